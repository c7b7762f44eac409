"""Moves near a point where cells meet: which motion keeps to its cell, and which two slide along a ray.

About a point p of the plane a motion is ``c' = v + w J (c - p)``, here the twist (v, w).  Seen from a ray r, at
``c = p + s r``, its normal and radial speeds (times the length of r) are

    r x c' = n + b s,    r . c' = rho    with    n = r x v,  b = w |r|^2,  rho = r . v.

Two motions, of which the first turns counterclockwise about p and the second clockwise, slide along the ray by
equivalent control (Filippov 1988, sec. 4): ``s' |r|^2 = (A + B s)/(C + D s)`` with ``A = n_1 rho_2 - n_2 rho_1``, ``C =
n_1 - n_2``, and B and D likewise from b.

The numbers may be exact, floats or float arrays.  Verdicts take exact signs, paths in floats those with slacks
(:mod:`nonsmooth.analysis.trajectories.slides`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import cross, dot, turned


@dataclass(frozen=True)
class Signs:
    """Signs of what is compared around a point; a value within its slack counts as zero.

    Slacks, all zero for exact numbers: of speeds (length/time), of rates at which velocities turn and at which the body
    rotates (1/time), of products of two speeds, of speeds times rates of turning, of the difference of a gain from one.
    """

    speed_slack: float = 0.0
    turn_slack: float = 0.0
    rate_slack: float = 0.0
    product_slack: float = 0.0
    bend_slack: float = 0.0
    gain_slack: float = 0.0

    def __call__(self, value: Any, slack: float) -> int:
        """Sign of a value, zero within a slack that is zero for exact numbers."""
        return 0 if slack and abs(value) <= slack else sign(value)

    def first(self, speed: Any, change: Any, change_slack: float) -> int:
        """Sign of a speed just ahead: its own, or that of its change."""
        return self(speed, self.speed_slack) or self(change, change_slack)


EXACT = Signs()


def departure_sign(normal: Point, twist: Twist, signs: Signs = EXACT) -> int:
    """Sign of ``normal . (c - p)`` just after p, on the path ``c - p = t v + t^2 w J v/2`` that starts there."""
    velocity = twist.velocity
    return signs.first(dot(normal, velocity), twist.omega * dot(normal, turned(velocity)), signs.bend_slack)


class RaySpeeds(NamedTuple):
    """A motion seen from a ray: normal speed ``normal + bend s`` (positive counterclockwise) and radial speed."""

    normal: Any
    bend: Any
    radial: Any

    def push(self, signs: Signs = EXACT) -> int:
        """The sense in which the motion turns about the point, on the ray and near the point."""
        return signs.first(self.normal, self.bend, signs.turn_slack)


def ray_speeds(ray: Point, twist: Twist) -> RaySpeeds:
    """``(r x v, w |r|^2, r . v)``."""
    return RaySpeeds(cross(ray, twist.velocity), twist.omega * dot(ray, ray), dot(ray, twist.velocity))


def sliding(first: RaySpeeds, second: RaySpeeds) -> tuple[Any, Any, Any, Any]:
    """``(A, B, C, D)`` of the slide of a motion that pushes counterclockwise with one that pushes clockwise."""
    (n1, b1, rho1), (n2, b2, rho2) = first, second
    return n1 * rho2 - n2 * rho1, b1 * rho2 - b2 * rho1, n1 - n2, b1 - b2


def slide_speed(ray: Point, first: Twist, second: Twist) -> Any | None:
    """Leading nonzero coefficient (a positive multiple of it) of the radial speed of a slide at small distances.

    ``first`` pushes counterclockwise or not at all, ``second`` clockwise or not at all; None where they do not, so
    that the pair is met in the other order or cannot slide.  Zero means exactly zero for all small s.
    """
    before, behind = ray_speeds(ray, first), ray_speeds(ray, second)
    pushes = before.push(), behind.push()
    if pushes[0] < 0 or pushes[1] > 0:
        return None
    if pushes == (0, 0):
        return before.radial
    constant, linear, *_ = sliding(before, behind)
    return constant if constant else linear
