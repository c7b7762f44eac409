"""The page ``docs/precision.md`` with its figure: ``python -m nonsmooth.reports.precision_page docs``.

Errors, slopes and verdicts on the page are the same on every machine up to rounding; times are those of the machine
that wrote it, and the page says so.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from nonsmooth.analysis.measurements.harness import Measured, Run, Study, measure
from nonsmooth.analysis.measurements.rows import ResultRow
from nonsmooth.analysis.measurements.slopes import Slope
from nonsmooth.analysis.measurements.timing import Limits
from nonsmooth.proofs.measurements.pruning import PRUNED, PRUNING, WHOLE
from nonsmooth.proofs.measurements.registry import STUDIES
from nonsmooth.reports.figures.measurements import measurement_figure
from nonsmooth.reports.files import output_path, write_whole
from nonsmooth.reports.measurements import Precision, error_text, number_text, setting_text, slopes_of, study_of
from nonsmooth.reports.progress import Report, progress
from nonsmooth.symbolic.files.scene_file import builtin_scenes, load_scene

SHOWN = "four-wheel"
LIMITS = Limits()
PRUNING_LIMITS = Limits(runs=2, seconds=10.0)  # a whole check is one long trial

INTRODUCTION = """\
# Error against run time

This page is written by `make precision`; the same for any array: `nonsmooth precision SCENE`. Every error is the
distance from an exact answer, or from one that holds to sixty digits; the yardstick stands above each table. No method
is measured against a finer run of itself.
"""
ADVICE = """\
## How to read the figure

Each panel is a work-precision diagram: the error across, the processor time upwards, both logarithmic, so that a better
method lies further to the left and further down. A line joins the settings of one method, from easy to hard. Stars on
the dotted line are errors of exactly zero, or too small to be told from it; open marks at the dashed line ran out of
time or failed, and stand above the last setting that did not. Times of a factor of two mean little, since they change
with the machine and with what else it does; slopes and the order of methods that lie a decade apart do not. Under each
table stands the slope of log(error) over log(setting) beside the one that theory predicts, or the reason why it
predicts none. Errors of event times are given where a method looks for events, at the edges that a path meets first.
The panel on full dynamics compares models, not methods: what a contact rule misses, and what a mass costs.

## Which method to choose

For trajectories take the event-driven method: its error is rounding, no setting has to be chosen, and no other method
is as fast at any of its settings; with exact numbers it takes five to ten times as long and has no error at all.
Hysteresis, smoothing and plain SciPy solvers are for comparison, or for fields of which only values are known:
smoothing with a stiff solver is then the cheapest, since hysteresis pays for its width with switches and a
Runge-Kutta method for its tolerance with rejected steps along every slide. To decide the sign of V\\* take the exact
cells: samples always come out too small, a hundred times more of them gain one digit where the largest value sits at
a vertex, and none of them proves anything. For minimizers take the explicit cells where many points are asked for,
HiGHS or the enumeration for a few (box), and the interior point with its Newton steps (ellipse), where a tolerance on
the duality gap leaves an error of its square root in the twist. Derive contact states in the number field: it is as
exact as naive SymPy in less than a hundredth of its time; balls are faster still, but cannot tell that a triple is
singular.
"""
PRUNING_NOTE = """\
Every built-in array under every contact rule: the check that leaves out what no verdict needs against the whole one
(`--no-prune`). The last column counts the verdicts that differ. The built-in arrays are small: under rule `nearest` all
wheels matter, and only large arrays gain (a grid of 7 x 7 wheels in `make bench`: more than tenfold). Under `box` and
`ellipse` the lemma on inward rims spares cells and samples of V\\*, and the feedback clause, decided exactly, spares
the samples of two laws.
"""


def write_page(folder: Path, report: Report) -> Path:
    """Measure, and write ``precision.md`` and its figure into a folder.

    Raises:
        KeyboardInterrupt: where the work is interrupted; then nothing is written.
    """
    shown = _whole(SHOWN, [study for study in STUDIES if study is not PRUNING], LIMITS, report)
    pruned = [_whole(name, [PRUNING], PRUNING_LIMITS, report) for name in builtin_scenes()]
    figure, page = folder / "precision" / f"{SHOWN}.svg", folder / "precision.md"
    figure.parent.mkdir(exist_ok=True)
    write_whole(output_path(str(figure), (".svg",)), measurement_figure(Precision(shown), ".svg"))
    write_whole(output_path(str(page), (".md",)), page_text(shown, pruned).encode())
    return page


def _whole(name: str, studies: Sequence[Study], limits: Limits, report: Report) -> Run:
    found = measure(load_scene(name), studies, limits, report)
    if not found.complete:
        raise KeyboardInterrupt
    return found


def page_text(shown: Run, pruned: Sequence[Run]) -> str:
    """The page as Markdown."""
    scene = shown.scene.name
    parts = [INTRODUCTION, _machine(shown), ADVICE, f"## The array `{scene}`\n"]
    parts.append(f"![error against run time for {scene}](precision/{SHOWN}.svg)\n")
    parts += [part for measured in shown.measured for part in _study(measured)]
    parts += ["## What pruning saves\n", PRUNING_NOTE, _pruning(pruned)]
    return "\n".join(parts)


def _machine(shown: Run) -> str:
    limits = shown.limits
    return (
        f"Times: processor time, the shortest of at most {limits.runs} runs within {limits.seconds:g} s, on "
        f"{platform.machine()} under\nPython {platform.python_version()}. "
        "Another machine has other times, and much the same ratios.\n"
    )


def _study(measured: Measured) -> Iterator[str]:
    study = study_of(measured)
    title = study.title
    yield f"### {_escaped(title[0].upper() + title[1:])}\n"
    if measured.plan is None:
        yield f"Left out: {_escaped(measured.left_out)}.\n"
        return
    yield f"Error: {_escaped(study.quantity)}. Yardstick: {_escaped(measured.plan.reference)}.\n"
    header = ("method", "setting", "error", "time [s]", "other errors, work, remarks")
    yield _table(header, map(_row, measured.rows))
    slopes = slopes_of(measured)
    if slopes:
        header = ("method", "slope in", "seen", "predicted", "why")
        yield _table(header, (_slope(slope) for slope in slopes))


def _row(row: ResultRow) -> tuple[str, ...]:
    seconds = "" if row.seconds is None else number_text(row.seconds)
    return row.method, setting_text(row), error_text(row), seconds, _remarks(row)


def _remarks(row: ResultRow) -> str:
    errors = [f"{what} {number_text(error)}" for what, error in row.details.items()]
    work = [f"{count} {what}" for what, count in row.work.items()]
    return "; ".join([*errors, *work, *([row.note] if row.note else [])])


def _slope(slope: Slope) -> tuple[str, ...]:
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
