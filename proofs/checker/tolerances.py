"""Arrays whose wheels are built within tolerances, under rule nearest: where all of them bring bodies.

Wheels may differ from those of the subject, each on its own: in both coordinates of the position, the angle of the rim,
the speed and both coefficients of friction.  Where the wheels i and j may be the two nearest, the velocity of the body
is enclosed over all builds of the two; the claim is that it leads inward outside a disc.  Nothing is evidence here but
the numbers of the claim: polygons and velocities are computed, in intervals that are rounded outward.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations
from typing import Any, TypeAlias

from .plane import around
from .positivity import Proofs
from .theorems import Statement
from .tower import Number, charge
from .wheels import NEAREST, Array, Wheel
from .work import rational, require, take

GRID = 1 << 128  # intervals end at multiples of its inverse
ABOVE_PI = Fraction(355, 113)
QUADRANTS = ((1, 1), (-1, 1), (-1, -1), (1, -1))
HALVINGS = 40  # of a side, to a point of it just inside a circle
MAX_BOUND = 200  # characters of a bound, so that all numbers here are about as long as the grid's
Point: TypeAlias = tuple[Fraction, Fraction]
HalfPlane: TypeAlias = tuple[Fraction, Fraction, Fraction]  # a, b, c of a x + b y <= c


@dataclass(frozen=True)
class Interval:
    """All numbers from ``low`` to ``high``."""

    low: Fraction
    high: Fraction

    def __add__(self, other: Interval) -> Interval:
        return rounded(self.low + other.low, self.high + other.high)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __sub__(self, other: Interval) -> Interval:
        return self + -other

    def __mul__(self, other: Interval) -> Interval:
        ends = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return rounded(min(ends), max(ends))

    def __truediv__(self, other: Interval) -> Interval:
        require(other.low > 0 or other.high < 0, "a divisor that is not zero")
        return self * rounded(*sorted((1 / other.low, 1 / other.high)))

    @property
    def size(self) -> Fraction:
        """The largest absolute value."""
        return max(-self.low, self.high)


def rounded(low: Fraction, high: Fraction) -> Interval:
    """An interval that holds another, with ends of few digits."""
    return Interval(Fraction(math.floor(low * GRID), GRID), Fraction(math.ceil(high * GRID), GRID))


def exactly(value: int | Fraction) -> Interval:
    """One number."""
    return Interval(Fraction(value), Fraction(value))


def up_to(size: Fraction) -> Interval:
    """All numbers of at most a size."""
    return Interval(-size, size)


NOTHING = exactly(0)


def _interval(number: Number) -> Interval:
    """Bounds of an exact number."""
    low, high = number.enclosure()
    require(max(-low, high) < GRID, "numbers of moderate size")
    return rounded(low, high)


@dataclass(frozen=True)
class Jet:
    """A function's value and its slopes in some parameters, enclosed."""

    value: Interval
    slopes: tuple[Interval, ...]

    def __add__(self, other: Jet) -> Jet:
        return Jet(self.value + other.value, tuple(a + b for a, b in zip(self.slopes, other.slopes, strict=True)))

    def __sub__(self, other: Jet) -> Jet:
        return Jet(self.value - other.value, tuple(a - b for a, b in zip(self.slopes, other.slopes, strict=True)))

    def __mul__(self, other: Jet) -> Jet:
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(self.value * other.value, tuple(a * other.value + self.value * b for a, b in pairs))

    def __truediv__(self, other: Jet) -> Jet:
        ratio = self.value / other.value
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(ratio, tuple((a - ratio * b) / other.value for a, b in pairs))


@dataclass(frozen=True)
class Build:
    """A wheel with how far it may be from the certificate's.

    Attributes:
        place: each coordinate of the position.
        rim: each entry of the unit rim direction.
        speed: the surface speed.
        sizes: half-widths of speed, angle (radian), x and y.
        kinds: the rows that may have the larger friction, ``R`` and ``S``.
    """

    place: tuple[Interval, Interval]
    rim: tuple[Interval, Interval]
    speed: Interval
    sizes: tuple[Fraction, Fraction, Fraction, Fraction]
    kinds: str


class PairMotion:
    """The motion of an ordered pair of wheels: both rows of the first and one of the second, over all their builds.

    ``v(p_i) = u_i d_i`` and ``m . v(p_j) = u_m`` give ``omega = (u_m - u_i d_i . m)/(m . J (p_j - p_i))`` and
    ``v = u_i d_i - omega J p_i``, with m the second rim or J of it.  By the mean value theorem a function over a box is
    its value at the middle and, for each parameter, its slope over the box times what the parameter may change.
    """

    COUNT = 8  # speed, angle, x and y of either wheel

    def __init__(self, first: Build, second: Build, kind: str) -> None:
        self.wheels, self.kind = (first, second), kind

    def velocity(self) -> tuple[Interval, Interval]:
        """``(v_x, v_y)``; rejected where the rows may be dependent."""
        sizes = [size for wheel in self.wheels for size in wheel.sizes]
        middle, whole = self._at([NOTHING] * self.COUNT), self._at([up_to(size) for size in sizes])
        found = []
        for at_middle, over_all in zip(middle, whole, strict=True):
            total = at_middle.value
            for slope, size in zip(over_all.slopes, sizes, strict=True):
                total = total + slope * up_to(size)
            found.append(total)
        return found[0], found[1]

    def _at(self, shifts: list[Interval]) -> tuple[Jet, Jet]:
        u_i, (a, b), (p, q) = self._wheel(0, shifts)
        u_j, (c, d), (r, s) = self._wheel(1, shifts)
        if self.kind == "S":
            (c, d), u_j = (self._constant(NOTHING) - d, c), self._constant(NOTHING)
        omega = (u_j - u_i * (a * c + b * d)) / (d * (r - p) - c * (s - q))
        return u_i * a + omega * q, u_i * b - omega * p

    def _wheel(self, number: int, shifts: list[Interval]) -> tuple[Jet, tuple[Jet, Jet], tuple[Jet, Jet]]:
        wheel, start = self.wheels[number], 4 * number
        speed, angle, x, y = (self._parameter(shifts[start + k], start + k) for k in range(4))
        turn = angle.value.size
        cosine = Jet(Interval(1 - turn * turn / 2, Fraction(1)), tuple(-(angle.value * k) for k in angle.slopes))
        sine = Jet(angle.value, tuple(cosine.value * k for k in angle.slopes))
        a, b, p, q = (self._constant(entry) for entry in (*wheel.rim, *wheel.place))
        return self._constant(wheel.speed) + speed, (a * cosine - b * sine, a * sine + b * cosine), (p + x, q + y)

    def _constant(self, value: Interval) -> Jet:
        return Jet(value, (NOTHING,) * self.COUNT)

    def _parameter(self, value: Interval, number: int) -> Jet:
        return Jet(value, tuple(exactly(int(k == number)) for k in range(self.COUNT)))


def show_tolerances(array: Array, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """For every array within the tolerances every Filippov solution that starts near enough ends in a smaller disc.

    Where ``|c0| <= start``, ``|c| <= radius`` from the time ``(start - radius)/rate`` on, c the true centre of mass.
    For wherever the wheels i and j may be the two nearest, ``c . v <= -rate |c|`` outside the disc, for all builds of
    the two; and ``(c . c)' = 2 c . v``.
    """
    bounds = take(hypotheses, "radius start rate")
    require(all(type(own) is str and len(own) <= MAX_BOUND for own in bounds), f"at most {MAX_BOUND} characters")
    Builds(array, *map(rational, bounds)).show()
    return [{"tolerances": hypotheses}]


class Builds:
    """All arrays whose wheels are built within the tolerances of one, and where they move the body.

    Args:
        array: the one, with rims as friction axes and friction in both directions at all wheels.
        radius: of the disc in which bodies end.
        start: of the disc in which they start.
        rate: at which ``|c|`` falls outside the smaller one.
    """

    def __init__(self, array: Array, radius: Fraction, start: Fraction, rate: Fraction) -> None:
        require(array.tolerances is not None and array.rule == NEAREST, "tolerances, under rule nearest")
        require(len(array.wheels) > 1, "two wheels at least, which fix the motion")
        step, turn, *shares = (_interval(own).high for own in array.tolerances or ())
        self.radius, self.start, self.rate, self.step = radius, start, rate, step
        sound = min(step, turn, *shares) >= 0 and max(shares) < 1 and turn < Fraction(1, 2)
        within = 0 < radius < start and rate > 0 and (array.radius - array.field.rational(start)).sign() >= 0
        own_rims = all(wheel.drive is None for wheel in array.wheels.values())
        require(sound and within and own_rims, "tolerances, and bounds within the square")
        self.builds = [self._build(wheel, turn * ABOVE_PI, shares) for wheel in array.wheels.values()]

    def _build(self, wheel: Wheel, turn: Fraction, shares: Sequence[Fraction]) -> Build:
        speed, roll, side = shares
        p, q, _ = map(_interval, wheel.place)
        a, b, _, u = map(_interval, wheel.rows[0])
        along, across = map(_interval, wheel.friction)
        require(along.low > 0 and across.low > 0, "friction in both directions")
        kinds = "R" * (along.high * (1 + roll) >= across.low * (1 - side))
        kinds += "S" * (across.high * (1 + side) >= along.low * (1 - roll))
        return Build((p, q), (a, b), -u, (u.size * speed, turn, self.step, self.step), kinds)

    def show(self) -> None:
        """Every quadrant of the square, every pair of wheels that may carry there outside the disc."""
        motions: dict[tuple[int, int], list[Any]] = {}
        for quadrant in QUADRANTS:
            for pair, corners in self._cells(quadrant):
                if not any(self._is_outside(corner) for corner in corners):
                    continue
                if pair not in motions:
                    motions[pair] = self._motions(*pair)
                self._check(corners, motions[pair], quadrant)

    def _cells(self, quadrant: tuple[int, int]) -> Iterator[tuple[tuple[int, int], list[Point]]]:
        """Pairs of wheels with a polygon that holds all points of a quadrant at which they may be the two nearest."""
        wheels = range(len(self.builds))
        nearer: list[dict[int, HalfPlane]] = [{} for _ in wheels]
        for i, k in permutations(wheels, 2):
            nearer[i][k] = self._nearer(i, k, quadrant)
        square = self._quadrant(quadrant)
        for i in wheels:
            first = self._clipped(square, nearer[i].values())
            for j in wheels if first else ():
                others = (line for far, line in nearer[j].items() if far != i)
                corners = self._clipped(first, others) if j != i else []
                if corners:
                    yield (i, j), corners

    def _motions(self, i: int, j: int) -> list[Any]:
        second = self.builds[j]
        charge(20_000)
        return [PairMotion(self.builds[i], second, kind).velocity() for kind in second.kinds]

    def _check(self, corners: list[Point], motions: Sequence[Any], quadrant: tuple[int, int]) -> None:
        """In a quadrant ``c . v <= c . w`` with one w, and ``c . w + rate |c|`` is convex along each side.

        Seen from the point, what a convex polygon has outside the disc lies behind its sides' parts outside the disc.
        """
        for motion in motions:
            w = tuple(entry.high if side > 0 else entry.low for entry, side in zip(motion, quadrant, strict=True))
            for a, b in around(corners):
                ends = [self._outer_end(a, b), self._outer_end(b, a)]
                require(all(end is None or self._falls(end, w) for end in ends), "a rate outside the disc")

    def _outer_end(self, a: Point, b: Point) -> Point | None:
        """The end a of a side if it lies outside the disc, else a point inside just before the side leaves it."""
        if self._is_outside(a):
            return a
        if not self._is_outside(b):
            return None
        charge(150 * HALVINGS)
        low, high = Fraction(0), Fraction(1)
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (low, middle) if self._is_outside(_between(a, b, middle)) else (middle, high)
        return _between(a, b, low)

    def _is_outside(self, c: Point) -> bool:
        return c[0] ** 2 + c[1] ** 2 > self.radius**2

    def _falls(self, c: Point, w: Sequence[Fraction]) -> bool:
        """Whether ``c . w <= -rate |c|``."""
        charge(100)
        change = c[0] * w[0] + c[1] * w[1]
        return change <= 0 and change**2 >= self.rate**2 * (c[0] ** 2 + c[1] ** 2)

    def _quadrant(self, quadrant: tuple[int, int]) -> list[Point]:
        far_x, far_y, zero = quadrant[0] * self.start, quadrant[1] * self.start, Fraction(0)
        return [(zero, zero), (far_x, zero), (far_x, far_y), (zero, far_y)][:: quadrant[0] * quadrant[1]]

    def _nearer(self, i: int, k: int, quadrant: tuple[int, int]) -> HalfPlane:
        """``(a, b, c)``: where wheel i may be nearer than k, in a quadrant, ``a x + b y <= c``.

        With t the tolerance of coordinates ``2 c . (p_k - p_i) - 4 t |c|_1 <= |p_k|^2 - |p_i|^2 + 2 t (|p_k|_1 +
        |p_i|_1) + 2 t^2``, and ``|c|_1`` is linear in the quadrant.
        """
        charge(1500)
        near, far, step = self.builds[i].place, self.builds[k].place, self.step
        two, four, bound = exactly(2), exactly(4 * step), exactly(2 * step * step)
        slopes = []
        for a, b, side in zip(near, far, quadrant, strict=True):
            slope = two * (b - a) - (four if side > 0 else -four)
            slopes.append(slope.low if side > 0 else slope.high)
            bound = bound + (b * b - a * a) + exactly(2 * step * (a.size + b.size))
        return slopes[0], slopes[1], bound.high

    def _clipped(self, corners: list[Point], half_planes: Iterable[HalfPlane]) -> list[Point]:
        """The part of a convex polygon in half-planes; empty where no area is left."""
        for a, b, c in half_planes:
            if not corners:
                break
            charge(300 * len(corners))
            above = [a * x + b * y - c for x, y in corners]
            kept: list[Point] = []
            for (p, q), (s, t) in zip(around(corners), around(above), strict=True):
                if s <= 0:
                    kept.append(p)
                if s * t < 0:
                    kept.append(_between(p, q, s / (s - t)))
            corners = kept if len(kept) > 2 else []
        return corners


def _between(a: Point, b: Point, share: Fraction) -> Point:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
