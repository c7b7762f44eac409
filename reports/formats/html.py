"""Reports as one HTML page: no server, no network, readable and printable with scripts off.

Formulas are MathML, figures inline SVG.  A content security policy forbids every request and every script but the
page's own.  The script links what is about the same cell and moves the slider of a figure; without it the links work
as links, and a figure shows its first frame.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from nonsmooth.reports.output.document import (
    Block,
    Code,
    Document,
    Figure,
    Inline,
    Math,
    Section,
    Table,
    Text,
    Verdict,
    every_section,
    plain_text,
)

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
    environment.globals |= {"page": page, "style": _markup(template_part("report.css"))}
    environment.globals |= {
        "script": _markup(template_part("report.js")),
        "script_hash": script_hash(template_part("report.js")),
    }
    return environment.from_string(template_part("report.html.j2")).render(document=document) + "\n"


@dataclass(frozen=True)
class _Page:
    """Names and links of the page."""

    document: Document

    @cached_property
    def names(self) -> dict[int, str]:
        """An id for every section, by identity: its title in lower case, numbered where titles repeat."""
        names: dict[int, str] = {}
        for section in every_section(self.document.sections):
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
        for section in every_section(self.document.sections):
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
    length = len(plain_text(text))
    return _markup(' class="short"' if length < SHORT else ' class="long"' if length > LONG else "")


def _display(block: Block) -> Markup:
    return _markup("".join(display_mathml(block.formula.latex)))  # type: ignore[union-attr]


def template_part(name: str) -> str:
    """A template, or what it includes."""
    return files("nonsmooth.reports.formats").joinpath("templates", name).read_text(encoding="utf-8")


def _markup(text: str) -> Markup:
    from markupsafe import Markup

    return Markup(text)


def script_hash(script: str) -> str:
    """By which a page allows its own script and no other."""
    return "sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


# ---- pictures ------------------------------------------------------------------------------------
#
# Matplotlib writes a whole file with fixed size and colors.  Inside a page the size is the column's, the ink follows
# the page's text (light or dark), and every id carries the figure's key, since several figures share one page.  Pieces
# whose id is a mark (``cell-3``) become links to what else is about that mark.


_SVG, _XLINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}"
_MARK = re.compile(r"((?:cell|start)-\d+)(?:--[\w-]+)?")
_REFERENCE = re.compile(r"url\(#([^)]+)\)")
_PAGE_COLORS = {"#222222": "currentColor", "#ffffff": "var(--paper)"}  # Matplotlib writes colors in lower case
LEAST = 0.65  # of its own width, below which a figure's labels could not be read: then it scrolls
_COLOR = re.compile("|".join(_PAGE_COLORS))


def inline_svg(figure: Figure, svg: bytes, targets: Mapping[str, str]) -> str:
    """The picture as an ``<svg>`` element.

    Args:
        figure: key, description and frames.
        svg: the file that it drew.
        targets: id of the element of the page to which a mark links.
    """
    root = ET.fromstring(svg)
    _simplify(root)
    _rename(root, figure.key)
    _adapt_colors(root)
    linked = _mark_pieces(root, figure, targets)
    _frame(root, figure, interactive=linked)
    return ET.tostring(root, encoding="unicode").replace("xlink:href", "href") + "\n"


def marks_of(svg: bytes) -> list[str]:
    """The marks that pieces of a picture carry, each once."""
    ids = (element.get("id", "") for element in ET.fromstring(svg).iter())
    return list(dict.fromkeys(match.group(1) for match in map(_MARK.fullmatch, ids) if match))


def _simplify(root: ET.Element) -> None:
    """Drop metadata and style sheets, and write elements without namespaces, as HTML holds them."""
    for parent in root.iter():
        for child in list(parent):
            if child.tag in {f"{_SVG}metadata", f"{_SVG}style"}:
                parent.remove(child)
    for element in root.iter():
        element.tag = element.tag.removeprefix(_SVG)
        for name in list(element.attrib):
            if name == f"{_XLINK}href":
                element.set("href", element.attrib.pop(name))
        element.text, element.tail = (part if part and part.strip() else None for part in (element.text, element.tail))


def _rename(root: ET.Element, key: str) -> None:
    """Keep the ids that are referred to, or are marks, behind the figure's key; drop the others."""
    used = {element.get("href", "")[1:] for element in root.iter()}
    used |= {name for element in root.iter() for value in element.attrib.values() for name in _REFERENCE.findall(value)}
    for element in root.iter():
        name = element.get("id")
        if name is not None and (name in used or _MARK.fullmatch(name)):
            element.set("id", f"{key}-{name}")
        elif name is not None:
            del element.attrib["id"]
        if element.get("href", "").startswith("#"):
            element.set("href", f"#{key}-{element.attrib['href'][1:]}")
        for attribute, value in element.attrib.items():
            element.set(attribute, _REFERENCE.sub(rf"url(#{key}-\1)", value))


def _adapt_colors(root: ET.Element) -> None:
    for element in root.iter():
        style = element.get("style")
        if style:
            element.set("style", _COLOR.sub(lambda match: _PAGE_COLORS[match.group()], style))


def _mark_pieces(root: ET.Element, figure: Figure, targets: Mapping[str, str]) -> bool:
    """Say what each marked piece is about, link it, and hide the frames after the first; whether there are links."""
    frames = {frame.mark: number for number, frame in enumerate(figure.frames)}
    linked = False
    for parent, piece, mark in list(_pieces(root, figure.key)):
        piece.set("data-about", mark)
        if mark in frames:
            piece.set("data-frame", str(frames[mark]))
            if frames[mark]:
                piece.set("class", "later")
        elif mark in targets:
            link = ET.Element("a", {"href": f"#{targets[mark]}", "aria-label": mark.replace("-", " ")})
            parent.insert(list(parent).index(piece), link)
            parent.remove(piece)
            link.append(piece)
            linked = True
    return linked


def _pieces(root: ET.Element, key: str) -> Iterator[tuple[ET.Element, ET.Element, str]]:
    for parent in root.iter():
        for child in list(parent):
            match = _MARK.fullmatch(child.get("id", "").removeprefix(f"{key}-"))
            if match:
                yield parent, child, match.group(1)


def _frame(root: ET.Element, figure: Figure, *, interactive: bool) -> None:
    """Size, role and description; a picture with links is a group, so that these stay reachable."""
    width = float(root.get("width", "0").removesuffix("pt"))
    for attribute in ("width", "height", "version"):
        root.attrib.pop(attribute, None)
    root.set("role", "group" if interactive else "img")
    root.set("aria-label", figure.description)
    natural = width * 4 / 3
    root.set("style", f"max-width: {natural:.0f}px; min-width: {LEAST * natural:.0f}px")


# ---- formulas ------------------------------------------------------------------------------------
#
# latex2mathml translates; here its gaps are bridged (``aligned``, bars, words and named operators are written as what
# it knows) and its output is checked: anything but known elements and attributes, or a command it passed on unread, is
# an error and not a report.  A formula is cut where its LaTeX says that a line may break, since browsers break no line
# inside MathML.


NAMESPACE = "http://www.w3.org/1998/Math/MathML"
ELEMENTS = frozenset({
    "math", "mrow", "mi", "mn", "mo", "mtext", "mspace", "mfrac", "msqrt", "msup", "msub", "msubsup", "mover", "munder",
    "munderover", "mtable", "mtr", "mtd", "mstyle",
})  # fmt: skip
ATTRIBUTES = frozenset({
    "display", "displaystyle", "width", "linebreak", "stretchy", "fence", "form", "columnalign", "columnspacing",
    "rowspacing",
})  # fmt: skip
_KNOWN = (
    (r"{aligned}", r"{split}"),
    (r"\tfrac", r"\frac"),
    (r"\lvert", r"\left|"),  # fences, so that bars are set like brackets
    (r"\rvert", r"\right|"),
)
_OPERATOR = re.compile(r"\\operatorname\{(\w+)\}\s*(?=(\(|\\left|\\\{)?)")
_WORD = re.compile(r"\\mathit\{((?:[^{}\\]|\\_)+)\}")  # a state whose name is a word: `x1`, `speed\_of\_mass`
_TOKENS = re.compile(r"\\allowbreak\\ |\\qquad\s?|\\(?:begin|end|left|right)(?![a-z])|\\.|[{}]|[^\\{}]+", re.DOTALL)
_OPENING, _CLOSING = (r"\begin", r"\left", "{"), (r"\end", r"\right", "}")


def inline_mathml(latex: str) -> list[str]:
    r"""A formula of running text as ``<math>`` elements, between which a line may break (at ``\allowbreak``)."""
    return [_mathml(part, "inline") for part in _parts(latex, r"\allowbreak\ ")]


def display_mathml(latex: str) -> list[str]:
    r"""A displayed formula as ``<math>`` elements that stand beside each other where there is room (at ``\qquad``)."""
    return [_mathml(part, "block") for part in _parts(latex, r"\qquad")]


def _parts(latex: str, separator: str) -> list[str]:
    """The formula cut at separators outside all braces and environments."""
    parts, depth = [""], 0
    for token in _TOKENS.findall(latex):
        depth += (token in _OPENING) - (token in _CLOSING)
        if token.strip() == separator.strip() and not depth:
            parts.append("")
        else:
            parts[-1] += token
    return [part.strip() for part in parts if part.strip()]


@lru_cache(maxsize=4096)
def _mathml(latex: str, mode: str) -> str:
    from latex2mathml.converter import convert

    source = _OPERATOR.sub(_operator, latex.replace(r"\allowbreak", ""))
    source = _WORD.sub(_word, source)
    for ours, theirs in _KNOWN:
        source = source.replace(ours, theirs)
    markup = convert(source, display=mode)
    _require_mathml(latex, markup)
    return markup.replace(f' xmlns="{NAMESPACE}"', "").replace(' display="inline"', "")


def _word(match: re.Match[str]) -> str:
    """The name of a state as text, which escapes nothing."""
    return rf"\text{{{match[1]}}}".replace(r"\_", "_")


def _operator(match: re.Match[str]) -> str:
    """A named operator as text, with a thin space before an argument without brackets."""
    return rf"\text{{{match.group(1)}}}" + ("" if match.group(2) else r"\, ")


def _require_mathml(latex: str, markup: str) -> None:
    try:
        elements = list(ET.fromstring(markup).iter())
    except ET.ParseError:
        elements = []
    strange = {element.tag.removeprefix(f"{{{NAMESPACE}}}") for element in elements} - ELEMENTS
    strange |= {name for element in elements for name in element.attrib} - ATTRIBUTES
    unread = any(c in (element.text or "") for element in elements for c in "\\&")
    if not elements or strange or unread:
        raise ValueError(f"required LaTeX that becomes MathML, received {latex!r}")
