"""How large the product is, and how much of it four commands run: ``make measure``.

``make measure`` prints the numbers of now beside the last row of ``tests/measure.csv``; ``make measure ROW="what was
done"`` appends them to that table, and so does ``python -m tests.measure --row "what was done"``. The last row is a
ratchet (``tests/test_measure.py``): the product may not have more tokens than it says. Who lets it grow appends a row
that says for what.

A token is a name, a number or an operator, as Python splits its source; strings, comments and ends of lines are none.
An f-string is a string, whatever stands in it, since Python 3.11 reads it as one and later ones do not. A function is a
``def``, also one in a class or in another function; lambdas and comprehensions are none. Two modules are in one circle
if each leads to the other by imports, those inside functions and under TYPE_CHECKING included; so are two packages by
imports of the files that lie in them.
"""

from __future__ import annotations

import argparse
import ast
import csv
import io
import math
import re
import statistics
import sys
import tokenize
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stderr, redirect_stdout
from cProfile import Profile
from inspect import CO_OPTIMIZED
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType
from typing import NamedTuple, TypeAlias

from tests.sources import (
    ROOT,
    Import,
    definitions_in,
    import_graph,
    imports_in,
    merged,
    product_files,
    rings,
    sources,
    text_of,
    tokens,
)

TABLE = ROOT / "tests" / "measure.csv"
REASON = "reason"  # the last column, in words
# What is run, by the names of the columns.
COMMANDS = {
    "check array": "check four-wheel",
    "check system": "check relay-oscillator-damped",
    "simulate": "simulate four-wheel --from 0.2,0.4,0 --until 2",
    "derive": "derive four-wheel -o {folder}/report.html",
}
AT_ONCE = 2
COMPREHENSIONS = ast.ListComp | ast.SetComp | ast.DictComp | ast.GeneratorExp

Numbers: TypeAlias = dict[str, float]  # in the order of the columns


class Row(NamedTuple):
    """A milestone: the numbers of then, and what was done."""

    numbers: Numbers
    reason: str


class FileSize(NamedTuple):
    """What is counted in one file.

    Attributes:
        lines: all of them.
        lines_of_code: neither blank nor part of a comment or a docstring.
        comment_lines: that hold nothing but a comment.
        tokens: of code.
        functions: lines of each, without decorators.
        comprehensions: also generator expressions.
        imports: its statements.
    """

    lines: int
    lines_of_code: int
    comment_lines: int
    tokens: int
    functions: tuple[int, ...]
    comprehensions: int
    imports: tuple[Import, ...]


def count_tokens(text: str) -> int:
    """The tokens of code in a text that Python accepts: those of :func:`size_of`, five times as fast."""
    return sum(map(bool, PIECES.findall(text)))


def pieces_of_code() -> re.Pattern[str]:
    """What matches comments and strings, and in its group tokens of code; what lies between them is neither."""
    long, short = r'"""(?:[^"\\]|\\.|"(?!""))*"""', r'"(?:[^"\\]|\\.)*"'
    quoted = "|".join((long, long.replace('"', "'"), short, short.replace('"', "'")))
    string = rf"(?:\b[rRbBuUfFtT]{{1,2}})?(?:{quoted})"
    number, name = r"(?:\d|\.\d)(?:[eE][+-]|[\w.])*", r"\w+"
    operator = r"\*\*=?|//=?|>>=?|<<=?|\.\.\.|->|[:=!<>+*/%&@|^-]=|[^\w\s\\]"
    return re.compile(rf"#[^\n]*|{string}|({number}|{name}|{operator})", re.DOTALL)


PIECES = pieces_of_code()


def is_code(token: tokenize.TokenInfo) -> bool:
    return token.type in {tokenize.NAME, tokenize.NUMBER, tokenize.OP}


def outside_f_strings(found: Iterable[tokenize.TokenInfo]) -> Iterator[tokenize.TokenInfo]:
    """Tokens without those of f-strings, which Python splits since 3.12 (and t-strings since 3.14)."""
    depth = 0
    for token in found:
        kind = tokenize.tok_name[token.type]
        if kind.endswith("STRING_START"):
            depth += 1
        elif kind.endswith("STRING_END"):
            depth -= 1
        elif depth == 0:
            yield token


def docstring_lines(tree: ast.Module) -> set[int]:
    """The lines of the docstrings of a module, of its classes and of its functions."""
    found: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0] if node.body else None
            if first is not None and ast.get_docstring(node, clean=False) is not None:
                found.update(range(first.lineno, (first.end_lineno or first.lineno) + 1))
    return found


def size_of(text: str) -> FileSize:
    """What is counted in a file of this text."""
    tree, pieces = ast.parse(text), list(outside_f_strings(tokens(text)))
    lines = text.splitlines()
    filled = {k for k, line in enumerate(lines, 1) if line.strip()}
    starts = [token.start for token in pieces if token.type == tokenize.COMMENT]
    comments = {line for line, column in starts if not lines[line - 1][:column].strip()}  # and nothing before it
    return FileSize(
        lines=text.count("\n"),
        lines_of_code=len(filled - comments - docstring_lines(tree)),
        comment_lines=len(comments),
        tokens=sum(map(is_code, pieces)),
        functions=tuple(entry.lines for entry in definitions_in(tree) if not entry.is_class),
        comprehensions=sum(isinstance(node, COMPREHENSIONS) for node in ast.walk(tree)),
        imports=tuple(imports_in(tree)),
    )


def measure_product(root: Path = ROOT) -> Numbers:
    """The size of the product under a root, the forms of its functions, and its circles of imports."""
    files = product_files(root)
    sizes = {name: size_of(text_of(path)) for name, path in files.items()}
    lines = sum(size.lines for size in sizes.values())
    functions = [length for size in sizes.values() for length in size.functions]
    of_imports = sum(statement.lines for size in sizes.values() for statement in size.imports)
    modules = import_graph({name: size.imports for name, size in sizes.items()}, for_types=True)
    circles = rings(modules)
    circles_of_packages = rings(merged(modules, {name: str(path.parent) for name, path in files.items()}))
    return {
        "tokens": sum(size.tokens for size in sizes.values()),
        "lines": lines,
        "lines of code": sum(size.lines_of_code for size in sizes.values()),
        "files": len(files),
        "functions": len(functions),
        "median lines of a function": statistics.median(functions),
        "mean lines of a function": round(statistics.mean(functions), 2),
        "imports % of lines": round(100 * of_imports / lines, 2),
        "comment lines": sum(size.comment_lines for size in sizes.values()),
        "comprehensions a function": round(sum(size.comprehensions for size in sizes.values()) / len(functions), 2),
        "circles of modules": len(circles),
        "modules in circles": sum(map(len, circles)),
        "circles of packages": len(circles_of_packages),
        "packages in circles": sum(map(len, circles_of_packages)),
    }


def measure_tests(root: Path = ROOT) -> Numbers:
    """The size of the tests under a root."""
    texts = [text_of(path) for path in sources(root / "tests")]
    return {
        "tests: tokens": sum(map(count_tokens, texts)),
        "tests: lines": sum(text.count("\n") for text in texts),
        "tests: files": len(texts),
    }


def functions_run(call: Callable[[], object], files: Iterable[Path]) -> int:
    """How many functions of some files run at least once during a call, in its thread."""
    profile = Profile(subcalls=False, builtins=False)
    profile.runcall(call)
    codes = (entry.code for entry in profile.getstats())
    names = {place_of(code) for code in codes if isinstance(code, CodeType) and is_function(code)}
    known = set(files)
    return sum(path in known for path, _, _ in names)


def is_function(code: CodeType) -> bool:
    """Whether a ``def`` made it: bodies of classes, and comprehensions before Python 3.12, run as functions do."""
    return bool(code.co_flags & CO_OPTIMIZED) and not code.co_name.startswith("<")


def place_of(code: CodeType) -> tuple[Path, int, str]:
    return Path(code.co_filename).resolve(), code.co_firstlineno, code.co_name


def measure_command(arguments: list[str]) -> tuple[int, int]:
    """How many functions of the product a command runs, and how many files it imports, in a process of its own."""
    files = product_files().values()
    functions = functions_run(lambda: run_command(arguments), files)
    loaded = {Path(getattr(module, "__file__", None) or "").resolve() for module in sys.modules.values()}
    if not functions:
        raise RuntimeError(f"nonsmooth is imported from elsewhere than {ROOT}")
    return functions, len(loaded & set(files))


def run_command(arguments: list[str]) -> None:
    """Do what the command ``nonsmooth`` does, its imports included, and print nothing.

    Raises:
        RuntimeError: it does not end well.
    """
    sys.argv = ["nonsmooth", *arguments]
    errors, status = io.StringIO(), None
    with redirect_stdout(io.StringIO()), redirect_stderr(errors):
        from nonsmooth.reports.cli import main

        try:
            main()
        except SystemExit as end:
            status = end.code
    if status != 0:
        raise RuntimeError(f"nonsmooth {' '.join(arguments)} ended with exit status {status}: {errors.getvalue()}")


def measure() -> Numbers:
    """All numbers of now, in the order of the columns."""
    context = get_context("spawn")
    with TemporaryDirectory() as folder, ProcessPoolExecutor(AT_ONCE, context, max_tasks_per_child=1) as pool:
        runs = {
            name: pool.submit(measure_command, command.format(folder=folder).split())
            for name, command in reversed(COMMANDS.items())  # the longest first
        }
        numbers = measure_product() | measure_tests()
        for name in COMMANDS:
            numbers[f"{name}: functions"], numbers[f"{name}: files"] = runs[name].result()
    return numbers


def read_table(path: Path = TABLE) -> list[Row]:
    """The rows of a table of milestones; a number that was not measured then is not there.

    Raises:
        ValueError: a row has no reason, or an entry is no number.
    """
    rows = []
    with path.open(encoding="utf-8", newline="") as file:
        for k, entry in enumerate(csv.DictReader(file), 1):
            reason = (entry.pop(REASON) or "").strip()
            if not reason:
                raise ValueError(f"{path.name}: row {k}: required a reason in words, received none")
            rows.append(Row({name: float(number) for name, number in entry.items() if number}, reason))
    return rows


def append_row(row: Row, path: Path = TABLE) -> None:
    """Append a milestone to a table.

    Raises:
        ValueError: the table has other columns.
    """
    with path.open("r+", encoding="utf-8", newline="") as file:
        columns = next(csv.reader(file))
        if columns != [*row.numbers, REASON]:
            raise ValueError(f"{path.name}: required the columns {[*row.numbers, REASON]}, received {columns}")
        file.seek(0, io.SEEK_END)
        numbers = [f"{number:.10g}" for number in row.numbers.values()]
        csv.writer(file, lineterminator="\n").writerow([*numbers, row.reason])


def side_by_side(row: Row, now: Numbers) -> str:
    """The numbers of a row and of now, as lines to read."""
    width = max(map(len, now))
    lines = [f'Last row of {TABLE.relative_to(ROOT)}: "{row.reason}"', ""]
    lines.append(f"{'':{width}}  {'last row':>10}  {'now':>10}  {'change':>10}")
    for name, number in now.items():
        before = row.numbers.get(name, math.nan)
        lines.append(f"{name:{width}}  {before:>10,.10g}  {number:>10,.10g}  {number - before:>+10,.7g}")
    return "\n".join(lines) + "\n"


def main(arguments: list[str] | None = None) -> None:
    """Measure, print the numbers beside those of the last row and, where asked, append them as a row."""
    parser = argparse.ArgumentParser(prog="python -m tests.measure", description=__doc__.partition("\n")[0])
    parser.add_argument("--row", metavar="REASON", help="append a row to the table: what was done")
    reason = parser.parse_args(arguments).row
    if reason is not None and not reason.strip():
        parser.error("argument --row: required what was done, in words, received nothing")
    now = measure()
    sys.stdout.write(side_by_side(read_table()[-1], now))
    if reason is not None:
        append_row(Row(now, reason))
        sys.stdout.write(f"Appended a row to {TABLE.relative_to(ROOT)}.\n")


if __name__ == "__main__":
    main()
