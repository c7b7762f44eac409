"""One document model for all report formats: sections, paragraphs, formulas, tables, lists and figures.

Every formula carries LaTeX and plain text, so a renderer never converts one into the other.  Running text is a
tuple of strings, formulas and code; strings are literal and escaped by the renderer.  Marks such as ``cell-3`` say
what a section, a row or a piece of a figure is about; a format that can link ties equal marks together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any, TypeAlias

from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import (
    SHORT,
    Real,
    decimal_latex,
    decimal_text,
    plain_decimal,
    real_text,
    settled,
)


@dataclass(frozen=True)
class Math:
    """A formula in both notations."""

    latex: str
    plain: str


@dataclass(frozen=True)
class Code:
    """A command or name, set in a fixed-width font."""

    text: str


class Tone(StrEnum):
    """How a verdict looks: a color repeats what its word says."""

    GOOD = "good"
    FAIR = "fair"
    BAD = "bad"
    OPEN = "open"


@dataclass(frozen=True)
class Verdict:
    """The word of an answer."""

    text: str
    tone: Tone


Inline: TypeAlias = str | Math | Code | Verdict
Text: TypeAlias = tuple[Inline, ...]
Entry: TypeAlias = Inline | Text
Marks: TypeAlias = tuple[str, ...]


@dataclass(frozen=True)
class Paragraph:
    """Running text."""

    text: Text


@dataclass(frozen=True)
class Display:
    """A formula on lines of its own."""

    formula: Math


@dataclass(frozen=True)
class Bullets:
    """A list without order."""

    items: tuple[Text, ...]


@dataclass(frozen=True, repr=False)
class Table(ShortRepr):
    """Rows under a header; ``widths`` are the columns' shares of the line, ``marks`` what each row is about, if any.

    Without a header (empty) each row is a name and what is found.
    """

    header: tuple[Text, ...]
    rows: tuple[tuple[Text, ...], ...]
    widths: tuple[float, ...]
    marks: tuple[Marks, ...] = ()

    def __post_init__(self) -> None:
        """Refuse rows and widths that do not fit the header."""
        columns = {len(self.header or self.widths), len(self.widths), *(len(row) for row in self.rows)}
        if len(columns) > 1:
            raise ValueError(f"required one width and one entry per column, received {sorted(columns)} of them")
        if self.marks and len(self.marks) != len(self.rows):
            raise ValueError(f"required marks for {len(self.rows)} rows or none, received {len(self.marks)}")


@dataclass(frozen=True)
class Frame:
    """One of the pictures that a figure holds in turn: its mark, and in words what it shows."""

    mark: str
    label: str


@dataclass(frozen=True)
class Figure:
    """A picture, drawn only by the formats that hold pictures.

    Attributes:
        key: its name in the document, such as ``cell-map``.
        caption: what it shows, beneath it.
        description: the same for those who cannot see it.
        command: draws it by itself.
        draw: the picture as a file of a format (``.svg``, ``.pdf``); in SVG the ``id`` of a piece is the mark it is
            about (``cell-3``), with ``--something`` behind it where several pieces are about one.
        frames: marks of pieces that are shown in turn, the first one where nothing can be chosen.
    """

    key: str
    caption: Text
    description: str
    command: str
    draw: Callable[[str], bytes] = field(repr=False, compare=False)
    frames: tuple[Frame, ...] = ()


@dataclass(frozen=True)
class Listing:
    """Lines of a file, as they are."""

    text: str


Block: TypeAlias = Paragraph | Display | Bullets | Table | Figure | Listing


@dataclass(frozen=True, repr=False)
class Section(ShortRepr):
    """A titled part with its blocks, then its subsections; ``marks`` say what it is about, if that can be marked."""

    title: str
    blocks: tuple[Block, ...]
    subsections: tuple[Section, ...] = ()
    marks: Marks = ()


@dataclass(frozen=True, repr=False)
class Document(ShortRepr):
    """A report."""

    title: str
    sections: tuple[Section, ...]

    @property
    def figures(self) -> tuple[Figure, ...]:
        """All figures, in order."""
        every = every_section(self.sections)
        return tuple(block for section in every for block in section.blocks if isinstance(block, Figure))


def every_section(sections: tuple[Section, ...]) -> Iterator[Section]:
    """All of them in order, each before those in it."""
    for section in sections:
        yield section
        yield from every_section(section.subsections)


def display(latex: str, plain: str) -> Display:
    """A displayed formula."""
    return Display(Math(latex, plain))


def table(
    header: Sequence[Entry],
    rows: Iterable[Sequence[Entry]],
    widths: tuple[float, ...] = (),
    marks: Iterable[Marks] = (),
) -> Table:
    """A table whose entries are single inlines or texts; its columns are equally wide unless told."""
    body = tuple(tuple(_text(entry) for entry in row) for row in rows)
    return Table(tuple(_text(entry) for entry in header), body, widths or (1.0,) * len(header), tuple(marks))


def without_empty_columns(shown: Table) -> Table:
    """The table without the columns in which no row says anything."""
    kept = [k for k in range(len(shown.header)) if any(plain_text(row[k]) for row in shown.rows)]

    def of(parts: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(parts[k] for k in kept)

    return replace(shown, header=of(shown.header), rows=tuple(map(of, shown.rows)), widths=of(shown.widths))


def sentences(*lines: str) -> list[Block]:
    """A paragraph for each line."""
    return [Paragraph((line,)) for line in lines]


def findings(rows: Iterable[tuple[str, str]]) -> Table:
    """Names, each with what is found, as literal text."""
    return table((), rows, (1.0, 3.0))


def plain_text(text: Text) -> str:
    """The characters that a text shows."""
    shown = []
    for part in text:
        shown.append(part if isinstance(part, str) else part.plain if isinstance(part, Math) else part.text)
    return "".join(shown)


def cell_mark(index: int) -> str:
    """What is about cell 3 carries the mark ``cell-3``."""
    return f"cell-{index}"


def _text(entry: Entry) -> Text:
    return entry if isinstance(entry, tuple) else (entry,)


def number(value: Real) -> Math:
    """An exact number where it is short, a decimal value otherwise (the JSON report holds it exactly)."""
    fixed = settled(value)
    plain = real_text(fixed)
    if isinstance(fixed, Number) and fixed.field.writes_decimals:
        return decimal(plain_decimal(fixed))
    if isinstance(fixed, Number) and len(plain) <= SHORT:
        from nonsmooth.symbolic.formulas.surfaces import number_latex

        return Math(number_latex(fixed), plain)
    rounded = decimal_text(value)
    return Math(rf"\approx {decimal_latex(rounded)}", f"~ {rounded}")


def decimal(text: str) -> Math:
    """A number that is written as a decimal already (:mod:`nonsmooth.symbolic.numbers.number_text`)."""
    return Math(decimal_latex(text), text)


def point(values: Iterable[Real]) -> Math:
    """``(a, b, ...)``; a line may break after a comma."""
    parts = [number(value) for value in values]
    latex = r",\allowbreak\ ".join(part.latex for part in parts)
    return Math(f"({latex})", f"({', '.join(part.plain for part in parts)})")


def matrix(rows: Iterable[Iterable[Real]]) -> Math:
    """A matrix."""
    entries = [[number(value) for value in row] for row in rows]
    latex = r" \\ ".join(" & ".join(entry.latex for entry in row) for row in entries)
    plain = "; ".join(", ".join(entry.plain for entry in row) for row in entries)
    return Math(rf"\begin{{pmatrix}} {latex} \end{{pmatrix}}", f"[{plain}]")


def column(values: Iterable[Real]) -> Math:
    """A column vector."""
    return matrix([value] for value in values)
