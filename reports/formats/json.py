"""Reports as JSON: the document's blocks in order, beside the exact records of the results."""

from __future__ import annotations

from typing import Any

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
from nonsmooth.reports.output.facts import Record

DERIVATION_SCHEMA = "nonsmooth-derivation/1"


def derivation_record(document: Document, records: Record) -> Record:
    """The document and the records of the results it reports (``check``, ``partition``)."""
    sections = [_section(section) for section in document.sections]
    return {"schema": DERIVATION_SCHEMA, "title": document.title, **records, "sections": sections}


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
