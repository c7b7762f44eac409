"""``--allow-outside``: every command that reads a scene keeps its table of wheels in the scene's folder without it."""

from __future__ import annotations

from pathlib import Path

import pytest

from nonsmooth.reports.output.console import BAD_INPUT
from tests.reports.conftest import Invoke

SCENE = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[wheels]\nfile = "../table.csv"\n[check]\nradius = "1/10"\n'
COMMANDS = {
    "check": (),
    "partition": (),
    "derive": ("--only", "verdict"),
    "simulate": ("--from", "0,0,0", "--until", "0.1"),
    "precision": ("--study", "derivation", "--runs", "1", "--time-limit", "0.1"),
    "stress": (),
    "audit": ("--lyapunov", "x**2 + y**2"),
}


@pytest.fixture
def scene(tmp_path: Path) -> str:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "my.toml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "table.csv").write_text("x,y\n1,1\n-1,1\n-1,-1\n1,-1\n", encoding="utf-8")
    return "folder/my.toml"


@pytest.mark.parametrize("command", COMMANDS)
def test_a_table_outside_is_refused_in_one_line(invoke: Invoke, scene: str, command: str) -> None:
    outcome = invoke(command, scene, *COMMANDS[command])
    assert (outcome.status, outcome.out) == (BAD_INPUT, "")
    assert "my.toml: wheels.file ../table.csv: required a file in the scene's folder" in outcome.err
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize("command", [name for name in COMMANDS if name != "stress"])
def test_the_option_allows_it(invoke: Invoke, scene: str, command: str) -> None:
    outcome = invoke(command, scene, *COMMANDS[command], "--allow-outside")
    assert outcome.status in (0, 1, 3)
    assert outcome.out


def test_a_report_names_the_option_that_it_needs(invoke: Invoke, scene: str) -> None:
    assert "--allow-outside" in invoke("derive", scene, "--only", "versions", "--allow-outside").out
