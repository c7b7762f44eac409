"""How far and how fast a V reaches that is proved to fall on a cube in many states.

*Region*: if ``V >= c`` on the border of the cube, a solution that starts inside with ``V < c`` stays inside and reaches
the point.

*Gain*: ``V' <= -kappa V + gamma |d|`` along ``x' in F(x) + d`` where ``|grad V| <= gamma`` on the cube.

*Rate*: ``V' <= -kappa V^q`` with q = 0, 1 or 2, by the sums of squares that show that V falls: each claim ``p > 0``
about ``-V'`` is asked again for ``p - kappa V^q``, on faces with the same functions mu.  Floats propose.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.checker.theorems import show_rate
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.inequalities.prover import Proof
from nonsmooth.proofs.kernel.claims import Collected
from nonsmooth.proofs.kernel.search import SQUARES, decide_claim
from nonsmooth.proofs.kernel.squares import Shown, condition_of, find, mu_shapes, with_values
from nonsmooth.proofs.kernel.written import terms_of
from nonsmooth.proofs.many_states.examination import Asked, ExaminedLyapunov, are_about_forms
from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.decay_rate import (
    GAIN_SHARES,
    DecayKind,
    DecayRate,
    DisturbanceGain,
    gain_above,
    rates_below,
    slowest_ratio,
)
from nonsmooth.proofs.systems.sublevel_region import SublevelRegion
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.polynomial import float_values

POINTS = 4_000
LEVEL_SHARES = tuple(Fraction(k, 64) for k in (63, 60, 48, 32, 16, 4))  # of the least sampled value, tried in turn


def largest_sublevel(function: ExaminedLyapunov) -> SublevelRegion | None:
    """A certified level near the least value on the border; None where none is proved."""
    sides = [condition_of(claim, claim.inequalities[0], ()) for claim in border_claims(function, Fraction(0))]
    least = min(map(_least, sides), default=0.0)
    if not least > 0:
        return None
    for share in LEVEL_SHARES:
        level = _brief(least * float(share))
        found = {claim.name: find(claim, Effort.STRICT) for claim in border_claims(function, level)}
        if None not in found.values():
            radius = function.cells.radius
            proofs = {name: own.evidence for name, own in found.items() if own is not None}
            return SublevelRegion(level, None, None, as_fraction(radius), True, proofs)
    return None


def border_claims(function: ExaminedLyapunov, level: Fraction) -> list[Claim]:
    """``V > level`` on each side of the cube, cell by cell of V."""
    conditions = function.conditions
    conditions.proofs = collected = Collected()
    conditions.show_border(level)
    return [replace(claim, strict=True, at_origin=True) for claim in collected.claims]


def _least(condition: Condition) -> float:
    """The least value at many points of one side."""
    points = np.random.default_rng(0).uniform(-1, 1, (POINTS, condition.variables))
    for _ in range(4):
        inside = np.ones(len(points), dtype=bool)
        for guard in condition.guards:
            inside &= float_values(guard, points) >= 0
        if not inside.any():
            return float("inf")
        points = points[inside]
        values = float_values(condition.constant, points)
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


def rate_scales(rate: DecayRate, function: ExaminedLyapunov) -> bool:
    """Whether a rate on the cube is one on the whole space: V and V' are forms, of the degrees of the rate.

    ``V' <= -kappa V^p`` scales where V' has p times the degree of V.
    """
    return function.is_homogeneous and are_about_forms(rate_claims(function, rate.decay, rate.kappa))


def decay_rate(function: ExaminedLyapunov) -> DecayRate | None:
    """A rate of a V that is proved to fall; None where none is proved."""
    falling = [own for own in function.asked if own.is_about_fall]
    for decay in DecayKind:
        unit = rate_claims(function, decay, Fraction(1))
        samples = [np.zeros((2, 0))]
        for own, claim in zip(falling, unit, strict=True):
            samples += _ratios(own, claim)
        for kappa in rates_below(slowest_ratio(*np.hstack(samples))):
            proofs = _proofs(function, falling, decay, kappa)
            if proofs is not None:
                return DecayRate(decay, kappa, proofs=proofs)
    return None


def rate_claims(function: ExaminedLyapunov, decay: DecayKind, kappa: Fraction) -> list[Claim]:
    """The claims about V' with kappa, in their order."""
    conditions = function.conditions
    conditions.proofs = collected = Collected()
    show_rate(conditions, {"kind": decay.name.lower(), "kappa": str(kappa)})
    return collected.claims


def disturbance_gain(
    function: ExaminedLyapunov, rate: DecayRate, region: SublevelRegion | None
) -> DisturbanceGain | None:
    """The gain of a V with a rate on the cube.

    None where none is proved, for an algebraic rate, and where V bends on surfaces that meet.

    Args:
        function: V.
        rate: proved on the cube.
        region: certified there; None without one.
    """
    if rate.decay is DecayKind.ALGEBRAIC:
        return None
    try:
        squares = [condition_of(own, own.inequalities[0], ()) for own in _gradient_claims(function, Fraction(0))]
    except RejectedError:
        return None
    needed = float(np.sqrt(max(-_least(own) for own in squares))) / float(function.radius)
    for share in GAIN_SHARES:
        gamma = gain_above(needed * float(share))
        found = {own.name: find(own, Effort.HASTY) for own in _gradient_claims(function, gamma)}
        if None not in found.values():
            proofs = {name: own.evidence for name, own in found.items() if own is not None}
            return DisturbanceGain(gamma, rate, None if region is None else region.level, proofs)
    return None


def _gradient_claims(function: ExaminedLyapunov, gamma: Fraction) -> list[Claim]:
    """``|grad V| <= gamma`` on all cells of the cube, in units of its half-width."""
    conditions = function.conditions
    conditions.proofs = collected = Collected()
    conditions.show_gradient(gamma * as_fraction(function.cells.radius))
    return collected.claims


def _proofs(
    function: ExaminedLyapunov, falling: list[Asked], decay: DecayKind, kappa: Fraction
) -> dict[str, Any] | None:
    """Evidence of all claims, strict; None where that of one is not found."""
    proofs = {}
    for own, claim in zip(falling, rate_claims(function, decay, kappa), strict=True):
        at_origin = decay is DecayKind.FINITE or claim.at_origin
        evidence = _evidence(replace(claim, strict=True, at_origin=at_origin), own.found)
        if evidence is None:
            return None
        proofs[claim.name] = evidence
    return proofs


def _evidence(claim: Claim, known: Shown | None) -> dict[str, Any] | None:
    """Of a claim with kappa, by the kind that showed the one without."""
    if known is None or known.mu is None:
        outcome = None if known is None else decide_claim(claim, but=SQUARES)
        return outcome.evidence if isinstance(outcome, Proof) else None
    if len(known.mu) != len(mu_shapes([claim])):  # of an algebraic rate, whose claims have a higher degree
        return None
    found = find(claim, Effort.HASTY, known.mu)
    return None if found is None else found.evidence


def _ratios(own: Asked, unit: Claim) -> Iterator[NDArray[np.float64]]:
    """The values of -V' over ``V^p`` at many points, and their distances, (2, n), for each inequality.

    Args:
        own: the claim that V falls; with functions mu, unless they are known in every part of a face only.
        unit: the same with ``kappa = 1``.
    """
    shapes = mu_shapes([own.claim])
    mu = () if own.found is None or own.found.mu is None else own.found.mu
    if len(mu) < len(shapes):
        return
    for inequality, other in zip(own.claim.inequalities, unit.inequalities, strict=True):
        if not own.claim.count:
            continue
        condition = with_values(condition_of(own.claim, inequality, shapes), dict(enumerate(mu)))
        rng = np.random.default_rng(0)
        points = rng.uniform(-1, 1, (POINTS, condition.variables)) * 0.5 ** rng.integers(0, 12, (POINTS, 1))
        inside = np.ones(POINTS, dtype=bool)
        for guard in condition.guards:
            inside &= float_values(guard, points) >= 0
        for form in condition.bounds:
            inside &= np.abs(float_values(form, points)) <= 1
        points = points[inside]
        if len(points):
            below = float_values(terms_of(inequality.value - other.value), points)
            yield np.array([float_values(condition.constant, points) / below, np.linalg.norm(points, axis=1)])
