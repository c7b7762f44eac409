"""What a person reads in a terminal: verdict tables, cell tables and the list of scenes.

Everything is built from :class:`rich.text.Text`, never from markup, because intervals such as ``[a, b]`` and names
from scene files are text.  Verdicts are words first; color repeats them, and only on a terminal.
"""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from nonsmooth.analysis.partitions.partition import Partition
from nonsmooth.proofs.clauses.at_point.ellipse_clauses import EllipseTranslation
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.rotation.on_cells import RotationResult
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.judged_equilibria import JudgedEquilibrium
from nonsmooth.proofs.theorem4_result import Check
from nonsmooth.symbolic.formulas import Real, decimal_text, lower_text, real_text
from nonsmooth.symbolic.numbers.measured_angles import angle_notes
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.scene_error import one_line

ROUNDING = 1e-12  # of a sampled V'/V at gain one: less is noise
VERDICT_WIDTH = 14  # columns: "asymptotically"
MOST_EQUILIBRIA = 6  # that are listed by place
SHORT = 24  # characters of exact text beyond which a decimal value is shown instead

_STYLES = {
    "holds": "green",
    "asymptotically stable": "green",
    "stable": "green",
    "stabilizable": "green",
    "not applicable": "dim",
    "undecided": "yellow",
    "no certificate": "yellow",
    "fails": "red",
    "hypotheses not met": "red",
}
_LEGEND = (
    ("c, v, omega", "centre of mass measured from the checked point c*, its velocity, rotation rate"),
    ("F", "Filippov set: hull of the velocities of all closed cells that hold a point"),
    ("V*", "upper derivative: the largest rate of V = |c|^2 over F"),
    ("d_i, p_i, u_i, J", "rim direction, position and speed of wheel i; quarter turn"),
    ("xi, k, n_i", "motion (v, omega); feedback gain; J d_i"),
)


def check_view(result: Check) -> RenderableType:
    """The verdict of Theorem 4, clause by clause, with its evidence."""
    table = header_table("clause", "verdict", "evidence")
    table.show_lines = True
    table.columns[1].max_width = VERDICT_WIDTH
    rows = (
        ("equilibrium", result.equilibrium.verdict, _equilibrium_evidence(result)),
        ("translation", result.translation.verdict, _translation_evidence(result.translation)),
        ("rotation", result.rotation.verdict, _rotation_evidence(result.rotation)),
        ("feedback", result.feedback.verdict, _feedback_evidence(result)),
    )
    for name, verdict, evidence in rows:
        table.add_row(Text(name), verdict_text(verdict), Text("\n".join(evidence)))
    table.add_row(Text("Theorem 4", "bold"), verdict_text(result.verdict, bold=True), Text(result.reason))
    left_out = [Text(f"left out: {s.what} ({s.count}): {s.why}") for s in result.skipped]
    return Group(_headline(result), Text(_census(result)), table, *left_out)


def partition_view(partition: Partition) -> RenderableType:
    """The cells with their rows and twists."""
    table = header_table("cell", "rows held", "v_x", "v_y", "omega", "area")
    for cell in partition.cells:
        for k, state in enumerate(cell.states):
            index, area = (str(cell.index), brief(cell.polygon.area)) if k == 0 else ("", "or")
            twist = [Text(brief(entry)) for entry in state.twist]
            table.add_row(Text(index), Text(state.name), *twist, Text(area))
    exact = "the cells tile the square" if partition.tiles else "the cells do not tile the square"
    head = f"{one_line(partition.scene.name)}: {len(partition.cells)} cells, {len(partition.states)} contact states"
    return Group(
        Text(f"{head}, rule {partition.rule}"),
        table,
        Text(f"area of the square minus area of the cells: {brief(partition.area_error)} ({exact})"),
        Text("R1 and S1 are the roll and side row of wheel 1; (v_x, v_y) is the body's velocity at the world origin"),
        *notes_lines(partition.scene.field),
    )


def scenes_view(descriptions: dict[str, str]) -> RenderableType:
    """The built-in scenes."""
    table = header_table("scene", "what it is")
    for name, description in descriptions.items():
        table.add_row(Text(name, no_wrap=True), Text(description))
    return table


def notes_lines(field: NumberField) -> list[Text]:
    """What a reader must know about the numbers of a scene."""
    return [Text(f"note: {note}") for note in angle_notes(field)]


def legend() -> RenderableType:
    """What the letters mean."""
    grid = Table.grid(padding=(0, 2))
    for symbols, meaning in _LEGEND:
        grid.add_row(Text(symbols, "dim", no_wrap=True), Text(meaning, "dim"))
    return grid


def brief(number: Real) -> str:
    """Exact where that is short, six digits otherwise."""
    text = real_text(number)
    return text if len(text) <= SHORT else f"~{decimal_text(number, 6)}"


def _headline(result: Check) -> Text:
    scene = result.scene
    x, y = (brief(entry) for entry in scene.check.equilibrium)
    head = Text(one_line(scene.name), "bold")
    head.append(f": {len(scene.wheels)} wheels, rule {scene.contact.rule}", "not bold")
    return head.append(f", checked at c* = ({x}, {y}) within {brief(scene.check.radius)}", "not bold")


def _census(result: Check) -> str:
    census = result.census
    counted = [f"{census.possible} possible"]
    if census.singular is not None:
        counted += [f"{census.singular} singular", f"{census.distinct_twists} distinct twists"]
    if result.minimizing_states is not None:
        counted.append(f"{result.minimizing_states} minimizing")
    return f"contact states: {', '.join(counted)}"


def _equilibrium_evidence(result: Check) -> list[str]:
    lines = [result.equilibrium.reason]
    others = result.other_equilibria
    if others is not None:
        shown = [_equilibrium(e) for e in others[:MOST_EQUILIBRIA]]
        more = [f"and {len(others) - MOST_EQUILIBRIA} more"] * (len(others) > MOST_EQUILIBRIA)
        lines.append(f"other equilibria in the square: {'; '.join(shown + more) or 'none'}")
    return lines


def _equilibrium(judged: JudgedEquilibrium) -> str:
    place = f"{judged.found.place} at {', '.join(_point(p) for p in judged.found.points)}"
    return place if judged.translation is None else f"{place} ({judged.translation})"


def _point(point: tuple[Real, Real]) -> str:
    return f"({brief(point[0])}, {brief(point[1])})"


def _translation_evidence(translation: TranslationResult | EllipseTranslation) -> list[str]:
    lines = [translation.reason]
    sampled = translation.sampled
    if sampled is not None:
        if sampled.largest_relative is not None:
            rate = f"{sampled.largest_relative:.6g}"
            lines.append(f"largest V*/|c| at {sampled.samples} sampled points of the square: {rate}")
        if sampled.not_certified:
            lines.append(f"largest V*/|c| over the square not certified: {sampled.not_certified}")
    elif translation.worst_rate is not None:
        lines.append(f"max V*/|c| = {brief(translation.worst_rate)} on the square")
    quadratic = translation.quadratic
    if quadratic is not None:
        lines.append(f"V = {quadratic} decreases: V* <= -{float(quadratic.decay):.4g} |c|")
        lines.append(f"region: V < {brief(quadratic.level)}")
    if translation.region_radius is not None:
        lines.append(f"region: disc of radius {brief(translation.region_radius)}")
    if isinstance(translation, TranslationResult) and translation.support_note:
        lines.append(translation.support_note)
    return lines


def _rotation_evidence(rotation: RotationResult) -> list[str]:
    lines = [rotation.reason]
    if rotation.drift is not None:
        low, high = (float(end) for end in rotation.drift.interval)
        lines.append(f"drift at rest: [{low:.6g}, {high:.6g}]")
    return lines


def _feedback_evidence(result: Check) -> list[str]:
    feedback = result.feedback
    lines = [feedback.reason]
    if feedback.law is not None:
        lines.append(feedback.law)
    if isinstance(feedback, DrivenFeedback):
        lines += _driven_evidence(feedback)
    if isinstance(feedback, FeedbackResult) and feedback.rate is not None:
        reach = feedback.rate.reach
        where = "near c*" if reach is None else f"where |c| <= {decimal_text(result.scene.field(reach), 3)}"
        lines.append(f"{where}: V' <= -{lower_text(2 * feedback.rate.kappa, 4)} k V (certified)")
        lines.append(f"V = {feedback.lyapunov}")
    if isinstance(feedback, FeedbackResult) and feedback.law is not None:
        where = "near c*; how near is not known" if feedback.region is None else str(feedback.region)
        lines.append(f"certified region: {where}")
    if isinstance(feedback, FeedbackResult) and feedback.margin is not None:
        lines.append(str(feedback.margin))
    if isinstance(feedback, FeedbackResult) and feedback.printed_sign_fails:
        lines.append(f"the paper's u_j = -k theta has the wrong sign in {_cells(feedback.printed_sign_fails)}")
    lines.append(f"torque authority: rank {result.authority.rank} of 3")
    return lines


def _driven_evidence(feedback: DrivenFeedback) -> list[str]:
    """Twists, certified rate and samples under the rules ``box`` and ``ellipse``."""
    lines: list[str] = []
    if len(feedback.cones) > 1:
        lines.append(f"xi_l: by direction of c, {len(feedback.cones)} cones; the report and --json list them")
    elif feedback.cones:
        twists = (", ".join(f"{float(x):.4g}" for x in twist) for twist in feedback.cones[0].vectors)
        lines.append("xi_l = " + ", ".join(f"({twist})" for twist in twists))
    if feedback.kappa is not None:
        reach = feedback.reach
        where = "near c*" if reach is None else f"where |x|, |y| < {lower_text(reach, 3)}"
        lines += [f"{where}: V' <= -{lower_text(2 * feedback.kappa, 4)} k V (certified)", "V = |c|^2 + theta^2"]
    for sample in feedback.samples:
        if sample.worst_rate is not None:
            rate = f"{sample.worst_rate:.3g}" if abs(sample.worst_rate) > ROUNDING else "0"
            lines.append(f"{sample.law} (sampled): largest V'/V found {rate} k over {sample.states} states")
        if sample.not_certified:
            lines.append(f"{sample.law} (sampled): largest V'/V not certified: {sample.not_certified}")
    return lines


def _cells(indices: Sequence[int]) -> str:
    shown = ", ".join(str(index) for index in indices[:12]) + (", ..." if len(indices) > 12 else "")
    return f"{len(indices)} cells ({shown})" if len(indices) > 1 else f"cell {shown}"


def verdict_text(verdict: str, *, bold: bool = False) -> Text:
    """A verdict in its color."""
    style = _STYLES.get(str(verdict), "default")
    return Text(str(verdict), f"bold {style}" if bold else style)


def header_table(*header: str, widest: str | None = None) -> Table:
    """A table with a header; one column, the last unless another is named, is as wide as there is room."""
    table = Table(box=box.ROUNDED, header_style="bold")
    for name in header:
        table.add_column(Text(name), overflow="fold", ratio=1 if name == (widest or header[-1]) else None)
    return table


def two_columns() -> Table:
    """A table of names and findings without a header."""
    table = Table(box=box.ROUNDED, show_header=False, show_lines=True)
    table.add_column(overflow="fold")
    table.add_column(overflow="fold", ratio=1)
    return table
