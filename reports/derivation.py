"""The derivation report of one scene: from the wheels to the verdict, every step with its formulas.

The report is built once as a :class:`nonsmooth.reports.document.Document`; the renderers only write it down.  It holds
no times and no dates, so equal input gives equal bytes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nonsmooth.proofs.clauses.workspace import Announce, unheard
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
from nonsmooth.reports.records import check_record, partition_record, states_record
from nonsmooth.reports.subject import Invocation, Subject
from nonsmooth.symbolic.notebook import ShortRepr
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line

REPORT_FORMATS = (".html", ".tex", ".md", ".json")


@dataclass(frozen=True, repr=False)
class Report(ShortRepr):
    """The document of a scene and the result it reports."""

    document: Document
    result: Check


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
    sections = []
    for part in PARTS:
        if part.name in parts and not part.lacks(subject):
            announce(f"section {part.name}")
            sections.append(part.build(subject))
    return Report(Document(f"Derivation report: {one_line(scene.name)}", tuple(sections)), subject.result)


def write_report(report: Report, path: Path) -> None:
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


def render_report(report: Report, suffix: str, figures: str = "figures") -> str:
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
            check = {key: value for key, value in check_record(report.result).items() if key != "seconds"}
            records: Record = {"check": check, "partition": None, "contact_states": None}
            if isinstance(report.result, CellCheck):
                records["partition"] = partition_record(report.result.partition)
                records["contact_states"] = states_record(report.result.partition)
            return json_text(derivation_record(report.document, records))
