"""The path of a body with mass and an outline: Newton-Euler equations, whose loads jump where wheels enter and leave.

Between such events the same wheels carry, and backward differentiation formulas follow the state
``(x, y, theta, w_x, w_y, omega)`` (:mod:`nonsmooth.analysis.dynamics.newton_euler`).  At an event only forces jump,
velocities do not: with ``g_i' != 0`` a wheel goes all the way under the body or beside it.  But where forces push back
to the edge from both sides, a wheel swings across it, ever faster and nearer, infinitely often.  Once a swing stays
within :data:`HELD` of the body's size, the wheel is held at the edge: weights mix the accelerations with and without it
so that ``g_i'' = 0``, which is the limit of such swings (Filippov), until a weight leaves [0, 1].
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from nonsmooth.analysis.bodies.body_stretch import DenseStep
from nonsmooth.analysis.bodies.first_change import first_change
from nonsmooth.analysis.bodies.mass_sets import MassSets
from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.tipping import tipping_edge
from nonsmooth.analysis.dynamics.newton_euler import (
    ABSOLUTE_TOLERANCE,
    RELATIVE_TOLERANCE,
    DynamicPath,
    RigidBody,
)
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import (
    End,
    EndReason,
    Event,
    EventKind,
    Piece,
    Trajectory,
    TrajectoryError,
)
from nonsmooth.symbolic.contact_set import require_elastic
from nonsmooth.symbolic.scene import Scene

ON_EDGE = 1e-10  # of the body's size: depths below are zero
HELD = 1e-6  # of the body's size: a wheel that swings across the edge by less is held there
MOST_EVENTS = 5_000


@dataclass(frozen=True)
class _Wheels:
    """The wheels that carry, and those held under the edge, ascending."""

    carrying: frozenset[int]
    held: tuple[int, ...] = ()


@dataclass
class _Log:
    """The path so far: steps with their dense outputs, events, evaluations, and how far each wheel swings."""

    times: list[float]
    states: list[Floats]
    dense: list[Any] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    swings: dict[int, float] = field(default_factory=dict)
    evaluations: int = 0

    def state(self, time: float) -> Floats:
        """State at a time within the path, shape (6,)."""
        k = int(np.searchsorted(self.times, time, side="right")) - 1
        return np.asarray(self.dense[min(max(k, 0), len(self.dense) - 1)](time))


class MassPath:
    """Follows one body."""

    def __init__(self, scene: Scene, model: ContactModel, body: RigidBody) -> None:
        """For a scene with a body, all its wheels in ``scene.wheels`` and in the model.

        Raises:
            ValueError: for a scene without a body.
            SceneError: for loads that are known for one set of wheels only.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        require_elastic(scene)
        self._scene, self._body = scene, body
        self._outline = MovingOutline(scene.body, model.positions)
        self._sets = MassSets(model, body, self._outline)
        self._edge = ON_EDGE * self._outline.size

    def follow(self, start: Sequence[float], until: float) -> DynamicPath:
        """The path from ``(x, y, theta)`` at rest.

        Raises:
            ValueError: for a last time that is not positive, numbers that are not finite, and a start where the body
                tips.
            TrajectoryError: where the integrator gives up.
        """
        state = np.array([*start, 0.0, 0.0, 0.0], float)
        if not (np.isfinite(state).all() and 0 < until < math.inf):
            raise ValueError(f"required a finite start and a positive last time, received {list(start)} and {until}")
        wheels = _Wheels(frozenset(np.flatnonzero(self._outline.depths(state[:3]) > 0).tolist()))
        if not self._sets.carry(wheels.carrying, state):
            raise ValueError("required a start where the body stands on its wheels, received one where it tips")
        log = _Log([0.0], [state])
        for _ in range(MOST_EVENTS):
            reason, signal = self._stretch(log, wheels, until)
            if reason is not None:
                return self._ended(log, wheels, reason)
            following, state = self._after(log, wheels, signal)
            self._note(log, wheels, following)
            wheels, log.states[-1] = following, state
            if not self._sets.carry(wheels.carrying, state):
                return self._ended(log, wheels, EndReason.TIPS)
        return self._ended(log, wheels, EndReason.EVENTS)

    # ---- between events --------------------------------------------------------------------------

    def _stretch(self, log: _Log, wheels: _Wheels, until: float) -> tuple[EndReason | None, int]:
        """Integrate until a signal changes; why the path ends there, or which signal it is."""
        from scipy.integrate import BDF

        start = log.times[-1]
        rate = partial(self._sets.rate, wheels.carrying, wheels.held)
        jacobian = None if wheels.held else partial(self._sets.jacobian, wheels.carrying)
        scale = np.array([self._outline.size, self._outline.size, 1.0])
        absolute = ABSOLUTE_TOLERANCE * np.concatenate([scale, self._sets.speed * scale / self._outline.size])
        solver = BDF(rate, start, log.states[-1], until, rtol=RELATIVE_TOLERANCE, atol=absolute, jac=jacobian)
        while solver.status == "running":
            before, message = solver.t, solver.step()
            if solver.status == "failed":
                raise TrajectoryError(f"the integrator stopped at t = {solver.t:.6g}: {message}")
            part = DenseStep(before, solver.t, solver.dense_output())
            found = first_change(partial(self._signals, wheels), part, first=before == start)
            self._keep(log, part, part.end if found is None else found[0])
            if found is not None:
                break
        log.evaluations += solver.nfev
        self._close(log, wheels, start)
        if found is None:
            return EndReason.TIME, -1
        return (EndReason.TIPS if found[1] == found[2] - 1 else None), found[1]

    def _signals(self, wheels: _Wheels, states: Floats) -> Floats:
        """What is positive while the same wheels carry: signed depths, weights of held wheels, the support's margin."""
        signs = np.full(self._outline.count, -1.0)
        signs[list(wheels.carrying)] = 1.0
        signed = signs * self._outline.depths(states[:, :3])
        columns = [signed]
        if wheels.held:
            signed[:, list(wheels.held)] = 1.0
            weights = np.array([self._sets.weights(wheels.carrying, wheels.held, state) for state in states])
            columns += [weights, 1 - weights]
        margins = self._sets.margins(wheels.carrying, states)
        return np.concatenate([*columns, margins[:, None]], axis=1)

    def _keep(self, log: _Log, part: DenseStep, end: float) -> None:
        """A step, up to a time, and how far each wheel has come from the edge in it."""
        log.dense.append(part.state)
        log.times.append(end)
        log.states.append(part.state(end))
        looks = part.state(np.linspace(part.start, end, 5)).T
        depths = np.abs(self._outline.depths(looks[:, :3])).max(axis=0)
        for wheel, reached in log.swings.items():
            log.swings[wheel] = max(reached, float(depths[wheel]))

    # ---- at events -------------------------------------------------------------------------------

    def _after(self, log: _Log, wheels: _Wheels, signal: int) -> tuple[_Wheels, Floats]:
        """The wheels after an event, and the state, whose velocity is tangent to the edges of wheels newly held."""
        state, count = log.states[-1], self._outline.count
        carrying, held = set(wheels.carrying), list(wheels.held)
        if signal >= count:  # a weight leaves [0, 1]
            place = signal - count
            wheel = held.pop(place % len(wheels.held))
            if place >= len(wheels.held):
                carrying.add(wheel)
            log.swings.pop(wheel, None)
            return _Wheels(frozenset(carrying), tuple(held)), state
        depths = self._outline.depths(state[:3])
        met = {signal, *np.flatnonzero(np.abs(depths) <= self._edge).tolist()} - set(held)
        swings = [k for k in met if log.swings.get(k, math.inf) < HELD * self._outline.size]
        if swings:
            kept = _Wheels(frozenset(carrying - set(swings)), tuple(sorted([*held, *swings])))
            if self._sets.can_hold(kept.carrying, kept.held, state):
                return kept, self._sets.tangent(kept.held, state)
        for wheel, rate in zip(met, self._outline.rates(state[:3], state[3:], list(met)), strict=True):
            (carrying.add if rate > 0 else carrying.discard)(wheel)
            log.swings[wheel] = 0.0
        return _Wheels(frozenset(carrying), tuple(held)), state

    def _note(self, log: _Log, before: _Wheels, after: _Wheels) -> None:
        """One event for each kind of change."""
        pose, held = tuple(log.states[-1][:3].tolist()), (frozenset(before.held), frozenset(after.held))
        swings = f"it swings there by less than {HELD:g} of the body's size; drawn is the mean"
        changes = (
            (EventKind.SLIDE, held[1] - held[0], "under the edge", swings),
            (EventKind.ENTER, after.carrying - before.carrying, "under the body", ""),
            (EventKind.LEAVE, (before.carrying | held[0]) - after.carrying - held[1], "beside the body", ""),
        )
        for kind, wheels, words, note in changes:
            if wheels:
                names = ", ".join(str(self._scene.wheels[k].index) for k in sorted(wheels))
                log.events.append(Event(log.times[-1], pose, kind, f"wheel {names} {words}", note=note))

    # ---- what is kept ----------------------------------------------------------------------------

    def _close(self, log: _Log, wheels: _Wheels, start: float) -> None:
        """Add the piece that began at a time."""
        names = tuple(str(self._scene.wheels[k].index) for k in sorted(wheels.carrying | frozenset(wheels.held)))
        times = tuple(time for time in log.times if time >= start)
        piece = Piece(start, log.times[-1], f"wheels {', '.join(names)}", names, partial(_pose, log, start), times)
        log.pieces.append(piece)

    def _ended(self, log: _Log, wheels: _Wheels, reason: EndReason) -> DynamicPath:
        poses = [tuple(state[:3].tolist()) for state in log.states]
        if reason is EndReason.TIPS:
            over = tipping_edge(self._scene, wheels.carrying, np.array(poses[-1]))
            log.events.append(Event(log.times[-1], poses[-1], EventKind.TIPS, over))
        end, pieces = End(log.times[-1], poses[-1], reason), tuple(log.pieces)
        times, kinematics = tuple(log.times), Kinematics.EXACT.value
        trajectory = Trajectory(kinematics, "dynamics", times, tuple(poses), tuple(log.events), end, True, pieces)
        arrays = np.array(log.times), np.array(log.states)
        return DynamicPath(self._body, self._sets.creep, *arrays, trajectory, log.evaluations, log.state)


def _pose(log: _Log, start: float, since: Any) -> tuple[float, ...]:
    return tuple(log.state(start + float(since))[:3].tolist())
