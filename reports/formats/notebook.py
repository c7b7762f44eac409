"""Blocks of a result as HTML for a notebook: paragraphs and plain tables, without style and script."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from nonsmooth.reports.document import Block, Paragraph, Table, plain_text
from nonsmooth.symbolic.notebook import html_table


def notebook_html(blocks: Iterable[Block]) -> str:
    """Paragraphs and tables; every text is escaped."""
    return "".join(_block(block) for block in blocks)


def _block(block: Block) -> str:
    match block:
        case Paragraph(text):
            return f"<p>{escape(plain_text(text))}</p>"
        case Table(header, rows):
            return html_table("", [*map(plain_text, header)], ([*map(plain_text, row)] for row in rows))
    raise TypeError(f"required a paragraph or a table, received {type(block).__name__}")
