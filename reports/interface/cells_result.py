"""The cells of an array as a script or a notebook holds them, and pictures of an array."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.reports.choices import Drawing
from nonsmooth.reports.files import PICTURES, output_path, write_whole
from nonsmooth.reports.result import Tabular
from nonsmooth.reports.short_text import short_lines
from nonsmooth.symbolic.number_text import brief_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True, repr=False)
class CellsResult(Tabular):
    """The exact cells of the checked square, each with its contact states.

    Attributes:
        partition: the cells.
    """

    partition: Partition

    def __len__(self) -> int:
        return len(self.partition.cells)

    def to_dict(self) -> dict[str, Any]:
        """The JSON record of ``nonsmooth partition --json``."""
        from nonsmooth.reports.records import partition_record

        return partition_record(self.partition)

    def rows(self) -> list[dict[str, str]]:
        """One row for each cell and contact state: rows held, twist about the world's origin, area of the cell."""
        return [
            {
                "cell": str(cell.index),
                "rows held": state.name,
                **dict(zip(("v_x", "v_y", "omega"), map(brief_text, state.twist), strict=True)),
                "area": brief_text(cell.polygon.area),
            }
            for cell in self.partition.cells
            for state in cell.states
        ]

    def picture(self, suffix: str = ".svg", *, show: str = "cells") -> bytes:
        """A picture as the bytes of a file; see :meth:`save`."""
        return drawn(self.partition.scene, suffix, show, self.partition)

    def save(self, file: str | Path, *, show: str = "cells") -> Path:
        """Draw into a file.

        Args:
            file: its name ends in .svg, .png or .pdf.
            show: ``cells``, the ``array`` of wheels, or V* over the cells (``rates``).

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
        """
        path = output_path(str(file), PICTURES)
        write_whole(path, self.picture(path.suffix.lower(), show=show))
        return path

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the cells with their motions."""
        from nonsmooth.reports.figures.cell_map import draw_cell_map
        from nonsmooth.reports.result import own_axes

        axes = own_axes(ax)
        draw_cell_map(axes, self.partition)
        return axes

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


def cells_of(scene: Scene) -> CellsResult:
    """The cells of an array.

    Raises:
        RefusalError: where the motion is not determined, and under a rule without cells.
    """
    return CellsResult(build_partition(scene))


def drawn(scene: Scene, suffix: str, show: str, partition: Partition | None = None) -> bytes:
    """A picture of an array: its wheels under any contact rule, its cells or V* under rules with cells.

    Args:
        scene: the array.
        suffix: ``.svg``, ``.png`` or ``.pdf``.
        show: one of :class:`nonsmooth.reports.choices.Drawing`.
        partition: its cells, where they are built already.

    Raises:
        ValueError: for something else to show.
        RefusalError: where the motion is not determined, and under a rule without cells.
    """
    if show not in list(Drawing):
        raise ValueError(f"show: required one of {', '.join(Drawing)}, received {show!r}")
    if show == Drawing.ARRAY:
        from nonsmooth.reports.figures.array import array_figure

        return array_figure(scene, suffix)
    cells = build_partition(scene) if partition is None else partition
    if show == Drawing.RATES:
        from nonsmooth.reports.figures.rate_map import rate_map

        return rate_map(cells, suffix)
    from nonsmooth.reports.figures.cell_map import cell_map

    return cell_map(cells, suffix)
