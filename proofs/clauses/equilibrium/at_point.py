"""Clause 1 under a rule without cells: whether the body rests (or spins) at the point."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation
from nonsmooth.proofs.clauses.every_load.point import EveryLoad, EveryLoadPoint
from nonsmooth.proofs.findings.verdicts import Equilibrium
from nonsmooth.symbolic.numbers.number_text import brief_text


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


# ---- loads that are unknown ----------------------------------------------------------------------


@dataclass(frozen=True)
class EveryLoadEquilibrium:
    """Clause 1: the same motion rests, or turns, at the point whatever the load; or a load drives the body away."""

    point: EveryLoadPoint

    @property
    def verdict(self) -> Equilibrium:
        """Holds where it holds under every load, fails where it fails under one."""
        return self.point.equilibrium

    @property
    def reason(self) -> str:
        """One sentence for people."""
        point = self.point
        plain = point.situation in (EveryLoad.OPEN, EveryLoad.MOVED)
        said = point.reason if plain else f"{point.situation}: {point.reason}"
        return f"{said} ({point.loads.remark})" if point.loads.remark else said
