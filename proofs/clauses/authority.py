"""Torque authority: which twists the drives can ask for.

Twist tracking sets every rim speed to ``u_i = d_i . v(p_i)`` of the wanted motion.  A wanted twist that all roll rows
``[d_i, d_i . J p_i]`` map to zero asks nothing of any wheel: the array cannot drive it, it can only brake.  So the
rank of the roll rows at the equilibrium decides: 3 is full authority; rims that all point at the equilibrium have
rank 2, and the missing twist is the rotation about it.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.symbolic.constraints import Triple, complement, independent, inner
from nonsmooth.symbolic.scene import Scene, Wheel, dot, turned


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
        """Re-verify that the rows are the wheels', that no roll row sees a missing twist, and the rank."""
        every = [_roll_normal(wheel) for wheel in scene.recentred().wheels]
        unseen = all(not inner(row, twist) for row in every for twist in self.missing)
        full = self.rank + len(self.missing) == 3 and len(independent(self.missing)) == len(self.missing)
        return unseen and full and self == roll_authority(scene)


def roll_authority(scene: Scene) -> Authority:
    """Exact rank of the roll rows about the checked equilibrium."""
    wheels = scene.recentred().wheels
    rows = [_roll_normal(wheel) for wheel in wheels]
    basis = independent(rows)
    chosen = tuple(rows[k] for k in basis)
    return Authority(len(basis), tuple(wheels[k].index for k in basis), chosen, complement(chosen))


def _roll_normal(wheel: Wheel) -> Triple:
    """Left side of the roll row; its right side would take a square root per wheel, and is not needed."""
    return *wheel.direction, dot(wheel.direction, turned(wheel.position))
