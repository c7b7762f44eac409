"""Equilibrium at rest under a rule without cells, exactly.

At the equilibrium (centred scene, c = 0) rest minimizes ``D = sum N_i f_i``, with the support functions f_i of the
friction sets (:mod:`nonsmooth.symbolic.mechanics.friction_set`; rule ``ellipse``:
``f_i = sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``), iff ``0 in dD(0)``.  Where every loaded wheel slips at rest
(``u_i != 0``), D is smooth there and that is the balance ::

    sum_i N_i mu_R sgn(u_i) a_i = 0,      a_i = [d_i; d_i . J p_i],  b_i = [n_i; n_i . J p_i]

because a slip along the rim alone is on the arc of every set: under rule ``roller`` the rollers stand.  A wheel whose
friction axis is not its rim slips across the axis too; its force is that of its slip, wherever the set has one such
force.  Wheels that
stick at rest (``u_i = 0``) may carry any force in their set.  The least-norm forces that restore balance are tried:
inside the sets they prove equilibrium, strictly inside (with rows of rank three) they prove that rest is the only
minimizer in a neighbourhood.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.proofs.boxes.linearization import Slip, gradient, slips_at
from nonsmooth.symbolic.mechanics.constraints import Triple, cofactors, combine, gram, inner, scaled
from nonsmooth.symbolic.mechanics.friction_set import BorderPiece, FrictionSet
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.lazy import divided
from nonsmooth.symbolic.numbers.number import Number


@dataclass(frozen=True)
class StuckForce:
    """Force of a wheel that sticks at rest, in units of the half-axes of its friction set."""

    wheel: int
    along: Number
    across: Number
    limits: FrictionSet

    @property
    def squared(self) -> Number:
        """``|f|^2``; admissible up to one."""
        return self.along * self.along + self.across * self.across


@dataclass(frozen=True)
class RestBalance:
    """Force and moment of the slipping wheels at rest, and the stuck wheels' forces that answer it.

    Attributes:
        residual: ``-sum N_i pull_i`` over the wheels that slip at rest: with rims ``sum N_i mu_R sgn(u_i) a_i``.
        stuck: forces of the wheels that stick, of least norm; None where none are determined: their rows have a rank
            below three, or a wheel slips across its friction axis alone, under a set with a straight side.
    """

    residual: Triple
    stuck: tuple[StuckForce, ...] | None

    @property
    def strict(self) -> bool:
        """Whether rest is shown to be the only minimizer in a neighbourhood of the equilibrium."""
        return bool(self.stuck) and all(f.limits.holds_strictly(f.along, f.across) for f in self.stuck or ())


def rest_balance(scene: Scene, region: LoadRegion) -> RestBalance:
    """Balance of forces at rest at the centred scene's equilibrium, which the load region holds."""
    zero = scene.field.zero
    loaded = [slip for slip in slips_at(scene, region, zero) if slip.load[0]]
    rough = [slip for slip in loaded if slip.piece is BorderPiece.KINK]  # no gradient: no slip that costs
    residual = scaled(gradient(zero, (slip for slip in loaded if slip.piece is not BorderPiece.KINK)), -1)
    columns = [column for slip in rough for column in _stuck_rows(slip)]
    answer = _least_norm([column for _, _, column in columns], residual)
    if answer is None or any(slip.limits.across * slip.across for slip in rough):
        return RestBalance(residual, None)
    shares = {slip.wheel: [zero, zero] for slip in rough}
    for (wheel, axis, _), share in zip(columns, answer, strict=True):
        shares[wheel][axis] = share
    forces = []
    for slip in rough:
        along, across = shares[slip.wheel]
        forces.append(StuckForce(slip.wheel, along, across, slip.limits))
    return RestBalance(residual, tuple(forces))


def _stuck_rows(slip: Slip[Number]) -> list[tuple[int, int, Triple]]:
    """Number of a wheel that sticks, axis, and force with moment of a unit of its half-axis there, where it has one."""
    sizes = enumerate((slip.limits.along, slip.limits.across))
    return [(slip.wheel, axis, scaled(slip.rows[axis], slip.load[0] * size)) for axis, size in sizes if size]


def _least_norm(columns: Sequence[Triple], target: Triple) -> list[Number] | None:
    """Least-norm f with ``sum f_k columns_k = target``; None where the columns have a rank below three."""
    if len(columns) < 3:
        return None
    rows = gram(columns)
    adjugate = cofactors(*rows)
    determinant = inner(rows[0], adjugate[0])
    if not determinant:
        return None
    multiplier = scaled(combine(target, adjugate), divided(determinant.field.one, determinant))
    return [inner(column, multiplier) for column in columns]
