"""The source files of the product and of the tests, parsed once in a process."""

from __future__ import annotations

import ast
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("symbolic", "analysis", "proofs", "reports")  # each may import the packages to its left


@cache
def sources(folder: str) -> list[Path]:
    """The Python files of a folder and of those in it."""
    return sorted((ROOT / folder).rglob("*.py"))


@cache
def parse(path: Path) -> ast.Module:
    """The tree of a file."""
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes below one that are no expressions; expressions hold no statements."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):
            yield child
            yield from statements(child)


def is_type_checking_block(node: ast.AST) -> bool:
    """Whether what is below a node is read by the type checker only."""
    return isinstance(node, ast.If) and ast.unparse(node.test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING"}


@cache
def tokens(path: Path) -> tuple[tokenize.TokenInfo, ...]:
    """The names and numbers of a file."""
    with tokenize.open(path) as file:
        found = tokenize.generate_tokens(file.readline)
        return tuple(token for token in found if token.type in {tokenize.NAME, tokenize.NUMBER})
