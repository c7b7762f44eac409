"""Newton-Euler equations of a body on each set of wheels that may carry it, and of wheels held at its edge."""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.bodies.mixing import balancing_weights, mixed_of, subsets_of
from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.some_contacts import contacts_of
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.dynamics.newton_euler import CREEP, NewtonEuler, RigidBody, speed_scale
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.trajectories.result import TrajectoryError

DIFFERENCE = 1e-5  # of the time in which the body crosses itself: step of the edge's turning; errs by its square
DAMPING = 10.0  # times a crossing at which what rounding and tolerance leave of g and g' of a held wheel is taken back

Wheels = frozenset[int]
Held = tuple[int, ...]


class MassSets:
    """The equations by set of wheels; states are ``(x, y, theta, w_x, w_y, omega)``.

    Attributes:
        speed: the largest of any wheel.
        creep: the speed below which a slip counts as sticking.
    """

    def __init__(self, model: ContactModel, body: RigidBody, outline: MovingOutline) -> None:
        self._model, self._body, self._outline = model, body, outline
        self.speed = speed_scale(model, np.zeros(3))
        self.creep = CREEP * self.speed
        self._time = outline.size / self.speed
        self._inverse = 1 / np.array([body.mass, body.mass, body.inertia])
        self._known: dict[Wheels, NewtonEuler] = {}

    def carry(self, wheels: Wheels, state: Floats) -> bool:
        """Whether the body stands on the wheels there."""
        try:
            return bool(self.margins(wheels, state[None])[0] > 0)
        except LoadError:
            return False

    def margins(self, wheels: Wheels, states: Floats) -> Floats:
        """Distances of the centre of mass from the border of the support polygon, negative outside; states (m, 6)."""
        return self._on(wheels, states[0]).loads.margins(states[:, :2])

    def jacobian(self, wheels: Wheels, t: float, state: Floats) -> Floats:
        """Derivative of the rate on a set, shape (6, 6)."""
        return self._on(wheels, state).jacobian(t, state)

    def rate(self, wheels: Wheels, held: Held, t: float, state: Floats) -> Floats:
        """Time derivative of the state, shape (6,), with wheels held at the edge.

        Raises:
            TrajectoryError: where no weights hold them.
        """
        if not held:
            return self._on(wheels, state).rate(t, state)
        rates = self._rates(wheels, held, state)
        weights = self._weights(held, state, rates)
        if weights is None:
            raise TrajectoryError("required weights that keep the wheels under the edge, received none")
        return mixed_of(rates, weights)

    def weights(self, wheels: Wheels, held: Held, state: Floats) -> Floats:
        """The weights of the held wheels; not numbers where there are none."""
        found = self._weights(held, state, self._rates(wheels, held, state))
        return np.full(len(held), np.nan) if found is None else found

    def can_hold(self, wheels: Wheels, held: Held, state: Floats) -> bool:
        """Whether forces push back to the edge from both sides, for every held wheel."""
        if not all(self.carry(wheels | subset, state) for subset in subsets_of(held)):
            return False
        weights = self.weights(wheels, held, self.tangent(held, state))
        return bool(((weights > 0) & (weights < 1)).all())

    def tangent(self, held: Held, state: Floats) -> Floats:
        """The state with the nearest velocity, by kinetic energy, that leaves held wheels under the edge."""
        edges = self._gradients(held, state[:3])
        pulled = self._inverse[:, None] * edges.T
        away = np.linalg.lstsq(edges @ pulled, edges @ state[3:], rcond=None)[0]
        return np.concatenate([state[:3], state[3:] - pulled @ away])

    def _on(self, wheels: Wheels, state: Floats) -> NewtonEuler:
        """The equations on a set, built where the body first stands on it.

        Raises:
            LoadError: for wheels that carried the body nowhere yet, and do not here.
        """
        if wheels not in self._known:
            if len(wheels) < 3:
                raise LoadError("required three wheels under the body")
            model = contacts_of(self._model, sorted(wheels))
            self._known[wheels] = NewtonEuler(model, self._body, MovingLoads(model, state[:2]), self.creep)
        return self._known[wheels]

    def _rates(self, wheels: Wheels, held: Held, state: Floats) -> Floats:
        """The rates with each subset of the held wheels, (2^k, 6)."""
        return np.array([self._on(wheels | subset, state).rate(0.0, state) for subset in subsets_of(held)])

    def _weights(self, held: Held, state: Floats, rates: Floats) -> Floats | None:
        """Weights with which ``g'' = -2 d g' - d^2 g``: zero, but for what takes back rounding."""
        pose, velocity = state[:3], state[3:]
        edges, step = self._gradients(held, pose), DIFFERENCE * self._time
        ahead, behind = (self._gradients(held, pose + way * velocity) for way in (step, -step))
        turning = ((ahead - behind) / (2 * step)) @ velocity
        damping = DAMPING / self._time
        taken = 2 * damping * (edges @ velocity) + damping**2 * self._outline.depths(pose)[list(held)]
        return balancing_weights(rates[:, 3:] @ edges.T + turning + taken, len(held), np.full(len(held), 0.5))

    def _gradients(self, held: Held, pose: Floats) -> Floats:
        """``dg_i/d(x, y, theta)`` of held wheels, (k, 3)."""
        return np.array([self._outline.gradient(pose, wheel) for wheel in held])
