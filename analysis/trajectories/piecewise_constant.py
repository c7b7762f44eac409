"""Event-driven Filippov paths on cells with constant twist: closed forms from event to event.

At an edge or corner every continuation is listed (:mod:`nonsmooth.analysis.trajectories.continuations`) and one is
followed to its end: through a cell to its border, along an edge to where sliding ends, around a corner to the limit of
infinitely many turns, or at rest.  There is no step size and no error that accumulates with time: a path is exact to
the rounding of one closed form per event, and exact altogether for exact numbers.

It fails where nothing is constant (feedback, plain systems): :mod:`nonsmooth.analysis.trajectories.smooth_path`.  A
path that spirals out of a corner is not drawn (the drawn path rests there), only said to exist.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.cell_complex import AtCorner, InCell, OnEdge, Place
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.trajectories.cell_motion import Free, Rest, State
from nonsmooth.analysis.trajectories.continuations import Choice, choices_at
from nonsmooth.analysis.trajectories.junction import junction_at, signs_of
from nonsmooth.analysis.trajectories.log import EventLog
from nonsmooth.analysis.trajectories.lyapunov_watch import LyapunovWatch
from nonsmooth.analysis.trajectories.orbits import OrbitMemory
from nonsmooth.analysis.trajectories.result import (
    End,
    EndReason,
    EventKind,
    Piece,
    Trajectory,
    TrajectoryError,
    samples,
)
from nonsmooth.analysis.trajectories.sample_times import sample_times
from nonsmooth.analysis.trajectories.slides import Slide
from nonsmooth.analysis.trajectories.turns import CornerSpiral, Turns
from nonsmooth.symbolic.plane import cross, dot, minus

MAX_LEGS = (
    10_000  # between events; a path of the built-in scenes has fewer than 20, a spiral of gain 0.99 some thousand
)

Motion: TypeAlias = Free | Slide | Rest | CornerSpiral


@dataclass(frozen=True)
class _Leg:
    """A motion with the place it leads to; duration None never ends."""

    motion: Motion
    place: str
    cells: tuple[int, ...]
    duration: Any | None
    arrival: Place | None = None


def follow_constant(
    field: ConstantField,
    start: Sequence[Any],
    until: Any | None,
    watch: LyapunovWatch | None,
    *,
    sampled: bool = True,
) -> Trajectory:
    """Follow a Filippov solution from ``(x, y, theta)``.

    Args:
        field: the field; over exact numbers the path is exact.
        start: initial pose.
        until: last time; None follows the path to its rest, however long that takes.
        watch: bound on V' to check every piece against.
        sampled: list states along the path, not its end alone.

    Raises:
        ValueError: for a start outside the domain.
        TrajectoryError: for a violated Lyapunov bound or a point without continuation.
    """
    place = None
    if all(math.isfinite(float(value)) for value in start):
        x, y, theta = (field.number(value) for value in start)
        place = field.cells.locate((x, y))
    if place is None:
        raise ValueError(f"required a start inside the domain of the cells, received ({start[0]}, {start[1]})")
    return _Path(field, (x, y), theta, until, watch, sampled=sampled).follow(place)


class _Path:
    """A path while it is being followed; ``moved`` are the cells of the last motion."""

    def __init__(
        self,
        field: ConstantField,
        point: Point,
        theta: Any,
        until: Any | None,
        watch: LyapunovWatch | None,
        *,
        sampled: bool,
    ) -> None:
        self.field, self.watch, self.sampled = field, watch, sampled
        self.signs = signs_of(field)
        self.turns = Turns(field, self.signs)
        self.log = EventLog(field, self.turns.lead_outward)
        self.point, self.theta, self.time = point, theta, theta * 0
        self.until = None if until is None or until == math.inf else field.number(until)
        self.pieces: list[Piece] = []
        self.moved: tuple[int, ...] | None = None
        self.entries: dict[tuple[int, int], list[Point]] = {}
        self.memory = OrbitMemory(field.cells.slack)

    @property
    def state(self) -> State:
        """Pose now."""
        return *self.point, self.theta

    def follow(self, place: Place) -> Trajectory:
        """Leg after leg."""
        for _ in range(MAX_LEGS):
            self._skip_turns(place)
            leg = self._leg(place)
            if leg is None:
                return self._result(EndReason.OUTSIDE)
            if self.until is None and self._repeats(place, leg):
                return self._result(EndReason.CIRCLES)
            reason = self._advance(leg)
            if reason is not None or leg.arrival is None:
                return self._result(reason or EndReason.TIME)
            place = leg.arrival
        return self._result(EndReason.EVENTS)

    # ---- where to go ---------------------------------------------------------------------

    def _leg(self, place: Place) -> _Leg | None:
        """The next motion; None beyond the border of the domain."""
        now = (self.time, self.state)
        if isinstance(place, InCell):
            self.log.ties(now, (place.cell,))
            return self._through(place.cell, frozenset())
        junction = junction_at(self.field, place, self.point)
        choices = choices_at(self.field, junction, self.theta, self.signs)
        if not choices:
            if junction.border:
                return None
            raise TrajectoryError(f"no Filippov continuation at {self.point}: please report this")
        chosen = choices[0]
        self.log.switch(now, place, choices, self.moved)
        if chosen.kind is EventKind.REST:
            motion = Rest(self.point, self.theta, chosen.rate)
            return _Leg(motion, self.field.place_name(place), chosen.cells, None)
        if chosen.kind is EventKind.SLIDE:
            return self._slide(chosen)
        cell = chosen.cells[0]
        if isinstance(place, OnEdge) and self.moved not in (None, (cell,)):
            spiral = self.turns.accumulation(place.edge, cell, self.point, self.theta)
            if spiral is not None:
                return self._spiral(spiral)
        return self._through(cell, next(frozenset(k for k, _ in sides) for own, sides in junction.cells if own == cell))

    def _through(self, cell: int, active: frozenset[int]) -> _Leg:
        """Through a cell, from the sides it has been entered by."""
        flow, name, slack = self.field.flows[cell][0], self.field.names[cell], self.signs.speed_slack
        if not any(self.signs(v, slack) for v in flow.velocity(self.point)):
            self.log.add((self.time, self.state), EventKind.REST, name, rates=(flow.omega, flow.omega))
            return _Leg(Rest(self.point, self.theta, flow.omega), name, (cell,), None)
        motion = Free(self.point, self.theta, flow)
        crossing = motion.first_crossing(self.field.cells.polygons[cell].sides, active, slack)
        if crossing is None:
            return _Leg(motion, name, (cell,), None)
        x, y, _ = motion.state(crossing.time)
        return _Leg(motion, name, (cell,), crossing.time, self._landing(cell, crossing.side, (x, y)))

    def _landing(self, cell: int, side: int, point: Point) -> Place:
        """The edge or corner at a point of a side."""
        cells = self.field.cells
        for number in cells.borders[cell][side]:
            r, edge = cells.direction(number), cells.edges[number]
            for corner in (edge.start, edge.end):
                if not cells.beyond(dot(r, minus(point, cells.points[corner]))):
                    return AtCorner(corner)
            if cells.on_edge(number, point):
                return OnEdge(number)
        raise TrajectoryError(f"no edge of {self.field.names[cell]} at {point}: please report this")

    def _slide(self, chosen: Choice) -> _Leg:
        slide, ray = chosen.slide, chosen.ray
        if slide is None or ray is None:
            raise TrajectoryError("required a slide with its ray: please report this")
        arrives = not self.field.cells.beyond(ray.reach - slide.reach)
        arrival: Place = AtCorner(ray.corner) if arrives else OnEdge(ray.edge)
        return _Leg(slide, self.field.place_name(OnEdge(ray.edge)), chosen.cells, slide.duration(), arrival)

    def _spiral(self, spiral: CornerSpiral) -> _Leg:
        place = AtCorner(spiral.turn.corner)
        name = self.field.place_name(place)
        note = "infinitely many switches accumulate at this corner"
        self.log.add((self.time, self.state), EventKind.CROSS, name, note=note)
        return _Leg(spiral, name, tuple(step.cell for step in spiral.turn.steps), spiral.limit()[0], place)

    def _repeats(self, place: Place, leg: _Leg) -> bool:
        """Whether the path enters a cell where it entered it before: then it is periodic."""
        if not isinstance(place, OnEdge) or not isinstance(leg.motion, Free):
            return False
        earlier = self.entries.setdefault((place.edge, leg.cells[0]), [])
        beyond = self.field.cells.beyond
        if any(not beyond(x - self.point[0]) and not beyond(y - self.point[1]) for x, y in earlier):
            return True
        earlier.append(self.point)
        return False

    def _skip_turns(self, place: Place) -> None:
        """Take all whole turns of a closed orbit at once that there is time for."""
        if self.until is None or not isinstance(place, OnEdge) or self.moved is None or len(self.moved) > 1:
            return
        crossing = (place.edge, self.moved)
        orbit = self.memory.closes(crossing, self.point, (self.time, self.theta), self.pieces)
        turns = 0 if orbit is None else orbit.turns_within(self.until - self.time)
        if orbit is None or not turns or orbit.gap * turns > self.field.cells.slack:
            return
        name = self.field.place_name(place)
        note = f"a closed orbit of period {float(orbit.period):.6g}: {turns} turns are taken at once"
        self.log.add((self.time, self.state), EventKind.CROSS, name, note=note)
        self.pieces.append(orbit.piece(turns))
        self.time, self.theta = self.time + turns * orbit.period, self.theta + turns * orbit.rotation
        self.memory = OrbitMemory(self.field.cells.slack)

    # ---- going there ---------------------------------------------------------------------

    def _advance(self, leg: _Leg) -> EndReason | None:
        """Move to the end of a leg, or as far as time allows; the reason, if the path ends there."""
        left = None if self.until is None else self.until - self.time
        cut = left is not None and (leg.duration is None or leg.duration > left)
        span = left if cut else leg.duration
        times = tuple(self.time + t for t in sample_times(leg.motion, span))
        end = None if span is None else self.time + span
        cells = tuple(self.field.names[cell] for cell in leg.cells)
        self.pieces.append(Piece(self.time, end, leg.place, cells, leg.motion.state, times))
        if self.watch is not None:
            self.watch.check(self.pieces[-1])
        self.moved = leg.cells
        if span is None:
            return self._forever(leg.motion)
        self.time = self.time + span
        self.point, self.theta = self._arrive(leg.motion, None if cut else leg.arrival, span)
        return EndReason.TIME if cut else None

    def _arrive(self, motion: Motion, place: Place | None, span: Any) -> tuple[Point, Any]:
        """Point and heading at the end of a leg: on the edge or corner itself, not a rounding beside it."""
        whole = place is not None and isinstance(motion, Slide)
        x, y, theta = motion.at(motion.reach) if whole and isinstance(motion, Slide) else motion.state(span)
        if isinstance(place, AtCorner):
            return self.field.cells.points[place.corner], theta
        if isinstance(place, OnEdge) and not self.field.exact:
            r = self.field.cells.direction(place.edge)
            off = cross(r, minus((x, y), self.field.cells.points[self.field.cells.edges[place.edge].start]))
            return (x + off * r[1], y - off * r[0]), theta
        return (x, y), theta

    def _forever(self, motion: Motion) -> EndReason:
        """Why a leg never ends; an equilibrium that is only approached is reached after infinite time."""
        if isinstance(motion, Rest):
            return EndReason.TURNING if self.signs(motion.rate, self.signs.rate_slack) else EndReason.REST
        if not isinstance(motion, Slide) or motion.stop is None:
            return EndReason.CIRCLES
        rate = motion.coefficients[4]
        (x, y), r = motion.point, motion.direction
        self.point = (x + motion.stop * r[0], y + motion.stop * r[1])
        self.time = math.inf
        self.theta = self.theta if not self.signs(rate, self.signs.rate_slack) else math.copysign(math.inf, rate)
        return EndReason.APPROACH

    def _result(self, reason: EndReason) -> Trajectory:
        end = End(self.time, self.state, reason)
        times, states = samples(self.pieces, end) if self.sampled else ((end.t,), (end.state,))
        events, pieces = tuple(self.log.events), tuple(self.pieces)
        return Trajectory(self.field.kinematics.value, "events", times, states, events, end, self.log.unique, pieces)
