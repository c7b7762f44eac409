"""The power dissipation functional (Murphey & Burdick, Definition 1), its minimizers, and what proves them.

The functional has two readings.

With slips ``r_i`` along and ``s_i`` across the rim of wheel i, and normal forces ``N_i``:

- box: ``D(xi) = sum_i N_i (mu_R |r_i| + mu_S |s_i|)``, each direction limited on its own;
- ellipse: ``D(xi) = sum_i N_i sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``, the friction ellipse; where it is cut by a strip
  (rule ``roller``), the support function of :class:`nonsmooth.symbolic.mechanics.friction_set.FrictionSet`.

Both are convex in the twist.  Their subgradients are minus the friction forces ``f``, which lie in the box
``|f_R| <= mu_R N, |f_S| <= mu_S N`` or in the ellipse with these half-axes.  For balanced forces
(``sum_k f_k a_k = 0``) the power ``sum_k f_k b_k`` that the wheels put in is at most ``D(xi)`` for every twist:
equality makes the twist a minimizer and the forces its certificate.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import combinations
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.cells.contact_rule import CellRule, LimitedForces, Rule
from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.analysis.minimizers.sum_of_supports import quadratic_parts
from nonsmooth.symbolic.mechanics.contact_states import free_text, free_twists
from nonsmooth.symbolic.mechanics.friction_set import Box, CutEllipse
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, max_norm, squared_norms

ROUNDING = 1e-14  # of D and of its gap, relative to the sum of the absolute terms they are made of


class Functional(StrEnum):
    """How the friction of one wheel is limited."""

    BOX = "box"
    ELLIPSE = "ellipse"

    def unit_sets(self, model: ContactRows) -> CutEllipse[Any]:
        """The friction sets of wheels in units of their half-axes: boxes, or the sets of the contacts."""
        return Box.units(np.ones_like(model.cuts)) if self is Functional.BOX else model.shape.units(model.cuts)


def functional_of(rule: Rule) -> Functional | None:
    """What the motion under a rule minimizes: that of boxes where it is constant in cells; None where nothing is."""
    if not isinstance(rule, LimitedForces):
        return None
    return Functional.BOX if isinstance(rule, CellRule) else Functional.ELLIPSE


def dissipation(functional: Functional, model: ContactRows, loads: ArrayLike, twists: ArrayLike) -> Floats:
    """``D`` for loads (..., n) and twists (..., 3), broadcast against each other; power."""
    weighted = np.moveaxis(model.limits(loads) * model.slips(twists), -1, 0)
    return np.asarray(functional.unit_sets(model).support(*weighted).sum(axis=-1))


def input_power(model: ContactRows, forces: ArrayLike) -> Floats:
    """``sum_k f_k b_k`` for forces (..., n, 2): the dual value of balanced forces; power."""
    flat = np.asarray(forces, float)
    flat = flat.reshape(*flat.shape[:-2], len(model.rows))
    return np.asarray((flat * model.targets).sum(axis=-1))


def usage(functional: Functional, model: ContactRows, loads: ArrayLike, forces: ArrayLike) -> Floats:
    """Share of its limit that each wheel's friction uses, shape (..., n); admissible iff at most 1.

    The gauge of the friction set.  A force without a limit (0/0) uses nothing, one beyond a zero limit infinity.
    """
    shares = np.moveaxis(share_of_limit(model, loads, forces), -1, 0)
    return np.asarray(functional.unit_sets(model).gauge(*shares))


def share_of_limit(model: ContactRows, loads: ArrayLike, forces: ArrayLike) -> Floats:
    """``(f_R/(mu_R N), f_S/(mu_S N))`` of each wheel, shape (..., n, 2); 0/0 is 0."""
    limits = model.limits(loads)
    forces = np.broadcast_to(np.asarray(forces, float), np.broadcast_shapes(np.shape(forces), limits.shape))
    unlimited = np.where(forces == 0, 0.0, np.copysign(np.inf, forces))
    return np.divide(forces, limits, out=unlimited, where=limits > 0)


def rounding_error(model: ContactRows, loads: Floats, twists: Floats) -> Floats:
    """Size of rounding errors in D and in its gap, for loads (..., n) and twists (..., 3)."""
    terms = np.abs(twists) @ np.abs(model.rows).T + np.abs(model.targets)
    paired = terms.reshape(*terms.shape[:-1], model.wheels, 2)
    return np.asarray(ROUNDING * (model.limits(loads) * paired).sum(axis=(-2, -1)))


# ---- all minimizers at once ----------------------------------------------------------------------
#
# The face of twists on which the dissipation is minimal (Theorem 2).
#
# Every pair of a minimizer and optimal forces is complementary: a force strictly inside its limit means zero slip,
# a force at its limit means a slip against it.  So with any one optimal f the set of minimizers is a polyhedron in
# the space of twists (:meth:`nonsmooth.symbolic.mechanics.friction_set.CutEllipse.slip_cone`):
#
# - box: ``a_k . xi = b_k`` where ``|f_k| < mu N``, and ``-f_k (a_k . xi - b_k) >= 0`` where ``|f_k| = mu N``;
# - ellipse, slips weighted by the limits: zero where the force is inside the ellipse, else a non-negative multiple
#   of ``-f``; at a cut a slip across the rim alone, at a corner anything between these two.
#
# Almost everywhere the equations leave one twist; :func:`undetermined` finds the other points for many at once.
# There the vertices are found by intersecting as many boundaries as there are free unknowns (at most three): slow
# for dozens of wheels, but such points are rare.  It needs forces good to :data:`AT_LIMIT`; vertices that do not
# dissipate the minimum are dropped.


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
    products = quadratic_parts(row_frame(model.rows)[0].reshape(-1, 2, 3))  # (3, n, 6)
    shares = np.stack([mix[..., 0] ** 2, mix[..., 1] ** 2, mix[..., 0] * mix[..., 1]])  # (3, m, n, 2)
    squares = np.einsum("kmni,kn->mni", shares, products[..., [0, 3, 5]].sum(axis=-1))
    shares *= np.divide(equation, squares, out=np.zeros_like(squares), where=squares > 0)
    coefficients = shares.sum(axis=-1).transpose(1, 0, 2).reshape(len(loads), 3 * model.wheels)
    xx, xy, xz, yy, yz, zz = (coefficients @ products.reshape(-1, 6)).T
    determinant = xx * (yy * zz - yz**2) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    return np.asarray(determinant <= SUSPECT * ((xx + yy + zz) / 3) ** 3)


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
    sizes = np.sqrt(squared_norms(rows))
    used = ~idle.reshape(-1) & (sizes > 0)
    rows, slips = rows[used] / sizes[used, None], slips[used] / sizes[used]
    scale = max(max_norm(model.targets), max_norm(slips))
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
        if all(max_norm(point - points[other]) > tolerance for other in kept):
            kept.append(k)
    return kept


# ---- friction forces that balance exactly and stay inside their limits ---------------------------
#
# What makes a dual value a proof.
#
# A solver's multipliers balance only to its tolerance.  The repair moves them by the least change, measured in units of
# the room that each force has left (a force at its limit may turn but not grow), so that ``sum_k f_k a_k = 0`` to
# rounding; then all are scaled down together by the largest excess over a limit.  The result is admissible, so that
# ``sum_k f_k b_k`` is a lower bound of D, whatever the solver did.


BALANCED = 1e-14  # relative imbalance that is rounding: nothing to repair
NEGLIGIBLE = 1e-40  # share of a limit that is zero: a force so small balances nothing
TURNING = 1e-2  # room of a force at its ellipse to turn: the forces of sticking wheels move first
PASSES = 3  # each pass repairs all but the rounding of the one before


def imbalance(model: ContactRows, forces: Floats) -> Floats:
    """Largest entry of ``sum_k f_k a_k`` relative to ``sum_k |f_k|`` times the column's largest entry.

    Force and moment are measured alike; forces (..., n, 2), result (...).
    """
    flat = forces.reshape(*forces.shape[:-2], len(model.rows))
    scale = np.abs(flat).sum(axis=-1)[..., None] * np.abs(model.rows).max(axis=0)
    total = np.abs(flat @ model.rows)
    return np.asarray(np.divide(total, scale, out=np.zeros_like(total), where=scale > 0).max(axis=-1))


def leaking_power(model: ContactRows, forces: Floats, twists: Floats) -> Floats:
    """Power of what is left unbalanced, ``|sum_k f_k a_k|``, in a motion as fast as the twist and the surfaces.

    The lower bound ``sum_k f_k b_k`` of D is off by no more; forces (m, n, 2), twists (m, 3), result (m,).
    """
    total = np.abs(forces.reshape(*forces.shape[:-2], len(model.rows)) @ model.rows)
    columns = np.abs(model.rows).max(axis=0)
    speeds = np.abs(model.targets).max(axis=-1, keepdims=True) / np.where(columns > 0, columns, 1.0)
    return np.asarray((total * (np.abs(twists) + speeds)).sum(axis=-1))


def balance_forces(functional: Functional, model: ContactRows, loads: Floats, forces: Floats) -> Floats:
    """Admissible, balanced forces (m, n, 2) next to the given ones, for loads (m, n)."""
    shares = share_of_limit(model, loads, forces)
    shares = np.where(np.isfinite(shares), shares, 0.0)
    limits, sets = model.limits(loads), functional.unit_sets(model)
    for _ in range(PASSES):
        unbalanced = np.flatnonzero(imbalance(model, shares * limits) > BALANCED)
        if not len(unbalanced):
            break
        for k in unbalanced:
            along, across = shares[k].T
            shares[k] = _repaired(sets.room(along, across, TURNING), limits[k], model.rows, shares[k])
    shares = np.where(np.abs(shares) > NEGLIGIBLE, shares, 0.0)
    excess = sets.gauge(*np.moveaxis(shares, -1, 0)).max(axis=-1)
    return shares * limits / np.maximum(1.0, excess)[:, None, None]


def _repaired(room: Floats, limits: Floats, rows: Floats, shares: Floats) -> Floats:
    """Shares (n, 2) moved by ``-room u`` with the smallest u that balances the forces."""
    sizes = np.abs(rows).max(axis=0)
    weighted = limits.reshape(-1, 1) * rows / np.where(sizes > 0, sizes, 1.0)
    movable = (room @ weighted.reshape(-1, 2, 3)).reshape(-1, 3)
    step, *_ = np.linalg.lstsq(movable.T, shares.reshape(-1) @ weighted)
    return shares - (room @ step.reshape(-1, 2, 1))[..., 0]


# ---- minimizers with the forces that prove them --------------------------------------------------
#
# A :class:`Minima` holds many results at once.  Nothing a solver says about its own quality is stored: admissibility,
# balance and gap are computed here from twist and forces alone.


GAP = 1e-9  # largest duality gap of a certified minimum, relative to its value
IMBALANCE = 1e-11  # largest relative imbalance of forces and moments: rounding of sums over hundreds of wheels
EXCESS = 1e-12  # largest relative excess over a friction limit: rounding of one quotient


@dataclass(frozen=True, eq=False)
class Minima:
    """Minimizers of D at m points.

    Attributes:
        functional: box or ellipse.
        model: the contact rows.
        loads: normal forces, shape (m, n).
        twists: minimizing twists ``xi``, shape (m, 3).
        forces: friction forces on the body along and across the rims, shape (m, n, 2).
        faces: by point, the vertices (k, 3) of the set of all minimizers, where it is more than one twist
            (Theorem 2: all convex combinations have the same D).
    """

    functional: Functional
    model: ContactRows
    loads: Floats
    twists: Floats
    forces: Floats
    faces: dict[int, Floats] = field(default_factory=dict)

    @classmethod
    def certified(
        cls, functional: Functional, model: ContactRows, loads: Floats, twists: Floats, multipliers: Floats
    ) -> Minima:
        """Complete a solver's answer: multipliers become balanced, admissible forces, and faces are found."""
        forces = balance_forces(functional, model, loads, multipliers)
        faces = {}
        for k in np.flatnonzero(undetermined(functional, model, loads, forces)).tolist():
            face = optimal_face(functional, model.at_point(k), loads[k], twists[k], forces[k])
            if face is not None:
                faces[k] = face
        return cls(functional, model, loads, twists, forces, faces)

    def __len__(self) -> int:
        return len(self.twists)

    def __getitem__(self, k: int) -> Minima:
        k = range(len(self))[k]
        part, faces = slice(k, k + 1), {0: self.faces[k]} if k in self.faces else {}
        model = self.model.at_point(k)
        return Minima(self.functional, model, self.loads[part], self.twists[part], self.forces[part], faces)

    def __iter__(self) -> Iterator[Minima]:
        return (self[k] for k in range(len(self)))

    @property
    def values(self) -> Floats:
        """``D(xi)``, shape (m,)."""
        return dissipation(self.functional, self.model, self.loads, self.twists)

    @property
    def gaps(self) -> Floats:
        """``D(xi) - sum_k f_k b_k``, shape (m,): no twist dissipates less than ``values - gaps``."""
        return self.values - input_power(self.model, self.forces)

    def check(self, gap: float = GAP) -> Mask:
        """Verify every point from twists and forces alone, shape (m,).

        Forces inside their limits, forces and moments in balance, and no gap between dissipated and input power:
        together they prove optimality.  What imbalance rounding leaves counts by its power, so that large forces which
        nearly cancel prove nothing about small dissipation.  All vertices of a face dissipate as much.
        """
        shares = usage(self.functional, self.model, self.loads, self.forces)
        allowed = gap * self.values + rounding_error(self.model, self.loads, self.twists)
        admissible = (shares <= 1 + EXCESS).all(axis=-1)
        balanced = imbalance(self.model, self.forces) <= IMBALANCE
        proven = np.maximum(np.abs(self.gaps), leaking_power(self.model, self.forces, self.twists)) <= allowed
        found = np.asarray(admissible & balanced & proven)
        for k, face in self.faces.items():
            found[k] &= self[k]._is_face(face)
        return found

    def _is_face(self, face: Floats) -> bool:
        """Whether several twists (k, 3) dissipate as much as the only one."""
        apart = np.abs(dissipation(self.functional, self.model, self.loads, face) - self.values)
        allowed = SAME_VALUE * self.values + rounding_error(self.model, self.loads, face)
        return len(face) > 1 and bool((apart <= allowed).all())


# ---- which answers of a minimizer are proved to be the motion ------------------------------------
#
# And how to say in words that some are not.
#
# A float minimizer proves its answer by forces (:meth:`nonsmooth.analysis.minimizers.minimum.Minima.check`).  That the
# answer is the motion takes more: the loaded rows with friction must be of rank three, else D is constant along a
# motion and its minimizers are a whole line.  What is not proved is never shown as a number.


UNRESISTED = 1e-9  # singular value, relative to the largest, of rows that leave a motion free


def proved(minima: Minima) -> Mask:
    """Points (m,) at which all minimizers are known: twist and face proved, and every motion resisted."""
    return minima.check() & resists_every_motion(minima.model, minima.loads)


def resists_every_motion(model: ContactRows, loads: Floats) -> Mask:
    """Whether the loaded rows with friction are of rank three, at loads (m, n); shape (m,)."""
    limited = (model.limits(loads) > 0).reshape(len(loads), -1)
    _, first, which = np.unique(np.packbits(limited, axis=1), axis=0, return_index=True, return_inverse=True)
    sizes = np.abs(model.rows).max(axis=0)
    units = model.rows / np.where(sizes > 0, sizes, 1.0)
    full = [
        np.linalg.matrix_rank(units[rows], rtol=UNRESISTED) == 3 if rows.any() else False for rows in limited[first]
    ]
    return np.array(full, dtype=bool)[which.reshape(-1)]


def may_jump(model: ContactRows) -> bool:
    """Whether the motion may jump as loads change, because D is linear in pieces somewhere.

    There a friction set has corners, or one motion is along all that is driven.
    Wheels with parallel rims have such a motion, the translation along them: while all slip, D has no curvature along
    it.  Its least value is where one of them does not, and jumps to where another one does not as loads change.
    Where one twist drives all contacts without slip, it is the motion at all loads.
    """
    if (model.cuts < 1).any():
        return True
    rows, goals = model.friction[:, None] * model.rows, model.friction * model.targets
    rows = rows / (np.abs(rows).max(axis=0) + np.finfo(float).tiny)
    pairs, wanted = rows.reshape(-1, 2, 3), goals.reshape(-1, 2)
    across = wanted[:, :1] * pairs[:, 1] - wanted[:, 1:] * pairs[:, 0]
    if not wanted.any() or np.linalg.matrix_rank(across, rtol=UNRESISTED) == 3:
        return False
    together = np.linalg.lstsq(rows, goals)[0]
    return max_norm(rows @ together - goals) > UNRESISTED * max_norm(goals)


def minima_without_proof(found: Mask) -> str:
    """In words, how many of so many minima are not proved; empty where all are."""
    missing = int(np.count_nonzero(~found))
    return f"{missing} of {len(found)} minima without proof" if missing else ""


def free_motions(scene: Scene) -> str:
    """In words, the motions that no row with friction resists; empty where there are none."""
    return free_text(free_twists(scene))


# ---- minimizers behind one interface -------------------------------------------------------------
#
# ====================  ==========  =====================================================================
# name                  functional  use
# ====================  ==========  =====================================================================
# ``EllipseMinimizer``  ellipse     all points at once in NumPy, to rounding: the one to use
# ``BoxHighs``          box         dual linear program by HiGHS, point by point: the one to use in floats
# ``BoxEnumeration``    box         every regular triple of rows, the literal definition: small arrays
# ====================  ==========  =====================================================================


class Minimizer(Protocol):
    """Anything that minimizes one of the two functionals."""

    @property
    def functional(self) -> Functional:
        """What it minimizes."""

    def minimize(self, model: ContactRows, loads: ArrayLike) -> Minima:
        """Minimizers of D for the contact rows under normal forces (m, n), one for each row of loads.

        Raises:
            ValueError: for loads of another shape, negative, or not finite.
        """
