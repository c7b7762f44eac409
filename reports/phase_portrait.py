"""The phase portrait of a plain system in two states: its cells, what happens on their borders, and a picture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import FieldCell, square_regions, system_cells
from nonsmooth.analysis.fields.stated_field import StatedField, stated_fields
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.border_motion import BorderPart, border_parts
from nonsmooth.proofs.systems.border_signs import wave_border_parts
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.exact_record import with_exact
from nonsmooth.symbolic.number_text import place_text
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem, require_one_field, require_plane

SCHEMA = "nonsmooth-phase-portrait/1"


@dataclass(frozen=True)
class PhasePortrait:
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

    def record(self) -> dict[str, Any]:
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

    def view(self) -> RenderableType:
        """Two tables: cells with their fields, and borders with what solutions do there."""
        states = self.system.states
        cells, borders = Table("corners", *(f"{name}'" for name in states)), Table("from", "to", "solutions")
        for cell, field in zip(self.cells, self.fields, strict=True):
            where = ", ".join(place_text(corner, 4) for corner in _corners(cell))
            guards = "".join(f"; {self._text(g)} > 0" for g in cell.region.guards)
            cells.add_row(where + guards, *field.texts(states))
        for part in self.borders:
            borders.add_row(place_text(part.start, 4), place_text(part.end, 4), str(part.kind))
        head = f"{one_line(self.system.name)}: plain switched system in {', '.join(states)}, measured from the point"
        return Group(Text(head), cells, borders) if self.borders else Group(Text(head), cells)

    def picture(self, suffix: str) -> bytes:
        """Field lines, nullclines, borders, and the V that proves stability with its region."""
        from nonsmooth.reports.figures.phase_portrait import portrait_figure

        return portrait_figure(self, suffix)


def _corners(cell: FieldCell) -> tuple[Point, ...]:
    return tuple((x / w, y / w) for x, y, w in cell.region.generators)


def _border_record(part: BorderPart) -> dict[str, Any]:
    ends = {"from": part.start, "to": part.end}
    if part.is_exact:
        return {**with_exact(ends), "kind": str(part.kind)}
    return {**{key: [float(v) for v in end] for key, end in ends.items()}, "exact": {}, "kind": str(part.kind)}
