"""The quasi-static path of a rule without cells: at every instant the body moves with the minimizer of the dissipation.

``c' = v + omega J c, theta' = omega`` with ``xi = (v, omega)`` from the interior point minimizer at the current loads.
Under rule ``ellipse`` the field is continuous, smooth where no wheel sticks, and stiff where mu_S is much smaller than
mu_R (near an equilibrium it decays like ``(mu_R/mu_S)^2``), so LSODA follows it, which turns implicit where that pays.
A minimizer costs about a millisecond.  Where the minimizer is not unique the one that the interior point method
returns is taken.  Where friction sets have corners (rule ``roller``) the twist may jump, and the path slide: there
the field has a little drag (:mod:`nonsmooth.analysis.dynamics.drag`), and is so stiff that backward differentiation
formulas follow it from the start.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.dynamics.continuous_path import as_trajectory, integrate
from nonsmooth.analysis.dynamics.drag import loads_with_drag, needs_drag, with_drag
from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseInterior, WarmInterior
from nonsmooth.analysis.minimizers.minimum import Minima
from nonsmooth.analysis.minimizers.proved import resists_every_motion
from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError
from nonsmooth.symbolic.number_text import place_text

Minimize: TypeAlias = Callable[[Floats], Minima]  # from loads (n,)

RELATIVE_TOLERANCE = 1e-9  # per step; the minimizer itself is right to about 1e-12
ABSOLUTE_TOLERANCE = 1e-11  # length and radians
LOOSER = 100.0  # of both with drag, which moves a path by more, and turns rounding of forces into 1e-9 of a twist


def ellipse_path(model: ContactModel, start: Sequence[float], until: float) -> Trajectory:
    """Follow a rule without cells from ``(x, y, theta)`` at time zero, by the model with its friction sets.

    Raises:
        ValueError: for a last time that is not positive, or numbers that are not finite.
        nonsmooth.analysis.cells.loads.LoadError: for a start without loads.
        nonsmooth.analysis.trajectories.result.TrajectoryError: where the integrator gives up, or a minimizer is not
            proved to be the motion.
    """
    state = np.array(start, float)
    if not (np.isfinite(state).all() and 0 < until < math.inf):
        raise ValueError(f"required a finite start and a positive last time, received {state.tolist()} and {until}")
    loads, dragged = MovingLoads(model, state[:2]), needs_drag(model)
    minimize = path_minimizer(model) if dragged else partial(EllipseInterior().minimize, model)

    def rate(t: float, pose: Floats) -> Floats:
        here = loads.at(pose[:2])[0]
        minima = minimize(here)
        if not (minima.check() & resists_every_motion(model, here[None]))[0]:
            x, y = (float(value) for value in pose[:2])
            raise TrajectoryError(
                f"required a certified motion, received a minimum without proof at {place_text((x, y))}"
            )
        (twist,) = minima.twists
        return twist + twist[2] * np.array([-pose[1], pose[0], 0.0])

    looser = LOOSER if dragged else 1.0
    tolerances = {"rtol": looser * RELATIVE_TOLERANCE, "atol": looser * ABSOLUTE_TOLERANCE}
    solution = integrate(rate, loads, state, until, method="BDF" if dragged else "LSODA", **tolerances)
    return as_trajectory("minimizer", solution, loads)


def path_minimizer(model: ContactModel) -> Minimize:
    """The minimizer at loads (n,), one after the other along a path: of D, plus drag where the twist may jump."""
    if not needs_drag(model):
        return WarmInterior(model).minimize
    minimizer = WarmInterior(with_drag(model))
    return lambda loads: minimizer.minimize(loads_with_drag(loads))
