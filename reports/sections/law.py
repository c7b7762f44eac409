"""The feedback law in the derivation report: the one that clause 4 certifies, and from where."""

from __future__ import annotations

from nonsmooth.analysis.contact_rule import rule_of
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.reports.document import Code, Section
from nonsmooth.reports.feedback_loop import certified_law
from nonsmooth.reports.papers.murphey_burdick_2001.paper import is_paper_array, law_of_section_3_3
from nonsmooth.reports.prose import paragraph
from nonsmooth.reports.sections.driven_loop import driven_law_section
from nonsmooth.reports.sections.feedback import law_formulas, region_blocks
from nonsmooth.reports.subject import ArraySubject


def law_section(subject: ArraySubject) -> Section:
    """The certified law; beside it, on the paper's own array, the law of its sec. 3.3."""
    if isinstance(subject.result.feedback, DrivenFeedback):
        return driven_law_section(subject)
    feedback = subject.cells.feedback
    if not isinstance(feedback, FeedbackResult):
        raise TypeError(f"required rule nearest, received {subject.scene.contact.rule}")
    words = paragraph(
        "Clause 4 certifies the {} law, in each cell with its nearest wheel `i` and second wheel `j`. The closed loops "
        "below follow it, and so does {}:",
        str(certified_law(feedback)),
        Code("nonsmooth simulate --feedback"),
    )
    papers = law_of_section_3_3() if is_paper_array(subject.scene) and subject.scene.check.length == 1 else []
    return Section("Feedback law", (words, *law_formulas(feedback), *region_blocks(feedback), *papers))


def without_cell_law(subject: ArraySubject) -> str:
    """Why the scene has no certified law of cells; empty where it has."""
    return without_law(subject) if rule_of(subject.scene).keeps_rows else "the law is one for rule nearest"


def without_law(subject: ArraySubject) -> str:
    """Why the scene has no such law; empty where it has."""
    verdict = subject.result.feedback.holding.verdict
    return "" if verdict is Feedback.STABILIZABLE else f"the feedback clause says: {verdict}"
