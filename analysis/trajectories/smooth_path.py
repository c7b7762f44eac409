"""Event-driven Filippov paths of smooth switched fields: DOP853 on a face, events polished on its dense output.

The path keeps to one face (a cell, a sliding mode, a point of rest) until one of its guards changes sign: a bound of
the face, a member's normal speed (tangential exit from sliding), or the existence of the mode itself
(:mod:`nonsmooth.analysis.trajectories.stretch`, which turns implicit where that is stiff).  Then the state is moved
onto the surfaces it met and all continuations are listed again (:mod:`nonsmooth.analysis.trajectories.faces`).
Switches that accumulate end at their limit (:mod:`nonsmooth.analysis.trajectories.loops`), and turns that get ever
faster without a limit in their mean (:mod:`nonsmooth.analysis.trajectories.whirls`).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, Face, FacedField, Surface, Vector
from nonsmooth.analysis.trajectories.face_motion import largest
from nonsmooth.analysis.trajectories.faces import FaceChoice, face_choices
from nonsmooth.analysis.trajectories.legs import Leg
from nonsmooth.analysis.trajectories.loops import LoopMemory
from nonsmooth.analysis.trajectories.lyapunov_watch import LyapunovWatch
from nonsmooth.analysis.trajectories.result import (
    End,
    EndReason,
    Event,
    EventKind,
    Piece,
    Trajectory,
    TrajectoryError,
    samples,
)
from nonsmooth.analysis.trajectories.stiffness import EXPLICIT, IMPLICIT
from nonsmooth.analysis.trajectories.stretch import Stretch, follow_face
from nonsmooth.analysis.trajectories.whirls import WHIRL_LOOP, SurfaceCrossing, last_turn, whirl_around
from nonsmooth.symbolic.numbers.work_limit import WorkMeter

RELATIVE_TOLERANCE = 1e-12  # of DOP853, per step; at 1e-13 rounding takes over
ABSOLUTE_TOLERANCE = 1e-13  # in units of the states' size
MAX_EVENTS = 2_000
MAX_WORK = 300_000  # evaluations of fields, some 25,000 steps of DOP853; paths of the built-in scenes take some hundred
SWITCH_WORK = 20  # that many evaluations cost as much as to look at one face where the path switches
MAX_STALLED = 20  # switches that may follow each other at one moment: more than there are faces at a point
REST_SPEED = 1e-9  # relative to the fields around a point: a slower motion is called rest
NEWTON_STEPS = 3  # onto surfaces from within their slack, where two steps reach rounding
CANCELLED = 2.0**-46  # of a coordinate: what moves leave of it is rounding then, and zero is as good
RULE = "the path drawn keeps to the surfaces if it can, with the velocity of least norm"


def follow_smooth(
    field: FacedField,
    start: Sequence[float],
    until: float,
    watch: LyapunovWatch | None = None,
    *,
    max_events: int = MAX_EVENTS,
    rtol: float = RELATIVE_TOLERANCE,
    atol: float | None = None,
    meter: WorkMeter | None = None,
) -> Trajectory:
    """Follow a Filippov solution from a state at time zero.

    Args:
        field: the field.
        start: initial state.
        until: last time.
        watch: bound on V' to check every piece against.
        max_events: number of events after which the path ends in any case.
        rtol: relative tolerance of DOP853.
        atol: absolute tolerance; None for :data:`ABSOLUTE_TOLERANCE` times the size of the states.
        meter: evaluations of fields after which the path ends in any case; None for :data:`MAX_WORK`.

    Raises:
        ValueError: for a start outside the domain.
        TrajectoryError: for a violated Lyapunov bound or a state without continuation.
    """
    atol = ABSOLUTE_TOLERANCE * field.size if atol is None else atol
    return _begun(field, start, until, watch, (rtol, atol), meter).follow(max_events)


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
        ValueError, TrajectoryError: as for :func:`follow_smooth`.
    """
    tolerances = RELATIVE_TOLERANCE * coarseness, ABSOLUTE_TOLERANCE * coarseness * field.size
    path = _begun(field, start, until, None, tolerances)
    return path.follow(MAX_EVENTS), tuple(path.legs)


def _begun(
    field: FacedField,
    start: Sequence[float],
    until: float,
    watch: LyapunovWatch | None,
    tolerances: tuple[float, float],
    meter: WorkMeter | None = None,
) -> _SmoothPath:
    x = np.array([float(value) for value in start])
    if not np.isfinite(x).all() or not field.faces_at(x):
        raise ValueError(f"required a start inside the domain of the cells, received {x.tolist()}")
    return _SmoothPath(field, x, until, watch, tolerances, meter or WorkMeter(MAX_WORK))


class _SmoothPath:
    """A path while it is being followed."""

    def __init__(
        self,
        field: FacedField,
        x: Vector,
        until: float,
        watch: LyapunovWatch | None,
        tolerances: tuple[float, float],
        meter: WorkMeter,
    ) -> None:
        self.field, self.until, self.watch, self.tolerances = field, until, watch, tolerances
        self.time, self.x, self.faces = 0.0, x, field.faces_at(x)
        self.before: Face | None = None
        self.step: float | None = None
        self.meter = meter
        self.stalled = 0
        self.events: list[Event] = []
        self.pieces: list[Piece] = []
        self.legs: list[Leg] = []
        self.unique: bool | None = True
        self.method = EXPLICIT
        self.memory = LoopMemory()
        self.crossings: deque[SurfaceCrossing] = deque(maxlen=2 * WHIRL_LOOP + 1)

    def follow(self, max_events: int) -> Trajectory:
        """Face after face."""
        reason = EndReason.TIME
        while self.time < self.until:
            choices = face_choices(self.field, self.faces, self.time, self.x)
            if not choices and not self.field.on_border(self.x):
                raise TrajectoryError(f"no Filippov continuation found at t = {self.time:.6g}, {self.x.tolist()}")
            if not choices or len(self.events) >= max_events:
                reason = EndReason.EVENTS if choices else EndReason.OUTSIDE
                break
            self.meter.left -= SWITCH_WORK * len(self.faces)
            if self.meter.left <= 0:
                reason = EndReason.STEPS
                break
            self._say(choices)
            self._advance(choices[0])
        end = End(self.time, tuple(self.x.tolist()), reason)
        times, states = samples(self.pieces, end)
        events, pieces = tuple(self.events), tuple(self.pieces)
        return Trajectory(self.field.kinematics, self.method, times, states, events, end, self.unique, pieces)

    def _advance(self, choice: FaceChoice) -> None:
        """Follow a face to its end, and a loop of crossings to its limit."""
        face = self.before = choice.motion.face
        stretch = follow_face(
            self.field,
            choice,
            (self.time, self.x),
            self.until,
            tolerances=self.tolerances,
            first_step=self.step,
            most_work=self.meter.left,
        )
        self.step = stretch.step
        self.meter.left -= stretch.work
        self.method = IMPLICIT if stretch.stiff else self.method
        self.stalled = self.stalled + 1 if stretch.times[-1] == stretch.times[0] else 0
        if self.stalled > MAX_STALLED:
            raise TrajectoryError(f"no progress at t = {self.time:.6g}, {self.x.tolist()}: please report this")
        self._add(_piece(stretch, face))
        self._arrive(float(stretch.times[-1]), stretch.end, [*face.keep, *stretch.met])
        self.legs.append(Leg(choice.motion, stretch, self.x))
        if stretch.met and not face.keep:
            self._look_for_limits(face, stretch.met[0])

    def _look_for_limits(self, face: Face, surface: Surface) -> None:
        """After a crossing: whether a loop of crossings ends in a limit, or its turns in their mean."""
        limit = self.memory.limit_after(self.time, self.x, face.name, self.until)
        if limit is not None:
            self._add(limit.piece)
            self._event(EventKind.CROSS, limit.piece.place, note="infinitely many switches accumulate here")
            around = [s for state in limit.states for other in self.field.faces_at(state) for s in other.keep]
            self._forget()
            self._arrive(limit.time, limit.x, around)
            return
        self.crossings.append(SurfaceCrossing(self.time, self.x, face.name, surface))
        turn = last_turn(self.crossings, self.field.size)
        if turn and self.time < self.until:
            self._whirl(turn)

    def _whirl(self, turn: Sequence[SurfaceCrossing]) -> None:
        """Follow the mean of small turns, at their corner, for as long as they last."""
        corner = onto(self.x, [crossing.surface for crossing in turn], self.field.size)
        motion = whirl_around(self.field.faces_at(corner), turn, self.time, corner)
        if motion is None:
            return
        self._forget()
        away = largest(self.x - corner) * self.field.unit
        self.x = corner
        note = f"turns around here without end, ever faster and nearer; drawn is their mean, within {away:.1g}"
        self._event(EventKind.SLIDE, motion.face.name, motion.weights(self.time, self.x), note=note)
        self._advance(FaceChoice(motion))

    def _forget(self) -> None:
        """Begin anew to look for loops of crossings."""
        self.memory = LoopMemory()
        self.crossings.clear()

    def _add(self, piece: Piece) -> None:
        self.pieces.append(piece)
        if self.watch is not None:
            self.watch.check(piece)

    def _arrive(self, time: float, x: Vector, surfaces: Sequence[Surface]) -> None:
        """Move a state onto the surfaces it has reached, and onto any other within the slack of it."""
        self.time, self.x = time, onto(x, surfaces, self.field.size)
        self.faces = self.field.faces_at(self.x)
        near = [surface for face in self.faces for surface in face.keep]
        if any(surface not in surfaces for surface in near):
            self.x = onto(self.x, list(dict.fromkeys(near)), self.field.size)
            self.faces = self.field.faces_at(self.x)

    # ---- what is said about it -----------------------------------------------------------

    def _say(self, choices: Sequence[FaceChoice]) -> None:
        """Events of a switch: what the path does, then whether it had to."""
        choice = choices[0]
        face, weights = choice.motion.face, choice.motion.weights(self.time, self.x)
        if not self._goes_on(face):
            self._say_switch(choice, weights)
        elif not choice.motion.weights_open:
            return
        notes = [f"keep to {c.motion.face.name}" for c in choices[1:]]
        if choice.free:
            notes.append("theta may drift at any rate of an interval" if choice.rates else "the weights are free")
        tied = [member.name for member in face.members if member.name in self.field.tied_members]
        if tied and self.unique is not False:
            notes.append(f"any mixture of the motions that tie in {tied[0]}")
        doubts = self._doubts(choice)
        if notes:
            self.unique = False
        elif doubts and self.unique:
            self.unique = None
        if notes or doubts:
            also = [f"also possible: {'; '.join(notes)}"] if notes else []
            perhaps = [f"perhaps possible: {'; '.join(doubts)}"] if doubts else []
            note = "; ".join([*also, *perhaps, RULE])
            self._event(EventKind.NONUNIQUE, face.name, weights, choice.rates, note)

    def _goes_on(self, face: Face) -> bool:
        """Whether a slide goes on, with weights found in another way."""
        return len(face.keep) == 1 and self.before is face

    def _say_switch(self, choice: FaceChoice, weights: tuple[tuple[str, float], ...]) -> None:
        """What the path does."""
        face, before = choice.motion.face, self.before
        if face.keep or (before is None and self._rests(choice)):
            self._event(EventKind.REST if self._rests(choice) else EventKind.SLIDE, face.name, weights, choice.rates)
        elif before is not None:
            self._event(EventKind.LEAVE if before.keep else EventKind.CROSS, self.faces[0].name)

    def _doubts(self, choice: FaceChoice) -> list[str]:
        """Continuations that are neither found nor excluded."""
        doubts = [] if choice.sure else ["another face, as the derivatives that decide vanish here"]
        if self.field.has_contact(self.x):
            doubts.append("a way into a cell squeezed between surfaces that touch here")
        return doubts

    def _rests(self, choice: FaceChoice) -> bool:
        """Whether the motion stands still (the drifting state apart)."""
        velocity = choice.motion(self.time, self.x)
        if self.field.heading is not None:
            velocity = np.delete(velocity, self.field.heading)
        return largest(velocity) <= REST_SPEED * largest(choice.motion.fields(self.time, self.x))

    def _event(
        self,
        kind: EventKind,
        surface: str,
        weights: tuple[tuple[str, float], ...] = (),
        rates: tuple[float, float] | None = None,
        note: str = "",
    ) -> None:
        self.events.append(Event(self.time, tuple(self.x.tolist()), kind, surface, weights, rates, note))


def _piece(stretch: Stretch, face: Face) -> Piece:
    names = tuple(member.name for member in face.members)
    times = tuple(stretch.times)
    return Piece(times[0], times[-1], face.name, names, stretch.state_since_start, times, stretch.states_since_start)


def onto(x: Vector, surfaces: Sequence[Surface], size: float) -> Vector:
    """The nearest state on some surfaces: Newton's method along their gradients, from within the slack.

    A coordinate that vanishes there is exactly zero: at a corner all fields may vanish, beside it they do not.
    """
    start = x
    for _ in range(NEWTON_STEPS if surfaces else 0):
        values = [surface.value(x) for surface in surfaces]
        if not any(values):
            break
        if len(surfaces) == 1:
            gradient = surfaces[0].gradient(x)
            move = gradient * (values[0] / float(gradient @ gradient))
        else:
            gradients = np.array([surface.gradient(x) for surface in surfaces])
            move = np.linalg.lstsq(gradients, np.array(values), rcond=SURFACE_SLACK)[0]
        if largest(move) > size:
            break
        x = x - move
    return x if x is start else np.where(np.abs(x) <= CANCELLED * np.abs(start), 0.0, x)
