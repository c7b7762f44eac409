"""The sections of the derivation report in their order, each with what it needs of the scene.

A section is built only where it applies and was asked for; the others of the same kind of scene are named with the
reason in the section on what was left out.  To add a section, write a function ``(subject) -> Section`` and one line in
:data:`PARTS`; of plain systems :data:`nonsmooth.reports.sections.plain_system.SYSTEM_PARTS`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.proofs.clauses.equilibrium.clause import EllipseEquilibrium
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.reports.checks.continuum import continuum_section
from nonsmooth.reports.checks.subject import ArraySubject, ReportPart, ReportSubject
from nonsmooth.reports.output.document import Bullets, Section, Text
from nonsmooth.reports.output.prose import paragraph
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import is_paper_array, sign_form_section, without_sign_form
from nonsmooth.reports.sections.answers import answers_section
from nonsmooth.reports.sections.contact import (
    cells_section,
    constraining_wheels,
    constraints_section,
    contact_states_section,
)
from nonsmooth.reports.sections.measurements import precision_section, stress_section, without_precision
from nonsmooth.reports.sections.opening import (
    array_section,
    conventions_section,
    references_section,
    reproduction_section,
    verdict_section,
)
from nonsmooth.reports.sections.rules import ellipse_derivative_section, rules_section, situation_section, without_rules
from nonsmooth.reports.sections.stability import (
    equilibria_section,
    filippov_section,
    lyapunov_section,
    theorem_section,
)
from nonsmooth.reports.sections.trajectories import law_section, trajectories_section, without_law
from nonsmooth.symbolic.messages.scene_kind import SceneKind

FOR_SMOOTH_RULES = "for rules without cells"  # of sections that nobody misses beside cells


def subject_of(kind: SceneKind) -> type[ReportSubject]:
    """What reports about scenes of a kind are about: arrays, or plain systems, which alone load what they need."""
    if kind is SceneKind.SYSTEM:
        from nonsmooth.reports.sections.plain_system import SystemSubject

        return SystemSubject
    return ArraySubject


def parts_of(kind: SceneKind) -> tuple[ReportPart, ...]:
    """The sections that reports about scenes of a kind may have, in their order."""
    if kind is SceneKind.SYSTEM:
        from nonsmooth.reports.sections.plain_system import SYSTEM_PARTS

        return (*SYSTEM_PARTS, *LAST_PARTS)
    return (*PARTS, *LAST_PARTS)


def names_of(kind: SceneKind) -> tuple[str, ...]:
    """Their names."""
    return tuple(part.name for part in parts_of(kind))


def chosen_parts(only: Collection[str], without: Collection[str], kind: SceneKind = SceneKind.ARRAY) -> tuple[str, ...]:
    """Names of the sections to write: those of ``only``, or all, less those of ``without``.

    Raises:
        ValueError: for a name that is none, and where nothing is left.
    """
    names = names_of(kind)
    unknown = next((name for name in (*only, *without) if name not in names), None)
    if unknown is not None:
        raise ValueError(f"required names among {', '.join(names)}, received {unknown[:60]!r}")
    left = tuple(name for name in names if (not only or name in only) and name not in without)
    if not left:
        raise ValueError("without: required fewer than all sections that are asked for, received all of them")
    return left


def sections_of(subject: ReportSubject) -> Iterator[Section]:
    """The sections that the subject asks for and has, each announced before it is built."""
    for part in parts_of(subject.scene.kind):
        if part.name in subject.parts and not part.lacks(subject):
            subject.announce(f"section {part.name}")
            yield part.build(subject)


def _left_out(subject: ReportSubject) -> Section:
    """What was not computed, and which sections were not written, with the reasons."""
    parts = parts_of(subject.scene.kind)
    reasons = [(part.name, part.lacks(subject)) for part in parts if part.name in subject.parts]
    reasons = [(name, why) for name, why in reasons if why not in {"", FOR_SMOOTH_RULES}]
    reasons += [(part.name, "not asked for") for part in parts if part.name not in subject.parts]
    items: list[Text] = [(said,) for said in subject.left_out]
    items += [(f"Section {name}: {why}.",) for name, why in reasons]
    return Section("What was left out, and why", (Bullets(tuple(items)) if items else paragraph("Nothing."),))


# ---- what sections need --------------------------------------------------------------------------


def _no_cells(subject: ArraySubject) -> str:
    if _unknown_loads(subject):
        return _unknown_loads(subject)
    has_cells = isinstance(subject.result, CellCheck)
    return "" if has_cells else f"rule {subject.scene.contact.rule} has no cells with one twist each"


def _no_ellipse(subject: ArraySubject) -> str:
    return FOR_SMOOTH_RULES if isinstance(subject.result, CellCheck) else ""


def _no_whole_partition(subject: ArraySubject) -> str:
    if isinstance(subject.result, CellCheck) and not subject.result.partition.complete:
        return "cells away from the point were not built, and no verdict needs them"
    return _no_cells(subject)


def _unknown_loads(subject: ArraySubject) -> str:
    """The motion away from the point is that of one load."""
    needs = rule_of(subject.scene).needs_loads and subject.scene.contact.loads_are_unknown
    return "the loads are not known, and this is about one load" if needs else ""


def _no_situation(subject: ArraySubject) -> str:
    return _no_ellipse(subject) or _unknown_loads(subject)


def _not_the_papers(subject: ArraySubject) -> str:
    its_array = is_paper_array(subject.scene) and subject.scene.contact.rule == "nearest"
    return "" if its_array else "the audit is about the paper's own array under rule nearest"


def _audit(subject: ArraySubject) -> Section:
    from nonsmooth.reports.papers.murphey_burdick_2001.audit import audit_section  # SymPy takes half a second

    return audit_section()


def _no_idealization(subject: ArraySubject) -> str:
    return "" if continuum_section(subject.result) else "no continuous field stands for the wheels"


def _continuum(subject: ArraySubject) -> Section:
    section = continuum_section(subject.result)
    if section is None:
        raise TypeError("required wheels that sample a field")
    return section


def _constraints(subject: ArraySubject) -> Section:
    result = subject.result
    wheels = constraining_wheels(result) if isinstance(result, CellCheck) else subject.scene.recentred().wheels
    return constraints_section(wheels)


def _situation(subject: ArraySubject) -> Section:
    equilibrium = subject.result.equilibrium
    if not isinstance(equilibrium, EllipseEquilibrium):
        raise TypeError("required a check under rule ellipse")
    return situation_section(equilibrium.point)


def _derivative(subject: ArraySubject) -> Section:
    translation = subject.result.translation
    if isinstance(translation, EllipseTranslation):
        return ellipse_derivative_section(translation)
    return lyapunov_section(subject)


# ---- the sections --------------------------------------------------------------------------------


PARTS: tuple[ReportPart, ...] = (
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
)
LAST_PARTS = (  # of every report
    ReportPart("left-out", _left_out),
    ReportPart("references", references_section),
    ReportPart("versions", reproduction_section),
)
