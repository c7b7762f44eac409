"""What a person reads in a terminal: verdict tables, cell tables and the list of scenes.

Everything is built from :class:`rich.text.Text`, never from markup, because intervals such as ``[a, b]`` and names
from scene files are text.  Verdicts are words first; color repeats them, and only on a terminal.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table as TerminalTable
from rich.text import Text

from nonsmooth.proofs.findings import Theorem4
from nonsmooth.reports.output.facts import fact_lines
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_field import FirstRemark, angle_notes
from nonsmooth.symbolic.numbers.number_text import exact_place, short_text

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.proofs.answers.answer import Answer
    from nonsmooth.proofs.theorem4 import Check
    from nonsmooth.reports.output.document import Block
    from nonsmooth.symbolic.numbers.number_field import NumberField

VERDICT_WIDTH = 14  # columns: "asymptotically"
MORE = "--evidence shows why, with all numbers"
ANSWER_WIDTH = 21  # columns: "asymptotically stable"

_STYLES = {
    "comes home": "green",
    "comes near": "green",
    "can be held": "green",
    "keeps": "green",
    "stays near": "yellow",
    "drifts": "yellow",
    "leaves": "red",
    "tips": "red",
    "cannot be held": "red",
    "holds": "green",
    "asymptotically stable": "green",
    "stable": "green",
    "stabilizable": "green",
    "not applicable": "dim",
    "undecided": "yellow",
    "no certificate": "yellow",
    "fails": "red",
    "hypotheses not met": "yellow",
}
_LEGEND = (
    ("c, v, omega", "centre of mass measured from the checked point c*, its velocity, rotation rate"),
    ("F", "Filippov set: hull of the velocities of all closed cells that hold a point"),
    ("V*", "upper derivative: the largest rate of V = |c|^2 over F"),
    ("d_i, p_i, u_i, J", "rim direction, position and speed of wheel i; quarter turn"),
    ("xi, k, n_i", "motion (v, omega); feedback gain; J d_i"),
)


def clauses_view(result: Check, answers: Sequence[Answer]) -> RenderableType:
    """One line for each clause of Theorem 4, why the theorem does not hold where it does not, and where bodies tip.

    Also why an answer is open that says that this stands below.
    """
    from nonsmooth.proofs.answers.answer import reason_below  # of arrays alone

    lines = TerminalTable.grid(padding=(0, 2))
    tips: list[Text] = []
    for clause, found in result.clauses:
        lines.add_row(Text(f"  {clause.name}"), verdict_text(found.verdict))
        supports = (fact for fact in result.facts(clause) if fact.key == "support")
        tips += [Text(f"note: {line}", "yellow") for line in fact_lines(supports)]
    why = [] if result.verdict is Theorem4.HOLDS else [Text(f"because {result.reason}")]
    for answer in answers:
        reason = reason_below(answer, result.results)
        if reason and reason not in result.reason:
            why.append(Text(f"{answer.name}, {answer.verdict}: {reason}"))
    return Group(lines, *why, *tips)


def check_view(result: Check) -> RenderableType:
    """Why: the verdict of Theorem 4, clause by clause, with its evidence."""
    table = header_table("clause", "verdict", "evidence")
    table.show_lines = True
    table.columns[1].max_width = VERDICT_WIDTH
    for clause, found in result.clauses:
        evidence = [found.reason, *fact_lines(result.facts(clause))]
        table.add_row(Text(clause.name), verdict_text(found.verdict), Text("\n".join(evidence)))
    table.add_row(Text("Theorem 4", "bold"), verdict_text(result.verdict, bold=True), Text(result.reason))
    left_out = [Text(f"left out: {s.what} ({s.count}): {s.why}") for s in result.skipped]
    return Group(Text(_census(result)), table, *left_out)


def partition_blocks(partition: Partition) -> Sequence[Block]:
    """The cells with their rows and twists."""
    from nonsmooth.reports.output.document import sentences, table

    rows = []
    for cell in partition.cells:
        for k, state in enumerate(cell.states):
            index, area = (str(cell.index), short_text(cell.polygon.area)) if k == 0 else ("", "or")
            rows.append((index, state.name, *map(short_text, state.twist), area))
    exact = "the cells tile the square" if partition.tiles else "the cells do not tile the square"
    head = f"{one_line(partition.scene.name)}: {len(partition.cells)} cells, {len(partition.states)} contact states"
    notes = (
        f"area of the square minus area of the cells: {short_text(partition.area_error)} ({exact})",
        "R1 and S1 are the roll and side row of wheel 1; (v_x, v_y) is the body's velocity at the world origin",
        *(f"note: {note}" for note in later_notes(partition.scene.field)),
    )
    units = partition.scene.units
    shown = {"v_x": units.speed, "v_y": units.speed, "omega": "rad/s", "area": f"{units.length}^2"}
    heads = [f"{name} ({unit})" if units.length else name for name, unit in shown.items()]
    cells = table(("cell", "rows held", *heads), rows)
    return [*sentences(f"{head}, rule {partition.rule}"), cells, *sentences(*notes)]


def scenes_view(kinds: Iterable[dict[str, str]]) -> RenderableType:
    """The built-in scenes, kind by kind."""
    table = header_table("scene", "what it is")
    for descriptions in kinds:
        for name, description in descriptions.items():
            table.add_row(Text(name, no_wrap=True), Text(description))
        table.add_section()
    return Group(table, Text("arrays of wheels; plain switched systems; vehicles, which the command vehicle reads"))


def notes_lines(field: NumberField) -> list[Text]:
    """What a reader must know about the numbers of a scene."""
    return [Text(f"note: {note}") for note in later_notes(field)]


def later_notes(field: NumberField) -> list[str]:
    """What a reader must know about the numbers of a scene, and does not stand above all results."""
    return [note for note in angle_notes(field) if not isinstance(note, FirstRemark)]


def legend() -> RenderableType:
    """What the letters mean."""
    grid = TerminalTable.grid(padding=(0, 2))
    for symbols, meaning in _LEGEND:
        grid.add_row(Text(symbols, "dim", no_wrap=True), Text(meaning, "dim"))
    return grid


def headline(result: Check) -> Text:
    """What is checked."""
    from nonsmooth.symbolic.mechanics.contact_set import wheels_text

    scene = result.scene
    point = exact_place(scene.check.equilibrium)
    head = Text(one_line(scene.name), "bold")
    head.append(f": {wheels_text(scene)}, rule {scene.contact.rule}", "not bold")
    unit = scene.units.after_length
    head.append(f", checked at c* = {point} within {short_text(scene.check.radius)}{unit}", "not bold")
    if scene.check.wider is not None:
        stated = f"{short_text(scene.check.wider)}{unit}"
        head.append(f" (of the {stated} that are stated: farther out other wheels may carry it)", "not bold")
    return head


def _census(result: Check) -> str:
    census = result.census
    counted = [f"{census.possible} possible"]
    if census.singular is not None:
        counted += [f"{census.singular} singular", f"{census.distinct_twists} distinct twists"]
    if result.minimizing_states is not None:
        counted.append(f"{result.minimizing_states} minimizing")
    return f"contact states: {', '.join(counted)}"


def verdict_text(verdict: str, *, bold: bool = False) -> Text:
    """A verdict in its color."""
    style = _STYLES.get(str(verdict), "default")
    return Text(str(verdict), f"bold {style}" if bold else style)


def header_table(*header: str, widest: str | None = None) -> TerminalTable:
    """A table with a header; one column, the last unless another is named, is as wide as there is room."""
    table = TerminalTable(box=box.ROUNDED, header_style="bold")
    for name in header:
        table.add_column(Text(name), overflow="fold", ratio=1 if name == (widest or header[-1]) else None)
    return table


def answers_table(answers: Iterable[tuple[str, str, str]]) -> TerminalTable:
    """Question, answer, and how far, how fast, on what conditions."""
    table = TerminalTable(box=box.ROUNDED, show_header=False, show_lines=True)
    table.add_column(no_wrap=True)
    table.add_column(max_width=ANSWER_WIDTH)
    table.add_column(overflow="fold", ratio=1)
    for question, answer, sentence in answers:
        table.add_row(Text(question, "bold"), verdict_text(answer, bold=True), Text(sentence))
    return table


def two_columns() -> TerminalTable:
    """A table of names and findings without a header."""
    table = TerminalTable(box=box.ROUNDED, show_header=False, show_lines=True)
    table.add_column(overflow="fold")
    table.add_column(overflow="fold", ratio=1)
    return table


def blocks_view(blocks: Iterable[Block]) -> RenderableType:
    """Paragraphs and tables of a result, one below the other.

    Raises:
        TypeError: for another kind of block.
    """
    return Group(*map(_block_view, blocks))


def _block_view(block: Block) -> RenderableType:
    from nonsmooth.reports.output.document import Paragraph, Table, plain_text

    match block:
        case Paragraph(text):
            return Text(plain_text(text))
        case Table(header, rows, widths):
            names = [plain_text(name) for name in header]
            widest = max(range(len(widths)), key=lambda k: (widths[k], k))  # the last of equal ones
            shown = header_table(*names, widest=names[widest]) if header else two_columns()
            for row in rows:
                shown.add_row(*(verdict_text(plain_text(entry)) for entry in row))
            return shown
    raise TypeError(f"required a paragraph or a table, received {type(block).__name__}")
