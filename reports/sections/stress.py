"""Stiff and extreme cases in the derivation report: the families that cost next to nothing; a command has them all."""

from __future__ import annotations

from nonsmooth.analysis.measurements.cases.row import StressRow
from nonsmooth.proofs.measurements.stress import guarded, stress_cases
from nonsmooth.reports.document import Code, Entry, Math, Section, table
from nonsmooth.reports.prose import paragraph
from nonsmooth.reports.subject import Subject
from nonsmooth.symbolic.formulas import decimal_latex

FAMILIES = ("loads", "contact states")  # hundredths of a second; verdicts, paths and feedback take some seconds


def stress_section(subject: Subject) -> Section:
    """What came out at extreme parameters, with its error against exact or 60-digit arithmetic."""
    cases = stress_cases(subject.scene)
    rows = [row for name in FAMILIES if name in cases for row in guarded(name, cases[name])]
    words = paragraph(
        "The scene at extreme parameters, against exact or 60-digit arithmetic: {} of {} cases hold. These are the "
        "families {}; {} runs all of them.",
        str(sum(row.ok for row in rows)),
        str(len(rows)),
        " and ".join(FAMILIES),
        Code(subject.invocation.line("stress")),
    )
    header = ("case", "parameter", "what came out", "error", "condition", "ok")
    listing = table(header, [_entries(row) for row in rows], (4, 2.4, 3.6, 2.6, 2.9, 1.2))
    return Section("Stiff and extreme cases", (words, listing))


def _entries(row: StressRow) -> tuple[Entry, ...]:
    said = row.verdict if row.ok else f"{row.verdict}: {row.note}"
    return row.case, row.parameter, said, _number(row.error), _number(row.condition), "yes" if row.ok else "no"


def _number(value: float | None) -> Entry:
    if value is None:
        return "-"
    text = f"{value:.2g}"
    return Math(decimal_latex(text), text)
