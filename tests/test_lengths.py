"""How long files and functions may be: a stranger reads one at a sitting."""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest

from tests.sources import PACKAGES, ROOT, sources, statements_in, text_of

LINES_OF_A_FILE, LINES_OF_A_FUNCTION = 350, 60
# Each stands alone, to be read beside the specification of certificates.
CHECKERS = {"proofs/checker.py", "proofs/system_checker.py", "proofs/many_state_checker.py"}


def long_functions(node: ast.AST) -> Iterator[tuple[str, int]]:
    """Names and lines of the functions below a node that are too long."""
    for child in statements_in(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            lines = (child.end_lineno or child.lineno) - child.lineno + 1
            if lines > LINES_OF_A_FUNCTION:
                yield child.name, lines
        yield from long_functions(child)


@pytest.mark.parametrize("package", PACKAGES)
def test_files_and_functions_of_the_product_are_short(package: str) -> None:
    lengths = {path.relative_to(ROOT).as_posix(): text_of(path).count("\n") for path in sources(package)}
    assert [(name, lines) for name, lines in lengths.items() if lines > LINES_OF_A_FILE and name not in CHECKERS] == []
    found = [
        (path.name, *function) for path in sources(package) for function in long_functions(ast.parse(text_of(path)))
    ]
    assert found == []


def test_a_function_of_sixty_one_lines_is_too_long() -> None:
    body = "        pass\n" * 59
    tree = ast.parse(f"class A:\n    def short(self):\n{body}\n    def long(self):\n        pass\n{body}")
    assert list(long_functions(tree)) == [("long", 61)]
