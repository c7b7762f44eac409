"""The derivation report of one scene: from the wheels, or the formulas, to the verdict, every step written down.

The report is built once as a :class:`nonsmooth.reports.document.Document`; the renderers only write it down.  It holds
no times and no dates, so equal input gives equal bytes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from nonsmooth.proofs.clauses.workspace import Announce, unheard
from nonsmooth.proofs.system_decision import StabilityResult
from nonsmooth.proofs.theorem4_result import CellCheck, Check
from nonsmooth.reports.console import json_text
from nonsmooth.reports.document import Document
from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.files import make_folder, write_whole
from nonsmooth.reports.formats.html import render_html
from nonsmooth.reports.formats.json import derivation_record
from nonsmooth.reports.formats.latex import render_latex
from nonsmooth.reports.formats.markdown import render_markdown
from nonsmooth.reports.parts import PART_NAMES, PARTS
from nonsmooth.reports.plain_systems.report import SYSTEM_PART_NAMES, system_document, system_subject
from nonsmooth.reports.records import check_record, partition_record, states_record
from nonsmooth.reports.report_part import sections_of
from nonsmooth.reports.subject import Invocation, Subject
from nonsmooth.symbolic.notebook import ShortRepr
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem

REPORT_FORMATS = (".html", ".tex", ".md", ".json")


@dataclass(frozen=True, repr=False)
class WrittenReport(ShortRepr, ABC):
    """A document with the exact records of what it reports.

    Attributes:
        document: to be rendered.
        records: computes what the JSON form adds.
    """

    document: Document
    records: Callable[[], Record] = field(repr=False, compare=False)

    @property
    @abstractmethod
    def headline(self) -> str:
        """The verdict in a line."""


@dataclass(frozen=True, repr=False)
class Report(WrittenReport):
    """The report of an array, with the check that it reports."""

    result: Check

    @property
    def headline(self) -> str:
        """The verdict of Theorem 4."""
        return f"Theorem 4: {self.result.verdict}"


@dataclass(frozen=True, repr=False)
class SystemReport(WrittenReport):
    """The report of a plain system, with the verdict that it reports."""

    result: StabilityResult

    @property
    def headline(self) -> str:
        """The stability of the checked point."""
        return str(self.result.verdict)


def derive_report(
    scene: Scene,
    invocation: Invocation | None = None,
    parts: tuple[str, ...] = PART_NAMES,
    announce: Announce = unheard,
) -> Report:
    """Check the scene and write the derivation down.

    Args:
        scene: the array.
        invocation: how the report was asked for, from which the commands that reproduce it and its figures follow;
            None for the scene as it stands.
        parts: names of the sections to write, see :data:`nonsmooth.reports.parts.PARTS`.
        announce: hears the steps of the check and the names of the sections.

    Raises:
        RefusalError: where the motion is not determined.
        RuntimeError: if the evidence of a verdict does not verify.
    """
    subject = Subject(scene, invocation or Invocation(scene.origin), parts, announce)
    document = Document(f"Derivation report: {one_line(scene.name)}", tuple(sections_of(PARTS, subject)))
    return Report(document, lambda: _array_records(subject.result), subject.result)


def derive_system_report(
    system: SwitchedSystem,
    invocation: Invocation | None = None,
    parts: tuple[str, ...] = SYSTEM_PART_NAMES,
    announce: Announce = unheard,
) -> SystemReport:
    """Check a plain system and write the derivation down.

    Args:
        system: in two states.
        invocation: as for :func:`derive_report`.
        parts: names of the sections, see :data:`nonsmooth.reports.plain_systems.report.SYSTEM_PARTS`.
        announce: hears the names of the sections.

    Raises:
        SceneError: for a system in another number of states.
        RuntimeError: if the evidence of the verdict does not verify.
    """
    subject = system_subject(system, invocation, parts, announce)
    return SystemReport(system_document(subject), lambda: subject.records, subject.result)


def write_report(report: WrittenReport, path: Path) -> None:
    """Write the report to a file that ends in one of REPORT_FORMATS; LaTeX with its figures in a folder beside it.

    Raises:
        OutputError: where the system refuses.
    """
    suffix = path.suffix.lower()
    folder = path.with_name(f"{path.stem}-figures")
    files = {path: render_report(report, suffix, folder.name).encode()}
    if suffix == ".tex":
        files |= {folder / f"{figure.key}.pdf": figure.draw(".pdf") for figure in report.document.figures}
    for file, content in files.items():
        make_folder(file.parent)
        write_whole(file, content)


def render_report(report: WrittenReport, suffix: str, figures: str = "figures") -> str:
    """The report in one of REPORT_FORMATS.

    Args:
        report: the report.
        suffix: the format.
        figures: the folder in which LaTeX finds the figures.
    """
    match suffix:
        case ".md":
            return render_markdown(report.document)
        case ".tex":
            return render_latex(report.document, figures)
        case ".html":
            return render_html(report.document)
        case _:
            return json_text(derivation_record(report.document, report.records()))


def _array_records(result: Check) -> Record:
    """The exact records of a check, its cells and contact states."""
    check = {key: value for key, value in check_record(result).items() if key != "seconds"}
    records: Record = {"check": check, "partition": None, "contact_states": None}
    if isinstance(result, CellCheck):
        records["partition"] = partition_record(result.partition)
        records["contact_states"] = states_record(result.partition)
    return records
