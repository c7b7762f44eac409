"""Clause 1: ``0 in F(c*)``, by convex weights, or refuted by a direction in which every velocity points.

At the equilibrium (the origin of the centred scene) the pose rate of a twist is its velocity v, so the question
is whether the origin lies in the convex hull of finitely many plane vectors: an exact linear program.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.findings.verdicts import Equilibrium
from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text, place_text
from nonsmooth.symbolic.numbers.plane import Vector, cross, dot, separating_direction
from nonsmooth.symbolic.numbers.rounded import certain_sign


@dataclass(frozen=True)
class EquilibriumResult:
    """Verdict with its evidence.

    Attributes:
        verdict: holds or fails; undecided where rounded numbers alone would say so.
        twists: the twists whose velocities span F at the point.
        weights: convex weights of the twists that give zero velocity (holds).
        separator: a direction with positive product against every velocity (fails).
        open: why it is undecided.
    """

    verdict: Equilibrium
    twists: tuple[Twist, ...]
    weights: dict[int, Number]
    separator: Vector | None
    open: str = ""

    @property
    def reason(self) -> str:
        """One sentence for people."""
        if self.open:
            return self.open
        if self.verdict is Equilibrium.HOLDS:
            return _at_rest(self.twists, len(self.weights))
        if len(self.twists) == 1:
            twist = self.twists[0]
            return (
                f"around it one constant twist drives the body: ({', '.join(brief_text(entry) for entry in twist)}) "
                f"~ {place_text(twist, 5)}"
            )
        along = place_text(self.separator or (), 5)
        return f"all {len(self.twists)} velocities that meet there point into the half-plane along {along}"


def _at_rest(twists: tuple[Twist, ...], mixed: int) -> str:
    """Which of the velocities that meet at the point give zero."""
    if mixed > 1:
        return f"0 is a convex combination of {mixed} of the {len(twists)} velocities that meet there"
    if len(twists) > 1:
        return f"one of the {len(twists)} velocities that meet there is zero"
    return "the body turns about the point" if twists[0].omega else "the body is at rest in the cell about the point"


def decide_equilibrium(partition: Partition) -> EquilibriumResult:
    """Decide ``0 in F(0)`` for a centred partition."""
    zero = partition.scene.field.zero
    twists = filippov_twists(partition, (zero, zero))
    velocities = [twist.velocity for twist in twists]
    before = zero.field.rounded_signs
    mixture = best_mixture(*mixtures_to_zero(velocities), [zero] * len(twists))
    certain = _certain_weights(velocities) if zero.field.rounded_signs > before else None
    if certain is not None:
        zero.field.rounded_signs = before
        return EquilibriumResult(Equilibrium.HOLDS, twists, certain, None)
    if mixture is not None:
        return EquilibriumResult(Equilibrium.HOLDS, twists, mixture.weights, None)
    separator = separating_direction(velocities)
    if separator is not None and zero.field.measured:
        for velocity in velocities:
            dot(separator, velocity).sign()  # counts where the rounded velocities alone point to one side
    return EquilibriumResult(Equilibrium.FAILS, twists, {}, separator)


def _certain_weights(velocities: Sequence[Vector]) -> dict[int, Number] | None:
    """Convex weights of the first three velocities whose triangle has zero inside, whatever rounding did to them."""
    for chosen in combinations(range(len(velocities)), 3):
        a, b, c = (velocities[k] for k in chosen)
        parts = cross(b, c), cross(c, a), cross(a, b)
        if abs(sum(certain_sign(part) for part in parts)) == len(parts):
            whole = parts[0] + parts[1] + parts[2]
            return {k: part / whole for k, part in zip(chosen, parts, strict=True)}
    return None
