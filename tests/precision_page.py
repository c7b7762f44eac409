"""The measured parts of ``docs/precision.md`` and its figure: ``python -m tests.precision_page docs``.

The page keeps its text; what stands between ``<!-- machine -->``, ``<!-- studies -->`` or ``<!-- pruning -->`` and the
next ``<!-- end -->`` is measured anew.  Errors, slopes and verdicts are the same on every machine up to rounding; times
are those of the machine that wrote them, and the page says so.
"""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from nonsmooth.analysis.measurements.harness import FittedSlope, Limits, Measured, ResultRow, Run, Study, measure
from nonsmooth.proofs.measurements import PRUNED, PRUNING, STUDIES, WHOLE
from nonsmooth.reports.checks.measurements import Precision, error_text, setting_text
from nonsmooth.reports.output.files import output_path, write_whole
from nonsmooth.reports.output.progress import ProgressCall, progress
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.number_text import measured_text

SHOWN = "four-wheel"
LIMITS = Limits()
PRUNING_LIMITS = Limits(runs=2, seconds=10.0)  # a whole check is one long trial

MEASURED = re.compile(r"(?s)(<!-- (machine|studies|pruning) -->\n).*?(?=<!-- end -->)")


def write_page(folder: Path, report: ProgressCall) -> Path:
    """Measure, and write ``precision.md`` and its figure into a folder.

    Raises:
        KeyboardInterrupt: where the work is interrupted; then nothing is written.
    """
    shown = _whole(SHOWN, [study for study in STUDIES if study is not PRUNING], LIMITS, report)
    pruned = [_whole(name, [PRUNING], PRUNING_LIMITS, report) for name in builtin_scenes()]
    figure, page = folder / "precision" / f"{SHOWN}.svg", folder / "precision.md"
    figure.parent.mkdir(exist_ok=True)
    write_whole(output_path(str(figure), (".svg",)), Precision(shown).content(".svg"))
    text = page_text(page.read_text(encoding="utf-8"), shown, pruned)
    write_whole(output_path(str(page), (".md",)), text.encode())
    return page


def _whole(name: str, studies: Sequence[Study], limits: Limits, report: ProgressCall) -> Run:
    found = measure(load_scene(name), studies, limits, report)
    if not found.complete:
        raise KeyboardInterrupt
    return found


def page_text(page: str, shown: Run, pruned: Sequence[Run]) -> str:
    """The page with its measured parts replaced."""
    studies = "\n".join(part for measured in shown.measured for part in _study(measured))
    parts = {"machine": _machine(shown), "studies": studies, "pruning": _pruning(pruned)}
    return MEASURED.sub(lambda found: found[1] + parts[found[2]], page)


def _machine(shown: Run) -> str:
    limits = shown.limits
    return (
        f"Times: processor time, the shortest of at most {limits.runs} runs within {limits.seconds:g} s, on "
        f"{platform.machine()} under\nPython {platform.python_version()}. "
        "Another machine has other times, and much the same ratios.\n"
    )


def _study(measured: Measured) -> Iterator[str]:
    study, title = measured.study, measured.study.title
    yield f"### {_escaped(title[0].upper() + title[1:])}\n"
    if measured.plan is None:
        yield f"Left out: {_escaped(measured.left_out)}.\n"
        return
    yield f"Error: {_escaped(study.quantity)}. Yardstick: {_escaped(measured.plan.reference)}.\n"
    yield _table(("method", "setting", "error", "time [s]", "other errors, work, remarks"), map(_row, measured.rows))
    if measured.slopes:
        yield _table(("method", "slope in", "seen", "predicted", "why"), map(_slope, measured.slopes))


def _row(row: ResultRow) -> tuple[str, ...]:
    seconds = "" if row.seconds is None else measured_text(row.seconds)
    return row.method, setting_text(row), error_text(row), seconds, _remarks(row)


def _remarks(row: ResultRow) -> str:
    errors = [f"{what} {measured_text(error)}" for what, error in row.details.items()]
    work = [f"{count} {what}" for what, count in row.work.items()]
    return "; ".join([*errors, *work, *([row.note] if row.note else [])])


def _slope(slope: FittedSlope) -> tuple[str, ...]:
    seen = "" if slope.value is None else f"{slope.value:.2f}"
    predicted = "" if slope.order.expected is None else f"{slope.order.expected:g}"
    return slope.method, slope.parameter, seen, predicted, slope.order.why


# ---- pruning -------------------------------------------------------------------------------------


def _pruning(pruned: Iterable[Run]) -> str:
    header = ("array", "rule", "pruned [s]", "whole [s]", "ratio", "cells", "left out", "verdicts that differ")
    return _table(header, (row for run in pruned for row in _pruning_rows(run)))


def _pruning_rows(run: Run) -> Iterator[tuple[str, ...]]:
    rows = {row.method: row for row in run.rows}
    for method, row in rows.items():
        rule, _, kind = method.partition(", ")
        if kind != PRUNED:
            continue
        whole = rows[f"{rule}, {WHOLE}"]
        ratio = "-" if row.seconds is None or whole.seconds is None else f"{whole.seconds / row.seconds:.2f}"
        cells = (
            f"{row.work['cells']} of {whole.work['cells']}" if "cells" in row.work and "cells" in whole.work else "-"
        )
        times = ["-" if r.seconds is None else f"{r.seconds:.3f}" for r in (row, whole)]
        differ = error_text(row)
        yield run.scene.name, rule, *times, ratio, cells, row.note or "nothing", differ


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(_escaped(entry) for entry in line)} |" for line in lines) + "\n"


def _escaped(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*")


def main() -> None:
    """Write the page into the folder that is named."""
    folder = Path(sys.argv[1])
    with progress() as report:
        page = write_page(folder, report)
    print(page)


if __name__ == "__main__":
    main()
