"""Sliding along an edge with constant twists on both sides: closed forms by equivalent control.

Along a ray from p with direction r the neighbours' normal speeds ``N = n + w s |r|^2`` (positive towards the left) are
affine in the position s and their tangential speeds rho are constant, so equivalent control (Filippov 1988, sec. 4)
gives ::

    s' |r|^2 = (A + B s)/(C + D s),     theta' = K/(C + D s)
    A = N_R rho_L - N_L rho_R,  C = N_R - N_L,  K = N_R omega_L - N_L omega_R,  B and D likewise from w |r|^2

whose time and rotation as functions of s are integrals of rational functions: logarithms.  With w = 0 every formula is
rational, so exact numbers stay exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField, Flow
from nonsmooth.analysis.fields.convex_weights import least_mix
from nonsmooth.analysis.trajectories.junction import Ray, Signs
from nonsmooth.analysis.trajectories.motion import State
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import cross, dot

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
        normals: ``(N_L, N_R)`` at the start.
        bends: their derivatives in s, ``turn |r|^2``.
        coefficients: ``A, B, C, D, K``, with ``C + D s > 0`` inside the slide.
        share: weight of the left cell where it does not follow from the normals, because both vanish together.
        free: whether the weights are not determined: both cells move along the line, differently.
        stop: equilibrium of the sliding motion that is approached and never reached, as a position.
    """

    point: Point
    theta: Any
    direction: Point
    normals: Sequence[Any]
    bends: Sequence[Any]
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
        left, right = (n + b * position for n, b in zip(self.normals, self.bends, strict=True))
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
    r, length = ray.direction, dot(ray.direction, ray.direction)
    left, right = field.flows[ray.left][0], field.flows[ray.right][0]
    velocities = (left.velocity(point), right.velocity(point))
    normals = tuple(_cleaned(cross(r, v), signs) for v in velocities)
    along = (dot(r, velocities[0]), dot(r, velocities[1]))
    bends = (left.turn * length, right.turn * length)
    first, second = (signs.first(n, b, signs.turn_slack) for n, b in zip(normals, bends, strict=True))
    if first * second > 0:
        return None
    share, free = _constant_share(normals, bends, (first, second)), False
    if not first and not second:
        free = left != right
        share = least_mix((*velocities[0], left.omega), (*velocities[1], right.omega))
    if share is not None:
        zero = share * 0
        speed, rate = (share * x + (1 - share) * y for x, y in (along, (left.omega, right.omega)))
        parts = (speed, zero, zero + 1, zero, rate)
    else:
        parts = _slide_coefficients(normals, bends, along, (left, right), second - first)
    if signs(parts[0], signs.product_slack if share is None else signs.speed_slack) <= 0:
        return None
    reach = ray.reach
    for normal, bend in zip(normals, bends, strict=True):
        if sign(normal) * sign(bend) < 0:
            reach = min(reach, -normal / bend)
    return Slide(point, theta, r, normals, bends, parts, share, free, reach, _stopping_place(parts, reach))


def _cleaned(speed: Any, signs: Signs) -> Any:
    """A speed without its rounding, where it vanishes within rounding."""
    return speed if signs(speed, signs.speed_slack) else speed * 0


def _constant_share(normals: Sequence[Any], bends: Sequence[Any], order: tuple[int, int]) -> Any | None:
    """The left cell's weight where both normal speeds vanish at one point of the line, so that it is constant.

    Mirror images do: there the slide passes from attracting to repelling without losing its speed.
    """
    (n1, n2), (b1, b2) = normals, bends
    if not any(order) or (not b1 and not b2):
        return None
    left, right = n1 * b2, n2 * b1
    if abs(left - right) > PROPORTIONAL_DOUBT * (abs(left) + abs(right)):
        return None
    return n2 / (n2 - n1) if n2 - n1 else b2 / (b2 - b1)


def _slide_coefficients(
    normals: Sequence[Any], bends: Sequence[Any], along: tuple[Any, Any], flows: tuple[Flow, Flow], orientation: int
) -> tuple[Any, Any, Any, Any, Any]:
    """``A, B, C, D, K`` with ``C + D s > 0`` ahead."""
    (n1, n2), (b1, b2), (p1, p2) = normals, bends, along
    parts = (n2 * p1 - n1 * p2, b2 * p1 - b1 * p2, n2 - n1, b2 - b1, n2 * flows[0].omega - n1 * flows[1].omega)
    if orientation > 0:
        return parts
    a, b, c, d, k = parts
    return -a, -b, -c, -d, -k


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
