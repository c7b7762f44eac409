"""Torque authority: which twists the drives can ask for.

Twist tracking sets every rim speed to ``u_i = d_i . v(p_i)`` of the wanted motion.  A wanted twist that all roll rows
``[d_i, d_i . J p_i]`` map to zero asks nothing of any wheel: the array cannot drive it, it can only brake.  So the
rank of the roll rows at the equilibrium decides: 3 is full authority; rims that all point at the equilibrium have
rank 2, and the missing twist is the rotation about it.  The drive of a wheel whose friction axis is not its rim pushes
along that axis, or across it where it runs at right angles to it; without friction there it pushes nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from nonsmooth.symbolic.constraints import Triple, complement, cross_product, independent, inner
from nonsmooth.symbolic.plane import Vector, dot, minus, turned
from nonsmooth.symbolic.scene import Scene, Wheel


@dataclass(frozen=True)
class Authority:
    """Rank of the roll rows with a basis of the row space and of the missing twists.

    Attributes:
        rank: 1, 2 or 3.
        basis: numbers of wheels with independent roll rows.
        rows: their rows, scaled by ``|D_i|``.
        missing: independent twists ``(vx, vy, omega)`` that no roll row sees; ``3 - rank`` of them.
    """

    rank: int
    basis: tuple[int, ...]
    rows: tuple[Triple, ...]
    missing: tuple[Triple, ...]

    def check(self, scene: Scene) -> bool:
        """Verify the rows from the wheels, the rank by minors from below and by the missing twists from above."""
        wheels = {wheel.index: wheel for wheel in scene.wheels}
        chosen = [wheels[k] for k in self.basis if k in wheels]
        sound = all(map(_drives, chosen))
        own = (
            sound
            and len(chosen) == len(self.basis)
            and self.rows == tuple(_moment_row(scene, wheel) for wheel in chosen)
        )
        driven = [wheel for wheel in scene.wheels if _drives(wheel)]
        unseen = not any(inner(_moment_row(scene, wheel), twist) for wheel in driven for twist in self.missing)
        sizes = self.rank == len(self.rows) == 3 - len(self.missing)
        return own and unseen and sizes and _has_minor(self.rows) and _has_minor(self.missing)


def roll_authority(scene: Scene) -> Authority:
    """Exact rank of the roll rows about the checked equilibrium."""
    driven = [wheel for wheel in scene.wheels if _drives(wheel)]
    basis = independent(_roll_normals(scene, driven))
    wheels = tuple(driven[k] for k in basis)
    chosen = tuple(_roll_normals(scene, wheels))
    return Authority(len(basis), tuple(wheel.index for wheel in wheels), chosen, complement(chosen))


def _moment_row(scene: Scene, wheel: Wheel) -> Triple:
    """The roll row as direction and moment of the rim's line about the checked point."""
    (x, y), (dx, dy) = minus(wheel.position, scene.check.equilibrium), _pushing(wheel)
    return dx, dy, x * dy - y * dx


def _pushing(wheel: Wheel) -> Vector:
    """The direction in which the drive pushes: that of the roll row, or of the side row where that has no input."""
    return wheel.grip if wheel.gains[0] else wheel.direction


def _drives(wheel: Wheel) -> bool:
    """Whether the drive pushes at all."""
    return wheel.axis is None or bool(wheel.gains[0]) or bool(wheel.friction.side)


def _has_minor(vectors: Sequence[Triple]) -> bool:
    """Whether some minor of full size does not vanish."""
    if len(vectors) < 2:
        return all(map(any, vectors))
    if len(vectors) == 2:
        return any(cross_product(vectors[0], vectors[1]))
    return len(vectors) == 3 and bool(inner(cross_product(vectors[0], vectors[1]), vectors[2]))


def _roll_normals(scene: Scene, wheels: Iterable[Wheel]) -> Iterator[Triple]:
    """Left sides of the roll rows about the checked point; right sides would take a square root per wheel."""
    x, y = scene.check.equilibrium
    for wheel in wheels:
        arm, push = (wheel.position[0] - x, wheel.position[1] - y), _pushing(wheel)
        yield *push, dot(push, turned(arm))
