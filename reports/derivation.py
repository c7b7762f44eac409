"""The derivation report of one scene: from the wheels, or the formulas, to the verdict, every step written down.

The report is built once as a :class:`nonsmooth.reports.document.Document`; the renderers only write it down.  It holds
no times and no dates, so equal input gives equal bytes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nonsmooth.proofs.clauses.workspace import Announce, unheard
from nonsmooth.reports.console import json_text
from nonsmooth.reports.document import Document
from nonsmooth.reports.files import make_folder, write_whole
from nonsmooth.reports.formats.html import render_html
from nonsmooth.reports.formats.json import derivation_record
from nonsmooth.reports.formats.latex import render_latex
from nonsmooth.reports.formats.markdown import render_markdown
from nonsmooth.reports.parts import names_of, sections_of
from nonsmooth.reports.subject import ArraySubject, Invocation, Subject, SystemSubject
from nonsmooth.symbolic.notebook import ShortRepr
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem

REPORT_FORMATS = (".html", ".tex", ".md", ".json")


@dataclass(frozen=True, repr=False)
class Report(ShortRepr):
    """A document with what it is about.

    Attributes:
        document: to be rendered.
        subject: the scene with its verdict and exact records.
    """

    document: Document
    subject: Subject

    @property
    def result(self) -> Any:
        """The check of an array, or the stability of a plain system."""
        return self.subject.result


def derive_report(
    scene: Scene | SwitchedSystem,
    invocation: Invocation | None = None,
    parts: tuple[str, ...] | None = None,
    announce: Announce = unheard,
) -> Report:
    """Check the scene and write the derivation down.

    Args:
        scene: an array, or a plain system in two states.
        invocation: how the report was asked for, from which the commands that reproduce it and its figures follow;
            None for the scene as it stands.
        parts: names of the sections to write, see :data:`nonsmooth.reports.parts.PARTS`; all unless given.
        announce: hears the steps of the check and the names of the sections.

    Raises:
        RefusalError: where the motion is not determined.
        SceneError: for a plain system in another number of states.
        RuntimeError: if the evidence of a verdict does not verify.
    """
    kind: type[Subject] = ArraySubject if isinstance(scene, Scene) else SystemSubject
    chosen = names_of(kind) if parts is None else parts
    subject = kind(scene, invocation or Invocation(scene.origin), chosen, announce)
    return Report(Document(f"Derivation report: {one_line(scene.name)}", tuple(sections_of(subject))), subject)


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
            return json_text(derivation_record(report.document, report.subject.records))
