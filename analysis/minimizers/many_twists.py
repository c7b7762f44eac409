"""Twists that dissipate the least under many poses at once, in floats: ``D = sum_i N_i |w_i|``, slightly smoothed.

``w_i = W_i x - t_i`` is the slip of contact i, weighted by its friction, and ``x = (c', size theta')``.  The norms are
smoothed to ``rho_i = sqrt(|w_i|^2 + g^2)``, so that contacts may stick: the twist moves by the order of g.  Newton's
method with the forces as unknowns of their own (:meth:`nonsmooth.symbolic.mechanics.friction_set.UnitDiscs.approach`)
settles in a few steps from the twist of the step before; a step that D grows along is halved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.symbolic.mechanics.friction_set import UnitDiscs
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask

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


class Contacts(NamedTuple):
    """Contacts of m bodies, k each, in units of their half-axes.

    Attributes:
        rows: W, shape (m, 2k, 3), first those along, then those across.
        targets: t, shape (m, 2k).
        loads: N, shape (m, k).
        cuts: kappa (m, k), 1 where nothing is cut.
    """

    rows: Floats
    targets: Floats
    loads: Floats
    cuts: Floats

    @classmethod
    def of(cls, rows: Floats, targets: Floats, loads: Floats, cuts: Floats) -> Contacts:
        """For rows of shape (m, k, 2, 3) and targets of shape (m, k, 2)."""
        along_first, goals = (np.concatenate([array[:, :, 0], array[:, :, 1]], axis=1) for array in (rows, targets))
        return cls(along_first, goals, loads, cuts)

    def take(self, chosen: Mask | Indices) -> Contacts:
        """Of some bodies."""
        return Contacts(*(array[chosen] for array in self))

    def moved(self, x: Floats) -> tuple[Floats, Floats]:
        """``W x`` along and across, each (m, k), of x (m, 3)."""
        moves, k = (self.rows @ x[..., None])[..., 0], self.loads.shape[1]
        return moves[:, :k], moves[:, k:]

    def slips(self, x: Floats) -> tuple[Floats, Floats]:
        """``W x - t``."""
        (along, across), k = self.moved(x), self.loads.shape[1]
        return along - self.targets[:, :k], across - self.targets[:, k:]

    def total(self, pairs: Floats) -> Floats:
        """``W^T`` of pairs (2, m, k): shape (m, 3)."""
        return np.asarray((np.concatenate([*pairs], axis=1)[:, None] @ self.rows)[:, 0])

    def hessian(self, rates: Floats) -> Floats:
        """``W^T S W`` with S by its entries ``(xx, yy, xy)``, (3, m, k): shape (m, 3, 3)."""
        (xx, yy, xy), k = rates[..., None], self.loads.shape[1]
        first, second = self.rows[:, :k], self.rows[:, k:]
        weighted = np.concatenate([xx * first + xy * second, xy * first + yy * second], axis=1)
        return np.asarray(self.rows.transpose(0, 2, 1) @ weighted)


class ManyTwists:
    """Minimizers, each from the one of the step before.

    Attributes:
        work: multiplications so far, and what takes as long: the same on every machine.
    """

    def __init__(self, speed: float, *, rollers: bool) -> None:
        """For contacts whose weighted targets are at most ``speed``, some of which may have rollers that turn."""
        self._unit, self.work = speed or 1.0, 0
        self._smoothing = SMOOTHING_OF_ROLLERS if rollers else SMOOTHING

    def minimize(self, contacts: Contacts, start: Floats) -> tuple[Floats, Mask]:
        """``x`` of shape (m, 3) from others, and whether it settled."""
        return self._again(contacts, *self.track(contacts, start), np.zeros_like(start), 1.0)

    def follow(self, contacts: Contacts, start: Floats) -> tuple[Floats, Mask]:
        """The same from near starts, where twists may have jumped since: g is first made larger, but not by much."""
        return self._again(contacts, *self.track(contacts, start), start, COARSE / SHARPER)

    def track(self, contacts: Contacts, start: Floats) -> tuple[Floats, Mask]:
        """The same by Newton's method from near starts alone, without another try where it does not settle."""
        return self._settle(contacts, start, self._smoothing)

    def _again(
        self, contacts: Contacts, found: Floats, settled: Mask, start: Floats, smoothing: float
    ) -> tuple[Floats, Mask]:
        """Where it did not settle, from a start and with g large at first."""
        again = np.flatnonzero(~settled)
        if len(again):
            found[again], settled[again] = self._from_smooth(contacts.take(again), start[again], smoothing)
        return found, settled

    def _from_smooth(self, contacts: Contacts, start: Floats, smoothing: float) -> tuple[Floats, Mask]:
        """With g large at first: there Newton's method settles from afar."""
        found = start.copy()
        known = np.zeros(len(start), bool)
        while True:
            smoothing = max(smoothing, self._smoothing)
            nearer, settled = self._settle(contacts, found, smoothing)
            found = np.where(settled[:, None], nearer, found)
            known |= settled & (smoothing <= COARSE)
            if smoothing <= self._smoothing:
                return found, known
            smoothing *= SHARPER

    def _settle(self, contacts: Contacts, start: Floats, smoothing: float) -> tuple[Floats, Mask]:
        """Newton's method at one g."""
        found, settled, g = start.copy(), np.zeros(len(start), bool), smoothing * self._unit
        at, sets, slips = np.arange(len(start)), UnitDiscs(contacts.cuts), contacts.slips(start)
        turning = sets.rollers(*slips)
        forces = np.array(sets.rounded_arc(slips[0], slips[1] - turning, g)[1:])
        for _ in range(STEPS):
            self.work += EACH_STEP + len(at) * (SMALLEST + contacts.rows.shape[1] * contacts.rows.shape[2] ** 2)
            x = found[at]
            step, change, turns = _newton_step(contacts, sets, x, forces, turning, g)
            share = _downhill(contacts, x, step, turning, turns, g)
            found[at] = x + share * step
            forces = forces + change
            forces /= np.maximum(sets.gauge(*forces), 1.0)
            turning = turning + share * turns
            sizes = np.maximum(np.abs(step).max(axis=1), np.abs(turns).max(axis=1, initial=0.0))
            settled[at[sizes <= SETTLED * self._unit]] = True
            going = (sizes > SETTLED * self._unit) & (sizes < LOST * self._unit)
            if not going.any():
                break
            at, contacts, forces, turning = at[going], contacts.take(going), forces[:, going], turning[going]
            sets = UnitDiscs(contacts.cuts)
        return found, settled & np.isfinite(found).all(axis=1)


def _newton_step(
    contacts: Contacts, sets: UnitDiscs, x: Floats, forces: Floats, turning: Floats, g: float
) -> tuple[Floats, Floats, Floats]:
    """Of x (m, 3), of the forces (2, m, k), which are unknowns of their own, and of the speeds of rollers (m, k)."""
    near = sets.approach(contacts.slips(x), forces, turning, g)
    gradient = contacts.total(contacts.loads * (forces + near.move))
    hessian = contacts.hessian(contacts.loads * near.rates)
    trace = np.trace(hessian, axis1=1, axis2=2)
    hessian += (REGULAR * np.abs(trace) + 1e-300)[:, None, None] * np.eye(x.shape[1])
    step: Floats = -np.linalg.solve(hessian, gradient[..., None])[..., 0].astype(np.float64, copy=False)
    change = near.change(*contacts.moved(step))
    return step, change, np.broadcast_to(near.turned(change), turning.shape)


def _downhill(contacts: Contacts, x: Floats, step: Floats, turning: Floats, turns: Floats, g: float) -> Floats:
    """The share (m, 1) of a step, halved until the smoothed D does not grow."""
    before = _value(contacts, x, turning, g) * (1 + ROUNDING)
    shares, trying = np.ones((len(x), 1)), np.arange(len(x))
    for _ in range(HALVINGS):
        share = shares[trying]
        ahead = x[trying] + share * step[trying], turning[trying] + share * turns[trying]
        there = _value(contacts.take(trying) if len(trying) < len(x) else contacts, *ahead, g)
        trying = trying[~(there <= before[trying])]
        if not len(trying):
            break
        shares[trying] /= 2
    return shares


def _value(contacts: Contacts, x: Floats, turning: Floats, g: float) -> Floats:
    """The smoothed D, shape (m,)."""
    sets = UnitDiscs(contacts.cuts)
    return np.asarray((contacts.loads * sets.rounded_support(*contacts.slips(x), turning, g)).sum(axis=1))


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
        """What all Newton steps so far cost, in multiplications."""
        return self._twists.work

    def remember(self, twists: Floats, paths: Indices) -> None:
        """Begin at twists (m, 3) on the paths of these numbers (m,)."""
        self._last[paths] = twists * self._unit

    def at(self, centres: Floats, paths: Indices) -> tuple[Floats, Mask]:
        """Twists at centres of mass (m, 2) of the paths of these numbers (m,): shape (m, 3), and whether they settled.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where a load of a table is negative.
        """
        count, loads = len(centres), loads_at(self._model, centres)
        rows = np.broadcast_to(self._rows, (count, *self._rows.shape))
        targets = np.broadcast_to(self._targets, (count, *self._targets.shape))
        contacts = Contacts.of(rows, targets, loads, np.broadcast_to(self._model.cuts, loads.shape))
        settle = self._twists.follow if self._turns else self._twists.track
        found, settled = settle(contacts, self._last[paths])
        self._last[paths[settled]] = found[settled]
        return found / self._unit, settled
