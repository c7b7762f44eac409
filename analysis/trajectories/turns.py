"""Full turns around a corner, and the limit of infinitely many of them (accumulating switches, Zeno).

Around a corner with velocities v that are constant, a path that starts at distance s on a ray returns to it at
distance ``gain s`` after a time and a rotation proportional to s.  With gain below one it keeps to the same cells
(they are convex and hold the corner), so the turns sum to geometric series: the limit time, place and heading are
closed forms, exact for exact numbers.  With exact pose kinematics the velocities vary by ``omega J (c - p)``: the
series is taken at distances whose square is below rounding, where that term no longer matters.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.cells.cell_complex import AtCorner
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.trajectories.junction import Ray, Signs, junction_at
from nonsmooth.analysis.trajectories.motion import State
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import cross, dot

# Relative to the size of the domain: turns smaller than this cannot be told apart in a drawing.
DRAWN_DISTANCE = 1 / 128
# Relative to the size of the domain: the turning terms change a turn from here by 1e-18 of the domain.
SERIES_DISTANCE = 1e-9
# Relative: a gain nearer to one than this is not told from one; the series would need more than 1e12 turns.
GAIN_DOUBT = 1e-12


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
        product: Any = 1
        for step in self.steps:
            product = step.gain * product
        return product

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
class Spiral:
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
    rays = list(junction.rays)
    order = _in_order(rays, sense)
    steps: list[TurnStep] = []
    for ray, following in zip(order, [*order[1:], order[0]], strict=True):
        cell = ray.left if sense > 0 else ray.right
        flow = field.flows[cell][0]
        v = flow.velocity(point)
        here, there = cross(ray.direction, v), cross(following.direction, v)
        if sense * signs(here, signs.speed_slack) <= 0 or sense * signs(there, signs.speed_slack) <= 0:
            return None
        lasts = cross(ray.direction, following.direction) / there
        steps.append(TurnStep(ray, cell, v, flow.omega, here / there, lasts))
    return Turn(corner, tuple(steps))


def _in_order(rays: Sequence[Ray], sense: int) -> list[Ray]:
    """Rays in the order of a turn: the next one has on its near side the cell on the far side of the last."""
    order = [rays[0]]
    while len(order) < len(rays):
        cell = order[-1].left if sense > 0 else order[-1].right
        order.append(next(ray for ray in rays if (ray.right if sense > 0 else ray.left) == cell))
    return order


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
        return any(turn is not None and self._sign(turn.gain - 1) > 0 for turn in turns)

    def inward_from(self, edge: int, cell: int, corner: int) -> Turn | None:
        """The turn around a corner of an edge just crossed into a cell, begun at that edge, if it contracts."""
        ends = self.field.cells.edges[edge]
        turn = self.around(corner, 1 if (ends.left == cell) == (ends.start == corner) else -1)
        return turn.from_edge(edge) if turn is not None and self._sign(1 - turn.gain) > 0 else None

    def _sign(self, value: Any) -> int:
        return sign(value) if self.field.exact else self.signs(value, GAIN_DOUBT)

    @property
    def small(self) -> float:
        """Distance from a corner (length) at which the series is summed."""
        return (SERIES_DISTANCE if self.field.turn_scale else DRAWN_DISTANCE) * self.field.cells.size

    def accumulation(self, edge: int, cell: int, point: Point, theta: Any) -> Spiral | None:
        """The limit of infinitely many turns around a corner of the edge just crossed, once they are small."""
        cells = self.field.cells
        for corner in (cells.edges[edge].start, cells.edges[edge].end):
            x, y = cells.points[corner]
            away = (point[0] - x, point[1] - y)
            if float(dot(away, away)) > self.small**2:
                continue
            turn = self.inward_from(edge, cell, corner)
            if turn is None:
                continue
            r = turn.steps[0].ray.direction
            s = dot(away, r) / dot(r, r)
            if turn.fits(s):
                return Spiral(turn, (x, y), theta, s)
        return None
