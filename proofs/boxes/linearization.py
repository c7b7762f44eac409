"""Spins and linearization under a rule without cells, exactly.

With D, ``a_i`` and ``b_i`` of :mod:`nonsmooth.proofs.clauses.at_point.ellipse`: arrays with torque may *spin* at the
equilibrium.  The twist ``(0, 0, omega)`` is a minimizer iff the gradient ``sum N_i pull_i`` of D vanishes at it ::

    pull_i = (df_i/dr) a_i + (df_i/ds) b_i,             on an ellipse (mu_R^2 r_i a_i + mu_S^2 s_i b_i)/f_i

About such a smooth minimizer, to first order ``xi = (0, 0, omega) - H^-1 G c`` with ::

    H = sum N_i bend_i w_i w_i^T,   w_i = s_i a_i - r_i b_i,      on an ellipse bend_i = mu_R^2 mu_S^2/f_i^3
    G = sum pull_i dN_i/dc

and ``c' = A c``, A the translation part of ``-H^-1 G`` plus ``omega J``: field operations on the scene's numbers, so
the eigenvalues are decided exactly.  (At rest H is ``sum N_i mu_S^2/(mu_R |u_i|) b_i b_i^T``.)

So it is where forces lie on the arcs of the friction sets, with ``alpha_i, beta_i`` for ``mu_R, mu_S``: under rule
``roller``, whose rollers stand at rest, with mu_R for both.  Where a force is at a corner (rollers turn) the
term of D is linear: it adds its force to the gradient and nothing to H.  Where arc and corner meet D has no second
derivative, so there is no linearization.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Generic, TypeAlias

from flint import arb

from nonsmooth.analysis.cells.contact_rule import SmoothRule, smooth_rule_of
from nonsmooth.analysis.cells.loads import Affine, LoadRegion
from nonsmooth.symbolic.mechanics.contact_states import (
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
from nonsmooth.symbolic.mechanics.friction_set import BorderPiece, CutEllipse
from nonsmooth.symbolic.mechanics.load_model import Three, X
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.numbers.lazy import Lazy, divided
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import Real
from nonsmooth.symbolic.numbers.plane import Vector

Slope: TypeAlias = tuple[Triple, Triple]  # two columns, one per coordinate of c


@dataclass(frozen=True)
class Slip(Generic[X]):
    """A wheel under a twist, and what it adds to D per unit of its load.

    Attributes:
        wheel: its number.
        position: from the checked point.
        load: its load as an affine form of c.
        rows: ``a_i`` and ``b_i``.
        along: ``r_i``.
        across: ``s_i``.
        limits: the friction set.
    """

    wheel: int
    position: Vector
    load: Three[X]
    rows: tuple[Three[X], Three[X]]
    along: X
    across: X
    limits: CutEllipse[X]

    def moved(self, twist: Sequence[X]) -> Slip[X]:
        """The same wheel under a twist that is added."""
        a, b = (inner(row, twist) for row in self.rows)
        return replace(self, along=self.along + a, across=self.across + b)

    def map(self, number: Callable[[X], Any]) -> Slip[Any]:
        """The same in another arithmetic."""
        load, *rows = (tuple(number(x) for x in triple) for triple in (self.load, *self.rows))
        speeds = number(self.along), number(self.across)
        return Slip(self.wheel, self.position, load, (rows[0], rows[1]), *speeds, self.limits.map(number))

    @cached_property
    def piece(self) -> BorderPiece:
        """Where the force lies on the border of the set."""
        return self.limits.piece(self.along, self.across)

    @property
    def is_smooth(self) -> bool:
        """Whether the wheel's term of D has two derivatives here."""
        return self.piece in (BorderPiece.ARC, BorderPiece.CORNER)

    @cached_property
    def pull(self) -> Three[X]:
        """The gradient of f; raises as that of the friction set."""
        (a, b), (along, across) = self.rows, self.limits.gradient(self.along, self.across)
        return added(scaled(a, along), scaled(b, across))

    @cached_property
    def bend(self) -> X:
        """The factor of ``w w^T`` in the Hessian of f: zero at a corner of the set."""
        return self.limits.bend(self.along, self.across)

    @cached_property
    def w(self) -> Three[X]:
        """``s_i a_i - r_i b_i``."""
        a, b = self.rows
        return added(scaled(a, self.across), scaled(b, -self.along))


def slips_at(scene: Scene, region: LoadRegion, omega: Number) -> tuple[Slip[Number], ...]:
    """Slips of the loaded wheels that have friction, under the twist ``(0, 0, omega)``."""
    zero = scene.field.zero
    pressed = [(wheel, load) for wheel, load in zip(scene.wheels, region.forces, strict=True) if any(load)]
    slips = [slip_at_rest(wheel, load, smooth_rule_of(scene)) for wheel, load in pressed]
    return tuple(slip.moved((zero, zero, omega)) for slip in slips if slip.limits.along or slip.limits.across)


def slip_at_rest(wheel: Wheel, load: Affine, rule: SmoothRule) -> Slip[Number]:
    """The slip of one wheel under a body that rests."""
    rows = roll_row(wheel).unit_normal, side_row(wheel).unit_normal
    along, across = wheel.slip_speeds
    return Slip(wheel.index, wheel.position, load, rows, -along, -across, rule.friction_set(wheel.friction))


def gradient(zero: X, slips: Iterable[Slip[X]], part: int = 0) -> Three[X]:
    """``sum N_i pull_i``: of D at c = 0, or (parts 1 and 2) how it changes along x and y."""
    return total(zero, (scaled(slip.pull, slip.load[part]) for slip in slips if slip.load[part]))


def hessian(zero: Number, slips: Iterable[Slip[Number]], loads: Iterable[Number]) -> tuple[Triple, Triple, Triple]:
    """``sum N_i bend_i w_i w_i^T``, by its rows."""
    weights = [(slip.w, load * slip.bend) for slip, load in zip(slips, loads, strict=True) if load]
    first, second, third = (total(zero, (scaled(w, weight * w[r]) for w, weight in weights)) for r in range(3))
    return first, second, third


def spin_candidates(scene: Scene, region: LoadRegion) -> tuple[Number, ...]:
    """Rates omega at which a wheel alone would have its least slip: the spin of arrays whose wheels are all alike.

    ``alpha^2 r a_3 + beta^2 s b_3 = 0`` gives ``omega = alpha^2 a_3 u/(alpha^2 a_3^2 + beta^2 b_3^2)``, on the arc;
    with a friction axis apart from the rim the surface has a speed across it too.  Rest is the first.
    """
    rates: dict[Number, None] = {scene.field.zero: None}
    for slip in slips_at(scene, region, scene.field.zero):
        (a, b), roll, side = slip.rows, slip.limits.along**2, slip.limits.across**2
        stiffness = roll * a[2] * a[2] + side * b[2] * b[2]
        if stiffness:
            rates[-(roll * a[2] * slip.along + side * b[2] * slip.across) / stiffness] = None
    return tuple(rates)


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
    slope: Slope
    columns: Slope

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
    def rotation_map(self) -> tuple[Number, Number]:
        """The row m of ``theta_inf - theta_0 = m . c_0`` (where omega = 0 and A is regular): ``m A = -M_3``.

        So ``(m, 1)`` is orthogonal to both columns of ``M = -H^-1 G``, thus parallel to ``H (G_x x G_y)``.
        """
        normal = cross_product(*self.slope)
        x, y, z = (inner(row, normal) for row in self.hessian)
        return divided(x, z), divided(y, z)


def linearize(scene: Scene, region: LoadRegion, omega: Number) -> Linearization | None:
    """First-order twist about ``(0, 0, omega)``; None where D is not smooth there or H is singular."""
    slips, zero = slips_at(scene, region, omega), scene.field.zero
    if not all(slip.is_smooth for slip in slips):
        return None
    rows = hessian(zero, slips, [slip.load[0] for slip in slips])
    slope = gradient(zero, slips, 1), gradient(zero, slips, 2)
    columns = cofactors(*rows)
    determinant = inner(rows[0], columns[0])
    if not determinant:
        return None
    scale = divided(-scene.field.one, determinant)
    x, y = (scaled(combine(column, columns), scale) for column in slope)
    return Linearization(omega, rows, slope, (x, y))


def inward_pull(slope: Slope) -> Number | None:
    """``beta > 0`` where ``G c = (beta c, 0)``; None for any other G."""
    (a, b, m), (c, d, n) = slope
    return a if a == d and a.sign() > 0 and not (b or c or m or n) else None


def _root_of_positive(ball: arb) -> arb:
    """A ball around the square root of a positive number; its own ball may hold zero where rounding told its sign."""
    return ball.sqrt() if ball > 0 else arb(0).union(ball.upper().sqrt())
