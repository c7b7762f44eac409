"""Sections of the derivation report on contact: constraints, contact states with their equations."""

from __future__ import annotations

from collections.abc import Iterable

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.minimizers.minimum import Functional, functional_of
from nonsmooth.proofs.theorem4 import CellCheck
from nonsmooth.reports.checks.cells import CellsResult
from nonsmooth.reports.checks.subject import ArraySubject
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Display,
    Figure,
    Section,
    Text,
    cell_mark,
    display,
    number,
    point,
    table,
)
from nonsmooth.reports.output.prose import listed, paragraph, prose
from nonsmooth.symbolic.formulas.surfaces import number_latex
from nonsmooth.symbolic.mechanics.contact_states import ContactState, askew_wheels, constraint_matrix
from nonsmooth.symbolic.mechanics.equations import Coordinates, GoverningEquations, governing_equations
from nonsmooth.symbolic.mechanics.scene import Wheel
from nonsmooth.symbolic.numbers.number_text import real_text

LONGEST = 120  # characters of an exact coefficient; longer ones are rounded (the JSON report holds them exactly)
LONGEST_ENTRY = 30  # the same for an entry of a matrix
SIDE_BY_SIDE = 62  # characters of both widest lines up to which two systems stand beside each other


def constraints_section(wheels: Iterable[Wheel]) -> Section:
    """Omega_i of the given wheels, about the checked point."""
    general = display(
        r"\Omega_i = \begin{pmatrix} d_i^T & d_i \cdot J p_i & -u_i \\ n_i^T & n_i \cdot J p_i & 0 \end{pmatrix},"
        r"\qquad n_i = J d_i, \qquad \Omega_i \begin{pmatrix} \xi \\ 1 \end{pmatrix} = 0",
        "Omega_i = [[d_i^T, d_i . J p_i, -u_i], [n_i^T, n_i . J p_i, 0]], n_i = J d_i, Omega_i (xi, 1) = 0",
    )
    blocks: list[Block] = [
        paragraph(
            "Wheel i acts through a roll row and a side row (eq. 2 of the paper, written for a rim along `d_i`):"
        ),
        general,
        *_askew(wheels),
        paragraph(
            "In the body's own coordinates the arm is `p_i - c` instead of `p_i`: the rows depend on x and y, "
            "never on `theta`."
        ),
    ]
    blocks += [_constraint(wheel) for wheel in wheels]
    return Section("Constraints", tuple(blocks))


def _askew(wheels: Iterable[Wheel]) -> list[Block]:
    """The rows of wheels whose friction axis is not their rim, where there are any."""
    rows = display(
        r"\Omega_i = \begin{pmatrix} a_i^T & a_i \cdot J p_i & -u_i\, a_i \cdot d_i \\"
        r" n_i^T & n_i \cdot J p_i & -u_i\, n_i \cdot d_i \end{pmatrix}, \qquad n_i = J a_i",
        "Omega_i = [[a_i^T, a_i . J p_i, -u_i a_i . d_i], [n_i^T, n_i . J p_i, -u_i n_i . d_i]], n_i = J a_i",
    )
    return _where_askew(wheels, "rows", rows)


def askew_slips(wheels: Iterable[Wheel]) -> list[Block]:
    """The slips of wheels whose friction axis is not their rim, where there are any."""
    slips = display(
        r"a_i \cdot v(p_i) - u_i\, a_i \cdot d_i, \qquad n_i \cdot v(p_i) - u_i\, n_i \cdot d_i, \qquad n_i = J a_i",
        "a_i . v(p_i) - u_i a_i . d_i, n_i . v(p_i) - u_i n_i . d_i, n_i = J a_i",
    )
    return _where_askew(wheels, "slips", slips)


def _where_askew(wheels: Iterable[Wheel], what: str, formula: Block) -> list[Block]:
    """A formula along and across the friction axes, where one is not the rim."""
    said = paragraph(f"Where the friction axis `a_i` is not the rim, the {what} are those along and across it:")
    return [] if all(wheel.axis is None for wheel in wheels) else [said, formula]


def constraining_wheels(result: CellCheck) -> list[Wheel]:
    """The wheels whose rows are held somewhere in the square."""
    held = {row.wheel.index for state in result.partition.states for row in state.rows}
    return [wheel for wheel in result.partition.scene.wheels if wheel.index in held]


def _constraint(wheel: Wheel) -> Display:
    rows = constraint_matrix(wheel)
    latex = r" \\ ".join(" & ".join(number_latex(entry, LONGEST_ENTRY) for entry in row) for row in rows)
    plain = "; ".join(", ".join(str(entry) for entry in row) for row in rows)
    return display(
        rf"\Omega_{{{wheel.index:d}}} = \begin{{pmatrix}} {latex} \end{{pmatrix}}", f"Omega_{wheel.index:d} = [{plain}]"
    )


def contact_states_section(result: CellCheck) -> Section:
    """The census, the general solution, and every minimizing state in both coordinates."""
    general = display(
        r"\omega = \frac{u_j - u_i\, d_i \cdot d_j}{d_j \cdot J(p_j - p_i)}, \qquad v = u_i d_i - \omega J p_i",
        "omega = (u_j - u_i d_i . d_j) / (d_j . J(p_j - p_i)), v = u_i d_i - omega J p_i",
    )
    words = paragraph(
        "Both rows of wheel i and the roll row of wheel j have the solution below; for the side row of wheel "
        "j, `n_j` replaces `d_j` and 0 replaces `u_j`."
    )
    if askew_wheels(result.scene):
        words = paragraph(
            "Both rows of wheel i and the roll row of wheel j have the solution below where the friction axis of wheel "
            "j is its rim; else `a_j` replaces `d_j`, and `u_j a_j . d_j` replaces `u_j`."
        )
    blocks: tuple[Block, ...] = (_census(result), words, general)
    if functional_of(rule_of(result.scene)) is Functional.BOX:
        functional = display(
            r"D(\xi) = \sum_i N_i \left(\mu_R \lvert d_i \cdot v(p_i) - u_i \rvert"
            r" + \mu_S \lvert n_i \cdot v(p_i) \rvert\right)",
            "D(xi) = sum_i N_i (mu_R |d_i . v(p_i) - u_i| + mu_S |n_i . v(p_i)|)",
        )
        words = paragraph("The motion minimizes the dissipation below; a minimizer satisfies three independent rows.")
        blocks = (_census(result), words, functional, *askew_slips(result.scene.wheels))
    states = tuple(_state_section(result, state) for state in result.partition.states)
    return Section("Contact states and governing equations", blocks, states)


def _census(result: CellCheck) -> Bullets:
    census = result.census
    items: list[Text] = [(f"possible: {census.possible} triples of the {2 * len(result.scene.wheels)} rows",)]
    if census.singular is not None:
        items.append((f"singular: {census.singular} triples of dependent rows",))
        items.append((f"regular: {census.regular}, with {census.distinct_twists} distinct twists",))
    items.append((f"minimizing: {len(result.partition.states)} own a cell of the checked square",))
    return Bullets(tuple(items))


def _state_section(result: CellCheck, state: ContactState) -> Section:
    held = set(state.rows)
    cells = [c.index for c in result.partition.cells if any(set(s.rows) == held for s in c.states)]
    title = f"{state.name} (cell{'s' * (len(cells) > 1)} {', '.join(str(index) for index in cells)})"
    blocks: list[Block] = [paragraph("At the scene's speeds, spatial twist and pose rate:")]
    blocks += _pair(*(governing_equations(state, kind) for kind in Coordinates))
    if len(state.rows) > 3:
        words = "More than three rows hold at these speeds, so no three of them define control vector fields."
        blocks.append(paragraph(words))
    elif state.control_fields:
        blocks.append(paragraph("With the speeds as inputs (their factors are the control vector fields):"))
        blocks += _pair(*(governing_equations(state, kind, symbolic_inputs=True) for kind in Coordinates))
    else:
        blocks.append(paragraph("No input acts: all three rows are side rows."))
    return Section(title, tuple(blocks), marks=tuple(cell_mark(index) for index in cells))


def _pair(*systems: GoverningEquations) -> list[Block]:
    """Two systems beside each other where there is room, one below the other elsewhere."""
    plains = [system.plain(LONGEST) for system in systems]
    latex = [system.latex(LONGEST) for system in systems]
    if sum(max(len(line) for line in plain.splitlines()) for plain in plains) <= SIDE_BY_SIDE:
        return [display(r" \qquad ".join(latex), "\n".join(plains))]
    return [display(*notations) for notations in zip(latex, plains, strict=True)]


# ---- cells ---------------------------------------------------------------------------------------


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
