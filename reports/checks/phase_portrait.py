"""The phase portrait of a plain system in two states: its cells, what happens on their borders, and a picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import FieldCell, square_regions, system_cells
from nonsmooth.analysis.fields.stated_field import StatedField, inside, polynomial_values, rate_values, stated_fields
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart, border_parts, wave_border_parts
from nonsmooth.proofs.systems.findings import PlaneFunction
from nonsmooth.reports.figures.style import INK, legend_below, new_figure, title_figure
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.facts import with_exact
from nonsmooth.reports.studies.result import DataTable, Result
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, require_one_field, require_plane

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


SCHEMA = "nonsmooth-phase-portrait/1"

# the picture
SIZE = 6.4  # inches
MESH = 161  # points in a row; odd, so that the middle is one
LEVELS = 6  # of V
FIELD, NULLCLINES, REGION, CURVE = "#999999", ("#E69F00", "#56B4E9"), "#0072B2", "#D55E00"
BORDERS: dict[BorderKind, Record] = {
    BorderKind.SLIDING: {"color": INK, "linewidth": 2.6},
    BorderKind.REPELLING: {"color": INK, "linewidth": 1.4, "linestyle": (0, (5, 3))},
    BorderKind.CROSSING: {"color": CURVE, "linewidth": 1.0},
    BorderKind.TOUCHED: {"color": CURVE, "linewidth": 1.0, "linestyle": (0, (1, 1))},
    BorderKind.UNDECIDED: {"color": FIELD, "linewidth": 1.4, "linestyle": (0, (1, 3))},
}


@dataclass(frozen=True, repr=False)
class PhasePortrait(Result):
    """Cells and borders of the checked square, in the displacement from the checked point.

    Attributes:
        system: in two states.
        decided: the verdict on the checked point, where it is known already.

    Raises:
        SceneError: for another number of states, and for arbitrary switching.
    """

    system: SwitchedSystem
    decided: StabilityResult | None = None

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
        if self.system.rewriting.names:
            return tuple(wave_border_parts(self.cells, self.fields))
        return tuple(border_parts(self.cells))

    @cached_property
    def stability(self) -> StabilityResult:
        """The verdict on the checked point."""
        return decide_system(self.system) if self.decided is None else self.decided

    def facts(self) -> Record:
        """The JSON record."""
        head = {"schema": SCHEMA, "scene": self.system.name, "states": list(self.system.states)}
        at = with_exact({"at": self.system.check.equilibrium, "radius": self.system.check.radius})
        cells = [self._cell_record(*pair) for pair in zip(self.cells, self.fields, strict=True)]
        return {**head, **at, "cells": cells, "borders": [_border_record(part) for part in self.borders]}

    def _cell_record(self, cell: FieldCell, field: StatedField) -> Record:
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
        blocks: list[Block] = [*sentences(head), table(names, lines)]
        rows = [(place_text(part.start, 4), place_text(part.end, 4), str(part.kind)) for part in self.borders]
        return [*blocks, table(("from", "to", "solutions"), rows)] if rows else blocks

    def summary(self) -> str:
        """How many cells, and the verdict on the checked point."""
        return f"{len(self.cells)} cells (cut along the axes, too), {self.stability.verdict}"

    def draw(self, ax: Axes) -> None:
        """Everything, in the displacement from the checked point."""
        self.draw_field(ax)
        self.draw_potential(ax)
        ax.plot([0], [0], "o", color=INK, markersize=5, zorder=6, label="checked point")

    def draw_field(self, ax: Axes) -> None:
        """The field, and what solutions do on borders."""
        half = self.system.check.half_width
        line = np.linspace(-half, half, MESH)
        xs, ys = np.meshgrid(line, line)
        rates = sampled_rates(self.cells, self.fields, xs, ys)
        ax.streamplot(line, line, *rates, color=FIELD, linewidth=0.6, density=1.3, arrowsize=0.7, zorder=1)
        self._draw_nullclines(ax, xs, ys)
        self._draw_curves(ax, xs, ys)
        self.draw_borders(ax)
        x, y = self.system.states
        ax.set(xlim=(-half, half), ylim=(-half, half), xlabel=x, ylabel=y, aspect="equal")

    def figure(self) -> Figure:
        """The portrait with a legend."""
        figure = new_figure(SIZE, SIZE * 1.12)
        self.draw(figure.add_subplot())
        legend_below(figure, columns=3, fontsize="small")
        everywhere = ", from everywhere" if self.stability.reach.everywhere else ""
        title_figure(figure, f"{one_line(self.system.name)}: {self.stability.verdict}{everywhere}")
        return figure

    def _draw_nullclines(self, axes: Axes, xs: Floats, ys: Floats) -> None:
        """Where one rate vanishes inside a cell."""
        for k, (name, color) in enumerate(zip(self.system.states, NULLCLINES, strict=True)):
            drawn = False
            for cell, field in zip(self.cells, self.fields, strict=True):
                values = np.where(inside(cell, xs, ys), rate_values(field, xs, ys)[k], np.nan)
                known = values[~np.isnan(values)]
                if known.size and known.min() < 0 < known.max():
                    axes.contour(xs, ys, values, levels=[0.0], colors=color, linewidths=1.4, zorder=2)
                    drawn = True
            if drawn:
                axes.plot([], [], color=color, linewidth=1.4, label=f"{name}' = 0")

    def _draw_curves(self, axes: Axes, xs: Floats, ys: Floats) -> None:
        """Switching curves, each once."""
        for guard in dict.fromkeys(guard for cell in self.cells for guard in cell.region.guards):
            values = polynomial_values(guard, xs, ys)
            if values.min() < 0 < values.max():
                axes.contour(xs, ys, values, levels=[0.0], colors=CURVE, linestyles="--", linewidths=1.0, zorder=3)

    def draw_borders(self, axes: Axes) -> None:
        """Straight borders, their kinds told apart by form."""
        named: set[BorderKind] = set()
        for part in self.borders:
            ends = [[float(end[k]) for end in (part.start, part.end)] for k in (0, 1)]
            label = "" if part.kind in named else f"border: {part.kind}"
            axes.plot(*ends, **BORDERS[part.kind], zorder=4, label=label or "_")
            named.add(part.kind)

    def draw_potential(self, axes: Axes) -> None:
        """Level sets of the V that proves the verdict, over the square on which it is proved."""
        function, region = self.stability.function, self.stability.reach.region
        if function is None:
            return
        line, potential = sampled_potential(self.system, function)
        axes.contour(line, line, potential, levels=LEVELS, colors=REGION, linewidths=0.5, alpha=0.6, zorder=2)
        axes.plot([], [], color=REGION, linewidth=0.5, label="level sets of V")
        if region is not None and region.falls:
            axes.contour(line, line, potential, levels=[float(region.level)], colors=REGION, linewidths=2.0, zorder=5)
            axes.plot([], [], color=REGION, linewidth=2.0, label="certified region")


def _corners(cell: FieldCell) -> tuple[Point, ...]:
    return tuple((x / w, y / w) for x, y, w in cell.region.generators)


def _border_record(part: BorderPart) -> Record:
    ends = {"from": part.start, "to": part.end}
    if part.is_exact:
        return {**with_exact(ends), "kind": str(part.kind)}
    return {**{key: [float(v) for v in end] for key, end in ends.items()}, "exact": {}, "kind": str(part.kind)}


# ---- values at many points -----------------------------------------------------------------------


def sampled_rates(
    cells: Sequence[FieldCell], fields: Sequence[StatedField], xs: Floats, ys: Floats
) -> tuple[Floats, Floats]:
    """The field at many points, that of one cell where several meet."""
    first, second = np.zeros_like(xs), np.zeros_like(xs)
    for cell, field in zip(cells, fields, strict=True):
        here = inside(cell, xs, ys)
        f, g = rate_values(field, xs, ys)
        first[here], second[here] = f[here], g[here]
    return first, second


def sampled_potential(system: SwitchedSystem, function: PlaneFunction) -> tuple[Floats, Floats]:
    """V over the square on which it is known, and the displacements at which it is sampled along each side."""
    half = float(function.domain.radius or system.check.radius)
    line = np.linspace(-half, half, MESH)
    xs, ys = np.meshgrid(line, line)
    potential = np.zeros_like(xs)
    for cell in function.result.cells:
        here = inside(cell, xs, ys)
        potential[here] = polynomial_values(cell.potential, xs, ys)[here]
    return line, potential
