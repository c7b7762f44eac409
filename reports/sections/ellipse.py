"""Rules without cells in the derivation report: what the body does at the checked point, and the motion near it."""

from __future__ import annotations

from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.proofs.boxes.linearization import Linearization
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.reports.document import Block, Entry, Math, Section, display, matrix, number, point, table
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.symbolic.number_text import float_text, place_text


def _functional(place: EllipsePoint) -> tuple[Block, Block]:
    """What the motion minimizes, in words and as a formula."""
    rule = smooth_rule_of(place.scene)
    if any(rule.friction_set(wheel.friction).is_cut for wheel in place.scene.wheels):
        words = "The motion minimizes the dissipation of sec. 2 with rollers that stand or turn at the speed t:"
        return paragraph(words), display(
            r"D(\xi) = \sum_i N_i \min_t \left(\mu_R |(r_i, s_i - t)| + \mu_S |t|\right), \qquad"
            r" r_i = d_i \cdot v(p_i) - u_i, \quad s_i = n_i \cdot v(p_i)",
            "D(xi) = sum_i N_i min_t (mu_R |(r_i, s_i - t)| + mu_S |t|), r_i = d_i . v(p_i) - u_i, s_i = n_i . v(p_i)",
        )
    words = "The motion minimizes the dissipation of sec. 2 with the friction ellipse of Fig. 3:"
    return paragraph(words), display(
        r"D(\xi) = \sum_i N_i \sqrt{\mu_R^2 r_i^2 + \mu_S^2 s_i^2}, \qquad r_i = d_i \cdot v(p_i) - u_i, \quad"
        r" s_i = n_i \cdot v(p_i)",
        "D(xi) = sum_i N_i sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2), r_i = d_i . v(p_i) - u_i, s_i = n_i . v(p_i)",
    )


def situation_section(place: EllipsePoint) -> Section:
    """The functional, the loads and the exact minimizer at the checked point."""
    blocks: list[Block] = [
        *_functional(place),
        paragraph(
            "At the checked point: {}. Reason: {}. The loads there, for total weight 1:", place.situation, place.reason
        ),
        _load_table(place),
    ]
    if place.twist is not None:
        words = "The minimizer there is the twist `xi = (v, omega)` = {}."
        blocks.append(paragraph(words, point(place.twist)))
    if place.balance.stuck:
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
        (str(force.wheel), number(force.along), number(force.across), number(force.squared))
        for force in place.balance.stuck or ()
    ]
    words = paragraph("Forces of the wheels that stick, in units of their friction limits (squared size up to 1):")
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


def _sampled_paragraph(samples: int, largest: float, at: tuple[float, float]) -> Block:
    x, y = at
    place, rate = place_text((x, y)), float_text(largest)
    return paragraph(
        "With `V = |c - c*|^2`, sampled and not proved: the largest `V*/|c|` at {} random points of the square "
        "is {}, at {}.",
        str(samples),
        Math(rate, rate),
        Math(place, place),
    )
