"""The source files of the product and of the tests, read once in a process; trees are not kept, they are large."""

from __future__ import annotations

import ast
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("symbolic", "analysis", "proofs", "reports")  # each may import the packages to its left
BLOCKS = ("body", "handlers", "cases", "orelse", "finalbody")  # fields of syntax trees that hold statements


class Import(NamedTuple):
    """An import statement.

    Attributes:
        line: where it stands.
        modules: what it names; `from a import b` counts as a.b, which may be a module.
        is_relative: whether it is `from . import b`, or from a package further up.
        in_function: whether it runs when a function is called, not when the module is loaded.
        for_types: whether it stands under TYPE_CHECKING, read by the type checker only.
    """

    line: int
    modules: tuple[str, ...]
    is_relative: bool
    in_function: bool
    for_types: bool


class Definition(NamedTuple):
    """A class or a function, also one inside another.

    Attributes:
        name: as it is defined.
        lines: from its first to its last line.
        is_class: whether it is a class.
        is_outermost: whether it stands in no other definition.
    """

    name: str
    lines: int
    is_class: bool
    is_outermost: bool


class Summary(NamedTuple):
    """What tests ask of a file: one tree serves them all, and is not kept."""

    imports: tuple[Import, ...]
    definitions: tuple[Definition, ...]


@cache
def sources(folder: str) -> list[Path]:
    """The Python files of a folder and of those in it."""
    return sorted((ROOT / folder).rglob("*.py"))


@cache
def text_of(path: Path) -> str:
    """The text of a file."""
    return path.read_text(encoding="utf-8")


@cache
def summary_of(path: Path) -> Summary:
    """The imports of a file, also those inside functions, and its classes and functions."""
    tree = ast.parse(text_of(path), filename=str(path))
    return Summary(tuple(imports_in(tree)), tuple(definitions_in(tree)))


def imports_in(node: ast.AST, in_function: bool = False, for_types: bool = False) -> Iterator[Import]:
    """Every import below a node."""
    for child in statements_in(node):
        if isinstance(child, ast.Import):
            modules = tuple(alias.name for alias in child.names)
            yield Import(child.lineno, modules, False, in_function, for_types)
        elif isinstance(child, ast.ImportFrom):
            modules = tuple(f"{child.module}.{alias.name}" for alias in child.names)
            yield Import(child.lineno, modules, child.level > 0, in_function, for_types)
        else:
            is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef)
            yield from imports_in(child, in_function or is_function, for_types or is_type_checking_block(child))


def definitions_in(node: ast.AST, is_outermost: bool = True) -> Iterator[Definition]:
    """Every class and function below a node."""
    for child in statements_in(node):
        is_class = isinstance(child, ast.ClassDef)
        if isinstance(child, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            lines = (child.end_lineno or child.lineno) - child.lineno + 1
            yield Definition(child.name, lines, is_class, is_outermost)
            yield from definitions_in(child, is_outermost=False)
        else:
            yield from definitions_in(child, is_outermost)


def statements_in(node: ast.AST) -> Iterator[ast.AST]:
    """The statements of the blocks of a node, and what holds blocks itself: expressions, by far the most, hold none."""
    for block in BLOCKS:
        yield from getattr(node, block, ())


def is_type_checking_block(node: ast.AST) -> bool:
    """Whether what is below a node is read by the type checker only."""
    if not isinstance(node, ast.If) or not isinstance(node.test, ast.Name | ast.Attribute):
        return False  # to write out every condition takes long
    return ast.unparse(node.test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING"}


@cache
def tokens(path: Path) -> tuple[tokenize.TokenInfo, ...]:
    """The names and numbers of a file."""
    with tokenize.open(path) as file:
        found = tokenize.generate_tokens(file.readline)
        return tuple(token for token in found if token.type in {tokenize.NAME, tokenize.NUMBER})
