"""A periodic orbit that crosses switching surfaces, proved by its return map on a segment across it.

With ``P(0)`` and ``P'(s)`` for ``|s| <= r`` enclosed, ``P(s) = s`` has exactly one solution there if
``P(0)/(1 - P')`` lies inside and ``P'`` excludes 1 (the interval Newton method; Moore 1966).  ``P'`` is the Floquet
multiplier there: inside the unit interval the orbit attracts all its neighbours, outside it repels them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from flint import arb

from nonsmooth.proofs.boxes.enclosures import UNIT, holds_on
from nonsmooth.proofs.orbits.ball_steps import (
    Ball,
    BallCell,
    BallFunction,
    Box,
    EnclosedStep,
    EndFunction,
    Expansion,
    UnprovedError,
    applied,
)
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError

# ---- a family of solutions through a cell --------------------------------------------------------
#
# From where it enters to where it leaves, enclosed by balls.
#
# The family is a curve ``x(s)``, ``|s| <= reach``, with ``x(0)`` in a small box and ``x'(s)`` in another: so ``x(s) =
# x(0) + x'(.) s`` by the mean value theorem.  Enclosed are the solution from the middle of the small box and the
# derivative Phi of all solutions by their starts.  On arrival at ``e = 0``, each at its own time, the derivative is
# ``Phi - f (grad e . Phi)/(grad e . f)``, which takes both boxes along.  Shown on the way: every guard of the cell is
# positive between entry and arrival, and ``e`` falls through zero once.


MOST_STEPS = 400  # through one cell
PARTS = 7  # halvings of a step, in search of the sign of a guard on all of it
APPROACHES = 40  # steps that come nearer to an arrival by three quarters each
NEWTON = 8  # steps towards a time of arrival


@dataclass(frozen=True)
class Family:
    """A curve of states.

    Attributes:
        centre: exact point beside ``x(0)``.
        error: ``x(0)`` less the centre.
        slope: ``x'(s)`` for all s.
        reach: largest s in absolute value.
    """

    centre: Box
    error: Box
    slope: Box
    reach: Ball

    @property
    def box(self) -> Box:
        """A box of the whole curve."""
        return [x + v * self.reach * UNIT for x, v in zip(self.first, self.slope, strict=True)]

    @property
    def first(self) -> Box:
        """A box of ``x(0)``."""
        return [c + e for c, e in zip(self.centre, self.error, strict=True)]

    def moved(self, states: Box, derivative: Box) -> Family:
        """The family after the centre has come to a box, and derivatives to others."""
        centre = [x.mid() for x in states]
        errors = applied(derivative, self.error)
        error = [x - c + e for x, c, e in zip(states, centre, errors, strict=True)]
        return replace(self, centre=centre, error=error, slope=applied(derivative, self.slope))


# at the arrival, each at its own time; the field's own time until then, of all; and of the centre that of the steps
Passage: TypeAlias = tuple[Family, Ball, Ball]


def pass_cell(
    cell: BallCell,
    family: Family,
    end: EndFunction,
    lasts: Ball,
    *,
    entry: int | None = None,
    leaves: int | None = None,
    tangent: bool = False,
) -> Passage:
    """Take a family through a cell until ``end`` falls to zero.

    Args:
        cell: the cell.
        family: on the surface ``entry``, or inside the cell where that is None.
        end: what falls to zero at the arrival.
        lasts: about how long the centre takes.
        entry: number of the surface that it enters by.
        leaves: number of the surface that ``end`` is, if it is one.
        tangent: whether it departs from that surface along it, bending away.

    Raises:
        UnprovedError: for what cannot be shown.
    """
    way, approaches = _Crossing(cell, family, entry, tangent=tangent), 0
    for _ in range(MOST_STEPS):
        remaining = (lasts - way.time).mid()
        # no path can have arrived; that is asked late on the way only, as a section may be crossed before
        ahead = remaining > lasts / 64 or end.value(way.family.box) > 0
        if not remaining > 0 or approaches > APPROACHES or not ahead:
            break
        thin, wide = way.steps(2 * remaining)
        if wide.span >= 2 * remaining:
            passage = way.arrive(thin, wide, end, leaves)
            if passage is not None:
                return passage
        if wide.span > remaining * 3 / 4:
            approaches += 1
            thin, wide = way.steps((remaining * 3 / 4).mid())
        way.advance(thin, wide)
    raise UnprovedError("the family of paths does not clearly reach the next surface")


class _Crossing:
    """A family while it passes a cell."""

    def __init__(self, cell: BallCell, family: Family, entry: int | None, *, tangent: bool) -> None:
        self.cell, self.family, self.time, self.elapsed = cell, family, arb(0), arb(0)
        self._recent = arb("inf")  # length of the last step
        self._series: tuple[Expansion, Expansion] | None = None
        box = family.box
        if not all(k == entry or guard.value(box) > 0 for k, guard in enumerate(cell.guards)):
            raise UnprovedError("a start of the return map may lie on another switching surface")
        # of each guard, which is positive or zero now: whether its slope is known to be
        self._rises = [tangent and k == entry for k in range(len(cell.guards))]
        if tangent and (entry is None or not cell.guards[entry].bend(box) > 0):
            raise UnprovedError("the orbit does not clearly bend away from the surface that it leaves")

    def steps(self, longest: Ball) -> tuple[EnclosedStep, EnclosedStep]:
        """The solution from the centre, and all solutions with their derivatives, over one time."""
        if self._series is None:
            self.cell.spend_step()
            one, zero = arb(1), arb(0)
            varied = Expansion(self.cell.varied_rates, [*self.family.box, one, zero, zero, one, zero])
            self._series = Expansion(self.cell.rates, self.family.centre), varied
        centre, whole = self._series
        thin = centre.step(min(longest, self._recent * 4 / 3))
        wide = whole.step(thin.span)
        if wide.span < thin.span:
            thin = centre.step(wide.span)
        if thin.span < wide.span:
            raise UnprovedError("no step of the path could be enclosed")
        return thin, wide

    def advance(self, thin: EnclosedStep, wide: EnclosedStep) -> None:
        """Take a step within the cell."""
        for k in range(len(self.cell.guards)):
            self._require_positive(k, wide, wide.span)
        *state, elapsed = wide.at(wide.span)
        self.family, self.elapsed = self.family.moved(thin.at(thin.span), state[2:]), self.elapsed + elapsed
        self.time, self._series, self._recent = self.time + thin.span, None, thin.span

    def _require_positive(self, number: int, step: EnclosedStep, until: Ball) -> None:
        """Show that a guard is positive all along a step until a time, but for a start at zero."""
        guard = self.cell.guards[number]

        def is_positive(times: Ball) -> bool:
            box = step.at(times)[:2]
            bends = self._rises[number] and bool(guard.bend(box) > 0)
            is_shown = bends or bool(guard.slope(box) > 0 or guard.value(box) > 0)
            self._rises[number] = bends if is_shown else self._rises[number]
            return is_shown

        if not holds_on(is_positive, arb(0), until, PARTS):
            raise UnprovedError("the path comes too near to a switching surface between its crossings")

    def arrive(self, thin: EnclosedStep, wide: EnclosedStep, end: EndFunction, leaves: int | None) -> Passage | None:
        """End at ``end = 0`` within a step, if that is clear."""
        late = wide.at(wide.span)[:2]
        if not (end.value(self.family.box) > 0 and end.value(late) < 0 and end.slope(wide.hull[:2]) < 0):
            return None
        when, centre_when = _falls_at(wide, end), _falls_at(thin, end)
        for k in range(len(self.cell.guards)):
            if k != leaves:
                self._require_positive(k, wide, when.upper())
        *state, elapsed = wide.at(when)
        box, derivative = state[:2], state[2:]
        rates, normal = self.cell.rates(box), [slope(box) for slope in end.gradient]
        across = [dot(normal, derivative[column::2]) / dot(normal, rates) for column in range(2)]
        moved = [derivative[2 * row + k] - rates[row] * across[k] for row in range(2) for k in range(2)]
        family = self.family.moved(thin.at(centre_when), moved)
        return family, self.elapsed + elapsed, self.time + centre_when


def _falls_at(step: EnclosedStep, end: EndFunction) -> Ball:
    """A ball of the times in a step at which a falling function is zero, by the interval Newton method."""
    when = arb(0).union(step.span)
    for _ in range(NEWTON):
        here = when.mid()
        slope = end.slope(step.at(when)[:2])
        following = here - end.value(step.at(here)[:2]) / slope
        low, high = max(when.lower(), following.lower()), min(when.upper(), following.upper())
        if not high >= low:
            break
        when = low.union(high)
    return when


# ---- the return map ------------------------------------------------------------------------------


REFINEMENTS = 2  # of the point of a float orbit, each doubles its digits
REFINED = -44  # binary digits of a move after which the point is as good as the shortest segment needs
THIN = -150  # binary digits of the reach with which the point is refined
# Binary digits of reaches relative to the orbit: tried until one will do, then larger ones until one will not.
REACHES, LARGER = (-32, -44, -56), (-20, -12, -8, -5)


@dataclass(frozen=True)
class CrossedLeg:
    """A leg of an orbit inside a cell.

    Attributes:
        cell: the cell.
        entry: number of the surface by which it enters, None where the turn begins.
        leaves: number of the surface by which it leaves, None where the turn ends.
        lasts: about how long it takes.
    """

    cell: BallCell
    entry: int | None
    leaves: int | None
    lasts: Ball


@dataclass(frozen=True)
class ReturnMap:
    """The return map of a segment ``p + s d``, ``|s| <= reach``, enclosed.

    Attributes:
        point: p, exact.
        direction: d, exact.
        reach: r.
        value: ``P(0)``.
        slope: ``P'(s)`` for all s.
        time: of one turn, for all s.
        lasts: of each leg, from the centre, in the time of the polynomial field that is followed.
    """

    point: Box
    direction: Box
    reach: Ball
    value: Ball
    slope: Ball
    time: Ball
    lasts: tuple[Ball, ...]

    @property
    def fixed(self) -> Ball | None:
        """The one fixed point within the segment; None where that is not shown."""
        if (self.slope - 1).contains(0):
            return None
        s = self.value / (1 - self.slope)
        return s if abs(s) < self.reach else None

    @property
    def image(self) -> Ball:
        """A ball of the image of the whole segment."""
        return self.value + self.slope * self.reach * UNIT

    @property
    def into_itself(self) -> bool:
        """Whether the segment is mapped into its interior."""
        return bool(abs(self.image) < self.reach)


def proved_maps(legs: Sequence[CrossedLeg], point: Box, direction: Box, extent: Ball) -> tuple[ReturnMap, ReturnMap]:
    """The return map on a short segment and on the longest tried on which it has one fixed point, decided.

    Args:
        legs: of one turn, in order.
        point: where it begins, nearly.
        direction: of the segment, across the orbit.
        extent: of the orbit.

    Raises:
        UnprovedError: where no segment will do.
    """
    lasts = tuple(leg.lasts for leg in legs)
    for _ in range(REFINEMENTS):
        thin = return_map(legs, lasts, point, direction, extent * arb(2) ** THIN)
        move = thin.value / (1 - thin.slope)
        if not move.is_finite():
            raise UnprovedError("the multiplier is not told apart from one")
        point, lasts = [(x + d * move.mid()).mid() for x, d in zip(point, direction, strict=True)], thin.lasts
        if abs(move) < extent * arb(2) ** REFINED:
            break
    short = best = _first_proved(legs, lasts, (point, direction), [extent * arb(2) ** digits for digits in REACHES])
    for digits in LARGER:
        reach = extent * arb(2) ** digits
        try:
            best = best if reach < best.reach else _decided(return_map(legs, lasts, point, direction, reach))
        except (UnprovedError, WorkLimitError):
            break
    return short, best


def _first_proved(
    legs: Sequence[CrossedLeg], lasts: Sequence[Ball], segment: tuple[Box, Box], reaches: Sequence[Ball]
) -> ReturnMap:
    """The return map on the first segment on which it is decided.

    Raises:
        UnprovedError: where there is none, for the reason of the last.
    """
    refusal = UnprovedError("no segment was tried")
    for reach in reaches:
        try:
            return _decided(return_map(legs, lasts, *segment, reach))
        except UnprovedError as error:
            refusal = error
    raise refusal


def _decided(candidate: ReturnMap) -> ReturnMap:
    """The return map, if it has one fixed point that attracts or repels.

    Raises:
        UnprovedError: if that is not shown.
    """
    size = abs(candidate.slope)
    if candidate.fixed is None or not (size < 1 or size > 1):
        raise UnprovedError(f"the return map is not enclosed well enough: its slope is {candidate.slope.str(5)}")
    return candidate


def return_map(legs: Sequence[CrossedLeg], lasts: Sequence[Ball], point: Box, direction: Box, reach: Ball) -> ReturnMap:
    """Enclose the return map.

    Raises:
        UnprovedError: where that fails.
    """
    start = Family(point, [arb(0), arb(0)], direction, reach)
    family, time, times = fly(legs, lasts, start, section(legs[-1].cell, point, direction))
    square = dot(direction, direction)
    gap = [x - p for x, p in zip(family.first, point, strict=True)]
    return ReturnMap(
        point, direction, reach, dot(direction, gap) / square, dot(direction, family.slope) / square, time, times
    )


def fly(
    legs: Sequence[CrossedLeg],
    lasts: Sequence[Ball],
    family: Family,
    last: EndFunction | None,
    tangent: int | None = None,
) -> tuple[Family, Ball, tuple[Ball, ...]]:
    """Take a family along some legs: where and when it arrives, and how long each takes from the centre.

    Args:
        legs: in order.
        lasts: about how long each takes.
        family: at the start.
        last: where the last leg ends, if that is on no surface.
        tangent: number of the surface that the family leaves along it, if it does.

    Raises:
        UnprovedError: for what cannot be shown, also that every surface is crossed in one sense all along the arrivals.
    """
    time, times = arb(0), []
    for k, (leg, lasting) in enumerate(zip(legs, lasts, strict=True)):
        end = last if leg.leaves is None else leg.cell.guards[leg.leaves]
        if end is None:
            raise UnprovedError("a leg of the orbit ends on no switching surface")
        entry = tangent if leg.entry is None else leg.entry
        slides = tangent is not None and not k
        family, when, middle = pass_cell(leg.cell, family, end, lasting, entry=entry, leaves=leg.leaves, tangent=slides)
        if leg.leaves is not None and k + 1 < len(legs):
            before, after = (part.cell.guards[leg.leaves].slope(family.box) for part in legs[k : k + 2])
            if not (before < 0 and after > 0):
                raise UnprovedError("a switching surface may not be crossed all along the arrivals at it")
        time = time + when
        times.append(middle.mid())
    return family, time, tuple(times)


def section(cell: BallCell, point: Box, direction: Box) -> EndFunction:
    """The segment's line as an end: falling along the flow."""
    normal = [direction[1], -direction[0]]
    if dot(normal, cell.rates(point)) > 0:
        normal = [-n for n in normal]
    return EndFunction(
        lambda box: dot(normal, [x - p for x, p in zip(box, point, strict=True)]),
        lambda box: dot(normal, cell.rates(box)),
        [_constant(n) for n in normal],
    )


def _constant(value: Ball) -> BallFunction:
    return lambda _: value
