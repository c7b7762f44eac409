"""Documents against the program: the page on design, the help, the gallery, and what the shell completes."""

from __future__ import annotations

import inspect
import json
import math
import re
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

from nonsmooth.reports.checks.subject import Invocation
from nonsmooth.reports.cli import app
from nonsmooth.reports.commands.registry import COMMANDS, command_function
from nonsmooth.reports.derivations.derivation import complete_part
from nonsmooth.reports.output.console import run
from nonsmooth.reports.output.study_options import complete_scene, complete_study
from tests.gallery import PAGE, SHOWN, gallery_files, gallery_page, gallery_report
from tests.reports.conftest import Invoke
from tests.reports.derived import derived, page
from tests.thorough import few, keep

# ---- The page on design against the program: its JSON table, its commands and its layout leave nothing out.

ROOT = Path(__file__).resolve().parents[2]
DESIGN_PAGE = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
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
    "sweep ring-3 --vary mu_side=1/2:2:2 --fail 1 --workers 1": "nonsmooth-sweep/2",
    "sweep eq-4 --vary radius=1/4,1/2 --borders --workers 1": "nonsmooth-sweep/2",
    "derive four-wheel --only verdict,cells": "nonsmooth-derivation/1",
    "derive eq-4 --only verdict": "nonsmooth-derivation/1",
    "simulate four-wheel --from 0.2,0.4,0": "nonsmooth-trajectory/1",
    "simulate eq-3 --from 0.2,0.4": "nonsmooth-trajectory/1",
    "simulate four-wheel --from 0.2,0.4,0 --method dynamics": "nonsmooth-trajectory/1",
    "simulate four-wheel --from 0.2,0.4,0 --until 0.001 --method dynamics --compare-masses": "nonsmooth-masses/1",
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
        for line in DESIGN_PAGE.splitlines()
        if line.startswith(f"| `{schema}") and (schema is SYSTEM or "of a plain" not in line)
    ]
    return {word for words in re.findall(r"`([^`]*)`", row) for word in re.findall(r"\w+", words)}


def keys_of(name: str, table: str) -> set[str]:
    """The keys of a clause or an answer, from their table."""
    (row,) = re.findall(rf"^\| `{name}` \| (.*) \|$", DESIGN_PAGE.split(table)[1], re.MULTILINE)
    return set(re.findall(r"`(\w+)`", row)) | {"verdict", "reason"}


clause = partial(keys_of, table="The clauses, beside")
answer = partial(keys_of, table="The `answers` of a check")


def printed(capsys: pytest.CaptureFixture[str], command: str) -> dict[str, Any]:
    assert run(app, [*command.split(), "--json"]) in {0, 1, 3}
    record: dict[str, Any] = json.loads(capsys.readouterr().out)
    return record


@few(6)
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
    assert all(f"| `{name}`" in DESIGN_PAGE for name in schemas)


def test_every_command_is_in_the_table_and_has_an_example() -> None:
    for name, command in get_command(app).commands.items():  # type: ignore[attr-defined]
        assert f"| `nonsmooth {name}" in DESIGN_PAGE, name
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
    assert {part for part in parts if f"| `{part}/` |" not in DESIGN_PAGE} == set()


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


# ---- What the shell completes: sections, studies, rules and scenes -------------------------------


def test_sections_are_completed_after_a_comma() -> None:
    assert complete_part("verd") == ["verdict"]
    assert complete_part("verdict,cel") == ["verdict,cells"]
    assert complete_part("nothing") == []


def test_studies_and_scenes_are_completed() -> None:
    assert "derivation" in complete_study("der")
    assert complete_study("nothing") == []
    assert complete_scene("four-wheel") == ["four-wheel", "four-wheel-side"]


# ---- The gallery in the documents is what the program writes today: the same words, and numbers up to rounding.

DOCS = Path(__file__).resolve().parents[2] / "docs"
STALE = "the gallery is stale: run make gallery"
NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:e[+-]?\d+)?)")
IDENTITY = re.compile(r'(?<=id=")[^"]*|(?<=#)[\w-]+|Python [\d.]+')  # hashes of coordinates; the interpreter's version
# An error such as 1.4e-16 is what one processor's arithmetic left over: another leaves another. So it is with the
# digits of a condition number such as 3.9e14, the inverse of what is left over.
LEFT_OVER = re.compile(
    r"<mn>[\d.]+</mn><mo>[^<]*</mo><msup><mn>10</mn><mrow>(?:<mo>[^<]*</mo>)?<mn>1[3-9]</mn></mrow></msup>"
)
# Another machine rounds otherwise in the last digit shown, and an integrator may take a step more or less.
RELATIVE, ABSOLUTE = 0.01, 0.02
MANY_STEPS = 20  # counts from here on may be of steps


def differences(old: str, new: str) -> list[tuple[str, str]]:
    """Pieces that differ by more than rounding."""
    first, second = (NUMBER.split(LEFT_OVER.sub("rounding", IDENTITY.sub("", text))) for text in (old, new))
    if len(first) != len(second):
        return [("other words", "")]
    pairs = zip(first, second, strict=True)
    return [(a, b) for a, b in pairs if a != b and not (NUMBER.fullmatch(a) and NUMBER.fullmatch(b) and close(a, b))]


def close(first: str, second: str) -> bool:
    if first.isdigit() and second.isdigit() and min(int(first), int(second)) >= MANY_STEPS:
        return abs(int(first) - int(second)) <= max(1, RELATIVE * int(first))
    return math.isclose(float(first), float(second), rel_tol=RELATIVE, abs_tol=ABSOLUTE)


@pytest.mark.parametrize("name", keep(1, SHOWN))
def test_the_gallery_is_fresh(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.gallery.render_report", lambda report, suffix: page(name))
    for path, content in gallery_files(name, derived(name)):
        shown = DOCS.joinpath(path).read_text(encoding="utf-8")
        assert differences(shown, content.decode()) == [], STALE
    overview = DOCS.joinpath(PAGE).read_text(encoding="utf-8")
    assert gallery_page({name: derived(name)}).split("\n## ")[1].strip() in overview, STALE


def test_the_reports_are_those_of_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    """As ``derived`` makes them: of the scene under its name, with all sections."""
    asked: list[tuple[Any, ...]] = []
    monkeypatch.setattr("tests.gallery.derive_report", lambda *given: asked.append(given))
    for name in SHOWN:
        gallery_report(name)
    assert [(scene.name, *rest) for scene, *rest in asked] == [(name, Invocation(name)) for name in SHOWN]


def test_the_page_shows_what_the_gallery_holds() -> None:
    page = DOCS.joinpath(PAGE).read_text(encoding="utf-8")
    assert re.findall(r"^## (.+)$", page, re.M) == list(SHOWN)
    assert {path.stem for path in (DOCS / "gallery").iterdir()} == set(SHOWN)


def power(mantissa: str, exponent: int) -> str:
    """``1.4 * 10^-16`` as the reports write it."""
    raised = f"<msup><mn>10</mn><mrow><mo>&#x02212;</mo><mn>{exponent}</mn></mrow></msup>"
    return f"<mn>{mantissa}</mn><mo>&#x022C5;</mo>{raised}"


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("V = 1.414, 7 cells", "V = 1.415, 7 cells", True),
        ("V = 1.414, 7 cells", "V = 1.5, 7 cells", False),
        ("V = 1.414, 7 cells", "V = 1.414, 8 cells", False),
        ("holds", "fails", False),
        ("1 2", "1 2 3", False),
        ('<g id="p1a">', '<g id="p2b">', True),
        (power("1.4", 16), power("4.6", 17), True),
        (power("1.4", 9), power("4.6", 9), False),
    ],
)
def test_what_counts_as_stale(old: str, new: str, same: bool) -> None:
    assert (differences(old, new) == []) is same
