"""Clause 1 under a rule without cells: whether the body rests (or spins) at the point."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation
from nonsmooth.proofs.verdicts import Equilibrium
from nonsmooth.symbolic.number_text import brief_text


@dataclass(frozen=True)
class EllipseEquilibrium:
    """Clause 1: whether the body rests (or spins) at the point."""

    point: EllipsePoint

    @property
    def rounding_distance(self) -> Fraction | None:
        """How far the place of rest is from the point at most, where only rounding tells them apart; else None."""
        return None if self.point.rest is None else self.point.rest.distance

    @property
    def verdict(self) -> Equilibrium:
        """Holds where the translation part of the exact minimizer vanishes: there, or beside it within rounding."""
        return self.point.equilibrium

    @property
    def reason(self) -> str:
        """One sentence for people."""
        twist = self.point.twist
        if self.point.situation is Situation.OPEN and twist is not None:
            return f"the twist (0, 0, {brief_text(twist.omega)}) minimizes D"
        return self.point.summary
