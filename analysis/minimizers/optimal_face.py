"""All minimizers at once: the face of twists on which the dissipation is minimal (Theorem 2).

Every pair of a minimizer and optimal forces is complementary: a force strictly inside its limit means zero slip,
a force at its limit means a slip against it.  So with any one optimal f the set of minimizers is a polyhedron in
the space of twists (:meth:`nonsmooth.symbolic.mechanics.friction_set.CutEllipse.slip_cone`):

- box: ``a_k . xi = b_k`` where ``|f_k| < mu N``, and ``-f_k (a_k . xi - b_k) >= 0`` where ``|f_k| = mu N``;
- ellipse, slips weighted by the limits: zero where the force is inside the ellipse, else a non-negative multiple
  of ``-f``; at a cut a slip across the rim alone, at a corner anything between these two.

Almost everywhere the equations leave one twist; :func:`undetermined` finds the other points for many at once.
There the vertices are found by intersecting as many boundaries as there are free unknowns (at most three): slow
for dozens of wheels, but such points are rare.  It needs forces good to :data:`AT_LIMIT`; vertices that do not
dissipate the minimum are dropped.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.analysis.minimizers.dissipation import Functional, dissipation, rounding_error, share_of_limit
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask

AT_LIMIT = 1e-7  # a force this close to its limit, relatively, counts as at its limit
DEPENDENT = 1e-7  # singular values of unit rows below this count as zero: the face may extend along them
SUSPECT = 1e-12  # determinant over cubed mean eigenvalue of a Gram matrix: larger means no value below DEPENDENT
INSIDE = 1e-9  # relative to the largest speed: slack of unit rows down to which a vertex satisfies them
SAME_VERTEX = 1e-8  # relative to the largest speed: distance at which two vertices are one
SAME_VALUE = 1e-9  # vertices dissipate the minimum up to this share of it
RANK = 1e-12  # relative singular value below which motions count as unresisted


class Conditions(NamedTuple):
    """Linear conditions that describe the minimizers, at m points: two rows per wheel.

    Attributes:
        mix: 2 x 2 matrix that turns (roll, side) rows of a wheel into its two conditions, shape (m, n, 2, 2).
        equation: whether a condition is an equation, shape (m, n, 2); else "at least 0".
        idle: conditions of rows without friction limit, which say nothing, shape (m, n, 2).
    """

    mix: Floats
    equation: Mask
    idle: Mask


def conditions(functional: Functional, model: ContactRows, loads: Floats, forces: Floats) -> Conditions:
    """Conditions on the minimizers from optimal forces (m, n, 2) at loads (m, n)."""
    x, y = np.moveaxis(share_of_limit(model, loads, forces), -1, 0)
    cone, equation = functional.unit_sets(model).slip_cone(x, y, AT_LIMIT)
    mix = cone * model.limits(loads)[..., None, :]
    idle = np.asarray(~mix.any(axis=-1))
    return Conditions(mix, equation & ~idle, idle)


def undetermined(functional: Functional, model: ContactRows, loads: Floats, forces: Floats) -> Mask:
    """Points (m,) at which the equations may leave more than one twist: the Gram matrix of unit rows is singular."""
    mix, equation, _ = conditions(functional, model, loads, forces)
    roll, side = row_frame(model.rows)[0].reshape(-1, 2, 3).transpose(1, 0, 2)
    products = np.stack([_symmetric(roll, roll), _symmetric(side, side), 2 * _symmetric(roll, side)])  # (3, n, 6)
    shares = np.stack([mix[..., 0] ** 2, mix[..., 1] ** 2, mix[..., 0] * mix[..., 1]])  # (3, m, n, 2)
    squares = np.einsum("kmni,kn->mni", shares, products[..., [0, 3, 5]].sum(axis=-1))
    shares *= np.divide(equation, squares, out=np.zeros_like(squares), where=squares > 0)
    coefficients = shares.sum(axis=-1).transpose(1, 0, 2).reshape(len(loads), 3 * model.wheels)
    xx, xy, xz, yy, yz, zz = (coefficients @ products.reshape(-1, 6)).T
    determinant = xx * (yy * zz - yz**2) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    return np.asarray(determinant <= SUSPECT * ((xx + yy + zz) / 3) ** 3)


def _symmetric(first: Floats, second: Floats) -> Floats:
    """Upper triangles of the symmetric parts of ``first_i second_i^T``, shape (n, 6)."""
    outer = first[:, :, None] * second[:, None, :]
    rows, columns = np.triu_indices(3)
    return np.asarray(((outer + outer.transpose(0, 2, 1)) / 2)[:, rows, columns])


def optimal_face(
    functional: Functional, model: ContactRows, loads: Floats, twist: Floats, forces: Floats
) -> Floats | None:
    """Vertices of the set of minimizers, shape (k, 3) with k >= 2, or None where it is one twist.

    Motions that no loaded row resists are left out: the face lies in their complement.

    Args:
        functional: box or ellipse.
        model: the contact rows.
        loads: normal forces, shape (n,).
        twist: a minimizer, shape (3,).
        forces: optimal forces, shape (n, 2).
    """
    (mix,), (equation,), (idle,) = conditions(functional, model, loads[None], forces[None])
    loaded = model.limits(loads).reshape(-1) > 0
    rows, to_twist = row_frame(np.where(loaded[:, None], model.rows, 0.0))
    rows = np.einsum("nij,njk->nik", mix, rows.reshape(-1, 2, 3)).reshape(-1, 3)
    slips = np.einsum("nij,nj->ni", mix, model.slips(twist)).reshape(-1)
    sizes = np.sqrt((rows**2).sum(axis=1))
    used = ~idle.reshape(-1) & (sizes > 0)
    rows, slips = rows[used] / sizes[used, None], slips[used] / sizes[used]
    scale = max(float(np.abs(model.targets).max()), float(np.abs(slips).max(initial=0.0)))
    steps = _vertices(rows, slips, equation.reshape(-1)[used], scale)
    twists = twist + steps[distinct(steps, SAME_VERTEX * scale)] @ to_twist.T
    value = dissipation(functional, model, loads, twist)
    allowed = SAME_VALUE * value + rounding_error(model, loads, twists)
    twists = twists[np.abs(dissipation(functional, model, loads, twists) - value) <= allowed]
    return twists if len(twists) > 1 else None


def row_frame(rows: Floats) -> tuple[Floats, Floats]:
    """Coordinates y in which the rows' columns are orthonormal: rows (2n, 3) there, and T with ``xi = T y``.

    Columns beyond the rank are zero: motions that no row sees are left out.
    """
    sizes = np.sqrt((rows**2).sum(axis=0))
    units = np.divide(1.0, sizes, out=np.zeros_like(sizes), where=sizes > 0)
    _, values, right = np.linalg.svd(rows * units, full_matrices=False)
    inverse = np.divide(1.0, values, out=np.zeros_like(values), where=values > RANK * values[0])
    to_twists = units[:, None] * right.T * inverse
    return np.asarray(rows @ to_twists), np.asarray(to_twists)


def _vertices(rows: Floats, slips: Floats, equation: Mask, scale: float) -> Floats:
    """Vertices x of ``rows x + slips = 0`` (equations), ``>= 0`` (others), among ``x`` in the span of the rows."""
    span = _span(rows)
    origin, *_ = np.linalg.lstsq(rows[equation], -slips[equation], rcond=DEPENDENT)
    free = _null_space(rows[equation] @ span)
    basis = span @ free
    count = basis.shape[1]
    if not count:
        return np.asarray(origin[None], float)
    normals, offsets = rows[~equation] @ basis, slips[~equation] + rows[~equation] @ origin
    corners = [
        np.linalg.solve(normals[list(chosen)], -offsets[list(chosen)])
        for chosen in combinations(range(len(normals)), count)
        if np.linalg.svd(normals[list(chosen)], compute_uv=False)[-1] > DEPENDENT
    ]
    inside = [x for x in corners if (normals @ x + offsets >= -INSIDE * scale).all()]
    return origin + np.reshape(inside, (-1, count)) @ basis.T


def _span(rows: Floats) -> Floats:
    """Orthonormal basis of the rows' span, as columns."""
    _, values, right = np.linalg.svd(rows)
    return right[: int((values > DEPENDENT).sum())].T


def _null_space(rows: Floats) -> Floats:
    """Orthonormal basis of the directions that the rows do not see, as columns."""
    _, values, right = np.linalg.svd(rows)
    return right[int((values > DEPENDENT).sum()) :].T


def distinct(points: Floats, tolerance: float) -> list[int]:
    """Indices of points (k, d) without repetitions."""
    kept: list[int] = []
    for k, point in enumerate(points):
        if all(np.abs(point - points[other]).max() > tolerance for other in kept):
            kept.append(k)
    return kept
