"""Twists that dissipate the least under many poses at once, in floats: ``D = sum_i N_i |w_i|``, slightly smoothed.

``w_i = W_i x - t_i`` is the slip of contact i, weighted by its friction, and ``x = (c', size theta')``.  The norms are
smoothed to ``rho_i = sqrt(|w_i|^2 + g^2)``, so that contacts may stick: the twist moves by the order of g.  Newton's
method on ``rho_i z_i = w_i`` with the forces ``z_i`` as unknowns of their own (Chan, Golub and Mulet 1999) settles in a
few steps from the twist of the step before; a step that D grows along is halved.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.float_loads import loads_at

STEPS = 25  # of Newton's method at one g
SHARPER = 0.2  # from one g to the next
HALVINGS = 8  # of a step that D grows along
ROUNDING = 1e-14  # of D
LOST = 1e3  # a step that is so many times as fast leads nowhere
SMOOTHING = 1e-6  # g, of the fastest wheel's speed times friction
SMOOTHING_OF_ROLLERS = 1e-4  # the same where D is linear in pieces, and its least value lies in corners
COARSE = 1e-2  # g up to which a twist that settled counts, where it does not with less
SETTLED = 1e-7  # step after which it ends, in the same unit
SMALLEST = 2_000  # multiplications that take as long as what every problem costs, however few contacts it has
EACH_STEP = 150_000  # the same of a step, however few problems take it
REGULAR = 1e-13  # multiple of the identity beside a Hessian, of its trace


class ManyTwists:
    """Minimizers, each from the one of the step before.

    Attributes:
        work: multiplications so far, and what takes as long: the same on every machine.
    """

    def __init__(self, speed: float, *, rollers: bool) -> None:
        """For contacts whose weighted targets are at most ``speed``, some of which may have rollers that turn."""
        self._unit, self.work = speed or 1.0, 0
        self._smoothing = SMOOTHING_OF_ROLLERS if rollers else SMOOTHING

    def minimize(self, rows: Floats, targets: Floats, loads: Floats, start: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """``x`` of shape (m, d), and whether it settled.

        Args:
            rows: weighted, (m, k, 2, d).
            targets: weighted, (m, k, 2).
            loads: (m, k).
            start: (m, d).
        """
        flat = rows.reshape(len(rows), -1, rows.shape[-1])
        found, settled = self.track(rows, targets, loads, start)
        again = np.flatnonzero(~settled)
        if len(again):
            at_rest = np.zeros((len(again), flat.shape[2]))
            found[again], settled[again] = self._from_smooth(flat[again], targets[again], loads[again], at_rest, 1.0)
        return found, settled

    def follow(self, rows: Floats, targets: Floats, loads: Floats, start: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """The same from near starts, where twists may have jumped since: g is first made larger, but not by much."""
        flat = rows.reshape(len(rows), -1, rows.shape[-1])
        found, settled = self.track(rows, targets, loads, start)
        again = np.flatnonzero(~settled)
        if len(again):
            near = flat[again], targets[again], loads[again], start[again]
            found[again], settled[again] = self._from_smooth(*near, COARSE / SHARPER)
        return found, settled

    def track(self, rows: Floats, targets: Floats, loads: Floats, start: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """The same by Newton's method from near starts alone, without another try where it does not settle."""
        flat = rows.reshape(len(rows), -1, rows.shape[-1])
        return self._settle(flat, targets, loads, start, self._smoothing)

    def _from_smooth(
        self, flat: Floats, targets: Floats, loads: Floats, start: Floats, smoothing: float
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """With g large at first: there Newton's method settles from afar."""
        found = start.copy()
        known = np.zeros(len(flat), bool)
        while True:
            smoothing = max(smoothing, self._smoothing)
            nearer, settled = self._settle(flat, targets, loads, found, smoothing)
            found = np.where(settled[:, None], nearer, found)
            known |= settled & (smoothing <= COARSE)
            if smoothing <= self._smoothing:
                return found, known
            smoothing *= SHARPER

    def _settle(
        self, flat: Floats, targets: Floats, loads: Floats, start: Floats, smoothing: float
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Newton's method at one g."""
        found, settled = start.copy(), np.zeros(len(start), bool)
        at = np.arange(len(start))
        forces: Floats | None = None
        aims, weights = targets, loads
        for _ in range(STEPS):
            x = found[at]
            self.work += EACH_STEP + len(at) * (SMALLEST + flat.shape[1] * flat.shape[2] ** 2)
            step, forces = self._step(flat, aims, weights, x, forces, smoothing)
            found[at] = x + self._downhill(flat, aims, weights, x, step, smoothing)
            sizes = np.abs(step).max(axis=1)
            settled[at[sizes <= SETTLED * self._unit]] = True
            going = (sizes > SETTLED * self._unit) & (sizes < LOST * self._unit)
            if not going.any():
                break
            at, flat, aims, weights, forces = at[going], flat[going], aims[going], weights[going], forces[going]
        return found, settled & np.isfinite(found).all(axis=1)

    def _downhill(
        self, flat: Floats, targets: Floats, loads: Floats, x: Floats, step: Floats, smoothing: float
    ) -> Floats:
        """The steps (m, d), halved until the smoothed D does not grow."""
        before = self._value(flat, targets, loads, x, smoothing) * (1 + ROUNDING)
        steps, trying = step.copy(), np.arange(len(x))
        for _ in range(HALVINGS):
            there = self._value(flat[trying], targets[trying], loads[trying], x[trying] + steps[trying], smoothing)
            trying = trying[~(there <= before[trying])]
            if not len(trying):
                break
            steps[trying] /= 2
        return steps

    def _value(self, flat: Floats, targets: Floats, loads: Floats, x: Floats, smoothing: float) -> Floats:
        """``sum_i N_i rho_i``, shape (m,)."""
        slips = (flat @ x[..., None]).reshape(targets.shape) - targets
        return np.asarray((loads * np.sqrt(_inner(slips, slips) + (smoothing * self._unit) ** 2)).sum(axis=1))

    def _step(
        self, flat: Floats, targets: Floats, loads: Floats, x: Floats, forces: Floats | None, smoothing: float
    ) -> tuple[Floats, Floats]:
        """The Newton step (m, d), and the forces after it, kept in their unit discs (m, k, 2)."""
        slips = (flat @ x[..., None]).reshape(targets.shape) - targets
        sizes = np.sqrt(_inner(slips, slips) + (smoothing * self._unit) ** 2)
        units = slips / sizes[..., None]
        z = units if forces is None else forces
        pull = loads / sizes
        gradient = (flat.transpose(0, 2, 1) @ (loads[..., None] * units).reshape(len(x), -1, 1))[..., 0]
        # sum of N/rho W^T (1 - sym(z w^T)/rho) W
        whole = flat.reshape(*targets.shape, -1)
        first, second = whole[:, :, 0], whole[:, :, 1]
        along_w = units[..., :1] * first + units[..., 1:] * second
        along_z = (pull * z[..., 0])[..., None] * first + (pull * z[..., 1])[..., None] * second
        weighted = np.repeat(pull, 2, axis=1)[..., None] * flat
        mixed = along_z.transpose(0, 2, 1) @ along_w
        hessian = flat.transpose(0, 2, 1) @ weighted - (mixed + mixed.transpose(0, 2, 1)) / 2
        trace = np.trace(hessian, axis1=1, axis2=2)
        hessian += (REGULAR * np.abs(trace) + 1e-300)[:, None, None] * np.eye(x.shape[1])
        step = -np.linalg.solve(hessian, gradient[..., None])[..., 0]
        moved = (flat @ step[..., None]).reshape(targets.shape)
        z = units + (moved - z * _inner(units, moved)[..., None]) / sizes[..., None]
        z /= np.maximum(np.sqrt(_inner(z, z)), 1.0)[..., None]
        return np.asarray(step, float), z


def _inner(first: Floats, second: Floats) -> Floats:
    """Inner products over the last axis, of length two: several times as fast as a sum over so short an axis."""
    return np.asarray(first[..., 0] * second[..., 0] + first[..., 1] * second[..., 1])


def with_rollers(rows: Floats, targets: Floats, loads: Floats, cuts: Floats) -> tuple[Floats, Floats, Floats]:
    """The same as sums of norms where strips cut the ellipses: one more unknown ``t_i``, how fast rollers turn.

    The support function of the cut ellipse is ``min over t of |w - t e_2| + cut |t|``.

    Args:
        rows: weighted by the half-axes, (m, k, 2, 3).
        targets: weighted, (m, k, 2).
        loads: (m, k).
        cuts: (m, k), 1 where nothing is cut.

    Returns:
        rows (m, 2k, 2, 3 + k), targets (m, 2k, 2) and loads (m, 2k).
    """
    m, k = loads.shape
    wide = np.zeros((m, 2 * k, 2, 3 + k))
    wide[:, :k, :, :3] = rows
    which = np.arange(k)
    wide[:, which, 1, 3 + which] = -1.0
    wide[:, k + which, 1, 3 + which] = cuts
    return wide, np.concatenate([targets, np.zeros_like(targets)], axis=1), np.concatenate([loads, loads], axis=1)


def turning_rollers(rows: Floats, targets: Floats, cuts: Floats, x: Floats) -> Floats:
    """The ``t`` (m, k) that are least at twists x (m, 3)."""
    along, across = np.moveaxis((rows @ x[:, None, :, None])[..., 0] - targets, -1, 0)
    kept = np.abs(along) * cuts / np.sqrt(np.maximum(1 - cuts**2, 1e-12))
    return np.asarray(np.sign(across) * np.maximum(np.abs(across) - kept, 0.0))


class MovingTwists:
    """Twists ``(v, omega)`` of bodies that move over all wheels of an array, each from the last one of its path."""

    def __init__(self, model: ContactModel, paths: int) -> None:
        """For the contacts of an array whose loads are known.

        Raises:
            ValueError: for friction sets of another shape than ellipses, cut or whole.
        """
        model.require_ellipses()
        self._model, self._size = model, float(np.hypot(*model.positions.T).max()) or 1.0
        self._unit = np.array([1.0, 1.0, self._size])
        weights = model.friction.reshape(-1, 2)
        self._rows = weights[..., None] * model.rows.reshape(-1, 2, 3) / self._unit
        self._targets = weights * model.targets.reshape(-1, 2)
        self._turns = bool((model.cuts < 1).any())
        self._twists = ManyTwists(float(np.abs(self._targets).max()), rollers=self._turns)
        self._last = np.zeros((paths, 3))

    @property
    def work(self) -> int:
        """What all Newton steps so far cost, in multiplications; the speeds of rollers are unknowns too."""
        return self._twists.work

    def remember(self, twists: Floats, paths: NDArray[np.int_]) -> None:
        """Begin at twists (m, 3) on the paths of these numbers (m,)."""
        self._last[paths] = twists * self._unit

    def at(self, centres: Floats, paths: NDArray[np.int_]) -> tuple[Floats, NDArray[np.bool_]]:
        """Twists at centres of mass (m, 2) of the paths of these numbers (m,): shape (m, 3), and whether they settled.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where a load of a table is negative.
        """
        count, start, loads = len(centres), self._last[paths], loads_at(self._model, centres)
        rows = np.broadcast_to(self._rows, (count, *self._rows.shape))
        targets = np.broadcast_to(self._targets, (count, *self._targets.shape))
        if self._turns:
            cuts = np.broadcast_to(self._model.cuts, loads.shape)
            start = np.concatenate([start, turning_rollers(rows, targets, cuts, start)], axis=1)
            rows, targets, loads = with_rollers(rows, targets, loads, cuts)
        settle = self._twists.follow if self._turns else self._twists.track
        found, settled = settle(rows, targets, loads, start)
        self._last[paths[settled]] = found[settled, :3]
        return found[:, :3] / self._unit, settled
