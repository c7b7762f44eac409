"""Figures as SVG inside a page: scalable, in the page's ink, with links, and with ids that occur once.

Matplotlib writes a whole file with fixed size and colors.  Inside a page the size is the column's, the ink follows
the page's text (light or dark), and every id carries the figure's key, since several figures share one page.  Pieces
whose id is a mark (``cell-3``) become links to what else is about that mark.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from xml.etree import ElementTree as ET

from nonsmooth.reports.document import Figure

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
