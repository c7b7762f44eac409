"""The last sections of the derivation report: what was left out and why, versions and reproduction."""

from __future__ import annotations

import platform
from collections.abc import Iterable
from importlib.metadata import version

from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.theorem4_result import CellCheck, Check
from nonsmooth.reports.console import own_version
from nonsmooth.reports.document import Bullets, Code, Listing, Section, Text
from nonsmooth.reports.prose import paragraph
from nonsmooth.reports.references import (
    BROCKETT,
    FILIPPOV,
    HOMOGENEITY,
    JURDJEVIC_QUINN,
    PAPER,
    RYAN,
    SHEVITZ_PADEN,
    how_to_cite,
)
from nonsmooth.reports.subject import Invocation, Subject

LIBRARIES = ("python-flint", "sympy", "numpy", "scipy", "matplotlib")


def left_out_section(result: Check, omitted: Iterable[tuple[str, str]]) -> Section:
    """What was not computed, and why.

    Args:
        result: the check.
        omitted: sections of the report with the reason for each.
    """
    items: list[Text] = [(f"{skipped.what} ({skipped.count}): {skipped.why}.",) for skipped in result.skipped]
    items += [(f"Section {name}: {why}.",) for name, why in omitted]
    if isinstance(result, CellCheck):
        count, possible = len(result.partition.states), result.census.possible
        words = f"Equations are written for the {count} contact states that own a cell, out of {possible} row triples."
        items.insert(0, (words,))
    if not items:
        return Section("What was left out, and why", (paragraph("Nothing."),))
    return Section("What was left out, and why", (Bullets(tuple(items)),))


def references_section(subject: Subject) -> Section:
    """The works that this report rests on, and how to cite the program."""
    feedback = subject.result.results["feedback"]
    works = [PAPER, FILIPPOV, SHEVITZ_PADEN]
    if isinstance(feedback, FeedbackResult):
        works += [HOMOGENEITY] if feedback.cascade is not None else []
        works += [JURDJEVIC_QUINN] if feedback.has_lyapunov else []
    if getattr(feedback, "obstruction", None) is not None:
        works += [BROCKETT, RYAN]
    listed = Bullets(tuple((work.text,) for work in sorted(works, key=lambda work: work.authors.split()[-1])))
    return Section("References", (listed, paragraph("To cite this program:"), Listing(how_to_cite())))


def reproduction_section(invocation: Invocation) -> Section:
    """Versions and the command that writes this report."""
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    words = "nonsmooth {}, Python {}, {}. This report is written by {}."
    versions = paragraph(words, own_version(), platform.python_version(), libraries, Code(invocation.derive))
    return Section("Versions and reproduction", (versions,))
