"""The three contact rules side by side in the derivation report: where they prescribe the same motion."""

from __future__ import annotations

from nonsmooth.analysis.minimizers.agreement import Agreement, TwistDifference
from nonsmooth.analysis.partitions.partition import RefusalError
from nonsmooth.reports.document import Block, Entry, Figure, Section, number, table
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.reports.subject import Subject

MOST_WHEELS = 24  # up to which the cells of rule box take a second or two; 36 wheels have some 450 cells


def without_rules(subject: Subject) -> str:
    """Why the rules are not compared; empty where they are."""
    if len(subject.scene.wheels) > MOST_WHEELS:
        command = subject.invocation.line("partition", "--compare")
        return f"rule box is compared for at most {MOST_WHEELS} wheels here; {command} has no such limit"
    try:
        _ = subject.agreement
    except RefusalError as error:
        return f"rules box and ellipse refuse the scene: {error}"
    return ""


def rules_section(subject: Subject) -> Section:
    """Cells, agreement and largest differences of the rules nearest, box and ellipse."""
    agreement = subject.agreement
    shared = agreement.shared
    blocks: list[Block] = [
        paragraph(
            "Rule nearest holds the rows of the nearest wheels; rule box minimizes the dissipation with friction "
            "limited along and across the rim apart; rule ellipse minimizes it with the friction ellipse. "
            "Nearest has {} cells in the square, box {}, ellipse a continuous field wherever the minimizer is unique.",
            str(len(agreement.nearest.cells)),
            str(len(agreement.box.cells)),
        ),
        _agreement_map(subject),
        paragraph(
            "Nearest and box prescribe the same set of twists on a share of {} of the area, exactly, with {} twists "
            "in common.",
            number(shared.share),
            str(len(shared.shared_twists)),
        ),
        table(
            ("rules", "mean difference", "largest difference", "near (x, y)"),
            [_row("nearest", agreement.ellipse_nearest), _row("box", agreement.ellipse_box)],
            (3, 2, 2, 3),
        ),
        paragraph(
            "Sampled at {} points: the difference of the twists in the norm {}, R the distance of the farthest wheel, "
            "relative to the larger one.",
            str(agreement.ellipse_box.points),
            prose("`sqrt(|v|^2 + (R omega)^2)`")[0],
        ),
    ]
    if agreement.ellipse_box.not_certified:
        blocks.append(paragraph("Elsewhere not certified: {}.", agreement.ellipse_box.not_certified))
    return Section("The three contact rules side by side", tuple(blocks))


def _row(other: str, difference: TwistDifference) -> tuple[Entry, ...]:
    if difference.mean is None or difference.largest is None or difference.at is None:
        return f"ellipse and {other}", "not certified", "", ""
    x, y = difference.at
    place = f"({x:.4g}, {y:.4g})"
    return f"ellipse and {other}", f"{difference.mean:.3g}", f"{difference.largest:.3g}", place


def _agreement_map(subject: Subject) -> Figure:
    agreement: Agreement = subject.agreement

    def draw() -> bytes:
        from nonsmooth.reports.agreement_views import agreement_map

        return agreement_map(agreement, ".svg")

    return Figure(
        "agreement-map",
        prose("Where the rules nearest and box prescribe the same motion, in the coordinates of the scene."),
        "Map of the square, shaded by whether rules nearest and box prescribe the same motion.",
        subject.invocation.line("partition", "--compare", "-o", "agreement.pdf"),
        draw,
    )
