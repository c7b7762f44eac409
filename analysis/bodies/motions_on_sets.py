"""Pose rates on given sets of wheels at given centres of mass, many at once, in floats.

Under a rule without cells ``(c', theta')`` depends on c and on the wheels that carry, whatever the heading is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.loads.spring_loads import spring_loads
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.many_twists import Contacts, ManyTwists
from nonsmooth.symbolic.mechanics.springs import EqualSprings
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask

# ---- the contacts under many poses of one body at once -------------------------------------------
#
# In floats: which wheels are near, their loads, who tips.
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
        own = model.on(wheels[k, under].tolist())
        try:
            loads[k, under] = loads_at(own, own.positions[:1] - levers[k, under[:1]])
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
            start: rates (m, 3) to start from.
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
            order = np.argsort(~carrying[stands], axis=1, kind="stable")[:, : int(carrying[stands].sum(axis=1).max())]
            under = np.take_along_axis(carrying[stands], order, axis=1)
            reaches = np.take_along_axis(levers[stands], order[..., None], axis=1)
            found = self._least.of(order, under, reaches, start[stands])
            rates[stands], known[stands], loads[stands[:, None], order] = found.rates, found.known, found.loads
        return SetMotions(rates, loads, known)
