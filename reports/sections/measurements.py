"""Measurements in the derivation report: errors against work, and the stiff and extreme cases that cost little.

Run times differ from run to run, and a report holds none: work is counted in steps here, and ``nonsmooth precision``
measures the times.  Methods, settings and cases that take long are left to the commands.
"""

from __future__ import annotations

import math

from nonsmooth.analysis.measurements.cases import COLLINEAR, LOADS
from nonsmooth.analysis.measurements.harness import LeftOut, Limits, ResultRow, fitted_slopes, measure
from nonsmooth.analysis.measurements.path_studies import TRAJECTORIES
from nonsmooth.reports.checks.subject import ArraySubject
from nonsmooth.reports.output.document import Code, Entry, Section, decimal, table
from nonsmooth.reports.output.prose import paragraph
from nonsmooth.symbolic.numbers.number_text import float_text

METHODS = ("events, closed form", "DOP853 with events", "hysteresis", "smoothed", "RK45", "DOP853")
SETTINGS = 3  # of each method, the easy ones first: enough for a slope, and together about a second
ONCE = Limits(runs=1, seconds=math.inf)  # without a time limit, so that equal input gives equal rows
CASES = (LOADS, COLLINEAR)  # hundredths of a second; verdicts, paths and feedback take some seconds


def without_precision(subject: ArraySubject) -> str:
    """Why the errors are not measured; empty where they are."""
    try:
        TRAJECTORIES.build(subject.scene)
    except LeftOut as reason:
        return str(reason)
    return ""


def precision_section(subject: ArraySubject) -> Section:
    """Errors, steps and orders of methods that follow the same paths."""
    plan = TRAJECTORIES.build(subject.scene)
    rows = []
    for method in METHODS:
        trials = [trial for trial in plan.trials if trial.method == method]
        rows += [TRAJECTORIES.measure(trial, plan, ONCE) for trial in trials[:SETTINGS]]
    header = ("method", "setting", TRAJECTORIES.quantity, "steps")
    listing = table(header, [_method_entries(row) for row in rows], (4, 3.5, 3, 2))
    intro = paragraph(
        "{}, against: {}. Run times depend on the machine and are measured by {}; work is counted in steps here.",
        TRAJECTORIES.title[:1].upper() + TRAJECTORIES.title[1:],
        plan.reference,
        Code(subject.invocation.line("precision", "--study", TRAJECTORIES.name, "-o", "precision.pdf")),
    )
    orders = [
        paragraph("{}: slope {} in the {}.", slope.method, f"{slope.value:.2f}", slope.parameter)
        for slope in fitted_slopes(plan, rows)
        if slope.value is not None
    ]
    return Section("Error against work", (intro, listing, *orders))


def stress_section(subject: ArraySubject) -> Section:
    """What came out at extreme parameters, with its error against exact or 60-digit arithmetic."""
    rows = measure(subject.scene, CASES).rows
    words = paragraph(
        "The scene at extreme parameters, against exact or 60-digit arithmetic: {} of {} cases hold. These are the "
        "families {}; {} runs all of them.",
        str(sum(row.ok for row in rows)),
        str(len(rows)),
        " and ".join(case.name for case in CASES),
        Code(subject.invocation.line("stress")),
    )
    header = ("case", "parameter", "what came out", "error", "condition", "ok")
    listing = table(header, [_case_entries(row) for row in rows], (4, 2.4, 3.6, 2.6, 2.9, 1.2))
    return Section("Stiff and extreme cases", (words, listing))


def _method_entries(row: ResultRow) -> tuple[Entry, ...]:
    setting = "" if row.setting is None else f"{row.parameter} {row.setting:.1e}"
    return row.method, setting, _number(row.error, "gave up"), str(row.work.get("steps", ""))


def _case_entries(row: ResultRow) -> tuple[Entry, ...]:
    said = row.outcome if row.ok else f"{row.outcome}: {row.note}"
    ok = "yes" if row.ok else "no"
    return row.name, row.parameter or "", said, _number(row.error, "-"), _number(row.condition, "-"), ok


def _number(value: float | None, otherwise: str) -> Entry:
    return otherwise if value is None else decimal(float_text(value, 2))
