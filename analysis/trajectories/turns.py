"""Full turns around a corner, and the limit of infinitely many of them (accumulating switches, Zeno).

Around a corner with velocities v that are constant, a path that starts at distance s on a ray returns to it at
distance ``gain s`` after a time and a rotation proportional to s.  With gain below one it keeps to the same cells
(they are convex and hold the corner), so the turns sum to geometric series: the limit time, place and heading are
closed forms, exact for exact numbers.  With exact pose kinematics the velocities vary by ``omega J (c - p)``: the
series is taken at distances whose square is below rounding, where that term no longer matters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.cells.cell_complex import AtCorner
from nonsmooth.analysis.cells.fan import by_angle
from nonsmooth.analysis.cells.full_turns import Growth, crossing, growth_of
from nonsmooth.analysis.cells.moves import Signs
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.trajectories.cell_motion import State
from nonsmooth.analysis.trajectories.slides import Ray, junction_at
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.numbers.plane import around, cross, dot, minus

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
