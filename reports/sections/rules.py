"""The contact rules side by side in the derivation report: where they prescribe the same motion."""

from __future__ import annotations

from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.contact_rule import all_rules
from nonsmooth.analysis.minimizers.agreement import Agreement, TwistDifference
from nonsmooth.reports.agreement import ComparisonResult
from nonsmooth.reports.document import Block, Bullets, Entry, Figure, Section, number, table
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.reports.subject import ArraySubject
from nonsmooth.symbolic.number_text import float_text, place_text

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
