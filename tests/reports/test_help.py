"""The help: what stands in the registry of commands is what the commands say, and showing it imports no command."""

from __future__ import annotations

import inspect
import subprocess
import sys

import pytest

from nonsmooth.reports.commands.registry import COMMANDS, command_function
from tests.reports.conftest import Invoke


@pytest.mark.parametrize("name", COMMANDS)
def test_summaries_are_those_of_the_commands(name: str) -> None:
    first, _, _ = (inspect.getdoc(command_function(name)) or "").partition("\n\n")
    assert COMMANDS[name].summary == " ".join(first.split())


def test_the_help_names_every_command_and_imports_none() -> None:
    code = (
        "import sys; from nonsmooth.reports.cli import app; from nonsmooth.reports.output.console import run; "
        "run(app, ['--help']); "
        "heavy = {'rich', 'pydantic', 'flint', 'numpy', 'sympy', 'nonsmooth.analysis'}; "
        "heavy |= {'nonsmooth.reports.output.study_options'}; "
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stderr == "[]\n"
    listed = [line.split()[0] for line in done.stdout.partition("Commands:")[2].splitlines() if line[2:3].strip()]
    assert listed == [*COMMANDS, "Example:"]


@pytest.mark.parametrize("name", COMMANDS)
def test_an_example_stands_on_one_line_to_be_copied(invoke: Invoke, name: str) -> None:
    assert f"  Example: nonsmooth {COMMANDS[name].example}\n" in invoke(name, "--help").out


def test_options_stand_under_their_headings(invoke: Invoke) -> None:
    out = invoke("simulate", "--help").out
    places = [out.index(text) for text in ("Arguments:", "Options:", "--until", "One path:", "--from", "--mass")]
    assert places == sorted(places)
    assert out.count("--json") == 1
