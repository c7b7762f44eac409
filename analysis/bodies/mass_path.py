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
from nonsmooth.analysis.bodies.mixing import balancing_weights, mixed_of, subsets_of
from nonsmooth.analysis.bodies.outline_path import OutlinePath, Wheels, wheel_changes
from nonsmooth.analysis.bodies.some_contacts import contacts_of
from nonsmooth.analysis.bodies.switching import Mode
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.dynamics.continuous_path import finite_start
from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.dynamics.newton_euler import (
    CREEP,
    RELATIVE_TOLERANCE,
    DynamicPath,
    NewtonEuler,
    RigidBody,
    absolute_tolerances,
    speed_scale,
)
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import End, EndReason, Event, EventKind, Piece, Trajectory, TrajectoryError
from nonsmooth.symbolic.contact_set import require_elastic
from nonsmooth.symbolic.scene import Scene

ON_EDGE = 1e-10  # of the body's size: depths below are zero
HELD = 1e-6  # of the body's size: a wheel that swings across the edge by less is held there
MOST_EVENTS = 5_000
DIFFERENCE = 1e-5  # of the time in which the body crosses itself: step of the edge's turning; errs by its square
DAMPING = 10.0  # times a crossing at which what rounding and tolerance leave of g and g' of a held wheel is taken back


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


class MassPath(OutlinePath):
    """Follows one body; the wheels that slide in a mode are held under its edge."""

    def __init__(self, scene: Scene, model: ContactModel, body: RigidBody) -> None:
        """For a scene with a body, all its wheels in ``scene.wheels`` and in the model.

        Raises:
            ValueError: for a scene without a body.
            SceneError: for loads that are known for one set of wheels only.
        """
        super().__init__(scene)
        require_elastic(scene)
        self._model, self._body = model, body
        self._speed = speed_scale(model, np.zeros(3))
        self._equations: dict[Wheels, NewtonEuler] = {}

    def follow(self, start: Sequence[float], until: float) -> DynamicPath:
        """The path from ``(x, y, theta)`` at rest.

        Raises:
            ValueError: for a last time that is not positive, numbers that are not finite, and a start where the body
                tips.
            TrajectoryError: where the integrator gives up.
        """
        log = _Log([0.0], [np.concatenate([finite_start(start, until), np.zeros(3)])])
        mode = Mode(frozenset(np.flatnonzero(self._outline.depths(log.states[0][:3]) > 0).tolist()))
        if not self._carry(mode.carrying, log.states[0]):
            raise ValueError("required a start where the body stands on its wheels, received one where it tips")
        notes = {EventKind.SLIDE: f"it swings there by less than {HELD:g} of the body's size; drawn is the mean"}
        for _ in range(MOST_EVENTS):
            reason, signal = self._stretch(log, mode, until)
            if reason is None:
                following = self._after(log, mode, signal)
                pose = tuple(log.states[-1][:3].tolist())
                for kind, words in wheel_changes(self._scene, mode, following):
                    log.events.append(Event(log.times[-1], pose, kind, words, note=notes.get(kind, "")))
                mode = following
                if not self._carry(mode.carrying, log.states[-1]):
                    reason = EndReason.TIPS
            if reason is not None:
                return self._ended(log, mode, reason)
        return self._ended(log, mode, EndReason.EVENTS)

    # ---- motions on sets of wheels ---------------------------------------------------------------

    def _on(self, wheels: Wheels, state: Floats) -> NewtonEuler:
        """The equations on a set, built where the body first stands on it.

        Raises:
            LoadError: for wheels that carried the body nowhere yet, and do not here.
        """
        if wheels not in self._equations:
            if len(wheels) < 3:
                raise LoadError("required three wheels under the body")
            model = contacts_of(self._model, sorted(wheels))
            loads = MovingLoads(model, state[:2])
            self._equations[wheels] = NewtonEuler(model, self._body, loads, CREEP * self._speed)
        return self._equations[wheels]

    def _margins(self, carrying: Wheels, states: Floats) -> Floats:
        return self._on(carrying, states[0]).loads.margins(states[:, :2])

    def _carry(self, wheels: Wheels, state: Floats) -> bool:
        try:
            return bool(self._margins(wheels, state[None])[0] > 0)
        except LoadError:
            return False

    def _held_rate(self, mode: Mode, t: float, state: Floats) -> Floats:
        """Time derivative of the state, shape (6,), with wheels held at the edge.

        Raises:
            TrajectoryError: where no weights hold them.
        """
        rates, weights = self._mixture(mode, state)
        if weights is None:
            raise TrajectoryError("required weights that keep the wheels under the edge, received none")
        return mixed_of(rates, weights)

    def _weights(self, mode: Mode, state: Floats) -> Floats:
        weights = self._mixture(mode, state)[1]
        return np.full(len(mode.sliding), np.nan) if weights is None else weights

    def _mixture(self, mode: Mode, state: Floats) -> tuple[Floats, Floats | None]:
        """The rates with each subset of the held wheels (2^k, 6), and the weights with which they stay at the edge.

        These make ``g'' = -2 d g' - d^2 g``: zero, but for what takes back rounding.
        """
        held, crossing = list(mode.sliding), self._outline.size / self._speed
        rates = np.array([self._on(mode.carrying | subset, state).rate(0.0, state) for subset in subsets_of(held)])
        pose, velocity, step, damping = state[:3], state[3:], DIFFERENCE * crossing, DAMPING / crossing
        edges, ahead, behind = (self._gradients(held, pose + way * velocity) for way in (0.0, step, -step))
        turning = ((ahead - behind) / (2 * step)) @ velocity
        taken = 2 * damping * (edges @ velocity) + damping**2 * self._outline.depths(pose)[held]
        accelerations = rates[:, 3:] @ edges.T + turning + taken
        return rates, balancing_weights(accelerations, len(held), np.full(len(held), 0.5))

    def _gradients(self, held: Sequence[int], pose: Floats) -> Floats:
        """``dg_i/d(x, y, theta)`` of held wheels, (k, 3)."""
        return np.array([self._outline.gradient(pose, wheel) for wheel in held])

    # ---- between events --------------------------------------------------------------------------

    def _stretch(self, log: _Log, mode: Mode, until: float) -> tuple[EndReason | None, int]:
        """Integrate until a signal changes; why the path ends there, or which signal it is."""
        from scipy.integrate import BDF

        start, state, found = log.times[-1], log.states[-1], None
        rate = partial(self._held_rate, mode) if mode.sliding else self._on(mode.carrying, state).rate
        jacobian = None if mode.sliding else self._on(mode.carrying, state).jacobian
        absolute = absolute_tolerances(self._outline.size, self._speed)
        solver = BDF(rate, start, state, until, rtol=RELATIVE_TOLERANCE, atol=absolute, jac=jacobian)
        while solver.status == "running" and found is None:
            before, message = solver.t, solver.step()
            if solver.status == "failed":
                raise TrajectoryError(f"the integrator stopped at t = {solver.t:.6g}: {message}")
            part = DenseStep(before, solver.t, solver.dense_output())
            found = self._first_change(mode, part, first=before == start)
            self._keep(log, part, part.end if found is None else found[0])
        log.evaluations += solver.nfev
        log.pieces.append(self._piece(mode, start, [time for time in log.times if time >= start], log.state))
        if found is None:
            return EndReason.TIME, -1
        return (EndReason.TIPS if found[1] == found[2] - 1 else None), found[1]

    def _keep(self, log: _Log, part: DenseStep, end: float) -> None:
        """A step, up to a time, and how far each wheel has come from the edge in it."""
        log.dense.append(part.state)
        log.times.append(end)
        log.states.append(part.state(end))
        looks = part.state(np.linspace(part.start, end, 5)).T
        depths = np.abs(self._outline.depths(looks[:, :3])).max(axis=0)
        log.swings = {wheel: max(reached, float(depths[wheel])) for wheel, reached in log.swings.items()}

    # ---- at events -------------------------------------------------------------------------------

    def _after(self, log: _Log, mode: Mode, signal: int) -> Mode:
        """The wheels after an event; the velocity becomes tangent to the edges of wheels newly held."""
        state, held, count = log.states[-1], mode.sliding, self._outline.count
        if signal >= count:  # a weight leaves [0, 1]
            place = signal - count
            wheel = held[place % len(held)]
            log.swings.pop(wheel, None)
            carrying = mode.carrying | {wheel} if place >= len(held) else mode.carrying
            return Mode(carrying, tuple(k for k in held if k != wheel))
        depths = self._outline.depths(state[:3])
        met = {signal, *np.flatnonzero(np.abs(depths) <= ON_EDGE * self._outline.size).tolist()}.difference(held)
        swings = {k for k in met if log.swings.get(k, math.inf) < HELD * self._outline.size}
        holding = Mode(mode.carrying - swings, tuple(sorted(swings.union(held))))
        if swings and all(self._carry(holding.carrying | subset, state) for subset in subsets_of(holding.sliding)):
            tangent = self._tangent(holding.sliding, state)
            weights = self._weights(holding, tangent)
            if ((weights > 0) & (weights < 1)).all():  # forces push back to the edge from both sides
                log.states[-1] = tangent
                return holding
        rates = self._outline.rates(state[:3], state[3:], list(met))
        inside = {wheel for wheel, rate in zip(met, rates, strict=True) if rate > 0}
        log.swings |= dict.fromkeys(met, 0.0)
        return Mode((mode.carrying - met) | inside, held)

    def _tangent(self, held: Sequence[int], state: Floats) -> Floats:
        """The state with the nearest velocity, by kinetic energy, that leaves held wheels under the edge."""
        edges = self._gradients(held, state[:3])
        pulled = (1 / self._body.masses)[:, None] * edges.T
        away = np.linalg.lstsq(edges @ pulled, edges @ state[3:], rcond=None)[0]
        return np.concatenate([state[:3], state[3:] - pulled @ away])

    def _ended(self, log: _Log, mode: Mode, reason: EndReason) -> DynamicPath:
        poses = [tuple(state[:3].tolist()) for state in log.states]
        if reason is EndReason.TIPS:
            log.events.append(self._tipping(log.times[-1], log.states[-1][:3], mode.carrying))
        times, states = np.array(log.times), np.array(log.states)
        trajectory = Trajectory(
            Kinematics.EXACT.value,
            "dynamics",
            tuple(log.times),
            tuple(poses),
            tuple(log.events),
            End(log.times[-1], poses[-1], reason),
            True,
            tuple(log.pieces),
        )
        return DynamicPath(self._body, CREEP * self._speed, times, states, trajectory, log.evaluations, log.state)
