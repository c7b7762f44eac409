"""Twists that dissipate the least under many poses at once, in floats: ``D = sum_i N_i |w_i|``, slightly smoothed.

``w_i = W_i x - t_i`` is the slip of contact i, weighted by its friction, and ``x = (c', size theta')``.  The norms are
smoothed to ``rho_i = sqrt(|w_i|^2 + g^2)``, so that contacts may stick: the twist moves by the order of g.  Newton's
method with the forces as unknowns of their own (:meth:`nonsmooth.symbolic.mechanics.friction_set.UnitDiscs.approach`)
settles in a few steps from a twist nearby, such as one of the steps before; a step that D grows along is halved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.loads.spring_loads import spring_loads
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import may_jump
from nonsmooth.symbolic.mechanics.friction_set import UnitDiscs
from nonsmooth.symbolic.mechanics.springs import EqualSprings
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, finite_rows, max_norms

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

    def moved(self, x: Floats) -> Floats:
        """``W x`` along and across, shape (2, m, k), of x (m, 3)."""
        return self._pairs(self.rows @ x[..., None])

    def slips(self, x: Floats) -> Floats:
        """``W x - t``."""
        return self._pairs((self.rows @ x[..., None])[..., 0] - self.targets)

    def _pairs(self, sides: Floats) -> Floats:
        """Entries along before those across, of each body, as an array (2, m, k)."""
        count, k = self.loads.shape
        return sides.reshape(count, 2, k).swapaxes(0, 1)

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
    """Minimizers, each from twists that are near it or may be.

    Attributes:
        work: multiplications so far, and what takes as long: the same on every machine.
    """

    def __init__(self, speed: float, *, rollers: bool) -> None:
        """For contacts whose weighted targets are at most ``speed``, some of which may have rollers that turn."""
        self._unit, self.work = speed or 1.0, 0
        self._smoothing = SMOOTHING_OF_ROLLERS if rollers else SMOOTHING

    def minimize(self, contacts: Contacts, starts: Floats) -> tuple[Floats, Mask]:
        """``x`` of shape (m, 3) from the best of others (m, s, 3), and whether it settled."""
        start = _best(contacts, starts, self._smoothing * self._unit)
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
        at, now = np.arange(len(start)), _Iterate.at(contacts, start, g)
        for _ in range(STEPS):
            self.work += EACH_STEP + len(at) * (SMALLEST + contacts.rows.shape[1] * contacts.rows.shape[2] ** 2)
            step = _newton_step(contacts, now, g)
            share = _downhill(contacts, now, step, g)
            found[at] += share * step.twists
            now = now.after(step, share)
            sizes = np.maximum(max_norms(step.twists), np.abs(step.turning).max(axis=1, initial=0.0))
            settled[at[sizes <= SETTLED * self._unit]] = True
            going = (sizes > SETTLED * self._unit) & (sizes < LOST * self._unit)
            if not going.any():
                break
            if not going.all():
                at, contacts, now = at[going], contacts.take(going), now.take(going)
        return found, settled & finite_rows(found)


class _Step(NamedTuple):
    """A step of Newton's method of m bodies: of twists (m, 3), and of what an iterate holds."""

    twists: Floats
    slips: Floats
    forces: Floats
    turning: Floats

    def take(self, chosen: Mask) -> _Step:
        """Of some bodies."""
        return _Step(self.twists[chosen], self.slips[:, chosen], self.forces[:, chosen], self.turning[chosen])


class _Iterate(NamedTuple):
    """Where Newton's method has come with m bodies, k contacts each.

    Attributes:
        sets: the friction sets.
        slips: ``W x - t``, shape (2, m, k).
        forces: unknowns of their own, (2, m, k).
        turning: the speeds of rollers (m, k).
    """

    sets: UnitDiscs
    slips: Floats
    forces: Floats
    turning: Floats

    @classmethod
    def at(cls, contacts: Contacts, x: Floats, g: float) -> _Iterate:
        """Of twists (m, 3), with the forces and rollers of their slips."""
        sets, slips = UnitDiscs(contacts.cuts), contacts.slips(x)
        turning = sets.rollers(*slips)
        forces = np.array(sets.rounded_arc(slips[0], slips[1] - turning, g)[1:])
        return cls(sets, slips, forces, turning)

    def take(self, chosen: Mask) -> _Iterate:
        """Of some bodies."""
        sets = UnitDiscs(self.sets.cut[chosen])
        return _Iterate(sets, self.slips[:, chosen], self.forces[:, chosen], self.turning[chosen])

    def after(self, step: _Step, share: Floats) -> _Iterate:
        """With forces within their sets, after a share (m, 1) of the steps of slips and of rollers."""
        forces = self.forces + step.forces
        forces /= np.maximum(self.sets.gauge(*forces), 1.0)
        return self._replace(
            slips=self.slips + share * step.slips, forces=forces, turning=self.turning + share * step.turning
        )

    def values(self, loads: Floats, g: float) -> Floats:
        """The smoothed D, shape (m,)."""
        along, across = self.slips
        return np.asarray((loads * self.sets.rounded_support(along, across, self.turning, g)).sum(axis=1))


def _newton_step(contacts: Contacts, now: _Iterate, g: float) -> _Step:
    """The step of all unknowns, the forces and the speeds of rollers among them."""
    near = now.sets.approach(now.slips, now.forces, now.turning, g)
    gradient = contacts.total(contacts.loads * (now.forces + near.move))
    hessian = contacts.hessian(contacts.loads * near.rates)
    trace = np.trace(hessian, axis1=1, axis2=2)
    hessian += (REGULAR * np.abs(trace) + 1e-300)[:, None, None] * np.eye(hessian.shape[1])
    twists: Floats = -np.linalg.solve(hessian, gradient[..., None])[..., 0].astype(np.float64, copy=False)
    slips = contacts.moved(twists)
    forces = near.change(*slips)
    return _Step(twists, slips, forces, np.broadcast_to(near.turned(forces), now.turning.shape))


def _downhill(contacts: Contacts, now: _Iterate, step: _Step, g: float) -> Floats:
    """The share (m, 1) of a step, halved until the smoothed D does not grow."""
    highest = now.values(contacts.loads, g) * (1 + ROUNDING)
    shares, trying = np.ones((len(highest), 1)), np.arange(len(highest))
    loads = contacts.loads
    for _ in range(HALVINGS):
        share = shares[trying]
        ahead = now._replace(slips=now.slips + share * step.slips, turning=now.turning + share * step.turning)
        grows = ~(ahead.values(loads, g) <= highest[trying])
        if not grows.any():
            break
        trying, loads, now, step = trying[grows], loads[grows], now.take(grows), step.take(grows)
        shares[trying] /= 2
    return shares


def _best(contacts: Contacts, starts: Floats, g: float) -> Floats:
    """That one of some twists (m, s, 3) of each body at which the smoothed D is least, shape (m, 3)."""
    values = [_Iterate.at(contacts, starts[:, k], g).values(contacts.loads, g) for k in range(starts.shape[1])]
    return np.asarray(starts[np.arange(len(starts)), np.argmin(values, axis=0)])


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
        self._turns = may_jump(model)
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


# ---- the contacts under many poses of one body at once -------------------------------------------
#
# In floats: which wheels are near, their loads, who tips.  Under a rule without cells ``(c', theta')`` depends on c and
# on the wheels that carry, whatever the heading is.
#
# Each pose keeps a list of wheels near enough to come under the outline soon; one row of every array is one pose.
# Loads are those of springs.  The centre of mass lies strictly inside the hull of the carrying wheels
# iff no two of them that follow each other around it are half a turn or more apart; else the body tips over the line
# through the two with the widest gap.


NOBODY = -1  # number of a wheel that is none


def nearest_wheels(places: Floats, centres: Floats, reach: float) -> Indices:
    """Numbers of the wheels (n, 2) within a distance of each centre (m, 2), shape (m, k); :data:`NOBODY` fills up."""
    from scipy.spatial import cKDTree

    found = cKDTree(places).query_ball_point(centres, reach, return_sorted=True)
    width = max((len(near) for near in found), default=0)
    numbers = np.full((len(centres), max(width, 1)), NOBODY)
    for row, near in zip(numbers, found, strict=True):
        row[: len(near)] = near
    return numbers


def widest_gaps(levers: Floats, carrying: Mask) -> tuple[Floats, Indices, Indices]:
    """The widest angle between carrying wheels that follow each other around the centre of mass, and both of them.

    Args:
        levers: ``p_i - c``, shape (m, k, 2).
        carrying: shape (m, k).

    Returns:
        angles (m,), infinite without a wheel; columns (m,) of the two wheels, counterclockwise.
    """
    angles = np.where(carrying, np.arctan2(levers[..., 1], levers[..., 0]), np.inf)
    order = np.argsort(angles, axis=1)
    ascending = np.take_along_axis(angles, order, axis=1)
    count = carrying.sum(axis=1)
    rows = np.arange(len(angles))
    last = np.maximum(count - 1, 0)
    with np.errstate(invalid="ignore"):
        gaps = np.diff(ascending, axis=1, append=np.inf)
        gaps[rows, last] = ascending[:, 0] + 2 * np.pi - ascending[rows, last]
    gaps[np.arange(gaps.shape[1]) >= count[:, None]] = -np.inf
    widest = gaps.argmax(axis=1)
    following = np.where(widest >= last, 0, widest + 1)
    wide = np.where(count > 0, gaps[rows, widest], np.inf)
    return wide, order[rows, widest], order[rows, following]


def carrying_first(carrying: Mask, levers: Floats) -> tuple[Indices, Mask, Floats]:
    """The columns of wheels that carry before those of others, in as few columns as hold them.

    Args:
        carrying: shape (m, k).
        levers: ``p_i - c``, shape (m, k, 2).

    Returns:
        the columns (m, j), at least one, and both arrays there.
    """
    order = np.argsort(~carrying, axis=1, kind="stable")[:, : max(int(carrying.sum(axis=1).max()), 1)]
    return order, np.take_along_axis(carrying, order, axis=1), np.take_along_axis(levers, order[..., None], axis=1)


def loads_of(model: ContactModel, wheels: Indices, carrying: Mask, levers: Floats) -> tuple[Floats, Mask]:
    """``N`` of shape (m, k), zero beside the body, and whether it balances the weight.

    Args:
        model: whose law lets wheels lift off.
        wheels: numbers of wheels, shape (m, k).
        carrying: which of them are under the body.
        levers: ``p_i - c``, shape (m, k, 2).
    """
    loads, balanced = elastic_loads_of(levers, carrying)
    if model.law == EqualSprings():
        return loads, balanced
    for k in np.flatnonzero(balanced):  # one after the other: a law is known by its forms on one set
        under = np.flatnonzero(carrying[k])
        carried = model.on(wheels[k, under].tolist())
        try:
            loads[k, under] = loads_at(carried, carried.positions[:1] - levers[k, under[:1]])
        except LoadError:
            balanced[k] = False
    return loads, balanced


def elastic_loads_of(levers: Floats, carrying: Mask) -> tuple[Floats, Mask]:
    """The same of equal springs."""
    sizes = np.abs(np.where(carrying[..., None], levers, 0.0)).max(axis=(1, 2))
    sizes[sizes == 0] = 1.0
    moments = np.concatenate([np.ones((*carrying.shape, 1)), levers / sizes[:, None, None]], axis=2)
    moments = np.where(carrying[..., None], moments, 0.0)
    weight = np.array([1.0, 0.0, 0.0])
    return spring_loads(moments, np.broadcast_to(weight, (len(levers), 3)))


class RowsOfWheels:
    """Rows of the contacts of any wheels of one model, about any centre of mass."""

    def __init__(self, model: ContactModel) -> None:
        frames = model.rows.reshape(-1, 2, 3)[..., :2]
        grip = model.friction.reshape(-1, 2)
        self._frames = grip[..., None] * frames
        self._targets = grip * model.targets.reshape(-1, 2)

    def at(self, wheels: Indices, levers: Floats, size: float) -> tuple[Floats, Floats]:
        """Weighted rows (m, k, 2, 3) on ``(c', size theta')`` and weighted targets (m, k, 2).

        The slip of a contact at lever q is ``frame . (c' + theta' J q) - target``.
        """
        frames = self._frames[wheels]
        turned = np.stack([-levers[..., 1], levers[..., 0]], axis=-1) / size
        turning = frames @ turned[..., None]
        return np.concatenate([frames, turning], axis=3), self._targets[wheels]


# ---- motions -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SetMotions:
    """Motions of m bodies.

    Attributes:
        rates: ``(c', size theta')``, shape (m, 3).
        loads: of all wheels (m, n), total weight 1.
        known: where the body stands and the motion was found, (m,).
    """

    rates: Floats
    loads: Floats
    known: Mask


class LeastTwists:
    """The motions of least dissipation of many bodies, each on wheels of its own."""

    def __init__(self, model: ContactModel, size: float) -> None:
        """With a length that stands for the body's size.

        Raises:
            ValueError: for friction sets of another shape than ellipses, cut or whole.
        """
        model.require_ellipses()
        self._model, self._rows, self._cuts, self._size = model, RowsOfWheels(model), model.cuts, size
        speed = float(np.abs(model.friction * model.targets).max())
        self._twists = ManyTwists(speed, rollers=bool((model.cuts < 1).any()))

    def of(self, wheels: Indices, carrying: Mask, levers: Floats, start: Floats) -> SetMotions:
        """The motions on some of the wheels (m, k), at ``p_i - c`` of shape (m, k, 2), with the loads of these wheels.

        Args:
            wheels: their numbers.
            carrying: which of them carry.
            levers: where they are.
            start: rates (m, s, 3), of which each body starts from those that dissipate the least.
        """
        loads, balanced = loads_of(self._model, wheels, carrying, levers)
        rows, targets = self._rows.at(wheels, levers, self._size)
        contacts = Contacts.of(rows, targets, loads, self._cuts[wheels])
        found, settled = self._twists.minimize(contacts, start)
        return SetMotions(np.where(settled[:, None], found, 0.0), loads, settled & balanced)


class MotionsOnSets:
    """Motions on any sets of wheels of one model."""

    def __init__(self, model: ContactModel, size: float) -> None:
        """With a length that stands for the body's size."""
        self._places, self._least = model.positions, LeastTwists(model, size)

    def at(self, carrying: Mask, centres: Floats, near: Floats | None = None) -> SetMotions:
        """The motions on wheels (m, n) with centres of mass (m, 2).

        Args:
            carrying: which wheels carry.
            centres: of mass.
            near: rates (m, 3) to start from; rest unless given.
        """
        rates, loads = np.zeros((len(centres), 3)), np.zeros(carrying.shape)
        start = rates if near is None else near
        levers = self._places - centres[:, None]
        stands = np.flatnonzero(widest_gaps(levers, carrying)[0] < np.pi)
        known = np.zeros(len(centres), bool)
        if len(stands):
            order, under, reaches = carrying_first(carrying[stands], levers[stands])
            found = self._least.of(order, under, reaches, start[stands, None])
            rates[stands], known[stands], loads[stands[:, None], order] = found.rates, found.known, found.loads
        return SetMotions(rates, loads, known)
