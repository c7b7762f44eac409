"""Clause 1 where loads are unknown: whether the point is an equilibrium under every load."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.proofs.clauses.every_load.point import EveryLoad, EveryLoadPoint
from nonsmooth.proofs.verdicts import Equilibrium


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
