"""The product does not grow without a reason, and what measures it counts what it says it counts."""

from __future__ import annotations

import runpy
import subprocess
import sys
import tokenize
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

from tests.measure import (
    COMMANDS,
    TABLE,
    Numbers,
    Row,
    append_row,
    count_tokens,
    functions_run,
    main,
    measure_command,
    measure_product,
    measure_tests,
    outside_f_strings,
    read_table,
    side_by_side,
    size_of,
)
from tests.sources import PACKAGES, ROOT, product_files, text_of
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
        ("", 0),
    ],
)
def test_tokens(text: str, tokens: int) -> None:
    assert count_tokens(text) == tokens


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


FOR_TYPES = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from nonsmooth.symbolic.b import B\n"
LAZY = "def f():\n    from nonsmooth.symbolic.b import B\n"
TYPES = ("circles of modules", "modules in circles", "circles of packages", "packages in circles")


@pytest.mark.parametrize("back", [FOR_TYPES, LAZY])
def test_circles_of_modules(tmp_path: Path, back: str) -> None:
    one = {"symbolic/a.py": f"{back}def g(): ...\n", "symbolic/b.py": "from nonsmooth.symbolic import a\n"}
    other = {
        "analysis/c.py": "import nonsmooth.analysis.d\n",
        "analysis/d.py": "import nonsmooth.analysis.e\n",
        "analysis/e.py": "import nonsmooth.analysis.c, nonsmooth.symbolic.a\n",
    }
    plant(tmp_path, one | other)
    numbers = measure_product(tmp_path)
    assert [numbers[name] for name in TYPES] == [2, 5, 0, 0]


@pytest.mark.parametrize("back", [FOR_TYPES, LAZY])
def test_circles_of_packages(tmp_path: Path, back: str) -> None:
    """Of a package with one inside it, too: no two of these files lead to each other."""
    texts = {
        "proofs/a.py": f"{back}def g(): ...\n",
        "symbolic/b.py": "",
        "symbolic/c.py": "import nonsmooth.proofs.inner.d",
        "proofs/inner/d.py": "import nonsmooth.proofs.e",
        "proofs/e.py": "",
    }
    plant(tmp_path, texts)
    numbers = measure_product(tmp_path)
    assert [numbers[name] for name in TYPES] == [0, 0, 1, 3]


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


LITERAL = """
import io
import sys
from pathlib import Path
from tests.sources import product_files

files, ran = set(product_files().values()), set()

def trace(frame, event, argument):
    code = frame.f_code
    if not code.co_name.startswith("<") and "__module__" not in code.co_names:  # a class says which module it is of
        ran.add((code.co_filename, code.co_firstlineno))

sys.argv = ["nonsmooth", "--version"]
sys.stderr = io.StringIO()  # progress is shown on no stream of somebody who calls a command
sys.settrace(trace)
try:
    from nonsmooth.reports.cli import main
    main()
finally:
    sys.settrace(None)
    loaded = {Path(module.__file__).resolve() for module in sys.modules.values() if getattr(module, "__file__", None)}
    print(sum(Path(file).resolve() in files for file, _ in ran), len(files & loaded))
"""


@thorough  # beside test_functions_that_run, on a few lines
def test_a_command_in_a_process_of_its_own() -> None:
    """Against every call that Python reports, one by one."""
    printed = subprocess.run([sys.executable, "-c", LITERAL], cwd=ROOT, capture_output=True, text=True, check=True)
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        functions, files = pool.submit(measure_command, ["--version"]).result()
    assert [functions, files] == [int(word) for word in printed.stdout.split()[-2:]]


def test_a_command_that_fails_is_not_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> None:
        sys.stderr.write(f"cannot {sys.argv[1:]}")
        sys.exit(2)

    monkeypatch.setattr("nonsmooth.reports.cli.main", fail)
    monkeypatch.setattr(sys, "argv", sys.argv)
    with pytest.raises(RuntimeError, match=r"nonsmooth check x ended with exit status 2: cannot \['check', 'x'\]"):
        measure_command(["check", "x"])


def test_rows_are_read_as_they_were_appended(tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    table.write_text("tokens,mean,reason\n", encoding="utf-8")
    rows = [Row({"tokens": 692075, "mean": 8.4}, 'before, "as it was"'), Row({"tokens": 7, "mean": 1}, "less")]
    for row in rows:
        append_row(row, table)
    assert read_table(table) == rows
    assert table.read_text(encoding="utf-8").splitlines()[1:] == ['692075,8.4,"before, ""as it was"""', "7,1,less"]


def test_a_row_without_all_numbers_is_not_appended(tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    table.write_text("tokens,mean,reason\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"required the columns \['tokens', 'reason'\]"):
        append_row(Row({"tokens": 7}, "less"), table)
    assert table.read_text(encoding="utf-8") == "tokens,mean,reason\n"


@pytest.mark.parametrize("reason", [",", ", ", ""])
def test_a_row_without_a_reason_is_refused(tmp_path: Path, reason: str) -> None:
    table = tmp_path / "table.csv"
    table.write_text(f"tokens,reason\n7,a start\n8{reason}\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"table.csv: row 2: required a reason"):
        read_table(table)


def test_an_empty_reason_is_refused_before_anything_is_measured(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--row", " "])
    assert "required what was done, in words" in capsys.readouterr().err


def test_the_table_has_the_columns_that_are_measured(tmp_path: Path) -> None:
    of_commands = [f"{name}: {counted}" for name in COMMANDS for counted in ("functions", "files")]
    columns = TABLE.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert columns == [*planted_numbers(tmp_path), *of_commands, "reason"]


def test_numbers_stand_beside_those_of_the_last_row() -> None:
    shown = side_by_side(Row({"tokens": 692075, "mean": 8.4}, "a start"), {"tokens": 440000, "mean": 14.25, "new": 1})
    first, _, *lines = shown.splitlines()
    assert first == 'Last row of tests/measure.csv: "a start"'
    assert [line.split() for line in lines] == [
        ["last", "row", "now", "change"],
        ["tokens", "692,075", "440,000", "-252,075"],
        ["mean", "8.4", "14.25", "+5.85"],
        ["new", "nan", "1", "+nan"],
    ]
