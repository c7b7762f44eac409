"""How long files and functions may be: a stranger reads one at a sitting."""

from __future__ import annotations

import ast
from collections.abc import Iterable

import pytest

from tests.sources import PACKAGES, ROOT, Definition, definitions_in, sources, summary_of, text_of

LINES_OF_A_FILE, LINES_OF_A_FUNCTION = 350, 60
# Each stands alone, to be read beside the specification of certificates.
CHECKERS = {"proofs/checker.py", "proofs/system_checker.py", "proofs/many_state_checker.py"}


def long_functions(definitions: Iterable[Definition]) -> list[tuple[str, int]]:
    """Names and lines of the functions that are too long."""
    functions = [entry for entry in definitions if not entry.is_class]
    return [(entry.name, entry.lines) for entry in functions if entry.lines > LINES_OF_A_FUNCTION]


@pytest.mark.parametrize("package", PACKAGES)
def test_files_and_functions_of_the_product_are_short(package: str) -> None:
    files = {path.relative_to(ROOT).as_posix(): path for path in sources(package)}
    lengths = {name: text_of(path).count("\n") for name, path in files.items() if name not in CHECKERS}
    assert {name: lines for name, lines in lengths.items() if lines > LINES_OF_A_FILE} == {}
    functions = {name: long_functions(summary_of(path).definitions) for name, path in files.items()}
    assert {name: found for name, found in functions.items() if found} == {}


def test_a_function_of_sixty_one_lines_is_too_long() -> None:
    body = "        pass\n" * 59
    tree = ast.parse(f"class A:\n    def short(self):\n{body}\n    def long(self):\n        pass\n{body}")
    assert long_functions(definitions_in(tree)) == [("long", 61)]
