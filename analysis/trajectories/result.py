"""What a simulation hands back: samples, events, pieces and how it ended; ready for JSON."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.symbolic.messages.notebook import ShortRepr, html_table
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm, norms

State: TypeAlias = tuple[Any, ...]
Samples: TypeAlias = tuple[tuple[Any, ...], tuple[State, ...]]  # times, and a state for each


class TrajectoryError(RuntimeError):
    """A simulation that cannot go on: a fault of this program or a field outside its assumptions."""


class EventKind(StrEnum):
    """What happens at an event."""

    CROSS = "cross"
    SLIDE = "slide"
    LEAVE = "leave"  # a surface of sliding; of a wheel, the body
    ENTER = "enter"  # of a wheel: it comes under the body
    TIPS = "tips"
    REST = "rest"
    NONUNIQUE = "nonunique"
    LIMIT = "limit"
    FREE = "free"


class EndReason(StrEnum):
    """Why a trajectory ends."""

    TIME = "the time is over"
    REST = "the body rests"
    TURNING = "the body turns in place forever"
    APPROACH = "an equilibrium is approached and never reached"
    CIRCLES = "the body follows a closed orbit forever"
    ESCAPES = "the solution grows beyond every bound within a finite time"
    FAR = "the solution grows beyond 1e150"
    OUTSIDE = "the body leaves the checked domain"
    TIPS = "the centre of mass leaves the support of the wheels: the body tips"
    WHEELS = "a wheel enters or leaves: the law is certified for the wheels before"
    LOADS = "a load of the load table becomes negative"
    EVENTS = "the largest number of events is reached"
    STEPS = "the largest number of steps is reached"
    UNPROVED = "what follows is not known"


UNFINISHED = frozenset({EndReason.EVENTS, EndReason.STEPS, EndReason.UNPROVED})  # where the solution goes on
BROKEN_OFF = UNFINISHED | {EndReason.OUTSIDE, EndReason.TIPS, EndReason.LOADS}  # and where it leaves what is followed


@dataclass(frozen=True)
class Event:
    """A switch, a stop or a branching.

    Attributes:
        t: time.
        state: state at that time.
        kind: what happens.
        surface: the edge, corner or switching functions concerned.
        weights: convex weights by cell, where the motion mixes several (equivalent control).
        rates: interval of possible rotation rates at rest, where it is known.
        note: what else there is to say: the choices and the rule that was followed, accumulating switches.
        drift_only: whether all that is open at a branching is the rate at which theta drifts at rest.
    """

    t: Any
    state: State
    kind: EventKind
    surface: str
    weights: tuple[tuple[str, Any], ...] = ()
    rates: tuple[Any, Any] | None = None
    note: str = ""
    drift_only: bool = False

    def record(self) -> dict[str, Any]:
        """JSON-ready."""
        entry: dict[str, Any] = {"t": _float(self.t), "state": _floats(self.state), "kind": self.kind.value}
        entry["surface"] = self.surface
        if self.weights:
            entry["weights"] = {name: _float(weight) for name, weight in self.weights}
        if self.rates is not None:
            entry["rates"] = [_float(rate) for rate in self.rates]
        if self.note:
            entry["note"] = self.note
        return entry


@dataclass(frozen=True)
class Piece:
    """A stretch of smooth motion.

    Attributes:
        start: time at which it begins.
        end: time at which it ends (None: never).
        place: the cell, edge or corner it keeps to.
        cells: the cells whose motions it mixes.
        state: state as a function of the time since ``start``.
        drawn: makes the :attr:`times`; a path that is not drawn does without.
        states: states (m, n) at many times since ``start`` at once, where the method has them.
    """

    start: Any
    end: Any | None
    place: str
    cells: tuple[str, ...]
    state: Callable[[Any], State] = field(repr=False, compare=False)
    drawn: Callable[[], Iterable[Any]] = field(repr=False, compare=False)
    states: Callable[[Floats], Floats] | None = field(repr=False, compare=False, default=None)

    @cached_property
    def times(self) -> tuple[Any, ...]:
        """Sample times within the piece, its start and (finite) end included."""
        return tuple(self.drawn())

    def record(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"start": _float(self.start), "end": _float(self.end), "place": self.place, "cells": list(self.cells)}


@dataclass(frozen=True)
class End:
    """Last state, when and why; an infinite time is ``inf``, a state without limit is not a number.

    Attributes:
        note: why what follows is not known; empty for every other reason.
    """

    t: Any
    state: State
    reason: EndReason
    note: str = ""

    @property
    def why(self) -> str:
        """The reason, with its note."""
        return f"{self.reason}: {self.note}" if self.note else str(self.reason)

    def record(self) -> dict[str, Any]:
        """JSON-ready, with the exact numbers beside the floats."""
        entry: dict[str, Any] = {"t": _float(self.t), "state": _floats(self.state), "reason": self.reason.value}
        if self.note:
            entry["note"] = self.note
        if not any(isinstance(value, float) for value in (self.t, *self.state)):
            entry["exact"] = {"t": str(self.t), "state": [str(value) for value in self.state]}
        return entry


@dataclass(frozen=True, repr=False)
class Trajectory(ShortRepr):
    """A Filippov solution.

    Attributes:
        kinematics: ``exact`` or ``leading`` for arrays, ``given`` for plain systems.
        method: ``events`` (``events, implicit (Radau) where stiff``, where that was needed), ``hysteresis``,
            ``smoothed``, ``dynamics`` or ``minimizer``.
        events: what happened, in order.
        end: last state and reason.
        unique: whether no other solution branches off along the way; None where the method does not look, or cannot
            tell.
        pieces: the smooth stretches.
        sampled: times and states of a method that keeps samples only, in place of pieces.
    """

    kinematics: str
    method: str
    events: tuple[Event, ...]
    end: End
    unique: bool | None
    pieces: tuple[Piece, ...] = ()
    sampled: Samples = ((), ())

    @property
    def times(self) -> tuple[Any, ...]:
        """Sample times, ascending (equal where a switch takes no time)."""
        return self._samples[0]

    @property
    def states(self) -> tuple[State, ...]:
        """One state per time."""
        return self._samples[1]

    @cached_property
    def _samples(self) -> Samples:
        return _samples(self.pieces, self.end) if self.pieces else self.sampled

    def _repr_html_(self) -> str:
        rows = [(float_text(e.t), e.kind, ", ".join(map(float_text, e.state)), e.surface, e.note) for e in self.events]
        head = f"{self.method}, {self.kinematics} kinematics: {self.end.reason} at t = {float_text(self.end.t)}"
        return html_table(head, ("t", "event", "state", "where", "note"), rows)

    def at(self, time: Any) -> State:
        """State at a time; before the start the first state, after the end the last.

        An exact trajectory reads a float as the binary fraction that it is, and answers exactly.

        Raises:
            ValueError: for a trajectory without pieces (comparison methods keep samples only).
        """
        if not self.pieces:
            raise ValueError(f"required a trajectory with pieces, received method {self.method}")
        if not isinstance(self.pieces[0].start, float):
            time = Fraction(float(time)) if isinstance(time, float | int) else time
        piece = next((p for p in reversed(self.pieces) if p.start <= time), self.pieces[0])
        if piece.end is not None and time >= piece.end:
            return self.end.state if piece is self.pieces[-1] else piece.state(piece.end - piece.start)
        return piece.state(max(time - piece.start, 0 * time))

    def sample(self, times: Iterable[float]) -> Floats:
        """States (m, n) at many times, as floats; on straight lines between samples where a method keeps these only."""
        asked = np.asarray(list(times), float)
        if not self.pieces:
            return np.column_stack([np.interp(asked, self.t, column) for column in self.array.T])
        if any(piece.states is None for piece in self.pieces):
            return np.array([_floats(self.at(time)) for time in asked.tolist()])
        found = np.empty((len(asked), len(self.end.state)))
        begun = np.searchsorted([piece.start for piece in self.pieces], asked, side="right")
        for k, piece in enumerate(self.pieces):
            covered = np.maximum(begun - 1, 0) == k
            if piece.states is not None and covered.any():
                last = np.inf if piece.end is None else piece.end - piece.start
                found[covered] = piece.states(np.clip(asked[covered] - piece.start, 0.0, last))
        if self.pieces[-1].end is not None:
            found[asked >= self.pieces[-1].end] = _floats(self.end.state)
        return found

    def in_lengths(self, length: float) -> Trajectory:
        """The same path of ``(x, y, theta)``, where x and y count a length, in the unit of that length."""
        if length == 1:
            return self
        return self._with_states(lambda state: (state[0] * length, state[1] * length, *state[2:]))

    def shifted(self, x: float, y: float) -> Trajectory:
        """The same path of ``(x, y, theta)``, measured from the point ``(-x, -y)``."""
        if not (x or y):
            return self
        return self._with_states(lambda state: (state[0] + x, state[1] + y, *state[2:]))

    def _with_states(self, seen: Callable[[State], State]) -> Trajectory:
        """The same path with all its states mapped."""

        def later(piece: Piece) -> Piece:
            return replace(piece, state=lambda time: seen(piece.state(time)), states=None)

        return replace(
            self,
            sampled=(self.sampled[0], tuple(map(seen, self.sampled[1]))),
            events=tuple(replace(event, state=seen(event.state)) for event in self.events),
            end=replace(self.end, state=seen(self.end.state)),
            pieces=tuple(map(later, self.pieces)),
        )

    @property
    def t(self) -> Floats:
        """Sample times (m,) as floats."""
        return np.array(_floats(self.times))

    def dense(self, count: int, until: float = math.inf) -> tuple[Floats, Floats]:
        """Sample times with more between them, and the states there: arcs look round.

        The samples themselves where there are no pieces.

        Args:
            count: of times that are added, evenly.
            until: the last of these at most.
        """
        times = self.t
        if not self.pieces:
            return times, self.array
        even = np.linspace(times[0], min(float(times[-1]), until), count)
        finer = np.unique(np.concatenate([times[np.isfinite(times)], even]))
        return finer, self.sample(finer.tolist())

    @property
    def array(self) -> Floats:
        """Sampled states (m, n) as floats."""
        return np.array([_floats(state) for state in self.states])

    def record(self) -> dict[str, Any]:
        """JSON-ready: ``kinematics, method, t, state, events, pieces, end, unique``."""
        return {
            "kinematics": self.kinematics,
            "method": self.method,
            "t": _floats(self.times),
            "state": [_floats(state) for state in self.states],
            "events": [event.record() for event in self.events],
            "pieces": [piece.record() for piece in self.pieces],
            "end": self.end.record(),
            "unique": self.unique,
        }


def _samples(pieces: Sequence[Piece], end: End) -> Samples:
    """Sample times and states of pieces that follow each other; a shared end is listed once."""
    times: list[Any] = []
    states: list[State] = []
    for piece in pieces:
        for time in piece.times:
            if not times or time != times[-1]:
                times.append(time)
                states.append(piece.state(time - piece.start))
    if not times or (times[-1] != end.t and end.t != math.inf):
        times.append(end.t)
        states.append(end.state)
    elif times[-1] == end.t:
        states[-1] = end.state
    return tuple(times), tuple(states)


def _float(value: Any) -> float | None:
    """A JSON number, or None where it is not finite."""
    if value is None:
        return None
    number = float(value)
    return number if math.isfinite(number) else None


def _floats(values: Iterable[Any]) -> list[float | None]:
    return [_float(value) for value in values]


# ---- a watch on every piece ----------------------------------------------------------------------
#
# V may not rise faster than the certified bound on V'.  The watch compares what the integrator did, states and times,
# with that bound; it does not know how that was computed.


class LyapunovViolationError(RuntimeError):
    """V rose faster than its certified bound: the path or the bound is wrong, which is a fault of this program."""

    def __init__(self, place: str, rise: float, allowed: float, duration: float) -> None:
        super().__init__(
            f"required V to rise by at most {allowed:.6g} within {duration:.6g} on {place}, received {rise:.6g}: "
            "the path contradicts the certified bound on V'; please report this"
        )
        self.place, self.rise, self.allowed, self.duration = place, rise, allowed, duration


@dataclass(frozen=True)
class LyapunovWatch:
    """Certified bounds on V' by cell.

    Attributes:
        value: V of a state.
        bounds: largest V' by cell name (V/time).
        slack: rise that is rounding (zero for exact numbers).
    """

    value: Callable[[Sequence[Any]], Any]
    bounds: dict[str, Any]
    slack: float = 0

    def check(self, piece: Piece) -> None:
        """Compare every stretch between two samples of a piece with the bound of its cells.

        Raises:
            LyapunovViolationError: where V rises faster than any of the cells allows.
        """
        known = [self.bounds[name] for name in piece.cells if name in self.bounds]
        if not known or len(piece.times) < 2:
            return
        bound = max(known)
        values = [self.value(piece.state(time - piece.start)) for time in piece.times]
        for k in range(1, len(values)):
            lasted = piece.times[k] - piece.times[k - 1]
            rise, allowed = values[k] - values[k - 1], bound * lasted
            if rise > allowed + self.slack:
                raise LyapunovViolationError(piece.place, float(rise), float(allowed), float(lasted))


# ---- how a path ends -----------------------------------------------------------------------------
#
# How a path ends: at rest since a time, creeping, or moving; read off the path itself, not off why it was cut.
#
# The speed of a state is the size of its rate.  Of a body ``(x, y, theta)`` that is ``|c'| + r |theta'|``, with r its
# size: no point of it within r is faster.  Speeds are means over :data:`PARTS` equal parts of the time, by the dense
# output of the engine, so that chatter about a place of rest is rest as far as it stays there.  With the path's unit of
# speed u (the fastest rim of an array, the fastest part of the path of a plain system) a path ends
#
# - *at rest since t*, where the mean speed is at most :data:`REST` u, or rounding of the states, in the last part and
#   from t on: t is the time at which that begins, by bisection of the part before on the dense output, so an arrival in
#   finite time is met to rounding;
# - *creeping at v*, where it is at most :data:`CREEP` u in the last part;
# - *moving at v*, where it is more.
#
# A point that is only approached is at rest in this sense once what is left of the speed is that small.  All of it is
# about the time that was followed, in floats, and proves nothing of later times.


PARTS = 1_000  # of the time
ROUNDING = 2.0**-50  # of the states: a way in a part of the time that is rounding, of some ulps
REST = 1e-5  # of the unit of speed; sticking under full dynamics is a creep of 1e-6
CREEP = 1e-2
BISECTIONS = 40
FOR_EVER = (EndReason.TURNING, EndReason.CIRCLES)  # what never ends, of paths without a last time


class EndMotion(StrEnum):
    """How a path ends."""

    AT_REST = "at rest"
    CREEPS = "creeps"
    MOVING = "moving"


@dataclass(frozen=True)
class Ending:
    """The end of a path.

    Attributes:
        motion: see the module.
        since: time from which it is at rest; None where it is not.
        speed: mean speed in the last part, of ``(x, y)`` alone where the state is a pose (length/time).
        turning: mean rate of theta in the last part (radian/time); None where the state is no pose.
    """

    motion: EndMotion
    since: float | None
    speed: float
    turning: float | None = None

    def record(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"motion": self.motion.value, "since": self.since, "speed": self.speed, "turning": self.turning}


def parts_of(path: Trajectory) -> Floats:
    """The ends of the parts of its time (PARTS + 1,); of a path without a last time up to its last sample."""
    last = float(path.end.t) if math.isfinite(float(path.end.t)) else float(path.times[-1])
    return np.linspace(0.0, last, PARTS + 1)


def ending(path: Trajectory, size: float | None = None, fastest: float = 0.0) -> Ending:
    """How a path ends.

    Args:
        path: of poses, or of the states of a plain system.
        size: r of a body; None for plain systems.
        fastest: a lower bound for the unit of speed, which is else the largest mean speed of a part.
    """
    times = parts_of(path)
    states = path.sample(times)
    length = times[1] - times[0]
    if not length:  # it ends where it begins
        return Ending(EndMotion.AT_REST, 0.0, 0.0, None if size is None else 0.0)

    def moved(first: Floats, last: Floats) -> Floats:
        apart = np.abs(last - first)
        if size is None:
            return np.asarray(np.linalg.norm(apart, axis=-1))
        return norms(apart) + size * apart[..., 2]

    speeds = moved(states[:-1], states[1:]) / length
    unit = max(fastest, float(speeds.max()))
    slow = max(REST * unit, ROUNDING * max_norm(states) / length)
    final = states[-1] - states[-2]
    shift = final if size is None else final[:2]
    speed, turning = float(np.linalg.norm(shift) / length), None if size is None else float(final[2] / length)
    if path.end.reason in FOR_EVER:
        return Ending(EndMotion.MOVING, None, speed, turning)
    if path.end.reason is EndReason.REST or speeds[-1] <= slow:
        since = _rest_begins(times, speeds, slow, lambda t, late: _mean(path, moved, t, late))
        return Ending(EndMotion.AT_REST, since, speed, turning)
    return Ending(EndMotion.CREEPS if speeds[-1] <= CREEP * unit else EndMotion.MOVING, None, speed, turning)


def _mean(path: Trajectory, moved: Callable[[Floats, Floats], Floats], t: float, late: float) -> float:
    first, last = path.sample([t, late])
    return float(moved(first, last)) / (late - t)


def _rest_begins(times: Floats, speeds: Floats, slow: float, mean: Callable[[float, float], float]) -> float:
    """The time from which the mean speed is at most ``slow``: within the last part that is faster."""
    fast = np.flatnonzero(speeds > slow)
    if not fast.size:
        return 0.0
    part = int(fast[-1])
    if part + 1 == len(speeds):  # the engine ended it where it came to rest
        return float(times[-1])
    low, high = float(times[part]), float(times[part + 1])
    late = high
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if middle >= late or mean(middle, late) <= slow:
            high = middle
        else:
            low = middle
    return high
