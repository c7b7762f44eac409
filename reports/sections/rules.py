"""The contact rules side by side in the derivation report: where they prescribe the same motion."""

from __future__ import annotations

from typing import NamedTuple

from nonsmooth.analysis.cells.contact_rule import all_rules, smooth_rule_of
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.minimizers.agreement import Agreement, TwistDifference
from nonsmooth.proofs.boxes.linearization import Linearization
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.reports.checks.agreement import ComparisonResult
from nonsmooth.reports.checks.subject import ArraySubject
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Entry,
    Figure,
    Math,
    Section,
    display,
    matrix,
    number,
    point,
    table,
)
from nonsmooth.reports.output.prose import paragraph, prose
from nonsmooth.reports.sections.contact import askew_slips
from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
from nonsmooth.symbolic.mechanics.scene import Friction
from nonsmooth.symbolic.numbers.number_text import float_text, numbers_text, place_text
from nonsmooth.symbolic.numbers.plane import XY

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
