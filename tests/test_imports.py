"""No circles of imports: none between two files, and none between the sub-packages of a package.

Imports inside functions count, since they only put a circle off until the call. Imports under TYPE_CHECKING do not:
they name a type in an annotation and load nothing. Between sub-packages, all files of a folder stand for it; a file
that lies beside sub-packages stands for itself.
"""

import ast
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

import pytest

from tests.sources import PACKAGES, ROOT, Import, imports_in, sources, summary_of

# Circles that are known; the list may only become shorter. Each with the reason why it still stands.
KNOWN_RINGS: dict[frozenset[str], str] = {}
KNOWN_RINGS_OF_FOLDERS: dict[frozenset[str], str] = {}

Graph = Mapping[str, set[str]]


def source_files() -> dict[str, Path]:
    """Every file of the product by its module's name without ``nonsmooth.``."""
    paths = [path for package in PACKAGES for path in sources(package)]
    return {module_name(path): path for path in paths}


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported_files(imports: Iterable[Import], modules: Mapping[str, object]) -> set[str]:
    """The modules among the given ones that some imports load at some time: all but those under TYPE_CHECKING."""
    found = set()
    for statement in imports:
        for name in () if statement.for_types else statement.modules:
            inner = name.removeprefix("nonsmooth.")
            found.add(inner if inner in modules else inner.rpartition(".")[0])
    return found & set(modules)


@cache
def import_graph() -> Graph:
    files = source_files()
    return {name: imported_files(summary_of(path).imports, files) - {name} for name, path in files.items()}


def folder_of(path: Path) -> str:
    """What a file stands for among sub-packages: its folder, or itself where the folder holds sub-packages too."""
    has_sub_packages = any(inner.is_dir() for inner in path.parent.iterdir() if (inner / "__init__.py").exists())
    return module_name(path if has_sub_packages else path.parent / "__init__.py")


def folder_graph() -> Graph:
    files = source_files()
    folders = {name: folder_of(path) for name, path in files.items()}
    graph: dict[str, set[str]] = {folder: set() for folder in folders.values()}
    for name, imported in import_graph().items():
        graph[folders[name]] |= {folders[other] for other in imported} - {folders[name]}
    return graph


def rings(graph: Graph) -> set[frozenset[str]]:
    """The strongly connected components of more than one node (Tarjan 1972)."""
    order: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    found: set[frozenset[str]] = set()

    def visit(node: str) -> None:
        order[node] = lowest[node] = len(order)
        stack.append(node)
        for other in sorted(graph[node]):
            if other not in order:
                visit(other)
                lowest[node] = min(lowest[node], lowest[other])
            elif other in stack:
                lowest[node] = min(lowest[node], order[other])
        if lowest[node] == order[node]:
            component = frozenset(stack[stack.index(node) :])
            del stack[stack.index(node) :]
            if len(component) > 1:
                found.add(component)

    for node in sorted(graph):
        if node not in order:
            visit(node)
    return found


def test_no_two_files_import_each_other() -> None:
    assert rings(import_graph()) == set(KNOWN_RINGS)


def test_no_sub_packages_import_each_other() -> None:
    assert rings(folder_graph()) == set(KNOWN_RINGS_OF_FOLDERS)


@pytest.mark.parametrize(
    ("graph", "expected"),
    [
        ({"a": {"b"}, "b": {"c"}, "c": set()}, []),
        ({"a": {"b"}, "b": {"a"}, "c": {"a"}}, ["ab"]),
        ({"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": {"e"}, "e": {"d"}}, ["abc", "de"]),
        ({"a": {"b", "c"}, "b": {"d"}, "c": {"d"}, "d": {"c"}}, ["cd"]),
    ],
)
def test_rings_of_small_graphs(graph: Graph, expected: Sequence[str]) -> None:
    assert rings(graph) == {frozenset(ring) for ring in expected}


def test_which_imports_count() -> None:
    text = """
from typing import TYPE_CHECKING
from nonsmooth.a import name
if TYPE_CHECKING:
    from nonsmooth.b import Name
def call():
    from nonsmooth import c
    import nonsmooth.d.e
"""
    imports = imports_in(ast.parse(text))
    assert imported_files(imports, dict.fromkeys(["a", "b", "c", "d.e"])) == {"a", "c", "d.e"}
