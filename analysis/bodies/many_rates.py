"""Pose rates of one body at many poses at once, in floats, and which of them do not stand.

At each pose the wheels strictly under the outline carry; their loads and the least dissipation give ``(c', theta')``,
or the cells of a rule on these wheels (:mod:`nonsmooth.analysis.bodies.many_cells`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from nonsmooth.analysis.bodies.many_contacts import (
    NOBODY,
    Mask,
    Numbers,
    nearest_wheels,
    widest_gaps,
)
from nonsmooth.analysis.bodies.motions_on_sets import LeastTwists
from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats

AROUND = 0.25  # of the body's size: how far it moves before the wheels near it are looked up again


@dataclass(frozen=True)
class Rates:
    """What is known at m poses.

    Attributes:
        rates: ``(c', theta')``, shape (m, 3), zero where the body does not stand.
        tips: where it does not.
        over: numbers of the two wheels (m, 2) over whose line it tips, -1 for none.
        none: where no wheel is under the body.
        known: where the motion was found.
    """

    rates: Floats
    tips: Mask
    over: Numbers
    none: Mask
    known: Mask


class Motions(Protocol):
    """Motions of many bodies that stand."""

    def of(self, near: Numbers, carrying: Mask, levers: Floats, poses: Floats, paths: Numbers) -> tuple[Floats, Mask]:
        """``(c', theta')`` (m, 3) at poses (m, 3) of the paths of these numbers (m,), and whether it was found.

        Args:
            near: numbers of wheels (m, k).
            carrying: which of them carry.
            levers: ``p_i - c``, shape (m, k, 2).
            poses: of the bodies.
            paths: their numbers.
        """


class LeastDissipation:
    """The motions that dissipate the least, each found from the last twist of its path."""

    def __init__(self, model: ContactModel, size: float, count: int) -> None:
        """For a number of paths of a body of some size."""
        self._least, self._size, self._last = LeastTwists(model, size), size, np.zeros((count, 3))

    def of(self, near: Numbers, carrying: Mask, levers: Floats, poses: Floats, paths: Numbers) -> tuple[Floats, Mask]:
        """See :meth:`Motions.of`."""
        found = self._least.of(near, carrying, levers, self._last[paths])
        self._last[paths] = found.rates
        return found.rates / [1.0, 1.0, self._size], found.known


class ManyRates:
    """Rates along many paths; each path keeps the wheels near it."""

    def __init__(self, motions: Motions, outline: MovingOutline, poses: Floats) -> None:
        """For paths that begin at poses (m, 3)."""
        self._motions, self._outline, self._size = motions, outline, outline.size
        self._centres = poses[:, :2].copy()
        self._near = nearest_wheels(outline.places, self._centres, self._size * (1 + AROUND))

    def at(self, poses: Floats, paths: Numbers) -> Rates:
        """The rates at poses (m, 3) of the paths of these numbers (m,)."""
        self._look_around(poses, paths)
        near = self._near[paths]
        levers = self._outline.places[near] - poses[:, None, :2]
        depths = self._outline.depths_at(self._outline.places[near], poses)
        carrying = (depths > 0) & (near != NOBODY)
        order = np.argsort(~carrying, axis=1, kind="stable")[:, : max(int(carrying.sum(axis=1).max()), 1)]
        near, carrying = np.take_along_axis(near, order, axis=1), np.take_along_axis(carrying, order, axis=1)
        levers = np.take_along_axis(levers, order[..., None], axis=1)
        gaps, first, second = widest_gaps(levers, carrying)
        tips = np.asarray(~(gaps < np.pi))
        over = np.stack([np.take_along_axis(near, k[:, None], axis=1)[:, 0] for k in (first, second)], axis=1)
        over[~tips | (carrying.sum(axis=1) < 2)] = NOBODY
        rates, known = np.zeros((len(poses), 3)), tips.copy()
        stands = np.flatnonzero(~tips)
        if len(stands):
            own = near[stands], carrying[stands], levers[stands], poses[stands], paths[stands]
            found = self._motions.of(*own)
            rates[stands], known[stands] = found
        return Rates(rates, tips, over, np.asarray(~carrying.any(axis=1)), known)

    def _look_around(self, poses: Floats, paths: Numbers) -> None:
        """Look up the wheels near those bodies that have moved far, of all paths that are asked for."""
        moved = np.hypot(*(poses[:, :2] - self._centres[paths]).T)
        if moved.max(initial=0.0) < AROUND * self._size:
            return
        self._centres[paths] = poses[:, :2]
        found = nearest_wheels(self._outline.places, poses[:, :2], self._size * (1 + AROUND))
        width = max(found.shape[1], self._near.shape[1])
        near = np.full((len(self._near), width), NOBODY)
        near[:, : self._near.shape[1]] = self._near
        near[paths] = NOBODY
        near[paths, : found.shape[1]] = found
        self._near = near
