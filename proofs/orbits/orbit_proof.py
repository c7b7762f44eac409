"""What is proved of a periodic orbit that floats have found: that there is one, where, and whether it attracts.

Rigorous for planar systems: an orbit that crosses surfaces by its return map
(:mod:`nonsmooth.proofs.orbits.return_map`), one that slides by the points in which its slides end
(below).  Everything else is computed, not proved, and the reason is said.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from flint import acb, arb

from nonsmooth.analysis.fields.switched_field import Face
from nonsmooth.analysis.orbits.orbit import Orbit
from nonsmooth.analysis.trajectories.smooth_path import Leg
from nonsmooth.proofs.boxes.enclosures import holds_on
from nonsmooth.proofs.orbits.ball_steps import Ball, BallCell, Box, UnprovedError, along, in_balls, precision
from nonsmooth.proofs.orbits.return_map import CrossedLeg, Family, ReturnMap, fly, proved_maps
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.polynomial import Polynomial, float_values
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, WorkMeter
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

PRODUCTS = 1_500_000  # of balls or series in one proof, some ten seconds
GAUSS = 5  # nodes of a quadrature over one step in floats


@dataclass(frozen=True)
class OrbitProof:
    """What is proved.

    Attributes:
        attracts: whether the orbit attracts (True) or repels (False) all its neighbours; None where nothing is proved.
        reason: in one sentence.
        period: enclosed; None where nothing is proved.
        multiplier: the Floquet multiplier, enclosed; None likewise.
        segment: the longest segment across the orbit on which the return map was enclosed; None for orbits that slide.
    """

    attracts: bool | None
    reason: str
    period: Ball | None = None
    multiplier: Ball | None = None
    segment: ReturnMap | None = None

    @property
    def is_proved(self) -> bool:
        """Whether the orbit is shown to exist, and to attract or to repel."""
        return self.attracts is not None


def prove_orbit(system: SwitchedSystem, orbit: Orbit) -> OrbitProof:
    """Try to prove a periodic orbit and its stability.

    Args:
        system: whose orbit it is.
        orbit: found by floats, in the coordinates of the states.
    """
    if not system.is_planar:
        return OrbitProof(None, "return maps are enclosed for two states only")
    if system.others or system.only_encloses or system.rewriting.norms or system.by_roots is not None:
        return OrbitProof(None, "return maps are enclosed for one field of polynomials or of their quotients only")
    try:
        with precision():
            return _Prover(system, orbit).proof()
    except UnprovedError as error:
        return OrbitProof(None, str(error))
    except WorkLimitError:
        return OrbitProof(None, f"its return map was not enclosed within {PRODUCTS} products of balls")


_Run: TypeAlias = tuple[Leg, ...]  # on one face; more than one where the turn began within it


class _Prover:
    """The legs of an orbit as exact cells."""

    def __init__(self, system: SwitchedSystem, orbit: Orbit) -> None:
        self.system, self.orbit, self.meter = system, orbit, WorkMeter(PRODUCTS)
        self.surfaces: Sequence[Polynomial] = system.surfaces(system.coordinates())
        self.numbers = {id(s): k for k, s in enumerate(orbit.field.surfaces)}

    def proof(self) -> OrbitProof:
        """By the return map, or by the ends of the slides."""
        return self._by_slides() if self.orbit.slides else self._by_crossings()

    def _by_crossings(self) -> OrbitProof:
        orbit = self.orbit
        along = orbit.legs[0].motion(0.0, orbit.point)
        normal = np.array([-along[1], along[0]]) / float(np.hypot(*along))
        point, direction = ([arb(float(x)) for x in vector] for vector in (orbit.point, normal))
        short, long = proved_maps(self._crossed([(leg,) for leg in orbit.legs]), point, direction, arb(orbit.extent))
        attracts = bool(abs(short.slope) < 1)
        clause = "is mapped into itself" if long.into_itself else "holds one fixed point of its return map"
        whole = f"a segment of half-width {float(long.reach.mid()):.3g} across the orbit {clause}"
        size = f"the slope of the return map is {short.slope.str(8)}"
        return OrbitProof(attracts, f"{whole}; {size}", short.time, short.slope, long)

    def _by_slides(self) -> OrbitProof:
        if self.orbit.is_one_slide:
            raise UnprovedError("slides are enclosed where they end, and this one goes on for the whole turn")
        legs = list(self.orbit.legs)
        last = max(k for k, leg in enumerate(legs) if leg.motion.face.keep)
        turned = _joined(legs[last:] + legs[:last])
        starts = [k for k, leg in enumerate(turned) if leg[0].motion.face.keep]
        parts = [turned[k : n or None] for k, n in zip(starts, [*starts[1:], 0], strict=True)]
        chains = [self._chain(part) for part in parts]
        period = proved_period(chains)
        reason = "a slide of the orbit ends in one point wherever it began, and that point returns to the slide"
        return OrbitProof(True, reason, period, arb(0))

    def _chain(self, legs: Sequence[_Run]) -> SlideChain:
        """A slide and the legs behind it."""
        slide, *free = legs
        keep = slide[0].motion.face.keep
        if len(keep) != 1 or slide[-1].met or not free:
            raise UnprovedError("a slide of the orbit ends otherwise than by leaving its surface")
        number = self.numbers[id(keep[0])]
        if self.surfaces[number].degree != 1:
            raise UnprovedError("slides are followed on straight surfaces only")
        leaving = self._signs(free[0])
        other = tuple(-side if k == number else side for k, side in enumerate(leaving))
        inside, outside = (BallCell(self.system, self.surfaces, signs, self.meter) for signs in (leaving, other))
        ends: Box = [arb(float(x)) for x in slide[-1].last]
        return SlideChain(
            TangencySlide(self.surfaces[number], number, inside, outside, ends), tuple(self._crossed(free))
        )

    def _crossed(self, legs: Sequence[_Run]) -> list[CrossedLeg]:
        """Legs in cells."""
        crossed_legs, entry = [], None
        for leg in legs:
            surfaces = leg[-1].met
            leaves = self.numbers[id(surfaces[0])] if surfaces else None
            cell = BallCell(self.system, self.surfaces, self._signs(leg), self.meter)
            crossed_legs.append(CrossedLeg(cell, entry, leaves, arb(_lasting(cell, leg))))
            entry = leaves
        return crossed_legs

    def _signs(self, leg: _Run) -> tuple[int, ...]:
        """Signs of the switching functions on a leg's cell."""
        sides = {self.numbers[id(surface)]: side for surface, side in leg[0].motion.face.bounds}
        if len(sides) != len(self.surfaces):
            raise UnprovedError("a leg of the orbit is in no cell")
        return tuple(sides[k] for k in range(len(self.surfaces)))


def _lasting(cell: BallCell, legs: _Run) -> float:
    """About how long legs take in the time of the field that is followed: the integral of ``1/s`` over the stated."""
    if cell.scale is None:
        return sum(leg.end - leg.start for leg in legs)
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
    total = 0.0
    for leg in legs:
        times = np.array(leg.stretch.times)
        halves = np.diff(times) / 2
        points = leg.stretch.at_all(np.ravel((times[:-1] + halves)[:, None] + halves[:, None] * nodes))
        total += float(halves @ (1 / float_values(cell.scale.terms, points)).reshape(-1, GAUSS) @ weights)
    return total


def _joined(legs: Sequence[Leg]) -> list[_Run]:
    """Legs of one turn; where the turn began, two parts of one leg follow each other."""
    runs: list[_Run] = []
    for leg in legs:
        last = runs[-1] if runs else ()
        if last and not last[-1].met and _sides(last[-1].motion.face) == _sides(leg.motion.face):
            runs[-1] = (*last, leg)
        else:
            runs.append((leg,))
    return runs


def _sides(face: Face) -> tuple[object, ...]:
    """The surfaces held and the sides of the others."""
    return face.keep, face.bounds


# ---- orbits that slide ---------------------------------------------------------------------------
#
# A slide along a straight surface ends where the field of one side becomes tangent to it.  That point does not depend
# on where the slide began: if the solution from it comes back to a stretch of the surface along which both sides push,
# and from which one slides to that point again, it is periodic.  Every neighbour reaches the same stretch, so all come
# onto the orbit in finite time: its Floquet multiplier is zero.


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

        With pushes p and q of two fields f and g the sliding field is ``(q f + p g)/(p + q)``, all in their own time.
        """
        (f, scale), (g, other) = (cell.paced(self.point(place)) for cell in (self.leaving, self.other))
        p, q = self.push(self.leaving, place) / scale, self.push(self.other, place) / other
        first, second = dot(self.tangent, f), dot(self.tangent, g)
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
    for cell in (slide.leaving, slide.other):
        for k, guard in enumerate(cell.guards):
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
