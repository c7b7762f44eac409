"""Arrays whose wheels are built within tolerances, under rule nearest: where all of them bring bodies.

Wheels may differ from those of the subject, each on its own: in both coordinates of the position, the angle of the rim,
the speed and both coefficients of friction.  Where the wheels i and j may be the two nearest, the velocity of the body
is enclosed over all builds of the two; the claim is that it leads inward outside a disc.  Nothing is evidence here but
the numbers of the claim.  All others are whole multiples of 2^-128; whatever is rounded lets wheels be the nearest at
more points, allows more velocities, or asks for more.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import permutations
from math import ceil, isqrt
from typing import Any, TypeAlias

from .intervals import GRID, ONE, ZERO, Interval, Jet, above, interval, mean_value
from .plane import Point, Side, clipped, corners
from .positivity import Proofs
from .theorems import Statement
from .tower import charge
from .wheels import NEAREST, Array
from .work import limit, rational, require, take

MAX_BOUND = 200  # characters of a bound
MAX_RATIO = 1 << 64  # of the radii of both discs, so that all numbers here are about as long as the grid's
QUADRANTS = ((1, 1), (-1, 1), (-1, -1), (1, -1))
SOUND = "tolerances, and bounds within the square"
Pair: TypeAlias = tuple[Interval, Interval]


def show_tolerances(array: Array, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """For every array within the tolerances every Filippov solution that starts near enough ends in a smaller disc.

    Where ``|c0| <= start``, ``|c| <= radius`` from the time ``(start - radius)/rate`` on, c the true centre of mass.

    *Proof.*  Outside the disc, wherever the wheels i and j may be the two nearest, ``c . v <= -rate |c|`` is shown for
    all builds of the two; so it holds for mixtures of velocities too, and ``(c . c)' = 2 c . v``.
    """
    texts = take(hypotheses, "radius start rate")
    require(all(type(text) is str and len(text) <= MAX_BOUND for text in texts), f"at most {MAX_BOUND} characters")
    radius, start, rate = map(rational, texts)
    builds = read_builds(array)
    within = 0 < radius < start and rate > 0 and (array.radius - array.field.rational(start)).sign() >= 0
    require(within, SOUND)
    limit(start < MAX_RATIO * radius, "discs of sizes that differ less")

    @cache
    def motions(i: int, j: int) -> list[Pair]:
        return [motion(builds[i], builds[j], kind) for kind in builds[j].kinds]

    for quadrant, pair, sides in regions(builds, radius, start):
        ends = list(outer_ends(sides))
        for velocity in motions(*pair) if ends else ():
            require(leads_inward(velocity, quadrant, ends, ceil(rate * GRID)), "a rate outside the disc")
    return [{"tolerances": hypotheses}]


def leads_inward(velocity: Pair, quadrant: tuple[int, int], ends: Iterable[Point], rate: int) -> bool:
    """Whether ``c . w <= -rate |c|`` at points, w being that velocity for which ``c . w`` is the largest there."""
    a, b = (component.high if sign > 0 else component.low for component, sign in zip(velocity, quadrant, strict=True))
    changes = [(x * a + y * b, rate * rate * (x * x + y * y)) for x, y, _ in ends]
    return all(change <= 0 and change * change >= least for change, least in changes)


# ---- wheels and motions --------------------------------------------------------------------------


@dataclass(frozen=True)
class WheelTolerance:
    """A wheel with how far it may be from the certificate's.

    Attributes:
        speed: the surface speed.
        rim: both entries of the unit rim direction.
        place: both coordinates of the position.
        sizes: by how much speed, angle (radian), x and y may be off.
        kinds: the rows that may have the larger friction, ``R`` and ``S``.
    """

    speed: Interval
    rim: Pair
    place: Pair
    sizes: tuple[int, int, int, int]
    kinds: str

    def middle(self) -> list[Jet]:
        """Speed, rim and place of the certificate's wheel."""
        return [Jet(value) for value in (self.speed, *self.rim, *self.place)]

    def box(self, before: int) -> list[Jet]:
        """The same over all builds, with slopes in parameters of another wheel and, after ``before`` of these, its own.

        An angle of at most t has a cosine of at least ``1 - t^2/2`` and a sine of at most t.  The slope of a rim (a, b)
        in the angle is (-b, a).
        """
        speed, angle, x, y = (Interval(-size, size) for size in self.sizes)
        cosine = Interval(GRID - (above(angle.size * angle.size) + 1) // 2, GRID)
        a = self.rim[0] * cosine - self.rim[1] * angle
        b = self.rim[0] * angle + self.rim[1] * cosine
        values = self.speed + speed, a, b, self.place[0] + x, self.place[1] + y
        in_speed, in_x, in_y = (ONE, ZERO, ZERO, ZERO), (ZERO, ZERO, ONE, ZERO), (ZERO, ZERO, ZERO, ONE)
        slopes = in_speed, (ZERO, -b, ZERO, ZERO), (ZERO, a, ZERO, ZERO), in_x, in_y
        others = (ZERO,) * 4
        return [Jet(v, others[:before] + slope + others[before:]) for v, slope in zip(values, slopes, strict=True)]


def read_builds(array: Array) -> list[WheelTolerance]:
    """All wheels with the tolerances."""
    require(array.tolerances is not None and array.rule == NEAREST, "tolerances, under rule nearest")
    require(len(array.wheels) > 1, "two wheels at least, which fix the motion")
    sizes = [interval(size).high for size in array.tolerances or ()]
    step, turn, *shares = sizes
    sound = min(sizes) >= 0 and max(shares) < GRID and 2 * turn < GRID
    require(sound and all(wheel.drive is None for wheel in array.wheels.values()), SOUND)
    angle = -(-turn * 355 // 113)  # more than pi times the half turns
    speed, roll, side = shares
    builds = []
    for wheel in array.wheels.values():
        p, q, _ = map(interval, wheel.place)
        a, b, _, u = map(interval, wheel.rows[0])
        along, across = map(interval, wheel.friction)
        require(along.low > 0 and across.low > 0, "friction in both directions")
        kinds = "R" * (along.high * (GRID + roll) >= across.low * (GRID - side))
        kinds += "S" * (across.high * (GRID + side) >= along.low * (GRID - roll))
        builds.append(WheelTolerance(-u, (a, b), (p, q), (above(u.size * speed), angle, step, step), kinds))
    return builds


def motion(first: WheelTolerance, second: WheelTolerance, kind: str) -> Pair:
    """The velocity of the body by both rows of one wheel and one of another, over all builds of the two."""
    charge(4_000)
    middle = _velocity(first.middle(), second.middle(), kind)
    over = _velocity(first.box(0), second.box(4), kind)
    x, y = (mean_value(at.value, jet, first.sizes + second.sizes) for at, jet in zip(middle, over, strict=True))
    return x, y


def _velocity(first: list[Jet], second: list[Jet], kind: str) -> tuple[Jet, Jet]:
    """``v = u_i d_i - omega J p_i``, by ``v(p_i) = u_i d_i`` and ``m . v(p_j) = u_m``.

    So ``omega = (u_m - u_i d_i . m)/(m . J (p_j - p_i))``, with m the second rim and u_m its speed, or with J of it and
    zero; rejected where the rows may be dependent.
    """
    u, a, b, p, q = first
    speed, c, d, r, s = second
    if kind == "S":
        c, d = -d, c
    along = u * (a * c + b * d)
    omega = (speed - along if kind == "R" else -along) / (d * (r - p) - c * (s - q))
    return u * a + omega * q, u * b - omega * p


# ---- where two wheels may be the nearest ---------------------------------------------------------


def regions(
    builds: list[WheelTolerance], radius: Fraction, start: Fraction
) -> Iterator[tuple[tuple[int, int], tuple[int, int], list[Side]]]:
    """Where in each quadrant of a square two wheels may be the two nearest: their numbers, and the sides of a polygon.

    Lengths are in units of the radius, ``start`` is half the side of the square, sides are listed counterclockwise.  A
    polygon without area, which is left out, holds no cell of any array.
    """
    wheels, far = range(len(builds)), ceil(start / radius * GRID)
    for x, y in QUADRANTS:
        square = [(x * GRID, 0, far), (0, y * GRID, far), (-x * GRID, 0, 0), (0, -y * GRID, 0)][:: x * y]
        nearer = {(i, k): nearer_side(builds[i], builds[k], (x, y), radius) for i, k in permutations(wheels, 2)}
        for i in wheels:
            nearest = clipped(square, (nearer[i, k] for k in wheels if k != i))
            for j in wheels if nearest else ():
                second = clipped(nearest, (nearer[j, k] for k in wheels if k not in (i, j))) if j != i else []
                if second:
                    yield (x, y), (i, j), second


def nearer_side(first: WheelTolerance, second: WheelTolerance, quadrant: tuple[int, int], radius: Fraction) -> Side:
    """Where the first wheel may be nearer than the second, in a quadrant.

    With the places p and q and the tolerance t of coordinates ``2 c . (q - p) - 4 t |c|_1`` is at most
    ``|q|^2 - |p|^2 + 2 t (|q|_1 + |p|_1) + 2 t^2``, and ``|c|_1`` is linear in the quadrant.
    """
    charge(300)
    step, slopes = first.sizes[-1], list[int]()
    bound = above(2 * step * step)
    for p, q, sign in zip(first.place, second.place, quadrant, strict=True):
        slope = q - p
        slopes.append(2 * slope.low - 4 * step if sign > 0 else 2 * slope.high + 4 * step)
        bound += (q * q - p * p).high + above(2 * step * (p.size + q.size))
    return slopes[0], slopes[1], ceil(bound / radius)


def outer_ends(sides: list[Side]) -> Iterator[Point]:
    """Ends of the parts of sides outside the unit disc, or points inside, just behind them.

    ``f(c) = c . w + rate |c|`` is convex, so where it is not positive at these it is not on those parts; and what the
    polygon has outside the disc lies behind them, as seen from the point, on the same rays.
    """
    places = corners(sides)
    outside = [x * x + y * y > w * w for x, y, w in places]
    for k, (a, b, c) in enumerate(sides):
        start, end = outside[k - 1], outside[k]
        if start or end:
            charge(100)
            size = a * a + b * b
            half = 0 if start and end else isqrt(size - c * c)  # of the chord, in the sense (-b, a) in which sides go
            yield places[k - 1] if start else (c * a - b * half, c * b + a * half, size)
            yield places[k] if end else (c * a + b * half, c * b - a * half, size)
