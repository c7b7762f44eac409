"""What no forces prove is said in words, in every view of a check under rule ``ellipse``."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

INWARD = """
friction = { mu_roll = 1, mu_side = 0 }
wheel = [{ position = [1, 1] }, { position = [-1, 1] }, { position = [-1, -1] }, { position = [1, -1] }]
"""
CARRIED = """
friction = { mu_roll = 1, mu_side = 0 }
field = { kind = "spiral", angle = "pi/2" }
[ring]
count = 3
[check]
radius = "1/10"
"""
HUGE = re.compile(r"e\+\d\d")  # no length, speed or rate here is above 10


@pytest.fixture(params=keep(1, [INWARD, CARRIED]), ids=["inward", "carried"])
def scene(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    (tmp_path / "free.toml").write_text(request.param, encoding="utf-8")
    return "free.toml"


SECTIONS = ("--only", "verdict,situation,derivative,theorem,feedback,rules")


@few(1)
@pytest.mark.parametrize(
    "views",
    [("check",), ("check", "--json"), ("derive", *SECTIONS), ("derive", *SECTIONS[:1], "theorem,feedback", "--json")],
    ids=["check", "check-json", "report", "report-json"],
)
def test_no_view_shows_a_number_that_is_none(invoke: Invoke, scene: str, views: tuple[str, ...]) -> None:
    command, *options = views
    outcome = invoke(command, scene, "--rule", "ellipse", *options)
    assert outcome.status in (0, 1, 3)
    assert not HUGE.search(outcome.out)
    assert "nan" not in re.findall(r"[a-z]+", outcome.out)
    if "--json" in options:
        json.loads(outcome.out)


@thorough  # the small one: test_free_motions_are_named_instead_of_numbers, analysis/test_proved_minima.py
def test_the_missing_motion_is_named(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "free.toml").write_text(INWARD, encoding="utf-8")
    sentence = "no row with friction resists the motion xi = (0, 0, 1)"
    table = invoke("check", "free.toml", "--rule", "ellipse", "--no-prune", "--evidence").out
    printed = " ".join(re.sub("[│╭╮╰╯├┤─┼]", " ", table).split())
    assert "largest V*/|c| over the square not certified: " in printed
    assert printed.count("certified: no row with friction resists") == 3
    record = invoke("check", "free.toml", "--rule", "ellipse", "--no-prune", "--json").record
    assert record["translation"]["not_certified"] == sentence
    assert record["translation"]["worst_rate"] is None
    for sample in record["feedback"]["sampled"]:
        assert (sample["worst_rate"], sample["worst_state"], sample["fails"]) == (None, None, None)
        assert sample["not_certified"] == sentence
    assert (
        "is not certified: no row with friction resists"
        in invoke("derive", "free.toml", "--rule", "ellipse", *SECTIONS).out
    )
