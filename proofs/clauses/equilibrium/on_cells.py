"""Clause 1: ``0 in F(c*)``, by convex weights, or refuted by a direction in which every velocity points.

At the equilibrium (the origin of the centred scene) the pose rate of a twist is its velocity v, so the question
is whether the origin lies in the convex hull of finitely many plane vectors: an exact linear program.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.inequalities.linear_program import best_mixture
from nonsmooth.proofs.verdicts import Equilibrium
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.formulas import brief_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector, dot, separating_direction


@dataclass(frozen=True)
class EquilibriumResult:
    """Verdict with its evidence.

    Attributes:
        verdict: holds or fails.
        twists: the twists whose velocities span F at the point.
        weights: convex weights of the twists that give zero velocity (holds).
        separator: a direction with positive product against every velocity (fails).
    """

    verdict: Equilibrium
    twists: tuple[Twist, ...]
    weights: dict[int, Number]
    separator: Vector | None

    def check(self) -> bool:
        """Re-verify the evidence from the definition."""
        if self.verdict is Equilibrium.HOLDS:
            total = sum(self.weights.values())
            x = sum(w * self.twists[k].vx for k, w in self.weights.items())
            y = sum(w * self.twists[k].vy for k, w in self.weights.items())
            return bool(total == 1 and x == 0 and y == 0 and all(w >= 0 for w in self.weights.values()))
        if self.separator is None or not self.twists:
            return False
        return all(dot(self.separator, t.velocity).sign() > 0 for t in self.twists)

    @property
    def reason(self) -> str:
        """One sentence for people."""
        if self.verdict is Equilibrium.HOLDS:
            return (
                f"0 is a convex combination of {len(self.weights)} of the {len(self.twists)} velocities that meet there"
            )
        if len(self.twists) == 1:
            twist = self.twists[0]
            return (
                f"around it one constant twist drives the body: ({', '.join(brief_text(entry) for entry in twist)}) "
                f"~ ({float(twist.vx):.5g}, {float(twist.vy):.5g}, {float(twist.omega):.5g})"
            )
        x, y = (float(s) for s in self.separator or ())
        return f"all {len(self.twists)} velocities that meet there point into the half-plane along ({x:.5g}, {y:.5g})"


def decide_equilibrium(partition: Partition) -> EquilibriumResult:
    """Decide ``0 in F(0)`` for a centred partition."""
    zero, one = partition.scene.field.zero, partition.scene.field.one
    twists = filippov_twists(partition, (zero, zero))
    mixture = best_mixture([(t.vx, t.vy, one) for t in twists], (zero, zero, one), [zero] * len(twists))
    if mixture is not None:
        return EquilibriumResult(Equilibrium.HOLDS, twists, mixture.weights, None)
    return EquilibriumResult(Equilibrium.FAILS, twists, {}, separating_direction([t.velocity for t in twists]))
