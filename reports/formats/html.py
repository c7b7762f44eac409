"""Reports as one HTML page: no server, no network, readable and printable with scripts off.

Formulas are MathML, figures inline SVG.  A content security policy forbids every request and every script but the
page's own.  The script links what is about the same cell and moves the slider of a figure; without it the links work
as links, and a figure shows its first frame.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from typing import TYPE_CHECKING

from nonsmooth.reports.document import Block, Code, Document, Figure, Inline, Math, Section, Table, Text, Verdict
from nonsmooth.reports.formats.inline_svg import inline_svg, marks_of
from nonsmooth.reports.formats.mathml import display_mathml, inline_mathml

if TYPE_CHECKING:
    from markupsafe import Markup

_PUNCTUATION, _END = re.compile(r"[.,;:)]+"), ("</math>", "</span>")
SHORT, LONG = 18, 44  # characters of a table's entry up to which it is one line, from which it needs a wide column
WIDE = 32  # characters of plain text from which a formula of running text may need to scroll on a phone


def render_html(document: Document) -> str:
    """The document as one HTML page, ending in a newline."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page = _Page(document)
    environment.filters |= {"text": _text, "display": _display, "svg": page.svg, "room": _room}
    environment.filters["kind"] = lambda block: type(block).__name__
    environment.globals |= {"page": page, "style": _markup(_part("report.css"))}
    environment.globals |= {"script": _markup(_part("report.js")), "script_hash": _hash(_part("report.js"))}
    return environment.from_string(_part("report.html.j2")).render(document=document) + "\n"


@dataclass(frozen=True)
class _Page:
    """Names and links of the page."""

    document: Document

    @cached_property
    def names(self) -> dict[int, str]:
        """An id for every section, by identity: its title in lower case, numbered where titles repeat."""
        names: dict[int, str] = {}
        for section in _sections(self.document.sections):
            slug = re.sub(r"[^a-z0-9]+", "-", section.title.lower()).strip("-") or "section"
            taken = set(names.values())
            free = (slug if k == 1 else f"{slug}-{k}" for k in range(1, len(taken) + 2))
            names[id(section)] = next(name for name in free if name not in taken)
        return names

    @cached_property
    def drawn(self) -> dict[str, bytes]:
        """The figures' SVG by key."""
        return {figure.key: figure.draw(".svg") for figure in self.document.figures}

    @cached_property
    def in_sections(self) -> dict[str, str]:
        """The section about a mark, by id."""
        targets: dict[str, str] = {}
        for section in _sections(self.document.sections):
            for mark in section.marks:
                targets.setdefault(mark, self.names[id(section)])
        return targets

    @cached_property
    def in_figures(self) -> dict[str, str]:
        """The first piece of a figure about a mark, by id."""
        targets: dict[str, str] = {}
        for figure in self.document.figures:
            framed = {frame.mark for frame in figure.frames}
            for mark in marks_of(self.drawn[figure.key]):
                if mark not in framed:
                    targets.setdefault(mark, f"{figure.key}-{mark}")
        return targets

    def name(self, section: Section) -> str:
        """Id of a section."""
        return self.names[id(section)]

    def svg(self, figure: Figure) -> Markup:
        """A figure as an SVG element with its links."""
        return _markup(inline_svg(figure, self.drawn[figure.key], self.in_sections))

    def link(self, marks: tuple[str, ...]) -> str:
        """Where the first of some marks is drawn; empty where none is."""
        return next((self.in_figures[mark] for mark in marks if mark in self.in_figures), "")

    def frame(self, marks: tuple[str, ...]) -> str:
        """The first of some marks that is a frame of a figure; empty where none is."""
        framed = {frame.mark for figure in self.document.figures for frame in figure.frames}
        return next((mark for mark in marks if mark in framed), "")

    def marks_of_row(self, block: Table, row: int) -> tuple[str, ...]:
        """What a row is about."""
        return block.marks[row] if block.marks else ()


def _sections(sections: tuple[Section, ...]) -> Iterator[Section]:
    for section in sections:
        yield section
        yield from _sections(section.subsections)


def _text(text: Text) -> Markup:
    """Running text; literal strings are escaped, and no line begins with the punctuation after a formula."""
    parts: list[str] = []
    for part in text:
        ahead = _PUNCTUATION.match(part) if isinstance(part, str) and parts and parts[-1].endswith(_END) else None
        if ahead is not None and isinstance(part, str):
            parts[-1] = f'<span class="keep">{parts[-1]}{ahead.group()}</span>'
            parts.append(_inline(part[ahead.end() :]))
        else:
            parts.append(_inline(part))
    return _markup("".join(parts))


def _inline(part: Inline) -> str:
    from markupsafe import escape

    match part:
        case Math(latex, plain):
            pieces = inline_mathml(latex)
            if len(plain) < WIDE:
                return f'<span class="keep">{" ".join(pieces)}</span>' if len(pieces) > 1 else pieces[0]
            return " ".join(pieces) if len(pieces) > 1 else f'<span class="scroll">{pieces[0]}</span>'
        case Code(text):
            return f"<code>{escape(text)}</code>"
        case Verdict(text, tone):
            return f'<strong class="{tone}">{escape(text)}</strong>'
        case str():
            return str(escape(part))


def _room(text: Text) -> Markup:
    """The class of a table's entry: short ones stay on one line, long ones have room to wrap."""
    length = sum(len(_plain(part)) for part in text)
    return _markup(' class="short"' if length < SHORT else ' class="long"' if length > LONG else "")


def _plain(part: Inline) -> str:
    """The characters that a part shows."""
    match part:
        case Math(_, plain):
            return plain
        case Code(text) | Verdict(text):
            return text
        case str():
            return part


def _display(block: Block) -> Markup:
    return _markup("".join(display_mathml(block.formula.latex)))  # type: ignore[union-attr]


def _part(name: str) -> str:
    return files("nonsmooth.reports.formats").joinpath("templates", name).read_text(encoding="utf-8")


def _markup(text: str) -> Markup:
    from markupsafe import Markup

    return Markup(text)


def _hash(script: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
