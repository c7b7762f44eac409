"""Lyapunov's conditions for a nonsmooth V and a Filippov inclusion on a closed domain, each with exact evidence.

V is a polynomial on each cell (:mod:`nonsmooth.analysis.cells.switched_cells`); it is positive if it is on every
closed cell. Its derivative is decided part by part: on each *closed* cell ``grad V . f`` is an inequality between
polynomials (the hull on a surface holds the fields of both sides, so for smooth V nothing else is needed: Filippov
1988, sec. 15).  V bends where two pieces meet with different gradients: there the three sets of
:mod:`nonsmooth.proofs.inequalities.kinks` are decided along the whole edge and at its ends.  A V that jumps across an
edge is refuted; one that bends along a curve is proved to fall there
or undecided.  Then along every solution

- largest value of Bacciotti and Ceragioli's set <= 0 everywhere: V does not increase, the equilibrium is stable;
- < 0 everywhere but at the equilibrium: no solution stays where 0 is in the set, so it is asymptotically stable
  (invariance principle: Bacciotti and Ceragioli 1999, thm. 3).

Where 0 is in the set, :func:`attraction` asks LaSalle's principle whether a solution stays there.

On closed cells < 0 is demanded also on sides where V bends: more than the theorem asks, and never too little.  A corner
at which V bends twice and the set is positive refutes nothing by itself (no solution need stay there): undecided.

*Along a curve* on which V bends: let ``q = 0`` part the cells A (``q > 0``) and B, with one field each, and let q
divide ``V_A - V_B``: V is continuous, and ``grad V_A - grad V_B = h grad q`` on the curve.  With ``a = grad q . f_A``
and ``b = grad q . f_B`` a mixture of the fields has one value against all gradients where ``h = 0``, which the closed
cells decide, or where it is tangent:

- ``a b > 0``: no mixture is; ``a = 0``: f_A is, with ``grad V_A . f_A < 0`` on the closed cell; likewise f_B;
- ``a b < 0``: ``f_s = (b f_A - a f_B)/(b - a)`` alone, with the value ``w/(b - a)`` for
  ``w = b grad V_A . f_A - a grad V_A . f_B``.

So two inequalities decide: ``w < 0`` where ``q = 0, a <= 0 <= b``, and ``w > 0`` where ``q = 0, b <= 0 <= a``.  The
prover shows them on all points at which no guard is negative, thin sets included.  Where a further cell with another
field or another V meets the curve off the equilibrium nothing is claimed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from itertools import combinations
from operator import itemgetter
from typing import Any

from nonsmooth.analysis.cells.polygon import Point, clipped_by
from nonsmooth.analysis.cells.region import Region, affine, common_edges
from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell, distinct, gradients_at, velocities_at
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.curved_regions import ClosureMembership, closure_membership, is_empty
from nonsmooth.proofs.inequalities.forms import Question, Sense, build_parts
from nonsmooth.proofs.inequalities.kinks import Interval, Kink, Ladder, SupremumSign, SupremumSigns, ladder_at, worst
from nonsmooth.proofs.inequalities.prover import Counterexample, Outcome, Proof, Undecided, ZeroBetween, prove
from nonsmooth.proofs.inequalities.real_roots import RealRoot
from nonsmooth.proofs.inequalities.subdivision import effort_of_its_own, shared_effort
from nonsmooth.proofs.kernel.second_function import find_attraction
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.formulas.surfaces import divides, factorize
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import dot, hull_holds_zero
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, with_known_numbers

MEETING_WORK = 5_000  # coefficients looked at to find that a further cell does not meet the curve


@dataclass(frozen=True)
class CurvedKink:
    """Two cells on the two sides of a curve, with the same convex part of the plane around it.

    Attributes:
        first: the cell where the curve's polynomial is positive.
        second: the cell where it is negative.
        curve: the polynomial.
        around: the common part of the cells' regions, with the guards of both: the curve alone.
    """

    first: LyapunovCell
    second: LyapunovCell
    curve: Polynomial
    around: Region

    def falls(self, cells: Sequence[LyapunovCell]) -> bool:
        """Whether V is proved to be continuous and to fall along every solution on the curve but the equilibrium.

        Args:
            cells: all of them; on each closed one V is known to fall, or nothing follows.
        """
        if len(self.first.velocities) > 1 or len(self.second.velocities) > 1:
            return False
        continuous = divides(self.curve, self.first.potential - self.second.potential)
        return continuous is True and all(map(self._is_left_alone_by, cells)) and self._slides_down()

    def _is_left_alone_by(self, other: LyapunovCell) -> bool:
        """Whether a cell adds neither a field nor a gradient at any point of the curve but the equilibrium."""
        fields = (*self.first.velocities, *self.second.velocities)
        shares_potential = any(not other.potential - cell.potential for cell in (self.first, self.second))
        if shares_potential and all(velocity in fields for velocity in other.velocities):
            return True
        sides = tuple(_linear(side, self.curve) for side in other.region.sides)
        there = replace(self.around, guards=(*self.around.guards, *other.region.guards, *sides))
        return _is_seen_empty(there, self.curve, MEETING_WORK)

    def _slides_down(self) -> bool:
        (f,), (g,) = self.first.velocities, self.second.velocities
        if f == g:
            return True
        slope = self.curve.derivative("x"), self.curve.derivative("y")
        gradient = self.first.gradient
        a, b = dot(slope, f), dot(slope, g)
        value = b * dot(gradient, f) - a * dot(gradient, g)
        for sense, opposed in ((Sense.NEGATIVE, (-a, b)), (Sense.POSITIVE, (a, -b))):
            sliding = replace(self.around, guards=(*self.around.guards, *opposed))
            if not isinstance(prove(sense, value, sliding, except_origin=True), Proof):
                return False
        return True


def _linear(side: tuple[object, object, object], like: Polynomial) -> Polynomial:
    """``a x + b y + c``."""
    x, y = Polynomial.coordinates(like.field, like.variables)
    a, b, c = side
    return x * a + y * b + Polynomial.constant(like.field, like.variables, 1) * c


def _is_seen_empty(region: Region, like: Polynomial, work: int) -> bool:
    """Whether ``-1 > 0`` is found to hold where no guard of a region is negative: only the origin may be such a point.

    Args:
        region: a cell.
        like: a polynomial in the same variables.
        work: coefficients that may be looked at.
    """
    minus_one = Polynomial.constant(like.field, like.variables, -1)
    parts = build_parts(Question(Sense.POSITIVE, minus_one, region, except_origin=True))
    return all(part.subdivided(work) is None for part in parts)


BEND_EFFORT = 100_000  # for all edges on which V bends: a few seconds
RISES = "the derivative of V is positive"
RISES_ON_LINE = "V increases along a line on which it bends"


@dataclass(frozen=True)
class Refutation:
    """A point at which a condition fails, with the exact value there (None where it is known by its sign only)."""

    point: tuple[Any, ...]
    value: Any | None
    meaning: str

    @property
    def is_of_rates(self) -> bool:
        """Whether it speaks of V along the fields, not of V alone."""
        return self.meaning in (RISES, RISES_ON_LINE)


@dataclass(frozen=True)
class Stratum:
    """A part of the domain with the derivatives of V there.

    Attributes:
        sample: a point of it.
        ladder: the three derivatives at the sample.
        supremum_signs: what their maxima do on the whole part (on closed cells, except at the equilibrium).
        evidence: the inequality for each field of a cell; the edge; nothing for a corner.
        refutation: where the last derivative is positive, or V is not continuous.
        constant: whether the ladder at the sample holds on the whole part.
    """

    sample: Point
    ladder: Ladder
    supremum_signs: SupremumSigns
    evidence: tuple[Outcome, ...] | Kink | None
    refutation: Refutation | None
    constant: bool


# ---- cells ---------------------------------------------------------------------------------


def cell_stratum(cell: LyapunovCell) -> Stratum:
    """``grad V . f`` on the closed cell, for each field."""
    outcomes = tuple(_rate_outcome(rate, cell.region) for rate in cell.rates)
    supremum_signs = [supremum_sign_of(outcome) for outcome in outcomes]
    sample = cell.region.inner_point
    refuted = [
        o for o, supremum_sign in zip(outcomes, supremum_signs, strict=True) if supremum_sign is SupremumSign.POSITIVE
    ]
    refutation = None
    if refuted and isinstance(refuted[0], Counterexample):
        refutation = Refutation(refuted[0].point, refuted[0].value, RISES)
    rates = [rate(sample) for rate in cell.rates]
    interval = Interval(min(rates), max(rates))
    supremum_sign = worst(supremum_signs)
    constant = all(rate.constant_value is not None for rate in cell.rates)
    return Stratum(
        sample,
        Ladder(interval, interval, interval),
        SupremumSigns(supremum_sign, supremum_sign, supremum_sign),
        outcomes,
        refutation,
        constant,
    )


def _rate_outcome(rate: Polynomial, region: Region) -> Outcome:
    """``rate < 0`` except at the equilibrium, or else ``rate <= 0``, or a point where it is positive."""
    strict = prove(Sense.NEGATIVE, rate, region, except_origin=True)
    if isinstance(strict, Proof) or (isinstance(strict, Counterexample) and sign(strict.value) > 0):
        return strict
    return prove(Sense.NONPOSITIVE, rate, region)


def supremum_sign_of(outcome: Outcome) -> SupremumSign:
    """What an outcome of :func:`_rate_outcome` says of the derivative on its closed cell."""
    match outcome:
        case Proof():
            return SupremumSign.NEGATIVE if outcome.question.sense.strict else SupremumSign.NONPOSITIVE
        case Undecided():
            return SupremumSign.UNDECIDED
        case _:
            return SupremumSign.POSITIVE


# ---- edges and corners where V bends ---------------------------------------------------------


@effort_of_its_own(BEND_EFFORT)
def bend_strata(cells: Sequence[LyapunovCell]) -> tuple[Stratum, ...]:
    """Edges on which V bends or jumps, and their corners; undecided where these are too much work together."""
    return tuple(_bend_strata(cells))


def _bend_strata(cells: Sequence[LyapunovCell]) -> Iterator[Stratum]:
    corners: list[Point] = []
    for first, second in combinations(cells, 2):
        if not first.potential - second.potential:
            continue
        parting = _parting(first, second)
        common = _overlap(first, second) if parting else None
        if common is not None:
            yield _curved_stratum(cells, CurvedKink(first, second, parting[0], common))
        for edge in common_edges(first.region, second.region):
            kink = Kink(first, second, edge)
            if parting and all(any(kink.along(guard)) for guard in parting):
                continue  # on two sides of a curve that only crosses the edge: no point of it borders both
            if _is_left_by_a_guard(kink):
                continue
            if not kink.is_continuous:
                yield _jump_stratum(cells, kink)
            elif kink.bends:
                yield _open_stratum(cells, kink.point(kink.samples()[0])) if parting else _kink_stratum(cells, kink)
                corners += [affine(end) for end in edge if end[2] and any(end[:2])]
    for corner in distinct(corners):
        yield _corner_stratum(cells, corner)


def _parting(first: LyapunovCell, second: LyapunovCell) -> list[Polynomial]:
    """The guards of one cell whose opposites are guards of another: curves between them."""
    return [g for g in first.region.guards for h in second.region.guards if not g + h]


def _kink_stratum(cells: Sequence[LyapunovCell], kink: Kink) -> Stratum:
    try:
        supremum_signs, place = kink.supremum_signs()
    except WorkLimitError:
        return _open_stratum(cells, kink.point(Fraction(1)))
    guarded = bool(kink.first.region.guards or kink.second.region.guards)
    if guarded:  # not every point of the edge belongs to both cells: only the largest set is an upper bound
        bound = (
            supremum_signs.naive
            if supremum_signs.naive.rank <= SupremumSign.NONPOSITIVE.rank
            else SupremumSign.UNDECIDED
        )
        supremum_signs = SupremumSigns(bound, bound, bound)
    sample = kink.point(kink.samples()[0])
    refutation = None
    if supremum_signs.bacciotti_ceragioli is SupremumSign.POSITIVE:
        at = place.low if isinstance(place, RealRoot) else place
        refutation = Refutation(kink.point(at), None, RISES_ON_LINE)
        if not isinstance(place, RealRoot):
            derivative = derivatives_at(cells, kink.point(at)).bacciotti_ceragioli
            refutation = Refutation(kink.point(at), derivative.high if derivative else None, refutation.meaning)
    constant = all(
        rate.constant_value is not None
        for gradient in (kink.first.gradient, kink.second.gradient)
        for f, g in (*kink.first.velocities, *kink.second.velocities)
        for rate in [gradient[0] * f + gradient[1] * g]
    )
    return Stratum(sample, derivatives_at(cells, sample), supremum_signs, kink, refutation, constant)


def _jump_stratum(cells: Sequence[LyapunovCell], kink: Kink) -> Stratum:
    """Two values of V at one point of an edge; undecided where none is found that belongs to both cells."""
    difference = kink.first.potential - kink.second.potential
    guards = (*kink.first.region.guards, *kink.second.region.guards)
    points = (kink.point(kink.samples()[0] * k) for k in range(1, 10 + difference.degree))
    place = next((p for p in points if difference(p) and all(sign(guard(p)) > 0 for guard in guards)), None)
    if place is None:
        return _open_stratum(cells, kink.point(kink.samples()[0]))
    refutation = Refutation(place, difference(place), "V is not continuous")
    positive = SupremumSigns(SupremumSign.POSITIVE, SupremumSign.POSITIVE, SupremumSign.POSITIVE)
    return Stratum(place, derivatives_at(cells, place), positive, kink, refutation, constant=False)


def _corner_stratum(cells: Sequence[LyapunovCell], corner: Point) -> Stratum:
    ladder = derivatives_at(cells, corner)
    supremum_signs = SupremumSigns(
        *(SupremumSign.EMPTY if i is None else SupremumSign.of_sign(sign(i.high)) for i in ladder)
    )
    return Stratum(corner, ladder, supremum_signs, None, None, constant=True)


def _open_stratum(cells: Sequence[LyapunovCell], sample: Point) -> Stratum:
    """Two pieces of V beside a curve, or on an edge that is too much work."""
    undecided = SupremumSigns(SupremumSign.UNDECIDED, SupremumSign.UNDECIDED, SupremumSign.UNDECIDED)
    return Stratum(sample, derivatives_at(cells, sample), undecided, None, None, constant=False)


def _curved_stratum(cells: Sequence[LyapunovCell], kink: CurvedKink) -> Stratum:
    """Two pieces of V beside a curve; what is proved is about the last derivative alone."""
    stratum = _open_stratum(cells, kink.around.inner_point)
    if not kink.falls(cells):
        return stratum
    return replace(stratum, supremum_signs=stratum.supremum_signs._replace(bacciotti_ceragioli=SupremumSign.NEGATIVE))


def _overlap(first: LyapunovCell, second: LyapunovCell) -> Region | None:
    """The common part of the convex regions of two cells, with the guards of both; None where it has no area."""
    overlap = clipped_by(first.region, second.region.sides)
    more = tuple(guard for guard in second.region.guards if guard not in first.region.guards)
    return None if overlap is None else replace(overlap, guards=(*first.region.guards, *more))


def _is_left_by_a_guard(kink: Kink) -> bool:
    """Whether a guard of either cell is negative on the whole edge, but perhaps at the origin."""
    (x, y, _), (s, t, u) = kink.edge
    for guard in (*kink.first.region.guards, *kink.second.region.guards):
        along = kink.along(guard)
        inside = any(along) and all(sign(c) <= 0 for c in along)
        if inside and (along[0] or not (x or y)) and (along[-1] or not u or not (s or t)):
            return True
    return False


def derivatives_at(cells: Sequence[LyapunovCell], point: Point) -> Ladder:
    """The three derivatives of V at a point of the domain."""
    return ladder_at(velocities_at(cells, point), gradients_at(cells, point))


EFFORT = 150_000  # coefficients looked at for all inequalities of one V: a few seconds
EMPTINESS_WORK = 2_000  # coefficients looked at to find that a cell beside a curve is empty; kept otherwise


class Decrease(StrEnum):
    """What V does along every solution in the domain."""

    STRICT = "V is positive and decreases everywhere but at the equilibrium"
    WEAK = "V is positive and does not increase"
    REFUTED = "V is no Lyapunov function"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Supremum:
    """The largest value of one derivative over the domain without the equilibrium.

    Attributes:
        supremum_sign: its sign.
        value: the exact value where every part that matters has a constant one; None otherwise.
        point: a point of the part on which it is largest.
    """

    supremum_sign: SupremumSign
    value: Any | None
    point: Point | None


@dataclass(frozen=True, repr=False)
class LyapunovResult(ShortRepr):
    """Lyapunov's conditions on a domain, with the evidence of each.

    Attributes:
        cells: cover the domain; V and the fields are smooth on each.
        definite: ``V > 0`` on each closed cell, except at the equilibrium.
        strata: the derivatives, part by part.
        verdict: what follows.
        witness: where a condition fails.
        reason: one sentence for people.
    """

    cells: tuple[LyapunovCell, ...]
    definite: tuple[Outcome, ...]
    strata: tuple[Stratum, ...]
    verdict: Decrease
    witness: Refutation | None
    reason: str

    def supremum(self, name: str) -> Supremum:
        """Of ``naive``, ``shevitz_paden`` or ``bacciotti_ceragioli``, over the parts on which it is not empty."""
        parts = [s for s in self.strata if getattr(s.supremum_signs, name) is not SupremumSign.EMPTY]
        supremum_sign = worst([getattr(s.supremum_signs, name) for s in parts])
        sampled = [(getattr(s.ladder, name), s.sample) for s in parts]
        attained = [(interval.high, sample) for interval, sample in sampled if interval is not None]
        if not attained:
            return Supremum(supremum_sign, None, None)
        value, point = max(attained, key=itemgetter(0))
        return Supremum(supremum_sign, value if all(s.constant for s in parts) else None, point)


@shared_effort(EFFORT)
def examine(cells: Sequence[LyapunovCell]) -> LyapunovResult:
    """Decide Lyapunov's conditions on cells that cover the domain, the equilibrium at the origin."""
    real = inhabited(cells)
    definite = tuple(prove(Sense.POSITIVE, cell.potential, cell.region, except_origin=True) for cell in real)
    strata = (*(cell_stratum(cell) for cell in real), *bend_strata(real))
    verdict, witness, reason = conclude(real, definite, strata)
    return LyapunovResult(real, definite, strata, verdict, witness, reason)


def inhabited(cells: Sequence[LyapunovCell]) -> tuple[LyapunovCell, ...]:
    """Without the cells whose guards are proved to leave nothing of them."""
    return tuple(cell for cell in cells if not (cell.region.guards and _is_empty(cell)))


def _is_empty(cell: LyapunovCell) -> bool:
    """Whether the open cell holds no point: exactly over Q, unless that takes too much work.

    Otherwise, whether that is seen with little work (the origin alone would be no cell).
    """
    decided = is_empty(cell.region)
    if decided is not None:
        return decided
    return _is_seen_empty(cell.region, cell.potential, EMPTINESS_WORK)


def conclude(
    cells: Sequence[LyapunovCell], definite: Sequence[Outcome], strata: Sequence[Stratum]
) -> tuple[Decrease, Refutation | None, str]:
    """The verdict from the evidence."""
    refuted = next(refutations(cells, definite, strata), None)
    if refuted is not None:
        return Decrease.REFUTED, refuted, refuted.meaning
    supremum_signs = [_trusted(stratum) for stratum in strata]
    open_part = next((o for o in definite if not isinstance(o, Proof)), None)
    if open_part is not None or worst(supremum_signs) is SupremumSign.UNDECIDED:
        stuck = [o for o in (open_part, *_outcomes(strata)) if isinstance(o, Undecided)]
        return Decrease.UNDECIDED, None, stuck[0].reason if stuck else "V bends where its derivative is not decided"
    if worst(supremum_signs) in (SupremumSign.EMPTY, SupremumSign.NEGATIVE):
        return Decrease.STRICT, None, Decrease.STRICT.value
    return Decrease.WEAK, None, Decrease.WEAK.value


def _outcomes(strata: Sequence[Stratum]) -> Iterator[Outcome]:
    for stratum in strata:
        if isinstance(stratum.evidence, tuple):
            yield from stratum.evidence


def _trusted(stratum: Stratum) -> SupremumSign:
    """The sign that decides; a positive one without refutation decides nothing."""
    supremum_sign = stratum.supremum_signs.bacciotti_ceragioli
    return (
        SupremumSign.UNDECIDED
        if supremum_sign is SupremumSign.POSITIVE and stratum.refutation is None
        else supremum_sign
    )


def refutations(
    cells: Sequence[LyapunovCell], definite: Sequence[Outcome], strata: Sequence[Stratum]
) -> Iterator[Refutation]:
    """Where V is not zero at the equilibrium, not positive, not continuous, or increases."""
    for cell, outcome in zip(cells, definite, strict=True):
        zero = cell.potential.field.zero
        at_origin = cell.potential.at_origin
        if at_origin and closure_membership(cell.region) is ClosureMembership.YES:
            yield Refutation((zero, zero), at_origin, "V is not zero at the equilibrium")
        if isinstance(outcome, Counterexample):
            yield Refutation(outcome.point, outcome.value, "V is not positive")
        elif isinstance(outcome, ZeroBetween):
            yield Refutation(outcome.point, None, "V vanishes beside this point")
    for stratum in strata:
        if stratum.refutation is not None:
            yield stratum.refutation


# ---- laSalle's invariance principle for a V that does not increase -------------------------------
#
# Whether anything but the origin stays where V' = 0.
#
# For a Filippov inclusion every bounded solution tends to the largest weakly invariant set in the closure of Z, the set
# of points at which some f in F has ``g . f = 0`` for all g in dV (Shevitz and Paden 1994; Ryan 1998; Bacciotti and
# Ceragioli 1999, thm. 3).  On a limit set V has one value, so a solution there stays on one level of V for ever.  That
# none does is shown by further functions that rise, one after the other, along all velocities that keep those before
# (:mod:`nonsmooth.proofs.kernel.second_function`): a theorem of the checker, in any number of states, of the hull of
# all fields that act.  Irrational numbers of the fields are enclosed first.
#
# Where no such functions are found, what is plainly seen is said: cells in which a field keeps V, a curve on which V' =
# 0 along a level of V, or a place of rest.  Nothing follows from that.


ALONG = (Fraction(1, 64), Fraction(1, 2), Fraction(1))  # of a side, from its first end, where a rest is looked for


class InvariantMotion(StrEnum):
    """What is known of solutions that stay where V' = 0."""

    NONE = "no solution but the equilibrium stays where V' = 0"
    RESTS = "there are other equilibria where V' = 0"
    ARC = "V' = 0 on an arc of a level of V"
    CELLS = "V' = 0 on cells in which solutions may stay"
    UNDECIDED = "whether other solutions stay where V' = 0 is not decided"


def decide_invariant_motion(
    system: SwitchedSystem, formula: PiecewiseExpression, radius: Number, cells: Sequence[LyapunovCell]
) -> InvariantMotion:
    """Whether a solution other than the origin stays for ever on one level of V inside the domain.

    Args:
        system: in two states.
        formula: V in the displacement.
        radius: half the side of the square on which further functions are searched.
        cells: cover the domain; V is positive and does not increase on them.
    """
    if attraction(system, formula, radius, cells) is not None:
        return InvariantMotion.NONE
    if not all(rate for cell in cells for rate in cell.rates):
        return InvariantMotion.CELLS
    if _holds_level_arc(cells):
        return InvariantMotion.ARC
    return InvariantMotion.UNDECIDED if resting_place(cells) is None or system.only_encloses else InvariantMotion.RESTS


def attraction(
    system: SwitchedSystem, formula: PiecewiseExpression, radius: Number, cells: Sequence[LyapunovCell]
) -> Record | None:
    """LaSalle's principle with its evidence, as a certificate holds it; None where it is not shown.

    Where another place is seen to rest no further functions are searched.

    Args:
        system: in two states.
        formula: V in the displacement, which does not increase.
        radius: half the side of the square on which further functions are searched.
        cells: cover the domain.
    """
    if resting_place(cells) is not None:
        return None
    return find_attraction(with_known_numbers(system), formula, radius)


# ---- what is seen where attraction is not shown ----------------------------------------------------


@effort_of_its_own(EFFORT)
def _holds_level_arc(cells: Sequence[LyapunovCell]) -> bool:
    """Whether a rate vanishes on a curve along which V is constant.

    An irreducible factor q of the rate whose zero set holds an arc of a level divides the Jacobian of V and q.
    """
    for cell in cells:
        for rate in cell.rates:
            factored = factorize(rate * rate.terms[max(rate.terms)].inverse())
            curves = [] if factored is None else [curve for curve, _ in factored[1]]
            if any(_runs_along_level(curve, cell) and _has_points(curve, cell) for curve in curves):
                return True
    return False


def _runs_along_level(curve: Polynomial, cell: LyapunovCell) -> bool:
    a, b = cell.gradient
    return divides(curve, a * curve.derivative("y") - b * curve.derivative("x")) is True


def _has_points(curve: Polynomial, cell: LyapunovCell) -> bool:
    """Whether a curve may have a point in a cell but the origin."""
    senses = (Sense.POSITIVE, Sense.NEGATIVE)
    return not any(isinstance(prove(sense, curve, cell.region, except_origin=True), Proof) for sense in senses)


def resting_place(cells: Sequence[FieldCell]) -> Point | None:
    """A place other than the origin at which 0 is in F; None where none is seen inside cells and on their sides.

    Args:
        cells: cover a domain.  Beside curves nothing is looked at.
    """
    if any(cell.region.guards for cell in cells):
        return None
    return next((p for p in _places(cells) if any(map(sign, p)) and hull_holds_zero(velocities_at(cells, p))), None)


def _places(cells: Sequence[FieldCell]) -> Iterator[Point]:
    yield from (cell.region.inner_point for cell in cells)
    for first, second in combinations(cells, 2):
        for start, end in common_edges(first.region, second.region):
            for share in ALONG:
                place = [a * (1 - share) + b * share for a, b in zip(start, end, strict=True)]
                if place[2]:
                    yield affine(place)
