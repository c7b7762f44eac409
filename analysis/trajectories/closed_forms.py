"""Closed forms of the motions between events on cells with constant twist.

- *free* in a cell: with ``c' = v + w J c`` and initial velocity v0,
  ``c(t) = c0 + (sin wt)/w v0 + (1 - cos wt)/w J v0``, a straight line for w = 0.  The time to a line ``m . c = b``
  solves a quadratic in ``z = (2/w) tan(wt/2)``, which turns into the linear equation of a straight path as w -> 0: no
  case of nearly straight arcs loses digits.
- *rest*: c stays, theta drifts at a constant rate.
- *slides* along an edge, and infinitely many *turns* around a corner: the chapters below, behind one on the edges and
  cells that meet at a point.

With w = 0 every formula is rational, so exact numbers stay exact.  None stands for a time that never comes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.cell_complex import AtCorner, OnEdge
from nonsmooth.analysis.cells.fan import (
    EXACT,
    Growth,
    RaySpeeds,
    Signs,
    by_angle,
    crossing,
    growth_of,
    ray_speeds,
    sliding,
)
from nonsmooth.analysis.cells.polygon import HalfPlane, Point
from nonsmooth.analysis.fields.constant_field import ConstantField, Flow
from nonsmooth.analysis.fields.convex_weights import least_mix
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import around, cross, dot, minus, turned
from nonsmooth.symbolic.numbers.plane_arrays import Floats

State: TypeAlias = tuple[Any, Any, Any]


class SideCrossing(NamedTuple):
    """A side that a free motion reaches, and when."""

    time: Any
    side: int


@dataclass(frozen=True)
class Free:
    """Motion inside a cell from ``point`` with heading ``theta``."""

    point: Point
    theta: Any
    flow: Flow

    def state(self, time: Any) -> State:
        """``(x, y, theta)`` after ``time``."""
        (vx, vy), w = self.flow.velocity(self.point), self.flow.turn
        theta = self.theta + self.flow.omega * time
        if not w:
            return self.point[0] + vx * time, self.point[1] + vy * time, theta
        along, across = math.sin(w * time) / w, 2 * math.sin(w * time / 2) ** 2 / w
        return self.point[0] + along * vx - across * vy, self.point[1] + along * vy + across * vx, theta

    def first_crossing(self, sides: Iterable[HalfPlane], active: frozenset[int], slack: float) -> SideCrossing | None:
        """The side through which the path leaves a convex cell.

        It departs from the active sides; from those along which it moves, within a slack of the speed, it bends away.
        """
        best: SideCrossing | None = None
        for k, side in enumerate(sides):
            time = self._time_to(side, slack if k in active else None)
            if time is not None and (best is None or time < best.time):
                best = SideCrossing(time, k)
        return best

    def _time_to(self, side: HalfPlane, departs: float | None) -> Any | None:
        """Time until a line ahead is crossed, or until an arc is back on one that it departs from faster than that."""
        velocity, w = self.flow.velocity(self.point), self.flow.turn
        rate = dot(side.normal, velocity)
        if departs is not None and (not w or abs(rate) <= departs):
            return None
        if not w:
            return None if sign(rate) <= 0 else side.slack(self.point) / rate
        bend = dot(side.normal, turned(velocity))
        time = line_times(w, side.slack(self.point), rate, bend) if departs is None else times_back(w, rate, bend)
        return float(time) if time < np.inf else None


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def line_times(w: float, gap: Any, rate: Any, bend: Any) -> Floats:
    """Times until arcs cross a line ahead, infinite where they never do; of one start, or of many.

    Args:
        w: the rate at which their velocities v turn.
        gap: distances from the line, whose unit normal is n.
        rate: ``n . v``.
        bend: ``n . J v``.
    """
    gap, rate = np.maximum(gap, 0.0), np.asarray(rate, float)
    quadratic = w * (2 * bend - w * gap) / 4
    discriminant = rate**2 + 4 * quadratic * gap
    q = -(rate + np.copysign(np.sqrt(discriminant), rate)) / 2
    found = np.fmin(_arc_time(w, -gap / q), _arc_time(w, q / quadratic))
    return np.where(discriminant >= 0, found, np.inf)


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def times_back(w: float, rate: Any, bend: Any) -> Floats:
    """Times until arcs are back on a line that they depart from: the root z = 0 is the departure itself."""
    return _arc_time(w, np.asarray(-2 * rate, float) / (w * bend))


def _arc_time(w: float, z: Any) -> Floats:
    """Time in ``(0, 2 pi/|w|)`` at which ``(2/w) tan(wt/2) = z``."""
    angle = np.arctan(abs(w) * np.abs(z) / 2)
    return np.asarray(2 / abs(w) * np.where(z > 0, angle, np.pi - angle))


@dataclass(frozen=True)
class Rest:
    """c stays; theta drifts at ``rate``."""

    point: Point
    theta: Any
    rate: Any

    def state(self, time: Any) -> State:
        """``(x, y, theta)`` after ``time``."""
        return self.point[0], self.point[1], self.theta + self.rate * time


# ---- the edges and cells that meet at a point of an edge or at a corner --------------------------
#
# And the signs by which paths decide there.
#
# What motions do around the point is that of :mod:`nonsmooth.analysis.cells.fan`; here is added what a path must know
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


ActiveSides: TypeAlias = tuple[tuple[int, tuple[tuple[int, bool], ...]], ...]  # of cells; and whether they are borders


@dataclass(frozen=True)
class Junction:
    """A point on an edge or at a corner with its fan.

    Attributes:
        cells: each closed cell at the point, with the sides it is active on and whether they border the domain.
    """

    point: Point
    cells: ActiveSides
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
    active: ActiveSides
    if isinstance(place, OnEdge):
        edge = cells.edges[place.edge]
        active = tuple((cell, ((cells.side_of(cell, place.edge), len(edge.cells) < 2),)) for cell in edge.cells)
        return Junction(point, active, tuple(_rays(field, place.edge, point)), len(edge.cells) < 2)
    corner = cells.corners[place.corner]
    active = tuple(
        (cell, tuple((k, _is_border(field, cell, k)) for k in cells.active_sides(cell, place.corner)))
        for cell in corner.cells
    )
    rays = chain.from_iterable(_rays(field, number, point, place.corner) for number in corner.edges)
    border = any(len(cells.edges[number].cells) < 2 for number in corner.edges)
    return Junction(point, active, tuple(rays), border)


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


# ---- sliding along an edge -----------------------------------------------------------------------
#
# With constant twists on both sides: closed forms by equivalent control.
#
# Along a ray ``s' |r|^2 = (A + B s)/(C + D s)`` (:mod:`nonsmooth.analysis.cells.fan`) and ``theta' = K/(C + D s)`` with
# ``K = n_1 omega_2 - n_2 omega_1``: time and rotation as functions of s are integrals of rational functions,
# logarithms. With w = 0 every formula is rational, so exact numbers stay exact.


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


# ---- full turns around a corner ------------------------------------------------------------------
#
# And the limit of infinitely many of them (accumulating switches, Zeno).
#
# Around a corner with velocities v that are constant, a path that starts at distance s on a ray returns to it at
# distance ``gain s`` after a time and a rotation proportional to s.  With gain below one it keeps to the same cells
# (they are convex and hold the corner), so the turns sum to geometric series: the limit time, place and heading are
# closed forms, exact for exact numbers.  With exact pose kinematics the velocities vary by ``omega J (c - p)``: the
# series is taken at distances whose square is below rounding, where that term no longer matters.


# Relative to the size of the domain: turns smaller than this cannot be told apart in a drawing.
DRAWN_DISTANCE = 1 / 128
# Relative to the size of the domain: the turning terms change a turn from here by 1e-18 of the domain.
SERIES_DISTANCE = 1e-9


@dataclass(frozen=True)
class TurnStep:
    """From a ray through one cell to the next: per unit of s, the next s, the time and the rotation."""

    ray: Ray
    cell: int
    velocity: Point
    omega: Any
    gain: Any
    time: Any


@dataclass(frozen=True)
class Turn:
    """A full turn around a corner; ``steps`` in the order they are passed."""

    corner: int
    steps: tuple[TurnStep, ...]

    @property
    def gain(self) -> Any:
        """Factor of the distance per turn."""
        return math.prod(step.gain for step in self.steps)

    def from_edge(self, edge: int) -> Turn:
        """The same turn, begun at an edge."""
        first = next(k for k, step in enumerate(self.steps) if step.ray.edge == edge)
        return Turn(self.corner, self.steps[first:] + self.steps[:first])

    def fits(self, s: Any) -> bool:
        """Whether a turn from distance s (in units of the first ray) keeps to the edges at the corner."""
        for step in self.steps:
            if s > step.ray.reach:
                return False
            s = s * step.gain
        return True

    def per_unit(self) -> tuple[Any, Any]:
        """Time and rotation of one turn from s = 1."""
        s: Any = 1
        time: Any = 0
        rotation: Any = 0
        for step in self.steps:
            lasted = step.time * s
            time, rotation = lasted + time, lasted * step.omega + rotation
            s = step.gain * s
        return time, rotation


@dataclass(frozen=True)
class CornerSpiral:
    """Infinitely many turns towards a corner from distance ``s`` with heading ``theta``."""

    turn: Turn
    point: Point
    theta: Any
    s: Any

    def limit(self) -> tuple[Any, Any]:
        """Time until the corner is reached, and heading there."""
        time, rotation = self.turn.per_unit()
        scale = self.s / (1 - self.turn.gain)
        return time * scale, self.theta + rotation * scale

    def state(self, time: Any) -> State:
        """``(x, y, theta)`` after ``time``."""
        last, heading = self.limit()
        part = float(time / last)
        if part >= 1:
            return *self.point, heading
        gain = self.turn.gain
        turns = max(0, math.floor(math.log1p(-part) / math.log(float(gain))))
        scale = gain**turns
        return self._after(turns, scale, (time - last * (1 - scale)) / scale)

    def _after(self, turns: int, scale: Any, time: Any) -> State:
        """State ``scale * time`` after so many full turns, each smaller by the gain."""
        s, heading = self.s, self.theta
        if turns:
            heading = heading + self.turn.per_unit()[1] * self.s * (1 - scale) / (1 - self.turn.gain)
        for step in self.turn.steps:
            lasts = step.time * s
            if time < lasts or step is self.turn.steps[-1]:
                break
            s, time, heading = s * step.gain, time - lasts, heading + scale * step.omega * lasts
        (x, y), r, v = self.point, step.ray.direction, step.velocity
        x, y = (p + scale * (s * a + time * b) for p, a, b in ((x, r[0], v[0]), (y, r[1], v[1])))
        return x, y, heading + scale * step.omega * time


def full_turn(field: ConstantField, corner: int, sense: int, signs: Signs) -> Turn | None:
    """The full turn around a corner, counterclockwise (1) or clockwise (-1), where every cell can be crossed."""
    point = field.cells.points[corner]
    junction = junction_at(field, AtCorner(corner), point)
    if junction.border:
        return None
    rays = sorted(junction.rays, key=lambda ray: by_angle(ray.direction))[::sense]
    steps = [_turn_step(field, point, pair, sense, signs) for pair in around(rays)]
    crossed = tuple(step for step in steps if step is not None)
    return Turn(corner, crossed) if len(crossed) == len(steps) else None


def _turn_step(field: ConstantField, point: Point, rays: tuple[Ray, Ray], sense: int, signs: Signs) -> TurnStep | None:
    """Through the cell between two rays with the velocity at the corner.

    Crossings that hang on the turn of the velocity are of another order than one, and sum to no geometric series.
    """
    first, second = (ray.direction for ray in rays)
    cell = rays[0].left if sense > 0 else rays[0].right
    flow = field.flows[cell][0]
    v = flow.velocity(point)
    passed = crossing((first, second), Twist(*v, flow.turn * 0), sense, signs)
    if passed is None:
        return None
    return TurnStep(rays[0], cell, v, flow.omega, passed.gain, cross(first, second) / cross(second, v))


class Turns:
    """The full turns of a field, found once for each corner and sense."""

    def __init__(self, field: ConstantField, signs: Signs) -> None:
        self.field, self.signs = field, signs
        self._known: dict[tuple[int, int], Turn | None] = {}

    def around(self, corner: int, sense: int) -> Turn | None:
        """The full turn around a corner in a sense, where there is one."""
        if (corner, sense) not in self._known:
            self._known[corner, sense] = full_turn(self.field, corner, sense, self.signs)
        return self._known[corner, sense]

    def lead_outward(self, corner: int) -> bool:
        """Whether a turn lengthens the distance: then infinitely many spirals leave the corner."""
        turns = (self.around(corner, sense) for sense in (1, -1))
        return any(turn is not None and growth_of(turn.gain, self.signs) is Growth.DIVERGES for turn in turns)

    def inward_from(self, edge: int, cell: int, corner: int) -> Turn | None:
        """The turn around a corner of an edge just crossed into a cell, begun at that edge, if it contracts."""
        ends = self.field.cells.edges[edge]
        turn = self.around(corner, 1 if (ends.left == cell) == (ends.start == corner) else -1)
        if turn is None or growth_of(turn.gain, self.signs) is not Growth.CONTRACTS:
            return None
        return turn.from_edge(edge)

    @property
    def small(self) -> float:
        """Distance from a corner (length) at which the series is summed."""
        return (SERIES_DISTANCE if self.field.turn_scale else DRAWN_DISTANCE) * self.field.cells.size

    def accumulation(self, edge: int, cell: int, point: Point, theta: Any) -> CornerSpiral | None:
        """The limit of infinitely many turns around a corner of the edge just crossed, once they are small."""
        cells = self.field.cells
        for corner in (cells.edges[edge].start, cells.edges[edge].end):
            away = minus(point, cells.points[corner])
            if float(dot(away, away)) > self.small**2:
                continue
            turn = self.inward_from(edge, cell, corner)
            if turn is None:
                continue
            r = turn.steps[0].ray.direction
            s = dot(away, r) / dot(r, r)
            if turn.fits(s):
                return CornerSpiral(turn, cells.points[corner], theta, s)
        return None
