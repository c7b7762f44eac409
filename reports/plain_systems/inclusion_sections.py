"""Cells, borders and the checked point of a plain system: Filippov's inclusion, part by part."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import FieldCell
from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart, sliding_velocity
from nonsmooth.proofs.systems.local_cells import values_at_origin
from nonsmooth.reports.document import Block, Entry, Math, Section, Text, display, point, table
from nonsmooth.reports.plain_systems.system_formulas import polynomial_math, rate_name, stated_math
from nonsmooth.reports.plain_systems.system_subject import SystemSubject
from nonsmooth.reports.prose import listed, paragraph
from nonsmooth.symbolic.number_text import place_text

SHOWN_BORDERS = 60  # rows; a picture shows the others


def cells_section(subject: SystemSubject) -> Section:
    """The pieces of the square on which the fields are polynomials."""
    states = subject.system.states
    words = paragraph(
        "The switching surfaces and the axes through the checked point cut the square into {} cells. On each the field "
        "is {}. Corners and rates are written in the displacement from the point, whose entries are called "
        "like the states.",
        str(len(subject.cells)),
        "a polynomial in the states and in sines and cosines of them" if subject.system.names else "a polynomial",
    )
    rows = [row for k, cell in enumerate(subject.cells) for row in _cell_rows(k, cell, subject)]
    header: list[Entry] = ["cell", "corners", *(rate_name(name) for name in states)]
    return Section("Cells", (words, table(header, rows, (0.07, 0.41, 0.26, 0.26))))


def _cell_rows(index: int, cell: FieldCell, subject: SystemSubject) -> Iterable[list[Entry]]:
    """A row for the field of a cell, or for each that may act there."""
    states = subject.system.states
    where: Text = listed([point((x / w, y / w)) for x, y, w in cell.region.generators])
    for guard in cell.region.guards:
        bound = polynomial_math(guard, states)
        where = (*where, "; ", Math(f"{bound.latex} > 0", f"{bound.plain} > 0"))
    known = [subject.portrait.fields[index]] if subject.system.names else map(StatedField, cell.velocities)
    for k, field in enumerate(known):
        yield [str(index + 1) if not k else "", where if not k else "", *stated_math(field, states)]


def borders_section(subject: SystemSubject) -> Section:
    """What solutions do where two cells meet along a straight side."""
    borders = subject.portrait.borders
    blocks: list[Block] = [
        paragraph(
            "Across these straight borders the field jumps. With f and g on the two sides and a normal n, solutions "
            "cross where n . f and n . g have one sign. Where both fields push onto the border, solutions slide along "
            "it with the only mixture that is tangent:"
        ),
        display(
            r"f_s = \frac{(n \cdot g)\, f - (n \cdot f)\, g}{n \cdot g - n \cdot f}",
            "f_s = ((n . g) f - (n . f) g)/(n . g - n . f)",
        ),
    ]
    if not borders:
        return Section("Filippov's inclusion on borders", (paragraph("No straight border lies between two fields."),))
    rows = [[*_ends(part), str(part.kind), _velocity(part)] for part in borders[:SHOWN_BORDERS]]
    blocks.append(table(("from", "to", "solutions", "f_s midway"), rows, (0.25, 0.25, 0.2, 0.3)))
    if len(borders) > SHOWN_BORDERS:
        blocks.append(paragraph("{} more are drawn in the phase portrait.", str(len(borders) - SHOWN_BORDERS)))
    return Section("Filippov's inclusion on borders", tuple(blocks))


def _ends(part: BorderPart) -> Iterable[Entry]:
    """Exact ends; those at zeros of sines are rounded."""
    rounded = part.fields[0].waves and not part.is_exact
    return (place_text(end, 4) if rounded else point(end) for end in (part.start, part.end))


def _velocity(part: BorderPart) -> Entry:
    if part.kind not in {BorderKind.SLIDING, BorderKind.REPELLING}:
        return ""
    velocity = sliding_velocity(part, _middle(part))
    return place_text(velocity, 4) if any(field.waves for field in part.fields) else point(velocity)


def _middle(part: BorderPart) -> Point:
    first, second = ((a + b) / 2 for a, b in zip(part.start, part.end, strict=True))
    return (first, second)


def point_section(subject: SystemSubject) -> Section:
    """Whether the checked point is an equilibrium: 0 in the hull of the fields of all cells that hold it."""
    values = values_at_origin(subject.cells)
    words = paragraph(
        "At the checked point F is the convex hull of the values of the fields of all cells that touch it: {}. "
        "The point is an equilibrium if 0 is in this hull; here that {}.",
        _values_text(values),
        str(subject.result.equilibrium),
    )
    return Section("The checked point", (words,))


def _values_text(values: Sequence[Point]) -> Math:
    parts = [point(value) for value in values]
    return Math(r",\allowbreak\ ".join(part.latex for part in parts), ", ".join(part.plain for part in parts))
