"""The path of a body with mass: Newton-Euler equations, whose loads jump where wheels enter and leave.

Between such events the same wheels carry, and backward differentiation formulas follow the state
``(x, y, theta, w_x, w_y, omega)`` (:mod:`nonsmooth.analysis.bodies.newton_euler`).  At an event only forces jump,
velocities do not: with ``g_i' != 0`` a wheel goes all the way under the body or beside it.  But where forces push back
to the edge from both sides, a wheel swings across it, ever faster and nearer, infinitely often.  Once a swing stays
within :data:`HELD` of the body's size, the wheel is held at the edge: weights mix the accelerations with and without it
so that ``g_i'' = 0``, which is the limit of such swings (Filippov), until a weight leaves [0, 1].

A plain array is a body that covers all its wheels: no wheel comes to its edge.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from nonsmooth.analysis.bodies.newton_euler import (
    CREEP,
    RELATIVE_TOLERANCE,
    DynamicPath,
    MovingLoads,
    NewtonEuler,
    RigidBody,
    absolute_tolerances,
    array_size,
    speed_scale,
)
from nonsmooth.analysis.bodies.set_motion import Wheels
from nonsmooth.analysis.bodies.supports import CarriedBody, CarryingWheels, SupportMode, finite_start
from nonsmooth.analysis.bodies.switching import balancing_weights, mixed_of, subsets_of
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.follow import DenseStep, Mode, Path, follow
from nonsmooth.analysis.trajectories.result import EndReason, TrajectoryError
from nonsmooth.analysis.trajectories.steppers import Integrator
from nonsmooth.symbolic.mechanics.contact_set import require_springs
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats

HELD = 1e-6  # of the body's size: a wheel that swings across the edge by less is held there
MOST_EVENTS = 5_000
MOST_WORK = 300_000  # evaluations of all forces: some ten thousand steps, half a minute
DIFFERENCE = 1e-5  # of the time in which the body crosses itself: step of the edge's turning; errs by its square
DAMPING = 10.0  # times a crossing at which what rounding and tolerance leave of g and g' of a held wheel is taken back
SWINGS = f"it swings there by less than {HELD:g} of the body's size; drawn is the mean"


def simulate_dynamics(
    model: ContactModel,
    body: RigidBody,
    start: Sequence[float],
    until: float,
    velocity: Sequence[float] = (0.0, 0.0, 0.0),
) -> DynamicPath:
    """Follow a body that covers all wheels from a pose and a velocity at time zero.

    Args:
        model: the array.
        body: mass and inertia.
        start: ``(x, y, theta)``.
        until: last time.
        velocity: ``(w_x, w_y, omega)`` of the centre of mass at the start; at rest unless given.

    Returns:
        The path; it ends early where no loads exist any more (the body tips).

    Raises:
        ValueError: for a last time that is not positive, or numbers that are not finite.
        nonsmooth.analysis.cells.loads.LoadError: for a start without loads.
        TrajectoryError: where the integrator gives up.
    """
    return MassPath(model, body).follow(start, until, velocity)


class MassPath(CarriedBody):
    """Follows one body; the wheels that slide on a support are held under its edge."""

    method, shown = "dynamics", 3

    def __init__(
        self,
        model: ContactModel,
        body: RigidBody,
        scene: Scene | None = None,
        coarser: float = 1.0,
        most_work: int | None = None,
    ) -> None:
        """For contacts, and the scene of a body with an outline, with the same wheels.

        Tolerances are ``coarser`` times as large as for a path that is shown; a path ends after ``most_work``
        evaluations of all forces, :data:`MOST_WORK` unless given.

        Raises:
            ValueError: for a scene without a body.
            SceneError: for loads that are known for one set of wheels only.
        """
        super().__init__(model, scene)
        if scene is not None:
            require_springs(scene)
        self._body, self._coarser, self._most_work = body, coarser, most_work or MOST_WORK
        self._equations: dict[Wheels, NewtonEuler] = {}

    def follow(self, start: Sequence[float], until: float, velocity: Sequence[float] = (0.0, 0.0, 0.0)) -> DynamicPath:
        """The path from ``(x, y, theta)`` with a velocity of the centre of mass, ``(w_x, w_y, omega)``.

        Raises:
            ValueError: for a last time that is not positive, numbers that are not finite, and a start where the body
                tips.
            LoadError: for a start of an array without loads.
            TrajectoryError: where the integrator gives up.
        """
        state = finite_start([*start, *velocity], until)
        self._speed = speed_scale(self.model, state[3:])
        self._support = CarryingWheels(frozenset(np.flatnonzero(self.outline.depths(state[:3]) > 0).tolist()))
        self._swings: dict[int, float] = {}  # how far each wheel that crossed the edge has come from it since
        self._evaluations = 0
        if self.scene is None:
            self._on(self._support.carrying, state)
            if self.margins(self._support.carrying, state[None])[0] < 0 and self._body.centre_height:
                raise LoadError("required a body that friction does not tip over at its start")
        elif not self._carry(self._support.carrying, state):
            raise self.refusal(LoadError("required loads"), state[:3])
        size = array_size(self.model) if self.scene is None else self.outline.size
        absolute = self._coarser * absolute_tolerances(size, self._speed)
        stepper = Integrator("BDF", self._coarser * RELATIVE_TOLERANCE, absolute)
        path = follow(self, (0.0, state), until, stepper)
        times, states = path.ends_of_steps()
        trajectory = path.trajectory(Kinematics.EXACT.value, self.method)
        creep = CREEP * self._speed
        return DynamicPath(self._body, creep, times, states, trajectory, self._evaluations, path.at)

    # ---- motions on sets of wheels ---------------------------------------------------------------

    def _on(self, wheels: Wheels, state: Floats) -> NewtonEuler:
        """The equations on a set, built where the body first stands on it.

        Raises:
            LoadError: for wheels that carried the body nowhere yet, and do not here.
        """
        if wheels not in self._equations:
            if len(wheels) < min(3, self.model.wheels):
                raise LoadError("required three wheels under the body")
            model = self.model.on(sorted(wheels))
            loads = MovingLoads(model, state[:2])
            self._equations[wheels] = NewtonEuler(model, self._body, loads, CREEP * self._speed)
        return self._equations[wheels]

    def margins(self, carrying: Wheels, states: Floats) -> Floats:
        """See :class:`nonsmooth.analysis.bodies.supports.CarriedBody`."""
        return self._on(carrying, states[0]).margins(states)

    def _carry(self, wheels: Wheels, state: Floats) -> bool:
        try:
            return bool(self.margins(wheels, state[None])[0] > 0)
        except LoadError:
            return False

    def _held_rate(self, support: CarryingWheels) -> Callable[[float, Floats], Floats]:
        """Time derivative of the state, shape (6,), with wheels held at the edge."""

        def rate(t: float, state: Floats) -> Floats:
            rates, weights = self._mixture(support, state)
            if weights is None:
                raise TrajectoryError("required weights that keep the wheels under the edge, received none")
            return mixed_of(rates, weights)

        return rate

    def weights(self, support: CarryingWheels, state: Floats) -> Floats:
        """See :class:`nonsmooth.analysis.bodies.supports.CarriedBody`."""
        weights = self._mixture(support, state)[1]
        return np.full(len(support.sliding), np.nan) if weights is None else weights

    def _mixture(self, support: CarryingWheels, state: Floats) -> tuple[Floats, Floats | None]:
        """The rates with each subset of the held wheels (2^k, 6), and the weights with which they stay at the edge.

        These make ``g'' = -2 d g' - d^2 g``: zero, but for what takes back rounding.
        """
        held, crossing = list(support.sliding), self.outline.size / self._speed
        rates = np.array([self._on(support.carrying | subset, state)(0.0, state) for subset in subsets_of(held)])
        pose, velocity, step, damping = state[:3], state[3:], DIFFERENCE * crossing, DAMPING / crossing
        edges, ahead, behind = (self._gradients(held, pose + way * velocity) for way in (0.0, step, -step))
        turning = ((ahead - behind) / (2 * step)) @ velocity
        taken = 2 * damping * (edges @ velocity) + damping**2 * self.outline.depths(pose)[held]
        accelerations = rates[:, 3:] @ edges.T + turning + taken
        return rates, balancing_weights(accelerations, len(held), np.full(len(held), 0.5))

    def _gradients(self, held: Sequence[int], pose: Floats) -> Floats:
        """``dg_i/d(x, y, theta)`` of held wheels, (k, 3)."""
        return np.array([self.outline.gradient(pose, wheel) for wheel in held])

    # ---- the engine's questions ------------------------------------------------------------------

    def next_mode(self, path: Path) -> Mode | EndReason:
        """The equations on the wheels that carry now."""
        support = self._support
        if len(path.stretches) >= MOST_EVENTS:
            return EndReason.EVENTS
        if path.stretches and not self._carry(support.carrying, path.state):
            return self.tipped(path, support.carrying)
        rate = self._held_rate(support) if support.sliding else self._on(support.carrying, path.state)
        return SupportMode(self, support, rate)

    def passed(self, step: DenseStep, end: float) -> EndReason | None:
        """Count the work, which may become too much, and note how far wheels have come from the edge."""
        self._evaluations += step.work
        if self._swings:
            looks = step(np.linspace(step.start, end, 5)).T
            depths = np.abs(self.outline.depths(looks[:, :3])).max(axis=0)
            self._swings = {wheel: max(reached, float(depths[wheel])) for wheel, reached in self._swings.items()}
        return EndReason.STEPS if self._evaluations > self._most_work else None

    def arrive(self, path: Path, mode: Mode, met: int | None) -> EndReason | None:
        """The wheels after an event."""
        if met is None or not isinstance(mode, SupportMode):
            return None
        if met == mode.guards.margin:
            return self.tipped(path, self._support.carrying)
        before, self._support = self._support, self._after(path, met)
        self.tell_changes(path, before, self._support, of_slides=SWINGS)
        return None

    def _after(self, path: Path, signal: int) -> CarryingWheels:
        """The wheels after an event; the velocity becomes tangent to the edges of wheels newly held."""
        state, support = path.state, self._support
        held, count = support.sliding, self.outline.count
        if signal >= count:  # a weight leaves [0, 1]
            place = signal - count
            wheel = held[place % len(held)]
            self._swings.pop(wheel, None)
            carrying = support.carrying | {wheel} if place >= len(held) else support.carrying
            return CarryingWheels(carrying, tuple(k for k in held if k != wheel))
        depths = self.outline.depths(state[:3])
        met = {signal, *np.flatnonzero(np.abs(depths) <= self.edge_depth).tolist()}.difference(held)
        swings = {k for k in met if self._swings.get(k, math.inf) < HELD * self.outline.size}
        holding = CarryingWheels(support.carrying - swings, tuple(sorted(swings.union(held))))
        if swings and all(self._carry(holding.carrying | subset, state) for subset in subsets_of(holding.sliding)):
            tangent = self._tangent(holding.sliding, state)
            weights = self.weights(holding, tangent)
            if ((weights > 0) & (weights < 1)).all():  # forces push back to the edge from both sides
                path.state = path.stretches[-1].states[-1] = tangent
                return holding
        rates = self.outline.rates(state[:3], state[3:], list(met))
        inside = {wheel for wheel, rate in zip(met, rates, strict=True) if rate > 0}
        self._swings |= dict.fromkeys(met, 0.0)
        return CarryingWheels((support.carrying - met) | inside, held)

    def _tangent(self, held: Sequence[int], state: Floats) -> Floats:
        """The state with the nearest velocity, by kinetic energy, that leaves held wheels under the edge."""
        edges = self._gradients(held, state[:3])
        pulled = (1 / self._body.masses)[:, None] * edges.T
        away = np.linalg.lstsq(edges @ pulled, edges @ state[3:], rcond=None)[0]
        return np.concatenate([state[:3], state[3:] - pulled @ away])
