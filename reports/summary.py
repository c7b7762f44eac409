"""The command ``check`` for many scenes: one line each, all records, and the worst exit status."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.systems.system_stability import system_check
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.console import BAD_INPUT, UNDECIDED
from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.progress import progress
from nonsmooth.reports.records import CHECK_SCHEMA, check_record
from nonsmooth.reports.system_views import system_record
from nonsmooth.reports.terminal import header_table, verdict_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem

COLUMNS = ("scene", "rule", "verdict", "reason")
WORST_FIRST = (BAD_INPUT, 1, UNDECIDED)
NONE = "-"  # the contact rule of a plain system
REFUSED = "refused"


@dataclass(frozen=True)
class Line:
    """One scene under one rule.

    Attributes:
        origin: file or built-in name.
        rule: the contact rule; a dash for a plain system.
        verdict: of Theorem 4; of stability for a plain system; or that it was refused.
        reason: one sentence.
        status: the exit status that the scene alone would give.
        record: JSON.
    """

    origin: str
    rule: str
    verdict: str
    reason: str
    status: int
    record: Record


def check_all(scenes: Sequence[Scene | SwitchedSystem], *, prune: bool) -> tuple[Line, ...]:
    """Check one scene after the other; a scene that is refused stops no other."""
    lines = []
    with progress("checked") as report:
        for done, scene in enumerate(scenes):
            report(done, len(scenes))
            lines.append(_system_line(scene) if isinstance(scene, SwitchedSystem) else _array_line(scene, prune=prune))
    return tuple(lines)


def _array_line(scene: Scene, *, prune: bool) -> Line:
    rule = str(scene.contact.rule)
    try:
        result = verified(check_theorem4(scene, prune=prune))
    except RefusalError as error:
        refusal = one_line(str(error))
        record = {"schema": CHECK_SCHEMA, "scene": scene.name, "rule": rule, "refused": refusal}
        return Line(scene.origin, rule, REFUSED, refusal, BAD_INPUT, record)
    verdict = result.verdict
    return Line(scene.origin, rule, str(verdict), result.reason, verdict.exit_status, check_record(result))


def _system_line(scene: SwitchedSystem) -> Line:
    result = verified(system_check(scene))
    return Line(scene.origin, NONE, str(result.verdict), result.reason, result.exit_status, system_record(result))


def worst_status(lines: Iterable[Line]) -> int:
    """Refused, else not holding, else undecided, else 0."""
    found = {line.status for line in lines}
    return next((status for status in WORST_FIRST if status in found), 0)


def summary_view(lines: Sequence[Line]) -> RenderableType:
    """A table with one row per scene and rule, and how many there are of each verdict."""
    table = header_table(*COLUMNS)
    for line in lines:
        place = Text(one_line(line.origin), overflow="fold")
        table.add_row(place, Text(line.rule, no_wrap=True), verdict_text(line.verdict), Text(line.reason))
    return Group(table, Text(_counted(lines)))


def _counted(lines: Sequence[Line]) -> str:
    """``Theorem 4: 5 holds, 2 fails; plain systems: 1 stable``."""
    arrays = Counter(line.verdict for line in lines if line.rule != NONE)
    systems = Counter(line.verdict for line in lines if line.rule == NONE)
    groups = (("Theorem 4", arrays), ("plain systems", systems))
    return "; ".join(f"{name}: {', '.join(f'{n} {word}' for word, n in c.most_common())}" for name, c in groups if c)
