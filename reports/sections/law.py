"""The feedback law in the derivation report: its formulas and why each cell needs its own sign."""

from __future__ import annotations

from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.reports.document import Section, display
from nonsmooth.reports.prose import paragraph
from nonsmooth.reports.subject import Subject
from nonsmooth.symbolic.rule import Rule


def law_section(subject: Subject) -> Section:
    """The law of sec. 3.3 with the signs that the certificate needs."""
    law = display(
        r"u_j = -\operatorname{sgn}(\Delta)\, k \theta, \qquad u_i = \lvert u_j \rvert + k \lvert (x, y) \rvert,"
        r" \qquad \Delta = d_j \cdot J(p_j - p_i)",
        "u_j = -sgn(Delta) k theta, u_i = |u_j| + k |(x, y)|, Delta = d_j . J(p_j - p_i)",
    )
    words = paragraph(
        "In a cell of wheel `i` with the roll row of wheel `j` the heading obeys `theta' = u_j/Delta`, up to the "
        "share of `u_i`, so the sign of `u_j` must follow that of `Delta`; clause 4 lists it cell by cell, and proves "
        "the decrease of V for the law `u_i = -k a`, `u_j = -k b`."
    )
    return Section("Feedback law", (words, law))


def without_law(subject: Subject) -> str:
    """Why the scene has no such law; empty where it has."""
    if subject.scene.contact.rule is not Rule.NEAREST:
        return "the law is one for rule nearest"
    verdict = subject.result.feedback.verdict
    return "" if verdict is Feedback.STABILIZABLE else f"the feedback clause says: {verdict}"
