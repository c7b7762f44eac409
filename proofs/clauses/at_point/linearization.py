"""Spins and linearization under a rule without cells, exactly.

With D, ``a_i`` and ``b_i`` of :mod:`nonsmooth.proofs.clauses.at_point.balance`: arrays with torque may *spin* at the
equilibrium.  The twist ``(0, 0, omega)`` is a minimizer iff the gradient
``sum N_i (mu_R^2 r_i a_i + mu_S^2 s_i b_i)/f_i`` vanishes at it.

About such a smooth minimizer, to first order ``xi = (0, 0, omega) - H^-1 G c`` with ::

    H = sum N_i mu_R^2 mu_S^2/f_i^3 w_i w_i^T,   w_i = s_i a_i - r_i b_i,      G = d gradient/dc through N_i(c)

and ``c' = A c``, A the translation part of ``-H^-1 G`` plus ``omega J``: field operations on the scene's numbers, so
the eigenvalues are decided exactly.  (At rest H is ``sum N_i mu_S^2/(mu_R |u_i|) b_i b_i^T``.)

So it is where forces lie on the arcs of the friction sets, with ``alpha_i, beta_i`` for ``mu_R, mu_S``: under rule
``roller``, whose rollers stand at rest, with mu_R for both.  Where a force is at a corner (rollers turn) the
term of D is linear: it adds its force to the gradient and nothing to H.  Where arc and corner meet D has no second
derivative, so there is no linearization.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from flint import arb

from nonsmooth.analysis.cells.loads import Affine, LoadRegion
from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.symbolic.constraints import (
    Triple,
    added,
    cofactors,
    combine,
    cross_product,
    inner,
    roll_row,
    scaled,
    side_row,
    total,
)
from nonsmooth.symbolic.friction_set import BorderPiece, FrictionSet
from nonsmooth.symbolic.number_text import Real
from nonsmooth.symbolic.numbers.lazy import Lazy, divided
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene, Wheel


@dataclass(frozen=True)
class Linearization:
    """``xi = (0, 0, omega) + M c`` and ``c' = A c`` to first order at a smooth minimizer.

    Attributes:
        omega: rotation rate at the equilibrium.
        hessian: H (3 x 3).
        slope: the columns of G, one per coordinate of c.
        columns: the columns of ``M = -H^-1 G``: change of the twist per unit of x and of y.
    """

    omega: Number
    hessian: tuple[Triple, Triple, Triple]
    slope: tuple[Triple, Triple]
    columns: tuple[Triple, Triple]

    @property
    def translation(self) -> tuple[tuple[Number, Number], tuple[Number, Number]]:
        """A of ``c' = A c``, by rows."""
        x, y = self.columns
        return (x[0], y[0] - self.omega), (x[1] + self.omega, y[1])

    @property
    def trace(self) -> Number:
        """Sum of the eigenvalues of A."""
        (a, _), (_, d) = self.translation
        return a + d

    @property
    def determinant(self) -> Number:
        """Product of the eigenvalues of A."""
        (a, b), (c, d) = self.translation
        return a * d - b * c

    @property
    def spectral_abscissa(self) -> Real:
        """Largest real part of the eigenvalues of A; a ball where it is the root of a late quotient."""
        discriminant = self.trace * self.trace - 4 * self.determinant
        if discriminant.sign() <= 0:
            return self.trace / 2
        if isinstance(discriminant, Lazy):  # its root is no number of the scene's field
            return (self.trace.ball + _root_of_positive(discriminant.ball)) / 2
        return (self.trace + discriminant.sqrt()) / 2

    @property
    def is_positive_definite(self) -> bool:
        """Whether H is positive definite, so that the minimizer is unique and smooth in c (Sylvester)."""
        a, b, c = self.hessian
        return a[0].sign() > 0 and (a[0] * b[1] - a[1] * b[0]).sign() > 0 and inner(a, cross_product(b, c)).sign() > 0

    @property
    def rotation_map(self) -> tuple[Number, Number]:
        """The row m of ``theta_inf - theta_0 = m . c_0`` (where omega = 0 and A is regular): ``m A = -M_3``.

        So ``(m, 1)`` is orthogonal to both columns of ``M = -H^-1 G``, thus parallel to ``H (G_x x G_y)``.
        """
        normal = cross_product(*self.slope)
        x, y, z = (inner(row, normal) for row in self.hessian)
        return divided(x, z), divided(y, z)

    def check(self) -> bool:
        """Re-verify ``H M + G = 0``."""
        return all(
            inner(row, column) + slope[r] == 0
            for column, slope in zip(self.columns, self.slope, strict=True)
            for r, row in enumerate(self.hessian)
        )


@dataclass(frozen=True)
class Slip:
    """Slip of a loaded wheel under the twist ``(0, 0, omega)``.

    Attributes:
        force: its load as an affine form of c.
        along: ``r_i``.
        across: ``s_i``.
        rows: ``a_i`` and ``b_i``.
        limits: the friction set.
    """

    force: Affine
    along: Number
    across: Number
    rows: tuple[Triple, Triple]
    limits: FrictionSet

    @property
    def squares(self) -> tuple[Number, Number]:
        """``alpha^2`` and ``beta^2``."""
        return self.limits.along * self.limits.along, self.limits.across * self.limits.across

    @cached_property
    def piece(self) -> BorderPiece:
        """Where the force lies on the border of the set."""
        return self.limits.piece(self.along, self.across)

    @property
    def is_smooth(self) -> bool:
        """Whether the wheel's term of D has two derivatives here."""
        return self.piece in (BorderPiece.ARC, BorderPiece.CORNER)

    @property
    def squared_size(self) -> Number:
        """``f_i^2`` on the arc."""
        roll, side = self.squares
        return roll * self.along * self.along + side * self.across * self.across

    @cached_property
    def size(self) -> Number:
        """What :attr:`pull` is divided by: f on the arc, one at a corner."""
        return self.squared_size.sqrt() if self.piece is BorderPiece.ARC else self.along.field.one

    @cached_property
    def pull(self) -> Triple:
        """On the arc ``(alpha^2 r_i a_i + beta^2 s_i b_i)``, the gradient of ``f_i^2/2``; at a corner that of f."""
        a, b = self.rows
        if self.piece is BorderPiece.ARC:
            roll, side = self.squares
            return added(scaled(a, roll * self.along), scaled(b, side * self.across))
        x, y = self.limits.corner * self.along.sign(), self.limits.cut * self.across.sign()
        return added(scaled(a, self.limits.along * x), scaled(b, self.limits.across * y))


def slips_at(scene: Scene, region: LoadRegion, omega: Number) -> tuple[Slip, ...]:
    """Slips of the loaded wheels that have friction, under the twist ``(0, 0, omega)``."""
    rule, slips = smooth_rule_of(scene), []
    for wheel, form in zip(scene.wheels, region.forces, strict=True):
        limits = rule.friction_set(wheel.friction)
        if any(form) and (limits.along or limits.across):
            slips.append(slip_of(wheel, form, limits, omega))
    return tuple(slips)


def slip_of(wheel: Wheel, force: Affine, limits: FrictionSet, omega: Number) -> Slip:
    """The slip of one wheel under the twist ``(0, 0, omega)``."""
    a, b = roll_row(wheel).unit_normal, side_row(wheel).unit_normal
    along, across = wheel.slip_speeds
    return Slip(force, a[2] * omega - along, b[2] * omega - across, (a, b), limits)


def gradient(scene: Scene, slips: Iterable[Slip]) -> Triple:
    """Gradient of D at c = 0, where every loaded wheel's term is smooth."""
    return total(scene.field.zero, (scaled(s.pull, s.force[0] / s.size) for s in slips if s.force[0]))


def spin_candidates(scene: Scene, region: LoadRegion) -> tuple[Number, ...]:
    """Rates omega at which a wheel alone would have its least slip: the spin of arrays whose wheels are all alike.

    ``alpha^2 r a_3 + beta^2 s b_3 = 0`` gives ``omega = alpha^2 a_3 u/(alpha^2 a_3^2 + beta^2 b_3^2)``, on the arc;
    with a friction axis apart from the rim the surface has a speed across it too.
    """
    rates: dict[Number, None] = {}
    for slip in slips_at(scene, region, scene.field.zero):
        (a, b), (roll, side) = slip.rows, slip.squares
        stiffness = roll * a[2] * a[2] + side * b[2] * b[2]
        if stiffness:
            rates[-(roll * a[2] * slip.along + side * b[2] * slip.across) / stiffness] = None
    return tuple(rates)


def linearize(scene: Scene, region: LoadRegion, omega: Number) -> Linearization | None:
    """First-order twist about ``(0, 0, omega)``; None where D is not smooth there or H is singular."""
    slips = slips_at(scene, region, omega)
    if not all(slip.is_smooth for slip in slips):
        return None
    zero = scene.field.zero
    hessian = [[zero] * 3 for _ in range(3)]
    slopes = [(zero, zero, zero), (zero, zero, zero)]
    for slip in slips:
        if slip.piece is BorderPiece.ARC:
            _add_curvature(hessian, slip)
        slopes = [added(g, scaled(slip.pull, slip.force[1 + axis] / slip.size)) for axis, g in enumerate(slopes)]
    rows = [(row[0], row[1], row[2]) for row in hessian]
    columns = cofactors(rows[0], rows[1], rows[2])
    determinant = inner(rows[0], columns[0])
    if not determinant:
        return None
    scale = divided(-scene.field.one, determinant)
    x, y = (scaled(combine(slope, columns), scale) for slope in slopes)
    return Linearization(omega, (rows[0], rows[1], rows[2]), (slopes[0], slopes[1]), (x, y))


def _add_curvature(hessian: list[list[Number]], slip: Slip) -> None:
    """Add ``N alpha^2 beta^2/f^3 w w^T``."""
    (a, b), (roll, side) = slip.rows, slip.squares
    w = added(scaled(a, slip.across), scaled(b, -slip.along))
    factor = slip.force[0] * roll * side / (slip.size * slip.squared_size)
    for r in range(3):
        for s in range(3):
            hessian[r][s] = hessian[r][s] + factor * w[r] * w[s]


def _root_of_positive(ball: arb) -> arb:
    """A ball around the square root of a positive number; its own ball may hold zero where rounding told its sign."""
    return ball.sqrt() if ball > 0 else arb(0).union(ball.upper().sqrt())
