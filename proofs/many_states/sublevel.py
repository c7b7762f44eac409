"""The largest sublevel set of V that is certified to lie inside the cube on which V falls.

If ``V >= c`` on the border of the cube, a solution that starts inside with ``V < c`` stays inside and reaches the
point.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np
from flint import fmpq

from nonsmooth.proofs.many_states.affine_faces import build_face, unit
from nonsmooth.proofs.many_states.conditions import ConditionSense
from nonsmooth.proofs.many_states.examination import Examination, Inequality
from nonsmooth.proofs.many_states.samples import values_at
from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.proofs.sums_of_squares.prove import Proved, prove_positive
from nonsmooth.symbolic.numbers.polynomial import add_terms

POINTS = 4_000
SHARES = tuple(Fraction(k, 64) for k in (63, 60, 48, 32, 16, 4))  # of the least sampled value, tried in turn


@dataclass(frozen=True)
class SublevelSet:
    """Starts that stay in the cube and reach the point.

    Attributes:
        level: c, where ``V < c`` is certified.
        radius: half the side of the cube.
        evidence: for each part of its border, that V is above c there.
    """

    level: Fraction
    radius: Fraction
    evidence: tuple[Proved, ...]

    def check(self, examination: Examination) -> bool:
        """Verify the level on the border anew."""
        asked = list(at_border(examination, self.level))
        own = len(asked) == len(self.evidence) and self.radius == _fraction(examination.cells.radius)
        return own and all(
            proved.claim.strict and proved.proves_condition(condition)
            for proved, condition in zip(self.evidence, asked, strict=True)
        )


def largest_sublevel(examination: Examination) -> SublevelSet | None:
    """A certified level near the least value on the border; None where none is proved."""
    if examination.is_homogeneous:
        return None
    least = min((_least(condition) for condition in at_border(examination, Fraction(0))), default=0.0)
    if not least > 0:
        return None
    for share in SHARES:
        level = _brief(least * float(share))
        evidence = _proofs(examination, level)
        if evidence is not None:
            return SublevelSet(level, _fraction(examination.cells.radius), evidence)
    return None


def _proofs(examination: Examination, level: Fraction) -> tuple[Proved, ...] | None:
    found = []
    for condition in at_border(examination, level):
        proved = prove_positive(condition)
        if proved is None:
            return None
        found.append(proved)
    return tuple(found)


def at_border(examination: Examination, level: Fraction) -> Iterator[Condition]:
    """``V - level`` on each side of the cube, cell by cell of V, in the displacement divided by its half-width."""
    for _, _, _, condition in named_border(examination, level):
        yield condition


def named_border(examination: Examination, level: Fraction) -> Iterator[tuple[Inequality, int, int, Condition]]:
    """The same, each with the inequality about V on the cell, the number of the state and its sign."""
    count = len(examination.cells.states)
    zero = (0,) * count
    for inequality in examination.inequalities:
        if inequality.question.sense is not ConditionSense.POSITIVE:
            continue
        whole = inequality.question.condition
        for k, side in product(range(count), (1, -1)):
            face = build_face([{unit(count, k): fmpq(1), zero: fmpq(-side)}], count)
            if face is None:
                continue
            guards = [face.restricted(guard) for guard in whole.guards]
            if any(not any(map(sum, g)) and g and next(iter(g.values())) < 0 for g in guards):
                continue
            above = add_terms(dict(whole.constant), {zero: -fmpq(level.numerator, level.denominator)})
            bounds = tuple(form for form in face.coordinates if any(map(sum, form)))
            kept = tuple(g for g in guards if any(map(sum, g)))
            condition = Condition(face.restricted(above), {}, kept, bounds, face.dimension, at_origin=True)
            yield inequality, k, side, condition


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


def _fraction(value: fmpq) -> Fraction:
    return Fraction(int(value.p), int(value.q))
