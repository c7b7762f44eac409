"""The fan of cones at a point: the cells whose closure holds it, each by two rays and its motions about the point.

Paths see a fan by the edges that meet at the point, because they must know which edge a ray is and how far it reaches
(:mod:`nonsmooth.analysis.trajectories.closed_forms`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction
from functools import cmp_to_key
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_text import brief_text, float_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, plus, same_direction, turned

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Cell, Partition

S = TypeVar("S", bound="Wedge")


@dataclass(frozen=True)
class Wedge:
    """The part of a cell near the point: counterclockwise from ray ``start`` to ray ``end``.

    Attributes:
        start: first ray.
        end: last ray.
    """

    start: Point
    end: Point

    @property
    def inner(self) -> Point:
        """A ray between both of a wedge of less than a half turn."""
        return plus(self.start, self.end)

    @property
    def inward_normals(self) -> tuple[Point, ...]:
        """Of the sides along both rays; none where the cone is the plane."""
        x, y = turned(self.end)
        return () if is_plane(self) else (turned(self.start), (-x, -y))

    def holds(self, vector: Point) -> bool:
        """Whether a nonzero vector points into the closed cone (of angle at most a half turn)."""
        if not cross(self.start, self.end):  # half-plane
            return sign(cross(self.start, vector)) >= 0
        return sign(cross(self.start, vector)) >= 0 and sign(cross(vector, self.end)) >= 0


@dataclass(frozen=True)
class Cone(Wedge):
    """A wedge with the motions that act there.

    Attributes:
        twists: the motions.
    """

    twists: tuple[Twist, ...]

    def bends_out(self, twist: Twist) -> bool:
        """Whether a velocity points away from the point along a ray, and omega bends the path out of the cone there."""
        turn, velocity = sign(twist.omega), twist.velocity
        return any(turn == sense and same_direction(ray, velocity) for ray, sense in ((self.start, -1), (self.end, 1)))


@dataclass(frozen=True)
class CellCone(Cone):
    """The cone of a cell of an array."""

    cell: Cell


def build_fan(partition: Partition) -> tuple[CellCone, ...]:
    """The cones of the cells whose closure holds the origin, counterclockwise."""
    cones = [_cone(cell) for cell in partition.meeting]
    cones.sort(key=lambda cone: by_angle(cone.start))
    if len(cones) == 1:
        return tuple(cones)
    # neighbours share one vector per ray, so that gains multiply to the gain of a full turn
    return tuple(replace(cone, end=following.start) for cone, following in around(cones))


def _cone(cell: Cell) -> CellCone:
    """The cone of a cell at the origin, from its vertices."""
    vertices = cell.polygon.vertices
    count = len(vertices)
    for k, vertex in enumerate(vertices):
        if not any(vertex):
            return CellCone(vertices[(k + 1) % count], vertices[k - 1], cell.twists, cell)
    for k, vertex in enumerate(vertices):
        after = vertices[(k + 1) % count]
        if not cross(vertex, after) and sign(dot(vertex, after)) < 0:
            return CellCone(after, vertex, cell.twists, cell)
    return CellCone(vertices[0], vertices[0], cell.twists, cell)  # the origin is inside: the cone is the plane


def _compare_angles(a: Point, b: Point) -> int:
    """Order by angle from the positive x axis, counterclockwise."""
    upper = [sign(p[1]) > 0 or (sign(p[1]) == 0 and sign(p[0]) > 0) for p in (a, b)]
    if upper[0] != upper[1]:
        return -1 if upper[0] else 1
    return -sign(cross(a, b))


by_angle = cmp_to_key(_compare_angles)  # key that sorts rays counterclockwise from the positive x axis


def is_plane(cone: Wedge) -> bool:
    """Whether the cone is the whole plane: the point lies inside its cell."""
    return cone.start is cone.end


def rays_of(fan: Sequence[S]) -> Iterator[tuple[Point, S, S]]:
    """Each ray with the cone before it and the cone after it (counterclockwise)."""
    if len(fan) == 1:
        return
    for k, cone in enumerate(fan):
        yield cone.start, fan[k - 1], cone


# ---- moves near a point where cells meet ---------------------------------------------------------
#
# Which motion keeps to its cell, and which two slide along a ray.
#
# About a point p of the plane a motion is ``c' = v + w J (c - p)``, here the twist (v, w).  Seen from a ray r, at
# ``c = p + s r``, its normal and radial speeds (times the length of r) are
#
#     r x c' = n + b s,    r . c' = rho    with    n = r x v,  b = w |r|^2,  rho = r . v.
#
# Two motions, of which the first turns counterclockwise about p and the second clockwise, slide along the ray by
# equivalent control (Filippov 1988, sec. 4): ``s' |r|^2 = (A + B s)/(C + D s)`` with ``A = n_1 rho_2 - n_2 rho_1``,
# ``C = n_1 - n_2``, and B and D likewise from b.
#
# The numbers may be exact, floats or float arrays.  Verdicts take exact signs, paths in floats those with slacks
# (:mod:`nonsmooth.analysis.trajectories.closed_forms`).


class Signs(NamedTuple):
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


def slide_speed(before: RaySpeeds, behind: RaySpeeds) -> Any | None:
    """Leading nonzero coefficient (a positive multiple of it) of the radial speed of a slide at small distances.

    ``before`` pushes counterclockwise or not at all, ``behind`` clockwise or not at all; None where they do not, so
    that the pair is met in the other order or cannot slide.  Zero means exactly zero for all small s.
    """
    pushes = before.push(), behind.push()
    if pushes[0] < 0 or pushes[1] > 0:
        return None
    if pushes == (0, 0):
        return before.radial
    constant, linear, *_ = sliding(before, behind)
    return constant if constant else linear


# ---- full turns ----------------------------------------------------------------------------------
#
# Crossing cones one after the other, all around a point, and what that does to small distances.
#
# In a cone with twist ``(v, omega)`` the body moves on a circle (exact kinematics ``c' = v + omega J c``), along which
#
#     H(c) = c x v + omega |c|^2 / 2
#
# does not change.  So a path that enters at ``s r`` and leaves at ``s' r'`` obeys ``H(s r) = H(s' r')``, and for small
# s (turning counterclockwise; clockwise with both signs changed)
#
#     (r x v) s + (omega |r|^2 / 2) s^2 = (r' x v) s' + (omega |r'|^2 / 2) s'^2.
#
# The first terms that do not vanish decide what the crossing does to small distances:
#
# - both products positive: ``s' = (r x v)/(r' x v) s``, the *gain* of a crossing of order one;
# - the entry's product zero and omega bends the path into the cone: ``s'`` is of order ``s^2``;
# - the exit's product zero and omega bends the path out of it: ``s'`` is of order ``s^(1/2)``: a start at 1e-12 leaves
#   the cone at about 1e-6;
# - both zero, in a half-plane with v along its line, or where v = 0: ``H = omega |c|^2 / 2``, the distance is kept.
#
# A full turn is of the product of these orders.  Below one the distances diverge, above one they vanish; at exactly one
# the product of the gains decides where every crossing is of order one.  Several motions in a cone: the most growth
# counts (``proofs.clauses.translation.fan_stability`` says why a mixture gains no more; that argument is for order one
# only).
#
# Over exact numbers or floats, as the moves above.


class Growth(Enum):
    """What full turns of one sense do to small distances."""

    DIVERGES = "diverges"
    CONTRACTS = "contracts"
    TIE = "tie"


class ConeCrossing(NamedTuple):
    """From ray to ray through a cone: ``s' = gain s^order`` to leading order, s in units of the rays' vectors.

    Attributes:
        order: 1/2, 1 or 2.
        gain: the factor of a crossing of order one; None for the others, and where the body turns about the
            equilibrium itself: there the distance is kept, whatever the lengths of the rays' vectors.
    """

    order: Fraction
    gain: Any | None


@dataclass(frozen=True)
class FullTurn:
    """A full turn about the equilibrium, one crossing to a cone.

    Attributes:
        sense: 1 counterclockwise, -1 clockwise.
        order: product of the orders of the crossings.
        gain: product of their gains, the factor of the distance; None where a crossing is not of order one.
        growth: what it does to small distances.
    """

    sense: int
    order: Fraction
    gain: Any | None
    growth: Growth

    def __str__(self) -> str:
        if self.gain is None:
            return f"a full turn takes a distance eps to the order of eps^({self.order})"
        if self.growth is Growth.CONTRACTS:
            return f"a full turn contracts by {brief_text(self.gain)}"
        return f"a full turn multiplies the distance by {brief_text(self.gain)} ~ {float_text(self.gain)}"


def full_turns(fan: Sequence[Cone]) -> tuple[FullTurn, ...]:
    """The full turns that exist, at most one for each sense."""
    found = (_full_turn(fan, sense) for sense in (1, -1))
    return tuple(turn for turn in found if turn is not None)


def _full_turn(fan: Sequence[Cone], sense: int) -> FullTurn | None:
    if len(fan) < 2:
        return None
    choices = [cone_crossings(cone, sense) for cone in fan]
    if not all(choices):
        return None
    steps = [most_growth(crossings) for crossings in choices]
    order = math.prod((step.order for step in steps), start=Fraction(1))
    gains = [step.gain for step in steps if step.gain is not None]
    gain = math.prod(gains[1:], start=gains[0]) if len(gains) == len(steps) else None
    tie_is_open = any(
        len(cone.twists) > 1 and any(step.gain is None for step in crossings)
        for cone, crossings in zip(fan, choices, strict=True)
    )
    return FullTurn(sense, order, gain, _growth(order, gain, tie_is_open=tie_is_open))


def _growth(order: Fraction, gain: Any | None, *, tie_is_open: bool) -> Growth:
    """What a turn does; one that contracts by the chosen motions of tied cones only is no proof."""
    if order != 1:
        growth = Growth.DIVERGES if order < 1 else Growth.CONTRACTS
    else:
        growth = Growth.TIE if gain is None else growth_of(gain)
    return Growth.TIE if tie_is_open and growth is Growth.CONTRACTS else growth


def growth_of(gain: Any, signs: Signs = EXACT) -> Growth:
    """What turns that multiply small distances by a gain do to them."""
    growing = signs(gain - 1, signs.gain_slack)
    return Growth.DIVERGES if growing > 0 else Growth.CONTRACTS if growing < 0 else Growth.TIE


def cone_crossings(cone: Cone, sense: int) -> list[ConeCrossing]:
    """The crossings of a cone in one sense, one for each motion that crosses it."""
    if is_plane(cone):
        return []
    found = (crossing(entry_and_exit(cone, sense), twist, sense) for twist in cone.twists)
    return [step for step in found if step is not None]


def most_growth(crossings: Sequence[ConeCrossing]) -> ConeCrossing:
    """The crossing after which small distances are largest: of the lowest order, then of the largest gain."""
    lowest = min(step.order for step in crossings)
    return max((step for step in crossings if step.order == lowest), key=lambda step: step.gain or 0)


def crossing(rays: tuple[Point, Point], twist: Twist, sense: int, signs: Signs = EXACT) -> ConeCrossing | None:
    """How a motion crosses a cone from its ray of entry to that of exit, in the given sense; None where it does not."""
    entry, exit_ray = rays
    entering, leaving = (sense * cross(ray, twist.velocity) for ray in rays)
    first, last = (signs(normal, signs.speed_slack) for normal in (entering, leaving))
    bend = sense * signs(twist.omega, signs.turn_slack)
    if first > 0 and last > 0:
        return ConeCrossing(Fraction(1), entering / leaving)
    if bend <= 0 or first < 0 or last < 0:
        return None
    if first > 0:
        return ConeCrossing(Fraction(1, 2), None)
    if last > 0:
        return ConeCrossing(Fraction(2), None)
    if any(twist.velocity):  # a half-plane with v along its line: the rays are opposite
        return ConeCrossing(Fraction(1), -dot(entry, exit_ray) / dot(exit_ray, exit_ray))
    return ConeCrossing(Fraction(1), None)


def entry_and_exit(cone: Cone, sense: int) -> tuple[Point, Point]:
    """The rays over which a cone is entered and left, turning counterclockwise (1) or clockwise (-1)."""
    return (cone.start, cone.end) if sense > 0 else (cone.end, cone.start)
