"""The quasi-static path of rule ``ellipse``: at every instant the body moves with the minimizer of the dissipation.

``c' = v + omega J c, theta' = omega`` with ``xi = (v, omega)`` from the interior point minimizer at the current loads.
The field is continuous, smooth where no wheel sticks, and stiff where mu_S is much smaller than mu_R (near an
equilibrium it decays like ``(mu_R/mu_S)^2``), so LSODA follows it, which turns implicit where that pays.  A minimizer
costs about a millisecond.  Where the minimizer is not unique the one that the interior point method returns is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.dynamics.continuous_path import as_trajectory, integrate
from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseInterior
from nonsmooth.analysis.minimizers.proved import resists_every_motion
from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError

RELATIVE_TOLERANCE = 1e-9  # per step; the minimizer itself is right to about 1e-12
ABSOLUTE_TOLERANCE = 1e-11  # length and radians


def ellipse_path(model: ContactModel, start: Sequence[float], until: float) -> Trajectory:
    """Follow rule ``ellipse`` from ``(x, y, theta)`` at time zero, exact kinematics.

    Raises:
        ValueError: for a last time that is not positive, or numbers that are not finite.
        nonsmooth.analysis.cells.loads.LoadError: for a start without loads.
        nonsmooth.analysis.trajectories.result.TrajectoryError: where the integrator gives up, or a minimizer is not
            proved to be the motion.
    """
    state = np.array(start, float)
    if not (np.isfinite(state).all() and 0 < until < math.inf):
        raise ValueError(f"required a finite start and a positive last time, received {state.tolist()} and {until}")
    loads, minimizer = MovingLoads(model, state[:2]), EllipseInterior()

    def rate(t: float, pose: Floats) -> Floats:
        minima = minimizer.minimize(model, loads.at(pose[:2])[0])
        if not (minima.check() & resists_every_motion(model, minima.loads))[0]:
            x, y = (float(value) for value in pose[:2])
            raise TrajectoryError(
                f"required a certified motion, received a minimum without proof at ({x:.6g}, {y:.6g})"
            )
        (twist,) = minima.twists
        return twist + twist[2] * np.array([-pose[1], pose[0], 0.0])

    tolerances = {"rtol": RELATIVE_TOLERANCE, "atol": ABSOLUTE_TOLERANCE}
    solution = integrate(rate, loads, state, until, method="LSODA", **tolerances)
    return as_trajectory("minimizer", solution, loads)
