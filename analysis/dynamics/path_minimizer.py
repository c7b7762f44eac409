"""The motion of least dissipation along a path: minimizers, one after the other, each with its proof.

``c' = v + omega J c, theta' = omega`` with ``xi = (v, omega)`` the minimizer at the current loads.
Newton steps from the last minimizer take a tenth of a millisecond.  Where they do not prove that theirs is the only
minimizer, that of the method of multipliers is taken, which costs a millisecond or more.

Where friction sets have corners (rule ``roller``) D is linear in pieces, as under rule ``box``: at some loads its
minimizers are a whole face, and beyond them the twist is another one.  Solutions slide along such places (Filippov),
which no integrator of smooth fields can follow.  So a little drag is added, ``sum_k epsilon sqrt(x_k^2 + g^2)`` over
the entries x of ``(v_x, v_y, L omega)``: smooth, strictly convex, least at rest.  The twist then passes from one to the
other while the slope of D along the face changes by the drag's.  It moves a twist that does not jump by the order of
epsilon.  The result is proved as ever: as the minimizer of D plus drag, whose value is within ``epsilon (|x|_1 + 3 g)``
of the least D.  The field is so stiff that backward differentiation formulas follow it from the start.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, Floats
from nonsmooth.analysis.minimizers.ellipse_minimizer import WarmMinimizer
from nonsmooth.analysis.minimizers.minimum import Minima
from nonsmooth.analysis.minimizers.proved import resists_every_motion
from nonsmooth.analysis.minimizers.smooth_newton import SmoothNewton
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.number_text import place_text

Minimize: TypeAlias = Callable[[Floats], Minima]  # from loads (n,)

DRAG = 1e-6  # of the friction of the whole weight


def proved_twist(
    model: ContactModel, quick: SmoothNewton | None, minimize: Minimize, loads: Floats, pose: Floats
) -> Floats:
    """The minimizer of D: by Newton steps from the last one, else by multipliers.

    Args:
        model: the contacts.
        quick: Newton's method, which remembers the last minimizer; None where friction sets are cut.
        minimize: what is asked where Newton's method does not prove its result.
        loads: of the wheels, shape (n,).
        pose: where the body is, for the message of an error.

    Raises:
        TrajectoryError: where the minimizer is not proved to be the motion.
    """
    found = None if quick is None else quick.minimize(loads)
    if found is not None:
        return found
    minima = minimize(loads)
    if not (minima.check() & resists_every_motion(model, loads[None]))[0]:
        place = place_text((float(pose[0]), float(pose[1])))
        raise TrajectoryError(f"required a certified motion, received a minimum without proof at {place}")
    (twist,) = minima.twists
    if quick is not None:
        quick.start_from(twist)
        quick.minimize(loads)  # finds the regime, if it can
    return np.asarray(twist)


def needs_drag(model: ContactModel) -> bool:
    """Whether D is linear in pieces somewhere: a friction set has corners."""
    return bool((model.cuts < 1).any())


def path_minimizer(model: ContactModel) -> Minimize:
    """The minimizer at loads (n,), one after the other along a path: of D, plus drag where the twist may jump."""
    if not needs_drag(model):
        return WarmMinimizer(model).minimize
    # three contacts more: along x, along y and around, each with a slip g across that never vanishes
    size = float(np.hypot(*(model.positions - model.positions.mean(axis=0)).T).max())
    speed = float(np.abs(model.targets).max()) or 1.0
    rows = np.zeros((6, 3))
    rows[[0, 2, 4], [0, 1, 2]] = 1.0, 1.0, size
    dragged = ContactRows(
        np.concatenate([model.rows, rows]),
        np.concatenate([model.targets, np.tile([0.0, speed], 3)]),
        np.concatenate([model.friction, np.full(6, model.friction.max())]),
        cuts=np.concatenate([model.cuts, np.ones(3)]),
    )
    minimizer = WarmMinimizer(dragged)
    return lambda loads: minimizer.minimize(np.concatenate([loads, np.full(3, DRAG * loads.sum())]))
