"""The product does not grow without a reason, and what measures it counts what it says it counts."""

from __future__ import annotations

import runpy
import tokenize
from pathlib import Path

import pytest

from tests.measure import (
    COMMANDS,
    TABLE,
    Numbers,
    count_tokens,
    functions_run,
    measure_product,
    measure_tests,
    outside_f_strings,
    read_table,
    size_of,
)
from tests.sources import PACKAGES, product_files, sources, text_of
from tests.thorough import thorough


def test_the_product_has_no_more_tokens_than_the_last_row_says() -> None:
    tokens = sum(count_tokens(text_of(path)) for path in product_files().values())
    allowed = read_table()[-1].numbers["tokens"]
    assert tokens <= allowed, f'{tokens - allowed:,g} more: delete some, or say what for: make measure ROW="..."'


def test_the_table_begins_before_the_redesign() -> None:
    assert read_table()[0].reason == "before the redesign"
    assert read_table()[0].numbers["tokens"] == 692_075


@pytest.mark.parametrize(
    ("text", "tokens"),
    [
        ("x = 1\n", 3),
        ("x = y  # and why\n# a line of its own\n\n", 3),
        ('"""A docstring."""\nx = "a" "b" + \'c\'\n', 3),  # x, =, +
        ("if x:\n    y = [1,\n         2]\n", 10),
        ('x = f"{a + b} of {c!r:>{width}}"\n', 2),
        ("x = f'{f\"{a}\"}' + rf'{b}' + d\n", 5),
        ('x = f"""{\n    a}\n""".strip()\n', 6),  # x, =, ., strip, ( and )
        ("x = 'a\\'b' + \"#\" \\\n  + rb'''c\\\n'd''' b'#'\n", 4),  # x, = and two +
        ("x = 0x1F if y>=1_0.e-3 else.5j-1e5-bar\n", 13),
        ("x: int = a.b[...] ** -c // 2\nx **= d<<1>>e\ng = lambda: (h := ~x)\ny @= h!=i\n", 37),
        ("", 0),
    ],
)
def test_tokens(text: str, tokens: int) -> None:
    assert count_tokens(text) == size_of(text).tokens == tokens


@pytest.mark.parametrize("signs", ['"', "'", "\\", "**", "->", "e-", '"""'])
def test_tokens_of_a_file_are_those_of_python(signs: str) -> None:
    """Of the one with most of some signs for its length."""
    text = max(map(text_of, product_files().values()), key=lambda text: text.count(signs) / (1 + len(text)))
    assert signs in text
    assert count_tokens(text) == size_of(text).tokens


@thorough  # the small one: the test above
def test_tokens_of_all_files_are_those_of_python() -> None:
    for path in (*product_files().values(), *sources("tests")):
        assert count_tokens(text_of(path)) == size_of(text_of(path)).tokens, path


@pytest.mark.parametrize("letter", ["F", "T"])
def test_no_token_of_a_split_string_counts(monkeypatch: pytest.MonkeyPatch, letter: str) -> None:
    """``x + f"{a:{b}} {f'{c}'}"`` as later Pythons split it, in whichever Python the tests run."""
    start, middle, end = 1001, 1002, 1003
    for number, name in ((start, "STRING_START"), (middle, "STRING_MIDDLE"), (end, "STRING_END")):
        monkeypatch.setitem(tokenize.tok_name, number, letter + name)
    types = {'f"': start, "f'": start, " ": middle, '"': end, "'": end}
    split = ["x", "+", 'f"', "{", "a", ":", "{", "b", "}", "}", " ", "{", "f'", "{", "c", "}", "'", "}", '"', "y"]
    found = [tokenize.TokenInfo(types.get(text, tokenize.NAME), text, (1, 0), (1, 0), "") for text in split]
    assert [token.string for token in outside_f_strings(found)] == ["x", "+", "y"]


FILE = '''"""A docstring
# of two lines."""

from __future__ import annotations

# A comment
# of two lines.
from a import (  # not a line of comment
    b,
)


@decorator
def outer(x):
    """A docstring."""

    def inner():
        return [y for y in x if any(z for z in y)]

    return lambda: inner()


class C:
    """A docstring."""

    async def method(self):
        import c

        return """
# not a comment

"""
'''


def test_one_file() -> None:
    size = size_of(FILE)
    assert size.lines == 32
    assert size.lines_of_code == 4 + 5 + 6  # imports; function; class, the blank line in its string not counted
    assert size.comment_lines == 2
    assert size.functions == (7, 2, 7)
    assert size.comprehensions == 2
    assert [statement.lines for statement in size.imports] == [1, 3, 1]


def plant(root: Path, texts: dict[str, str]) -> None:
    """Write a small product and tests of it, all other files empty."""
    for package in (*PACKAGES, "tests"):
        (root / package).mkdir()
    for name in ("__init__.py", "__main__.py", *texts):
        path = root / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(texts.get(name, ""), encoding="utf-8")


def planted_numbers(root: Path) -> Numbers:
    plant(root, {"symbolic/a.py": "def f(x):\n    return -x\n", "tests/test_a.py": "assert True\n\n\n"})
    return measure_product(root) | measure_tests(root)


def test_a_small_product(tmp_path: Path) -> None:
    numbers = planted_numbers(tmp_path)
    assert (numbers["files"], numbers["lines"], numbers["tokens"], numbers["functions"]) == (3, 2, 9, 1)
    assert (numbers["tests: files"], numbers["tests: lines"], numbers["tests: tokens"]) == (1, 3, 2)
    assert numbers["circles of modules"] == numbers["circles of packages"] == 0


PROGRAM = """
from functools import cache

class C:
    x = 1

    @property
    def seen(self):
        return [y for y in (self.x,)]

    def unseen(self):
        return 0

@cache
def one():
    def inner():
        yield {x: x for x in C().seen if (lambda y: y)(x)}
    return [*inner(), *inner()]

def never():
    return one()

one()
"""


def test_functions_that_run(tmp_path: Path) -> None:
    """Bodies of modules and of classes, lambdas and comprehensions are no functions; a function counts once."""
    counted, other = tmp_path / "counted.py", tmp_path / "other.py"
    for path in (counted, other):
        path.write_text(PROGRAM, encoding="utf-8")

    def call() -> None:
        for path in (counted, counted, other):
            runpy.run_path(str(path))

    assert functions_run(call, [counted]) == 3
    assert functions_run(call, [counted, other]) == 6
    assert functions_run(call, [tmp_path / "another.py"]) == 0


def test_the_table_has_the_columns_that_are_measured(tmp_path: Path) -> None:
    of_commands = [f"{name}: {counted}" for name in COMMANDS for counted in ("functions", "files")]
    columns = TABLE.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert columns == [*planted_numbers(tmp_path), *of_commands, "reason"]
