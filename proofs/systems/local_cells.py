"""The cells of a switched system at the origin: which ones count there, and where they are cones.

The Filippov set at a point is the hull of the limits of the fields of the cells whose *open* parts have points
arbitrarily near; a guard that merely vanishes at the point adds nothing
(:mod:`nonsmooth.proofs.inequalities.curved_regions`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import cone_region
from nonsmooth.analysis.cells.switched_cells import FieldCell, distinct
from nonsmooth.proofs.inequalities.curved_regions import Adherence, Extent, adherence, sectors
from nonsmooth.proofs.verdicts import Equilibrium
from nonsmooth.symbolic.plane import hull_holds_zero


def decide_equilibrium(cells: Sequence[FieldCell]) -> Equilibrium:
    """Whether 0 is in F at the origin; undecided where that hangs on a cell of which it is not known if it counts."""
    by_adherence = [(adherence(cell.region), cell) for cell in cells]
    sure = [cell for found, cell in by_adherence if found is Adherence.YES]
    possible = [cell for found, cell in by_adherence if found is not Adherence.NO]
    if hull_holds_zero(values_at_origin(sure)):
        return Equilibrium.HOLDS
    return Equilibrium.UNDECIDED if hull_holds_zero(values_at_origin(possible)) else Equilibrium.FAILS


def values_at_origin(cells: Iterable[FieldCell]) -> tuple[Point, ...]:
    """The distinct values of the fields of some cells at the origin."""
    values = []
    for cell in cells:
        for f, g in cell.velocities:
            zero = f.field.zero
            values.append((f.terms.get((0, 0), zero), g.terms.get((0, 0), zero)))
    return distinct(values)


def conic_germ(cells: Iterable[FieldCell]) -> tuple[FieldCell, ...] | None:
    """The cells near the origin as whole cones; None where a curved side ends at the origin, or may.

    Guards that are positive near the origin bound nothing there, and cells that have no points near it are left out.
    """
    cones: list[FieldCell] = []
    for cell in cells:
        for sector in sectors(cell.region):
            if sector.extent is Extent.WHOLE:
                cones.append(replace(cell, region=cone_region(sector.start, sector.end)))
            elif sector.extent is not Extent.NONE:
                return None
    return tuple(cones)
