"""The command ``check`` for many scenes: one line each, all records, and the worst exit status."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.answers.answers import exit_status, full_answers
from nonsmooth.proofs.answers.contradictions import reconciled
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.console import BAD_INPUT, UNDECIDED
from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.interface.tipped_result import TippedResult
from nonsmooth.reports.progress import progress
from nonsmooth.reports.records import CHECK_SCHEMA, check_record
from nonsmooth.reports.system_views import system_record
from nonsmooth.reports.terminal import header_table, verdict_text
from nonsmooth.symbolic.contact_set import TipsError
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import SceneError, one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem

COLUMNS = ("scene", "rule", "position", "heading", "pose", "Theorem 4")
WORST_FIRST = (BAD_INPUT, 1, UNDECIDED)
NONE = "-"  # the contact rule of a plain system, and what is not asked of it
REFUSED = "refused"


@dataclass(frozen=True)
class SummaryLine:
    """One scene under one rule.

    Attributes:
        origin: file or built-in name.
        rule: the contact rule; a dash for a plain system.
        answers: of position, heading and pose; of a plain system its stability.
        theorem: the verdict of Theorem 4; a dash for a plain system.
        refusal: why the scene was refused; empty where it was not.
        status: the exit status that the scene alone would give.
        record: JSON.
    """

    origin: str
    rule: str
    answers: tuple[str, ...]
    theorem: str
    refusal: str
    status: int
    record: Record


def check_all(
    scenes: Sequence[Scene | SwitchedSystem], required: Sequence[str], *, prune: bool, records: bool
) -> tuple[SummaryLine, ...]:
    """Check one scene after the other; a scene that is refused stops no other.

    Args:
        scenes: arrays and plain systems.
        required: the answers that exit status 0 asks for.
        prune: leave out what no verdict needs.
        records: build the JSON records too.
    """
    lines = []
    with progress("checked") as report:
        for done, scene in enumerate(scenes):
            report(done, len(scenes))
            if isinstance(scene, SwitchedSystem):
                lines.append(_system_line(scene))
            else:
                lines.append(_array_line(scene, required, prune=prune, records=records))
    return tuple(lines)


def _array_line(scene: Scene, required: Sequence[str], *, prune: bool, records: bool) -> SummaryLine:
    rule = str(scene.contact.rule)
    try:
        result = verified(check_theorem4(scene, prune=prune))
    except TipsError as tipping:
        tipped = TippedResult(scene, tipping)
        tips = (str(tipped.position.verdict), *(NONE,) * 2)
        return SummaryLine(
            scene.origin, rule, tips, tipped.theorem4, "", tipped.exit_status(required), tipped.to_dict()
        )
    except (RefusalError, SceneError) as error:
        refusal = one_line(str(error))
        record: Record = {"schema": CHECK_SCHEMA, "scene": scene.name, "rule": rule, "refused": refusal}
        return SummaryLine(scene.origin, rule, (REFUSED,), NONE, refusal, BAD_INPUT, record)
    result, answered = reconciled(result, full_answers(result) if records else None)
    answers = tuple(str(answer.verdict) for answer in answered.answers)
    record = check_record(result, answered) if records else {}
    return SummaryLine(scene.origin, rule, answers, str(result.verdict), "", exit_status(result, required), record)


def _system_line(scene: SwitchedSystem) -> SummaryLine:
    result = verified(decide_system(scene))
    return SummaryLine(scene.origin, NONE, (str(result.verdict),), NONE, "", result.exit_status, system_record(result))


def worst_status(lines: Iterable[SummaryLine]) -> int:
    """Refused, else not holding, else undecided, else 0."""
    found = {line.status for line in lines}
    return next((status for status in WORST_FIRST if status in found), 0)


def summary_view(lines: Sequence[SummaryLine]) -> RenderableType:
    """A table with one row per scene and rule, why scenes were refused, and how many there are of each verdict."""
    table = header_table(*COLUMNS, widest="scene")
    for line in lines:
        said = [*line.answers, *(NONE,) * (len(COLUMNS) - 3 - len(line.answers)), line.theorem]
        place = Text(one_line(line.origin), overflow="fold")
        table.add_row(place, Text(line.rule, no_wrap=True), *map(verdict_text, said))
    refused = [
        Text(f"refused: {one_line(line.origin)}, rule {line.rule}: {line.refusal}") for line in lines if line.refusal
    ]
    return Group(table, *refused, Text(_counted(lines)))


def _counted(lines: Sequence[SummaryLine]) -> str:
    """``position: 5 comes home, 2 leaves; Theorem 4: 5 holds, 2 fails; plain systems: 1 stable``."""
    arrays = [line for line in lines if line.rule != NONE]
    groups = (
        ("position", Counter(line.answers[0] for line in arrays)),
        ("Theorem 4", Counter(line.theorem for line in arrays if line.theorem != NONE)),
        ("plain systems", Counter(line.answers[0] for line in lines if line.rule == NONE)),
    )
    return "; ".join(f"{name}: {', '.join(f'{n} {word}' for word, n in c.most_common())}" for name, c in groups if c)
