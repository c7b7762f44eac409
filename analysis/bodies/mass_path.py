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
from nonsmooth.analysis.bodies.mixing import balancing_weights, mixed_of, subsets_of
from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.some_contacts import contacts_of
from nonsmooth.analysis.bodies.tipping import tipping_edge
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

Wheels = frozenset[int]
Held = tuple[int, ...]  # ascending


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

    def pose(self, start: float, since: Any) -> tuple[float, ...]:
        """Pose at a time since the start of a piece."""
        return tuple(self.state(start + float(since))[:3].tolist())


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
        self._scene, self._model, self._body = scene, model, body
        self._outline = MovingOutline(scene.body, model.positions)
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
        wheels = frozenset(np.flatnonzero(self._outline.depths(log.states[0][:3]) > 0).tolist())
        held: Held = ()
        if not self._carry(wheels, log.states[0]):
            raise ValueError("required a start where the body stands on its wheels, received one where it tips")
        for _ in range(MOST_EVENTS):
            reason, signal = self._stretch(log, wheels, held, until)
            if reason is None:
                before = wheels, held
                wheels, held = self._after(log, wheels, held, signal)
                self._note(log, *before, wheels, held)
                if not self._carry(wheels, log.states[-1]):
                    reason = EndReason.TIPS
            if reason is not None:
                return self._ended(log, wheels, reason)
        return self._ended(log, wheels, EndReason.EVENTS)

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

    def _margins(self, wheels: Wheels, states: Floats) -> Floats:
        """Distances of the centre of mass from the border of the support polygon, negative outside; states (m, 6)."""
        return self._on(wheels, states[0]).loads.margins(states[:, :2])

    def _carry(self, wheels: Wheels, state: Floats) -> bool:
        try:
            return bool(self._margins(wheels, state[None])[0] > 0)
        except LoadError:
            return False

    def _rate(self, wheels: Wheels, held: Held, t: float, state: Floats) -> Floats:
        """Time derivative of the state, shape (6,), with wheels held at the edge.

        Raises:
            TrajectoryError: where no weights hold them.
        """
        rates, weights = self._mixture(wheels, held, state)
        if weights is None:
            raise TrajectoryError("required weights that keep the wheels under the edge, received none")
        return mixed_of(rates, weights)

    def _weights(self, wheels: Wheels, held: Held, state: Floats) -> Floats:
        """The weights of the held wheels; not numbers where there are none."""
        weights = self._mixture(wheels, held, state)[1]
        return np.full(len(held), np.nan) if weights is None else weights

    def _mixture(self, wheels: Wheels, held: Held, state: Floats) -> tuple[Floats, Floats | None]:
        """The rates with each subset of the held wheels (2^k, 6), and the weights with which they stay at the edge.

        These make ``g'' = -2 d g' - d^2 g``: zero, but for what takes back rounding.
        """
        rates = np.array([self._on(wheels | subset, state).rate(0.0, state) for subset in subsets_of(held)])
        pose, velocity, crossing = state[:3], state[3:], self._outline.size / self._speed
        edges, step, damping = self._gradients(held, pose), DIFFERENCE * crossing, DAMPING / crossing
        ahead, behind = (self._gradients(held, pose + way * velocity) for way in (step, -step))
        turning = ((ahead - behind) / (2 * step)) @ velocity
        taken = 2 * damping * (edges @ velocity) + damping**2 * self._outline.depths(pose)[list(held)]
        falls = rates[:, 3:] @ edges.T + turning + taken
        return rates, balancing_weights(falls, len(held), np.full(len(held), 0.5))

    def _gradients(self, held: Held, pose: Floats) -> Floats:
        """``dg_i/d(x, y, theta)`` of held wheels, (k, 3)."""
        return np.array([self._outline.gradient(pose, wheel) for wheel in held])

    def _tangent(self, held: Held, state: Floats) -> Floats:
        """The state with the nearest velocity, by kinetic energy, that leaves held wheels under the edge."""
        edges = self._gradients(held, state[:3])
        pulled = (1 / self._body.masses)[:, None] * edges.T
        away = np.linalg.lstsq(edges @ pulled, edges @ state[3:], rcond=None)[0]
        return np.concatenate([state[:3], state[3:] - pulled @ away])

    # ---- between events --------------------------------------------------------------------------

    def _stretch(self, log: _Log, wheels: Wheels, held: Held, until: float) -> tuple[EndReason | None, int]:
        """Integrate until a signal changes; why the path ends there, or which signal it is."""
        from scipy.integrate import BDF

        start, state, found = log.times[-1], log.states[-1], None
        rate = partial(self._rate, wheels, held) if held else self._on(wheels, state).rate
        jacobian = None if held else self._on(wheels, state).jacobian
        absolute = absolute_tolerances(self._outline.size, self._speed)
        solver = BDF(rate, start, state, until, rtol=RELATIVE_TOLERANCE, atol=absolute, jac=jacobian)
        while solver.status == "running" and found is None:
            before, message = solver.t, solver.step()
            if solver.status == "failed":
                raise TrajectoryError(f"the integrator stopped at t = {solver.t:.6g}: {message}")
            part = DenseStep(before, solver.t, solver.dense_output())
            found = first_change(partial(self._signals, wheels, held), part, first=before == start)
            self._keep(log, part, part.end if found is None else found[0])
        log.evaluations += solver.nfev
        names = self._names(wheels.union(held))
        times = tuple(time for time in log.times if time >= start)
        place = f"wheels {', '.join(names)}"
        log.pieces.append(Piece(start, log.times[-1], place, names, partial(log.pose, start), times))
        if found is None:
            return EndReason.TIME, -1
        return (EndReason.TIPS if found[1] == found[2] - 1 else None), found[1]

    def _signals(self, wheels: Wheels, held: Held, states: Floats) -> Floats:
        """What is positive while the same wheels carry: signed depths, weights of held wheels, the support's margin."""
        signs = np.full(self._outline.count, -1.0)
        signs[list(wheels)] = 1.0
        signed = signs * self._outline.depths(states[:, :3])
        signed[:, list(held)] = 1.0
        columns = [signed]
        if held:
            weights = np.array([self._weights(wheels, held, state) for state in states])
            columns += [weights, 1 - weights]
        return np.column_stack([*columns, self._margins(wheels, states)])

    def _keep(self, log: _Log, part: DenseStep, end: float) -> None:
        """A step, up to a time, and how far each wheel has come from the edge in it."""
        log.dense.append(part.state)
        log.times.append(end)
        log.states.append(part.state(end))
        looks = part.state(np.linspace(part.start, end, 5)).T
        depths = np.abs(self._outline.depths(looks[:, :3])).max(axis=0)
        log.swings = {wheel: max(reached, float(depths[wheel])) for wheel, reached in log.swings.items()}

    # ---- at events -------------------------------------------------------------------------------

    def _after(self, log: _Log, wheels: Wheels, held: Held, signal: int) -> tuple[Wheels, Held]:
        """The wheels after an event; the velocity becomes tangent to the edges of wheels newly held."""
        state, count = log.states[-1], self._outline.count
        if signal >= count:  # a weight leaves [0, 1]
            place = signal - count
            wheel = held[place % len(held)]
            log.swings.pop(wheel, None)
            kept = tuple(k for k in held if k != wheel)
            return (wheels | {wheel} if place >= len(held) else wheels), kept
        depths = self._outline.depths(state[:3])
        met = {signal, *np.flatnonzero(np.abs(depths) <= ON_EDGE * self._outline.size).tolist()} - set(held)
        swings = {k for k in met if log.swings.get(k, math.inf) < HELD * self._outline.size}
        if swings:
            rest, both = wheels - swings, tuple(sorted([*held, *swings]))
            tangent = self._tangent(both, state)
            if self._can_hold(rest, both, state, tangent):
                log.states[-1] = tangent
                return rest, both
        rates = self._outline.rates(state[:3], state[3:], list(met))
        inside = {wheel for wheel, rate in zip(met, rates, strict=True) if rate > 0}
        log.swings |= dict.fromkeys(met, 0.0)
        return (wheels - met) | inside, held

    def _can_hold(self, wheels: Wheels, held: Held, state: Floats, tangent: Floats) -> bool:
        """Whether forces push back to the edge from both sides, for every held wheel."""
        if not all(self._carry(wheels | subset, state) for subset in subsets_of(held)):
            return False
        weights = self._weights(wheels, held, tangent)
        return bool(((weights > 0) & (weights < 1)).all())

    def _note(self, log: _Log, wheels: Wheels, held: Held, carrying: Wheels, sliding: Held) -> None:
        """One event for each kind of change, from wheels and held ones to those that carry and slide next."""
        pose, swings = tuple(log.states[-1][:3].tolist()), f"it swings there by less than {HELD:g} of the body's size"
        changes = (
            (EventKind.SLIDE, set(sliding).difference(held), "under the edge", f"{swings}; drawn is the mean"),
            (EventKind.ENTER, carrying - wheels, "under the body", ""),
            (EventKind.LEAVE, wheels.union(held).difference(carrying, sliding), "beside the body", ""),
        )
        for kind, changed, words, note in changes:
            if changed:
                names = ", ".join(self._names(changed))
                log.events.append(Event(log.times[-1], pose, kind, f"wheel {names} {words}", note=note))

    def _names(self, wheels: set[int] | Wheels) -> tuple[str, ...]:
        return tuple(str(self._scene.wheels[k].index) for k in sorted(wheels))

    def _ended(self, log: _Log, wheels: Wheels, reason: EndReason) -> DynamicPath:
        poses = [tuple(state[:3].tolist()) for state in log.states]
        if reason is EndReason.TIPS:
            over = tipping_edge(self._scene, wheels, np.array(poses[-1]))
            log.events.append(Event(log.times[-1], poses[-1], EventKind.TIPS, over))
        end = End(log.times[-1], poses[-1], reason)
        trajectory = Trajectory(
            Kinematics.EXACT.value,
            "dynamics",
            tuple(log.times),
            tuple(poses),
            tuple(log.events),
            end,
            True,
            tuple(log.pieces),
        )
        arrays = np.array(log.times), np.array(log.states)
        return DynamicPath(self._body, CREEP * self._speed, *arrays, trajectory, log.evaluations, log.state)
