"""Equilibrium at rest under a rule without cells, exactly.

At the equilibrium (centred scene, c = 0) rest minimizes ``D = sum N_i f_i``, with the support functions f_i of the
friction sets (:mod:`nonsmooth.symbolic.friction_set`; rule ``ellipse``:
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
from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.proofs.clauses.at_point.linearization import Slip, slip_of
from nonsmooth.symbolic.constraints import (
    Row,
    Triple,
    cofactors,
    combine,
    gram,
    inner,
    roll_row,
    scaled,
    side_row,
    total,
)
from nonsmooth.symbolic.friction_set import BorderPiece, FrictionSet
from nonsmooth.symbolic.numbers.lazy import divided
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene, Wheel


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

    @property
    def is_admissible(self) -> bool:
        """Whether it lies in the set."""
        return self.squared <= 1 and abs(self.across) <= self.limits.cut

    @property
    def is_inside(self) -> bool:
        """Whether it lies inside, off the border."""
        return self.limits.holds_strictly(self.along, self.across)


@dataclass(frozen=True)
class RestBalance:
    """Force and moment of the slipping wheels at rest, and the stuck wheels' forces that answer it.

    Attributes:
        residual: ``sum N_i mu_R sgn(u_i) a_i`` over the wheels that slip at rest.
        stuck: forces of the wheels that stick; None where the least-norm forces leave an ellipse.
        rank: rank of the stuck wheels' rows.
        smooth: whether every loaded wheel slips at rest.
        open: whether the force of a wheel that slips is not determined: one that slips across its friction axis alone,
            under a set with a straight side.
    """

    residual: Triple
    stuck: tuple[StuckForce, ...] | None
    rank: int
    smooth: bool
    open: bool = False

    @property
    def holds(self) -> bool:
        """Whether rest is proved to be a minimizer."""
        if self.open:
            return False
        if self.smooth or not self.stuck:
            return not any(self.residual)
        return all(force.is_admissible for force in self.stuck)

    @property
    def strict(self) -> bool:
        """Whether rest is the only minimizer in a neighbourhood of the equilibrium."""
        return bool(self.stuck) and self.rank == 3 and all(force.is_inside for force in self.stuck or ())


def rest_balance(scene: Scene, region: LoadRegion) -> RestBalance:
    """Balance of forces at rest at the centred scene's equilibrium, which the load region holds."""
    rule = smooth_rule_of(scene)
    loaded = [(wheel, form) for wheel, form in zip(scene.wheels, region.forces, strict=True) if form[0]]
    slips = [slip_of(wheel, form, rule.friction_set(wheel.friction), scene.field.zero) for wheel, form in loaded]
    residual = total(scene.field.zero, (_pull(slip) for slip in slips if _slips_smoothly(slip)))
    rough = [(wheel, slip) for (wheel, _), slip in zip(loaded, slips, strict=True) if not _slips_smoothly(slip)]
    if any(slip.squared_size for _, slip in rough):
        return RestBalance(residual, None, 0, smooth=False, open=True)
    sticking = [(wheel, slip.force[0]) for wheel, slip in rough]
    columns = [
        (wheel.index, row.kind, scaled(row.unit_normal, force * friction))
        for wheel, force in sticking
        for row, friction in _sticking_rows(wheel, rule.friction_set(wheel.friction))
        if friction
    ]
    answer, rank = _least_norm([column for _, _, column in columns], residual)
    if answer is None:
        return RestBalance(residual, None if columns else (), rank, not sticking)
    by_wheel: dict[int, dict[str, Number]] = {}
    for (index, kind, _), value in zip(columns, answer, strict=True):
        by_wheel.setdefault(index, {})[kind] = value
    zero = scene.field.zero
    limits = {wheel.index: rule.friction_set(wheel.friction) for wheel, _ in sticking}
    stuck = tuple(StuckForce(i, parts.get("R", zero), parts.get("S", zero), limits[i]) for i, parts in by_wheel.items())
    return RestBalance(residual, stuck, rank, not sticking)


def _slips_smoothly(slip: Slip) -> bool:
    """Whether the wheel's term of D has a gradient at rest: it slips, and that costs."""
    return slip.piece is not BorderPiece.KINK


def _sticking_rows(wheel: Wheel, limits: FrictionSet) -> list[tuple[Row, Number]]:
    """Rows in which a wheel that sticks at rest may carry any admissible force, with half-axes."""
    rows = (roll_row(wheel), limits.along), (side_row(wheel), limits.across)
    return [(row, friction) for row, friction in rows if not row.rhs]


def _pull(slip: Slip) -> Triple:
    """The force of a wheel that slips, with its moment: ``N mu_R sgn(u) a`` where its friction axis is its rim."""
    if not slip.across:
        return scaled(slip.rows[0], -slip.force[0] * slip.limits.along * slip.along.sign())
    return scaled(slip.pull, -slip.force[0] / slip.size)


def _least_norm(columns: Sequence[Triple], target: Triple) -> tuple[list[Number] | None, int]:
    """Least-norm f with ``sum f_k columns_k = target`` and the rank of the columns; None where they have rank < 3."""
    if len(columns) < 3:
        return None, len(columns)
    rows = gram(columns)
    adjugate = cofactors(*rows)
    determinant = inner(rows[0], adjugate[0])
    if not determinant:
        return None, 2
    multiplier = scaled(combine(target, adjugate), divided(determinant.field.one, determinant))
    return [inner(column, multiplier) for column in columns], 3
