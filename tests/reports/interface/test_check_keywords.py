"""What a check in Python is asked by keywords is what the command is asked by options."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import nonsmooth as ns
from nonsmooth.reports.checks.check_results import RulesResult, TippedResult
from tests.reports.conftest import Invoke

TIPPING = """
name = "tipping"
friction = { mu_roll = 1, mu_side = "1/2" }
check = { equilibrium = [0, 0], radius = "1/8" }
body = { shape = "disc", radius = "1/2" }
wheel = [{ position = ["1/8", 0], heading = "inward" }, { position = ["1/8", "1/8"], heading = "inward" }]
"""


def four_wheel() -> ns.Array:
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    return array


def without_seconds(record: dict[str, object]) -> dict[str, object]:
    return {key: value for key, value in record.items() if key != "seconds"}


def test_files_and_statuses_follow(invoke: Invoke, tmp_path: Path) -> None:
    files = {"certificate": str(tmp_path / "c.json"), "law": str(tmp_path / "l.py")}
    found = four_wheel().check(require="position,pose", **files)
    assert (found.exit_status, four_wheel().check(require="heading").exit_status) == (0, 1)
    assert json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))["statement"]
    assert "def speeds" in (tmp_path / "l.py").read_text(encoding="utf-8")
    record = invoke("check", "four-wheel", "--require", "position,pose", "--json").record
    assert without_seconds(found.to_dict()) == without_seconds(record)
    with pytest.raises(ValueError, match=r"^require: required names among position, heading"):
        four_wheel().check(require="tea")


def test_all_rules_are_compared(invoke: Invoke) -> None:
    found = four_wheel().check(rule="all")
    assert isinstance(found, RulesResult)
    record = invoke("check", "four-wheel", "--rule", "all", "--json").record
    own = [without_seconds(check) for check in found.to_dict()["checks"]]
    assert own == [without_seconds(check) for check in record["checks"]]
    assert {row["rule"] for row in found.rows()} == {"nearest", "box", "ellipse", "roller"}


def test_what_it_says_is_saved_and_drawn(tmp_path: Path) -> None:
    found = four_wheel().check()
    assert found.save(tmp_path / "c.csv").read_text(encoding="utf-8").startswith("question,verdict,why\nposition,comes")
    assert found.save(tmp_path / "c.svg").stat().st_size > 1000
    assert ns.System(["x"], ["-x"]).check().save(tmp_path / "s.json").exists()


def test_that_a_body_tips_is_a_result(tmp_path: Path, invoke: Invoke) -> None:
    (tmp_path / "tipping.toml").write_text(TIPPING, encoding="utf-8")
    array = ns.load(tmp_path / "tipping.toml")
    assert isinstance(array, ns.Array)
    found = array.check()
    assert isinstance(found, TippedResult)
    assert (str(found.position.verdict), found.exit_status) == ("tips", 1)
    assert found.to_dict() == invoke("check", "tipping.toml", "--json").record
