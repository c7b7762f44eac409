"""Governing equations with ``sgn`` in one formula for all cells, as the paper prints eqs. (3) and (4)."""

from __future__ import annotations

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.reports.document import Block, Math, Paragraph, Section, display
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import Direction, SignForm, find_sign_form, line_factors
from nonsmooth.reports.prose import listed, paragraph, prose
from nonsmooth.reports.subject import Subject
from nonsmooth.symbolic.numbers.enclosures import EXACT_ROOTS
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.plane import cross

_LEFT = (("v_x", "v_x"), ("v_y", "v_y"), ("omega", r"\omega"))


def sign_form_section(subject: Subject) -> Section:
    """The twist of all cells in one formula, each component that has a short one."""
    forms = partition_forms(subject.cells.partition)
    found = [(left, form) for left, form in zip(_LEFT, forms, strict=True) if form is not None]
    lines = [rf"{latex} &= {form.latex}" for (_, latex), form in found]
    plain = [f"{name} = {form.plain}" for (name, _), form in found]
    blocks: list[Block] = [
        paragraph("The cells are the sectors of lines through the checked point, so the spatial twist is, exactly:"),
        display("\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}", "\n".join(plain)),
    ]
    missing = [Math(latex, name) for (name, latex), form in zip(_LEFT, forms, strict=True) if form is None]
    if missing:
        words = prose("No sum of two products of signs equals the others, which the contact states list cell by cell: ")
        blocks.append(Paragraph((*words, *listed(missing), ".")))
    return Section("Governing equations in sgn form", tuple(blocks))


def without_sign_form(subject: Subject) -> str:
    """Why the cells allow no such formula; empty where they do."""
    partition = subject.cells.partition
    if len(partition.scene.field.radicands) > EXACT_ROOTS:
        return "exact coordinates of the cells would take minutes over so many square roots"
    if any(len(set(cell.twists)) > 1 for cell in partition.cells):
        return "several motions tie in a cell"
    if separating_lines(partition) is None:
        return "the cells are not the sectors of lines through the checked point"
    if not any(partition_forms(partition)):
        return "no sum of two products of signs gives the twist"
    return ""


def separating_lines(partition: Partition) -> list[Direction] | None:
    """Directions of the lines through the origin that part the cells; None where another edge does."""
    cells = partition.complex
    lines: list[Direction] = []
    for edge in cells.edges:
        if edge.left is None or edge.right is None:
            continue
        first, last = cells.points[edge.start], cells.points[edge.end]
        if sign(cross(first, last)):
            return None
        away = first if any(sign(value) for value in first) else last
        direction = _number(away[0]), _number(away[1])
        if all(sign(cross(direction, line)) for line in lines):
            lines.append(direction)
    return lines


def partition_forms(partition: Partition) -> tuple[SignForm | None, ...]:
    """The forms of ``v_x, v_y, omega``; None for a component that has no short one."""
    lines = separating_lines(partition)
    if not lines:
        return None, None, None
    factors = line_factors(lines)
    centres = [(_number(cell.polygon.centre[0]), _number(cell.polygon.centre[1])) for cell in partition.cells]
    twists = [cell.twists[0] for cell in partition.cells]
    return tuple(
        find_sign_form(factors, list(zip(centres, values, strict=True))) for values in zip(*twists, strict=True)
    )


def _number(value: object) -> Number:
    """A coordinate as an exact number."""
    if isinstance(value, Number):
        return value
    exact: Number = value.exact()  # type: ignore[attr-defined]
    return exact
