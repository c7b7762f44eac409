"""Torque authority: which twists the drives can ask for.

Twist tracking sets every rim speed to ``u_i = d_i . v(p_i)`` of the wanted motion.  A wanted twist that all roll rows
``[d_i, d_i . J p_i]`` map to zero asks nothing of any wheel: the array cannot drive it, it can only brake.  So the
rank of the roll rows at the equilibrium decides: 3 is full authority; rims that all point at the equilibrium have
rank 2, and the missing twist is the rotation about it.  The drive of a wheel whose friction axis is not its rim pushes
along that axis, or across it where it runs at right angles to it; without friction there it pushes nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from nonsmooth.symbolic.mechanics.contact_states import Triple, complement, independent
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.numbers.plane import Vector, dot, turned


class Authority(NamedTuple):
    """Rank of the roll rows with wheels of a basis, and the missing twists.

    Attributes:
        rank: 1, 2 or 3.
        basis: numbers of wheels with independent roll rows.
        missing: independent twists ``(vx, vy, omega)`` that no roll row sees; ``3 - rank`` of them.
    """

    rank: int
    basis: tuple[int, ...]
    missing: tuple[Triple, ...]


def roll_authority(scene: Scene) -> Authority:
    """Exact rank of the roll rows about the checked equilibrium."""
    driven = [wheel for wheel in scene.wheels if _drives(wheel)]
    basis = independent(_roll_normals(scene, driven))
    chosen = [driven[k] for k in basis]
    missing = complement(tuple(_roll_normals(scene, chosen)))
    return Authority(len(basis), tuple(wheel.index for wheel in chosen), missing)


def _pushing(wheel: Wheel) -> Vector:
    """The direction in which the drive pushes: that of the roll row, or of the side row where that has no input."""
    return wheel.grip if wheel.gains[0] else wheel.direction


def _drives(wheel: Wheel) -> bool:
    """Whether the drive pushes at all."""
    return wheel.axis is None or bool(wheel.gains[0]) or bool(wheel.friction.side)


def _roll_normals(scene: Scene, wheels: Iterable[Wheel]) -> Iterator[Triple]:
    """Left sides of the roll rows about the checked point; right sides would take a square root per wheel."""
    x, y = scene.check.equilibrium
    for wheel in wheels:
        arm, push = (wheel.position[0] - x, wheel.position[1] - y), _pushing(wheel)
        yield *push, dot(push, turned(arm))
