"""Sections of the derivation report on contact: constraints, contact states with their equations."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from nonsmooth.analysis.cells.contact_rule import all_rules, rule_of, smooth_rule_of
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.minimizers.agreement import Agreement, TwistDifference
from nonsmooth.analysis.minimizers.minimum import Functional, functional_of
from nonsmooth.proofs.boxes.linearization import Linearization
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.theorem4 import CellCheck
from nonsmooth.reports.checks.agreement import ComparisonResult
from nonsmooth.reports.checks.cells import CellsResult
from nonsmooth.reports.checks.subject import ArraySubject
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Display,
    Entry,
    Figure,
    Math,
    Section,
    Text,
    cell_mark,
    display,
    matrix,
    number,
    point,
    table,
)
from nonsmooth.reports.output.prose import listed, paragraph, prose
from nonsmooth.symbolic.formulas.surfaces import number_latex
from nonsmooth.symbolic.mechanics.contact_states import ContactState, askew_wheels, constraint_matrix
from nonsmooth.symbolic.mechanics.equations import Coordinates, GoverningEquations, governing_equations
from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
from nonsmooth.symbolic.mechanics.scene import Friction, Wheel
from nonsmooth.symbolic.numbers.number_text import float_text, numbers_text, place_text, real_text
from nonsmooth.symbolic.numbers.plane import XY

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


# ---- what the rule says --------------------------------------------------------------------------
#
# The contact rules side by side in the derivation report: where they prescribe the same motion.


MOST_WHEELS = 24  # up to which the cells of rule box take a second or two; 36 wheels have some 450 cells


def without_rules(subject: ArraySubject) -> str:
    """Why the rules are not compared; empty where they are."""
    if len(subject.scene.wheels) > MOST_WHEELS:
        command = subject.invocation.line("partition", "--compare")
        return f"rule box is compared for at most {MOST_WHEELS} wheels here; {command} has no such limit"
    try:
        _ = subject.agreement
    except LoadError as error:
        *first, last = (rule.name for rule in all_rules() if rule.needs_loads)
        return f"rules {', '.join(first)} and {last} refuse the scene: {error}"
    except RefusalError as error:
        return f"not every rule determines a motion: {error}"
    return ""


def rules_section(subject: ArraySubject) -> Section:
    """Cells, agreement and largest differences of all rules."""
    agreement = subject.agreement
    blocks: list[Block] = [_rules_list(subject, agreement), _agreement_map(subject)]
    for (first, second), shared in agreement.shared.items():
        words = (
            "{} and {} prescribe the same set of twists on a share of {} of the area, exactly, "
            "with {} twists in common."
        )
        count = str(len(shared.shared_twists))
        blocks.append(paragraph(words, first.capitalize(), second, number(shared.share), count))
    header = ("rules", "mean difference", "largest difference", "near (x, y)")
    blocks.append(table(header, [_row(*pair, found) for pair, found in agreement.differences.items()], (3, 2, 2, 3)))
    sampled = list(agreement.differences.values())[-1]
    blocks.append(
        paragraph(
            "Sampled at {} points: the difference of the twists in the norm {}, R the distance of the farthest wheel, "
            "relative to the larger one.",
            str(sampled.points),
            prose("`sqrt(|v|^2 + (R omega)^2)`")[0],
        )
    )
    if sampled.not_certified:
        blocks.append(paragraph("Elsewhere not certified: {}.", sampled.not_certified))
    return Section("The contact rules side by side", tuple(blocks))


def _rules_list(subject: ArraySubject, agreement: Agreement) -> Bullets:
    """What each rule is, and how many cells it has."""
    items = []
    for rule in all_rules(subject.scene):
        partition = agreement.partitions.get(rule.name)
        count = 0 if partition is None else len(partition.cells)
        cells = "1 cell" if count == 1 else f"{count} cells" if count else "no cells, a continuous field"
        items.append(prose(f"Rule {rule.name}: {rule.summary} ({cells})."))
    return Bullets(tuple(items))


def _row(first: str, second: str, difference: TwistDifference) -> tuple[Entry, ...]:
    if difference.mean is None or difference.largest is None or difference.at is None:
        return f"{first} and {second}", "not certified", "", ""
    x, y = difference.at
    place = place_text((x, y), 4)
    return f"{first} and {second}", float_text(difference.mean, 3), float_text(difference.largest, 3), place


def _agreement_map(subject: ArraySubject) -> Figure:
    agreement: Agreement = subject.agreement
    rules = "the rules " + ", or ".join(f"{first} and {second}" for first, second in agreement.shared)
    return Figure(
        "agreement-map",
        prose(f"Where {rules} prescribe the same motion, in the coordinates of the scene."),
        f"Map of the square, shaded by whether {rules} prescribe the same motion.",
        subject.invocation.line("partition", "--compare", "-o", "agreement.pdf"),
        ComparisonResult(agreement).content,
    )


# ---- rules without cells -------------------------------------------------------------------------


class _Losses(NamedTuple):
    """The dissipation of one wheel per unit of load: in words, in LaTeX and as plain text."""

    words: str
    latex: str
    text: str


_SLIPS_LATEX = r"\qquad r_i = d_i \cdot v(p_i) - u_i, \quad s_i = n_i \cdot v(p_i)"
_SLIPS = "r_i = d_i . v(p_i) - u_i, s_i = n_i . v(p_i)"
_ELLIPSE = _Losses(
    "with the friction ellipse of Fig. 3",
    r"\sqrt{\mu_R^2 r_i^2 + \mu_S^2 s_i^2}",
    "sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)",
)
_TURNING = _Losses(
    "with rollers that stand or turn at the speed t",
    r"\min_t \left(\mu_R |(r_i, s_i - t)| + \mu_S |t|\right)",
    "min_t (mu_R |(r_i, s_i - t)| + mu_S |t|)",
)
_STANDING = _Losses("with rollers that never turn", r"\mu_R \sqrt{r_i^2 + s_i^2}", "mu_R sqrt(r_i^2 + s_i^2)")


def losses_of(limits: FrictionSet, friction: Friction) -> _Losses:
    """The support function of the forces that a wheel can carry."""
    if limits.is_cut:
        return _TURNING
    return _ELLIPSE if limits.across == friction.side else _STANDING


def _functional(place: EllipsePoint) -> tuple[Block, ...]:
    """What the motion minimizes, in words and as a formula; one for each kind of wheel where there are several."""
    rule = smooth_rule_of(place.scene)
    wheels: dict[_Losses, list[int]] = {}
    for wheel in place.scene.wheels:
        wheels.setdefault(losses_of(rule.friction_set(wheel.friction), wheel.friction), []).append(wheel.index)
    if len(wheels) == 1:
        (losses,) = wheels
        return paragraph(f"The motion minimizes the dissipation of sec. 2 {losses.words}:"), display(
            rf"D(\xi) = \sum_i N_i {losses.latex}, {_SLIPS_LATEX}", f"D(xi) = sum_i N_i {losses.text}, {_SLIPS}"
        )
    blocks: list[Block] = [
        paragraph("The motion minimizes the dissipation of sec. 2, of each wheel with its own friction:"),
        display(rf"D(\xi) = \sum_i N_i h_i, {_SLIPS_LATEX}", f"D(xi) = sum_i N_i h_i, {_SLIPS}"),
    ]
    for losses, numbers in wheels.items():
        which = "wheel" if len(numbers) == 1 else "wheels"
        blocks.append(paragraph(f"Of {which} {numbers_text(tuple(numbers))}, {losses.words}:"))
        blocks.append(display(f"h_i = {losses.latex}", f"h_i = {losses.text}"))
    return tuple(blocks)


def situation_section(place: EllipsePoint) -> Section:
    """The functional, the loads and the exact minimizer at the checked point."""
    blocks: list[Block] = [
        *_functional(place),
        *askew_slips(place.scene.wheels),
        paragraph(
            "At the checked point: {}. Reason: {}. The loads there, for total weight 1:", place.situation, place.reason
        ),
        _load_table(place),
    ]
    if place.twist is not None:
        words = "The minimizer there is the twist `xi = (v, omega)` = {}."
        blocks.append(paragraph(words, point(place.twist)))
    if place.held:
        blocks += _stuck_blocks(place)
    if place.linearization is not None:
        blocks += _linearization_blocks(place.linearization)
    return Section("Motion at the checked point", tuple(blocks))


def _load_table(place: EllipsePoint) -> Block:
    rows: list[tuple[Entry, ...]] = [
        (str(wheel.index), number(form[0]), number(form[1]), number(form[2]))
        for wheel, form in zip(place.scene.wheels, place.region.forces, strict=True)
    ]
    header = ("wheel", prose("`N_i` at `c = 0`"), "change along x", "change along y")
    return table(header, rows, (1, 2, 2, 2))


def _stuck_blocks(place: EllipsePoint) -> list[Block]:
    rows: list[tuple[Entry, ...]] = [
        (str(force.wheel), number(force.along), number(force.across), number(force.squared)) for force in place.held
    ]
    words = paragraph("Forces of the wheels that are held, in units of their friction limits (squared size up to 1):")
    return [words, table(("wheel", "along the rim", "across it", "squared size"), rows, (1, 2, 2, 2))]


def _linearization_blocks(linear: Linearization) -> list[Block]:
    hessian, slope = matrix(linear.hessian), matrix(zip(*linear.slope, strict=True))
    motion = matrix(linear.translation)
    blocks: list[Block] = [
        paragraph(
            "D is smooth there, so to first order `xi` is linear in `c`, with the Hessian H of D and its slope G:"
        ),
        display(f"H = {hessian.latex}, \\qquad G = {slope.latex}", f"H = {hessian.plain}, G = {slope.plain}"),
        display(rf"\dot c = A c, \qquad A = {motion.latex}", f"c' = A c, A = {motion.plain}"),
        paragraph(
            "Trace {}, determinant {}, largest real part of the eigenvalues {}.",
            number(linear.trace),
            number(linear.determinant),
            number(linear.spectral_abscissa),
        ),
    ]
    if not linear.omega and linear.determinant:
        x, y = (number(entry) for entry in linear.rotation_map)
        blocks.append(
            display(
                rf"\theta_\infty - \theta_0 = \left({x.latex}\right) x_0 + \left({y.latex}\right) y_0",
                f"theta_inf - theta_0 = ({x.plain}) x_0 + ({y.plain}) y_0",
            )
        )
    return blocks


def ellipse_derivative_section(translation: EllipseTranslation) -> Section:
    """What is known of V* over the square: a lemma, or samples."""
    if translation.lemma is not None:
        words = paragraph(
            "All wheels lie on one circle about the checked point with rims inward, equal `mu_R` and positive "
            "speeds, so `V* <= 0` on the whole square with `V = |c - c*|^2`, for every `mu_S`."
        )
        return Section("Upper derivative", (words,))
    if translation.sampled is None:
        return Section("Upper derivative", (paragraph("`V*` is not known away from the checked point."),))
    sampled = translation.sampled
    blocks: list[Block] = []
    if sampled.largest_relative is not None and sampled.at is not None:
        blocks.append(_sampled_paragraph(sampled.samples, sampled.largest_relative, sampled.at))
    if sampled.not_certified:
        blocks.append(paragraph("The largest `V*/|c|` over the square is not certified: {}.", sampled.not_certified))
    return Section("Upper derivative", tuple(blocks))


def _sampled_paragraph(samples: int, largest: float, at: XY) -> Block:
    x, y = at
    place, rate = place_text((x, y)), float_text(largest)
    return paragraph(
        "With `V = |c - c*|^2`, sampled and not proved: the largest `V*/|c|` at {} random points of the square "
        "is {}, at {}.",
        str(samples),
        Math(rate, rate),
        Math(place, place),
    )
