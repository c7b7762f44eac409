"""The derivation report as a script or a notebook holds it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.proofs.clauses.workspace import Announce, unheard
from nonsmooth.reports.derivation import (
    REPORT_FORMATS,
    Report,
    derive_report,
    render_report,
    write_report,
)
from nonsmooth.reports.files import output_path
from nonsmooth.reports.parts import chosen_parts
from nonsmooth.reports.short_text import short_lines
from nonsmooth.reports.subject import ArraySubject, Subject

if TYPE_CHECKING:
    from nonsmooth.reports.subject import Invocation
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True, repr=False)
class ReportResult:
    """A derivation report, not yet written down.

    Attributes:
        report: the document, and the check that it reports.
    """

    report: Report

    @property
    def verdict(self) -> str:
        """Of Theorem 4 for an array, of stability for a plain system."""
        return str(self.report.result.verdict)

    @property
    def theorem4(self) -> str:
        """The verdict of Theorem 4.

        Raises:
            AttributeError: for the report of a plain system.
        """
        if not isinstance(self.report.subject, ArraySubject):
            raise AttributeError("theorem4: the report is about a plain system, see verdict")
        return self.verdict

    @property
    def title(self) -> str:
        """What the report is about."""
        return self.report.document.title

    @property
    def sections(self) -> tuple[str, ...]:
        """The headings of its sections, in order."""
        return tuple(section.title for section in self.report.document.sections)

    def text(self, format: str = ".md") -> str:
        """The report in one format.

        Args:
            format: ``.md``, ``.html``, ``.tex`` or ``.json``.

        Raises:
            ValueError: for another format.
        """
        if format not in REPORT_FORMATS:
            raise ValueError(f"format: required one of {', '.join(REPORT_FORMATS)}, received {format!r}")
        return render_report(self.report, format)

    def save(self, file: str | Path) -> Path:
        """Write it to a file whose name ends in its format; .tex with its figures in a folder beside it.

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
        """
        path = output_path(str(file), REPORT_FORMATS)
        write_report(self.report, path)
        return path

    def __repr__(self) -> str:
        return short_lines(
            self.title, [("verdict", self.report.subject.headline), ("sections", ", ".join(self.sections))]
        )


def named_parts(
    only: str | Sequence[str] | None, without: str | Sequence[str] | None, kind: type[Subject] = ArraySubject
) -> tuple[str, ...]:
    """The sections to write, of names in a sequence or in a text with commas.

    Args:
        only: these, or all.
        without: less these.
        kind: of what the report is about.

    Raises:
        ValueError: for a name that is none, beginning with ``only`` or ``without``.
    """
    chosen = {"only": _names(only), "without": _names(without)}
    for option, names in chosen.items():
        try:
            chosen_parts(names, (), kind)
        except ValueError as error:
            raise ValueError(f"{option}: {error}") from None
    return chosen_parts(chosen["only"], chosen["without"], kind)


def _names(given: str | Sequence[str] | None) -> list[str]:
    if given is None:
        return []
    return [name.strip() for name in given.split(",")] if isinstance(given, str) else list(given)


def derive_scene(
    scene: Scene | SwitchedSystem,
    parts: tuple[str, ...] | None = None,
    *,
    invocation: Invocation | None = None,
    announce: Announce = unheard,
) -> ReportResult:
    """Check a scene and write its derivation; the evidence is verified before anything is written.

    Args:
        scene: an array, or a plain system in two states.
        parts: names of the sections to write; all unless given.
        invocation: how the report was asked for; None for the scene as it stands.
        announce: hears the steps of the check and the names of the sections.

    Raises:
        RefusalError: where the motion is not determined.
        SceneError: for a plain system in another number of states.
    """
    return ReportResult(derive_report(scene, invocation, parts, announce))
