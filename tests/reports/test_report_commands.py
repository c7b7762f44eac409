"""Every figure of a report names the command that draws it: the command runs, wherever the checked point lies."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from tests.thorough import keep, thorough

TABLE = """name = "table"
[friction]
mu_roll = 0.8
mu_side = 0.2
[field]
kind = "expression"
x = "0.3 - x"
y = "-0.1 - y"
[check]
equilibrium = [0.3, -0.1]
radius = 0.1
"""
FEW_WHEELS, MANY_WHEELS = (0.2, 0.4), (0.0, 0.2, 0.4, 0.6)  # x of the wheels, in two rows
DRAWN = re.compile(r"Drawn by `([^`]*)`")
SECTIONS = "array,cells,derivative,trajectories,rules"


def write_table(places: tuple[float, ...]) -> None:
    wheels = [f"[[wheel]]\nposition = [{x}, {y}]\n" for x in places for y in (0.0, -0.2)]
    Path("table.toml").write_text(TABLE + "".join(wheels), encoding="utf-8")


@pytest.mark.parametrize(
    ("rule", "places"),
    keep(1, [("ellipse", FEW_WHEELS), *((rule, MANY_WHEELS) for rule in ("ellipse", "nearest", "box"))]),
)
def test_commands_of_figures_run(
    rule: str,
    places: tuple[float, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    write_table(places)
    assert run(app, ["derive", "table.toml", "--rule", rule, "--only", SECTIONS]) == 0
    commands = DRAWN.findall(capsys.readouterr().out)
    assert len(commands) == {"nearest": 7, "box": 6, "ellipse": 2}[rule]
    for command in commands:
        program, *arguments = shlex.split(command)
        assert program == "nonsmooth"
        assert run(app, arguments) == 0, capsys.readouterr().err
        assert Path(arguments[-1]).stat().st_size > 0


@thorough  # the small one: test_commands_of_figures_run
def test_the_path_that_a_command_draws_is_that_of_the_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_table(MANY_WHEELS)
    assert run(app, ["derive", "table.toml", "--only", "trajectories"]) == 0
    command = next(line for line in DRAWN.findall(capsys.readouterr().out) if "open-loop" in line)
    words = shlex.split(command)
    start = [float(value) for value in words[words.index("--from") + 1].split(",")]
    assert start == pytest.approx([0.3 + 0.04, -0.1 + 0.08, 0.0])
