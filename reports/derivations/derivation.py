"""The study ``derive``: the derivation report of a scene, from the wheels or the formulas to the verdict.

The report is built once as a :class:`nonsmooth.reports.output.document.Document`; the renderers only write it down.  It
holds no times and no dates, so equal input gives equal bytes.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from nonsmooth.proofs.clauses.workspace import Announce, unheard
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.checks.subject import ArraySubject, Invocation, ReportSubject
from nonsmooth.reports.derivations.parts import brief_document, chosen_parts, lacking, names_of, sections_of, subject_of
from nonsmooth.reports.formats.html import render_html
from nonsmooth.reports.formats.latex import render_latex
from nonsmooth.reports.formats.markdown import render_markdown
from nonsmooth.reports.output.console import json_text, write
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Code,
    Display,
    Document,
    Figure,
    Inline,
    Listing,
    Math,
    Paragraph,
    Section,
    Table,
    Text,
    Verdict,
    findings,
    sentences,
)
from nonsmooth.reports.output.files import make_folder, write_whole
from nonsmooth.reports.output.progress import steps
from nonsmooth.reports.output.refusals import option_named, refusals_named, require_resolved
from nonsmooth.reports.output.study_options import Options, option
from nonsmooth.reports.studies.result import DataTable, Formats, Result, short_lines
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.messages.scene_kind import SceneKind

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.scene import Scene
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


REPORT_FORMATS = (".html", ".tex", ".md", ".json")


@dataclass(frozen=True, repr=False)
class ReportResult(Result):
    """A derivation report, not yet written down.

    Attributes:
        document: to be rendered.
        subject: the scene with its verdict and exact records.
        headline: what it says in a line; the verdict unless given.
    """

    document: Document
    subject: ReportSubject
    headline: str = ""

    formats: ClassVar[Formats] = dict.fromkeys(
        REPORT_FORMATS, lambda report, ending: render_report(report, ending).encode()
    )

    @property
    def result(self) -> Any:
        """The check of an array, or the stability of a plain system."""
        return self.subject.result

    @property
    def verdict(self) -> str:
        """Of Theorem 4 for an array, of stability for a plain system."""
        return str(self.result.verdict)

    @property
    def theorem4(self) -> str:
        """The verdict of Theorem 4.

        Raises:
            AttributeError: for the report of a plain system.
        """
        if self.subject.scene.kind is not SceneKind.ARRAY:
            raise AttributeError("theorem4: the report is about a plain system, see verdict")
        return self.verdict

    @property
    def title(self) -> str:
        """What the report is about."""
        return self.document.title

    @property
    def sections(self) -> tuple[str, ...]:
        """The headings of its sections, in order."""
        return tuple(section.title for section in self.document.sections)

    def text(self, format: str = ".md") -> str:
        """The report in one format.

        Args:
            format: ``.md``, ``.html``, ``.tex`` or ``.json``.

        Raises:
            ValueError: for another format.
        """
        if format not in REPORT_FORMATS:
            raise ValueError(f"format: required one of {', '.join(REPORT_FORMATS)}, received {format!r}")
        return render_report(self, format)

    def facts(self) -> Record:
        """The JSON form of the report."""
        sections = [_section(section) for section in self.document.sections]
        head = {"schema": DERIVATION_SCHEMA, "title": self.document.title}
        return {**head, **self.subject.records, "sections": sections}

    def table(self) -> DataTable:
        """One line for each section."""
        return DataTable(("section",), [(title,) for title in self.sections])

    def blocks(self) -> Sequence[Block]:
        """What it is about, and its sections."""
        return [*sentences(self.title), findings(self._said())]

    def summary(self) -> str:
        """What it says in a line."""
        return self.headline or self.subject.headline

    def to_terminal(self) -> None:
        """Print it as Markdown."""
        write(self.text())

    def write_to(self, path: Path) -> None:
        """Write it; LaTeX after its figures, in a folder beside it: where there can be none, nothing is written."""
        suffix = path.suffix.lower()
        folder = path.with_name(f"{path.stem}-figures")
        figures = self.document.figures if suffix == ".tex" else ()
        files = {folder / f"{figure.key}.pdf": figure.draw(".pdf") for figure in figures}
        files[path] = render_report(self, suffix, folder.name).encode()
        for file, content in files.items():
            make_folder(file.parent)
            write_whole(file, content)

    def _said(self) -> list[tuple[str, str]]:
        return [("verdict", self.summary()), ("sections", ", ".join(self.sections))]

    def __repr__(self) -> str:
        return short_lines(self.title, self._said())


class NoSectionError(ValueError):
    """Sections that are not about a scene, in one line."""


def derive_report(
    scene: Scene | SwitchedSystem,
    invocation: Invocation | None = None,
    parts: tuple[str, ...] | None = None,
    announce: Announce = unheard,
    *,
    brief: bool = False,
) -> ReportResult:
    """Check the scene and write the derivation down.

    Args:
        scene: an array, or a plain system.
        invocation: how the report was asked for, from which the commands that reproduce it and its figures follow;
            None for the scene as it stands.
        parts: names of the sections to write, see :data:`nonsmooth.reports.derivations.parts.PARTS`; all unless given.
        announce: hears the steps of the check and the names of the sections.
        brief: of an array, two pages for somebody who decides in place of the sections.

    Raises:
        RefusalError: where the motion is not determined.
        NoSectionError: where none of these sections is about the scene.
    """
    chosen = names_of(scene.kind) if parts is None else parts
    subject = subject_of(scene.kind)(scene, invocation or Invocation(scene.origin), chosen, announce)
    if brief and isinstance(subject, ArraySubject):
        answers = ", ".join(f"{answer.name} {answer.verdict}" for answer in subject.answers.rows)
        return ReportResult(brief_document(subject), subject, answers)
    title, sections = f"Derivation report: {one_line(scene.name)}", tuple(sections_of(subject))
    if not sections:
        lacks = "; ".join(f"{name}: {why}" for name, why in lacking(subject)) or ", ".join(chosen)
        raise NoSectionError(f"only: required a section that is about this scene, received none ({lacks})")
    return ReportResult(Document(title, sections), subject)


def render_report(report: ReportResult, suffix: str, figures: str = "figures") -> str:
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
            return json_text(report.facts())


# ---- the study -----------------------------------------------------------------------------------


def complete_part(incomplete: str) -> list[str]:
    """Names of sections, the last of a list with commas, for the shell."""
    first, comma, last = incomplete.rpartition(",")
    return [f"{first}{comma}{name}" for name in names_of(SceneKind.ARRAY) if name.startswith(last)]


@dataclass(frozen=True, kw_only=True)
class DeriveOptions(Options):
    """Which sections are written."""

    only: str | Sequence[str] | None = option(
        None,
        "Only these sections, such as verdict,cells; a wrong name lists all.",
        str | None,
        metavar="NAMES",
        complete=complete_part,
    )
    without: str | Sequence[str] | None = option(
        None,
        "All sections but these, such as precision,stress.",
        str | None,
        metavar="NAMES",
        complete=complete_part,
    )
    brief: bool = option(
        False, "Two pages for somebody who decides: answers, picture, what binds, the law, what is not decided."
    )
    file: Path | None = field(default=None)  # that the command writes, which the report names

    def parts(self, kind: SceneKind) -> tuple[str, ...]:
        """The sections to write.

        Raises:
            ValueError: for a name that is none, beginning with ``only`` or ``without``.
        """
        chosen = {"only": _names(self.only), "without": _names(self.without)}
        for name, names in chosen.items():
            try:
                chosen_parts(names, (), kind)
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from None
        return chosen_parts(chosen["only"], chosen["without"], kind)


def _names(given: str | Sequence[str] | None) -> list[str]:
    if given is None:
        return []
    is_list = isinstance(given, Iterable) and not isinstance(given, str)
    listed = map(str, given) if is_list else str(given).split(",")
    return [name.strip() for name in listed]


class NamedScene(NamedTuple):
    """A scene, and how it was asked for."""

    scene: Any
    invocation: Invocation | None = None

    @property
    def kind(self) -> SceneKind:
        """That of the scene."""
        kind: SceneKind = self.scene.kind
        return kind


class DeriveStudy(SceneStudy[DeriveOptions]):
    """The derivation report."""

    options = DeriveOptions
    files = "Report: .html, .tex, .md or .json."

    def endings(self, options: DeriveOptions) -> Collection[str]:
        """Those of reports."""
        return REPORT_FORMATS

    def settled(self, options: DeriveOptions, path: Path | None) -> DeriveOptions:
        """The report says how it was written."""
        return replace(options, file=path)

    def load(self, scene: str, options: DeriveOptions, **changes: Any) -> NamedScene:
        """The scene that is named, and by which words."""
        loaded = super().load(scene, options, **changes)
        of_scene = _given(**changes)
        rest = _given(only=options.only, without=options.without, brief=options.brief)
        rest += ("-o", str(options.file)) if options.file is not None else ()
        return NamedScene(loaded, Invocation(scene, of_scene, rest))

    def refuse(self, asked: StudyRequest[DeriveOptions], path: Path | None) -> None:
        """Refuse what arrays alone have, and sections that there are not."""
        if asked.kind is SceneKind.SYSTEM:
            asked.refuse(("allow_outside", "brief"), "an array of wheels", "a plain system")
        if asked.options.brief:
            asked.refuse(("only", "without"), "a report of all sections", "--brief")
        with option_named(ValueError):
            asked.options.parts(asked.kind)

    def run(self, scene: NamedScene, options: DeriveOptions) -> ReportResult:
        """Check, and write the derivation."""
        loaded = scene.scene
        if scene.kind is SceneKind.ARRAY:
            from nonsmooth.symbolic.mechanics.contact_set import standing

            require_resolved(loaded)
            loaded = standing(loaded)
        with option_named(NoSectionError), refusals_named(loaded), steps("derivation") as announce:
            return derive_report(loaded, scene.invocation, options.parts(scene.kind), announce, brief=options.brief)


DERIVE = DeriveStudy()


def _given(**options: Any) -> tuple[str, ...]:
    """Flag and value of the options that were given."""
    given: list[str] = []
    for name, value in options.items():
        flag = f"--{name.replace('_', '-')}"
        if value is True:
            given.append(flag)
        elif value not in (None, False):
            given += [flag, str(value)]
    return tuple(given)


# ---- the report as JSON --------------------------------------------------------------------------
#
# Reports as JSON: the document's blocks in order, beside the exact records of the results.


DERIVATION_SCHEMA = "nonsmooth-derivation/1"


def _section(section: Section) -> Record:
    return {
        "title": section.title,
        "blocks": [_block(block) for block in section.blocks],
        "subsections": [_section(subsection) for subsection in section.subsections],
    }


def _block(block: Block) -> Record:
    match block:
        case Paragraph(text):
            return {"kind": "paragraph", "text": _text(text)}
        case Display(formula):
            return {"kind": "formula", **_inline(formula)}
        case Bullets(items):
            return {"kind": "list", "items": [_text(item) for item in items]}
        case Table():
            rows = [[_text(entry) for entry in row] for row in block.rows]
            return {"kind": "table", "header": [_text(entry) for entry in block.header], "rows": rows}
        case Listing(text):
            return {"kind": "listing", "text": text}
        case Figure():
            return {"kind": "figure", "key": block.key, "caption": _text(block.caption), "command": block.command}


def _text(text: Text) -> list[Any]:
    return [_inline(part) for part in text]


def _inline(part: Inline) -> Any:
    match part:
        case Math(latex, plain):
            return {"latex": latex, "plain": plain}
        case Code(text):
            return {"code": text}
        case Verdict(text):
            return {"verdict": text}
        case str():
            return part
