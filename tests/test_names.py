"""No name stands for two things: every public class of the product has a name of its own, and none for anything."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterable, Iterator

from tests.sources import PACKAGES, ROOT, sources, summary_of, text_of

CHECKER = "proofs/checker/"  # stands alone, to be read beside the specification of certificates
# What scripts and notebooks hold of the class of the same name.
IN_SCRIPTS = {("reports/interface/array.py", "Wheel"), ("reports/interface/vehicle.py", "Vehicle")}


def public_classes() -> Iterator[tuple[str, str]]:
    """Files of the product, without the checker, which stands alone, and the classes in them."""
    for path in (path for package in PACKAGES for path in sources(package)):
        file = path.relative_to(ROOT).as_posix()
        for entry in summary_of(path).definitions if not file.startswith(CHECKER) else ():
            if entry.is_class and entry.is_outermost and not entry.name.startswith("_"):
                yield file, entry.name


def repeated(classes: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Names of several classes, with their files."""
    files = defaultdict(list)
    for file, name in classes:
        files[name].append(file)
    return {name: places for name, places in files.items() if len(places) > 1}


def test_no_two_classes_have_the_same_name() -> None:
    classes = set(public_classes())
    assert classes > IN_SCRIPTS
    assert repeated(classes - IN_SCRIPTS) == {}
    assert sorted(repeated(classes)) == ["Vehicle", "Wheel"]


def test_a_name_of_two_classes_is_told() -> None:
    assert repeated([("a.py", "Step"), ("b.py", "Step"), ("b.py", "Stop")]) == {"Step": ["a.py", "b.py"]}


# ---- What belongs to something may be a row, a cell or a certificate: a reader asks which. ---------------------------

ANYTHING = {"own"}


def bound_names(tree: ast.AST) -> Iterator[str]:
    """Names of parameters, and of what functions, loops and comprehensions bind."""
    for node in ast.walk(tree):
        if isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id


def test_local_names_say_what_they_are() -> None:
    paths = [
        path for package in PACKAGES for path in sources(package) if any(name in text_of(path) for name in ANYTHING)
    ]
    functions = {
        path: [node for node in ast.walk(ast.parse(text_of(path))) if isinstance(node, ast.FunctionDef | ast.Lambda)]
        for path in paths
    }
    assert paths
    assert [path for path in paths if any(ANYTHING & set(bound_names(node)) for node in functions[path])] == []


def test_a_name_for_anything_is_told() -> None:
    assert set(bound_names(ast.parse("[own for own in (x := rows)]; lambda a: a"))) == {"own", "x", "a"}
