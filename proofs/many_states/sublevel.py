"""The largest sublevel set of V that is certified to lie inside the cube on which V falls.

If ``V >= c`` on the border of the cube, a solution that starts inside with ``V < c`` stays inside and reaches the
point.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.kernel.claims import Collected
from nonsmooth.proofs.kernel.squares import condition_of, find
from nonsmooth.proofs.many_states.examination import Examination
from nonsmooth.proofs.many_states.samples import values_at
from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.proofs.sums_of_squares.prove import Effort

POINTS = 4_000
SHARES = tuple(Fraction(k, 64) for k in (63, 60, 48, 32, 16, 4))  # of the least sampled value, tried in turn


@dataclass(frozen=True)
class SublevelSet:
    """Starts that stay in the cube and reach the point.

    Attributes:
        level: c, where ``V < c`` is certified.
        radius: half the side of the cube.
        proofs: the evidence that V is above c on the border, by the names of claims.
    """

    level: Fraction
    radius: Fraction
    proofs: dict[str, Any]
    refuted: None = None  # no larger level is refuted
    point: None = None
    falls: bool = True  # on all of the cube

    def __str__(self) -> str:
        return f"V < {self.level}"


def largest_sublevel(examination: Examination) -> SublevelSet | None:
    """A certified level near the least value on the border; None where none is proved."""
    if examination.is_homogeneous:
        return None
    sides = [condition_of(claim, claim.inequalities[0], ()) for claim in border_claims(examination, Fraction(0))]
    least = min(map(_least, sides), default=0.0)
    if not least > 0:
        return None
    for share in SHARES:
        level = _brief(least * float(share))
        found = {claim.name: find(claim, Effort.STRICT) for claim in border_claims(examination, level)}
        if None not in found.values():
            radius = examination.cells.radius
            proofs = {name: own.evidence for name, own in found.items() if own is not None}
            return SublevelSet(level, Fraction(int(radius.p), int(radius.q)), proofs)
    return None


def border_claims(examination: Examination, level: Fraction) -> list[Claim]:
    """``V > level`` on each side of the cube, cell by cell of V."""
    conditions = examination.conditions
    conditions.proofs = collected = Collected()
    conditions.show_border(level)
    return [replace(claim, strict=True, at_origin=True) for claim in collected.claims]


def _least(condition: Condition) -> float:
    """The least value at many points of one side."""
    points = np.random.default_rng(0).uniform(-1, 1, (POINTS, condition.variables))
    for _ in range(4):
        inside = np.ones(len(points), dtype=bool)
        for guard in condition.guards:
            inside &= values_at(guard, points) >= 0
        if not inside.any():
            return float("inf")
        points = points[inside]
        values = values_at(condition.constant, points)
        best = points[np.argsort(values)[: POINTS // 40]]
        spread = np.random.default_rng(1).normal(scale=1 / 16, size=(40, *best.shape))
        points = np.clip((best + spread).reshape(-1, condition.variables), -1, 1)
        points = np.vstack([best, points])
    return float(values.min())


def _brief(value: float) -> Fraction:
    """A short fraction below a number."""
    power = 1
    while value * power < 32:
        power *= 2
    return Fraction(int(value * power), power)
