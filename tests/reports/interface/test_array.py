"""Arrays, systems and results as a script holds them."""

from __future__ import annotations

import json
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
import sympy
from matplotlib import pyplot as plt

import nonsmooth as ns
from nonsmooth.proofs.answers.answer import Heading, Position
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import few, keep, thorough

MU: dict[str, Any] = {"mu_roll": 1, "mu_side": "1/2"}


@pytest.fixture(autouse=True)
def _no_window() -> None:
    mpl.use("Agg")


def ring(**more: Any) -> ns.Array:
    return ns.Array.ring(4, radius="sqrt(2)", phase="pi/4", **{**MU, **more})


def test_a_ring_is_the_built_in_array() -> None:
    built_in = load_scene("four-wheel")
    for own, other in zip(ring().scene.wheels, built_in.wheels, strict=True):
        assert [str(x) for x in own.position] == [str(x) for x in other.position]
    assert ring().check().to_dict()["translation"] == ns.load("four-wheel").check().to_dict()["translation"]


@pytest.mark.parametrize(
    "half", [0.5, "1/2", Fraction(1, 2), Decimal("0.5"), sympy.Rational(1, 2), np.float64(0.5), "sqrt(1/4)"]
)
def test_a_number_means_what_it_says(half: object) -> None:
    assert ring(mu_side=half).scene.wheels[0].friction.side == Fraction(1, 2)


def test_a_float_means_its_shortest_decimal() -> None:
    assert ring(mu_side=0.1).scene.wheels[0].friction.side == Fraction(1, 10)
    assert ns.Array.ring(3, radius=np.float32(0.5), **MU).scene.wheels[0].position[0] == Fraction(1, 2)
    assert ns.Array.ring(4, radius=sympy.sqrt(2), phase=sympy.pi / 4, **MU).scene.wheels[0].position[0] == 1


def test_changes_return_another_array() -> None:
    array = ring()
    other = array.with_(mu_side=0.3, rule="box", at=(0.1, 0), radius=0.2, name="other")
    assert (array.scene.contact.rule, other.scene.contact.rule) == ("nearest", "box")
    assert str(other.scene.check.equilibrium[0]) == "1/10"
    assert other.scene.name == "other"
    assert array == ring()
    assert other != array


def test_wheels_one_by_one_grids_and_tables(tmp_path: Path) -> None:
    corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    wheels = ns.Array([ns.Wheel(corner, heading="inward") for corner in corners], **MU)
    (tmp_path / "wheels.csv").write_text("x,y\n1,1\n-1,1\n-1,-1\n1,-1\n", encoding="utf-8")
    table = ns.Array.from_csv(tmp_path / "wheels.csv", **MU)
    grid = ns.Array.grid(2, 2, pitch=2, **MU)
    places = [
        sorted((float(w.position[0]), float(w.position[1])) for w in a.scene.wheels) for a in (wheels, table, grid)
    ]
    assert places[0] == places[1] == places[2]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ring(mu_side="x+"), "friction.mu_side: required a number"),
        (lambda: ring(rule="no"), "contact.rule: required"),
        (lambda: ns.Array.ring(4, radius=-1, **MU), "ring.radius: required"),
        (lambda: ns.Array([ns.Wheel((0, 0)), ns.Wheel((0, 0))], **MU), "wheel"),
        (lambda: ring(mu_side=float("nan")), "friction.mu_side: required"),
        (lambda: ns.System(["x"], ["import os"]), "system.rhs"),
    ],
)
def test_errors_are_one_line(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ns.SceneError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_unknown_keywords_are_refused() -> None:
    with pytest.raises(TypeError, match=r"required a keyword among name, mu_roll, .* received 'mu'"):
        ring(mu=1)
    with pytest.raises(TypeError, match="received 'rule'"):
        ns.System(["x"], ["-x"]).with_(rule="box")


def test_a_result_answers() -> None:
    result = ring().check()
    assert (result.position.verdict, result.heading.verdict) == (Position.COMES_HOME, Heading.DRIFTS)
    assert (result.theorem4, result.position["within"]) == ("holds", Fraction(1, 2))
    assert result.evidence.check()
    assert result.destinations is None
    assert [row["question"] for row in result.rows()][:3] == ["position", "heading", "pose"]


@pytest.mark.parametrize("name", keep(1, ["four-wheel", "off-center"]))
def test_a_result_is_the_record_of_the_command(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    run(app, ["check", name, "--rule", "box", "--json"])
    printed = json.loads(capsys.readouterr().out)
    record = ns.load(name).check(rule="box").to_dict()
    record.pop("seconds")
    printed.pop("seconds")
    assert json.loads(json.dumps(record)) == printed


def test_the_best_point() -> None:
    array = ns.load("off-center")
    assert isinstance(array, ns.Array)
    result = array.check(at="auto")
    assert (result.at, result.position.verdict) == ((0.5, 0.25), Position.COMES_HOME)


@few(2)
@pytest.mark.parametrize("name", ["four-wheel", "grid-4x4", "saddle", "off-center", "eq-4", "flower"])
def test_results_print_in_few_lines(name: str) -> None:
    subject = ns.load(name)
    result = subject.check()
    lines = str(result).splitlines()
    assert len(lines) <= 12
    assert all(len(line) <= 100 for line in lines)
    parts: list[Any] = [subject, result, result.evidence, result.evidence.scene]
    parts += [getattr(result.evidence, "partition", None), getattr(subject, "scene", None)]
    start = (0.1, 0.2, 0.3)[: len(subject.system.states) if isinstance(subject, ns.System) else 3]
    path = subject.simulate(start, until=0.5)
    assert all(len(repr(part)) <= 2_000 for part in [*parts, path, path.trajectory])
    assert "<table" in result._repr_html_()


@thorough  # the small one: test_a_path_is_that_of_the_command, test_results.py
def test_paths_of_every_kind() -> None:
    array = ring()
    opened, closed = (array.simulate((0.2, 0.1, 0.3), until=1, feedback=law) for law in (False, True))
    assert abs(closed.state[-1, 2]) < abs(opened.state[-1, 2])
    smooth = array.simulate((0.2, 0.1, 0.3), until=1, rule="ellipse")
    assert smooth.partition is None
    assert np.hypot(*smooth.state[-1, :2]) < 0.01
    assert [list(row) for row in opened.rows()[:1]] == [["t", "x", "y", "theta"]]
    with pytest.raises(ValueError, match="nothing"):
        array.simulate((0.2, 0.1, 0.3), feedback="nothing")


def test_rows_and_films_of_a_closed_loop_are_those_of_the_command(tmp_path: Path) -> None:
    array = ring()
    closed = array.simulate((0.2, 0.1, 0.3), until=1, feedback=True)
    table = closed.save(tmp_path / "path.csv").read_text(encoding="utf-8").splitlines()
    rows = closed.rows()
    assert ",".join(rows[0]) == table[0] == "t,x,y,theta,u_1,u_2,u_3,u_4"
    assert [float(cell or "nan") for cell in table[-1].split(",")] == pytest.approx(
        [float("nan") if value is None else value for value in rows[-1].values()], abs=0, nan_ok=True
    )
    driven = array.with_(rule="ellipse").simulate((0.05, 0.02, 0.1), until=0.2, feedback=True)
    with pytest.raises(ValueError, match="film"):  # which would show the speeds of the open loop
        driven.animate(tmp_path / "path.html")
    assert not (tmp_path / "path.html").exists()


def test_what_a_method_does_not_follow_is_refused() -> None:
    array = ring()
    with pytest.raises(ValueError, match="feedback: required method events, hysteresis or smoothed, received method"):
        array.simulate((0.2, 0.1, 0.3), method="dynamics", feedback=True)
    with pytest.raises(ValueError, match="kinematics: required exact with method dynamics, received leading"):
        array.simulate((0.2, 0.1, 0.3), method="dynamics", kinematics="leading")


def test_paths_of_plain_systems_are_as_long_as_those_of_the_command() -> None:
    path = ns.System(["x", "y"], ["y", "-x"]).simulate((1, 0))
    assert path.t[-1] == 2


def test_plots_draw_on_the_axes_given() -> None:
    _, axes = plt.subplots(1, 4)
    array = ring()
    assert array.plot(axes[0]) is axes[0]
    assert array.plot(axes[1], show="cells") is axes[1]
    assert array.plot(axes[2], show="rates") is axes[2]
    assert array.simulate((0.2, 0.1, 0)).plot(axes[3]) is axes[3]
    assert all(ax.has_data() or ax.patches for ax in axes)
    own = ns.System(["x"], ["-sign(x)"]).simulate((0.3,), until=1).plot()
    assert own.get_ylabel() == "x"
    with pytest.raises(ValueError, match="required one of cells, array, rates"):
        array.plot(axes[0], show="nothing")
    plt.close("all")


@thorough  # the small one: test_a_report_is_the_file_of_the_command, test_results.py
def test_reports_are_written(tmp_path: Path) -> None:
    written = ring(name="mine").report(tmp_path / "mine.md")
    assert written.read_text(encoding="utf-8").startswith("# Derivation report: mine")


def test_a_table_of_pandas_where_there_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    class Pandas:
        DataFrame: Any = staticmethod(list)

    monkeypatch.setattr("nonsmooth.reports.studies.result.import_module", lambda name: Pandas)
    assert ring().check().to_dataframe() == ring().check().rows()
    assert len(ns.load("eq-4").check().to_dataframe()) > 3
    assert len(ring().simulate((0.1, 0.2, 0)).to_dataframe()) > 1
