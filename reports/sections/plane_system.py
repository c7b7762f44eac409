"""Sections of reports about plain systems in two states: polygons, borders, derivatives of V, and the portrait."""

from __future__ import annotations

from collections.abc import Iterable

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import FieldCell
from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart, sliding_velocity
from nonsmooth.proofs.systems.findings import DERIVATIVES, Method, PlaneFunction
from nonsmooth.reports.checks.system_subject import SystemSubject
from nonsmooth.reports.output.document import (
    Block,
    Entry,
    Figure,
    Math,
    Section,
    Text,
    display,
    number,
    point,
    table,
)
from nonsmooth.reports.output.field_formulas import polynomial_math, rates_header, stated_math
from nonsmooth.reports.output.prose import listed, paragraph
from nonsmooth.symbolic.formulas.enclosed_functions import kinds_text
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import place_text

SHOWN_BORDERS = 60  # rows; a picture shows the others
LADDER = (
    "Three sets bound the derivative of V along solutions, each inside the one before, and the last one decides: all "
    "products of gradients and velocities that meet at a point (naive), the set of Shevitz and Paden, and that of "
    "Bacciotti and Ceragioli. Their signs over the domain without the point:"
)


# ---- cells and borders ---------------------------------------------------------------------------


def polygons_section(subject: SystemSubject) -> Section:
    """The pieces of the square on which the fields are polynomials."""
    states = subject.scene.states
    words = paragraph(
        "The switching surfaces and the axes through the checked point cut the square into {} cells. On each the field "
        "is {}. Corners and rates are written in the displacement from the point, whose entries are called "
        "like the states.",
        str(len(subject.polygons)),
        f"a polynomial in the states and in {kinds_text(subject.scene.names)} of them"
        if subject.scene.names
        else "a polynomial",
    )
    rows = [row for k, cell in enumerate(subject.polygons) for row in _cell_rows(k, cell, subject)]
    header: list[Entry] = ["cell", "corners", *rates_header(states)]
    return Section("Cells", (words, table(header, rows, (0.07, 0.41, 0.26, 0.26))))


def _cell_rows(index: int, cell: FieldCell, subject: SystemSubject) -> Iterable[list[Entry]]:
    """A row for the field of a cell, or for each that may act there."""
    states = subject.scene.states
    where: Text = listed([point((x / w, y / w)) for x, y, w in cell.region.generators])
    for guard in cell.region.guards:
        bound = polynomial_math(guard, states)
        where = (*where, "; ", Math(f"{bound.latex} > 0", f"{bound.plain} > 0"))
    known = [subject.portrait.fields[index]] if subject.scene.names else map(StatedField, cell.velocities)
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


# ---- what decides --------------------------------------------------------------------------------


def derivative_blocks(subject: SystemSubject, shown: PlaneFunction) -> list[Block]:
    """The largest values of the three derivatives of V, and V with its derivative on each cell."""
    return [paragraph(LADDER), _ladder(shown), *_pieces(subject, shown)]


def _ladder(shown: PlaneFunction) -> Block:
    rows: list[list[Entry]] = []
    for key, found in shown.suprema.items():
        largest: Entry = ""
        if found.value is not None and found.point is not None:
            largest = (number(found.value), " at ", point(found.point))
        rows.append([DERIVATIVES[key], str(found.trend), largest])
    return table(("derivative", "sign", "largest value, where it is attained"), rows, (0.3, 0.25, 0.45))


def _pieces(subject: SystemSubject, shown: PlaneFunction) -> list[Block]:
    """V and its derivative on each cell."""
    states = subject.scene.states
    rows: list[list[Entry]] = [
        [str(k), polynomial_math(cell.potential, states), polynomial_math(rate, states)]
        for k, cell in enumerate(shown.result.cells, 1)
        for rate in cell.rates
    ]
    words = paragraph("On each cell of its domain, V and its derivative along the field of the cell:")
    return [words, table(("cell", "V", "grad V . f"), rows, (0.08, 0.4, 0.52))]


def leading_section(subject: SystemSubject) -> Section:
    """The homogeneous parts of lowest degree on tangent cones."""
    found = subject.result.by(Method.LEADING)
    if found is None:
        raise TypeError("required a system that its leading terms decide")
    leading = found.proofs
    words = paragraph(
        "Near the point the fields are looked at to leading order on the tangent cones of their cells, where solutions "
        "of the homogeneous field turn and grow by functions of the direction alone; what follows for them holds for "
        "the system. Here, {}: {}.",
        found.reason,
        str(leading.verdict),
    )
    rows: list[list[Entry]] = [
        [point(m.ray), ("inward", "at rest", "outward")[m.direction + 1], "sliding" if m.sliding else "in a cone"]
        for m in leading.motions
    ]
    blocks: list[Block] = [words]
    if rows:
        blocks.append(paragraph("Rays along which a radial motion is possible:"))
        blocks.append(table(("ray", "direction", "kind"), rows, (0.5, 0.25, 0.25)))
    return Section("Leading terms", tuple(blocks))


# ---- the picture ---------------------------------------------------------------------------------


def portrait_section(subject: SystemSubject) -> Section:
    """The phase portrait."""
    figure = Figure(
        "phase-portrait",
        (
            "Field lines, nullclines, borders, and level sets of the V that proves the verdict, over the checked "
            "square; measured from the checked point.",
        ),
        f"Phase portrait of {one_line(subject.scene.name)}: {subject.result.verdict}.",
        subject.invocation.line("partition", "-o", "portrait.svg"),
        subject.portrait.content,
    )
    return Section("Phase portrait", (figure,))
