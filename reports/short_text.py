"""How results print: few lines of moderate width."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

WIDTH, LINES = 100, 12


def short_lines(head: str, rows: Iterable[tuple[str, str]]) -> str:
    """A headline and a wrapped line for each name and text; what goes beyond :data:`LINES` is cut."""
    pairs = list(rows)
    wide = max((len(name) for name, _ in pairs), default=0)
    lines = [textwrap.shorten(head, WIDTH, placeholder=" ...")]
    for name, text in pairs:
        start = f"  {name:{wide}}  "
        lines += textwrap.wrap(text, WIDTH, initial_indent=start, subsequent_indent=" " * len(start))
    if len(lines) > LINES:
        lines = [*lines[: LINES - 1], "  ..."]
    return "\n".join(lines)
