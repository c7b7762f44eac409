"""Verifying what is said of a periodic orbit by another way than the one by which it was proved.

A solution from one point is followed through the cells as they come (:mod:`nonsmooth.proofs.orbits.follower`).
The derivative of the return map is taken from areas, not from the variational equation: by Liouville's formula the
derivative Phi of the state by the start has determinant ``exp(int div f)``, times ``n . g/n . f`` where the field jumps
from f to g across a surface with the normal n.  Sections carry the direction d and the flow, so

    P'(s) = det Phi (f(x) x d)/(f(y) x d)      for the start x and the return y

(Aizerman and Gantmakher 1958; Andronov, Vitt and Khaikin 1966).  A solution that comes to a surface onto which
both sides push slides on by the differential equation of the sliding field, until one side no longer pushes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from flint import arb

from nonsmooth.proofs.orbits.ball_cell import dot
from nonsmooth.proofs.orbits.ball_steps import Ball, BallPolynomial, Box, UnprovedError, lower, middle, upper
from nonsmooth.proofs.orbits.follower import MOST_STEPS, Follower, SolutionPlace
from nonsmooth.proofs.orbits.return_map import ReturnMap
from nonsmooth.proofs.orbits.slide_map import SlideEnd
from nonsmooth.proofs.orbits.solution_steps import LONGEST, SHORTEST, falls_at
from nonsmooth.symbolic.switched_system import SwitchedSystem

THIN = -20  # binary digits to which a claim is told from another one at least
WITHIN = 64  # returns farther from the point, against the reach of the segment, are other crossings of its line


@dataclass(frozen=True)
class Return:
    """A solution that has come back to the line of a segment: where, after which time, and ``P'`` there."""

    place: Ball
    time: Ball
    slope: Ball


def returned(follower: Follower, point: Box, direction: Box, start: Ball, reach: Ball) -> Return:
    """Follow the solution from ``point + start direction`` back to the line.

    Raises:
        UnprovedError: where that is not shown.
    """
    first = [p + start * d for p, d in zip(point, direction, strict=True)]
    place = SolutionPlace(follower.signs_at(first), [*first, arb(0)], arb(0))
    speed = _cross(follower.cell(place.signs).rates(first), direction)
    sense = 1 if speed > 0 else -1
    if not sense * speed > 0:
        raise UnprovedError("a segment is not across the flow")

    def below(z: Sequence[Any]) -> Any:
        """Positive before the line, in the sense of the flow at the start."""
        return -sense * _cross([x - p for x, p in zip(z[:2], point, strict=True)], direction)

    armed = False
    for _ in range(MOST_STEPS):
        before = replace(place)
        met = follower.advance(place, LONGEST)
        if armed and not below(place.state) > 0:
            found = _arrival(follower, before, below, point, direction)
            if abs(found.place) < WITHIN * reach:
                return Return(found.place, found.time, found.slope * speed)
        armed = bool(below(place.state) > 0)
        if met is not None and not follower.cross(place, met):
            raise UnprovedError("a solution slides, which the orbit does not")
    raise UnprovedError("a solution does not come back")


def _arrival(follower: Follower, before: SolutionPlace, below: Any, point: Box, direction: Box) -> Return:
    """The arrival at the line within the step from a place; the slope lacks the speed at the start."""
    longest, cell = LONGEST, follower.cell(before.signs)
    while longest > SHORTEST:
        step, met = follower.step(before, longest)
        late = below(step.at(step.span))
        if not met and late > 0:
            before.state, before.time = step.at(step.span), before.time + step.span
        elif not met and late < 0 and not _cross(cell.rates(step.hull[:2]), direction).contains(0):
            when = falls_at(step, below)
            *state, growth = step.at(when)
            gap = [x - p for x, p in zip(state, point, strict=True)]
            place = dot(gap, direction) / dot(direction, direction)
            return Return(place, before.time + when, growth.exp() / _cross(cell.rates(state), direction))
        longest = step.span * 3 / 4
    raise UnprovedError("it is not clear when a solution comes back")


def _cross(first: Sequence[Any], second: Sequence[Any]) -> Any:
    return first[0] * second[1] - first[1] * second[0]


def next_slide_end(follower: Follower, signs: tuple[int, ...], number: int, point: Box) -> SolutionPlace:
    """From the end of a slide to the end of the next.

    Raises:
        UnprovedError: where that is not shown.
    """
    place = SolutionPlace(signs, [*point, arb(0)], arb(0), number)
    for _ in range(MOST_STEPS):
        met = follower.advance(place, LONGEST)
        if met is not None and not follower.cross(place, met):
            follower.slide(place, met)
            return place
    raise UnprovedError("a solution does not come to a slide")


# ---- what is claimed -----------------------------------------------------------------------------


def segment_holds(system: SwitchedSystem, found: ReturnMap, period: Ball, multiplier: Ball, attracts: bool) -> bool:
    """Whether the solutions from both ends and the fixed point of a segment bear out what is said of it.

    The ends come back nearer to each other or farther apart, on either side of a fixed point; there lie the period and
    the multiplier.  The slope of the return map between these places is not enclosed again.

    Raises:
        UnprovedError: where that is not shown.
    """
    if found.fixed is None or not found.reach > 0:
        return False
    if not (found.slope.overlaps(multiplier) and found.time.overlaps(period)):
        return False
    if not (abs(multiplier) < 1 if attracts else abs(multiplier) > 1):
        return False
    back = partial(returned, Follower(system), found.point, found.direction, reach=found.reach)
    starts = [-found.reach, found.reach, middle(found.fixed)]
    low, high, beside = (back(start) for start in starts)
    fixed = starts[2] + (beside.place - starts[2]) / (1 - found.slope)  # interval Newton
    orbit = back(fixed)
    sense = 1 if attracts else -1
    apart = sense * (low.place + found.reach) > 0 and sense * (found.reach - high.place) > 0
    others = (low, high, beside)
    on_it = all(
        (found.value + found.slope * start).overlaps(end.place) for start, end in zip(starts, others, strict=True)
    )
    slopes = all(_agree(found.slope, b.slope) and _agree(found.time, b.time) for b in others)
    own = _agree(multiplier, orbit.slope) and _agree(period, orbit.time) and found.fixed.overlaps(fixed)
    decided = abs(orbit.slope) < 1 if attracts else abs(orbit.slope) > 1
    return bool(apart and on_it and slopes and own and decided)


def slides_hold(system: SwitchedSystem, ends: Sequence[SlideEnd], period: Ball) -> bool:
    """Whether each slide's end is one, and the solution from it comes to the end of the next slide, after the period.

    Raises:
        UnprovedError: where that is not shown.
    """
    follower, time = Follower(system), arb(0)
    for end, following in zip(ends, [*ends[1:], *ends[:1]], strict=True):
        line = _Line(follower, end)
        if not line.holds_an_end():
            return False
        place = next_slide_end(follower, end.signs, end.number, line.point(end.place))
        if (place.signs, place.departs) != (following.signs, following.number):
            return False
        if not _Line(follower, following).is_that_end(place.state[:2]):
            return False
        time += place.time
    return bool(ends) and bool(period.overlaps(time)) and _is_thin(period)


def _agree(claimed: Ball, own: Ball) -> bool:
    """Whether a ball holds another, or cannot be told apart from a thin one."""
    thin = own.rad() < arb(2) ** THIN * abs(own)
    return bool(claimed.contains(own) or (thin and claimed.overlaps(own)))


def _is_thin(ball: Ball) -> bool:
    """Whether a ball is known to far more digits than are printed."""
    return bool(upper(ball) - lower(ball) < arb(2) ** -60 * abs(ball))


class _Line:
    """The straight surface on which a slide is said to end, by places along it."""

    def __init__(self, follower: Follower, end: SlideEnd) -> None:
        surface = follower.surfaces[end.number]
        zero = [arb(0), arb(0)]
        self.normal = [BallPolynomial(surface.derivative(name))(zero) for name in surface.variables]
        self.offset = BallPolynomial(surface)(zero)
        self.follower, self.end, self.cell = follower, end, follower.cell(end.signs)

    def point(self, place: Ball) -> Box:
        """The point of the line at a place."""
        a, b = self.normal
        share = self.offset / dot(self.normal, self.normal)
        return [-share * a - place * b, -share * b + place * a]

    def speed(self, place: Ball) -> Ball:
        """Speed away from the line into the cell that the solution departs to."""
        return self.cell.guards[self.end.number].slope(self.point(place))

    def holds_an_end(self) -> bool:
        """Whether that speed takes both signs within the ball of places, and the solution bends away."""
        low, high = self.speed(lower(self.end.place)), self.speed(upper(self.end.place))
        bends = self.cell.guards[self.end.number].bend(self.point(self.end.place)) > 0
        return bool(bends and (low < 0 < high or high < 0 < low))

    def is_that_end(self, point: Box) -> bool:
        """Whether a zero of that speed in a box is the one in the ball of places: there is no other in both."""
        a, b = self.normal
        place = dot([-b, a], point) / dot(self.normal, self.normal)
        whole = place.union(self.end.place)
        slopes = self.follower.push_slopes(self.cell, self.end.number, self.point(whole))
        return bool(place.overlaps(self.end.place)) and not dot([-b, a], slopes).contains(0)
