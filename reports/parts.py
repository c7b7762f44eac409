"""The sections of the derivation report in their order, each with what it needs of the scene.

A section is built only where it applies and was asked for; the others are named with the reason in the section on
what was left out.  To add a section, write a function ``(subject) -> Section`` and one line below.
"""

from __future__ import annotations

from collections.abc import Collection

from nonsmooth.analysis.contact_rule import rule_of
from nonsmooth.proofs.clauses.equilibrium.at_point import EllipseEquilibrium
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.reports.continuum import continuum_section
from nonsmooth.reports.document import Section
from nonsmooth.reports.papers.murphey_burdick_2001.paper import is_paper_array
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import sign_form_section, without_sign_form
from nonsmooth.reports.report_part import ReportPart, chosen_names
from nonsmooth.reports.sections.answers import answers_section
from nonsmooth.reports.sections.cells import cells_section
from nonsmooth.reports.sections.closing import left_out_section, references_section, reproduction_section
from nonsmooth.reports.sections.contact import constraining_wheels, constraints_section, contact_states_section
from nonsmooth.reports.sections.ellipse import ellipse_derivative_section, situation_section
from nonsmooth.reports.sections.law import law_section, without_law
from nonsmooth.reports.sections.measurements import precision_section, stress_section, without_precision
from nonsmooth.reports.sections.opening import array_section, conventions_section, verdict_section
from nonsmooth.reports.sections.rules import rules_section, without_rules
from nonsmooth.reports.sections.stability import (
    equilibria_section,
    filippov_section,
    lyapunov_section,
    theorem_section,
)
from nonsmooth.reports.sections.trajectories import trajectories_section
from nonsmooth.reports.subject import Subject
from nonsmooth.symbolic.unknown_loads import UnknownLoads


def _no_cells(subject: Subject) -> str:
    if _unknown_loads(subject):
        return _unknown_loads(subject)
    has_cells = isinstance(subject.result, CellCheck)
    return "" if has_cells else f"rule {subject.scene.contact.rule} has no cells with one twist each"


def _no_ellipse(subject: Subject) -> str:
    return "for rules without cells" if isinstance(subject.result, CellCheck) else ""


def _no_whole_partition(subject: Subject) -> str:
    if isinstance(subject.result, CellCheck) and not subject.result.partition.complete:
        return "cells away from the point were not built, and no verdict needs them"
    return _no_cells(subject)


def _unknown_loads(subject: Subject) -> str:
    """The motion away from the point is that of one load."""
    needs = rule_of(subject.scene).needs_loads and isinstance(subject.scene.contact.loads, UnknownLoads)
    return "the loads are not known, and this is about one load" if needs else ""


def _no_situation(subject: Subject) -> str:
    return _no_ellipse(subject) or _unknown_loads(subject)


def _not_the_papers(subject: Subject) -> str:
    its_array = is_paper_array(subject.scene) and subject.scene.contact.rule == "nearest"
    return "" if its_array else "the audit is about the paper's own array under rule nearest"


def _audit(subject: Subject) -> Section:
    from nonsmooth.reports.papers.murphey_burdick_2001.audit import audit_section  # SymPy takes half a second

    return audit_section()


def _no_idealization(subject: Subject) -> str:
    return "" if continuum_section(subject.result) else "no continuous field stands for the wheels"


def _continuum(subject: Subject) -> Section:
    section = continuum_section(subject.result)
    if section is None:
        raise TypeError("required wheels that sample a field")
    return section


def _constraints(subject: Subject) -> Section:
    result = subject.result
    wheels = constraining_wheels(result) if isinstance(result, CellCheck) else subject.scene.recentred().wheels
    return constraints_section(wheels)


def _situation(subject: Subject) -> Section:
    equilibrium = subject.result.equilibrium
    if not isinstance(equilibrium, EllipseEquilibrium):
        raise TypeError("required a check under rule ellipse")
    return situation_section(equilibrium.point)


def _derivative(subject: Subject) -> Section:
    translation = subject.result.translation
    if isinstance(translation, EllipseTranslation):
        return ellipse_derivative_section(translation)
    return lyapunov_section(subject)


def _left_out(subject: Subject) -> Section:
    reasons = [(part.name, part.lacks(subject)) for part in PARTS if part.name in subject.parts]
    omitted = [(name, why) for name, why in reasons if why and why != _no_ellipse(subject)]
    unasked = [(part.name, "not asked for") for part in PARTS if part.name not in subject.parts]
    return left_out_section(subject.result, omitted + unasked)


PARTS: tuple[ReportPart[Subject], ...] = (
    ReportPart("answers", answers_section),
    ReportPart("verdict", lambda subject: verdict_section(subject.result)),
    ReportPart("array", array_section),
    ReportPart("conventions", lambda subject: conventions_section(subject.scene)),
    ReportPart("constraints", _constraints),
    ReportPart("contact-states", lambda subject: contact_states_section(subject.cells), _no_cells),
    ReportPart("cells", cells_section, _no_cells),
    ReportPart(
        "sgn-form", sign_form_section, lambda subject: _no_whole_partition(subject) or without_sign_form(subject)
    ),
    ReportPart("situation", _situation, _no_situation),
    ReportPart("filippov", lambda subject: filippov_section(subject.cells), _no_cells),
    ReportPart("equilibria", lambda subject: equilibria_section(subject.cells), _no_cells),
    ReportPart("derivative", _derivative, _unknown_loads),
    ReportPart("theorem", lambda subject: theorem_section(subject.result)),
    ReportPart("feedback", law_section, lambda subject: _unknown_loads(subject) or without_law(subject)),
    ReportPart("trajectories", trajectories_section, _no_whole_partition),
    ReportPart("rules", rules_section, lambda subject: _unknown_loads(subject) or without_rules(subject)),
    ReportPart("continuum", _continuum, _no_idealization),
    ReportPart(
        "precision", precision_section, lambda subject: _no_whole_partition(subject) or without_precision(subject)
    ),
    ReportPart("stress", stress_section, _unknown_loads),
    ReportPart("audit", _audit, _not_the_papers),
    ReportPart("left-out", _left_out),
    ReportPart("references", references_section),
    ReportPart("versions", lambda subject: reproduction_section(subject.invocation)),
)
PART_NAMES = tuple(part.name for part in PARTS)


def chosen_parts(only: Collection[str], without: Collection[str]) -> tuple[str, ...]:
    """Names of the sections to write: those of ``only``, or all, less those of ``without``.

    Raises:
        ValueError: for a name that is none.
    """
    return chosen_names(PART_NAMES, only, without)
