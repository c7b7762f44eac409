"""What is proved of a periodic orbit that floats have found: that there is one, where, and whether it attracts.

Rigorous for planar systems: an orbit that crosses surfaces by its return map
(:mod:`nonsmooth.proofs.orbits.return_map`), one that slides by the points in which its slides end
(:mod:`nonsmooth.proofs.orbits.slide_map`).  Everything else is computed, not proved, and the reason is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from flint import arb

from nonsmooth.analysis.fields.switched_field import Face, Surface, Vector
from nonsmooth.analysis.orbits.orbit import Orbit
from nonsmooth.analysis.trajectories.smooth_path import Leg
from nonsmooth.proofs.orbits.ball_cell import BallCell
from nonsmooth.proofs.orbits.ball_steps import Ball, Box, UnprovedError, precision
from nonsmooth.proofs.orbits.return_map import CrossedLeg, ReturnMap, proved_maps
from nonsmooth.proofs.orbits.slide_map import SlideChain, TangencySlide, proved_period
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, WorkMeter
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem

PRODUCTS = 1_500_000  # of balls or series in one proof, some ten seconds


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
    if len(system.states) != len(PLANE):
        return OrbitProof(None, "return maps are enclosed for two states only")
    if system.written:
        return OrbitProof(None, "return maps are enclosed for polynomial right-hand sides only")
    try:
        with precision():
            return _Prover(system, orbit).proof()
    except UnprovedError as error:
        return OrbitProof(None, str(error))
    except WorkLimitError:
        return OrbitProof(None, f"its return map was not enclosed within {PRODUCTS} products of balls")


@dataclass(frozen=True)
class _Part:
    """What is needed of a leg: its face, the surface it met, where it ends, how long it lasts."""

    face: Face
    met: tuple[Surface, ...]
    last: Vector
    lasts: float


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
        extent = float(np.ptp(orbit.path.array, axis=0).max())
        point, direction = ([arb(float(x)) for x in vector] for vector in (orbit.point, normal))
        short, long = proved_maps(self._crossed([_part(leg) for leg in orbit.legs]), point, direction, arb(extent))
        attracts = bool(abs(short.slope) < 1)
        said = "is mapped into itself" if long.into_itself else "holds one fixed point of its return map"
        whole = f"a segment of half-width {float(long.reach.mid()):.3g} across the orbit {said}"
        size = f"the slope of the return map is {short.slope.str(8)}"
        return OrbitProof(attracts, f"{whole}; {size}", short.time, short.slope, long)

    def _by_slides(self) -> OrbitProof:
        if self.orbit.is_one_slide:
            raise UnprovedError("slides are enclosed where they end, and this one goes on for the whole turn")
        legs = list(self.orbit.legs)
        last = max(k for k, leg in enumerate(legs) if leg.motion.face.keep)
        turned = _joined(legs[last:] + legs[:last])
        starts = [k for k, leg in enumerate(turned) if leg.face.keep]
        parts = [turned[k : n or None] for k, n in zip(starts, [*starts[1:], 0], strict=True)]
        chains = [self._chain(part) for part in parts]
        period = proved_period(chains)
        reason = "a slide of the orbit ends in one point wherever it began, and that point returns to the slide"
        return OrbitProof(True, reason, period, arb(0))

    def _chain(self, legs: Sequence[_Part]) -> SlideChain:
        """A slide and the legs behind it."""
        slide, *free = legs
        if len(slide.face.keep) != 1 or slide.met or not free:
            raise UnprovedError("a slide of the orbit ends otherwise than by leaving its surface")
        number = self.numbers[id(slide.face.keep[0])]
        if self.surfaces[number].degree != 1:
            raise UnprovedError("slides are followed on straight surfaces only")
        leaving = self._signs(free[0])
        other = tuple(-side if k == number else side for k, side in enumerate(leaving))
        inside, outside = (BallCell(self.system, self.surfaces, signs, self.meter) for signs in (leaving, other))
        ends: Box = [arb(float(x)) for x in slide.last]
        return SlideChain(
            TangencySlide(self.surfaces[number], number, inside, outside, ends), tuple(self._crossed(free))
        )

    def _crossed(self, legs: Sequence[_Part]) -> list[CrossedLeg]:
        """Legs in cells."""
        found, entry = [], None
        for leg in legs:
            leaves = self.numbers[id(leg.met[0])] if leg.met else None
            cell = BallCell(self.system, self.surfaces, self._signs(leg), self.meter)
            found.append(CrossedLeg(cell, entry, leaves, arb(leg.lasts)))
            entry = leaves
        return found

    def _signs(self, leg: _Part) -> tuple[int, ...]:
        """Signs of the switching functions on a leg's cell."""
        sides = {self.numbers[id(surface)]: side for surface, side in leg.face.bounds}
        if len(sides) != len(self.surfaces):
            raise UnprovedError("a leg of the orbit is in no cell")
        return tuple(sides[k] for k in range(len(self.surfaces)))


def _part(leg: Leg) -> _Part:
    return _Part(leg.motion.face, leg.met, leg.last, leg.end - leg.start)


def _joined(legs: Sequence[Leg]) -> list[_Part]:
    """Legs of one turn as parts; where the turn began, two parts of one leg follow each other."""
    found: list[_Part] = []
    for leg in legs:
        last = found[-1] if found else None
        if last is not None and not last.met and _sides(last.face) == _sides(leg.motion.face):
            found[-1] = replace(last, met=leg.met, last=leg.last, lasts=last.lasts + leg.end - leg.start)
        else:
            found.append(_part(leg))
    return found


def _sides(face: Face) -> tuple[object, ...]:
    """The surfaces held and the sides of the others."""
    return face.keep, face.bounds
