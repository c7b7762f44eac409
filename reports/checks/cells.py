"""The cells of an array as a script or a notebook holds them, and pictures of an array."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.minimizers.sampling import SampledField, sample_field
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.figures.style import figure_bytes
from nonsmooth.reports.output.document import Block, findings, sentences
from nonsmooth.reports.output.facts import floats
from nonsmooth.reports.output.study_options import Drawing
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.symbolic.numbers.number_text import brief_text, float_text, percent_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.symbolic.mechanics.scene import Scene


@dataclass(frozen=True, repr=False)
class CellsResult(Result):
    """The exact cells of the checked square, each with its contact states.

    Attributes:
        partition: the cells.
        show: what its picture shows.
    """

    partition: Partition
    show: Drawing = Drawing.CELLS

    def __len__(self) -> int:
        return len(self.partition.cells)

    def facts(self) -> Record:
        """The JSON record of ``nonsmooth partition --json``."""
        from nonsmooth.reports.checks.answers import partition_record

        return partition_record(self.partition)

    def table(self) -> DataTable:
        """One line for each cell and contact state: rows held, twist about the world's origin, area of the cell."""
        lines = []
        for cell in self.partition.cells:
            for state in cell.states:
                twist = map(brief_text, state.twist)
                lines.append((str(cell.index), state.name, *twist, brief_text(cell.polygon.area)))
        return DataTable(("cell", "rows held", "v_x", "v_y", "omega", "area"), lines)

    def picture(self, suffix: str = ".svg", *, show: str = "cells") -> bytes:
        """A picture as the bytes of a file that ends in ``suffix``; ``show`` as for :meth:`save`."""
        return drawn(self.partition.scene, suffix, show, self.partition)

    def save(self, file: str | Path, *, show: str = "cells") -> Path:
        """Write it; a picture shows the ``cells``, the ``array`` of wheels, or V* over the cells (``rates``).

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
            ValueError: for something else to show.
        """
        return super(CellsResult, replace(self, show=drawing(show))).save(file)

    def draw(self, ax: Axes) -> None:
        """The cells with their motions."""
        from nonsmooth.reports.figures.cells import draw_cells

        draw_cells(ax, self.partition)

    def figure(self) -> Figure:
        """What it is to show."""
        return figure_of(self.partition.scene, self.show, self.partition)

    def blocks(self) -> Sequence[Block]:
        """The cells with their rows and twists."""
        from nonsmooth.reports.output.terminal import partition_blocks

        return partition_blocks(self.partition)

    def summary(self) -> str:
        """How many cells."""
        return f"{len(self)} cells"

    def __repr__(self) -> str:
        partition = self.partition
        head = f"{partition.scene.name}: {len(self)} cells, {len(partition.states)} contact states"
        said = [
            (f"cell {row['cell']}", f"{row['rows held']}: ({row['v_x']}, {row['v_y']}, {row['omega']})")
            for row in self.rows()
        ]
        return short_lines(f"{head}, rule {partition.rule}", said)

    def _repr_html_(self) -> str:
        return self.partition._repr_html_()


@dataclass(frozen=True, repr=False)
class WheelsResult(Result):
    """An array of wheels, under any contact rule.

    Attributes:
        scene: the array.
    """

    scene: Scene

    def facts(self) -> Record:
        """The cells, under a rule that has them."""
        return cells_of(self.scene).facts()

    def table(self) -> DataTable:
        """Places of the wheels."""
        lines = [(str(wheel.index), *map(brief_text, wheel.position)) for wheel in self.scene.wheels]
        return DataTable(("wheel", "x", "y"), lines)

    def figure(self) -> Figure:
        """The wheels."""
        return figure_of(self.scene, Drawing.ARRAY)

    def blocks(self) -> Sequence[Block]:
        """How many."""
        return sentences(self.summary())

    def summary(self) -> str:
        """How many."""
        return f"{len(self.scene.wheels)} wheels"


def cells_of(scene: Scene) -> CellsResult:
    """The cells of an array.

    Raises:
        RefusalError: where the motion is not determined, and under a rule without cells.
    """
    return CellsResult(build_partition(scene))


def drawing(show: str) -> Drawing:
    """What a picture shows, by its name.

    Raises:
        ValueError: for something else to show.
    """
    if show not in list(Drawing):
        raise ValueError(f"show: required one of {', '.join(Drawing)}, received {show!r}")
    return Drawing(show)


def drawn(scene: Scene, suffix: str, show: str, partition: Partition | None = None) -> bytes:
    """A picture of an array as the bytes of a file; see :func:`figure_of`."""
    chosen = drawing(show)
    return figure_bytes(lambda: figure_of(scene, chosen, partition), suffix)


def figure_of(scene: Scene, show: Drawing, partition: Partition | None = None) -> Figure:
    """A picture of an array: its wheels under any contact rule, its cells or V* under rules with cells.

    Args:
        scene: the array.
        show: what.
        partition: its cells, where they are built already.

    Raises:
        RefusalError: where the motion is not determined, and under a rule without cells.
    """
    if show is Drawing.ARRAY:
        from nonsmooth.reports.figures.wheels import array_figure

        return array_figure(scene)
    from nonsmooth.reports.figures.cells import cells_figure, rates_figure

    cells = build_partition(scene) if partition is None else partition
    return rates_figure(cells) if show is Drawing.RATES else cells_figure(cells)


# ---- the sampled field of an array under a rule without cells, as a script or a notebook holds it


SCHEMA = "nonsmooth-field/1"
COUNT = 41  # points in a row: an odd number, so that the checked point is one of them
COLUMNS = ("x", "y", "x_rate", "y_rate", "theta_rate", "upper_derivative")


@dataclass(frozen=True, repr=False, eq=False)
class FieldResult(Result):
    """Velocities at the points of a grid; all numbers are sampled.

    Attributes:
        field: the points with their velocities.
    """

    field: SampledField

    def facts(self) -> Record:
        """The JSON record of ``nonsmooth partition --json`` under a rule without cells."""
        scene = self.field.scene
        head = {"schema": SCHEMA, "scene": scene.name, "rule": scene.contact.rule, "status": "sampled"}
        return {**head, "grid": self.field.count, "rows": self.rows()}

    def table(self) -> DataTable:
        """One line for each point; None where the motion is not determined."""
        field = self.field
        numbers = np.column_stack([field.points, field.velocities, field.rates, field.upper_derivative])
        return DataTable(COLUMNS, [floats(line) for line in numbers.tolist()])

    def dimensions(self) -> Sequence[str]:
        """The two coordinates of the points."""
        return self.table().columns[:2]

    def draw(self, ax: Axes) -> None:
        """Streamlines over V*."""
        from nonsmooth.reports.figures.cells import draw_field

        draw_field(ax, self.field)

    def figure(self) -> Figure:
        """The same with the scale of V*."""
        from nonsmooth.reports.figures.cells import field_figure

        return field_figure(self.field)

    def blocks(self) -> Sequence[Block]:
        """What the samples say."""
        return [*sentences(self.headline), findings(self.said)]

    def summary(self) -> str:
        """What is drawn, and of how many samples."""
        head = f"rule {self.field.scene.contact.rule} has no cells, so --show cells and rates draw one picture"
        return f"{head}: streamlines over V*, {len(self.field.points)} sampled points"

    @property
    def said(self) -> list[tuple[str, str]]:
        """What the samples say, with names."""
        field, units = self.field, self.field.scene.units
        rests, unknown = float(field.rests.mean()), float((~field.is_determined).mean())
        squares = f" {units.length}^2/{units.time}" if units.length else ""
        return [
            ("fastest", float_text(float(np.nanmax(field.speeds, initial=0.0))) + units.after_speed),
            ("largest V*", float_text(float(np.nanmax(field.upper_derivative, initial=-np.inf))) + squares),
            ("the body rests at", f"{percent_text(rests)} of the points"),
            ("not determined at", f"{percent_text(unknown)} of the points"),
        ]

    @property
    def headline(self) -> str:
        """What was sampled."""
        scene, count = self.field.scene, self.field.count
        return f"{scene.name}: rule {scene.contact.rule} has no cells; its field at {count} x {count} points, sampled"

    def __repr__(self) -> str:
        return short_lines(self.headline, self.said)


def field_of(scene: Scene) -> FieldResult:
    """Sample the field of an array over its checked square.

    Raises:
        TypeError: for a rule with cells.
        RefusalError: where some motion meets no friction, and where the square leaves the support polygon.
    """
    return FieldResult(sample_field(scene, COUNT))
