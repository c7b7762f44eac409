"""Full dynamics of a body on driven wheels: Newton-Euler equations with friction-ellipse forces.

With mass m, moment of inertia I about the centre of mass, loads ``N_i(c)`` and friction forces f_i on the body::

    c' = w,   theta' = omega,   m w' = sum_i f_i,   I omega' = sum_i (p_i - c) x f_i

The weight of the body is 1, as everywhere in this program, so m is mass per weight, ``1/g`` (time^2/length): 0.102 in
metres and seconds.  Wheels stand still in the world and the plate covers them all, so nothing depends on theta.

The equations are stiff: velocities settle within a time of order ``m |u|/mu``, and a wheel that nearly sticks is
``|u|/creep`` times faster still.  Backward differentiation formulas (SciPy's BDF, variable order and step) are implicit
with one small system per step and an analytic Jacobian, so the cost hardly grows as m -> 0; friction's part of that
Jacobian is symmetric and negative, where these formulas are stable.  Radau IIA gives the same paths for ten to a
hundred times as many evaluations where wheels stick.  Sticking is a creep of at most some multiples of ``creep``, so a
rest that the true law keeps for ever is left slowly: see :mod:`nonsmooth.analysis.dynamics.friction_forces`.

Scaling: with speeds ``s u`` and mass ``m/s^2`` the same path is followed s times faster.  Slow wheels and light bodies
are one limit, and in it the path is that of rule ``ellipse``
(:mod:`nonsmooth.analysis.bodies.mass_study` measures how fast).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from nonsmooth.analysis.dynamics.continuous_path import as_trajectory, integrate
from nonsmooth.analysis.dynamics.friction_forces import EllipseFriction
from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.trajectories.result import Trajectory

RELATIVE_TOLERANCE = 1e-8  # of BDF, per step: below the difference between the models for every mass above 1e-7
ABSOLUTE_TOLERANCE = 1e-10  # in units of the array's size and of the largest speed
CREEP = 1e-6  # creep speed over the largest speed: changes paths by as much, and costs a few steps where wheels stick
LARGEST = 1e100  # mass and inertia, and their inverses: products of two are still doubles


@dataclass(frozen=True)
class RigidBody:
    """A rigid plate.

    Attributes:
        mass: per unit of weight (time^2/length): ``1/g``.
        inertia: moment of inertia about the centre of mass per unit of weight (time^2 length).

    Raises:
        ValueError: for a number that is not positive, or too large or small for doubles.
    """

    mass: float
    inertia: float

    def __post_init__(self) -> None:
        for name in ("mass", "inertia"):
            value = getattr(self, name)
            if not 1 / LARGEST <= value <= LARGEST:
                raise ValueError(
                    f"{name}: required a positive number, {1 / LARGEST:g} to {LARGEST:g}, received {value}"
                )


def disc(model: ContactModel, mass: float) -> RigidBody:
    """A uniform disc as large as the array: ``I = m R^2/2``, ``R^2`` the mean squared distance of the wheels."""
    return RigidBody(mass, mass * array_size(model) ** 2 / 2)


def array_size(model: ContactModel) -> float:
    """Root mean squared distance of the wheels from their middle; one for a single wheel (length)."""
    offsets = model.positions - model.positions.mean(axis=0)
    return float(np.sqrt((offsets**2).sum(axis=1).mean())) or 1.0


class NewtonEuler:
    """The equations as an integrator wants them: state ``(x, y, theta, w_x, w_y, omega)``."""

    def __init__(self, model: ContactModel, body: RigidBody, loads: MovingLoads, creep: float) -> None:
        self.friction, self.body, self.loads = EllipseFriction(model, creep), body, loads
        self._masses = np.array([body.mass, body.mass, body.inertia])

    def rate(self, t: float, state: Floats) -> Floats:
        """Time derivative of the state, shape (6,)."""
        centre, velocity = state[:2], state[3:]
        forces = self.friction.forces(centre, velocity, self.loads.at(centre)[0])
        return np.concatenate([velocity, self.friction.rows(centre).T @ forces.reshape(-1) / self._masses])

    def jacobian(self, t: float, state: Floats) -> Floats:
        """Derivative of the rate, shape (6, 6)."""
        centre, velocity = state[:2], state[3:]
        wrench = self.friction.wrench(centre, velocity, *self.loads.at(centre))
        matrix = np.zeros((6, 6))
        matrix[:3, 3:] = np.eye(3)
        matrix[3:, :2] = wrench.by_centre / self._masses[:, None]
        matrix[3:, 3:] = wrench.by_velocity / self._masses[:, None]
        return matrix

    def kinetic_energy(self, states: Floats) -> Floats:
        """``(m |w|^2 + I omega^2)/2`` of states (..., 6), in units of weight times length."""
        return np.asarray((self._masses * states[..., 3:] ** 2).sum(axis=-1) / 2)


@dataclass(frozen=True, eq=False)
class DynamicPath:
    """A path under full dynamics.

    Attributes:
        body: what moved.
        creep: the speed below which a slip counts as sticking.
        times: the integrator's own steps, shape (m,).
        states: ``(x, y, theta, w_x, w_y, omega)`` at these times, shape (m, 6).
        trajectory: the pose as every other method returns it.
        evaluations: how often forces were computed.
        dense: all six entries of the state between the steps.
    """

    body: RigidBody
    creep: float
    times: Floats
    states: Floats
    trajectory: Trajectory
    evaluations: int
    dense: Callable[[float], Floats] = field(repr=False)

    def state(self, t: float) -> Floats:
        """State at a time within the path, shape (6,)."""
        return np.asarray(self.dense(t))


def simulate_dynamics(
    model: ContactModel,
    body: RigidBody,
    start: Sequence[float],
    until: float,
    velocity: Sequence[float] = (0.0, 0.0, 0.0),
) -> DynamicPath:
    """Follow a body from a pose and a velocity at time zero.

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
    state = np.array([*start, *velocity], float)
    if not (np.isfinite(state).all() and 0 < until < math.inf):
        raise ValueError(f"required a finite start and a positive last time, received {state.tolist()} and {until}")
    length, speed = array_size(model), speed_scale(model, state[3:])
    loads, creep = MovingLoads(model, state[:2]), CREEP * speed
    equations = NewtonEuler(model, body, loads, creep)
    solution = integrate(
        equations.rate,
        loads,
        state,
        until,
        method="BDF",
        jac=equations.jacobian,
        rtol=RELATIVE_TOLERANCE,
        atol=ABSOLUTE_TOLERANCE * np.array([length, length, 1.0, speed, speed, speed / length]),
    )
    trajectory = as_trajectory("dynamics", solution, loads)
    return DynamicPath(body, creep, solution.t, solution.y.T, trajectory, int(solution.nfev), solution.sol)


def speed_scale(model: ContactModel, velocity: Floats) -> float:
    """The largest speed that drives: of a wheel's surface, or of the body at the start; one if all stands still."""
    size = array_size(model)
    return max(float(np.abs(model.targets).max()), float(np.hypot(*velocity[:2])), size * abs(velocity[2])) or 1.0
