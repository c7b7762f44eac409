"""Normal forces in floats, for many centres of mass at once (total weight 1).

Elastic loads (identical springs, no tension) solve ``min |N|^2`` subject to
``sum N_i = 1, sum N_i p_i = c, N >= 0``.  With ``m_i = (1, p_i)`` the optimality conditions are
``N_i = max(0, m_i . y)`` and ``sum N_i m_i = (1, c)``: a piecewise linear equation in the three unknowns y,
the gradient of a convex function.  Newton's method on the loaded wheels ends after a few steps because the
pieces are finitely many; a step that overshoots is halved, and the Hessian of fewer than three loaded wheels
is made regular by a tiny multiple of the identity.  It converges for every centre of mass inside the support
polygon (its boundary included); outside no loads exist, and for collinear wheels they are undetermined.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nonsmooth.analysis.cells.loads import UNKNOWN, LoadError
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats

MAX_STEPS = 60  # Newton steps; random arrays of 3 to 100 wheels need at most 15
MAX_HALVINGS = 40  # a step halved that often no longer changes a double
RESIDUAL = 1e-13  # of the balances, for orthonormal columns, in units of 1 + |y|: what rounding of y leaves
REGULAR = 1e-13  # multiple of the identity (the Hessian of all wheels): slows the steps by this share
ON_HULL = 1e-12  # for orthonormal columns: a point closer to the support polygon counts as on it
THIN = 1e-10  # ratio of the array's two widths below which wheels count as collinear
ROUNDING = 1e-14  # relative: energies closer than this are equal in doubles
HULLS = 16  # arrays whose support polygons are remembered
BELOW_ZERO = -1e-12  # table loads down to here are rounding of 0; relative to the table's largest entry


def loads_at(model: ContactModel, points: ArrayLike) -> Floats:
    """Normal forces of the model's load rule at centres of mass (m, 2); shape (m, n).

    Raises:
        LoadError: where the scene leaves the loads open; see also :func:`elastic_loads` and :func:`table_loads`.
    """
    if model.unknown_loads:
        raise LoadError(UNKNOWN.format(model.unknown_loads))
    return elastic_loads(model, points) if model.load_table is None else table_loads(model, points)


def table_loads(model: ContactModel, points: ArrayLike) -> Floats:
    """``N_i = r_i . (1, c)`` at centres of mass (m, 2); shape (m, n).

    Raises:
        LoadError: if there is no table or a load is negative.
    """
    if model.load_table is None:
        raise LoadError("required a load table, received elastic loads")
    centres = np.atleast_2d(np.asarray(points, float))
    loads = _affine(centres) @ model.load_table.T
    scale = np.abs(_affine(centres)) @ np.abs(model.load_table).T
    negative = np.argwhere(loads < BELOW_ZERO * scale)
    if len(negative):
        row, wheel = negative[0]
        x, y = centres[row]
        raise LoadError(f"required loads >= 0, received {loads[row, wheel]:.6g} of wheel {wheel + 1} at ({x:g}, {y:g})")
    return np.maximum(loads, 0.0)


def elastic_loads(model: ContactModel, points: ArrayLike) -> Floats:
    """The unique minimizer of ``|N|^2`` at centres of mass (m, 2); shape (m, n).

    Raises:
        LoadError: if a point lies outside the support polygon or the wheels are collinear; names the point.
    """
    centres = np.atleast_2d(np.asarray(points, float))
    middle = model.positions.mean(axis=0)
    radius = float(np.hypot(*(model.positions - middle).T).max()) or 1.0
    # orthonormal columns: thin arrays are as well posed as round ones
    moments, triangle = np.linalg.qr(_affine((model.positions - middle) / radius))
    widths = np.abs(np.diag(triangle))[1:]
    if model.wheels < 3 or widths.min() < THIN * widths.max():
        raise LoadError(
            f"required three wheels that are not collinear, received {model.wheels} wheels on one line: "
            "elastic loads are undetermined"
        )
    finite = np.isfinite(centres).all(axis=1)
    goals = np.linalg.solve(triangle.T, _affine((np.where(finite[:, None], centres, middle) - middle) / radius).T).T
    tips = ~finite | _outside(moments[:, 1:], goals[:, 1:])
    if tips.any():
        x, y = centres[int(tips.argmax())]
        raise LoadError(
            f"required centres of mass inside the support polygon, received ({x:g}, {y:g}): the body tips there"
        )
    loads = np.maximum(_multipliers(moments, goals) @ moments.T, 0.0)
    rest = _newton_step(moments, loads, goals - loads @ moments)  # the rounding of y, of which the loads need no part
    return np.maximum(loads + (loads > 0) * (rest @ moments.T), 0.0)


def _affine(points: Floats) -> Floats:
    """``(1, x, y)``."""
    return np.column_stack([np.ones(len(points)), points])


def _outside(corners: Floats, points: Floats) -> NDArray[np.bool_]:
    """Whether points (m, 2) lie outside the convex hull of the corners (n, 2)."""
    sides = _hull_sides(np.ascontiguousarray(corners).tobytes())
    return np.asarray((points @ sides[:, :2].T + sides[:, 2] > ON_HULL).any(axis=1))


@lru_cache(maxsize=HULLS)
def _hull_sides(corners: bytes) -> Floats:
    """Rows ``(n_x, n_y, offset)`` with ``n . p + offset <= 0`` in the hull of corners (n, 2) of doubles.

    A path asks for the loads of one array at thousands of places.
    """
    from scipy.spatial import ConvexHull

    return np.asarray(ConvexHull(np.frombuffer(corners).reshape(-1, 2)).equations)


def _multipliers(moments: Floats, goals: Floats) -> Floats:
    """``y`` with ``sum_i max(0, m_i . y) m_i = goal`` for each goal (m, 3), by damped Newton steps.

    Raises:
        LoadError: if a point is not solved after :data:`MAX_STEPS`; no array is known that does this.
    """
    y, waiting = goals.copy(), np.arange(len(goals))  # all wheels loaded: the columns are orthonormal
    for _ in range(MAX_STEPS):
        at = y[waiting]
        forces = np.maximum(at @ moments.T, 0.0)
        gradient = forces @ moments - goals[waiting]
        unsolved = np.abs(gradient).max(axis=1) > RESIDUAL * (1 + np.abs(at).max(axis=1))
        if not unsolved.any():
            return y
        waiting, at, gradient = waiting[unsolved], at[unsolved], gradient[unsolved]
        step = _newton_step(moments, forces[unsolved], -gradient)
        y[waiting] = at + _damping(moments, goals[waiting], at, step)[:, None] * step
    raise LoadError(f"required loads within {MAX_STEPS} steps, received none for {len(waiting)} centres of mass")


def _newton_step(moments: Floats, forces: Floats, right: Floats) -> Floats:
    """Solve ``sum over loaded wheels of m_i m_i^T`` times x = right, for forces (m, n) and right sides (m, 3)."""
    products = np.einsum("ni,nj->nij", moments, moments)
    hessian = np.tensordot((forces > 0).astype(float), products, axes=1) + REGULAR * np.eye(3)
    return np.asarray(np.linalg.solve(hessian, right[..., None])[..., 0])


def _damping(moments: Floats, goals: Floats, y: Floats, step: Floats) -> Floats:
    """Powers of 1/2 at which the convex function no longer rises."""
    damping = np.ones(len(y))
    before = _energy(moments, goals, y)
    for _ in range(MAX_HALVINGS):
        rises = _energy(moments, goals, y + damping[:, None] * step) > before + ROUNDING * np.abs(before)
        if not rises.any():
            break
        damping[rises] /= 2
    return damping


def _energy(moments: Floats, goals: Floats, y: Floats) -> Floats:
    """``1/2 sum_i max(0, m_i . y)^2 - goal . y``."""
    return np.asarray(0.5 * (np.maximum(y @ moments.T, 0.0) ** 2).sum(axis=1) - (goals * y).sum(axis=1))
