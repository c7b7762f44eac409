"""Minimizers of the dissipation with the forces that prove them, and which of them are proved to be the motion.

A :class:`Minima` holds many results at once, a :class:`Minimum` one of them.  Nothing a solver says about its own
quality is stored: admissibility, balance and gap are computed here from twist and forces alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.analysis.minimizers.dissipation import (
    Functional,
    dissipation,
    input_power,
    rounding_error,
    share_of_limit,
    usage,
)
from nonsmooth.analysis.minimizers.optimal_face import SAME_VALUE, optimal_face, undetermined
from nonsmooth.symbolic.mechanics.free_rollers import free_text, free_twists
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask

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
        for k in np.flatnonzero(imbalance(model, shares * limits) > BALANCED):
            along, across = shares[k].T
            shares[k] = _repaired(sets.room(along, across, TURNING), limits[k], model.rows, shares[k])
    shares = np.where(np.abs(shares) > NEGLIGIBLE, shares, 0.0)
    excess = usage(functional, model, loads, shares * limits).max(axis=-1)
    return np.asarray(shares * limits / np.maximum(1.0, excess)[:, None, None])


def _repaired(room: Floats, limits: Floats, rows: Floats, shares: Floats) -> Floats:
    """Shares (n, 2) moved by ``-room u`` with the smallest u that balances the forces."""
    sizes = np.abs(rows).max(axis=0)
    weighted = limits.reshape(-1, 1) * rows / np.where(sizes > 0, sizes, 1.0)
    movable = (room @ weighted.reshape(-1, 2, 3)).reshape(-1, 3)
    step, *_ = np.linalg.lstsq(movable.T, shares.reshape(-1) @ weighted)
    return np.asarray(shares - (room @ step.reshape(-1, 2, 1))[..., 0])


# ---- minima --------------------------------------------------------------------------------------


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

    def __getitem__(self, k: int) -> Minimum:
        k = range(len(self))[k]
        model, face = self.model.at_point(k), self.faces.get(k)
        return Minimum(self.functional, model, self.loads[k], self.twists[k], self.forces[k], face)

    def __iter__(self) -> Iterator[Minimum]:
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
        nearly cancel prove nothing about small dissipation.
        """
        shares = usage(self.functional, self.model, self.loads, self.forces)
        allowed = gap * self.values + rounding_error(self.model, self.loads, self.twists)
        admissible = (shares <= 1 + EXCESS).all(axis=-1)
        balanced = imbalance(self.model, self.forces) <= IMBALANCE
        proven = np.maximum(np.abs(self.gaps), leaking_power(self.model, self.forces, self.twists)) <= allowed
        return np.asarray(admissible & balanced & proven)


@dataclass(frozen=True, eq=False)
class Minimum:
    """One minimizer of D: the fields of :class:`Minima` without their first axis; ``face`` None if unique."""

    functional: Functional
    model: ContactRows
    loads: Floats
    twist: Floats
    forces: Floats
    face: Floats | None = None

    @property
    def value(self) -> float:
        """``D(xi)``."""
        return float(dissipation(self.functional, self.model, self.loads, self.twist))

    @property
    def gap(self) -> float:
        """``D(xi) - sum_k f_k b_k``: no twist dissipates less than ``value - gap``."""
        return self.value - float(input_power(self.model, self.forces))

    def check(self, gap: float = GAP) -> bool:
        """:meth:`Minima.check`, and equal dissipation at all vertices of the face."""
        alone = Minima(self.functional, self.model, self.loads[None], self.twist[None], self.forces[None])
        return bool(alone.check(gap)[0]) and (self.face is None or self._is_face(self.face))

    def _is_face(self, face: Floats) -> bool:
        values = dissipation(self.functional, self.model, self.loads, face)
        allowed = SAME_VALUE * self.value + rounding_error(self.model, self.loads, face)
        return len(face) > 1 and bool((np.abs(values - self.value) <= allowed).all())


# ---- which answers of a minimizer are proved to be the motion ------------------------------------
#
# And how to say in words that some are not.
#
# A float minimizer proves its answer by forces (:meth:`nonsmooth.analysis.minimizers.minimum.Minima.check`).  That the
# answer is the motion takes more: the loaded rows with friction must be of rank three, else D is constant along a
# motion and its minimizers are a whole line.  What is not proved is never shown as a number.


DEPENDENT = 1e-9  # singular value, relative to the largest, of rows that leave a motion free


def proved(minima: Minima) -> Mask:
    """Points (m,) at which all minimizers are known: twist and face proved, and every motion resisted."""
    found = minima.check() & resists_every_motion(minima.model, minima.loads)
    for k in minima.faces:
        found[k] &= minima[k].check()
    return found


def resists_every_motion(model: ContactRows, loads: Floats) -> Mask:
    """Whether the loaded rows with friction are of rank three, at loads (m, n); shape (m,)."""
    limited = (model.limits(loads) > 0).reshape(len(loads), -1)
    _, first, which = np.unique(np.packbits(limited, axis=1), axis=0, return_index=True, return_inverse=True)
    sizes = np.abs(model.rows).max(axis=0)
    units = model.rows / np.where(sizes > 0, sizes, 1.0)
    full = [np.linalg.matrix_rank(units[rows], rtol=DEPENDENT) == 3 if rows.any() else False for rows in limited[first]]
    return np.array(full, dtype=bool)[which.reshape(-1)]


def minima_without_proof(found: Mask) -> str:
    """In words, how many of so many minima are not proved; empty where all are."""
    missing = int(np.count_nonzero(~found))
    return f"{missing} of {len(found)} minima without proof" if missing else ""


def free_motions(scene: Scene) -> str:
    """In words, the motions that no row with friction resists; empty where there are none."""
    return free_text(free_twists(scene))
