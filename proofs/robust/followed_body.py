"""The body that starts at the checked point, followed until it is far away: in balls through cells, else in a funnel.

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
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from flint import arb, ctx

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import Cell, RefusalError
from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.proofs.boxes.balanced_forces import STRENGTHS, BalancedForces
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.enclosures import enclosure
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite, cross, field_beside, norm, norms, turned

PRECISION = 128  # bits of the balls
PARTS = 8  # steps on the way out, at least
FINEST = 2.0**-40  # of a first step: no step is as short
MOST_STEPS = 400
BISECTIONS = 100  # of the time at which a body leaves a cell

Vector: TypeAlias = tuple[arb, arb]


@dataclass(frozen=True, eq=False)
class _Cell:
    """A cell with its motion, which holds numbers that are none where there are several."""

    sides: tuple[HalfPlane, ...]
    motion: tuple[arb, arb, arb]  # (v_x, v_y, omega)

    @classmethod
    def of(cls, cell: Cell) -> _Cell:
        """In balls."""
        sides = (
            HalfPlane((enclosure(s.normal[0]), enclosure(s.normal[1])), enclosure(s.offset)) for s in cell.polygon.sides
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
        return all(dot(side.normal, self.velocity(c)) < 0 for side in near)

    def passed(self, place: Vector, start: float, end: float) -> list[HalfPlane] | None:
        """The side that a body from a place passes between two times, if any; None where that is not shown.

        At the first time it is in the closed cell.
        """
        between, last = self.after(place, arb(start).union(arb(end))), self.after(place, arb(end))
        velocity, crossed_sides = self.velocity(between), list[HalfPlane]()
        (x, y), omega = velocity, self.motion[2]
        for side in self.sides:
            rate = -dot(side.normal, velocity)  # of the slack, which is not negative at first
            if side.slack(between) > 0 or rate > 0 or (rate < 0 and side.slack(last) > 0):
                continue
            if not start and not side.slack(place) > 0 and -dot(side.normal, (-omega * y, omega * x)) > 0:
                continue  # it begins on the side, along it or away from it, and turns away
            if not (rate < 0 and side.slack(last) < 0):
                return None
            crossed_sides.append(side)
        return crossed_sides if len(crossed_sides) < 2 else None

    def moment(self, place: Vector, side: HalfPlane, start: float, end: float) -> arb:
        """When it passes a side, whose slack falls from the first time to the second."""
        for _ in range(BISECTIONS):
            middle = (start + end) / 2
            slack = side.slack(self.after(place, arb(middle)))
            if not (slack > 0 or slack < 0) or middle in (start, end):
                break
            start, end = (middle, end) if slack > 0 else (start, middle)
        return arb(start).union(arb(end))

    def side_at(self, c: Vector) -> HalfPlane | None:
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
        far = rational_ball(accuracy)
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
            arrival = self._to_border(cell, place)
            if arrival is None or self._is_far(arrival[1]):
                return arrival is not None
            side, place = arrival
            others = [other for other in self._around(place) if other is not cell]
            if len(others) != 1:
                return False
            (other,) = others
            if not (other.side_at(place) and dot(side.normal, other.velocity(place)) > 0):
                return self._slides_out(place, cell, other)
            cell = other

    def _around(self, place: Vector) -> list[_Cell]:
        """The cells that may hold a place."""
        return [cell for cell in self._cells if cell.may_hold(place)]

    def _is_far(self, place: Vector) -> bool:
        return bool(dot(place, place) > self._far * self._far)

    def _to_border(self, cell: _Cell, place: Vector) -> tuple[HalfPlane, Vector] | None:
        """Through which side a body leaves its cell, and where; None where that is not shown.

        Of a body that is far away before that it is where it is then, with any side.
        """
        speed = float(dot(*[cell.velocity(place)] * 2).sqrt())
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
    side: HalfPlane
    entered: HalfPlane
    place: Vector

    @property
    def _along(self) -> Vector:
        a, b = self.side.normal
        return -b, a

    @property
    def length(self) -> float:
        """Of the vector along the side."""
        return float(dot(self._along, self._along).sqrt())

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
        a, b = dot(self.side.normal, before), dot(self.side.normal, after)
        return a, b, a * dot(self._along, after) - b * dot(self._along, before)

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
        is_alone = all(side.slack(c) > 0 for cell, border in borders for side in cell.sides if side is not border)
        is_held = (a > 0 or into is self.cell) and (b < 0 or into is self.other)
        return bool(is_held and direction * speed > 0) and is_alone


# ---- rules without cells -------------------------------------------------------------------------
#
# The body that starts at the checked point of an array without cells, followed through a funnel until it is far away.
#
# It may leave a disc though other bodies of the disc do not, or though a wheel lifts elsewhere in the disc.
#
# A funnel is a chain of quadrangles about a path, each with a gate in common with the next one; the first begins in the
# point.  On both other sides let all velocities lead inward, and in all of a quadrangle through the gate to the next
# one, ``m . c' > 0`` for its normal m.  Then a body leaves each by that gate, after a time, and does not come back
# through it. Floats propose the path.  Forces that balance a pull back (:mod:`nonsmooth.proofs.boxes.balanced_forces`)
# bound the velocities: on sides, which are segments, and in quadrangles, which are divided where they are not shown
# whole.


QUADRANGLES = 16  # on the length of the accuracy
DIVISIONS = 4  # times that quadrangles are divided that are not shown whole
MORE = 2.0**-30  # of a part
FAR = 1.125  # accuracies, as far as a funnel goes
SLOPES = (0.125, 0.5, 0.03)  # of its sides, tried in turn
LONGEST = 8  # accuracies, the longest path of one
DIFFERENCE = 2.0**-16  # of the accuracy, over which the field is differentiated
DOUBLINGS = 40  # of a step in time


def leaves_by_funnel(scene: Scene, accuracy: Fraction) -> bool:
    """Whether the body that starts at the point leaves the disc of that radius, inside a funnel.

    Args:
        scene: centred, without an outline, under a rule without cells, with known loads.
        accuracy: the radius.
    """
    forces = BalancedForces.of(scene)
    path = None if forces is None else _path_outward(forces, float(accuracy))
    if forces is None or path is None:
        return False
    ahead = np.diff(path, axis=0, append=2 * path[-1:] - path[-2:-1])
    normals = turned(ahead) / norms(ahead)[:, None]
    widths = np.linspace(0.0, FAR * float(accuracy), len(path))[:, None] * normals
    for slope in SLOPES:
        left, right = path + slope * widths, path - slope * widths
        if _is_beyond(path[-1], (left[-1], right[-1]), accuracy) and _is_passed(forces, left, right):
            return True
    return False


def _path_outward(forces: BalancedForces, radius: float) -> Floats | None:
    """Places of a path from the origin to beyond a radius, in floats; None where it stays within.

    By implicit steps in time that are as long as steps of an even length ask for: bodies come fast to a line along
    which they creep.
    """
    length, places = radius / QUADRANGLES, [np.zeros(2)]
    for _ in range(LONGEST * QUADRANGLES):
        here, slope = field_beside(forces.velocities, places[-1], DIFFERENCE * radius)
        speed = norm(here)
        if not 0 < speed < math.inf or not are_finite(slope):
            return None
        time = length / speed
        move: Any = here
        for _ in range(DOUBLINGS):
            move = np.linalg.solve(np.eye(2) - time * slope, time * here)
            if np.hypot(*move) > length / 2:
                break
            time *= 2
        else:
            return None  # it comes to rest
        places.append(places[-1] + move * min(1.0, length / norm(move)))
        if np.hypot(*places[-1]) > FAR * radius:
            return np.array(places)
    return None


def _is_beyond(towards: Floats, gate: Iterable[Floats], radius: Fraction) -> bool:
    """Whether a gate is farther from the origin than a radius, exactly."""
    a, b = map(Fraction, towards.tolist())
    heights = (a * Fraction(x) + b * Fraction(y) for x, y in map(np.ndarray.tolist, gate))
    return all(height > 0 and height**2 > radius**2 * (a**2 + b**2) for height in heights)


def _is_passed(forces: BalancedForces, left: Floats, right: Floats) -> bool:
    """Whether bodies from the first points of two lines pass all quadrangles between these."""
    to_right, to_left = (np.stack([line[:-1], line[1:], line[1:], line[:-1]], axis=1) for line in (right, left))
    between = np.stack([right[:-1], right[1:], left[1:], left[:-1]], axis=1)
    return (
        _are_convex(between)
        and _lead_left(forces, to_right, right[:-1], right[1:], (2, 1))
        and _lead_left(forces, to_left, left[1:], left[:-1], (2, 1))
        and _lead_left(forces, between, left[1:], right[1:], (2, 2))
    )


def _are_convex(corners: Floats) -> bool:
    """Whether quadrangles, the first of which is a triangle, are convex and counterclockwise, beyond rounding."""
    along = np.roll(corners, -1, axis=1) - corners
    after = np.roll(along, -1, axis=1)
    turns = cross(along, after)
    clear = turns > 2.0**-30 * np.linalg.norm(along, axis=2) * np.linalg.norm(after, axis=2)
    return bool(clear[:, :2].all() and clear[1:].all())


def _lead_left(forces: BalancedForces, corners: Floats, starts: Floats, ends: Floats, parts: tuple[int, int]) -> bool:
    """Whether on each quadrangle all velocities lead to the left of a vector, that from a start to an end.

    Args:
        forces: of the array.
        corners: of the quadrangles (pieces, 4, 2), which may be segments.
        starts: of the vectors (pieces, 2).
        ends: of the vectors (pieces, 2).
        parts: of a quadrangle that is not shown whole, along and across.
    """
    for _ in range(DIVISIONS):
        unit = Intervals.of(1 / norms(ends - starts)[:, None] * np.ones(4))  # any positive factor does
        along_x, along_y = (unit * (Intervals.of(ends[:, k, None]) - Intervals.of(starts[:, k, None])) for k in (0, 1))
        x, y = (Intervals.of(corners[:, :, k]) for k in (0, 1))
        covector = forces.covector(along_y, -along_x, -along_x * x - along_y * y)
        remaining = ~(forces.largest_powers(corners, covector, STRENGTHS) < 0)
        if not remaining.any():
            return True
        corners = _divided(corners[remaining], *parts)
        starts, ends = (np.repeat(points[remaining], parts[0] * parts[1], axis=0) for points in (starts, ends))
    return False


def _divided(corners: Floats, along: int, across: int) -> Floats:
    """Quadrangles that cover others together: parts along, from corner 0 to 1 and from 3 to 2, and across.

    Their corners are rounded: each is a little larger than its part.
    """
    a, b, c, d = (corners[:, k, None] for k in range(4))
    ends = [(np.arange(parts) - MORE, np.arange(1, parts + 1) + MORE) for parts in (along, across)]
    places = []
    for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
        t, s = (grid.reshape(-1, 1) for grid in np.meshgrid(ends[0][i] / along, ends[1][j] / across))
        back, front = a + s * (d - a), b + s * (c - b)
        places.append(back + t * (front - back))
    return np.stack(places, axis=2).reshape(-1, 4, 2)
