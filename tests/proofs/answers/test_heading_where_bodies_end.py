"""The heading of bodies that end beside the checked point, against a simulator that shares nothing with the proofs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import root

import nonsmooth as ns
from tests.oracles.measured_tables import Floats, MeasuredTable, SmallSteps


def answers_of(table: MeasuredTable, folder: Path) -> dict[str, Any]:
    """What a check says of a table."""
    file = folder / "table.toml"
    file.write_text(table.toml, encoding="utf-8")
    answers: dict[str, Any] = ns.load(str(file)).check().to_dict()["answers"]
    return answers


def rate_at_rest(table: MeasuredTable, about: Floats) -> float:
    """The rotation rate where a body rests that starts at a place, by Newton's method on its velocity."""
    steps = SmallSteps(table)
    found = root(steps.velocity, about, tol=1e-10)
    assert found.success
    return float(steps.twists(found.x[None])[0, 2] / steps.length)


@pytest.mark.parametrize(("seed", "rule"), [(1, "ellipse"), (2, "ellipse"), (4, "ellipse"), (3, "roller")])
def test_a_body_that_ends_beside_the_point_turns_at_the_rate_that_is_said(seed: int, rule: str, tmp_path: Path) -> None:
    """The point itself is no place of rest; on one of these tables bodies end farther away than the accuracy."""
    table = MeasuredTable.random(seed, rule, off=3.0)
    said = answers_of(table, tmp_path)
    assert said["position"]["verdict"] in {"comes near", "leaves"}
    assert said["heading"]["verdict"] == "drifts"
    rate = rate_at_rest(table, np.array(said["position"]["at"], dtype=float))
    assert abs(rate) <= said["heading"]["largest_rate"] == pytest.approx(abs(rate), rel=1e-3)
