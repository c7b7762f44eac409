"""The friction forces that a wheel can carry under a rule without cells: an ellipse, perhaps cut by a strip.

For a wheel with normal force N these are, along and across its rim ::

    N (alpha x, beta y)    with    x^2 + y^2 <= 1,    |y| <= kappa,    0 < kappa <= 1

With slips ``(r, s)`` and ``X = alpha |r|``, ``Y = beta |s|`` the power that they take is the support function ::

    D/N = sqrt(X^2 + Y^2)                        where (1 - kappa^2) Y^2 <= kappa^2 X^2     (on the arc)
    D/N = sqrt(1 - kappa^2) X + kappa Y          elsewhere                                  (at a corner)

It is continuously differentiable where ``r != 0``, twice where moreover the two pieces do not meet, and linear at a
corner.  ``kappa = 1`` is the whole ellipse: there are no corners.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

from nonsmooth.symbolic.numbers.number import Number


class BorderPiece(StrEnum):
    """Where on the border of the set the force of a slip lies."""

    ARC = "on the arc"
    CORNER = "at a corner"
    KINK = "not determined"  # no slip, or a slip across a straight side
    SEAM = "where arc and corner meet"


@dataclass(frozen=True)
class FrictionSet:
    """The set of one wheel per unit of normal force.

    Attributes:
        along: alpha, at least 0.
        across: beta, at least 0.
        cut: kappa, above 0 and at most 1.
    """

    along: Number
    across: Number
    cut: Number

    @property
    def is_cut(self) -> bool:
        """Whether the strip takes anything away."""
        return self.cut != 1 and bool(self.across)

    @cached_property
    def corner(self) -> Number:
        """``sqrt(1 - kappa^2)``: x at a corner."""
        return (1 - self.cut * self.cut).sqrt()

    def piece(self, r: Number, s: Number) -> BorderPiece:
        """Where the force of slips r along and s across lies."""
        x, y = self.along * r, self.across * s
        if not self.is_cut:
            return BorderPiece.ARC if x or y else BorderPiece.KINK
        if not x:
            return BorderPiece.KINK
        square = self.cut * self.cut
        excess = ((1 - square) * y * y - square * x * x).sign()
        return (BorderPiece.ARC, BorderPiece.SEAM, BorderPiece.CORNER)[excess + 1]

    def holds_strictly(self, x: Number, y: Number) -> bool:
        """Whether ``(alpha x, beta y)`` lies inside, off the border."""
        return x * x + y * y < 1 and -self.cut < y < self.cut
