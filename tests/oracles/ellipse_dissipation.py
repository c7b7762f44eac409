"""Rule ``ellipse`` by its words: what slips cost under given loads, and the twist that costs least."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from nonsmooth.analysis.cells.loads import LoadRegion, value_at
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import Contacts

ROUNDING = 1e-18  # of squared slips, so that the sum has slopes everywhere
NELDER_MEAD = ({"xatol": 1e-11, "fatol": 1e-15, "maxiter": 20_000}, {"xatol": 1e-12, "fatol": 1e-16, "maxiter": 20_000})


class EllipseDissipation:
    """``sum_i N_i |(mu_R r_i, mu_S s_i)|`` as a function of the twist about the origin."""

    def __init__(self, scene: Scene, loads: Floats) -> None:
        contacts = Contacts.of(scene)
        self._loads, self._friction = loads, contacts.friction
        self._rows, self._targets = contacts.rows(list(range(len(loads))))

    def __call__(self, twist: Floats) -> float:
        along, across = (self._friction * (self._rows @ twist - self._targets).reshape(-1, 2)).T
        return float(self._loads @ np.sqrt(along**2 + across**2 + ROUNDING))

    def minimizer(self) -> Floats:
        """By a general-purpose solver, which begins once more from where it ended."""
        twist = np.zeros(3)
        for options in NELDER_MEAD:
            twist = minimize(self, twist, method="Nelder-Mead", options=options).x
        return np.asarray(twist)


def loads_in(region: LoadRegion, place: Point) -> Floats:
    """The loads of a region at a place, in floats."""
    return np.array([float(value_at(form, place)) for form in region.forces])
