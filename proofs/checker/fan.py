"""The fan of cones at the checked point of an array: whether solutions come home, rest or leave.

The theorem (Filippov 1988, sec. 15-16, with the linear term of the pose): every solution near the point is a chain of
escapes, slides and crossings.  If none leads outward and none rests, the point is asymptotically stable; if some rest,
stable; if one leads outward, unstable.  The checker decides all of it by signs and needs no evidence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction
from itertools import product

from .contact import Cells, Motion
from .theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE
from .tower import Number, Vector, cross, dot, is_zero


class Outcome(IntEnum):
    """What the moves of a fan do, from the best to the worst."""

    INWARD = 0
    REST = 1
    OPEN = 2
    OUTWARD = 3


SLIDE_OUTCOMES = {1: Outcome.OUTWARD, 0: Outcome.REST, -1: Outcome.INWARD}  # by the sign of the radial speed
VERDICT_OF = {
    Outcome.INWARD: ASYMPTOTICALLY_STABLE,
    Outcome.REST: STABLE,
    Outcome.OPEN: None,
    Outcome.OUTWARD: UNSTABLE,
}


@dataclass(frozen=True)
class Cone:
    """A cell at the checked point: from ray ``start`` counterclockwise to ray ``end``, with its twists.

    Rays are numbers of points; ``(-1, -1)`` for the whole plane.
    """

    start: int
    end: int
    twists: tuple[Vector, ...]

    @property
    def is_plane(self) -> bool:
        """Whether the checked point lies inside the cell."""
        return self.start < 0


@dataclass(frozen=True)
class Crossing:
    """From ray to ray through a cone: ``s'`` is of order ``s^order``.

    ``gain`` is ``(a, b)``, both of one sign, where ``s' = (a/b) s``; None where the order is not one, and where the
    body turns about the checked point itself and keeps its distance.
    """

    order: Fraction
    gain: tuple[Number, Number] | None = None


def fan_at_point(cells: Cells, velocity: Callable[[Motion], Vector]) -> str | None:
    """What the fan of cones at the point says where each motion there moves the body with a velocity."""
    cones = [Cone(*cell.rays, tuple(map(velocity, cell.motions))) for cell in cells.listed if cell.rays is not None]
    return Fan(cones, cells.points).verdict()


class Fan:
    """The cones that meet at the checked point, and what solutions do in them.

    On a ray r at distance s the body's velocity has the normal part ``r x v + s omega |r|^2``, whose sign for all
    small s is that of the first term, or where that is zero of omega.
    """

    def __init__(self, cones: Sequence[Cone], points: Sequence[Vector]) -> None:
        self.cones = list(cones)
        self.points = points

    def verdict(self) -> str | None:
        """Stability of the checked point; None where these moves leave it open."""
        outcomes = [Outcome.INWARD]
        for cone in self.cones:
            outcomes += [self._escape(cone, twist) for twist in cone.twists]
        if not any(cone.is_plane for cone in self.cones):
            outcomes += self._slides()
            outcomes += [self._full_turn(sense) for sense in (1, -1)]
        return VERDICT_OF[max(outcomes)]

    def _escape(self, cone: Cone, twist: Vector) -> Outcome:
        """A velocity in its own closed cone carries the body straight away, unless omega bends it out along a ray."""
        if is_zero(twist[:2]):
            if not twist[2].sign():
                return Outcome.REST
            only_crossed = len(cone.twists) == 1 and not cone.is_plane
            return Outcome.INWARD if only_crossed else Outcome.OPEN
        if cone.is_plane:
            return Outcome.OUTWARD
        start, end, turning = self.points[cone.start], self.points[cone.end], twist[2].sign()
        after_start = cross(start, twist).sign() or turning * dot(start[:2], twist).sign()
        before_end = cross(twist, end).sign() or -turning * dot(end[:2], twist).sign()
        return Outcome.OUTWARD if after_start >= 0 and before_end >= 0 else Outcome.INWARD

    def _slides(self) -> Iterator[Outcome]:
        """Along a ray the hull of the velocities beside it holds a radial one where their normal parts are opposed."""
        beginning = {cone.start: cone.twists for cone in self.cones}
        for cone in self.cones:
            ray = self.points[cone.end][:2]
            twists = (*cone.twists, *beginning[cone.end])
            for first, second in product(twists, repeat=2):
                outcome = _slide(ray, first, second)
                if outcome is not None:
                    yield outcome

    def _full_turn(self, sense: int) -> Outcome:
        """The product of the orders of all crossings decides, and where that is one the product of their gains.

        In each cone the crossing with the most growth counts: a mixture of motions that tie gains no more, to first
        order, so a turn with a tied cone of another order is not said to contract.
        """
        choices = [self._crossings(cone, sense) for cone in self.cones]
        if not all(choices):
            return Outcome.INWARD  # no full turn exists
        steps = [_most_growth(crossings) for crossings in choices]
        order = math.prod((step.order for step in steps), start=Fraction(1))
        side = _side_of_one(steps) if order == 1 else (1 - order)
        if side > 0:
            return Outcome.OUTWARD
        mixed = any(len(cone.twists) > 1 for cone, step in zip(self.cones, choices, strict=True) if _has_no_gain(step))
        return Outcome.INWARD if side < 0 and not mixed else Outcome.OPEN

    def _crossings(self, cone: Cone, sense: int) -> list[Crossing]:
        crossings = (self._crossing(cone, twist, sense) for twist in cone.twists)
        return [step for step in crossings if step is not None]

    def _crossing(self, cone: Cone, twist: Vector, sense: int) -> Crossing | None:
        """How a motion crosses a cone, or None; along its circle ``c x v + omega |c|^2 / 2`` does not change.

        So ``(r x v) s + (omega |r|^2 / 2) s^2`` is the same at the entry and at the exit.
        """
        ends = [self.points[cone.start], self.points[cone.end]]
        entry, exit_ray = ends[::sense]
        entering, leaving = cross(entry, twist), cross(exit_ray, twist)
        before, after = sense * entering.sign(), sense * leaving.sign()
        bend = sense * twist[2].sign()
        if before > 0 and after > 0:
            return Crossing(Fraction(1), (entering, leaving))
        if bend <= 0 or before < 0 or after < 0:
            return None
        if before > 0:
            return Crossing(Fraction(1, 2))
        if after > 0:
            return Crossing(Fraction(2))
        if is_zero(twist[:2]):
            return Crossing(Fraction(1))
        # a half-plane with the velocity along its line: opposite rays, at equal distances
        at_entry, at_exit = dot(entry[:2], exit_ray) * exit_ray[2], dot(exit_ray[:2], exit_ray) * entry[2]
        return Crossing(Fraction(1), (-at_entry, at_exit))


def _has_no_gain(crossings: Sequence[Crossing]) -> bool:
    return any(step.gain is None for step in crossings)


def _slide(ray: Vector, first: Vector, second: Vector) -> Outcome | None:
    """A slide along a ray, or None: ``first`` pushes counterclockwise or not at all, ``second`` clockwise or not.

    With normal parts ``n + s m`` and radial parts r its speed at distance s has the sign of
    ``(n_1 r_2 - n_2 r_1) + s (m_1 r_2 - m_2 r_1)``, or of r where both normal parts vanish for all s.
    """
    (n1, r1), (n2, r2) = ((cross(ray, v), dot(ray, v)) for v in (first, second))
    m1, m2 = first[2], second[2]
    pushes = [n1.sign() or m1.sign(), n2.sign() or m2.sign()]
    if pushes[0] < 0 or pushes[1] > 0:
        return None
    if pushes == [0, 0]:
        return SLIDE_OUTCOMES[r1.sign()]
    speed = (n1 * r2 - n2 * r1).sign() or (m1 * r2 - m2 * r1).sign()
    return SLIDE_OUTCOMES[speed]


def _most_growth(crossings: Sequence[Crossing]) -> Crossing:
    """Of the lowest order, and then of the largest gain."""
    lowest = min(step.order for step in crossings)
    best, *others = [step for step in crossings if step.order == lowest]
    for step in others:
        if best.gain is not None and step.gain is not None:
            inverse = Crossing(lowest, (best.gain[1], best.gain[0]))
            best = step if _side_of_one([step, inverse]) > 0 else best
    return best


def _side_of_one(steps: Sequence[Crossing]) -> int:
    """Sign of the product of gains less one; zero, which decides nothing, where a crossing has no gain."""
    gains = [step.gain for step in steps if step.gain is not None]
    if len(gains) < len(steps):
        return 0
    above, below = gains[0]
    for a, b in gains[1:]:
        above, below = above * a, below * b
    return (above - below).sign() * below.sign()
