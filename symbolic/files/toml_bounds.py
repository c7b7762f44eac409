"""Bounds of a TOML text, tested in linear time before it is parsed.

The parser of the standard library takes time that grows with the square of the number of parts of a dotted key, and a
stack that grows with the depth of brackets.  A scene needs three of either.
"""

from __future__ import annotations

import re

MAX_PARTS = 16  # of a dotted key
MAX_NESTING = 64  # of brackets

# Strings and comments, each to its end or, where that is missing, to where the parser would give up.  Possessive, so
# that no character is looked at twice.
_OPAQUE = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*+(?:"{3,5})?'
    r"|'''(?:[^']|'(?!''))*+(?:'{3,5})?"
    r'|"(?:[^"\\\n]|\\[^\n])*+"?'
    r"|'[^'\n]*+'?"
    r"|#[^\n]*+",
    re.DOTALL,
)
_STRUCTURE = re.compile(r"[\n=,\[\]{}]")


def toml_excess(text: str) -> tuple[str, str] | None:
    """What a document must keep to and what this one holds; None where it keeps to both bounds."""
    bare = _OPAQUE.sub("", text)
    parts = 1 + max(piece.count(".") for piece in _STRUCTURE.split(bare))
    if parts > MAX_PARTS:
        return f"keys of at most {MAX_PARTS} parts", f"one of {parts}"
    depth = deepest = 0
    for bracket in re.findall(r"[\[\]{}]", bare):
        depth = depth + 1 if bracket in "[{" else max(depth - 1, 0)
        deepest = max(deepest, depth)
    if deepest > MAX_NESTING:
        return f"a document with fewer nested brackets (at most {MAX_NESTING})", f"{deepest}"
    return None
