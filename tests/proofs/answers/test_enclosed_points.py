"""Rest points without simple coordinates: enclosed, taken by ``--at auto``, and judged there."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from flint import arb

import nonsmooth as ns
from nonsmooth.proofs.answers.best_point import best_point
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.rounded import certain_sign, enclosed, plain
from tests.oracles.measured_tables import MeasuredTable, SmallSteps
from tests.thorough import keep, thorough


def file_of(folder: Path, table: MeasuredTable) -> str:
    file = folder / "table.toml"
    file.write_text(table.toml, encoding="utf-8")
    return str(file)


@thorough  # test_python_takes_an_enclosed_point_too
@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize("rule", keep(1, ["ellipse", "roller"]))
def test_a_measured_table_is_checked_where_bodies_come_to_rest(
    rule: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = MeasuredTable.random(3, rule, off=3.0)
    status = run(app, ["check", file_of(tmp_path, table), "--at", "auto", "--require", "position", "--json"])
    found = json.loads(capsys.readouterr().out)
    position, heading = found["answers"]["position"], found["answers"]["heading"]
    assert (status, position["verdict"], heading["verdict"]) == (0, "comes home", "drifts")
    assert position["ends_within"] < 1e-11
    body, place = SmallSteps(table), np.array(position["at"])
    for angle in (1.0,):
        start = place + 15 * np.array([math.cos(angle), math.sin(angle)])
        end, _ = body.end(start, 20.0, 0.02)
        assert np.hypot(*(end - place)) < 0.03
    assert abs(body.twists(place[None])[0, 2] / body.length) == pytest.approx(heading["largest_rate"], rel=1e-3)


def test_python_takes_an_enclosed_point_too(tmp_path: Path) -> None:
    array = ns.load(file_of(tmp_path, MeasuredTable.random(1, "ellipse", off=3.0)))
    assert isinstance(array, ns.Array)
    checked = array.check(at="auto")
    assert checked.position.verdict == "comes home"
    assert checked.at == pytest.approx((1.01973, 1.64126), abs=1e-5)


def test_clauses_are_undecided_rather_than_those_of_the_number_that_stands_for_the_point(tmp_path: Path) -> None:
    scene = best_point(load_scene(file_of(tmp_path, MeasuredTable.random(3, "ellipse", off=3.0)))).scene
    x, y = scene.check.equilibrium
    assert [certain_sign(entry - plain(entry)) for entry in (x, y)] == [0, 0]
    assert x.ball().rad() < 1e-11


def test_what_vanishes_at_the_number_in_the_middle_is_not_taken_for_zero() -> None:
    field = NumberField()
    ball = arb("0.123456789", 1e-13)
    x, y = enclosed(field, ball, 0.7), enclosed(field, ball, -0.6)
    assert x.ball().contains(ball)
    middle = x.exact
    for vanishing in (x - middle, x - y, x * x - 2 * x * middle + middle * middle):
        assert certain_sign(vanishing) == 0
        before = field.rounded_signs
        vanishing.sign()
        assert field.rounded_signs > before
    before = field.rounded_signs
    assert (x * y - y * x).sign() == 0
    assert (x - 1).sign() == -1
    assert field.rounded_signs == before
