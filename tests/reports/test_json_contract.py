"""The help and the page on design against the program: commands, what the shell completes, JSON, layout."""

from __future__ import annotations

import inspect
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

from nonsmooth.reports.cli import app
from nonsmooth.reports.commands.registry import COMMANDS, command_function
from nonsmooth.reports.derivations.derivation import complete_part
from nonsmooth.reports.output.console import run
from nonsmooth.reports.output.study_options import complete_scene, complete_study
from tests.reports.conftest import Invoke
from tests.thorough import few

# ---- The page on design against the program: its JSON table, its commands and its layout leave nothing out.

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
PACKAGES = ("symbolic", "analysis", "proofs", "reports")
UNLISTED = {"schema", "exact"}  # described above the table
ARRAY, SYSTEM = "nonsmooth-check/2", "nonsmooth-check/1` of a plain"
CASES = {
    "check four-wheel": ARRAY,
    "check ring-5 --rule ellipse": ARRAY,
    "check eq-3": SYSTEM,
    "check four-wheel eq-3": "nonsmooth-checks/1",
    "partition four-wheel": "nonsmooth-partition/1",
    "partition four-wheel --rule ellipse": "nonsmooth-field/1",
    "partition four-wheel --compare": "nonsmooth-agreement/1",
    "sweep four-wheel --vary mu_side=1/2:2:2 --fail 1 --workers 1": "nonsmooth-sweep/2",
    "sweep eq-4 --vary radius=1/4,1/2 --borders --workers 1": "nonsmooth-sweep/2",
    "derive four-wheel --only verdict,cells": "nonsmooth-derivation/1",
    "derive eq-4 --only verdict": "nonsmooth-derivation/1",
    "simulate four-wheel --from 0.2,0.4,0": "nonsmooth-trajectory/1",
    "simulate eq-3 --from 0.2,0.4": "nonsmooth-trajectory/1",
    "simulate four-wheel --from 0.2,0.4,0 --method dynamics": "nonsmooth-trajectory/1",
    "simulate four-wheel --from 0.2,0.4,0 --until 0.01 --method dynamics --compare-masses": "nonsmooth-masses/1",
    "simulate four-wheel --from 0.2,0.1,0 --fail 3": "nonsmooth-failed-paths/1",
    "simulate stick-slip --from 2,0 --orbit": "nonsmooth-orbit/1",
    "simulate four-wheel --grid 4": "nonsmooth-map/1",
    "simulate carton-on-6x6 --rule ellipse --headings 8 --until 0.2": "nonsmooth-headings/1",
    "simulate eq-4 --grid 2 --until 1": "nonsmooth-system-map/1",
    "audit four-wheel --lyapunov x**2+y**2": "nonsmooth-audit/1",
    "precision relay-oscillator --runs 1 --time-limit 0.02": "nonsmooth-precision/1",
    "precision four-wheel --study derivation --runs 1": "nonsmooth-precision/1",
    "vehicle husky-a200 --spin 2": "nonsmooth-vehicle/1",
    "scenes": "nonsmooth-scenes/1",
    "rules": "nonsmooth-rules/1",
}


def described(schema: str) -> set[str]:
    """The words in backquotes of a row of the JSON table."""
    (row,) = [
        line
        for line in PAGE.splitlines()
        if line.startswith(f"| `{schema}") and (schema is SYSTEM or "of a plain" not in line)
    ]
    return {word for words in re.findall(r"`([^`]*)`", row) for word in re.findall(r"\w+", words)}


def clause(name: str) -> set[str]:
    """The keys of a clause, from the table of clauses."""
    (row,) = re.findall(rf"^\| `{name}` \| (.*) \|$", PAGE.split("The clauses, beside")[1], re.MULTILINE)
    return set(re.findall(r"`(\w+)`", row)) | {"verdict", "reason"}


def answer(name: str) -> set[str]:
    """The keys of an answer, from the table of answers."""
    (row,) = re.findall(rf"^\| `{name}` \| (.*) \|$", PAGE.split("The `answers` of a check")[1], re.MULTILINE)
    return set(re.findall(r"`(\w+)`", row)) | {"verdict", "reason"}


def printed(capsys: pytest.CaptureFixture[str], command: str) -> dict[str, Any]:
    assert run(app, [*command.split(), "--json"]) in {0, 1, 3}
    record: dict[str, Any] = json.loads(capsys.readouterr().out)
    return record


@few(10)
@pytest.mark.parametrize("command", CASES)
def test_every_key_is_in_the_table(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    record, schema = printed(capsys, command), CASES[command]
    assert record["schema"] == schema.split("`")[0]
    assert set(record) - UNLISTED <= described(schema)
    rows = record.get("rows") or []
    assert all(set(row) <= described(schema) for row in rows)
    if schema == ARRAY:
        for name in ("equilibrium", "translation", "rotation", "feedback"):
            assert set(record[name]) - UNLISTED <= clause(name)
        for name in ("position", "heading", "pose"):
            assert set(record["answers"][name]) - UNLISTED <= answer(name)


def test_a_certificate_is_in_the_table(tmp_path: Path) -> None:
    file = tmp_path / "c.json"
    assert run(app, ["check", "four-wheel", "--certificate", str(file)]) == 0
    keys = set(json.loads(file.read_text(encoding="utf-8")))
    assert keys == {"version", "statement", "evidence", "notes"}
    assert keys <= described("nonsmooth-certificate/2` (an array")


def test_every_schema_of_the_code_is_in_the_table() -> None:
    files = [path.read_text(encoding="utf-8") for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    schemas = {name for text in files for name in re.findall(r'"(nonsmooth-\w+/\d+)"', text)}
    assert len(schemas) > len(set(CASES.values())) - 2
    assert all(f"| `{name}`" in PAGE for name in schemas)


def test_every_command_is_in_the_table_and_has_an_example() -> None:
    for name, command in get_command(app).commands.items():  # type: ignore[attr-defined]
        assert f"| `nonsmooth {name}" in PAGE, name
        assert f"nonsmooth {name}" in (command.epilog or ""), name
        assert name in {"scenes", "rules"} or "Exit status: 0" in (command.help or ""), name
        described_options = [parameter.help for parameter in command.params if parameter.name != "help"]
        assert all(text and text.endswith(".") for text in described_options), name


def test_every_part_is_in_the_layout() -> None:
    parts = {
        path.parent.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("__init__.py")
    }
    assert {part for part in parts if f"| `{part}/` |" not in PAGE} == set()


# ---- The help, and what the shell completes. -----------------------------------------------------

# ---- The help: what stands in the registry of commands is what the commands say, and showing it imports no command.


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


# ---- What the shell completes: sections, studies, rules and scenes. ------------------------------


def test_sections_are_completed_after_a_comma() -> None:
    assert complete_part("verd") == ["verdict"]
    assert complete_part("verdict,cel") == ["verdict,cells"]
    assert complete_part("nothing") == []


def test_studies_and_scenes_are_completed() -> None:
    assert "derivation" in complete_study("der")
    assert complete_study("nothing") == []
    assert complete_scene("four-wheel") == ["four-wheel", "four-wheel-side"]
