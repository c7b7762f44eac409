"""The feedback law in the derivation report: the one that clause 4 certifies, and from where."""

from __future__ import annotations

from nonsmooth.proofs.clauses.feedback import FeedbackResult
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.reports.document import Block, Code, Section, display
from nonsmooth.reports.feedback_loop import certified_law
from nonsmooth.reports.papers.murphey_burdick_2001.paper import is_paper_array
from nonsmooth.reports.prose import paragraph
from nonsmooth.reports.sections.feedback import law_formulas, region_blocks
from nonsmooth.reports.subject import Subject
from nonsmooth.symbolic.rule import Rule


def law_section(subject: Subject) -> Section:
    """The certified law; beside it, on the paper's own array, the law of its sec. 3.3."""
    feedback = subject.cells.feedback
    if not isinstance(feedback, FeedbackResult):
        raise TypeError(f"required rule nearest, received {subject.scene.contact.rule}")
    words = paragraph(
        "Clause 4 certifies the {} law, in each cell with its nearest wheel `i` and second wheel `j`. The closed loops "
        "below follow it, and so does {}:",
        str(certified_law(feedback)),
        Code("nonsmooth simulate --feedback"),
    )
    papers = _papers_law() if is_paper_array(subject.scene) else []
    return Section("Feedback law", (words, *law_formulas(feedback), *region_blocks(feedback), *papers))


def _papers_law() -> list[Block]:
    """The law of sec. 3.3 with the signs that its own proof needs."""
    law = display(
        r"u_j = -\operatorname{sgn}(\Delta)\, k \theta, \qquad u_i = \lvert u_j \rvert + k \lvert (x, y) \rvert,"
        r" \qquad \Delta = d_j \cdot J(p_j - p_i)",
        "u_j = -sgn(Delta) k theta, u_i = |u_j| + k |(x, y)|, Delta = d_j . J(p_j - p_i)",
    )
    words = paragraph(
        "The paper (sec. 3.3) takes another law for this array. There `theta' = u_j/Delta`, so the sign of `u_j` must "
        "follow that of `Delta`; with it, {} follows the law, which the audit below proves for this array:",
        Code("nonsmooth simulate --feedback --law corrected"),
    )
    return [words, law]


def without_law(subject: Subject) -> str:
    """Why the scene has no such law; empty where it has."""
    if subject.scene.contact.rule is not Rule.NEAREST:
        return "the law is one for rule nearest"
    verdict = subject.result.feedback.verdict
    return "" if verdict is Feedback.STABILIZABLE else f"the feedback clause says: {verdict}"
