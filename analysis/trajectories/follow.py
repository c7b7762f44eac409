"""One engine for every path: it follows a mode until a guard falls below zero, then asks the field what comes next.

A *mode* is a law of motion that holds for a while: the field of a cell, sliding on a surface, a set of wheels that
carries a body, speeds that a controller holds.  A *stepper* solves it, in steps with dense output
(:mod:`nonsmooth.analysis.trajectories.steppers`).  *Guards* are functions that are positive as long as the mode goes
on.  After every step they are looked at, and the first time at which one falls below zero is located on the dense
output.  There the *field* says which mode comes next, or why the path ends::

    follow(field, start, until, stepper) -> Path

So hysteresis, smoothing, sampling, outlines and inertia are fields, exact arcs and stiff methods are steppers, and
none of them follows anything itself.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from nonsmooth.analysis.fields.switched_field import NoVelocityError
from nonsmooth.analysis.trajectories.result import (
    End,
    EndReason,
    Event,
    EventKind,
    Piece,
    Samples,
    State,
    Trajectory,
    TrajectoryError,
)
from nonsmooth.symbolic.messages.under_way import is_watched, tell
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm

Rate: TypeAlias = Callable[[float, Floats], Floats]  # time derivative of the state at a time and a state
Interpolant: TypeAlias = Callable[[Any], Floats]  # of a time, as a state (n,); of times (m,), as states (n, m)

HALVINGS = 40  # of a step, in search of a moment at which a guard that starts at zero is positive
LATE = 2.0**-16  # of a step: by how much its dense output may miss an event
SAMPLED_PARTS = 12  # of an easy step: more than the extrema of a polynomial of the dense output's degree
ESCAPE = 1e-9  # of the time: in which a solution that escapes within a finite time grows e-fold where steps end
RELATIVE_ULPS = 4 * float(np.finfo(float).eps)  # the smallest that SciPy takes


# ---- steps ---------------------------------------------------------------------------------------


class DenseStep:
    """One step of a stepper, with the solution in between, which is made when it is first asked for.

    Attributes:
        start, end: times between which it holds.
        first, last: states at both.
        slopes: rates at both; None where the stepper does not know them.
        parts: of a path that is drawn, into how many a stretch of the step of a length is divided.
        easy: whether its error is far below the tolerance: the solution is nearly a polynomial of low degree there, and
            nothing but the size of the step keeps a guard from falling and rising more than once within it.
        work: evaluations of the rate that it took.
        again: takes the step once more, to a time within it; None where no stepper does, or it would come to the same.
    """

    def __init__(
        self,
        before: tuple[float, Floats],
        after: tuple[float, Floats],
        dense: Callable[[], Interpolant],
        *,
        slopes: tuple[Floats, Floats] | None = None,
        parts: Callable[[float], int] = lambda length: 1,
        easy: bool = False,
        work: int = 0,
    ) -> None:
        (self.start, self.first), (self.end, self.last) = before, after
        self._dense = dense
        self._interpolant: Interpolant | None = None
        self.slopes, self.parts, self.easy, self.work = slopes, parts, easy, work
        self.again: Callable[[float], DenseStep] | None = None

    def __call__(self, times: Any) -> Floats:
        """State at a time within the step, (n,), or states at many, (n, m)."""
        return self.between(times)

    @property
    def between(self) -> Interpolant:
        """The solution within the step."""
        if self._interpolant is None:
            self._interpolant = self._dense()
        return self._interpolant


class PolynomialInterpolant:
    """Polynomials through a step, one for each state.

    Args:
        t: time at which the step begins.
        unit: what the variable of the polynomials counts the time since then in.
        states: coefficients of each state, the first that where the step begins.
        value: of a variable and coefficients, one by one, linear in these.
    """

    def __init__(
        self,
        t: float,
        unit: float,
        states: Sequence[Sequence[float]],
        value: Callable[..., Any],
    ) -> None:
        self._start, self._unit, self._states, self._value = t, unit, states, value

    def __call__(self, times: Any) -> Floats:
        """The state at a time, or at many."""
        s = (times - self._start) / self._unit
        return np.array([self._value(s, *state) for state in self._states])

    def along(self, normal: Sequence[float], first: float) -> Callable[[float], float]:
        """A linear function of the state with a gradient, and a value where the step begins, as a function of time."""
        _, *others = np.dot(normal, self._states).tolist()
        return lambda time: float(self._value((time - self._start) / self._unit, first, *others))


class Stepper(Protocol):
    """A method for ``x' = rate(t, x)``."""

    def steps(self, rate: Any, t: Any, x: Any, until: Any) -> Iterator[DenseStep]:
        """Steps from a time and a state, one after the other, up to the last time."""


class Stretch(NamedTuple):
    """The solution of one mode: its steps, the last of which may end before its stepper meant it to.

    Attributes:
        times: at the ends of the steps, the event last.
        states: at those times.
        steps: dense output; none where a path keeps samples only.
    """

    times: list[float]
    states: list[Floats]
    steps: list[DenseStep]

    @property
    def end(self) -> Floats:
        """Last state."""
        return self.states[-1]

    def drawn(self) -> Iterator[Any]:
        """Times at which a path is drawn: the ends of the steps, and between them where they say so."""
        yield self.times[0]
        for step, (start, end) in zip(self.steps, pairwise(self.times), strict=False):
            parts = step.parts(end - start)
            yield from (start + k * (end - start) / parts for k in range(1, parts))
            yield end

    def at(self, time: float) -> Floats:
        """State at a time of the path."""
        k = bisect_right(self.times, time) - 1
        if k >= len(self.steps):
            return self.end
        return self.states[k] if time == self.times[k] else self.steps[k](time)

    def at_all(self, times: Floats) -> Floats:
        """States (m, n) at many times of the path: each step's dense output is asked once."""
        steps = np.searchsorted(self.times, times, side="right") - 1
        found = np.empty((len(times), self.end.size))
        by_step = np.argsort(steps, kind="stable")
        for numbers in np.split(by_step, np.flatnonzero(np.diff(steps[by_step])) + 1):
            if not numbers.size:
                continue
            k = int(steps[numbers[0]])
            if k >= len(self.steps):
                found[numbers] = self.end
            else:
                found[numbers] = self.steps[k](times[numbers]).T
                found[numbers[times[numbers] == self.times[k]]] = self.states[k]
        return found


# ---- guards, and where they fall -----------------------------------------------------------------


class Guards(ABC):
    """Some functions of time and state that are positive as long as a path keeps to its mode.

    Attributes:
        slacks: of each: a value above minus it is not yet below zero.  One that begins within it is expected to rise,
            and counts as fallen where it has passed the slack.
        looks: parts of every step at whose ends they are looked at.
        located: whether the time of a fall is looked for within a step; else it is where the step ends.
        crossed: whether a path stops only where a guard is below zero, as the next mode is told by its sign there.
    """

    slacks: Sequence[float] = (0.0,)
    looks = 1
    located = True
    crossed = False

    @abstractmethod
    def at(self, t: float, x: Floats) -> Sequence[float]:
        """All values at a time and a state."""

    def at_all(self, times: Sequence[float], states: Floats) -> list[Sequence[float]]:
        """The same at many times, with states (m, n)."""
        return [self.at(t, x) for t, x in zip(times, states, strict=True)]

    def one(self, k: int, t: float, x: Floats) -> float:
        """One of them at a time and a state."""
        return self.at(t, x)[k]

    def along(self, k: int, step: DenseStep) -> Callable[[float], float]:
        """One of them as a function of time within a step."""
        return lambda t: self.one(k, t, step(t))

    def slope(self, k: int, t: float, x: Floats, rate: Floats) -> float:
        """The derivative of one of them along the motion; zero where nobody asks for dips."""
        return 0.0


class GuardsOfStates(Guards):
    """Guards that do not depend on time and are known at many states at once: one state is the first of one."""

    @abstractmethod
    def values(self, states: Floats) -> Floats:
        """All of them at states (m, n), shape (m, k)."""

    def at(self, t: float, x: Floats) -> Sequence[float]:
        """At one state."""
        return self.values(x[None])[0].tolist()

    def at_all(self, times: Sequence[float], states: Floats) -> list[Sequence[float]]:
        """At many."""
        return self.values(states).tolist()


def first_event(
    guards: Guards, before: Sequence[float], after: Sequence[float], step: DenseStep
) -> tuple[float, int] | None:
    """The first time in a step at which a guard is below zero, and which guard that is.

    Where the slope of a guard turns from falling to rising within a step, or within its samples, the lowest value in
    between is looked for too, so that a short excursion is not stepped over.

    Args:
        guards: the functions.
        before: their values where the step begins.
        after: where it ends.
        step: its dense output.
    """
    if not guards.located:
        return next(((step.end, k) for k, value in enumerate(after) if value <= 0), None)
    below = next((k for k, slack in enumerate(guards.slacks) if before[k] < -slack), None)
    if below is not None:  # as where a path begins within the slack of a surface, on its other side
        return step.start, below
    parts = SAMPLED_PARTS if step.easy else guards.looks
    if parts == 1:
        searched = [
            k for k, slack in enumerate(guards.slacks) if after[k] < -slack or (step.slopes and _turns(guards, k, step))
        ]
        if not searched:
            return None
        marks, rows = [step.start, step.end], [before, after]
    else:
        marks, rows = _looked_at(guards, before, after, step, parts)
        fallen = (np.array(rows[1:]) < -np.array(guards.slacks)).any(axis=0)
        searched = list(range(len(before))) if step.easy else np.flatnonzero(fallen).tolist()
    found = []
    for k in searched:
        time = _first_fall(guards, k, [(t, row[k]) for t, row in zip(marks, rows, strict=True)], step)
        if time is not None:
            found.append((time, k))
    return min(found, default=None)


def _looked_at(
    guards: Guards, before: Sequence[float], after: Sequence[float], step: DenseStep, parts: int
) -> tuple[list[float], list[Sequence[float]]]:
    """Times that divide a step, and the values of all guards there."""
    marks = np.linspace(step.start, step.end, parts + 1).tolist()
    inner = step(np.array(marks[1:-1])).T
    return marks, [before, *guards.at_all(marks[1:-1], inner), after]


def _first_fall(guards: Guards, k: int, known: list[tuple[float, float]], step: DenseStep) -> float | None:
    """The first time at which one guard is below zero, from its values at some times of a step."""
    slack, value = guards.slacks[k], guards.along(k, step)

    for place, (before, after) in enumerate(pairwise(known)):
        if after[1] < -slack:
            time = _fall(value, slack, before, after)
            return _beyond(value, time, after[0]) if guards.crossed else time
        begin = known[max(place - 1, 0)]
        dips = step.easy and place > 0 and begin[1] > before[1] < after[1]
        found = _dip(value, slack, begin, after[0]) if dips or len(known) == 2 else None
        if found is not None:
            return found
    return None


def _turns(guards: Guards, k: int, step: DenseStep) -> bool:
    """Whether a guard falls where a step begins, and rises where it ends."""
    first, last = step.slopes or (step.first, step.last)
    return guards.slope(k, step.start, step.first, first) < 0 < guards.slope(k, step.end, step.last, last)


def _fall(
    value: Callable[[float], float], slack: float, before: tuple[float, float], after: tuple[float, float]
) -> float:
    """Time at which a guard falls through zero; through its slack, where it starts at zero and never rises."""
    (low, first), (high, last) = before, after
    if first > slack:
        return find_root(value, before, after)
    for k in range(1, HALVINGS):
        middle = low + (high - low) * 2.0**-k
        risen = value(middle)
        if risen > 0:
            return find_root(value, (middle, risen), after)
    return find_root(lambda t: value(t) + slack, (low, first + slack), (high, last + slack))


def _dip(value: Callable[[float], float], slack: float, before: tuple[float, float], high: float) -> float | None:
    """Time at which a guard falls through zero on its way to a lowest value below zero between two times."""
    from scipy.optimize import minimize_scalar

    lowest = minimize_scalar(value, bounds=(before[0], high), method="bounded")
    if lowest.fun >= -slack:
        return None
    return _fall(value, slack, before, (float(lowest.x), float(lowest.fun)))


def _ended(step: DenseStep, guards: Guards, time: float, k: int) -> tuple[DenseStep, float, Floats]:
    """The step in which a guard falls, as far as that, with the time and the state there.

    Between its ends a long step errs more than at them.  So it is taken once more, to where its dense output has the
    event; what is left of the guard there is so little that Newton's method needs one step.  Where that does not do, as
    for guards that hardly move, the dense output is believed.
    """
    if step.again is not None and not guards.crossed and step.start < time < step.end:
        shorter = step.again(time)
        rate = shorter.slopes[1] if shorter.slopes else np.zeros_like(shorter.last)
        slope = guards.slope(k, time, shorter.last, rate)
        later = -guards.one(k, time, shorter.last) / slope if slope else math.inf
        if abs(later) <= LATE * (time - step.start):
            state = shorter.last + later * rate
            if abs(guards.one(k, time + later, state)) <= guards.slacks[k]:
                shorter.work += step.work
                return shorter, time + later, state
    return step, time, step(time)


def find_root(value: Callable[[float], float], before: tuple[float, float], after: tuple[float, float]) -> float:
    """When a function that is positive at first falls through zero, down to rounding.

    Values of many states at once and of one alone may be rounded differently, so that a fall that was seen among many
    may be none here: then it is the later time.  Where the function is not positive to begin with, it is the earlier.

    Args:
        value: the function.
        before: a time, and the value there.
        after: a later time, and the value there, below zero.
    """
    if before[1] <= 0:
        return before[0]
    from scipy.optimize import brentq

    ends, finest = dict([before, after]), math.ulp(after[0])
    root = brentq(lambda t: ends[t] if t in ends else value(t), before[0], after[0], xtol=finest, rtol=RELATIVE_ULPS)
    return float(root)


def _beyond(value: Callable[[float], float], time: float, latest: float) -> float:
    """The first time from a root on, up to some ulps, at which a function is below zero."""
    step = float(np.spacing(latest))
    while time < latest and value(time) >= 0:
        time, step = min(time + step, latest), 2 * step
    return time


# ---- modes, and what follows them ----------------------------------------------------------------


class Mode(ABC):
    """A law of motion that holds until one of its guards falls.

    Attributes:
        place: what a piece of a path that follows it is called.
        cells: names of what it mixes.
        rate: what a stepper solves.
        guards: None where it goes on to the last time.
        shown: how many entries of the state a piece shows; None for all.
    """

    place: str
    cells: tuple[str, ...]
    rate: Any
    guards: Guards | None = None
    shown: int | None = None

    def passed(self, step: DenseStep, end: float) -> EndReason | None:
        """Take note of a step, which is followed up to a time; why the path ends with it, if no event does that."""
        return None

    def is_outlived(self, state: Floats) -> bool:
        """Whether the mode is kept where its law need not hold: that it cannot be followed there says nothing."""
        return False

    def piece(self, stretch: Stretch) -> Piece:
        """What is kept of the path."""
        start = stretch.times[0]

        def state(since: Any) -> State:
            return tuple(stretch.at(start + float(since))[: self.shown].tolist())

        def states(since: Floats) -> Floats:
            return stretch.at_all(start + since)[:, : self.shown]

        return Piece(start, stretch.times[-1], self.place, self.cells, state, stretch.drawn, states)


@dataclass
class Path:
    """A path while it is followed.

    Attributes:
        time, state: now.
        until: last time; None where a path is followed to its end, however long that takes.
        events, pieces, unique: see :class:`nonsmooth.analysis.trajectories.result.Trajectory`.
        stretches: the solutions of the modes so far.
        shown: how many entries of the state events and the trajectory show; None for all.
        reason: why it ended.
        note: why it is not followed any farther, where that is the reason.
    """

    time: Any
    state: Any
    until: Any
    shown: int | None = None
    events: list[Event] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    stretches: list[Stretch] = field(default_factory=list)
    unique: bool | None = True
    reason: EndReason = EndReason.TIME
    note: str = ""

    def tell(self, kind: EventKind, surface: str, **more: Any) -> None:
        """Note an event now."""
        self.events.append(Event(self.time, self.pose, kind, surface, **more))

    @property
    def pose(self) -> State:
        """What is shown of the state now, as a tuple."""
        return tuple(self.state[: self.shown].tolist() if isinstance(self.state, np.ndarray) else self.state)

    def at(self, time: float) -> Floats:
        """The whole state at a time of a path whose dense output is kept."""
        k = bisect_right(self.stretches, time, key=lambda stretch: stretch.times[0]) - 1
        return self.stretches[max(k, 0)].at(time)

    def ends_of_steps(self) -> tuple[Floats, Floats]:
        """All times (m,) at which a step ended, the start first, and the states (m, n) there."""
        first, *later = self.stretches
        times = [*first.times, *(time for stretch in later for time in stretch.times[1:])]
        states = [*first.states, *(state for stretch in later for state in stretch.states[1:])]
        return np.array(times), np.array(states)

    def trajectory(self, kinematics: str, method: str) -> Trajectory:
        """The path as it is handed back: by its pieces, or without any by the ends of all steps."""
        end = End(self.time, self.pose, self.reason, self.note)
        sampled: Samples = (end.t,), (end.state,)
        if self.stretches and not self.pieces:
            times, states = self.ends_of_steps()
            sampled = tuple(times.tolist()), tuple(map(tuple, states[:, : self.shown].tolist()))
        return Trajectory(kinematics, method, tuple(self.events), end, self.unique, tuple(self.pieces), sampled)


class HybridField(ABC):
    """What may be followed: modes, and which of them comes next.

    Attributes:
        dense: whether the solution between steps is kept, as pieces; else samples are kept only.
        shown: how many entries of a state are shown; None for all.
        keeps_beginnings: whether a path that cannot be followed any farther ends there, after its start.
    """

    dense = True
    shown: int | None = None
    keeps_beginnings = False

    @abstractmethod
    def next_mode(self, path: Path) -> Mode | EndReason:
        """How the path goes on from where it is, or why it ends."""

    def arrive(self, path: Path, mode: Mode, met: int | None) -> EndReason | None:
        """Note that the path has come to the end of a mode, where one of its guards fell (None: the time is over).

        May move the path, and say why it ends.
        """
        return None


@np.errstate(over="ignore", invalid="ignore")  # a trial beyond floats is refused, and a shorter one made
def follow(field: HybridField, start: tuple[Any, Any], until: Any, stepper: Stepper) -> Path:
    """The path of a field from ``(time, state)``, mode after mode.

    Raises:
        TrajectoryError: where it cannot be followed.
    """
    path = Path(*start, until, field.shown)
    while True:
        try:
            mode = field.next_mode(path)
        except TrajectoryError as error:
            if not (field.keeps_beginnings and path.stretches):
                raise
            path.reason, path.note = EndReason.UNPROVED, str(error)
            return path
        except NoVelocityError as error:
            if not path.stretches:
                raise TrajectoryError(str(error)) from error
            path.reason, path.note = EndReason.UNPROVED, str(error)
            return path
        if isinstance(mode, EndReason):
            path.reason = mode
            return path
        stretch, met, reason = _stretch(field, mode, path, stepper)
        path.time, path.state = stretch.times[-1], stretch.end
        path.stretches.append(stretch)
        if field.dense:
            path.pieces.append(mode.piece(stretch))
        ended = field.arrive(path, mode, met) or reason
        if ended is None and until is not None and path.time >= until:
            ended = EndReason.TIME
        if ended is not None:
            path.reason = ended
            return path


def _stretch(
    field: HybridField, mode: Mode, path: Path, stepper: Stepper
) -> tuple[Stretch, int | None, EndReason | None]:
    """One mode to its first event, or until the path ends; the guard that fell there, and why it ends."""
    stretch, guards = Stretch([path.time], [path.state], []), mode.guards
    values = None if guards is None else guards.at(path.time, path.state)
    steps = stepper.steps(mode.rate, path.time, path.state, path.until)
    while True:
        try:
            step = next(steps, None)
        except NoVelocityError as error:
            path.note = str(error)
            return stretch, None, EndReason.UNPROVED
        except TrajectoryError as error:
            if (field.keeps_beginnings and stretch.times[-1] > 0) or mode.is_outlived(stretch.end):
                path.note = str(error)
                return stretch, None, EndReason.UNPROVED
            if not escapes(mode, stretch.times[-1], stretch.end):
                raise
            return stretch, None, EndReason.ESCAPES
        if step is None:
            return stretch, None, None
        if path.until is not None and is_watched():
            tell(f"t = {float(step.end):.6g} of {float(path.until):.6g}")
        if field.dense:
            stretch.steps.append(step)
        if guards is not None and values is not None:
            following = guards.at(step.end, step.last)
            found = first_event(guards, values, following, step)
            if found is not None:
                last, time, state = _ended(step, guards, *found)
                mode.passed(last, time)
                if field.dense:
                    stretch.steps[-1] = last
                stretch.times.append(time)
                stretch.states.append(state)
                return stretch, found[1], None
            values = following
        stretch.times.append(step.end)
        stretch.states.append(step.last)
        reason = mode.passed(step, step.end)
        if reason is not None:
            return stretch, None, reason


def escapes(mode: Mode, time: float, state: Floats) -> bool:
    """Whether a state grows so fast that it leaves every bound, as far as floats see: by a factor e within
    :data:`ESCAPE` of the time, and no more slowly farther out, where a field that is singular here is not.
    """

    def growth(x: Floats) -> float:
        size = max_norm(x)
        return float(x / size @ mode.rate(time, x) / size) if size else 0.0

    here = growth(state)
    return math.isfinite(here) and here * ESCAPE * abs(time) > 1 and not growth(2 * state) < here
