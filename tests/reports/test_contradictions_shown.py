"""A contradiction is undecided and said with both sides, wherever the verdict is written."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import nonsmooth as ns
from nonsmooth.proofs import theorem4
from nonsmooth.proofs.findings.verdicts import Theorem4, Translation
from nonsmooth.proofs.theorem4_result import CellCheck, Check
from nonsmooth.reports.checks import subject
from nonsmooth.reports.sweeps import outcome as outcomes
from tests.reports.conftest import Invoke
from tests.thorough import few

BOTH_SIDES = ("translation unstable: V* < 0 at every nonzero vertex", "sampled starts near the point")

# Three rims at 67 degrees and its turns, rounded: under rule ellipse the body rests at the point, to every digit.
RING = """
name = "ring"
friction = { mu_roll = 1, mu_side = "1/2" }
check = { equilibrium = [0, 0], radius = "1/4" }
contact = { rule = "ellipse" }
wheel = [
    { position = [1, 0], heading = "187 deg", speed = 1 },
    { position = ["-1/2", "sqrt(3)/2"], heading = "307 deg", speed = 1 },
    { position = ["-1/2", "-sqrt(3)/2"], heading = "67 deg", speed = 1 },
]
"""


def wrong(check: Check) -> Check:
    """The four-wheel array, which attracts, as a point that bodies leave: a fault that no evidence shows."""
    assert isinstance(check, CellCheck)
    translation = replace(check.translation, verdict=Translation.UNSTABLE, fan=None)
    return replace(check.with_results(translation=translation), verdict=Theorem4.FAILS)


@pytest.fixture
def planted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Such a fault behind every command."""
    truly = theorem4.check_theorem4
    for module in (theorem4, subject, outcomes):
        monkeypatch.setattr(module, "check_theorem4", lambda *given, **how: wrong(truly(*given, **how)))


@pytest.mark.usefixtures("planted")
def test_the_terminal_says_both_sides(invoke: Invoke) -> None:
    outcome = invoke("check", "four-wheel", "--require", "pose")
    assert outcome.status == 3
    text = " ".join(outcome.out.split())
    assert "contradiction between position and destinations: nobody may rely on either" in text
    for side in BOTH_SIDES:
        assert side in text


@pytest.mark.usefixtures("planted")
def test_json_says_both_sides(invoke: Invoke) -> None:
    outcome = invoke("check", "four-wheel", "--json")
    assert outcome.status == 3
    record = outcome.record
    found = record["contradictions"][0]
    assert found["between"] == "position and destinations"
    for side, words in zip(found["sides"], BOTH_SIDES, strict=True):
        assert words in side
    assert record["answers"]["position"]["verdict"] == "undecided"
    assert record["translation"]["verdict"] == record["theorem4"]["verdict"] == "undecided"
    assert "contradictions" in invoke("check", "four-wheel", "--rule", "nearest", "--json").record


@pytest.mark.usefixtures("planted")
def test_many_scenes_the_report_and_python_say_it(invoke: Invoke, tmp_path: Path) -> None:
    outcome = invoke("check", "four-wheel", "four-wheel", "--json")
    assert outcome.status == 3
    assert [check["theorem4"]["verdict"] for check in outcome.record["checks"]] == ["undecided"] * 2
    invoke("derive", "four-wheel", "--only", "answers,verdict", "-o", str(tmp_path / "report.md"))
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "contradiction between position and destinations" in text
    result = ns.load("four-wheel").check()
    assert isinstance(result, ns.CheckResult)
    assert (str(result.position.verdict), result.theorem4) == ("undecided", "undecided")
    assert result.contradictions
    assert "position and destinations contradict each other" in " ".join(repr(result).split())
    assert result.rows()[-1]["question"] == "contradiction"


@pytest.mark.usefixtures("planted")
def test_a_sweep_says_it(invoke: Invoke) -> None:
    command = ("sweep", "four-wheel", "--vary", "mu_side=1/4,1/2", "--workers", "1")
    for row in invoke(*command, "--json").record["rows"]:
        assert (row["position"], row["theorem4"]) == ("undecided", "undecided")
        assert row["why"].startswith("position and destinations contradict each other: ")
    said = " ".join(invoke(*command).out.split())
    assert "2 of 2 scenes are undecided for that (please report this): position and destinations contradict" in said


@pytest.mark.usefixtures("planted")
def test_no_certificate_and_no_law_are_written_of_it(invoke: Invoke, tmp_path: Path) -> None:
    file = tmp_path / "certificate.json"
    outcome = invoke("check", "four-wheel", "--certificate", str(file))
    assert outcome.status == 3
    assert "not written: what the check says contradicts itself" in outcome.err
    assert not file.exists()


@few(1)
@pytest.mark.parametrize("mu_side", ["1/2", "1"])
def test_a_rounded_ring_is_not_said_to_drive_away_what_rests_on_it(
    invoke: Invoke, tmp_path: Path, mu_side: str
) -> None:
    file = tmp_path / "ring.toml"
    file.write_text(RING.replace('1/2" }\ncheck', f'{mu_side}" }}\ncheck'), encoding="utf-8")
    outcome = invoke("check", str(file), "--json")
    assert outcome.status == 0, json.dumps(outcome.record["theorem4"])
    assert "only rounding tells from the point" in outcome.record["theorem4"]["reason"]
    assert outcome.record["answers"]["position"]["verdict"] == "comes home"
