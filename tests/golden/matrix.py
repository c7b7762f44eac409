"""The golden matrix: what commands and Python calls say, run in this process and brought into a form to compare.

``rows.toml`` is the table.  A row is a line: the arguments of one or several commands (joined by ``&&``, run in one
empty folder), or a Python expression that begins with ``ns.``.  Beside the scenes of ``scenes.toml`` that it names a
row needs nothing, and it leaves nothing behind.

What a row says is its :class:`Record`: plain JSON.  Text is unwrapped, pictures and pages become what is in them, long
lists become their ends and sums, so that a record is small and a difference can be read.
"""

from __future__ import annotations

import ast
import json
import os
import re
import shlex
import tempfile
import tomllib
from collections.abc import Iterator
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any, TypeAlias
from unittest.mock import patch

from tests.golden.contents import content_of, plain, text_lines

HERE = Path(__file__).parent
COLUMNS = "1000"  # so wide that no line is broken
PYTHON = "ns."

Record: TypeAlias = dict[str, Any]


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes:
        section: the heading under which it stands, also the name of the file of its records.
        line: what is run.
        tested: whether `make test` runs it, too.
    """

    section: str
    line: str
    tested: bool


@cache
def rows() -> tuple[Row, ...]:
    """The whole table; in each section the first ``tested`` rows run in `make test`."""
    table = tomllib.loads((HERE / "rows.toml").read_text(encoding="utf-8"))
    found = []
    for name, section in table.items():
        found += [Row(name, line, k < section["tested"]) for k, line in enumerate(section["rows"])]
    return tuple(found)


@cache
def scenes() -> dict[str, str]:
    """Scene files and tables by name: what a row names is written into its folder."""
    documents = tomllib.loads((HERE / "scenes.toml").read_text(encoding="utf-8"))
    return {name: text for section in documents.values() for name, text in section.items()}


def run_row(line: str) -> Record:
    """What a row says, in a folder of its own that holds the scenes it names."""
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        for name in _named(line):
            Path(name).write_text(scenes()[name], encoding="utf-8")
        before = set(_files())
        with patch.dict(os.environ, COLUMNS=COLUMNS):
            record = _python(line) if line.startswith(PYTHON) else _commands(line)
        written = sorted(set(_files()) - before)
        if written:
            record["files"] = {name: content_of(Path(name)) for name in written}
    return record


def _named(text: str) -> set[str]:
    """The scenes that a row names, and the tables that these name."""
    found = scenes().keys() & set(re.findall(r"[\w.-]+", text))
    return found.union(*(_named(scenes()[name]) for name in found if name.endswith(".toml")))


def _files() -> Iterator[str]:
    return (str(path) for path in Path().rglob("*") if path.is_file())


def _commands(line: str) -> Record:
    """Exit status, standard output and error of each command."""
    from nonsmooth.reports.cli import app
    from nonsmooth.reports.output.console import run

    steps = []
    for command in line.split(" && "):
        out, err = StringIO(), StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            status = run(app, shlex.split(command))
        step: Record = {"status": status}
        said, complained = (stream.getvalue().replace(os.getcwd(), "(folder)") for stream in (out, err))
        if said:
            step["out"] = _output(said)
        if complained:
            step["err"] = text_lines(complained)
        steps.append(step)
    return {"steps": steps}


def _output(text: str) -> Any:
    """A JSON document as it is, other text as lines."""
    try:
        return plain(json.loads(text))
    except json.JSONDecodeError:
        return text_lines(text)


def _python(line: str) -> Record:
    """The value of an expression, or the error that it raises."""
    import nonsmooth

    try:
        return {"value": plain(_evaluate(ast.parse(line, mode="eval").body, nonsmooth))}
    except Exception as error:
        return {"raised": f"{type(error).__name__}: {error}"}


def _evaluate(node: ast.expr, ns: Any) -> Any:
    """Calls, attributes and literals, and nothing else."""
    match node:
        case ast.Name(id="ns"):
            return ns
        case ast.Attribute(value=value, attr=name):
            return getattr(_evaluate(value, ns), name)
        case ast.Call(func=function, args=arguments, keywords=keywords):
            called = _evaluate(function, ns)
            named = {keyword.arg or "": _evaluate(keyword.value, ns) for keyword in keywords}
            return called(*(_evaluate(argument, ns) for argument in arguments), **named)
        case ast.Subscript(value=value, slice=key):
            return _evaluate(value, ns)[ast.literal_eval(key)]
        case ast.Tuple(elts=items):
            return tuple(_evaluate(item, ns) for item in items)
        case ast.List(elts=items):
            return [_evaluate(item, ns) for item in items]
        case _:
            return ast.literal_eval(node)
