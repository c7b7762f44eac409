"""A section of a report under its name on the command line, and the choice among the sections of a report."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from nonsmooth.proofs.clauses.workspace import Announce
from nonsmooth.reports.document import Section


class ReportSubject(Protocol):
    """What a report is about."""

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the sections that are written."""
        ...

    @property
    def announce(self) -> Announce:
        """Hears the names of the sections."""
        ...


Subject = TypeVar("Subject", bound=ReportSubject)


def always(subject: Any) -> str:
    """Of a section that every subject has."""
    return ""


@dataclass(frozen=True)
class ReportPart(Generic[Subject]):
    """A section under its name on the command line.

    Attributes:
        name: for ``--only`` and ``--without``.
        build: the section.
        lacks: why the subject has no such section; empty where it has.
    """

    name: str
    build: Callable[[Subject], Section]
    lacks: Callable[[Subject], str] = always


def sections_of(parts: Iterable[ReportPart[Subject]], subject: Subject) -> Iterator[Section]:
    """The sections that the subject asks for and has, each announced before it is built."""
    for part in parts:
        if part.name in subject.parts and not part.lacks(subject):
            subject.announce(f"section {part.name}")
            yield part.build(subject)


def chosen_names(names: tuple[str, ...], only: Collection[str], without: Collection[str]) -> tuple[str, ...]:
    """Names of the sections to write: those of ``only``, or all, less those of ``without``.

    Raises:
        ValueError: for a name that is none.
    """
    unknown = next((name for name in (*only, *without) if name not in names), None)
    if unknown is not None:
        raise ValueError(f"required names among {', '.join(names)}, received {unknown[:60]!r}")
    return tuple(name for name in names if (not only or name in only) and name not in without)
