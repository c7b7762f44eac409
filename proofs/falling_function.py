"""A V that falls on a cube, with what follows from it by further claims of theorem ``lyapunov``.

*Region*: ``V >= c`` on the border of the cube.  *Rate*: ``V' <= -kappa V^p``: each claim about ``-V'`` is asked again
with this shift.  *Gain*: ``|grad V| <= gamma``.  Floats propose the numbers, the checker's own claims are shown by
evidence of any kind.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache, partial
from typing import Any

import numpy as np
from flint import fmpq

from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim, Inequality
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.theorems import show_rate
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.prover import Proof
from nonsmooth.proofs.inequalities.subdivision import value_at
from nonsmooth.proofs.kernel.bases import functions_on
from nonsmooth.proofs.kernel.cells import BeyondReachError, StatedCells, rational, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import DeferredClaims, Functions, Search, decide_claim, directed_hypotheses
from nonsmooth.proofs.kernel.squares import Shown, condition_of, find, mu_shapes, with_values
from nonsmooth.proofs.kernel.subject import NoCertificateError, about, exact_text, formula_in_names, subjects_of
from nonsmooth.proofs.kernel.written import terms_of
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.domain import (
    GAIN_SHARES,
    SLACK,
    WIDTH,
    DecayKind,
    DecayRate,
    DisturbanceGain,
    Domain,
    RegionRate,
    SublevelRegion,
    gain_above,
    rates_below,
    simple_below,
    slowest_ratio,
)
from nonsmooth.proofs.systems.findings import ExaminedFunction
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats, row_norms
from nonsmooth.symbolic.numbers.polynomial import Exponents, float_values
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

# ---- where inequalities of a claim are least -----------------------------------------------------
#
# In floats: what samples propose for levels, rates and gains.
#
# Samples are random points of the cube, or points on rays, where the guards of an inequality hold; the search goes on
# closer and closer to the best of them.  Nothing here is proved.


RAYS, SHRINKING, DISTANCES = 25, 0.5625, 10  # of points at which ratios are looked at: rays for each orthant
GRID = {1: 3, 2: 13, 3: 5, 4: 3}  # points of a side of the cube that they pass, besides
POINTS, FEWER = 4_000, 500  # of the search for a least value; fewer of one variable
BEST, ROUNDS, SPREAD = 32, 7, 0.35


def kept(inequality: Inequality, points: Floats) -> Floats:
    """The points at which no guard is negative."""
    kept = np.ones(len(points), dtype=bool)
    for guard in inequality.guards.values():
        kept &= float_values(terms_of(guard), points) >= 0
    return points[kept]


@lru_cache
def points_near(count: int) -> Floats:
    """Points of the cube on rays, at distances that fall by a constant factor: terms of low degree decide near it."""
    side = np.linspace(-1, 1, GRID.get(count, 2))
    regular = np.stack(np.meshgrid(*[side] * count), axis=-1).reshape(-1, count)
    rays = np.vstack([np.random.default_rng(0).uniform(-1, 1, (RAYS << count, count)), regular])
    rays = rays[np.any(rays != 0, axis=1)]
    rays /= np.abs(rays).max(axis=1, keepdims=True)
    return np.vstack([rays * SHRINKING**k for k in range(DISTANCES)])


def least(inequality: Inequality) -> tuple[float, tuple[float, ...]]:
    """The least value that is met in a search by samples, and where; infinite where no point is kept."""
    value = inequality.value
    points = np.random.default_rng(0).uniform(-1, 1, (POINTS if value.count > 1 else FEWER, value.count))
    return least_near(inequality, kept(inequality, points), partial(float_values, terms_of(value)))


def least_near(
    inequality: Inequality, points: Floats, values_at: Callable[[Floats], Floats]
) -> tuple[float, tuple[float, ...]]:
    """The same of any values, at some points that are kept and closer and closer to the best of them."""
    source, best_so_far = np.random.default_rng(0), (float("inf"), ())
    for k in range(ROUNDS):
        if not len(points):
            break
        values = values_at(points)
        best = points[np.argsort(values)[:BEST]]
        best_so_far = float(values.min()), tuple(best[0])
        steps = source.normal(scale=SPREAD ** (k + 1), size=(BEST, *best.shape))
        points = kept(inequality, np.vstack([best, np.clip((best + steps).reshape(-1, best.shape[1]), -1, 1)]))
    return best_so_far


def ratios_at(value: Mapping[Exponents, Any], size: Mapping[Exponents, Any], points: Floats) -> Floats:
    """Of two polynomials; infinite where the second one is not positive."""
    sizes = float_values(size, points)
    with np.errstate(all="ignore"):
        ratios = float_values(value, points) / sizes
    return np.where(np.isfinite(ratios) & (sizes > 0), ratios, np.inf)


# ---- claims about a falling V --------------------------------------------------------------------


WORK = 4_000  # coefficients looked at for one claim, beside sums of squares
WORK_ALONE = 20_000  # where there are none, in numbers with roots
LEVEL_SHARES = tuple(Fraction(k, 4096) for k in (4095, 4092, 4080, 4032, 3840, 3072, 2048, 1024, 256))  # of the least
FINE = ((1 << 14, 0.0), (1 << 30, 2.0**-16))  # denominators of a point that refutes a level; moved outward by a share
REGION_SHARES = (Fraction(1), Fraction(1, 2))  # of the level of a region, for its rate


@dataclass
class FallingFunction:
    """A V that falls on a cube, whose further claims are shown.

    Attributes:
        radius: half the side of the cube.
        conditions: from which they are derived.
        known: evidence that it falls, by the names of claims: functions mu serve for rates, too.
    """

    radius: Number
    conditions: Functions
    known: Mapping[str, Shown] = field(default_factory=dict)

    def largest_sublevel(self, *, falls: bool = True) -> SublevelRegion | None:
        """A certified level near the least value on the border of the cube; None where none is proved.

        Args:
            falls: whether V is proved to fall on all of the cube; otherwise that is asked below the level, which then
                is less than V at all points where it does not fall.
        """
        sought = self._on_border() if falls else [*self._on_border(), *self._where_it_rises()]
        minima = [(least(inequality), inequality, side) for inequality, side in sought]
        (value, place), inequality, side = min(minima, key=lambda entry: entry[0][0])
        if not 0 < value < np.inf:
            return None
        shares = (*([1 + SLACK] if side else []), *LEVEL_SHARES)
        levels = [simple_below(Fraction(value) * share) for share in shares]
        shown = first_shown(levels, lambda level: self._level_proofs(level, falls=falls))
        if shown is None:
            return None
        return SublevelRegion(shown[0], *self._refuted(inequality, place, side), self.radius, falls, shown[1])

    def _level_proofs(self, level: Fraction, *, falls: bool) -> Record | None:
        if not falls:
            self.conditions.require_below(level)
        return self._proofs([*([] if falls else self.conditions.claims()), *self._claims(Functions.show_border, level)])

    def first_rise(self) -> tuple[float, Floats]:
        """The least value of V where it does not fall, as floats see it, and where, in the displacement."""
        value, place = min((least(inequality) for inequality, _ in self._where_it_rises()), key=lambda entry: entry[0])
        return value, np.array(place) * float(self.radius)

    def _on_border(self) -> list[tuple[Inequality, str]]:
        """V on each side of the cube, cell by cell."""
        return [
            (claim.inequalities[0], claim.name.split()[-1])
            for claim in self._claims(Functions.show_border, Fraction(0))
        ]

    def _where_it_rises(self) -> list[tuple[Inequality, str]]:
        """V on the parts of cells where it does not fall."""
        speed = 1 / as_fraction(rational(self.radius))
        return [
            (Inequality(size.times(speed), {**inequality.guards, "rise": -inequality.value}), "")
            for claim, inequality, size in self._with_sizes(DecayKind.EXPONENTIAL)
            if not inequality.pushes
        ]

    def decay_rate(self, kinds: Iterable[DecayKind] = DecayKind) -> DecayRate | None:
        """A rate of the first kind that is proved; None where none is."""
        for decay in kinds:
            rates = list(dict.fromkeys(rates_below(self._slowest(decay))))
            shown = first_shown(rates, partial(self._rate_proofs, decay))
            if shown is not None:
                return DecayRate(decay, shown[0], Domain(self.radius), proofs=shown[1])
        return None

    def _rate_proofs(self, decay: DecayKind, kappa: Fraction) -> Record | None:
        return self._proofs(self.rate_claims(decay, kappa))

    def region_rate(self, region: SublevelRegion) -> RegionRate | None:
        """A rate on a region of the cube, or where V is below half its level; None where none is proved.

        The level may be that at which V' first vanishes, where no rate is positive.  That comes first which bears the
        larger disturbances, the product of rate and level.
        """
        levels = [region.level * share for share in REGION_SHARES]
        borne = {}
        for level in levels:
            self.conditions.require_below(level)
            borne[level] = self._slowest(DecayKind.EXPONENTIAL) * level
        for level in sorted(levels, key=borne.__getitem__, reverse=True):
            self.conditions.require_below(level)
            rate = self.decay_rate([DecayKind.EXPONENTIAL])
            if rate is not None:
                return RegionRate(rate.kappa, level, region.radius)
        return None

    def rate_claims(self, decay: DecayKind, kappa: Fraction) -> list[Claim]:
        """The claims about V' with kappa."""
        return self._claims(show_rate, {"kind": decay.name.lower(), "kappa": str(kappa)})

    def disturbance_gain(self, rate: DecayRate, region: SublevelRegion | None) -> DisturbanceGain | None:
        """The gain of a V with a rate on the cube.

        None where none is proved, for an algebraic rate, and where V bends on surfaces that meet.

        Args:
            rate: proved on the cube.
            region: certified there; None without one.
        """
        if rate.decay is DecayKind.ALGEBRAIC:
            return None
        try:
            squares = self._claims(Functions.show_gradient, Fraction(0))
        except RejectedError:
            return None
        radius = as_fraction(rational(self.radius))
        needed = math.sqrt(max(-least(claim.inequalities[0])[0] for claim in squares)) / radius
        if not math.isfinite(needed):
            return None
        gains = [gain_above(needed * float(share)) for share in GAIN_SHARES]
        shown = first_shown(gains, lambda gamma: self._proofs(self._claims(Functions.show_gradient, gamma * radius)))
        if shown is None:
            return None
        return DisturbanceGain(shown[0], rate, Domain(self.radius), None if region is None else region.level, shown[1])

    @property
    def degree(self) -> int:
        """That of V'."""
        return max(inequality.value.degree for _, inequality, _ in self._with_sizes(DecayKind.EXPONENTIAL))

    # ---- claims ----------------------------------------------------------------------------------

    def _claims(self, ask: Callable[..., None], *values: Any) -> list[Claim]:
        self.conditions.proofs = collected = DeferredClaims()
        ask(self.conditions, *values)
        return collected.claims

    def _proofs(self, claims: Iterable[Claim]) -> Record | None:
        """Evidence of all claims by their names; None where that of one is not found."""
        evidence_by_name = {}
        for claim in claims:
            evidence = self._evidence(claim)
            if evidence is None:
                return None
            evidence_by_name[claim.name] = evidence
        return evidence_by_name

    def _evidence(self, claim: Claim) -> Record | None:
        """Of a claim, with the functions mu that are known of the one without a rate."""
        known = self.known.get(claim.name.removeprefix("rate "))
        if known is None or known.mu is None or not any(inequality.value for inequality in claim.inequalities):
            outcome = decide_claim(claim, WORK if claim.field is None else WORK_ALONE)
            return outcome.evidence if isinstance(outcome, Proof) else None
        if len(known.mu) != len(mu_shapes([claim])):  # of an algebraic rate, whose claims have a higher degree
            return None
        at_origin = claim.at_origin or any(inequality.value.at_origin for inequality in claim.inequalities)
        shown = find(replace(claim, strict=True, at_origin=at_origin), Effort.HASTY, known.mu)
        return None if shown is None else shown.evidence

    # ---- floats ----------------------------------------------------------------------------------

    def _with_sizes(self, decay: DecayKind) -> Iterator[tuple[Claim, Inequality, Polynomial]]:
        """The inequalities about ``-V'`` with ``V^p``, times the half-width."""
        conditions = self.conditions
        falls = self._claims(partial(Functions.show_falls, prefix="rate ", shift=conditions.zero, strict=False))
        for claim, shifted in zip(falls, self.rate_claims(decay, Fraction(1)), strict=True):
            for inequality, other in zip(claim.inequalities, shifted.inequalities, strict=True):
                yield claim, inequality, inequality.value - other.value

    def _slowest(self, decay: DecayKind) -> Fraction:
        """The largest rate that many points allow; faces count where mu is known."""
        samples, searched = [np.zeros((2, 0))], []
        for claim, inequality, size in self._with_sizes(decay):
            known, shapes = self.known.get(claim.name.removeprefix("rate ")), mu_shapes([claim])
            mu = () if known is None or known.mu is None else known.mu
            if claim.count and len(mu) >= len(shapes):
                value = with_values(condition_of(claim, inequality, shapes), dict(enumerate(mu))).constant
                points, ratio = kept(inequality, points_near(claim.count)), partial(ratios_at, value, terms_of(size))
                ratios = ratio(points)
                samples.append(np.array([ratios, row_norms(points)])[:, np.isfinite(ratios)])
                searched.append((float(ratios.min(initial=np.inf)), inequality, points, ratio))
        bound = slowest_ratio(*np.hstack(samples))
        if not bound:
            return bound
        _, slowest, points, ratio = min(searched, key=lambda entry: entry[0])
        return Fraction(max(least_near(slowest, points, ratio)[0], 0))

    def _refuted(self, inequality: Inequality, place: Sequence[float], side: str) -> tuple[Fraction | None, Any]:
        """A level that a point refutes, and this point; None where floats miss the cell.

        Args:
            inequality: V on a part of the cube.
            place: there.
            side: of the cube on whose border the part lies, as claims name it; empty where it does not.
        """
        for denominator, outward in FINE:
            exact = [fmpq(round(x * (1 + outward) * denominator), denominator) for x in place]
            if all(sign(value_at(terms_of(guard), exact)) >= 0 for guard in inequality.guards.values()):
                value = Fraction(float(value_at(terms_of(inequality.value), exact)))
                if side:
                    exact.insert(int(side[1:]), fmpq(1 if side[0] == "+" else -1))
                return simple_below(value * (1 + 2 * WIDTH)), tuple(self.radius * x for x in exact)
        return None, None


def claims_about(
    system: SwitchedSystem, function: ExaminedFunction | PiecewiseExpression, radius: Number
) -> FallingFunction | None:
    """The same of a V of which nothing is known; a cube with an irrational half-width is a little smaller."""
    half = Domain(radius).rational.radius or radius
    for subject in subjects_of(system):
        try:
            stated, cells = stated_function(subject, half, function)
            return FallingFunction(half, functions_on(subject, cells, [stated]))
        except (NoCertificateError, BeyondReachError):
            continue
    return None


def first_shown(
    numbers: Sequence[Fraction], prove: Callable[[Fraction], Record | None]
) -> tuple[Fraction, Record] | None:
    """The first number that is proved, with its evidence, of some that ask for less and less; None where none is.

    A proof that is not found takes the most time: after the first number the last one is tried, then those between.
    """
    proved, low, high = None, -1, len(numbers)  # what is not proved, and what is
    k = 0
    while low + 1 < high:
        proofs = prove(numbers[k])
        if proofs is not None:
            proved, high = (numbers[k], proofs), k
        elif k == len(numbers) - 1:
            return None
        else:
            low = k
        k = (low + high) // 2 if proved else len(numbers) - 1
    return proved


# ---- a V as hypotheses of a certificate ----------------------------------------------------------
#
# Its formulas, and the cells of the system and of V.


def stated_function(
    system: SwitchedSystem, radius: Number | None, function: ExaminedFunction | PiecewiseExpression
) -> tuple[str, StatedCells]:
    """V as a certificate states it, and the cells of the system and of V.

    Args:
        system: in any number of states.
        radius: half the side of the cube; None for the whole space.
        function: V.
    """
    if radius is not None:
        exact_text(radius)
    formula = parse_piecewise(function.text, system.states)
    return formula_in_names(formula, system), stated_cells(
        system, radius, surfaces_of(system, formula), irrational=True
    )


def growth_hypotheses(system: SwitchedSystem, function: ExaminedFunction) -> Record:
    """Of theorem ``instability``, by a V that grows: where it does on all of the plane a square is enough, and bounded.

    Raises:
        NoCertificateError: where V cannot be written.
        NotShownError: where no direction leads into a cell.
    """
    stated, cells = stated_function(system, function.domain.radius or system.check.radius, function)
    return directed_hypotheses(read_subject(about(system)), cells.record, f"-({stated})", Search())
