"""Error against work in the derivation report: integrators of the array's field beside exact paths.

Run times differ from run to run, and a report holds none: work is counted in steps here, and ``nonsmooth precision``
measures the times.  Methods and settings that take long are left to that command.
"""

from __future__ import annotations

import math

from nonsmooth.analysis.measurements.clock import Clock
from nonsmooth.analysis.measurements.slopes import fitted_slopes
from nonsmooth.analysis.measurements.studies.trajectories import TRAJECTORIES
from nonsmooth.analysis.measurements.study import LeftOut, Outcome, Plan, Row, Trial
from nonsmooth.reports.document import Code, Entry, Math, Section, table
from nonsmooth.reports.prose import paragraph
from nonsmooth.reports.subject import Subject
from nonsmooth.symbolic.formulas import decimal_latex

METHODS = ("events, closed form", "DOP853 with events", "hysteresis", "smoothed", "RK45", "DOP853")
SETTINGS = 4  # of each method, the easy ones first: together below a second


def without_precision(subject: Subject) -> str:
    """Why the errors are not measured; empty where they are."""
    try:
        TRAJECTORIES.build(subject.scene)
    except LeftOut as reason:
        return str(reason)
    return ""


def precision_section(subject: Subject) -> Section:
    """Errors, steps and orders of methods that follow the same paths."""
    plan = TRAJECTORIES.build(subject.scene)
    rows = [_measured(plan, trial) for method in METHODS for trial in _trials(plan, method)]
    listing = table(
        ("method", "setting", TRAJECTORIES.quantity, "steps"), [_entries(row) for row in rows], (4, 3.5, 3, 2)
    )
    intro = paragraph(
        "{}, against: {}. Run times depend on the machine and are measured by {}; work is counted in steps here.",
        TRAJECTORIES.title[:1].upper() + TRAJECTORIES.title[1:],
        plan.reference,
        Code(subject.invocation.line("precision", "--study", TRAJECTORIES.name, "-o", "precision.pdf")),
    )
    orders = [
        paragraph("{}: slope {} in the {}.", slope.method, f"{slope.value:.2f}", slope.parameter)
        for slope in fitted_slopes(TRAJECTORIES.name, plan, rows)
        if slope.value is not None
    ]
    return Section("Error against work", (intro, listing, *orders))


def _trials(plan: Plan, method: str) -> list[Trial]:
    return [trial for trial in plan.trials if trial.method == method][:SETTINGS]


def _measured(plan: Plan, trial: Trial) -> Row:
    """A trial without a time limit and without a time, so that equal input gives equal rows."""
    labels = (TRAJECTORIES.name, trial.method, trial.parameter, trial.setting)
    try:
        found = trial.judge(trial.work(Clock(math.inf)))
    except (RuntimeError, ValueError, ArithmeticError):  # what methods raise that give up
        return Row(*labels, None, None, plan.reference, Outcome.FAILED)
    return Row(*labels, found.error, None, plan.reference, work=found.work, note=found.note)


def _entries(row: Row) -> tuple[Entry, ...]:
    setting = "" if row.setting is None else f"{row.parameter} {row.setting:.1e}"
    steps = str(row.work["steps"]) if "steps" in row.work else ""
    return row.method, setting, "gave up" if row.error is None else _number(row.error), steps


def _number(value: float) -> Math:
    text = f"{value:.2g}"
    return Math(decimal_latex(text), text)
