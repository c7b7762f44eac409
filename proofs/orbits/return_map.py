"""A periodic orbit that crosses switching surfaces, proved by its return map on a segment across it.

With ``P(0)`` and ``P'(s)`` for ``|s| <= r`` enclosed, ``P(s) = s`` has exactly one solution there if
``P(0)/(1 - P')`` lies inside and ``P'`` excludes 1 (the interval Newton method; Moore 1966).  ``P'`` is the Floquet
multiplier there: inside the unit interval the orbit attracts all its neighbours, outside it repels them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb

from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.proofs.orbits.ball_cell import BallCell, BallFunction, EndFunction, dot
from nonsmooth.proofs.orbits.ball_steps import Ball, Box, UnprovedError
from nonsmooth.proofs.orbits.cell_passage import Family, pass_cell
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError

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


def _decided(found: ReturnMap) -> ReturnMap:
    """The return map, if it has one fixed point that attracts or repels.

    Raises:
        UnprovedError: if that is not shown.
    """
    size = abs(found.slope)
    if found.fixed is None or not (size < 1 or size > 1):
        raise UnprovedError(f"the return map is not enclosed well enough: its slope is {found.slope.str(5)}")
    return found


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
