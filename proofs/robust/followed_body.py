"""The body that starts at the checked point of an array with cells, followed in balls until it is far away.

In a cell with one motion, ``c' = v + omega J c``, a body from ``c_0`` is at ::

    c(t) = c_0 + t sinc(omega t/2) R(omega t/2) (v + omega J c_0)

at the time t, R the rotation by an angle.  It is followed in steps of time.  On a whole step, as a ball, each side of
the cell is away from it, or its distance from the side rises or falls; so a body leaves through the side whose distance
falls below zero, at a time that bisection finds.  There one other cell meets the first one.  Let n be the normal of the
side, out of the first cell, and a and b the speeds along n of its motion and of the other's:

- ``a, b > 0``: the body goes on in the other cell;
- ``a > 0 > b``: it slides between them, with ``(a f_B - b f_A)/(a - b)`` for the velocities ``f_A, f_B``, as long as
  both signs last.

Where a vanishes first, the body goes on in the first cell, along the side at first, as the other motion leads into
it; where b does, in the other one.  In all cases no other solution goes on from there.  Where a sign is not shown, and
at corners of cells, the body is not followed farther.  What is shown holds for every array of which the balls hold the
numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from flint import arb, ctx, fmpq

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import Cell, RefusalError
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.enclosures import enclosure

PRECISION = 128  # bits of the balls
PARTS = 8  # steps on the way out, at least
FINEST = 2.0**-40  # of a first step: no step is as short
MOST_STEPS = 400
BISECTIONS = 100  # of the time at which a body leaves a cell

Vector: TypeAlias = tuple[arb, arb]


@dataclass(frozen=True)
class _Side:
    """The half-plane ``n . c <= offset`` behind a side of a cell."""

    normal: Vector
    offset: arb

    def slack(self, c: Vector) -> arb:
        """``offset - n . c``: positive inside."""
        return self.offset - _dot(self.normal, c)


@dataclass(frozen=True, eq=False)
class _Cell:
    """A cell with its motion, which holds numbers that are none where there are several."""

    sides: tuple[_Side, ...]
    motion: tuple[arb, arb, arb]  # (v_x, v_y, omega)

    @classmethod
    def of(cls, cell: Cell) -> _Cell:
        """In balls."""
        sides = (
            _Side((enclosure(s.normal[0]), enclosure(s.normal[1])), enclosure(s.offset)) for s in cell.polygon.sides
        )
        vx, vy, omega = (entry.ball() for entry in cell.twists[0]) if len(cell.twists) == 1 else [arb(math.nan)] * 3
        return cls(tuple(sides), (vx, vy, omega))

    def velocity(self, c: Vector) -> Vector:
        """Of its motion, at a place."""
        vx, vy, omega = self.motion
        return vx - omega * c[1], vy + omega * c[0]

    def after(self, c: Vector, time: arb) -> Vector:
        """Where its motion takes a body from a place."""
        (ux, uy), half = self.velocity(c), self.motion[2] * time / 2
        length, cos, sin = time * half.sinc(), half.cos(), half.sin()
        return c[0] + length * (cos * ux - sin * uy), c[1] + length * (sin * ux + cos * uy)

    def may_hold(self, c: Vector) -> bool:
        """Whether a place is not known to be outside."""
        return not any(side.slack(c) < 0 for side in self.sides)

    def leads_in(self, c: Vector) -> bool:
        """Whether its motion leads from a place inside, or on its border, into it."""
        near = [side for side in self.sides if not side.slack(c) > 0]
        return all(_dot(side.normal, self.velocity(c)) < 0 for side in near)

    def passed(self, place: Vector, start: float, end: float) -> list[_Side] | None:
        """The side that a body from a place passes between two times, if any; None where that is not shown.

        At the first time it is in the closed cell.
        """
        between, last = self.after(place, arb(start).union(arb(end))), self.after(place, arb(end))
        velocity, found = self.velocity(between), list[_Side]()
        (x, y), omega = velocity, self.motion[2]
        for side in self.sides:
            rate = -_dot(side.normal, velocity)  # of the slack, which is not negative at first
            if side.slack(between) > 0 or rate > 0 or (rate < 0 and side.slack(last) > 0):
                continue
            if not start and not side.slack(place) > 0 and -_dot(side.normal, (-omega * y, omega * x)) > 0:
                continue  # it begins on the side, along it or away from it, and turns away
            if not (rate < 0 and side.slack(last) < 0):
                return None
            found.append(side)
        return found if len(found) < 2 else None

    def moment(self, place: Vector, side: _Side, start: float, end: float) -> arb:
        """When it passes a side, whose slack falls from the first time to the second."""
        for _ in range(BISECTIONS):
            middle = (start + end) / 2
            slack = side.slack(self.after(place, arb(middle)))
            if not (slack > 0 or slack < 0) or middle in (start, end):
                break
            start, end = (middle, end) if slack > 0 else (start, middle)
        return arb(start).union(arb(end))

    def side_at(self, c: Vector) -> _Side | None:
        """The side on which a place of the border may be; None where that is not one."""
        near = [side for side in self.sides if not side.slack(c) > 0]
        return near[0] if len(near) == 1 else None


def is_carried_out(scene: Scene, accuracy: Fraction) -> bool:
    """Whether a body that starts at a centred scene's point comes farther from it than the accuracy.

    Args:
        scene: centred, without an outline, under a rule with cells.
        accuracy: a length.
    """
    if scene.field.rational(accuracy * (1 + Fraction(1, 2**20))) > scene.check.radius:
        return False
    try:
        cells = build_partition(scene).cells
    except RefusalError:
        return False
    with ctx.workprec(PRECISION):
        far = arb(fmpq(accuracy.numerator, accuracy.denominator))
        return _Followed([_Cell.of(cell) for cell in cells], far).leaves()


class _Followed:
    """A body on its way.

    Args:
        cells: all of them.
        far: the distance from the origin that it is to exceed.
    """

    def __init__(self, cells: Sequence[_Cell], far: arb) -> None:
        self._cells, self._far, self._steps = cells, far, MOST_STEPS

    def leaves(self) -> bool:
        """Whether a body comes as far that begins at the origin, with the motion of a cell or between two."""
        origin = arb(0), arb(0)
        around = self._around(origin)
        if any(cell.leads_in(origin) and self._leaves_from(origin, cell) for cell in around):
            return True
        return len(around) == 2 and self._slides_out(origin, *around)

    def _leaves_from(self, place: Vector, cell: _Cell) -> bool:
        """Whether a body comes as far that goes on from a place with the motion of a cell."""
        while True:
            found = self._to_border(cell, place)
            if found is None or self._is_far(found[1]):
                return found is not None
            side, place = found
            others = [other for other in self._around(place) if other is not cell]
            if len(others) != 1:
                return False
            (other,) = others
            if not (other.side_at(place) and _dot(side.normal, other.velocity(place)) > 0):
                return self._slides_out(place, cell, other)
            cell = other

    def _around(self, place: Vector) -> list[_Cell]:
        """The cells that may hold a place."""
        return [cell for cell in self._cells if cell.may_hold(place)]

    def _is_far(self, place: Vector) -> bool:
        return bool(_dot(place, place) > self._far * self._far)

    def _to_border(self, cell: _Cell, place: Vector) -> tuple[_Side, Vector] | None:
        """Through which side a body leaves its cell, and where; None where that is not shown.

        Of a body that is far away before that it is where it is then, with any side.
        """
        speed = float(_dot(*[cell.velocity(place)] * 2).sqrt())
        first = float(self._far) / speed / PARTS if speed else 0.0
        start, step = 0.0, first
        while self._steps and step > first * FINEST:
            self._steps -= 1
            end = start + step
            passed = cell.passed(place, start, end)
            if passed is None:
                step /= 2
            elif passed:
                return passed[0], cell.after(place, cell.moment(place, passed[0], start, end))
            elif self._is_far(cell.after(place, arb(end))):
                return cell.sides[0], cell.after(place, arb(end))
            else:
                start = end
        return None

    def _slides_out(self, place: Vector, cell: _Cell, other: _Cell) -> bool:
        """Whether a body between two cells slides so far, or leaves the slide and comes so far in one of them."""
        side, entered = cell.side_at(place), other.side_at(place)
        if side is None or entered is None:
            return False
        slide = _Slide(cell, other, side, entered, place)
        direction, first = slide.direction, float(self._far) / slide.length / PARTS
        last, into = slide.end(direction)
        start, step = 0.0, first
        while direction and self._steps and step > first * FINEST:
            self._steps -= 1
            end = start + step
            is_last = not last > end
            shares = arb(start).union(last if is_last else arb(end))
            if not slide.lasts(direction * shares, direction, into if is_last else None):
                step /= 2
                continue
            place = slide.at(direction * (last if is_last else arb(end)))
            if self._is_far(place):
                return True
            if is_last:
                return into is not None and self._leaves_from(place, into)
            start = end
        return False


@dataclass(frozen=True)
class _Slide:
    """A slide on the side of a cell, from a place; on the other cell the side is another one."""

    cell: _Cell
    other: _Cell
    side: _Side
    entered: _Side
    place: Vector

    @property
    def _along(self) -> Vector:
        a, b = self.side.normal
        return -b, a

    @property
    def length(self) -> float:
        """Of the vector along the side."""
        return float(_dot(self._along, self._along).sqrt())

    @property
    def direction(self) -> int:
        """1 or -1, along that vector or against it; 0 where that is not shown."""
        speed = self._speeds(self.place)[2]
        return int(speed > 0) - int(speed < 0)

    def at(self, share: arb) -> Vector:
        """The place a multiple of that vector away."""
        a, b = self._along
        return self.place[0] + share * a, self.place[1] + share * b

    def _speeds(self, c: Vector) -> tuple[arb, arb, arb]:
        """The speeds a and b over the side, and ``a - b`` times that of the slide."""
        before, after = self.cell.velocity(c), self.other.velocity(c)
        a, b = _dot(self.side.normal, before), _dot(self.side.normal, after)
        return a, b, a * _dot(self._along, after) - b * _dot(self._along, before)

    def end(self, direction: int) -> tuple[arb, _Cell | None]:
        """At which multiple of that vector one of the speeds over the side vanishes, and the cell of its motion.

        The body goes on in that cell, along the side at first, as the other motion leads into it.
        """
        ends: list[tuple[arb, _Cell]] = []
        here, there = self._speeds(self.place), self._speeds(self.at(arb(direction)))
        for first, second, cell in zip(here, there, (self.cell, self.other), strict=False):
            if first * (second - first) < 0:
                ends.append((first / (first - second), cell))
        if len(ends) == 2 and not ends[0][0] < ends[1][0]:
            ends.reverse()
        if not ends or (len(ends) == 2 and not ends[0][0] < ends[1][0]):
            return arb(math.inf), None
        return ends[0]

    def lasts(self, shares: arb, direction: int, into: _Cell | None) -> bool:
        """Whether it goes on in a direction at all these places, beside no third cell.

        Args:
            shares: multiples of that vector.
            direction: of the slide.
            into: the cell whose speed over the side is known to vanish at the last of them; None where none does.
        """
        c = self.at(shares)
        a, b, speed = self._speeds(c)
        borders = ((self.cell, self.side), (self.other, self.entered))
        is_alone = all(side.slack(c) > 0 for cell, own in borders for side in cell.sides if side is not own)
        is_held = (a > 0 or into is self.cell) and (b < 0 or into is self.other)
        return bool(is_held and direction * speed > 0) and is_alone


def _dot(a: Vector, b: Vector) -> arb:
    return a[0] * b[0] + a[1] * b[1]
