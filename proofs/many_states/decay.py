"""How fast a proved V falls: ``V' <= -kappa`` or ``V' <= -kappa V``, by the sums of squares that show that it falls.

Each inequality ``p > 0`` about ``-V'`` is asked again for ``p - kappa`` or ``p - kappa V``, on faces with the same
functions mu.  Floats propose kappa.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from flint import fmpq

from nonsmooth.proofs.many_states.conditions import ConditionSense, ScaledInequality
from nonsmooth.proofs.many_states.examination import Examination, Inequality, with_values
from nonsmooth.proofs.many_states.samples import values_at
from nonsmooth.proofs.many_states.sign_cells import RationalTerms
from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.proofs.sums_of_squares.prove import Effort, Proved, prove_positive
from nonsmooth.proofs.systems.decay_rate import DENOMINATOR, SHARES, DecayKind
from nonsmooth.symbolic.numbers.polynomial import add_terms

POINTS = 4_000


@dataclass(frozen=True)
class ProvedDecay:
    """A proved rate.

    Attributes:
        decay: its kind.
        kappa: the rate.
        evidence: one proof for each inequality about V'.
    """

    decay: DecayKind
    kappa: Fraction
    evidence: tuple[Proved, ...]

    def __str__(self) -> str:
        return self.decay.value.format(self.kappa)

    def scales(self, examination: Examination) -> bool:
        """Whether the rate on the cube is one on the whole space: V and V' are forms, of the degrees of the rate.

        ``V' <= -kappa V`` scales where V' has the degree of V, ``V' <= -kappa`` where it has degree 0.
        """
        if not examination.is_homogeneous:
            return False
        for inequality in falling(examination):
            falls = with_values(inequality.question.condition, inequality.mu).constant
            degrees = {sum(e) for own in (falls, _target(self.decay, inequality.question)) for e, c in own.items() if c}
            if len(degrees) != 1:
                return False
        return True

    def check(self, examination: Examination) -> bool:
        """Verify every inequality again."""
        asked = list(rate_conditions(examination, self.decay, self.kappa))
        return (
            self.kappa > 0
            and len(asked) == len(self.evidence)
            and all(p.claim.strict and p.proves_condition(c) for p, c in zip(self.evidence, asked, strict=True))
        )


def decay_rate(examination: Examination) -> ProvedDecay | None:
    """A rate of a V that is proved to fall; None where none is proved."""
    for decay in DecayKind:
        most = min((_ratio(examination, decay, i) for i in falling(examination)), default=0.0)
        for share in SHARES if np.isfinite(most) else ():
            kappa = Fraction(int(most * float(share) * DENOMINATOR), DENOMINATOR)
            evidence = _proofs(examination, decay, kappa) if kappa else None
            if evidence is not None:
                return ProvedDecay(decay, kappa, evidence)
    return None


def _proofs(examination: Examination, decay: DecayKind, kappa: Fraction) -> tuple[Proved, ...] | None:
    found = []
    for condition in rate_conditions(examination, decay, kappa):
        proved = prove_positive(condition, Effort.HASTY)
        if proved is None:
            return None
        found.append(proved)
    return tuple(found)


def falling(examination: Examination) -> Iterator[Inequality]:
    """The inequalities about V'."""
    return (i for i in examination.inequalities if i.question.sense is ConditionSense.FALLS)


def rate_conditions(examination: Examination, decay: DecayKind, kappa: Fraction) -> Iterator[Condition]:
    """The inequalities about V' with kappa, in their order.

    They are in the displacement divided by the half-width of the cube, which multiplies V'.
    """
    factor = fmpq(kappa.numerator, kappa.denominator) * examination.cells.radius
    for inequality in falling(examination):
        whole = with_values(inequality.question.condition, inequality.mu)
        least = {e: -c * factor for e, c in _target(decay, inequality.question).items()}
        finite = decay is DecayKind.FINITE
        yield replace(whole, constant=add_terms(whole.constant, least), at_origin=finite or whole.at_origin)


def _target(decay: DecayKind, question: ScaledInequality) -> RationalTerms:
    """What kappa multiplies: 1 or V, on the cell or face of a question."""
    if decay is DecayKind.FINITE:
        return {(0,) * question.condition.variables: fmpq(1)}
    return dict(question.functions[0])


def _ratio(examination: Examination, decay: DecayKind, inequality: Inequality) -> float:
    """The least value of -V' over 1 or V at many points."""
    condition = with_values(inequality.question.condition, inequality.mu)
    if not condition.variables:
        return float("inf")
    rng = np.random.default_rng(0)
    points = rng.uniform(-1, 1, (POINTS, condition.variables)) * 0.5 ** rng.integers(0, 12, (POINTS, 1))
    inside = np.ones(POINTS, dtype=bool)
    for guard in condition.guards:
        inside &= values_at(guard, points) >= 0
    for form in condition.bounds:
        inside &= np.abs(values_at(form, points)) <= 1
    points = points[inside]
    if not len(points):
        return float("inf")
    below = values_at(_target(decay, inequality.question), points) * float(examination.cells.radius)
    return float(np.min(values_at(condition.constant, points) / below))
