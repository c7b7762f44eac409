"""Models of friction under a pushed block, each fitted to some pushes (or to none) and judged on others.

==============  =========  ===============================================================================
name            fitted     what it says
==============  =========  ===============================================================================
``naive``       nothing    the wrench is parallel to the motion
``isotropic``   nothing    point contacts at the supports, one friction in all directions, loads by statics
``ellipse``     2 numbers  the same with a friction ellipse: its ratio, and its direction in the block
``ellipsoid``   6 numbers  a limit surface of degree 2
``quartic``     15 numbers a convex limit surface of degree 4
==============  =========  ===============================================================================

Only the first two know nothing of the measured forces.  Each predicts both ways: the direction of the wrench from the
motion, and that of the motion from the wrench.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.pushes.contacts import Contacts
from nonsmooth.analysis.pushes.limit_surfaces import LimitSurface, fit_surface
from nonsmooth.analysis.pushes.measured_pushes import PushLog, angles
from nonsmooth.analysis.pushes.supports import RHO, support_loads, support_points

RATIOS = np.exp(np.linspace(-1.5, 1.5, 13))  # of the axes of a friction ellipse, tried before the search
DIRECTIONS = np.linspace(0, np.pi / 2, 7)[:-1]  # of its first axis; the rest is the same ellipse


class Predictor(Protocol):
    """Predicts directions both ways."""

    def wrenches(self, motions: Floats) -> Floats:
        """Of motions (n, 3), up to their size."""

    def motions(self, wrenches: Floats) -> Floats:
        """Of wrenches (n, 3), up to their size."""


@dataclass(frozen=True)
class Model:
    """One model.

    Attributes:
        name: as above.
        parameters: how many numbers are fitted.
        fit: makes a predictor for a log from its pushes of these numbers.
    """

    name: str
    parameters: int
    fit: Callable[[PushLog, Floats, Floats], Predictor]


class _Parallel:
    """The wrench is parallel to the motion."""

    def wrenches(self, motions: Floats) -> Floats:
        return motions

    def motions(self, wrenches: Floats) -> Floats:
        return wrenches


@dataclass(frozen=True, eq=False)
class _PointContacts:
    contacts: Contacts

    def wrenches(self, motions: Floats) -> Floats:
        return self.contacts.wrenches(motions)

    def motions(self, wrenches: Floats) -> Floats:
        return np.array([self.contacts.twist_of(wrench) for wrench in wrenches])


@dataclass(frozen=True, eq=False)
class _Surface:
    surface: LimitSurface

    def wrenches(self, motions: Floats) -> Floats:
        return self.surface.wrenches(motions)

    def motions(self, wrenches: Floats) -> Floats:
        return self.surface.gradients(wrenches)


def isotropic_contacts(support_set: int) -> Contacts:
    """The supports of the block, lengths in units of rho."""
    points = support_points(support_set)
    return Contacts.isotropic(points / RHO, support_loads(points))


def _fit_ellipse(log: PushLog, motions: Floats, wrenches: Floats) -> _PointContacts:
    """The friction ellipse whose wrenches are nearest on average: a grid, then a search from its best entry."""
    from scipy.optimize import minimize

    known = isotropic_contacts(log.support_set)

    def contacts(parameters: Floats) -> Contacts:
        return Contacts(known.points, known.loads, _axes(*parameters))

    def error(parameters: Floats) -> float:
        return float(angles(contacts(parameters).wrenches(motions), wrenches).mean())

    grid = [np.array([np.log(ratio), turn]) for ratio in RATIOS for turn in DIRECTIONS]
    best = min(grid, key=error)
    found = minimize(error, best, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-4}).x
    return _PointContacts(contacts(found))


def _axes(log_ratio: float, turn: float) -> Floats:
    """``diag(1, ratio)`` in axes turned by an angle."""
    c, s = np.cos(turn), np.sin(turn)
    return np.diag([1.0, np.exp(log_ratio)]) @ np.array([[c, s], [-s, c]])


MODELS = (
    Model("naive", 0, lambda log, motions, wrenches: _Parallel()),
    Model("isotropic", 0, lambda log, motions, wrenches: _PointContacts(isotropic_contacts(log.support_set))),
    Model("ellipse", 2, _fit_ellipse),
    Model("ellipsoid", 6, lambda log, motions, wrenches: _Surface(fit_surface(2, motions, wrenches))),
    Model("quartic", 15, lambda log, motions, wrenches: _Surface(fit_surface(4, motions, wrenches))),
)
