"""No circles of imports: none between two files, and none between two packages, for each of which its folder stands.

Imports inside functions count, since they only put a circle off until the call, and so do those under TYPE_CHECKING:
who reads one file of such a circle has to read all.
"""

import ast
from collections.abc import Sequence
from functools import cache

import pytest

from tests.sources import (
    Graph,
    import_graph,
    imported_modules,
    imports_in,
    merged,
    product_files,
    rings,
    summary_of,
)


@cache
def graph_of_files() -> Graph:
    imports = {name: summary_of(path).imports for name, path in product_files().items()}
    return import_graph(imports, for_types=True)


def test_no_two_files_import_each_other() -> None:
    assert rings(graph_of_files()) == set()


def test_no_sub_packages_import_each_other() -> None:
    folders = {name: str(path.parent) for name, path in product_files().items()}
    assert rings(merged(graph_of_files(), folders)) == set()


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
    imports = list(imports_in(ast.parse(text)))
    modules = [f"nonsmooth.{name}" for name in ("a", "b", "c", "d.e")]
    assert imported_modules(imports, modules, for_types=False) == {"nonsmooth.a", "nonsmooth.c", "nonsmooth.d.e"}
    assert imported_modules(imports, modules, for_types=True) == set(modules)
