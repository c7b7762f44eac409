"""The source files of the product and of the tests: imports, definitions, tokens, and which files import each other.

Each file is read once in a process; trees are not kept, they are large.
"""

from __future__ import annotations

import ast
import io
import tokenize
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple, TypeAlias

from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("symbolic", "analysis", "proofs", "reports")  # each may import the packages to its left
TOP = ("__init__.py", "__main__.py")  # what `import nonsmooth` and `python -m nonsmooth` run
BLOCKS = ("body", "handlers", "cases", "orelse", "finalbody")  # fields of syntax trees that hold statements

Graph: TypeAlias = Mapping[str, set[str]]  # a name, and the names it leads to


class Import(NamedTuple):
    """An import statement.

    Attributes:
        line: where it stands.
        lines: how many it takes.
        modules: what it names; `from a import b` counts as a.b, which may be a module.
        is_relative: whether it is `from . import b`, or from a package further up.
        in_function: whether it runs when a function is called, not when the module is loaded.
        for_types: whether it stands under TYPE_CHECKING, read by the type checker only.
    """

    line: int
    lines: int
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
def sources(folder: str | Path) -> list[Path]:
    """The Python files of a folder and of those in it."""
    return sorted((ROOT / folder).rglob("*.py"))


def product_files(root: Path = ROOT) -> dict[str, Path]:
    """The files of the product by the names of their modules."""
    paths = [root / name for name in TOP] + [path for package in PACKAGES for path in sources(root / package)]
    return {module_name(path, root): path for path in paths}


def module_name(path: Path, root: Path = ROOT) -> str:
    """What a file of the product is imported as; an ``__init__.py`` is its folder."""
    parts = ("nonsmooth", *path.relative_to(root).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


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
            yield Import(child.lineno, lines_of(child), modules, False, in_function, for_types)
        elif isinstance(child, ast.ImportFrom):
            modules = tuple(f"{child.module}.{alias.name}" for alias in child.names)
            yield Import(child.lineno, lines_of(child), modules, child.level > 0, in_function, for_types)
        else:
            is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef)
            yield from imports_in(child, in_function or is_function, for_types or is_type_checking_block(child))


def definitions_in(node: ast.AST, is_outermost: bool = True) -> Iterator[Definition]:
    """Every class and function below a node."""
    for child in statements_in(node):
        is_class = isinstance(child, ast.ClassDef)
        if isinstance(child, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield Definition(child.name, lines_of(child), is_class, is_outermost)
            yield from definitions_in(child, is_outermost=False)
        else:
            yield from definitions_in(child, is_outermost)


def lines_of(node: ast.stmt) -> int:
    """From the first to the last line of a statement; decorators stand before the first."""
    return (node.end_lineno or node.lineno) - node.lineno + 1


def statements_in(node: ast.AST) -> Iterator[ast.AST]:
    """The statements of the blocks of a node, and what holds blocks itself: expressions, by far the most, hold none."""
    for block in BLOCKS:
        yield from getattr(node, block, ())


def is_type_checking_block(node: ast.AST) -> bool:
    """Whether what is below a node is read by the type checker only."""
    if not isinstance(node, ast.If) or not isinstance(node.test, ast.Name | ast.Attribute):
        return False  # to write out every condition takes long
    return ast.unparse(node.test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING"}


def tokens(text: str) -> Iterator[tokenize.TokenInfo]:
    """The tokens of a text, as Python splits it."""
    return tokenize.generate_tokens(io.StringIO(text).readline)


def imported_modules(imports: Iterable[Import], modules: Iterable[str], for_types: bool) -> set[str]:
    """The modules among the given ones that some imports name.

    Args:
        imports: of a file.
        modules: full names.
        for_types: whether imports under TYPE_CHECKING count, too.
    """
    known, found = set(modules), set()
    for statement in imports:
        for name in statement.modules if for_types or not statement.for_types else ():
            found.add(name if name in known else name.rpartition(".")[0])
    return found & known


def import_graph(imports: Mapping[str, Iterable[Import]], for_types: bool) -> Graph:
    """Which module imports which others, at any time, from the imports of each."""
    return {name: imported_modules(found, imports, for_types) - {name} for name, found in imports.items()}


def merged(graph: Graph, groups: Mapping[str, str]) -> Graph:
    """The graph of groups: one leads to another where a member does."""
    found: defaultdict[str, set[str]] = defaultdict(set)
    for name, others in graph.items():
        found[groups[name]] |= {groups[other] for other in others} - {groups[name]}
    return dict(found)


def rings(graph: Graph) -> set[frozenset[str]]:
    """The circles of a graph: its strongly connected components of more than one node."""
    names = sorted(graph)
    number = {name: k for k, name in enumerate(names)}
    tails = [number[name] for name in names for _ in graph[name]]
    heads = [number[other] for name in names for other in graph[name]]
    edges = coo_array(([1] * len(tails), (tails, heads)), shape=(len(names), len(names)))
    components: defaultdict[int, set[str]] = defaultdict(set)
    for name, component in zip(names, connected_components(edges, connection="strong")[1], strict=True):
        components[component].add(name)
    return {frozenset(component) for component in components.values() if len(component) > 1}
