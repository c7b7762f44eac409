"""A periodic orbit that slides, proved by the point in which its slide ends.

A slide along a straight surface ends where the field of one side becomes tangent to it.  That point does not depend on
where the slide began: if the solution from it comes back to a stretch of the surface along which both sides push, and
from which one slides to that point again, it is periodic.  Every neighbour reaches the same stretch, so all come onto
the orbit in finite time: its Floquet multiplier is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import acb, arb

from nonsmooth.proofs.enclosures import holds_on
from nonsmooth.proofs.orbits.ball_cell import BallCell, along, dot, in_balls
from nonsmooth.proofs.orbits.ball_steps import Ball, Box, UnprovedError
from nonsmooth.proofs.orbits.cell_passage import Family
from nonsmooth.proofs.orbits.return_map import CrossedLeg, fly
from nonsmooth.symbolic.numbers.polynomial import Polynomial

NEAR_END = range(-40, 0, 2)  # binary digits of the radius in which the end of a slide is looked for
NEWTON = 8
PARTS = 12  # halvings of a slide, in search of the sign of a speed on all of it
LAST_PART = 20  # halvings of a slide, in search of a last part on which a speed rises to zero

OnLine = Callable[[Any], Any]


@dataclass(frozen=True)
class TangencySlide:
    """A slide along a straight surface, which ends where one side's field becomes tangent.

    Attributes:
        surface: the switching function, of degree one.
        number: its number.
        leaving: the cell into which the path leaves.
        other: the cell on the other side.
        ends: where it ends, nearly.
    """

    surface: Polynomial
    number: int
    leaving: BallCell
    other: BallCell
    ends: Box

    @cached_property
    def normal(self) -> Box:
        """Gradient of the switching function."""
        point = [arb(0), arb(0)]
        return [in_balls(self.surface.derivative(name))(point) for name in self.surface.variables]

    @cached_property
    def tangent(self) -> Box:
        """Direction of the line."""
        return [-self.normal[1], self.normal[0]]

    @cached_property
    def foot(self) -> Box:
        """The point of the line nearest to the origin."""
        share = in_balls(self.surface)([arb(0), arb(0)]) / dot(self.normal, self.normal)
        return [-share * n for n in self.normal]

    def point(self, place: Any) -> Box:
        """The point at a place along the line."""
        return [p + place * e for p, e in zip(self.foot, self.tangent, strict=True)]

    def place(self, point: Box) -> Ball:
        """Where on the line a point of it lies."""
        away = [x - p for x, p in zip(point, self.foot, strict=True)]
        return dot(self.tangent, away) / dot(self.tangent, self.tangent)

    def on_line(self, function: OnLine) -> OnLine:
        """A function of points at places along the line."""
        return lambda place: function(self.point(place))

    def push(self, cell: BallCell, place: Any) -> Any:
        """Speed away from the line into a side's own cell: negative where it pushes onto the line."""
        return cell.guards[self.number].slope(self.point(place))

    @cached_property
    def bend(self) -> OnLine:
        """Derivative of the leaving side's push along the line."""
        guard = self.surface * self.leaving.signs[self.number]
        push = along(self.leaving.field, guard)
        slopes = [in_balls(push.derivative(name)) for name in push.variables]
        return lambda place: dot([slope(self.point(place)) for slope in slopes], self.tangent)

    def drift(self, place: Any) -> tuple[Any, Any]:
        """Numerator and denominator of the sliding speed along the line, in places per time.

        With pushes p and q of two fields f and g the sliding field is ``(q f + p g)/(p + q)``.
        """
        p, q = self.push(self.leaving, place), self.push(self.other, place)
        point = self.point(place)
        first, second = (dot(self.tangent, cell.rates(point)) for cell in (self.leaving, self.other))
        return q * first + p * second, (p + q) * dot(self.tangent, self.tangent)

    @cached_property
    def end_place(self) -> Ball:
        """Where along the line the slide ends: a zero of the leaving side's push, enclosed.

        Raises:
            UnprovedError: where that is not shown.
        """
        start = self.place(self.ends).mid()
        for digits in NEAR_END:
            place = arb(start, arb(2) ** digits)
            following = start - self.push(self.leaving, start) / self.bend(place)
            if following.is_finite() and place.contains_interior(following):
                for _ in range(NEWTON):
                    here = following.mid()
                    following = here - self.push(self.leaving, here) / self.bend(following)
                return following
        raise UnprovedError("the end of a slide is not where one field alone becomes tangent to its surface")


@dataclass(frozen=True)
class SlideChain:
    """A slide and what follows it until the next slide begins.

    Attributes:
        slide: the slide.
        legs: the legs in cells after it.
    """

    slide: TangencySlide
    legs: tuple[CrossedLeg, ...]


def proved_period(chains: Sequence[SlideChain]) -> Ball:
    """The period of the orbit of some slides that follow each other in a circle.

    Raises:
        UnprovedError: for what cannot be shown.
    """
    period = arb(0)
    for chain, following in zip(chains, [*chains[1:], *chains[:1]], strict=True):
        arrived, time = _flown(chain)
        begin = following.slide.place(arrived.box)
        period = period + time + _slid(following.slide, begin)
    return period


def _flown(chain: SlideChain) -> tuple[Family, Ball]:
    """From the end of a slide to the surface of the next, and how long that takes."""
    slide = chain.slide
    exact = slide.point(slide.end_place)
    centre = [x.mid() for x in exact]
    nothing = [arb(0), arb(0)]
    family = Family(centre, [x - c for x, c in zip(exact, centre, strict=True)], nothing, arb(0))
    if not chain.legs:
        raise UnprovedError("a slide is followed by another at once")
    family, time, _ = fly(chain.legs, [leg.lasts for leg in chain.legs], family, None, slide.number)
    return family, time


def _slid(slide: TangencySlide, begin: Ball) -> Ball:
    """Time of a slide from a place to its end, with all that makes it one."""
    end = slide.end_place
    sense = 1 if end > begin else -1
    if not sense * (end - begin) > 0:
        raise UnprovedError("a slide may begin where it ends")
    whole = begin.union(end)
    last = _last_part(slide, begin, end, sense)
    _require_positive(lambda s: -slide.push(slide.leaving, s), begin.union(last))
    _require_positive(lambda s: -slide.push(slide.other, s), whole)
    # both pushes are negative, and so are numerator and denominator of a drift towards larger places
    _require_positive(lambda s: -sense * slide.drift(s)[0], whole)
    for k, guard in enumerate(slide.leaving.guards):
        if k != slide.number:
            _require_positive(slide.on_line(guard.value), whole)
    return _duration(slide, begin, end)


def _last_part(slide: TangencySlide, begin: Ball, end: Ball, sense: int) -> Ball:
    """A place from which on the leaving side's push rises to its zero at the end."""
    for k in range(1, LAST_PART):
        place = (end + (begin - end) * arb(2) ** -k).mid()
        if sense * slide.bend(place.union(end)) > 0:
            return place
    raise UnprovedError("it is not clear how a slide ends")


def _require_positive(value: OnLine, whole: Ball) -> None:
    """Show that a function is positive on an interval.

    Raises:
        UnprovedError: where that is not clear.
    """
    if not holds_on(lambda part: bool(value(part) > 0), whole.lower(), whole.upper(), PARTS):
        raise UnprovedError("it is not clear that both sides push onto the surface all along a slide")


def _duration(slide: TangencySlide, begin: Ball, end: Ball) -> Ball:
    """``int ds / drift``."""

    def per_place(place: Any, _: bool) -> Any:
        speed, scale = slide.drift(place)
        return scale / speed

    return arb(acb.integral(per_place, acb(begin), acb(end)).real)
