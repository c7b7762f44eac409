"""Sliding along an edge with constant twists on both sides: closed forms by equivalent control.

Along a ray ``s' |r|^2 = (A + B s)/(C + D s)`` (:mod:`nonsmooth.analysis.cells.moves`) and ``theta' = K/(C + D s)`` with
``K = n_1 omega_2 - n_2 omega_1``: time and rotation as functions of s are integrals of rational functions, logarithms.
With w = 0 every formula is rational, so exact numbers stay exact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple

from nonsmooth.analysis.cells.cell_complex import AtCorner, OnEdge
from nonsmooth.analysis.cells.moves import EXACT, RaySpeeds, Signs, ray_speeds, sliding
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.fields.convex_weights import least_mix
from nonsmooth.analysis.trajectories.cell_motion import State
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import dot, minus

# ---- the edges and cells that meet at a point of an edge or at a corner --------------------------
#
# And the signs by which paths decide there.
#
# What motions do around the point is that of :mod:`nonsmooth.analysis.cells.moves`; here is added what a path must know
# besides: which edge a ray is, how far it reaches, and where the domain ends.


# Relative to the largest speed in the domain: directions and velocities err by a few 2^-53, so a smaller normal
# speed is a tangent one.
SPEED_SLACK = 2.0**-45
# Relative: a gain nearer to one than this is not told from one; the series would need more than 1e12 turns.
GAIN_DOUBT = 1e-12


class Ray(NamedTuple):
    """An edge seen from a point on it: direction away from the point, cells beside it, distance to its end."""

    edge: int
    direction: Point
    left: int
    right: int
    reach: Any
    corner: int


@dataclass(frozen=True)
class Junction:
    """A point on an edge or at a corner with its fan.

    Attributes:
        cells: each closed cell at the point, with the sides it is active on and whether they border the domain.
    """

    point: Point
    cells: tuple[tuple[int, tuple[tuple[int, bool], ...]], ...]
    rays: tuple[Ray, ...]
    border: bool


def signs_of(field: ConstantField) -> Signs:
    """Exact for a field of exact numbers; for floats, zero within their rounding."""
    if field.exact:
        return EXACT
    speed, turn, rate = (SPEED_SLACK * scale for scale in (field.speed_scale, field.turn_scale, field.rate_scale))
    return Signs(speed, turn, rate, speed * field.speed_scale, turn * field.speed_scale, GAIN_DOUBT)


def junction_at(field: ConstantField, place: OnEdge | AtCorner, point: Point) -> Junction:
    """The fan at a point of an edge or at a corner."""
    cells = field.cells
    own: tuple[tuple[int, tuple[tuple[int, bool], ...]], ...]
    if isinstance(place, OnEdge):
        edge = cells.edges[place.edge]
        own = tuple((cell, ((cells.side_of(cell, place.edge), len(edge.cells) < 2),)) for cell in edge.cells)
        return Junction(point, own, tuple(_rays(field, place.edge, point)), len(edge.cells) < 2)
    corner = cells.corners[place.corner]
    own = tuple(
        (cell, tuple((k, _is_border(field, cell, k)) for k in cells.active_sides(cell, place.corner)))
        for cell in corner.cells
    )
    rays = chain.from_iterable(_rays(field, number, point, place.corner) for number in corner.edges)
    border = any(len(cells.edges[number].cells) < 2 for number in corner.edges)
    return Junction(point, own, tuple(rays), border)


def _is_border(field: ConstantField, cell: int, side: int) -> bool:
    return all(len(field.cells.edges[e].cells) < 2 for e in field.cells.borders[cell][side])


def _rays(field: ConstantField, number: int, point: Point, source: int | None = None) -> Iterator[Ray]:
    """The edge towards each of its corners other than the source; edges on the border of the domain have none."""
    edge = field.cells.edges[number]
    if edge.left is None or edge.right is None:
        return
    r = field.cells.direction(number)
    for corner in (edge.end, edge.start):
        if corner == source:
            continue
        forward = corner == edge.end
        direction = r if forward else (-r[0], -r[1])
        beside = (edge.left, edge.right) if forward else (edge.right, edge.left)
        reach = dot(direction, minus(field.cells.points[corner], point)) / dot(direction, direction)
        yield Ray(number, direction, *beside, reach, corner)


# ---- slides --------------------------------------------------------------------------------------


# Relative to the products compared: normal speeds whose quotient is constant to this vanish at one point together.
PROPORTIONAL_DOUBT = 1e-12
# Relative: a slide whose end lies this near its asymptote never reaches it; below, the logarithm holds no digits.
ASYMPTOTE_DOUBT = 1e-12
SERIES_BELOW = 0.1  # |x| for which (x - log(1 + x))/x^2 is summed as a series: 18 terms leave 1e-18
SERIES_TERMS = 18
INVERSION_STEPS = 60  # bisection alone gains 60 bits of the position; Newton's method ends far earlier


@dataclass(frozen=True)
class Slide:
    """Sliding from ``point`` along ``direction``; ``reach`` is the position s at which it ends.

    Attributes:
        beside: the speeds of the left and the right cell on the ray.
        coefficients: ``A, B, C, D, K``, with ``C + D s > 0`` inside the slide.
        share: weight of the left cell where it does not follow from the normals, because both vanish together.
        free: whether the weights are not determined: both cells move along the line, differently.
        stop: equilibrium of the sliding motion that is approached and never reached, as a position.
    """

    point: Point
    theta: Any
    direction: Point
    beside: tuple[RaySpeeds, RaySpeeds]
    coefficients: tuple[Any, Any, Any, Any, Any]
    share: Any | None
    free: bool
    reach: Any
    stop: Any | None

    def duration(self) -> Any | None:
        """Time to the end; None where the motion only approaches an equilibrium."""
        return None if self.stop is not None else self.time_to(self.reach)

    def weights(self, position: Any) -> tuple[Any, Any]:
        """Convex weights of the left and the right cell at a position."""
        if self.share is not None:
            return self.share, 1 - self.share
        left, right = (speeds.normal + speeds.bend * position for speeds in self.beside)
        share = right / (right - left)
        return share, 1 - share

    def state(self, time: Any) -> State:
        """``(x, y, theta)`` after ``time``; near an asymptote theta follows from the time, not from the position."""
        s = self.position(time)
        if self.stop is None:
            return self.at(s)
        a, b, c, d, k = self.coefficients
        r = self.direction
        theta = self.theta + k * (b * time - dot(r, r) * d * s) / (b * c - a * d)
        return self.point[0] + s * r[0], self.point[1] + s * r[1], theta

    def at(self, s: Any) -> State:
        """``(x, y, theta)`` at a position."""
        a, b, _, _, k = self.coefficients
        r = self.direction
        theta = self.theta + dot(r, r) * k * s / a * _logarithm(b * s / a)
        return self.point[0] + s * r[0], self.point[1] + s * r[1], theta

    def position(self, time: Any) -> Any:
        """Position s after ``time``."""
        a, b, c, d, _ = self.coefficients
        length = dot(self.direction, self.direction)
        if not d:
            if not b:
                return a * time / (c * length)
            return a / b * math.expm1(b * time / (c * length))
        low, high = 0.0, float(self.reach if self.stop is None else self.stop)
        s = min(a * time / (c * length), high) if c else high / 2
        for _ in range(INVERSION_STEPS):
            error = self.time_to(s) - time
            if error > 0:
                high = s
            else:
                low = s
            guess = s - error * (a + b * s) / ((c + d * s) * length) if c + d * s > 0 and error < math.inf else math.nan
            following = guess if low < guess < high else (low + high) / 2
            if following == s:
                break
            s = following
        return s

    def time_to(self, s: Any) -> Any:
        """Time to a position: ``|r|^2`` times the integral of ``(C + D s)/(A + B s)``."""
        a, b, c, d, _ = self.coefficients
        length, x = dot(self.direction, self.direction), b * s / a
        if x <= -1:
            return math.inf
        linear = length * c * s / a * _logarithm(x)
        return linear + length * d * s * s / a * _second_logarithm(x) if d else linear


def slide_along(field: ConstantField, point: Point, theta: Any, ray: Ray, signs: Signs) -> Slide | None:
    """The sliding motion away from a point along a ray, where there is one."""
    flows = field.flows[ray.left][0], field.flows[ray.right][0]
    left, right = (_cleaned(ray_speeds(ray.direction, flow.about(point)), signs) for flow in flows)
    pushes = left.push(signs), right.push(signs)
    if pushes[0] * pushes[1] > 0:
        return None
    omegas, free = (flows[0].omega, flows[1].omega), False
    share = _constant_share(left, right) if any(pushes) else None
    if not any(pushes):
        free = flows[0] != flows[1]
        share = least_mix(*((*flow.velocity(point), flow.omega) for flow in flows))
    if share is not None:
        zero = share * 0
        speed, rate = (share * x + (1 - share) * y for x, y in ((left.radial, right.radial), omegas))
        parts = (speed, zero, zero + 1, zero, rate)
    elif pushes[0] < pushes[1]:
        parts = (*sliding(right, left), right.normal * omegas[0] - left.normal * omegas[1])
    else:
        parts = (*sliding(left, right), left.normal * omegas[1] - right.normal * omegas[0])
    if signs(parts[0], signs.product_slack if share is None else signs.speed_slack) <= 0:
        return None
    reach = ray.reach
    for normal, bend, _ in (left, right):
        if sign(normal) * sign(bend) < 0:
            reach = min(reach, -normal / bend)
    stop = _stopping_place(parts, reach)
    return Slide(point, theta, ray.direction, (left, right), parts, share, free, reach, stop)


def _cleaned(speeds: RaySpeeds, signs: Signs) -> RaySpeeds:
    """Speeds without the rounding of the normal one, where that vanishes within rounding."""
    return speeds if signs(speeds.normal, signs.speed_slack) else speeds._replace(normal=speeds.normal * 0)


def _constant_share(left: RaySpeeds, right: RaySpeeds) -> Any | None:
    """The left cell's weight where both normal speeds vanish at one point of the line, so that it is constant.

    Mirror images do: there the slide passes from attracting to repelling without losing its speed.
    """
    (n1, b1, _), (n2, b2, _) = left, right
    if not b1 and not b2:
        return None
    first, second = n1 * b2, n2 * b1
    if abs(first - second) > PROPORTIONAL_DOUBT * (abs(first) + abs(second)):
        return None
    return n2 / (n2 - n1) if n2 - n1 else b2 / (b2 - b1)


def _stopping_place(coefficients: tuple[Any, Any, Any, Any, Any], reach: Any) -> Any | None:
    """Position where ``A + B s`` vanishes before (or at) the end of a slide."""
    a, b, *_ = coefficients
    if not b or sign(a) * sign(b) > 0:
        return None
    stop = -a / b
    return stop if stop <= reach * (1 + ASYMPTOTE_DOUBT) else None


def _logarithm(x: Any) -> Any:
    """``log(1 + x)/x``, one at zero."""
    return math.log1p(x) / x if x else 1


def _second_logarithm(x: Any) -> Any:
    """``(x - log(1 + x))/x^2``, one half at zero."""
    if abs(x) < SERIES_BELOW:
        return sum((-x) ** k / (k + 2) for k in range(SERIES_TERMS))
    return (x - math.log1p(x)) / (x * x)
