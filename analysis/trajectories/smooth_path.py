"""Event-driven Filippov paths of smooth switched fields: faces as modes of the engine.

The path keeps to one face (a cell, a sliding mode, a point of rest) until one of its guards falls: a bound of the face,
a member's normal speed (tangential exit from sliding), or the existence of the mode itself
(:mod:`nonsmooth.analysis.trajectories.guards`).  Then the state is moved onto the surfaces it met and all continuations
are listed again (:mod:`nonsmooth.analysis.trajectories.faces`).  Switches that accumulate end at their limit
(:class:`LoopMemory`), and turns that get ever faster without a limit in their mean
(:mod:`nonsmooth.analysis.trajectories.guards`).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, Face, FacedField, Surface, length
from nonsmooth.analysis.trajectories.faces import FaceChoice, FaceMotion, face_choices, largest
from nonsmooth.analysis.trajectories.follow import DenseStep, HybridField, Mode, Path, Stepper, Stretch, escapes, follow
from nonsmooth.analysis.trajectories.guards import (
    GAIN_DOUBT,
    WHIRL_LOOP,
    FaceGuards,
    Guard,
    SurfaceCrossing,
    WhirlMotion,
    guards_of,
    last_turn,
    turning_gain,
    whirl_around,
)
from nonsmooth.analysis.trajectories.result import (
    EndReason,
    EventKind,
    LyapunovWatch,
    Piece,
    Trajectory,
    TrajectoryError,
)
from nonsmooth.analysis.trajectories.steppers import StiffAware
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite
from nonsmooth.symbolic.numbers.work_limit import WorkMeter

RELATIVE_TOLERANCE = 1e-12  # of DOP853, per step; at 1e-13 rounding takes over
ABSOLUTE_TOLERANCE = 1e-13  # in units of the states' size
MAX_EVENTS = 2_000
MAX_WORK = 300_000  # evaluations of fields, some 25,000 steps of DOP853; paths of the built-in scenes take some hundred
SWITCH_WORK = 20  # that many evaluations cost as much as to look at one face where the path switches
FAR = 1e150  # squares of what lies nearer are floats
LOOKS, LATE = 16, 1e-3  # at a slide at a corner, the last so near its end: whether other solutions leave it
MANY = 3  # surfaces; where more cross only the last of these is taken, since there are 3^n faces
MAX_STALLED = 20  # switches that may follow each other at one moment: more than there are faces at a point
REST_SPEED = 1e-9  # relative to the fields around a point: a slower motion is called rest
NEWTON_STEPS = 3  # onto surfaces from within their slack, where two steps reach rounding
CANCELLED = 2.0**-46  # of a coordinate: what moves leave of it is rounding then, and zero is as good
EXPLICIT, IMPLICIT = "events", "events, implicit (Radau) where stiff"
RULE = "the path drawn keeps to the surfaces if it can, with the velocity of least norm"

Weights: TypeAlias = tuple[tuple[str, float], ...]  # convex ones, by the names of members


def follow_legs(
    field: FacedField, start: Sequence[float], until: float, coarseness: float = 1.0
) -> tuple[Trajectory, tuple[Leg, ...]]:
    """The same solution with the motions of its stretches; limits of accumulating switches are no legs.

    Args:
        field: the field.
        start: initial state.
        until: last time.
        coarseness: factor on the tolerances of DOP853.

    Raises:
        ValueError, TrajectoryError: as for :func:`nonsmooth.analysis.trajectories.trajectory.follow_smooth`.
    """
    faces = FilippovFaces(field, None, WorkMeter(MAX_WORK), MAX_EVENTS)
    path = faces.path(start, until, near_rounding(field, coarseness))
    return path, tuple(faces.legs)


def near_rounding(field: FacedField, coarseness: float = 1.0) -> StiffAware:
    """The method of which paths are right to some 1e-12."""
    rtol, atol = RELATIVE_TOLERANCE * coarseness, ABSOLUTE_TOLERANCE * coarseness * field.size
    return StiffAware(rtol, atol, field.size)


class Leg(NamedTuple):
    """A stretch of a path with the motion that it follows.

    Attributes:
        motion: on the face that it keeps to.
        stretch: times, states and dense output; its end is not yet moved onto the surface it met.
        last: where it ends, on the surfaces it met.
        met: the surface it met at its end, if any.
    """

    motion: FaceMotion
    stretch: Stretch
    last: Floats
    met: tuple[Surface, ...]

    @property
    def start(self) -> float:
        """Time at which it begins."""
        return float(self.stretch.times[0])

    @property
    def end(self) -> float:
        """Time at which it ends."""
        return float(self.stretch.times[-1])

    @property
    def first(self) -> Floats:
        """Where it begins."""
        return self.stretch.states[0]

    def at(self, time: float) -> Floats:
        """State at a time of the path within the leg."""
        return self.stretch.at(time)


class FaceMode(Mode):
    """One of the motions on a face."""

    def __init__(
        self, field: FacedField, choice: FaceChoice, path: Path, meter: WorkMeter, further: Sequence[Guard]
    ) -> None:
        self.motion, self.rate = choice.motion, choice.motion.velocity
        self.place = self.motion.face.name
        self.cells = tuple(member.name for member in self.motion.face.members)
        self.guards = self._bounds = FaceGuards(guards_of(field, choice, path.time, path.state), further)
        self._meter, self._until = meter, path.until

    def met(self, guard: int | None) -> tuple[Surface, ...]:
        """The surface on which a guard falls, if it is one of the face's bounds."""
        surface = None if guard is None else self._bounds.surfaces[guard]
        return () if surface is None else (surface,)

    def further_met(self, guard: int | None) -> int | None:
        """Which of the further guards has fallen, if one has."""
        number = -1 if guard is None else guard - self._bounds.first_further
        return None if number < 0 else number

    def passed(self, step: DenseStep, end: float) -> EndReason | None:
        """Count the work, and look how far away it is."""
        self._meter.left -= len(self.cells) * step.work
        if not largest(step.last) <= FAR:
            return EndReason.FAR
        return EndReason.STEPS if self._meter.left <= 0 and end < self._until else None


class FilippovFaces(HybridField):
    """The solutions of a switched field, face after face.

    Attributes:
        legs: the stretches so far with their motions.
    """

    def __init__(self, field: FacedField, watch: LyapunovWatch | None, meter: WorkMeter, max_events: int) -> None:
        self.field, self.watch, self.meter, self.max_events = field, watch, meter, max_events
        self.faces: list[Face] = []
        self.before: Face | None = None
        self.legs: list[Leg] = []
        self._stalled = 0
        self._cells: dict[Face, FaceMode] = {}
        self._mean: FaceChoice | None = None  # of turns around a corner, which is followed next
        self._forget()

    def path(self, start: Sequence[float], until: float, stepper: Stepper) -> Trajectory:
        """The solution from a state at time zero.

        Raises:
            ValueError, TrajectoryError: as for :func:`nonsmooth.analysis.trajectories.trajectory.follow_smooth`.
        """
        x = np.array(start, float)
        self.faces = self.field.faces_at(x) if are_finite(x) else []
        if not self.faces:
            raise ValueError(f"required a start inside the domain of the cells, received {x.tolist()}")
        path = follow(self, (0.0, x), until, stepper)
        stiff = getattr(stepper, "was_stiff", False)
        return path.trajectory(self.field.kinematics, IMPLICIT if stiff else EXPLICIT)

    def next_mode(self, path: Path) -> Mode | EndReason:
        """The face that keeps to most surfaces, of those that the path may go on on."""
        choice, self._mean = self._mean, None
        if choice is None:
            choices = face_choices(self.field, self.faces, path.time, path.state)
            if not choices and not self.field.on_border(path.state):
                raise TrajectoryError(f"no Filippov continuation found {self._where(path)}")
            if not choices or len(path.events) >= self.max_events:
                return EndReason.EVENTS if choices else EndReason.OUTSIDE
            self.meter.left -= SWITCH_WORK * len(self.faces)
            if self.meter.left <= 0:
                return EndReason.STEPS
            self._say(path, choices)
            choice = choices[0]
        self.before = choice.motion.face
        return self._mode(choice, path)

    def _where(self, path: Path) -> str:
        """When and where a path is, in the scene's unit of length."""
        place = path.state.copy()
        lengths = [k for k in range(len(place)) if k != self.field.heading]
        place[lengths] *= self.field.unit
        return f"at t = {path.time:.6g}, {place_text(place.tolist())}"

    def _mode(self, choice: FaceChoice, path: Path) -> FaceMode:
        """The mode of a choice; that of a cell with flat bounds is the same wherever the path enters it."""
        face = choice.motion.face
        if face in self._cells:
            return self._cells[face]
        further = self.further_guards(choice)
        mode = FaceMode(self.field, choice, path, self.meter, further)
        if not face.keep and all(surface.flat for surface, _ in face.bounds):
            self._cells[face] = mode
        return mode

    def further_guards(self, choice: FaceChoice) -> Sequence[Guard]:
        """Guards beside those of the face."""
        return ()

    def arrive(self, path: Path, mode: Mode, met: int | None) -> EndReason | None:
        """Onto the surface that was met; after a loop of crossings, on to its limit."""
        if not isinstance(mode, FaceMode):
            raise TypeError(f"required a mode on a face, received {mode}")
        stretch, face, surfaces = path.stretches[-1], mode.motion.face, mode.met(met)
        self._stalled = self._stalled + 1 if stretch.times[-1] == stretch.times[0] else 0
        if self._stalled > MAX_STALLED:
            if escapes(mode, path.time, path.state):
                return EndReason.ESCAPES
            raise TrajectoryError(f"no progress {self._where(path)}: please report this")
        self._watch(path)
        others = self._others_along(mode.motion, stretch) if path.unique and len(face.keep) > 1 else ""
        if others:
            path.unique = False
            path.tell(EventKind.NONUNIQUE, face.name, note=f"also possible, before: {others}; {RULE}")
        self._move_onto(path, [*face.keep, *surfaces])
        self.legs.append(Leg(mode.motion, stretch, path.state, surfaces))
        if surfaces and not face.keep:
            self._look_for_limits(path, face, surfaces[0])
        return None

    def _others_along(self, motion: FaceMotion, stretch: Stretch) -> str:
        """What other solutions may do that leave somewhere along a slide at a corner; empty where none is seen."""
        if isinstance(motion, WhirlMotion):
            return ""
        first, last, seen = stretch.times[0], stretch.times[-1], None
        looks = LOOKS if len(motion.face.keep) <= MANY else 0
        for share in (*np.linspace(0, 1, looks, endpoint=False), 1 - LATE):
            t = first + float(share) * (last - first)
            x = stretch.at(t)
            if seen is not None and (x == seen).all():
                continue
            seen, faces = x, self.field.faces_at(x)
            if turning_gain(motion.face, faces, t, x) > 1 + GAIN_DOUBT:
                return "turns around it that grow"
            choices = face_choices(self.field, faces, t, x)
            if len(choices) > 1 and all(choice.sure for choice in choices):
                return f"keep to {choices[1].motion.face.name}"
        return ""

    def _look_for_limits(self, path: Path, face: Face, surface: Surface) -> None:
        """After a crossing: whether a loop of crossings ends in a limit, or its turns in their mean."""
        limit = self.memory.limit_after(path.time, path.state, face.name, path.until)
        if limit is not None:
            path.pieces.append(limit.piece)
            self._watch(path)
            path.tell(EventKind.CROSS, limit.piece.place, note="infinitely many switches accumulate here")
            around = [s for state in limit.states for other in self.field.faces_at(state) for s in other.keep]
            self._forget()
            path.time, path.state = limit.time, limit.x
            self._move_onto(path, around)
            return
        self.crossings.append(SurfaceCrossing(path.time, path.state, face.name, surface))
        turn = last_turn(self.crossings, self.field.size)
        if turn and path.time < path.until:
            self._whirl(path, turn)

    def _whirl(self, path: Path, turn: Sequence[SurfaceCrossing]) -> None:
        """Follow the mean of small turns, at their corner, for as long as they last."""
        corner = onto(path.state, [crossing.surface for crossing in turn], self.field.size)
        motion = whirl_around(self.field.faces_at(corner), turn, path.time, corner)
        if motion is None:
            return
        self._forget()
        away = largest(path.state - corner) * self.field.unit
        path.state = corner
        note = f"turns around here without end, ever faster and nearer; drawn is their mean, within {away:.1g}"
        path.tell(EventKind.SLIDE, motion.face.name, weights=motion.weights(path.time, path.state), note=note)
        self._mean = FaceChoice(motion)

    def _forget(self) -> None:
        """Begin anew to look for loops of crossings."""
        self.memory = LoopMemory()
        self.crossings: deque[SurfaceCrossing] = deque(maxlen=2 * WHIRL_LOOP + 1)

    def _watch(self, path: Path) -> None:
        if self.watch is not None:
            self.watch.check(path.pieces[-1])

    def _move_onto(self, path: Path, surfaces: Sequence[Surface]) -> None:
        """Move a state onto the surfaces it has reached, and onto any other within the slack of it."""
        path.state = onto(path.state, surfaces, self.field.size)
        self.faces = self.field.faces_at(path.state)
        near = [surface for face in self.faces for surface in face.keep]
        if any(surface not in surfaces for surface in near):
            path.state = onto(path.state, list(dict.fromkeys(near)), self.field.size)
            self.faces = self.field.faces_at(path.state)

    # ---- what is said about it -----------------------------------------------------------

    def _say(self, path: Path, choices: Sequence[FaceChoice]) -> None:
        """Events of a switch: what the path does, then whether it had to."""
        choice = choices[0]
        face, weights = choice.motion.face, choice.motion.weights(path.time, path.state)
        if not self._goes_on(face):
            self.tell_switch(path, choice, weights)
        elif not choice.motion.weights_open:
            return
        notes = [f"keep to {c.motion.face.name}" for c in choices[1:]]
        if choice.free:
            notes.append("theta may drift at any rate of an interval" if choice.rates else "the weights are free")
        tied = [member.name for member in face.members if member.name in self.field.tied_members]
        if tied and path.unique is not False:
            notes.append(f"any mixture of the motions that tie in {tied[0]}")
        doubts = self._doubts(path, choice)
        if notes:
            path.unique = False
        elif doubts and path.unique:
            path.unique = None
        if notes or doubts:
            also = [f"also possible: {'; '.join(notes)}"] if notes else []
            perhaps = [f"perhaps possible: {'; '.join(doubts)}"] if doubts else []
            note = "; ".join([*also, *perhaps, RULE])
            path.tell(EventKind.NONUNIQUE, face.name, weights=weights, rates=choice.rates, note=note)

    def _goes_on(self, face: Face) -> bool:
        """Whether a slide goes on, with weights found in another way."""
        return len(face.keep) == 1 and self.before is face

    def tell_switch(self, path: Path, choice: FaceChoice, weights: Weights) -> None:
        """What the path does."""
        face, before = choice.motion.face, self.before
        if before is not None and not face.keep:
            path.tell(EventKind.LEAVE if before.keep else EventKind.CROSS, self.faces[0].name)
            return
        rests = self._rests(path, choice)
        if face.keep or rests:
            kind = EventKind.REST if rests else EventKind.SLIDE
            path.tell(kind, face.name, weights=weights, rates=choice.rates)

    def _doubts(self, path: Path, choice: FaceChoice) -> list[str]:
        """Continuations that are neither found nor excluded."""
        doubts = [] if choice.sure else ["another face, as the derivatives that decide vanish here"]
        if self.field.has_contact(path.state):
            doubts.append("a way into a cell squeezed between surfaces that touch here")
        return doubts

    def _rests(self, path: Path, choice: FaceChoice) -> bool:
        """Whether the motion stands still (the drifting state apart)."""
        velocity = choice.motion(path.time, path.state)
        if self.field.heading is not None:
            velocity = np.delete(velocity, self.field.heading)
        return largest(velocity) <= REST_SPEED * largest(choice.motion.fields(path.time, path.state))


def onto(x: Floats, surfaces: Sequence[Surface], size: float) -> Floats:
    """The nearest state on some surfaces: Newton's method along their gradients, from within the slack.

    A coordinate that vanishes there is exactly zero: at a corner all fields may vanish, beside it they do not.
    """
    if not surfaces:
        return x
    start, is_plane = x, len(surfaces) == 1 and surfaces[0].flat
    for _ in range(1 if is_plane else NEWTON_STEPS):
        values = [surface.value(x) for surface in surfaces]
        if not any(values):
            break
        if len(surfaces) == 1:
            gradient = surfaces[0].gradient(x)
            move = gradient * (values[0] / gradient.dot(gradient))
        else:
            gradients = np.array([surface.gradient(x) for surface in surfaces])
            move = np.linalg.lstsq(gradients, np.array(values), rcond=SURFACE_SLACK)[0]
        if length(move) > size:
            break
        x = x - move
    if x is start:
        return x
    both = zip(x.tolist(), start.tolist(), strict=True)
    return np.array([0.0 if abs(now) <= CANCELLED * abs(before) else now for now, before in both])


# ---- accumulating switches -----------------------------------------------------------------------
#
# When a loop of crossings repeats with durations in a ratio q below one, the tail of the geometric series is the time
# left, and its error is about ``tail |change of q|/(1 - q)``.  As soon as that error is below ``ZENO_ERROR`` the limit
# of time and state is taken (Aitken's extrapolation).  Crossings get slower, and their times less sure: where the error
# begins to grow the limit before is taken, if it was below ``ZENO_NOISE``.  Loops that never get so regular, or whose
# durations fall more slowly than any geometric series, run on until the largest number of events, or until they are
# within the slack of a corner.


ZENO_ERROR = 1e-12  # relative to the time passed: the integrator's own error
ZENO_NOISE = 1e-9  # the same, where rounding keeps loops from getting more regular
ZENO_DRAWN = 1e-3  # relative to the time passed: longer tails are followed turn by turn
ZENO_ROUNDING = 1e-5  # of a coordinate in the last turn: what the limit leaves of it below is zero
ZENO_LOOP = 4  # longest loop of crossings that is recognized, in crossings


@dataclass(frozen=True)
class _Estimate:
    """The time and state of a limit, with an estimate of the error of the time, by the last two turns of a loop."""

    loop: int
    time: float
    x: Floats
    error: float


@dataclass(frozen=True)
class LoopLimit:
    """Limit of a loop.

    Attributes:
        time: limit time.
        x: extrapolated limit state.
        states: states at the crossings of the last loop.
        piece: what is left, drawn as a straight line.
    """

    time: float
    x: Floats
    states: list[Floats]
    piece: Piece


class LoopMemory:
    """The crossings of a path since it last slid or rested."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self.states: list[Floats] = []
        self.places: list[str] = []
        self._before: _Estimate | None = None

    def limit_after(self, time: float, x: Floats, place: str, until: float) -> LoopLimit | None:
        """Take note of a crossing out of ``place``; the limit, if a loop converges regularly before ``until``."""
        self.times.append(time)
        self.states.append(x)
        self.places.append(place)
        before, now = self._before, self._estimate()
        self._before = now
        if now is None:
            return None
        if now.error <= ZENO_ERROR * time:
            return self._limit(now) if now.time < until else None
        if before is None or now.error < before.error or before.error > ZENO_NOISE * time:
            return None
        return self._limit(before) if time < before.time < until else None

    def _estimate(self) -> _Estimate | None:
        """The surest one, by the loops that repeat; None where none does, or all tails are long enough to be drawn."""
        found = []
        for loop in range(1, ZENO_LOOP + 1):
            if len(self.times) < 3 * loop + 1 or self.places[-loop:] != self.places[-2 * loop : -loop]:
                continue
            turns = [self.times[k] - self.times[k - loop] for k in (-1 - 2 * loop, -1 - loop, -1)]
            if not turns[0] > turns[1] > turns[2] > 0:
                continue
            ratio = turns[2] / turns[1]
            factor = ratio / (1 - ratio)
            tail, change = turns[2] * factor, abs(ratio - turns[1] / turns[0])
            if tail < ZENO_DRAWN * self.times[-1]:
                x = self.states[-1] + (self.states[-1] - self.states[-1 - loop]) * factor
                found.append(_Estimate(loop, self.times[-1] + tail, x, tail * change / (1 - ratio)))
        return min(found, key=lambda estimate: estimate.error, default=None)

    def _limit(self, found: _Estimate) -> LoopLimit:
        start, here, tail = self.times[-1], self.states[-1], found.time - self.times[-1]
        turn = np.abs(self.states[-found.loop :]).max(axis=0)
        limit = np.where(np.abs(found.x) <= ZENO_ROUNDING * turn, 0.0, found.x)
        names = tuple(dict.fromkeys(self.places[-found.loop :]))

        def state(time: float) -> tuple[float, ...]:
            return tuple((here + (limit - here) * min(time / tail, 1.0)).tolist())

        piece = Piece(start, found.time, " | ".join(names), names, state, lambda: (start, found.time))
        return LoopLimit(found.time, limit, self.states[-found.loop :], piece)
