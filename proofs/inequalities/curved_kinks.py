"""The derivative of V along a curve on which V bends: whether it is negative at every point but the equilibrium.

Let ``q = 0`` part the cells A (``q > 0``) and B, with one field each, and let q divide ``V_A - V_B``: V is continuous,
and ``grad V_A - grad V_B = h grad q`` on the curve.  With ``a = grad q . f_A`` and ``b = grad q . f_B`` a mixture of
the fields has one value against all gradients where ``h = 0``, which the closed cells decide, or where it is tangent:

- ``a b > 0``: no mixture is; ``a = 0``: f_A is, with ``grad V_A . f_A < 0`` on the closed cell; likewise f_B;
- ``a b < 0``: ``f_s = (b f_A - a f_B)/(b - a)`` alone, with the value ``w/(b - a)`` for
  ``w = b grad V_A . f_A - a grad V_A . f_B``.

So two inequalities decide: ``w < 0`` where ``q = 0, a <= 0 <= b``, and ``w > 0`` where ``q = 0, b <= 0 <= a``.  The
prover shows them on all points at which no guard is negative, thin sets included.  Where a further cell with another
field or another V meets the curve off the equilibrium nothing is claimed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from nonsmooth.analysis.cells.region import Region
from nonsmooth.analysis.cells.switched_cells import LyapunovCell
from nonsmooth.proofs.inequalities.forms import CellClaim, Leaf, Split, build_parts, subdivide
from nonsmooth.proofs.inequalities.prover import Proof, Sense, prove
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.surfaces import divides

EMPTINESS_WORK = 5_000  # coefficients looked at to find that a further cell does not meet the curve


@dataclass(frozen=True)
class CurvedKink:
    """Two cells on the two sides of a curve, with the same convex part of the plane around it.

    Attributes:
        first: the cell where the curve's polynomial is positive.
        second: the cell where it is negative.
        curve: the polynomial.
        around: the common part of the cells' regions, with the guards of both: the curve alone.
    """

    first: LyapunovCell
    second: LyapunovCell
    curve: Polynomial
    around: Region

    def falls(self, cells: Sequence[LyapunovCell]) -> bool:
        """Whether V is proved to be continuous and to fall along every solution on the curve but the equilibrium.

        Args:
            cells: all of them; on each closed one V is known to fall, or nothing follows.
        """
        if len(self.first.velocities) > 1 or len(self.second.velocities) > 1:
            return False
        continuous = divides(self.curve, self.first.potential - self.second.potential)
        return continuous is True and all(map(self._is_left_alone_by, cells)) and self._slides_down()

    def _is_left_alone_by(self, other: LyapunovCell) -> bool:
        """Whether a cell adds neither a field nor a gradient at any point of the curve but the equilibrium."""
        fields = (*self.first.velocities, *self.second.velocities)
        known = any(not other.potential - cell.potential for cell in (self.first, self.second))
        if known and all(velocity in fields for velocity in other.velocities):
            return True
        sides = tuple(_linear(side, self.curve) for side in other.region.sides)
        there = replace(self.around, guards=(*self.around.guards, *other.region.guards, *sides))
        return is_seen_empty(there, self.curve, EMPTINESS_WORK, except_origin=True)

    def _slides_down(self) -> bool:
        (f,), (g,) = self.first.velocities, self.second.velocities
        if f == g:
            return True
        slope = self.curve.derivative("x"), self.curve.derivative("y")
        gradient = self.first.gradient
        a, b = _product(slope, f), _product(slope, g)
        value = b * _product(gradient, f) - a * _product(gradient, g)
        for sense, opposed in ((Sense.NEGATIVE, (-a, b)), (Sense.POSITIVE, (a, -b))):
            sliding = replace(self.around, guards=(*self.around.guards, *opposed))
            if not isinstance(prove(sense, value, sliding, except_origin=True), Proof):
                return False
        return True


def _product(first: tuple[Polynomial, Polynomial], second: tuple[Polynomial, Polynomial]) -> Polynomial:
    return first[0] * second[0] + first[1] * second[1]


def _linear(side: tuple[object, object, object], like: Polynomial) -> Polynomial:
    """``a x + b y + c``."""
    x, y = (Polynomial.variable(like.field, like.variables, name) for name in like.variables)
    a, b, c = side
    return x * a + y * b + Polynomial.constant(like.field, like.variables, 1) * c


def is_seen_empty(region: Region, like: Polynomial, work: int, *, except_origin: bool) -> bool:
    """Whether ``-1 > 0`` is found to hold where no guard of a region is negative: there is no such point.

    Args:
        region: a cell.
        like: a polynomial in the same variables.
        work: coefficients that may be looked at.
        except_origin: whether the origin may be such a point.
    """
    minus_one = Polynomial.constant(like.field, like.variables, -1)
    parts = build_parts(CellClaim(minus_one, region, strict=True, except_origin=except_origin))
    return all(isinstance(subdivide(part, work), Leaf | Split) for part in parts)
