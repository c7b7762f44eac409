"""Reports as Markdown (CommonMark with tables and dollar mathematics, as GitHub and Pandoc read it)."""

from __future__ import annotations

import re

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
)

_SPECIAL = re.compile(r"([\\`*_{}\[\]<>#|~$^&])")
_BULLET = re.compile(r"(?m)^(\s*)([-+]|\d+\.)(?=\s)")


def render_markdown(document: Document) -> str:
    """The document as Markdown text, ending in a newline."""
    parts = [f"# {_escaped(document.title)}"]
    for section in document.sections:
        parts += _section(section, 2)
    return "\n\n".join(parts) + "\n"


def _section(section: Section, level: int) -> list[str]:
    parts = [f"{'#' * level} {_escaped(section.title)}"]
    parts += [_block(block) for block in section.blocks]
    for subsection in section.subsections:
        parts += _section(subsection, level + 1)
    return parts


def _block(block: Block) -> str:
    match block:
        case Paragraph(text):
            return _text(text)
        case Display(formula):
            return f"$$\n{formula.latex}\n$$"
        case Bullets(items):
            return "\n".join(f"- {_text(item)}" for item in items)
        case Table():
            return _table(block)
        case Listing(text):
            return f"```\n{text}\n```"
        case Figure():
            return f"**Figure.** {_text(block.caption)} Drawn by {_inline(Code(block.command))}."


def _table(block: Table) -> str:
    rows = [block.header or ((),) * len(block.widths), *block.rows]  # a table of Markdown has a head
    lines = ["| " + " | ".join(_text(entry) for entry in row) + " |" for row in rows]
    lines.insert(1, "|" + " --- |" * len(block.widths))
    return "\n".join(lines)


def _text(text: Text) -> str:
    return _BULLET.sub(r"\1\\\2", "".join(_inline(part) for part in text))


def _inline(part: Inline) -> str:
    match part:
        case Math(latex, _):
            line = " ".join(latex.replace(r"\allowbreak", "").split()).replace("|", r"\vert ")
            return f"${line}$"  # a bar inside mathematics would end a table's column
        case Code(text):
            fence = "``" if "`" in text else "`"
            return f"{fence}{text.replace('|', chr(92) + '|')}{fence}"
        case Verdict(text):
            return f"**{_escaped(text)}**"
        case str():
            return _escaped(part)


def _escaped(text: str) -> str:
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()) if "\n" in text else text)
