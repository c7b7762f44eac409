"""Filippov paths on cells with constant twist: closed forms as modes of the engine, from event to event.

At an edge or corner every continuation is listed (:func:`choices_at`) and one is followed to its end: through a cell to
its border, along an edge to where sliding ends, around a corner to the limit of infinitely many turns, or at rest.
There is no step size and no error that accumulates with time: a path is exact to the rounding of one closed form per
event, and exact altogether for exact numbers.

It fails where nothing is constant (feedback, plain systems): :mod:`nonsmooth.analysis.trajectories.smooth_path`.  A
path that spirals out of a corner is not drawn (the drawn path rests there), only said to exist.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.cell_complex import AtCorner, InCell, OnEdge, Place
from nonsmooth.analysis.cells.fan import Signs, departure_sign
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.trajectories.closed_forms import (
    CornerSpiral,
    Free,
    Junction,
    Ray,
    Rest,
    Slide,
    State,
    Turns,
    junction_at,
    signs_of,
    slide_along,
)
from nonsmooth.analysis.trajectories.follow import DenseStep, HybridField, Mode, Path, Stretch, follow
from nonsmooth.analysis.trajectories.result import (
    EndReason,
    EventKind,
    LyapunovWatch,
    Piece,
    Trajectory,
    TrajectoryError,
)
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import cross, dot, minus

# ---- where a path can go from a point on an edge or at a corner ----------------------------------
#
# Every Filippov continuation of a constant field.
#
# Near a point only the cells whose closure holds it matter: a fan of cones separated by rays.  The continuations are
#
# - *cross* into a cell whose velocity points into its own cone (by the turn of the velocity where it is tangent);
# - *slide* along a ray on which the neighbours' normal speeds do not have the same sign, where the equivalent control
#   moves away from the point (also between cells that both push away: one solution is enough);
# - *rest*, where the hull of the velocities holds zero; theta may then drift at any rate in an interval, found from
#   the basic solutions of ``sum l_k v_k = 0, sum l_k = 1, l >= 0``;
# - *turn* away: a full turn around the corner that lengthens the distance admits outward spirals, infinitely many.
#
# More than one, or a free rotation rate, means that the solution is not unique.  (Filippov 1988, sec. 4, 10, 16;
# Piiroinen & Kuznetsov 2008 for the events on a single surface.)  The path drawn rests if it can, else slides if it
# can, and drifts at the rate of smallest magnitude.


@dataclass(frozen=True)
class Choice:
    """One continuation: the kind of motion, the cells that take part and what defines it."""

    kind: EventKind
    cells: tuple[int, ...]
    weights: tuple[Any, ...] = ()
    ray: Ray | None = None
    slide: Slide | None = None
    rate: Any = None
    rates: tuple[Any, Any] | None = None
    free: bool = False


def choices_at(field: ConstantField, junction: Junction, theta: Any, signs: Signs) -> list[Choice]:
    """Every continuation: rest first, then slides, then crossings."""
    found = list(_rests(field, junction, signs))
    for ray in junction.rays:
        slide = slide_along(field, junction.point, theta, ray, signs)
        if slide is not None:
            weights = slide.weights(slide.position(0 * theta))
            found.append(Choice(EventKind.SLIDE, (ray.left, ray.right), weights, ray, slide, free=slide.free))
    for cell, sides in junction.cells:
        if enters(field, cell, sides, junction.point, signs):
            found.append(Choice(EventKind.CROSS, (cell,)))
    return found


def enters(field: ConstantField, cell: int, sides: Sequence[tuple[int, bool]], point: Point, signs: Signs) -> bool:
    """Whether a cell's velocity points into the cell; along the border of the domain it may also be tangent."""
    twist, polygon = field.flows[cell][0].about(point), field.cells.polygons[cell]
    if not any(signs(speed, signs.speed_slack) for speed in twist.velocity):
        return False
    outward = ((departure_sign(polygon.sides[side].normal, twist, signs), border) for side, border in sides)
    return all(sense < 0 or (sense == 0 and border) for sense, border in outward)


def _rests(field: ConstantField, junction: Junction, signs: Signs) -> Iterator[Choice]:
    """Rest, where the hull of the velocities holds zero, with the interval of rotation rates."""
    flows = [(cell, field.flows[cell][0]) for cell, _ in junction.cells]
    basic = list(zero_combinations([flow.velocity(junction.point) for _, flow in flows], signs))
    if not basic:
        return
    rates = [sum(w * flows[k][1].omega for k, w in combination.items()) for combination in basic]
    order = sorted(range(len(basic)), key=lambda i: rates[i])
    low, high = rates[order[0]], rates[order[-1]]
    lowest, highest = basic[order[0]], basic[order[-1]]
    zero = low * 0
    rate = min(max(zero, low), high)
    share = (rate - low) / (high - low) if signs(high - low, signs.rate_slack) else zero
    weights: dict[int, Any] = {}
    for combination, part in ((lowest, 1 - share), (highest, share)):
        for k, weight in combination.items():
            cell = flows[k][0]
            weights[cell] = weights.get(cell, zero) + part * weight
    kept = {cell: weight for cell, weight in weights.items() if weight}
    free = bool(share) or bool(signs(high - low, signs.rate_slack))
    yield Choice(EventKind.REST, tuple(kept), tuple(kept.values()), rate=rate, rates=(low, high), free=free)


def zero_combinations(vectors: Sequence[Point], signs: Signs) -> Iterator[dict[int, Any]]:
    """Basic solutions of ``sum l_k v_k = 0, sum l_k = 1, l >= 0``: one, two or three vectors each.

    By products only, so that exact numbers stay exact; ``basic_weights`` in floats serves any number of dimensions.
    """
    moving = []
    for k, (x, y) in enumerate(vectors):
        if signs(x, signs.speed_slack) or signs(y, signs.speed_slack):
            moving.append(k)
        else:
            yield {k: x * 0 + 1}
    turns = {(i, j): cross(vectors[i], vectors[j]) for i, j in combinations(moving, 2)}
    sense = {pair: signs(value, signs.product_slack) for pair, value in turns.items()}
    for i, j in turns:
        if not sense[i, j] and sign(dot(vectors[i], vectors[j])) < 0:
            a, b = dot(vectors[i], vectors[i]), -dot(vectors[i], vectors[j])
            yield {i: b / (a + b), j: a / (a + b)}
    for i, j, k in combinations(moving, 3):
        if sense[i, j] and sense[i, j] == sense[j, k] == -sense[i, k]:
            total = turns[i, j] + turns[j, k] - turns[i, k]
            yield {i: turns[j, k] / total, j: -turns[i, k] / total, k: turns[i, j] / total}


# ---- the path ------------------------------------------------------------------------------------


# Motions between events; a path of the built-in scenes has fewer than 20, a spiral of gain 0.99 some thousand.
MAX_LEGS = 10_000
RULE = "the path drawn rests if it can, else slides if it can, at the rate of smallest magnitude"
ARC_STEP = math.pi / 36  # turn between samples (radian): a drawn chord leaves its arc by less than 0.1 % of the radius
SLIDE_SAMPLES = 33  # along a slide whose speed varies
SPIRAL_SAMPLES = 129  # over a spiral whose turns accumulate; the first few turns are what can be seen

Motion: TypeAlias = Free | Slide | Rest | CornerSpiral


def follow_constant(
    field: ConstantField, start: Sequence[Any], until: Any | None, watch: LyapunovWatch | None
) -> Trajectory:
    """Follow a Filippov solution from ``(x, y, theta)``.

    Args:
        field: the field; over exact numbers the path is exact.
        start: initial pose.
        until: last time; None follows the path to its rest, however long that takes.
        watch: bound on V' to check every piece against.

    Raises:
        ValueError: for a start outside the domain.
        TrajectoryError: for a violated Lyapunov bound or a point without continuation.
    """
    return follow_cells(field, start, until, watch).trajectory(field.kinematics.value, "events")


def follow_cells(
    field: ConstantField, start: Sequence[Any], until: Any | None = None, watch: LyapunovWatch | None = None
) -> Path:
    """The same path without its samples."""
    place = None
    if all(math.isfinite(float(value)) for value in start):
        x, y, theta = (field.number(value) for value in start)
        place = field.cells.locate((x, y))
    if place is None:
        raise ValueError(f"required a start inside the domain of the cells, received ({start[0]}, {start[1]})")
    last = None if until is None or until == math.inf else field.number(until)
    return follow(_Cells(field, place, watch), (theta * 0, (x, y, theta)), last, _ClosedForms())


class _Leg(Mode):
    """A motion with the place it leads to; duration None never ends."""

    def __init__(
        self, motion: Motion, place: str, cells: tuple[str, ...], duration: Any | None, arrival: Place | None = None
    ) -> None:
        self.motion, self.rate = motion, self
        self.place, self.cells, self.duration, self.arrival = place, cells, duration, arrival

    def ends_by(self, start: Any, until: Any | None) -> bool:
        """Whether it comes to its end before the time is over."""
        return self.duration is not None and (until is None or start + self.duration <= until)

    def piece(self, stretch: Stretch) -> Piece:
        """The closed form itself."""
        start, end = stretch.times
        span = None if end == math.inf else end - start

        def drawn() -> Iterator[Any]:
            return (start + t for t in sample_times(self.motion, span))

        return Piece(start, None if span is None else end, self.place, self.cells, self.motion.state, drawn)


class _ClosedForms:
    """The stepper of closed forms: one step to the end of a leg, infinite where it has none, or to the last time."""

    def steps(self, leg: _Leg, t: Any, x: State, until: Any | None) -> Iterator[DenseStep]:
        """One step."""
        motion, end, last = leg.motion, until, x
        if leg.ends_by(t, until):
            end = t + leg.duration
            last = motion.at(motion.reach) if isinstance(motion, Slide) else motion.state(leg.duration)
        elif until is None:
            end = math.inf
        else:
            last = motion.state(until - t)
        yield DenseStep((t, x), (end, last), lambda: motion.state)  # type: ignore[arg-type, return-value]


class _Cells(HybridField):
    """The cells as a field to follow; ``moved`` are those of the last motion."""

    def __init__(self, field: ConstantField, place: Place, watch: LyapunovWatch | None) -> None:
        self.field, self.place, self.watch = field, place, watch
        self.signs = signs_of(field)
        self.turns = Turns(field, self.signs)
        self.moved: tuple[int, ...] | None = None
        self.entries: dict[tuple[int, int], list[Point]] = {}
        self.memory = OrbitMemory(field.cells.slack)
        self._tied: set[int] = set()

    # ---- where to go ---------------------------------------------------------------------

    def next_mode(self, path: Path) -> Mode | EndReason:
        """The next motion; beyond the border of the domain there is none."""
        if len(path.stretches) >= MAX_LEGS:
            return EndReason.EVENTS
        self._skip_turns(path)
        place, point = self.place, path.state[:2]
        if isinstance(place, InCell):
            self._tell_ties(path, (place.cell,))
            return self._through(path, place.cell, frozenset())
        junction = junction_at(self.field, place, point)
        choices = choices_at(self.field, junction, path.state[2], self.signs)
        if not choices:
            if junction.border:
                return EndReason.OUTSIDE
            raise TrajectoryError(f"no Filippov continuation at {point}: please report this")
        chosen, before = choices[0], self.moved
        self._tell_switch(path, place, choices)
        self.moved = chosen.cells
        if chosen.kind is EventKind.REST:
            motion = Rest(point, path.state[2], chosen.rate)
            return _Leg(motion, self.field.place_name(place), self._names(chosen.cells), None)
        if chosen.kind is EventKind.SLIDE:
            return self._slide(chosen)
        cell = chosen.cells[0]
        if isinstance(place, OnEdge) and before not in (None, (cell,)):
            spiral = self.turns.accumulation(place.edge, cell, point, path.state[2])
            if spiral is not None:
                return self._spiral(path, spiral)
        if path.until is None and isinstance(place, OnEdge) and self._repeats(place.edge, cell, point):
            return EndReason.CIRCLES
        return self._through(
            path, cell, next(frozenset(k for k, _ in sides) for member, sides in junction.cells if member == cell)
        )

    def _through(self, path: Path, cell: int, active: frozenset[int]) -> _Leg:
        """Through a cell, from the sides it has been entered by."""
        self.moved = (cell,)
        flow, name, slack = self.field.flows[cell][0], self.field.names[cell], self.signs.speed_slack
        point, theta = path.state[:2], path.state[2]
        if not any(self.signs(v, slack) for v in flow.velocity(point)):
            path.tell(EventKind.REST, name, rates=(flow.omega, flow.omega))
            return _Leg(Rest(point, theta, flow.omega), name, (name,), None)
        motion = Free(point, theta, flow)
        crossing = motion.first_crossing(self.field.cells.polygons[cell].sides, active, slack)
        if crossing is None:
            return _Leg(motion, name, (name,), None)
        x, y, _ = motion.state(crossing.time)
        return _Leg(motion, name, (name,), crossing.time, self._landing(cell, crossing.side, (x, y)))

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
        name = self.field.place_name(OnEdge(ray.edge))
        return _Leg(slide, name, self._names(chosen.cells), slide.duration(), arrival)

    def _spiral(self, path: Path, spiral: CornerSpiral) -> _Leg:
        place = AtCorner(spiral.turn.corner)
        name = self.field.place_name(place)
        path.tell(EventKind.CROSS, name, note="infinitely many switches accumulate at this corner")
        self.moved = tuple(step.cell for step in spiral.turn.steps)
        return _Leg(spiral, name, self._names(self.moved), spiral.limit()[0], place)

    def _repeats(self, edge: int, cell: int, point: Point) -> bool:
        """Whether the path enters a cell where it entered it before: then it is periodic."""
        earlier = self.entries.setdefault((edge, cell), [])
        beyond = self.field.cells.beyond
        if any(not beyond(x - point[0]) and not beyond(y - point[1]) for x, y in earlier):
            return True
        earlier.append(point)
        return False

    def _skip_turns(self, path: Path) -> None:
        """Take all whole turns of a closed orbit at once that there is time for."""
        place = self.place
        if path.until is None or not isinstance(place, OnEdge) or self.moved is None or len(self.moved) > 1:
            return
        x, y, theta = path.state
        orbit = self.memory.closes((place.edge, self.moved), (x, y), (path.time, theta), path.pieces)
        turns = 0 if orbit is None else orbit.turns_within(path.until - path.time)
        if orbit is None or not turns or orbit.gap * turns > self.field.cells.slack:
            return
        note = f"a closed orbit of period {float(orbit.period):.6g}: {turns} turns are taken at once"
        path.tell(EventKind.CROSS, self.field.place_name(place), note=note)
        path.pieces.append(orbit.piece(turns))
        path.time, path.state = path.time + turns * orbit.period, (x, y, theta + turns * orbit.rotation)
        self.memory = OrbitMemory(self.field.cells.slack)

    def _names(self, cells: Sequence[int]) -> tuple[str, ...]:
        return tuple(self.field.names[cell] for cell in cells)

    # ---- arriving there --------------------------------------------------------------------

    def arrive(self, path: Path, mode: Mode, met: int | None) -> EndReason | None:
        """Onto the edge or corner that a leg leads to; the reason, if the path ends there."""
        if not isinstance(mode, _Leg):
            raise TypeError(f"required a leg, received {mode}")
        piece = path.pieces[-1]
        if self.watch is not None:
            self.watch.check(piece)
        if piece.end is None:
            return self._forever(path, mode.motion)
        if mode.arrival is None or not mode.ends_by(piece.start, path.until):
            return EndReason.TIME
        path.state, self.place = self._arrived(path, mode), mode.arrival
        return None if path.until is None or path.time < path.until else self._last_words(path)

    def _arrived(self, path: Path, leg: _Leg) -> State:
        """The pose at the end of a leg: on the edge or corner itself, not a rounding beside it."""
        (x, y, theta), place = path.state, leg.arrival
        if isinstance(place, AtCorner):
            return *self.field.cells.points[place.corner], theta
        if isinstance(place, OnEdge) and not self.field.exact:
            r = self.field.cells.direction(place.edge)
            off = cross(r, minus((x, y), self.field.cells.points[self.field.cells.edges[place.edge].start]))
            return x + off * r[1], y - off * r[0], theta
        return x, y, theta

    def _last_words(self, path: Path) -> EndReason:
        """What happens where a path arrives just when its time is over."""
        mode = self.next_mode(path)
        if isinstance(mode, EndReason):
            return mode
        path.pieces.append(mode.piece(Stretch([path.time] * 2, [path.state] * 2, [])))
        return EndReason.TIME

    def _forever(self, path: Path, motion: Motion) -> EndReason:
        """Why a leg never ends; an equilibrium that is only approached is reached after infinite time."""
        path.time = path.pieces[-1].start
        if isinstance(motion, Rest):
            return EndReason.TURNING if self.signs(motion.rate, self.signs.rate_slack) else EndReason.REST
        if not isinstance(motion, Slide) or motion.stop is None:
            return EndReason.CIRCLES
        rate = motion.coefficients[4]
        (x, y), r, theta = motion.point, motion.direction, path.state[2]
        theta = theta if not self.signs(rate, self.signs.rate_slack) else math.copysign(math.inf, rate)
        path.time, path.state = math.inf, (x + motion.stop * r[0], y + motion.stop * r[1], theta)
        return EndReason.APPROACH

    # ---- what is said about it ---------------------------------------------------------------

    def _tell_switch(self, path: Path, place: OnEdge | AtCorner, choices: Sequence[Choice]) -> None:
        """The first choice is taken, coming from the motion of some cells, or from the start of the path."""
        chosen, surface, before = choices[0], self.field.place_name(place), self.moved
        weights = tuple(zip(self._names(chosen.cells), chosen.weights, strict=True)) if chosen.weights else ()
        kind = chosen.kind
        if kind is EventKind.CROSS and before is not None and len(before) > 1:
            kind = EventKind.LEAVE
        stays = before is None or before == chosen.cells
        if kind is not EventKind.CROSS or not stays:
            path.tell(kind, surface, weights=weights, rates=chosen.rates)
        notes = [self._described(other) for other in choices[1:]]
        if isinstance(place, AtCorner) and kind is EventKind.REST and self.turns.lead_outward(place.corner):
            notes.append("spiral outward")
        drift_only = not notes and chosen.free and chosen.rates is not None
        if chosen.free:
            notes.append("theta may drift at any rate of an interval" if chosen.rates else "the weights are free")
        if notes:
            path.unique = False
            note = f"also possible: {'; '.join(notes)}; {RULE}"
            more = {"weights": weights, "rates": chosen.rates, "note": note, "drift_only": drift_only}
            path.tell(EventKind.NONUNIQUE, surface, **more)
        self._tell_ties(path, chosen.cells)

    def _tell_ties(self, path: Path, cells: Sequence[int]) -> None:
        """Cells in which several motions tie leave the path open at every moment; said once for each."""
        for cell in cells:
            if cell not in self._tied and self.field.tied(cell):
                self._tied.add(cell)
                path.unique = False
                note = "also possible: any mixture of the motions that tie in this cell; the first is drawn"
                path.tell(EventKind.NONUNIQUE, self.field.names[cell], note=note)

    def _described(self, other: Choice) -> str:
        if other.kind is EventKind.CROSS:
            return f"cross into {self.field.names[other.cells[0]]}"
        if other.ray is not None:
            return f"slide along {self.field.place_name(OnEdge(other.ray.edge))}"
        return "rest"


# ---- samples: the ends of what is straight, enough for a drawing where it bends ------------------


def sample_times(motion: Motion, span: Any | None) -> tuple[Any, ...]:
    """Times since the start of a piece at which it is sampled, first zero, last ``span`` where that is finite."""
    if isinstance(motion, Slide) and span is None:
        return _approach(motion)
    if span is None:
        return (motion.theta * 0,)
    zero = span * 0
    if isinstance(motion, Free) and motion.flow.turn:
        return _even(span, max(1, math.ceil(abs(motion.flow.turn) * span / ARC_STEP)))
    bends = isinstance(motion, Slide) and (motion.coefficients[1] or motion.coefficients[3])
    if bends:
        return _even(span, SLIDE_SAMPLES - 1)
    if isinstance(motion, CornerSpiral) and isinstance(span, float):
        return _even(span, SPIRAL_SAMPLES - 1)
    return (zero, span) if span > zero else (zero,)


def _even(span: float, steps: int) -> tuple[float, ...]:
    return (*(span * k / steps for k in range(steps)), span)


def _approach(slide: Slide) -> tuple[float, ...]:
    """Times at which a slide has covered all but 2^-k of the way to the equilibrium it approaches."""
    if slide.stop is None:
        return (0.0,)
    return tuple(slide.time_to(slide.stop * (1 - 2.0**-k)) for k in range(SLIDE_SAMPLES))


# ---- closed orbits -------------------------------------------------------------------------------
#
# A path that crosses an edge from the same cell at the same point as before repeats itself, with its heading turned by
# the same angle each time.  So the state after any number of turns is a closed form, however many switches that are.
# In floats the orbit has to close so well that all turns together move it by less than the slack of a point; else it is
# followed turn by turn, until the largest number of motions ends it.  The search is Brent's: the entry after 1, 2, 4,
# 8, ... motions is remembered.


@dataclass(frozen=True)
class ClosedOrbit:
    """One turn of a path that repeats itself.

    Attributes:
        start: time at which the turn began.
        period: how long it took.
        rotation: by which angle the heading changed.
        gap: by how much it fails to close (length; zero for exact numbers).
        pieces: the motions of the turn.
    """

    start: Any
    period: Any
    rotation: Any
    gap: float
    pieces: tuple[Piece, ...]

    def turns_within(self, time: Any) -> int:
        """Number of whole turns in a time."""
        turns = math.floor(float(time / self.period))
        return max(turns - 1 if turns * self.period > time else turns, 0)

    def state(self, time: Any) -> State:
        """``(x, y, theta)`` a time after the turn that was computed."""
        turns = self.turns_within(time)
        moment = self.start + (time - turns * self.period)
        piece = next((p for p in reversed(self.pieces) if p.start <= moment), self.pieces[0])
        x, y, theta = piece.state(moment - piece.start)
        return x, y, theta + (turns + 1) * self.rotation

    def piece(self, turns: int) -> Piece:
        """So many turns as one piece of a path that follows the turn itself; its first turn is sampled."""
        begin, end = self.start + self.period, self.start + (turns + 1) * self.period
        places = dict.fromkeys(piece.place for piece in self.pieces)
        cells = dict.fromkeys(cell for piece in self.pieces for cell in piece.cells)

        def drawn() -> tuple[Any, ...]:
            sampled = dict.fromkeys(t + self.period for piece in self.pieces for t in piece.times)
            return tuple(sampled) if turns == 1 else (*sampled, end)

        return Piece(begin, end, " | ".join(places), tuple(cells), self.state, drawn)


@dataclass(frozen=True)
class _Entry:
    """Where a path crossed an edge: from which cell, at which point, when, with which heading, after which pieces."""

    crossing: tuple[int, tuple[int, ...]]
    point: Point
    time: Any
    theta: Any
    pieces: int


class OrbitMemory:
    """The crossing that a path is compared with."""

    def __init__(self, near: float) -> None:
        self.near = near  # length; zero for exact numbers
        self._crossings = 0
        self._anchor: _Entry | None = None

    def closes(
        self, crossing: tuple[int, tuple[int, ...]], point: Point, now: tuple[Any, Any], pieces: Sequence[Piece]
    ) -> ClosedOrbit | None:
        """Take note of a crossing at ``now = (time, heading)``; the orbit, if it closes here."""
        anchor, (time, theta) = self._anchor, now
        self._crossings += 1
        if anchor is not None and anchor.crossing == crossing:
            apart = [abs(a - b) for a, b in zip(anchor.point, point, strict=True)]
            if not any(apart) or (self.near and max(apart) <= self.near):
                turn = tuple(pieces[anchor.pieces :])
                gap = max(float(value) for value in apart)
                return ClosedOrbit(anchor.time, time - anchor.time, theta - anchor.theta, gap, turn)
        if self._crossings & (self._crossings - 1) == 0:
            self._anchor = _Entry(crossing, point, time, theta, len(pieces))
        return None
