"""The path of a body with an outline under a rule without cells, from event to event.

Between events the same wheels carry and the pose follows their motion, by LSODA with dense output; every step is
searched for wheels that come to the edge, and the time is refined until it is right to rounding.  There Filippov's
construction says how the body goes on (:mod:`nonsmooth.analysis.bodies.switching`).  Events: ``enter``, ``leave``,
``slide``.  The path ends in time, at rest, where the body tips, or after so much work.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nonsmooth.analysis.bodies.body_stretch import DenseStep, Parts
from nonsmooth.analysis.bodies.contact_sets import ContactSets, TippedError, Wheels
from nonsmooth.analysis.bodies.outline_path import OutlinePath, wheel_changes
from nonsmooth.analysis.bodies.switching import Mode, Switching
from nonsmooth.analysis.contact_rule import SmoothRule
from nonsmooth.analysis.dynamics.continuous_path import finite_start
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import End, EndReason, Event, Piece, Trajectory, samples
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.under_way import tell

ON_EDGE = 1e-10  # of the body's size: depths below are zero
MOST_EVENTS = 2_000  # stretches between events; a path that needs more may switch for ever
# Evaluations of pose rates along a path, a step counted as some: twenty seconds; with drag each takes ten times longer.
MOST_RATES, MOST_DRAGGED = 50_000, 6_000
OF_A_STEP = 12  # stages of a Runge-Kutta step, which follow regimes without asking for rates
RESTS = 1e-10  # speed relative to the fastest wheel's below which the body rests


@dataclass
class _Log:
    """The path so far."""

    pieces: list[Piece] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    unique: bool = True


@dataclass(frozen=True)
class _Stretch:
    """One solution between events: its end, and why it ends (None: a wheel comes to the edge)."""

    times: tuple[float, ...]
    state: Callable[[float], Floats]
    reason: EndReason | None


class BodyPath(OutlinePath):
    """Follows one body under a rule without cells."""

    def __init__(self, scene: Scene, rule: SmoothRule) -> None:
        """For a scene with a body, all its wheels in ``scene.wheels``.

        Raises:
            ValueError: for a scene without a body.
        """
        super().__init__(scene)
        self._sets = ContactSets(scene, rule)
        self._switching = Switching(self._sets, self._outline)
        fastest = max(abs(float(wheel.speed)) for wheel in scene.wheels)
        self._slow, self._scale = RESTS * fastest, self._outline.size / (fastest or 1.0)
        self._steps = 0
        self._edge_depth = ON_EDGE * self._outline.size

    def follow(self, start: Sequence[float], until: float) -> Trajectory:
        """The path from ``(x, y, theta)``, theta measured from the checked heading.

        Raises:
            ValueError: for a last time that is not positive, numbers that are not finite, and a start where the body
                tips.
            TrajectoryError: where the path cannot be followed.
        """
        pose, log, time = finite_start(start, until), _Log(), 0.0
        self._steps = self._sets.evaluations = 0
        try:
            mode = self._mode_at(pose)
        except TippedError:
            raise ValueError(
                "required a start where the body stands on its wheels, received one where it tips"
            ) from None
        while True:
            stretch = self._stretch(mode, pose, time, until)
            pose = stretch.state(stretch.times[-1])
            log.pieces.append(self._piece(mode, time, stretch.times, stretch.state))
            log.unique &= mode.unique
            time = stretch.times[-1]
            if stretch.reason is not None:
                return self._ended(log, time, pose, stretch.reason, mode.carrying)
            if len(log.pieces) >= MOST_EVENTS:
                return self._ended(log, time, pose, EndReason.EVENTS, mode.carrying)
            try:
                following = self._mode_at(pose, mode)
            except TippedError:
                return self._ended(log, time, pose, EndReason.TIPS, self._well_under(pose, mode))
            note = "" if following.unique else "other choices go on too"
            for kind, words in wheel_changes(self._scene, mode, following):
                log.events.append(Event(time, tuple(pose.tolist()), kind, words, note=note))
            mode = following

    # ---- modes -----------------------------------------------------------------------------------

    def _mode_at(self, pose: Floats, before: Mode | None = None) -> Mode:
        """How the body goes on from a pose; wheels that slide stay under the edge whatever rounding says."""
        depths = self._outline.depths(pose)
        near = {int(k) for k in np.flatnonzero(np.abs(depths) <= self._edge_depth)}
        if before is not None:
            near |= set(before.sliding)
        inside = frozenset(int(k) for k in np.flatnonzero(depths > 0) if int(k) not in near)
        if near:
            return self._switching.next_mode(pose, inside, sorted(near))
        if not self._sets.carries(inside, pose):
            raise TippedError
        return Mode(inside)

    def _stretch(self, mode: Mode, pose: Floats, start: float, until: float) -> _Stretch:
        """Integrate one mode until a wheel comes to the edge, a slide ends, the body tips or rests, or time is over."""
        weights = np.full(len(mode.sliding), 0.5)
        rate, weights = self._switching.rate(mode, pose, weights)
        if np.hypot(*rate[:2]) + abs(rate[2]) * self._outline.size <= self._slow:
            return _Stretch((start, start), lambda t: pose, EndReason.REST)
        times: list[float] = [start]
        dense: list[Any] = []
        parts = Parts(self._switching, mode, pose, self._scale, self._outline.size, drags=self._sets.is_stiff)
        for part in parts.from_pose(pose, start, until):
            dense.append(part.state)
            tell(f"t = {part.end:.6g} of {until:.6g}")
            found = self._first_change(mode, part, first=part.start == start)
            times.append(part.end if found is None else found[0])
            if found is not None:
                return _joined(times, dense, pose, EndReason.TIPS if found[1] == found[2] - 1 else None)
            if self._rests(part):
                return _joined(times, dense, pose, EndReason.REST)
            self._steps += 1
            if self._is_spent:
                return _joined(times, dense, pose, EndReason.STEPS)
        return _joined(times, dense, pose, EndReason.TIME)

    @property
    def _is_spent(self) -> bool:
        """Whether the path has taken all the work that it may."""
        if self._sets.is_stiff:
            return self._sets.evaluations >= MOST_DRAGGED
        return self._sets.evaluations + OF_A_STEP * self._steps >= MOST_RATES

    def _rests(self, part: DenseStep) -> bool:
        """Whether the body hardly moves in a step."""
        moved = np.abs(part.state(part.end) - part.state(part.start)) * [1.0, 1.0, self._outline.size]
        return bool(moved.max() <= self._slow * (part.end - part.start))

    def _weights(self, mode: Mode, state: Floats) -> Floats:
        return self._switching.rate(mode, state, np.full(len(mode.sliding), 0.5))[1]

    def _margins(self, carrying: Wheels, states: Floats) -> Floats:
        return self._sets.motion(carrying, states[0]).margins(states)

    # ---- what is kept ----------------------------------------------------------------------------

    def _well_under(self, pose: Floats, before: Mode) -> Wheels:
        """The wheels that carried the body and have not come to its edge."""
        depths = self._outline.depths(pose)
        return frozenset(k for k in before.carrying if depths[k] > self._edge_depth)

    def _ended(self, log: _Log, time: float, pose: Floats, reason: EndReason, carrying: Wheels) -> Trajectory:
        if reason is EndReason.TIPS:
            log.events.append(self._tipping(time, pose, carrying))
        end = End(time, tuple(pose.tolist()), reason)
        times, states = samples(log.pieces, end)
        return Trajectory(
            Kinematics.EXACT.value, "minimizer", times, states, tuple(log.events), end, log.unique, tuple(log.pieces)
        )


def _joined(times: list[float], dense: list[Any], pose: Floats, reason: EndReason | None) -> _Stretch:
    """A stretch from the steps of a solver."""
    if not dense:
        return _Stretch((times[0], times[0]), lambda t: pose, reason)
    borders = np.array(times[1:])

    def state(t: float) -> Floats:
        k = min(int(np.searchsorted(borders, t)), len(dense) - 1)
        return np.asarray(dense[k](t))

    return _Stretch(tuple(times), state, reason)
