"""One document model for all report formats: sections, paragraphs, formulas, tables and lists.

Every formula carries LaTeX and plain text, so a renderer never converts one into the other.  Running text is a
tuple of strings, formulas and code; strings are literal and escaped by the renderer.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from nonsmooth.symbolic.formulas import SHORT, Real, decimal_latex, decimal_text, number_latex, real_text, settled
from nonsmooth.symbolic.numbers.number import Number


@dataclass(frozen=True)
class Math:
    """A formula in both notations."""

    latex: str
    plain: str


@dataclass(frozen=True)
class Code:
    """A command or name, set in a fixed-width font."""

    text: str


Inline: TypeAlias = str | Math | Code
Text: TypeAlias = tuple[Inline, ...]
Entry: TypeAlias = Inline | Text


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


@dataclass(frozen=True)
class Table:
    """Rows under a header; ``widths`` are the columns' shares of the line."""

    header: tuple[Text, ...]
    rows: tuple[tuple[Text, ...], ...]
    widths: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse rows and widths that do not fit the header."""
        columns = {len(self.header), len(self.widths), *(len(row) for row in self.rows)}
        if len(columns) > 1:
            raise ValueError(f"required one width and one entry per column, received {sorted(columns)} of them")


Block: TypeAlias = Paragraph | Display | Bullets | Table


@dataclass(frozen=True)
class Section:
    """A titled part with its blocks, then its subsections."""

    title: str
    blocks: tuple[Block, ...]
    subsections: tuple[Section, ...] = ()


@dataclass(frozen=True)
class Document:
    """A report."""

    title: str
    sections: tuple[Section, ...]


def display(latex: str, plain: str) -> Display:
    """A displayed formula."""
    return Display(Math(latex, plain))


def table(header: Sequence[Entry], rows: Iterable[Sequence[Entry]], widths: tuple[float, ...]) -> Table:
    """A table whose entries are single inlines or texts."""
    body = tuple(tuple(_text(entry) for entry in row) for row in rows)
    return Table(tuple(_text(entry) for entry in header), body, widths)


def _text(entry: Entry) -> Text:
    return entry if isinstance(entry, tuple) else (entry,)


def number(value: Real) -> Math:
    """An exact number where it is short, a decimal value otherwise (the JSON report holds it exactly)."""
    fixed = settled(value)
    plain = real_text(fixed)
    if isinstance(fixed, Number) and len(plain) <= SHORT:
        return Math(number_latex(fixed), plain)
    decimal = decimal_text(value)
    return Math(rf"\approx {decimal_latex(decimal)}", f"~ {decimal}")


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
