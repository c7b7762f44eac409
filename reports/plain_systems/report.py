"""The derivation report of a plain switched system: from its formulas to the verdict, every step written down."""

from __future__ import annotations

from collections.abc import Collection

from nonsmooth.proofs.clauses.workspace import Announce, unheard
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.reports.document import Bullets, Document, Section
from nonsmooth.reports.plain_systems.inclusion_sections import borders_section, cells_section, point_section
from nonsmooth.reports.plain_systems.system_sections import (
    paths_section,
    portrait_section,
    references_section,
    system_section,
    verdict_section,
)
from nonsmooth.reports.plain_systems.system_subject import SystemSubject
from nonsmooth.reports.plain_systems.v_sections import leading_section, lyapunov_section
from nonsmooth.reports.prose import paragraph
from nonsmooth.reports.report_part import ReportPart, chosen_names, sections_of
from nonsmooth.reports.sections.closing import reproduction_section
from nonsmooth.reports.subject import Invocation
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem, require_plane


def _several_fields(subject: SystemSubject) -> str:
    switches = "the field may switch at any time, and this is about one field in each cell"
    return "" if subject.system.has_one_field else switches


def _no_leading(subject: SystemSubject) -> str:
    return "" if subject.result.by(Method.LEADING) is not None else "what decides are not the leading terms"


def _left_out(subject: SystemSubject) -> Section:
    asked = [(part.name, part.lacks(subject)) for part in SYSTEM_PARTS if part.name in subject.parts]
    items = [(f"Section {name}: {why}.",) for name, why in asked if why]
    items += [(f"Section {part.name}: not asked for.",) for part in SYSTEM_PARTS if part.name not in subject.parts]
    return Section("What was left out, and why", (Bullets(tuple(items)) if items else paragraph("Nothing."),))


SYSTEM_PARTS: tuple[ReportPart[SystemSubject], ...] = (
    ReportPart("verdict", verdict_section),
    ReportPart("system", system_section),
    ReportPart("cells", cells_section),
    ReportPart("borders", borders_section, _several_fields),
    ReportPart("point", point_section),
    ReportPart("lyapunov", lyapunov_section),
    ReportPart("leading-terms", leading_section, _no_leading),
    ReportPart("portrait", portrait_section, _several_fields),
    ReportPart("trajectories", paths_section, _several_fields),
    ReportPart("left-out", _left_out),
    ReportPart("references", references_section),
    ReportPart("versions", lambda subject: reproduction_section(subject.invocation)),
)
SYSTEM_PART_NAMES = tuple(part.name for part in SYSTEM_PARTS)


def chosen_system_parts(only: Collection[str], without: Collection[str]) -> tuple[str, ...]:
    """Names of the sections to write: those of ``only``, or all, less those of ``without``.

    Raises:
        ValueError: for a name that is none.
    """
    return chosen_names(SYSTEM_PART_NAMES, only, without)


def system_document(subject: SystemSubject) -> Document:
    """The report of a system.

    Args:
        subject: the system, and which sections are written.

    Raises:
        SceneError: for a system in another number of states than two.
        RuntimeError: if the evidence of the verdict does not verify.
    """
    sections = tuple(sections_of(SYSTEM_PARTS, subject))
    return Document(f"Derivation report: {one_line(subject.system.name)}", sections)


def system_subject(
    system: SwitchedSystem,
    invocation: Invocation | None = None,
    parts: tuple[str, ...] = SYSTEM_PART_NAMES,
    announce: Announce = unheard,
) -> SystemSubject:
    """What the report is about.

    Args:
        system: in two states.
        invocation: how the report was asked for; None for the system as it stands.
        parts: names of the sections to write.
        announce: hears the names of the sections.

    Raises:
        SceneError: for a system in another number of states than two.
    """
    require_plane(system)
    return SystemSubject(system, invocation or Invocation(system.origin), parts, announce)
