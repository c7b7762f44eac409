"""``--fail 1`` on check and sweep."""

from __future__ import annotations

import pytest

from tests.reports.conftest import Invoke
from tests.thorough import thorough


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_check_lists_failures_and_names_the_worst(invoke: Invoke) -> None:
    done = invoke("check", "four-wheel", "--fail", "1")
    assert done.status == 0
    out = " ".join(done.out.split("with any one wheel")[1].split())
    assert "the worst: wheels 1-4 lifted: position tips, heading undecided, pose undecided (by what is proved: " in out
    assert out.count("stays near") == 1  # one line for all that answer alike
    assert "wheels 1-4 stopped: a law may need the wheel that is stopped" in out
    shown = invoke("check", "four-wheel", "--fail", "1", "--evidence").out.split("with any one wheel")[1]
    assert shown.count("stays near") == 4
    record = invoke("check", "four-wheel", "--fail", "any", "--json").record
    assert len(record["failures"]) == 8
    assert [failure["wheel"] for failure in record["failures"] if failure["worst"]] == [1]
    assert invoke("check", "four-wheel", "--json").record["failures"] is None


@thorough  # the small one: test_check_lists_failures_and_names_the_worst
def test_every_rule_has_its_own_failures(invoke: Invoke) -> None:
    checks = invoke("check", "four-wheel", "--rule", "all", "--fail", "1", "--json").record["checks"]
    assert [len(check["failures"]) for check in checks] == [8] * 4


def test_a_sweep_has_the_failures_of_every_scene(invoke: Invoke) -> None:
    command = ("sweep", "four-wheel", "--vary", "mu_side=1/2,2", "--fail", "1", "--workers", "1")
    rows = invoke(*command, "--json").record["rows"]
    one = invoke("check", "four-wheel", "--fail", "1", "--json").record
    assert rows[0]["failures"] == one["failures"]
    out = invoke(*command).out
    assert "worst failure" in out
    assert out.count("tips") == 2
