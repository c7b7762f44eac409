"""Full dynamics of a body on driven wheels: Newton-Euler equations with forces in the wheels' friction sets.

With mass m, moment of inertia I about the centre of mass, loads ``N_i(c)`` and friction forces f_i on the body::

    c' = w,   theta' = omega,   m w' = sum_i f_i,   I omega' = sum_i (p_i - c) x f_i

The weight of the body is 1, as everywhere in this program, so m is mass per weight, ``1/g`` (time^2/length): 0.102 in
metres and seconds.  Wheels stand still in the world and the plate covers them all, so nothing depends on theta.

Where the centre of mass is at a height h above the wheels, friction tilts the body until loads balance it, so they are
those of a body at rest whose centre of mass were at the *centre of pressure* q (moments about the centre of mass)::

    sum_i N_i = 1,   sum_i N_i p_i = q = c - h sum_i f_i,     N_i = N_i(q)

Per unit of load friction forces do not depend on loads, which are affine in q as long as the same wheels carry, so this
is one linear system of two equations.  In balance of forces, and so without inertia, q is c.

The equations are stiff: velocities settle within a time of order ``m |u|/mu``, and a wheel that nearly sticks is
``|u|/creep`` times faster still.  Backward differentiation formulas (SciPy's BDF, variable order and step) are implicit
with one small system per step and an analytic Jacobian, so the cost hardly grows as m -> 0; friction's part of that
Jacobian is symmetric and negative, where these formulas are stable.  Radau IIA gives the same paths for ten to a
hundred times as many evaluations where wheels stick.  Sticking is a creep of at most some multiples of ``creep``, so a
rest that the true law keeps for ever is left slowly: see :class:`EllipseFriction`.

Scaling: with speeds ``s u`` and mass ``m/s^2`` the same path is followed s times faster.  Slow wheels and light bodies
are one limit, and in it the path is that of the rule with the same friction sets, ``ellipse`` or ``roller``
(:mod:`nonsmooth.analysis.bodies.mass_study` measures how fast).
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers.float_loads import affine_loads, hull_sides, loads_at
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm, norm, squared_norms, turned

# ---- normal forces along a path ------------------------------------------------------------------
#
# Loads and their slope at one centre of mass, and where the loads end.
#
# Loads are affine in c as long as the same wheels carry load, so an integrator needs one small table per set of loaded
# wheels: that of the last point serves while its loads are >= 0 and the springs that it leaves out are free; where it
# does not, :mod:`nonsmooth.analysis.minimizers.float_loads` finds the loaded set.  Trial states of an implicit step may
# lie beyond the last place where loads exist: there the last table is continued, cut off at zero, and
# :meth:`MovingLoads.margin` is negative, so that no such state is ever kept.
#
# Loads are those of a body at rest with its centre of mass at c.  Acceleration shifts them as if it were elsewhere
# (:class:`nonsmooth.analysis.bodies.newton_euler.NewtonEuler`).


LIFTED = 1e-12  # share of the weight: a load above minus this one is not yet negative


class MovingLoads:
    """Loads of a model at one centre of mass after the other, total weight 1.

    Attributes:
        model: the contacts.
    """

    def __init__(self, model: ContactModel, start: Floats) -> None:
        """Prepare for a path.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where no loads exist at the start.
        """
        self.model = model
        self._table, self._valid = self._tables(start)
        self._sides = self._borders()

    def at(self, centre: Floats) -> tuple[Floats, Floats]:
        """Loads (n,) and their slope with respect to the centre (n, 2); continued beyond the border."""
        if self.margin(centre) >= 0 and self.validities(centre[None])[0] < 0:
            with suppress(LoadError):  # of a centre over the line through two wheels, where the last table serves
                self._table, self._valid = self._tables(centre)
        loads = self._table @ np.array([1.0, *centre])
        return np.maximum(loads, 0.0), np.where(loads[:, None] > 0, self._table[:, 1:], 0.0)

    def continued(self, centre: Floats) -> tuple[Floats, Floats]:
        """Loads (n,) and slopes (n, 2) with the table of the last point, wherever it leads."""
        return self._table[:, 0] + self._table[:, 1:] @ centre, self._table[:, 1:]

    def validities(self, centres: Floats) -> Floats:
        """Negative where that table no longer holds, at centres (m, 2)."""
        return _least(self._valid, centres) + LIFTED

    def margins(self, centres: Floats) -> Floats:
        """How far the loads exist around centres (m, 2): distance to the support's border, or the least table load."""
        return _least(self._sides, centres)

    def margin(self, centre: Floats) -> float:
        """:meth:`margins` at one centre."""
        return float((self._sides @ np.array([1.0, *centre])).min())

    def _tables(self, centre: Floats) -> tuple[Floats, Floats]:
        """Affine forms of (1, c) around a point: of the loads (n, 3), and those that are >= 0 while they hold."""
        loaded = loads_at(self.model, centre[None])[0] > 0
        if self.model.load_table is not None:
            return self.model.load_table, np.array([[np.inf, 0.0, 0.0]])
        forms = affine_loads(self.model, np.flatnonzero(loaded))
        return np.where(loaded[:, None], forms, 0.0), np.where(loaded[:, None], forms, -forms)

    def _borders(self) -> Floats:
        """Affine forms (k, 3) of (1, c), all of them >= 0 where loads exist."""
        if self.model.load_table is not None:
            return self.model.load_table[self.model.load_table.any(axis=1)]
        return -hull_sides(self.model.positions)[:, [2, 0, 1]]


def _least(forms: Floats, centres: Floats) -> Floats:
    """The least of affine forms (k, 3) of (1, c) at centres (m, 2)."""
    return (forms[:, :1] + forms[:, 1:] @ centres.T).min(axis=0)


# ---- the equations -------------------------------------------------------------------------------


RELATIVE_TOLERANCE = 1e-8  # of BDF, per step: below the difference between the models for every mass above 1e-7
ABSOLUTE_TOLERANCE = 1e-10  # in units of the array's size and of the largest speed
CREEP = 1e-6  # creep speed over the largest speed: changes paths by as much, and costs a few steps where wheels stick
MOST_SETS = 12  # of loaded wheels that are tried for one centre of pressure
BALANCED = 1e-12  # of the weight at the height of the centre of mass: a moment that counts as zero
LARGEST = 1e100  # mass and inertia, and their inverses: products of two are still doubles


# ---- bodies --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RigidBody:
    """A rigid plate.

    Attributes:
        mass: per unit of weight (time^2/length): ``1/g``.
        inertia: moment of inertia about the centre of mass per unit of weight (time^2 length).
        centre_height: h of the centre of mass above the wheels (length).

    Raises:
        ValueError: for a mass or an inertia that is not positive, or too large or small for doubles, and for a height
            that is negative or too large.
    """

    mass: float
    inertia: float
    centre_height: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.centre_height <= LARGEST:
            raise ValueError(f"centre_height: required 0 to {LARGEST:g}, received {self.centre_height}")
        for name, value in (("mass", self.mass), ("inertia", self.inertia)):
            if not 1 / LARGEST <= value <= LARGEST:
                raise ValueError(
                    f"{name}: required a positive number, {1 / LARGEST:g} to {LARGEST:g}, received {value}"
                )

    @property
    def masses(self) -> Floats:
        """``(m, m, I)``."""
        return np.array([self.mass, self.mass, self.inertia])

    def times(self, factor: float) -> RigidBody:
        """The same body with another mass per weight."""
        return RigidBody(factor * self.mass, factor * self.inertia, self.centre_height)


def disc(model: ContactModel, mass: float) -> RigidBody:
    """A uniform disc as large as the array: ``I = m R^2/2``, ``R^2`` the mean squared distance of the wheels.

    Args:
        model: of the array; lengths in its unit.
        mass: m > 0, in the unit of mass of the scene.
    """
    return RigidBody(mass, mass * array_size(model) ** 2 / 2)


def array_size(model: ContactModel) -> float:
    """Root mean squared distance of the wheels from their middle; one for a single wheel (length)."""
    offsets = model.positions - model.positions.mean(axis=0)
    return float(np.sqrt(squared_norms(offsets).mean())) or 1.0


def speed_scale(model: ContactModel, velocity: Floats) -> float:
    """The largest speed that drives: of a wheel's surface, or of the body at the start; one if all stands still."""
    at_rim = array_size(model) * abs(velocity[2])
    return max(max_norm(model.targets), norm(velocity[:2]), at_rim) or 1.0


# ---- friction ------------------------------------------------------------------------------------


class EllipseFriction:
    """Friction of all wheels as one force and one torque on the body: friction ellipses, cut or whole, regularized.

    With slips ``r = d . v(p) - u`` and ``s = n . v(p)`` the associated law of the friction ellipse is minus the
    gradient of the dissipation, ``f = -N (mu_R^2 r, mu_S^2 s)/sqrt(mu_R^2 r^2 + mu_S^2 s^2)``: among all forces of the
    ellipse the one that takes the most power from the slip.  At r = s = 0 every force of the ellipse is allowed
    (stick).  An integrator needs a function, so the root becomes ``sqrt(mu_R^2 r^2 + mu_S^2 s^2 + (mu e)^2)`` with
    ``mu = max(mu_R, mu_S)`` and a creep speed e: the force stays inside the ellipse, reaches 99 % of its limit at a
    slip of ``7 e`` along the axis of more friction, and a wheel that should stick creeps at a speed of order e.  The
    law is then the gradient of a smooth convex function, so friction never gives power to the slip and its derivative
    with respect to velocity is symmetric and at most zero.

    Velocities are those of the centre of mass, ``(w, omega)`` with ``w = c' = v + omega J c``; the point of the body
    over wheel i moves with ``w + omega J (p_i - c)``.  So rows depend on c (their moment arm) and never on theta.
    """

    def __init__(self, model: ContactModel, creep: float) -> None:
        """For the contacts of an array and the creep speed e (length/time), above zero."""
        self._model = model
        self._frames = np.ascontiguousarray(model.rows[:, :2])  # d_1, n_1, d_2, n_2, ...
        self._turned = turned(self._frames)
        self._sets = model.sets
        self._third = np.maximum(self._sets.along, self._sets.across) * creep
        self._third[self._third == 0] = 1.0  # a wheel without friction: its force is zero in any case

    def rows(self, centre: Floats) -> Floats:
        """Rows ``(e, e . J(p_i - c))`` for e = d_i, n_i, acting on ``(w, omega)``; shape (2n, 3)."""
        offsets = self._model.positions - centre  # first, so that an array far from the origin loses no digits
        arms = -(self._turned.reshape(-1, 2, 2) @ offsets[..., None]).reshape(-1)
        return np.concatenate([self._frames, arms[:, None]], axis=1)

    def forces(self, centre: Floats, velocity: Floats, loads: Floats) -> Floats:
        """Forces along and across every rim, shape (n, 2)."""
        return loads[:, None] * self._shares(*self._slips(self.rows(centre), velocity))

    def total(self, centre: Floats, velocity: Floats, loads: Floats) -> Floats:
        """Force and torque about the centre of mass ``(F_x, F_y, tau)``, in units of the body's weight."""
        return self.rows(centre).T @ self.forces(centre, velocity, loads).reshape(-1)

    def per_load(self, centre: Floats, velocity: Floats) -> Floats:
        """Force and torque of every wheel per unit of its load, shape (n, 3)."""
        rows = self.rows(centre)
        return np.einsum("ni,nij->nj", self._shares(*self._slips(rows, velocity)), rows.reshape(-1, 2, 3))

    def slopes(self, centre: Floats, velocity: Floats, loads: Floats, by_centre: Floats) -> tuple[Floats, Floats]:
        """Derivatives of the total with respect to c, (3, 2), and ``(w, omega)``, (3, 3), symmetric and at most zero.

        Args:
            centre: c.
            velocity: ``(w, omega)``.
            loads: N, (n,).
            by_centre: their derivative with respect to c, (n, 2).
        """
        rows = self.rows(centre)
        pairs, (r, s) = rows.reshape(-1, 2, 3), self._slips(rows, velocity)
        share = self._shares(r, s)
        rr, rs, ss = self._sets.rounded_hessian(r, s, self._third)
        # by the slip of each wheel, which changes with c as its row's moment arm does, by omega J e
        by_slip = -loads[:, None, None] * (np.array([[rr, rs], [rs, ss]]).transpose(2, 0, 1) @ pairs)
        by_velocity = np.einsum("nij,nik->jk", pairs, by_slip)
        bent = np.einsum("ni,nij->nj", share, pairs)
        moved = np.einsum("nij,nik->jk", by_slip, velocity[2] * self._turned.reshape(-1, 2, 2)) + bent.T @ by_centre
        moved[2] += self._turned.T @ (loads[:, None] * share).reshape(-1)
        return moved, by_velocity

    def _shares(self, r: Floats, s: Floats) -> Floats:
        """Forces per unit of load, (n, 2)."""
        return -np.array(self._sets.rounded_gradient(r, s, self._third)).T

    def _slips(self, rows: Floats, velocity: Floats) -> Floats:
        """Along and across the axes, shape (2, n)."""
        return (rows @ velocity - self._model.targets).reshape(-1, 2).T


# ---- equations ---------------------------------------------------------------------------------------


class NewtonEuler:
    """The equations as an integrator wants them: state ``(x, y, theta, w_x, w_y, omega)``.

    Attributes:
        loads: by the centre of pressure.
    """

    def __init__(self, model: ContactModel, body: RigidBody, loads: MovingLoads, creep: float) -> None:
        self._friction, self._body, self.loads = EllipseFriction(model, creep), body, loads

    def __call__(self, t: float, state: Floats) -> Floats:
        """Time derivative of the state, shape (6,)."""
        total = self._friction.total(state[:2], state[3:], self.loads.at(self.pressed(state)[0])[0])
        return np.concatenate([state[3:], total / self._body.masses])

    def jacobian(self, t: float, state: Floats) -> Floats:
        """Derivative of the rate, shape (6, 6)."""
        matrix, (pressed, shift) = np.zeros((6, 6)), self.pressed(state)
        matrix[:3, 3:] = np.eye(3)
        matrix[3:, :2], matrix[3:, 3:] = self._friction.slopes(state[:2], state[3:], *self.loads.at(pressed))
        matrix[3:] = np.linalg.solve(shift, matrix[3:]) / self._body.masses[:, None]
        return matrix

    def pressed(self, state: Floats) -> tuple[Floats, Floats]:
        """The centre of pressure q, (2,), and S, (3, 3): forces change by ``S^-1`` of what they would if q were c.

        With B the derivative of forces and torque by q through the loads, (3, 2), ``S = 1 + h (B 0)``.  Newton's method
        on ``q + h sum_i N_i(q) f_i = c`` takes one step for each set of loaded wheels that it meets.
        """
        centre, height, shift = state[:2], self._body.centre_height, np.eye(3)
        if not height:
            return centre, shift
        per_load, pressed = self._friction.per_load(centre, state[3:]), centre
        for _ in range(MOST_SETS):
            loads, slope = self.loads.at(pressed)
            shift[:, :2] = np.eye(3, 2) + height * per_load.T @ slope
            missing = pressed + height * per_load[:, :2].T @ loads - centre
            if max_norm(missing) <= BALANCED * height:
                break
            pressed = pressed - np.linalg.solve(shift[:2, :2], missing)
        return pressed, shift

    def margins(self, states: Floats) -> Floats:
        """How far the body is from tipping at states (m, 6): negative where no loads balance it.

        That is the distance of the centre of pressure from the border of where loads exist.  Where the determinant of S
        is not positive a shift of the loads makes friction shift them farther, without end, and the body tips too.
        """
        if not self._body.centre_height:
            return self.loads.margins(states[:, :2])
        found = [self.pressed(state) for state in states]
        rooms = self.loads.margins(np.array([pressed for pressed, _ in found]))
        return np.array(
            [room if np.linalg.det(shift) > 0 else -1.0 for room, (_, shift) in zip(rooms, found, strict=True)]
        )


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
        return self.dense(t)


def absolute_tolerances(size: float, speed: float) -> Floats:
    """Of the six entries of a state, for a body and a motion of a size and a speed."""
    return ABSOLUTE_TOLERANCE * np.array([size, size, 1.0, speed, speed, speed / size])
