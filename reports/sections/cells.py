"""The partition in the derivation report: its map, the polygons, and the proof that they tile the square."""

from __future__ import annotations

from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.reports.cells import CellsResult
from nonsmooth.reports.document import Figure, Section, cell_mark, number, point, table
from nonsmooth.reports.prose import listed, paragraph, prose
from nonsmooth.reports.subject import ArraySubject
from nonsmooth.symbolic.number_text import real_text


def cells_section(subject: ArraySubject) -> Section:
    """The map, and the polygons with the proof that they tile the square."""
    cells = subject.cells.partition.cells
    rows = [
        (
            str(cell.index),
            " or ".join(state.name for state in cell.states),
            listed([point(vertex) for vertex in cell.polygon.vertices]),
            number(cell.polygon.area),
        )
        for cell in cells
    ]
    header = ("cell", "rows held", "vertices, counterclockwise", "area")
    listing = table(header, rows, (1.2, 2, 6.6, 2.7), [(cell_mark(cell.index),) for cell in cells])
    return Section("Cells", (_map(subject), listing, paragraph("{}", _tiling(subject.cells))))


def _map(subject: ArraySubject) -> Figure:
    partition = subject.cells.partition

    return Figure(
        "cell-map",
        prose(
            "The cells of the checked square. Within a cell the same rows are held and the twist is constant; "
            "arrows show the direction of the centre of mass, turning signs the sense of `omega`."
        ),
        f"Map of the {len(partition.cells)} cells with an arrow for the motion in each.",
        subject.invocation.line("partition", "-o", "cells.pdf"),
        CellsResult(partition).content,
    )


def _tiling(result: CellCheck) -> str:
    partition = result.partition
    if not partition.complete:
        return "Only the cells at the checked point were built; the verdicts need no others."
    said = "cancel exactly and leave its border, so they tile it" if partition.tiles else "do not leave its border"
    error = real_text(partition.area_error)
    return f"In sum, the boundaries of the cells {said}. Area of the square minus area of the cells: {error}."
