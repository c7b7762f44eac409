"""Paths of rule ``nearest`` close to a point, by the definitions alone: an oracle for verdicts about translation.

Nothing here knows of cones, fans, gains or Lyapunov functions.  At a point the wheels are ordered by distance and rows
are taken greedily (the rule as the paper states it); the twist solves three rows; the body moves on the exact circle of
its twist until the order of distances changes; on such a line the velocities of both sides decide whether it crosses,
slides (Filippov's convex combination) or may leave to either side.  All numbers are 512-bit, so starts as close as
1e-40 and several hundred events keep their digits; data that are exactly zero stay exactly zero, because they are
formed from fractions first.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from typing import Any, NamedTuple, TypeAlias

import flint

BITS = 512
TINY = flint.arb(2) ** -300  # below any distance met: smaller values are rounding of an exact zero
NEAR = flint.arb(10) ** -6  # of the point: the paths start within 1e-30 of it, and have left it beyond this
ARRIVED = flint.arb(10) ** -75
SAME_RATIO = flint.arb(10) ** -18  # two turns, or one turn and 1, that differ by less do not differ
MOST_EVENTS = 400

Vector: TypeAlias = tuple[Any, Any]


class Wheel(NamedTuple):
    """A wheel in fractions, seen from the checked point; the direction has length one."""

    position: tuple[Fraction, Fraction]
    direction: tuple[Fraction, Fraction]
    speed: Fraction
    roll: Fraction
    side: Fraction


class Twist(NamedTuple):
    """Velocity of the point and rate of rotation."""

    vx: Fraction
    vy: Fraction
    omega: Fraction


class End(Enum):
    """What a path does."""

    ARRIVES = "arrives"
    RESTS = "rests beside the point"
    CYCLES = "returns to where it was"
    LEAVES = "leaves"
    UNCLEAR = "unclear"


@dataclass(frozen=True)
class Line:
    """``f_n - f_m = offset + slope . c``, positive where wheel m is nearer than wheel n."""

    slope: tuple[Fraction, Fraction]
    offset: Fraction

    def at(self, point: Vector) -> Any:
        """Value at a point."""
        offset, a, b = self._balls
        return offset + a * point[0] + b * point[1]

    def along(self, vector: Vector) -> Any:
        """Derivative in a direction."""
        _, a, b = self._balls
        return a * vector[0] + b * vector[1]

    @cached_property
    def _balls(self) -> tuple[Any, Any, Any]:
        return as_arb(self.offset), as_arb(self.slope[0]), as_arb(self.slope[1])


def as_arb(value: Fraction) -> Any:
    """The ball of a fraction."""
    return flint.arb(flint.fmpq(value.numerator, value.denominator))


def _sign(value: Any) -> int:
    if value > TINY:
        return 1
    return -1 if value < -TINY else 0


def _unit_sign(value: Any, scale: Any) -> int:
    """Sign of a value that is exactly zero or at least of the order of ``scale``, up to rounding."""
    if abs(value) <= scale * TINY:
        return 0
    return 1 if value > 0 else -1


class NearestArray:
    """The literal rule for an array given in fractions."""

    def __init__(self, wheels: Sequence[Wheel]) -> None:
        self.wheels = list(wheels)
        self.rows = [self._rows(wheel) for wheel in self.wheels]
        self.twists: dict[tuple[int, ...], tuple[Twist, ...]] = {}
        self.lines: dict[tuple[int, int], Line] = {}

    def _rows(self, wheel: Wheel) -> dict[str, tuple[Fraction, ...]]:
        (px, py), (dx, dy) = wheel.position, wheel.direction
        nx, ny = -dy, dx
        # v(p) = v + omega J p with J p = (-py, px)
        roll = (dx, dy, -dx * py + dy * px, wheel.speed)
        side = (nx, ny, -nx * py + ny * px, Fraction(0))
        return {"roll": roll, "side": side}

    def line(self, near: int, far: int) -> Line:
        """The line on which two wheels are equally near; positive where ``near`` is nearer."""
        if (near, far) not in self.lines:
            (ax, ay), (bx, by) = self.wheels[near].position, self.wheels[far].position
            line = Line((2 * (ax - bx), 2 * (ay - by)), bx * bx + by * by - ax * ax - ay * ay)
            self.lines[near, far] = line
        return self.lines[near, far]

    def order(self, point: Vector, step: Vector) -> tuple[int, ...]:
        """The wheels by distance just beside the point, in the direction of the step."""
        indices = list(range(len(self.wheels)))

        def nearer(a: int, b: int) -> bool:
            line = self.line(a, b)
            value = _sign(line.at(point)) or _sign(line.along(step) / (abs(step[0]) + abs(step[1])))
            return value > 0 or (value == 0 and a < b)

        ranked: list[int] = []
        for index in indices:
            place = next((k for k, other in enumerate(ranked) if nearer(index, other)), len(ranked))
            ranked.insert(place, index)
        return tuple(ranked)

    def motions(self, order: tuple[int, ...]) -> tuple[Twist, ...]:
        """The twists of the greedy choice of rows; two where the frictions of the third row tie."""
        if order not in self.twists:
            self.twists[order] = self._motions(order)
        return self.twists[order]

    def _motions(self, order: tuple[int, ...]) -> tuple[Twist, ...]:
        taken: list[tuple[Fraction, ...]] = []
        for index in order:
            wheel = self.wheels[index]
            names = ["roll", "side"] if wheel.roll >= wheel.side else ["side", "roll"]
            candidates = [self.rows[index][name] for name in names]
            if len(taken) == 2 and wheel.roll == wheel.side:
                free = [row for row in candidates if _is_independent([*taken, row])]
                if free:
                    return tuple(dict.fromkeys(_solve([*taken, row]) for row in free))
                continue
            for row in candidates:
                if len(taken) < 3 and _is_independent([*taken, row]):
                    taken.append(row)
            if len(taken) == 3:
                return (_solve(taken),)
        raise ValueError("the rows do not determine a twist")

    def lines_near_the_point(self) -> list[Line]:
        """The lines through the point on which the order of distances changes."""
        pairs = combinations(range(len(self.wheels)), 2)
        return [line for line in (self.line(a, b) for a, b in pairs) if not line.offset and any(line.slope)]


def _determinant(rows: Sequence[tuple[Fraction, ...]]) -> Fraction:
    (a, b, c, *_), (d, e, f, *_), (g, h, i, *_) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def _is_independent(rows: Sequence[tuple[Fraction, ...]]) -> bool:
    if len(rows) == 1:
        return any(rows[0][:3])
    if len(rows) == 2:
        (a, b, c, *_), (d, e, f, *_) = rows
        return any((a * e - b * d, a * f - c * d, b * f - c * e))
    return _determinant(rows) != 0


def _solve(rows: Sequence[tuple[Fraction, ...]]) -> Twist:
    """Cramer's rule."""
    whole = _determinant(rows)
    entries = []
    for column in range(3):
        changed = [tuple(row[3] if k == column else row[k] for k in range(3)) for row in rows]
        entries.append(_determinant(changed) / whole)
    return Twist(*entries)


def velocity(twist: Twist, point: Vector) -> Vector:
    """``c' = v + omega J c``."""
    w = as_arb(twist.omega)
    return as_arb(twist.vx) - w * point[1], as_arb(twist.vy) + w * point[0]


def _mid(point: Vector) -> Vector:
    return point[0].mid(), point[1].mid()


def _size(point: Vector) -> Any:
    return (point[0] * point[0] + point[1] * point[1]).sqrt()


@dataclass(frozen=True)
class Slide:
    """A slide along a line between two twists; ``first`` belongs to the positive side of the line."""

    line: Line
    first: Twist
    second: Twist


class Path:
    """One Filippov path from a start; choices where there are several are drawn by ``rng``."""

    def __init__(self, array: NearestArray, rng: random.Random) -> None:
        self.array = array
        self.rng = rng
        self.returns: dict[tuple[Any, ...], list[Any]] = {}

    def run(self, point: Vector, *, twist: Twist | None = None, slide: Slide | None = None) -> End:
        """Follow the path; it starts with the given motion or slide, or with one that the rule gives there."""
        here = _mid(point)
        if twist is None and slide is None:
            twist = self._twist_inside(here)
        for _ in range(MOST_EVENTS):
            if slide is not None:
                end, here, line = self._follow_slide(here, slide)
            else:
                assert twist is not None
                end, here, line = self._follow_arc(here, twist)
            if end is not None:
                return end
            here = _mid(here)
            size = _size(here)
            if size < ARRIVED:
                return End.ARRIVES
            if size > NEAR:
                return End.LEAVES
            twist, slide = self._beyond(here, line, twist)
            if twist is None and slide is None:
                return End.UNCLEAR
            ended = self._has_returned(line, here, size, twist)
            if ended is not None:
                return ended
        return End.UNCLEAR

    # ---- inside a cell -------------------------------------------------------------------

    def _twist_inside(self, point: Vector) -> Twist:
        """The twist at a point; any of those beside it where it lies on a line."""
        angle = (flint.arb(self.rng.randint(1, 10**9)), flint.arb(self.rng.randint(-(10**9), 10**9)))
        return self.rng.choice(self.array.motions(self.array.order(point, angle)))

    def _follow_arc(self, point: Vector, twist: Twist) -> tuple[End | None, Vector, Any]:
        """To the first line where the order of the wheels changes.

        The arc is ``c = c0 + 2 y (v + w y J v)/(1 + w^2 y^2)`` with ``y = tan(w t/2)/w``: a line is a quadratic in y.
        """
        v, w = velocity(twist, point), as_arb(twist.omega)
        if _size(v) < TINY:
            return End.RESTS, point, None
        turned = (-v[1], v[0])
        best: tuple[Any, Line] | None = None
        for line in self.array.lines_near_the_point():
            value = line.at(point)
            constant = value if _unit_sign(value, flint.arb(1)) else flint.arb(0)
            linear, square = 2 * line.along(v), w * w * constant + 2 * w * line.along(turned)
            for root in _positive_roots(constant, linear, square):
                if best is None or root < best[0]:
                    best = (root, line)
        if best is None:
            return self._half_a_turn(point, twist)
        y, line = best
        scale = 2 * y / (1 + w * w * y * y)
        there = (point[0] + scale * (v[0] + w * y * turned[0]), point[1] + scale * (v[1] + w * y * turned[1]))
        if _size(there) > NEAR:
            return End.LEAVES, there, None
        return None, there, line

    def _half_a_turn(self, point: Vector, twist: Twist) -> tuple[End | None, Vector, Any]:
        """To the opposite point, where the cell turns the body about the point itself; away from it otherwise."""
        if twist.vx or twist.vy:
            return End.LEAVES, point, None
        opposite = (-point[0], -point[1])
        on = [line for line in self.array.lines_near_the_point() if not _sign(line.at(opposite))]
        return (None, opposite, on[0]) if on else (End.CYCLES, opposite, None)

    # ---- on a line -----------------------------------------------------------------------

    def _beyond(self, point: Vector, line: Line, arriving: Twist | None) -> tuple[Twist | None, Slide | None]:
        """What the path does on a line: crosses it, slides, or leaves to either side."""
        normal = (as_arb(line.slope[0]), as_arb(line.slope[1]))
        sides = {}
        for side in (1, -1):
            order = self.array.order(point, (side * normal[0], side * normal[1]))
            sides[side] = self.array.motions(order)
        if arriving is None:  # at the end of a slide
            choices = self._departures(point, line, sides)
            return (self.rng.choice(choices), None) if choices else (None, None)
        coming = 1 if self._normal(line, arriving, point) < 0 else -1
        after = self.rng.choice(sides[-coming])
        if self._normal(line, after, point) == -coming:
            return after, None
        first, second = (arriving, after) if coming > 0 else (after, arriving)
        return None, Slide(line, first, second)

    def _normal(self, line: Line, twist: Twist, point: Vector) -> int:
        return _sign(line.along(velocity(twist, point)))

    def _departures(self, point: Vector, line: Line, sides: dict[int, tuple[Twist, ...]]) -> list[Twist]:
        return [twist for side, twists in sides.items() for twist in twists if self._normal(line, twist, point) == side]

    def _follow_slide(self, point: Vector, slide: Slide) -> tuple[End | None, Vector, Any]:
        """Along the line while the hull of both velocities holds a vector along it."""
        line = slide.line
        along = (-as_arb(line.slope[1]), as_arb(line.slope[0]))
        first, second = velocity(slide.first, point), velocity(slide.second, point)
        n1, n2 = line.along(first), line.along(second)
        r1, r2 = (along[0] * f[0] + along[1] * f[1] for f in (first, second))
        # weights |n2|, |n1| of the two velocities leave nothing across the line
        speed = abs(n2) * r1 + abs(n1) * r2
        if not _sign(n1) and not _sign(n2):
            speed = r1
        way = _sign(speed)
        if not way:
            return End.RESTS, point, None
        outward = _sign(along[0] * point[0] + along[1] * point[1]) * way
        # the same line holds the point itself: inward slides end there unless the slide stops before
        stop = self._end_of_slide(point, slide, (along[0] * way, along[1] * way))
        if stop is None:
            return (End.LEAVES if outward > 0 else End.ARRIVES), point, None
        return None, stop, line

    def _end_of_slide(self, point: Vector, slide: Slide, way: Vector) -> Vector | None:
        """The nearest place ahead, and before the point itself, where a velocity's normal part vanishes."""
        line, turned = slide.line, (-way[1], way[0])
        inward = _sign(way[0] * point[0] + way[1] * point[1]) < 0
        reach = _size(point) / _size(way)
        times = []
        for twist in (slide.first, slide.second):
            start = line.along(velocity(twist, point))
            rate = as_arb(twist.omega) * line.along(turned)
            if _sign(rate) and _sign(start):
                times.append(-start / rate)
        ahead = [t for t in times if t > 0 and (not inward or t < reach * (1 - TINY))]
        if not ahead:
            return None
        t = min(ahead)
        there = (point[0] + t * way[0], point[1] + t * way[1])
        return None if _size(there) > NEAR else there

    # ---- turns ---------------------------------------------------------------------------

    def _has_returned(self, line: Line, point: Vector, size: Any, twist: Twist | None) -> End | None:
        """Compare a crossing with earlier ones of the same ray into the same motion."""
        if twist is None:
            return None
        side = _sign(-as_arb(line.slope[1]) * point[0] + as_arb(line.slope[0]) * point[1])
        seen = self.returns.setdefault((line, side, twist), [])
        seen.append(size)
        if len(seen) < 3:
            return None
        ratio, last = seen[-1] / seen[-2], seen[-2] / seen[-3]
        if ratio > 1 + SAME_RATIO and last > 1 + SAME_RATIO:
            return End.LEAVES
        if ratio < 1 - SAME_RATIO and last < 1 - SAME_RATIO:
            return End.ARRIVES
        return End.CYCLES if abs(ratio - 1) < SAME_RATIO else None


def _positive_roots(constant: Any, linear: Any, square: Any) -> Iterator[Any]:
    """Positive roots of ``constant + linear y + square y^2``; the root at zero of a path that starts on the line."""
    if not _sign_of_exact(constant):
        # a square term that is rounding only: the other root is half a turn away
        if abs(square) > TINY * abs(linear) and _sign_of_exact(linear):
            root = -linear / square
            if root > 0:
                yield root
        return
    if not _sign_of_exact(square):
        if _sign_of_exact(linear):
            root = -constant / linear
            if root > 0:
                yield root
        return
    discriminant = linear * linear - 4 * constant * square
    if not discriminant >= 0:
        return
    # the two stable forms of the roots
    half = -(linear + (discriminant.sqrt() if linear >= 0 else -discriminant.sqrt())) / 2
    for root in (half / square, constant / half if half != 0 else None):
        if root is not None and root > 0:
            yield root


def _sign_of_exact(value: Any) -> int:
    """Sign where values are zero exactly or well above rounding."""
    return 0 if value.contains(0) else (1 if value > 0 else -1)


# ---- many paths ----------------------------------------------------------------------------


def observe(wheels: Sequence[Wheel], *, seed: int, starts: int = 12) -> set[End]:
    """The ends of paths from starts all around the point, on its lines, and along each slide on them."""
    flint.ctx.prec = BITS
    rng = random.Random(seed)
    array = NearestArray(wheels)
    lines = array.lines_near_the_point()
    ends = set[End]()
    for k in range(starts):
        distance = flint.arb(10) ** -rng.choice((30, 36, 40))
        angle = flint.arb(2 * k + rng.random()) / starts
        point = (distance * angle.cos_pi(), distance * angle.sin_pi())
        ends.add(Path(array, rng).run(point))
    for line in lines:
        for side in (1, -1):
            distance = flint.arb(10) ** -rng.choice((30, 36, 40)) * side
            point = (-as_arb(line.slope[1]) * distance, as_arb(line.slope[0]) * distance)
            ends |= _ends_on_line(array, line, point, rng)
    return ends


def _ends_on_line(array: NearestArray, line: Line, point: Vector, rng: random.Random) -> set[End]:
    """Leave the line to either side, and slide along it by every pair of velocities that allows it."""
    normal = (as_arb(line.slope[0]), as_arb(line.slope[1]))
    ends = set[End]()
    beside = []
    for side in (1, -1):
        order = array.order(point, (side * normal[0], side * normal[1]))
        beside.append(array.motions(order))
    every = list(dict.fromkeys([*beside[0], *beside[1]]))
    for first in every:
        for second in every:
            n1, n2 = (_sign(line.along(velocity(t, point))) for t in (first, second))
            if n1 <= 0 <= n2:
                ends.add(Path(array, rng).run(point, slide=Slide(line, first, second)))
    for side, twists in zip((1, -1), beside, strict=True):
        for twist in twists:
            if _sign(line.along(velocity(twist, point))) == side:
                ends.add(Path(array, rng).run(point, twist=twist))
    return ends
