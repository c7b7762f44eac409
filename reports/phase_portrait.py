"""The phase portrait of a plain system in two states: its cells, what happens on their borders, and a picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import FieldCell, square_regions, system_cells
from nonsmooth.analysis.fields.stated_field import StatedField, stated_fields
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.border_motion import BorderPart, border_parts, wave_border_parts
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.document import Block, Paragraph, table
from nonsmooth.reports.exact_record import with_exact
from nonsmooth.reports.result import DataTable, Record, Result
from nonsmooth.symbolic.number_text import place_text
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem, require_one_field, require_plane

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SCHEMA = "nonsmooth-phase-portrait/1"


@dataclass(frozen=True, repr=False)
class PhasePortrait(Result):
    """Cells and borders of the checked square, in the displacement from the checked point.

    Attributes:
        system: in two states.

    Raises:
        SceneError: for another number of states, and for arbitrary switching.
    """

    system: SwitchedSystem

    def __post_init__(self) -> None:
        require_plane(self.system)
        require_one_field(self.system)

    @cached_property
    def cells(self) -> tuple[FieldCell, ...]:
        """The cells, cut along the axes through the point too."""
        return system_cells(self.system, square_regions(self.system.check.radius))

    @cached_property
    def fields(self) -> tuple[StatedField, ...]:
        """The field of each cell."""
        return stated_fields(self.system, self.cells)

    @cached_property
    def borders(self) -> tuple[BorderPart, ...]:
        """Parts of the straight borders across which the field changes."""
        if self.system.names:
            return tuple(wave_border_parts(self.cells, self.fields))
        return tuple(border_parts(self.cells))

    @cached_property
    def stability(self) -> StabilityResult:
        """The verdict on the checked point."""
        return verified(decide_system(self.system))

    def facts(self) -> Record:
        """The JSON record."""
        head = {"schema": SCHEMA, "scene": self.system.name, "states": list(self.system.states)}
        at = with_exact({"at": self.system.check.equilibrium, "radius": self.system.check.radius})
        cells = [self._cell_record(*pair) for pair in zip(self.cells, self.fields, strict=True)]
        return {**head, **at, "cells": cells, "borders": [_border_record(part) for part in self.borders]}

    def _cell_record(self, cell: FieldCell, field: StatedField) -> dict[str, Any]:
        named = with_exact({"polygon": _corners(cell)})
        guards = [self._text(guard) for guard in cell.region.guards]
        return {**named, "guards": guards, "field": field.texts(self.system.states)}

    def _text(self, polynomial: Any) -> str:
        return str(replace(polynomial, variables=self.system.states))

    def table(self) -> DataTable:
        """One line for each cell: its corners and guards, and its field."""
        states, lines = self.system.states, []
        for cell, field in zip(self.cells, self.fields, strict=True):
            where = ", ".join(place_text(corner, 4) for corner in _corners(cell))
            guards = "".join(f"; {self._text(g)} > 0" for g in cell.region.guards)
            lines.append((where + guards, *field.texts(states)))
        return DataTable(("corners", *(f"{name}'" for name in states)), lines)

    def blocks(self) -> Sequence[Block]:
        """Cells with their fields, and borders with what solutions do there."""
        names, lines = self.table()
        states = ", ".join(self.system.states)
        head = f"{one_line(self.system.name)}: plain switched system in {states}, measured from the point"
        blocks: list[Block] = [Paragraph((head,)), table(names, lines, (1.0,) * len(names))]
        rows = [(place_text(part.start, 4), place_text(part.end, 4), str(part.kind)) for part in self.borders]
        return [*blocks, table(("from", "to", "solutions"), rows, (1.0,) * 3)] if rows else blocks

    def summary(self) -> str:
        """How many cells, and the verdict on the checked point."""
        return f"{len(self.cells)} cells, {self.stability.verdict}"

    def draw(self, ax: Axes) -> None:
        """Field lines, nullclines, borders, and the V that proves stability with its region."""
        from nonsmooth.reports.figures.phase_portrait import draw_portrait

        draw_portrait(ax, self)

    def figure(self) -> Figure:
        """The same with a legend."""
        from nonsmooth.reports.figures.phase_portrait import portrait_figure

        return portrait_figure(self)


def _corners(cell: FieldCell) -> tuple[Point, ...]:
    return tuple((x / w, y / w) for x, y, w in cell.region.generators)


def _border_record(part: BorderPart) -> dict[str, Any]:
    ends = {"from": part.start, "to": part.end}
    if part.is_exact:
        return {**with_exact(ends), "kind": str(part.kind)}
    return {**{key: [float(v) for v in end] for key, end in ends.items()}, "exact": {}, "kind": str(part.kind)}
