"""Arrays, systems, checks, results and Filippov sets as a script holds them."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterator
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
from nonsmooth.analysis.cells.filippov import filippov_twists, upper_derivative_at
from nonsmooth.analysis.measurements import cases
from nonsmooth.analysis.measurements.cases import POWERS, RATIOS
from nonsmooth.proofs import measurements
from nonsmooth.proofs.answers.answer import Heading, Position
from nonsmooth.reports.checks.check_results import RulesResult, TippedResult
from nonsmooth.reports.cli import app
from nonsmooth.reports.interface.filippov_set import FilippovSet
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic import annihilator, constraint_matrix, stacked_constraints, wheel_constraints
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.reports.conftest import Invoke
from tests.thorough import few, keep

# ---- Results as a script holds them: what the command line writes, and short to print ------------

MOST_LINES, WIDEST, LONGEST = 12, 100, 2_000
DEEPEST = 6  # attributes of attributes that are printed
FIRST = 3  # entries of a sequence that are printed


@pytest.fixture(autouse=True)
def _no_window() -> Iterator[None]:
    mpl.use("Agg")
    yield
    plt.close("all")


def array(name: str = "four-wheel", rule: str = "nearest") -> ns.Array:
    loaded = ns.load(name)
    assert isinstance(loaded, ns.Array)
    return loaded.with_(rule=rule)


def system(name: str) -> ns.System:
    loaded = ns.load(name)
    assert isinstance(loaded, ns.System)
    return loaded


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    capsys.readouterr()
    assert run(app, arguments) == 0
    return capsys.readouterr().out


PATH = "simulate four-wheel --from 0.1,0.2,0.3 --until 0.5 --kinematics leading"
HEAVY = "simulate four-wheel --from 0.2,0.3,0 --until 0.001 --method dynamics --mass 1"
# Of every kind of result: the command, and what a script calls; of both the record is the same.
STRESS = "stress relay-oscillator-damped"


def with_few_cases(patch: pytest.MonkeyPatch) -> None:
    """Of every kind of extreme case one, since each is a check of its own."""
    for module in (cases, measurements):
        patch.setattr(module, "POWERS", POWERS[:1])
        patch.setattr(module, "RATIOS", dict([*RATIOS.items()][:1]))


SAME: dict[str, Callable[[], Any]] = {
    "partition four-wheel": lambda: array().cells(),
    "partition four-wheel --rule box": lambda: array(rule="box").cells(),
    "partition four-wheel --compare": lambda: array().compare(),
    "check four-wheel --rule box": lambda: array().check(rule="box"),
    "check four-wheel --rule all": lambda: array().check(rule="all"),
    "check eq-4": lambda: ns.load("eq-4").check(),
    "simulate saddle --grid 5 --heading 0.2 --until 1": lambda: array("saddle").map(5, heading=0.2, until=1),
    PATH: lambda: array().simulate((0.1, 0.2, 0.3), 0.5, kinematics="leading"),
    f"{PATH} --method smoothed --width 0.01": lambda: array().simulate(
        (0.1, 0.2, 0.3), 0.5, kinematics="leading", method="smoothed", width=0.01
    ),
    f"{HEAVY} --inertia 0.01": lambda: array().dynamics((0.2, 0.3, 0), until=0.001, mass=1, inertia=0.01),
    f"{HEAVY} --compare-masses": lambda: array().compare_masses((0.2, 0.3, 0), until=0.001, mass=1),
    "audit four-wheel --lyapunov x**2+y**2": lambda: array().audit("x**2+y**2"),
    "partition eq-4": lambda: system("eq-4").portrait(),
    STRESS: lambda: ns.load("relay-oscillator-damped").stress(),
    "vehicle jackal --spin 3": lambda: ns.Vehicle.load("jackal").motion(spin=3),
}


@pytest.mark.parametrize("command", SAME)
def test_a_result_is_the_record_of_the_command(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if command == STRESS:
        with_few_cases(monkeypatch)
    run(app, [*command.split(), "--json"])
    record, result = json.loads(capsys.readouterr().out), SAME[command]()
    own = json.loads(json.dumps(result.to_dict()))
    for one in (record, own, *record.get("checks", ()), *own.get("checks", ())):
        one.pop("seconds", None)
    assert {key: record[key] for key in own} == own  # of a path the command says further how it ends
    assert result.rows()
    assert "<table" in result._repr_html_()
    assert len(str(result).splitlines()) <= MOST_LINES


@few(1)
@pytest.mark.parametrize("show", ["cells", "array", "rates"])
def test_pictures_are_the_files_of_the_command(show: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    own = array().cells().save(tmp_path / "own.svg", show=show)
    other = tmp_path / "other.svg"
    printed(capsys, "partition", "four-wheel", "--show", show, "-o", str(other))
    assert own.read_bytes() == other.read_bytes()


@few(2)
@pytest.mark.parametrize("suffix", [".md", ".json", ".tex"])
def test_a_report_is_the_file_of_the_command(
    suffix: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    report = array().derive(only=["verdict", "cells"], without="cells")
    assert report.sections == ("Verdict",)
    printed(capsys, "derive", "four-wheel", "--only", "verdict", "-o", f"other{suffix}")
    other = Path(f"other{suffix}").read_text(encoding="utf-8")
    own = report.save(f"own{suffix}").read_text(encoding="utf-8")
    assert own == other
    if suffix != ".tex":
        assert own == report.text(suffix)


@pytest.mark.parametrize(
    ("key", "value"), [("length", "1e400"), ("radius", "1e400"), ("accuracy", "1e400"), ("accuracy", "1e-400")]
)
def test_a_number_beyond_floats_is_named_before_a_result_fails_on_it(key: str, value: str) -> None:
    """Answers are computed when they are read, where nobody would say which number they fail on."""
    array = ns.load("four-wheel").with_(**{key: value})
    with pytest.raises(ns.SceneError, match=rf"check\.{key}: required 0 or a size of"):
        array.check()


def test_a_time_beyond_floats_is_refused() -> None:
    with pytest.raises(ValueError, match="until: required a number within the range of floats, received an integer of"):
        array().map(grid=3, until=10**400)


def test_what_is_audited_or_measured_is_named() -> None:
    assert ns.System(["x"], ["-sign(x)"]).audit("Abs(x)").verdict == "valid"
    assert str(array().precision(["derivation"], runs=1, time_limit=0.01)).startswith("Precision: ")


@few(1)
@pytest.mark.parametrize("rule", ["nearest", "box", "ellipse"])
@pytest.mark.parametrize("name", keep(2, ["four-wheel", "n" * 200, "off-center", "ring-5"]))
def test_reports_print_in_few_lines(name: str, rule: str) -> None:
    asked = array("off-center", rule).with_(name=name) if len(name) > LONGEST / 20 else array(name, rule)
    results: list[Any] = [asked.check(), asked.compare(), asked.derive(only="verdict")]
    results.append(asked.simulate((0.01, 0.02, 0.1), until=0.5))
    if rule != "ellipse":
        results += [asked.cells(), asked.filippov_set((0, 0))]
    for result in results:
        lines = str(result).splitlines()
        assert len(lines) <= MOST_LINES, result
        assert max(map(len, lines)) <= WIDEST, result


@few(1)
@pytest.mark.parametrize("name", ["ring-5", "off-center", "flower", "relay-oscillator-damped"])
def test_whatever_a_result_holds_is_short_to_print(name: str) -> None:
    subject = ns.load(name)
    held: list[Any] = [subject.check()]
    if isinstance(subject, ns.Array):
        held += [subject.scene, subject.cells(), subject.compare(), subject.derive(only="verdict")]
        held += [subject.check(rule="box"), subject.check(rule="ellipse"), subject.simulate((0.01, 0.02, 0.1))]
    for part in inside(held):
        assert len(repr(part)) <= LONGEST, type(part)


def inside(value: Any, depth: int = 0) -> Iterator[Any]:
    """A value of ours and all that it holds."""
    if depth > DEEPEST:
        return
    if isinstance(value, (tuple, list)):
        for entry in value[:FIRST]:
            yield from inside(entry, depth + 1)
    elif dataclasses.is_dataclass(value) and type(value).__module__.startswith("nonsmooth"):
        yield value
        for part in dataclasses.fields(value):
            yield from inside(getattr(value, part.name), depth + 1)


def test_a_check_of_two_states_is_drawn_as_its_phase_portrait() -> None:
    """With the certified region where one is known; other numbers of states have no picture, and say so."""
    drawn = ns.System(("x", "y"), ("-sign(x) + y", "-y")).check().plot()
    assert "asymptotically stable" in drawn.get_title()
    assert {"border: sliding", "certified region"} <= set(drawn.get_legend_handles_labels()[1])
    for states, rhs in (("x", ["-x"]), ("xyz", ["-x", "-y", "-z"]), ("xy", [["-x", "-y"], ["-2*x", "-y"]])):
        with pytest.raises(TypeError, match="required a system in two states with one right-hand side"):
            ns.System(states, rhs).check().plot()


# ---- Arrays, systems and results as a script holds them ------------------------------------------

MU: dict[str, Any] = {"mu_roll": 1, "mu_side": "1/2"}


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


def test_an_array_of_one_number_is_a_number() -> None:
    assert ring(mu_side=np.array(0.25)) == ring(mu_side=0.25)
    assert ring().sweep(mu_side=0.25).rows() == ring().sweep(mu_side=[0.25]).rows()


@pytest.mark.parametrize("stranger", [3, "axes", plt, [None]])
def test_what_is_no_axes_is_refused(stranger: Any) -> None:
    for drawn in (array(), array().cells(), array().simulate((0.1, 0.2, 0), until=0.1)):
        with pytest.raises(ValueError, match=r"^ax: required axes of Matplotlib, received "):
            drawn.plot(stranger)


def test_paths_name_the_files_of_a_check(tmp_path: Path) -> None:
    array().check(certificate=tmp_path / "c.json", law=tmp_path / "law.c")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["c.json", "law.c"]


def test_a_result_answers() -> None:
    result = ring().check()
    assert (result.position.verdict, result.heading.verdict) == (Position.COMES_HOME, Heading.DRIFTS)
    assert (result.theorem4, result.position["within"]) == ("holds", Fraction(1, 2))
    assert result.evidence.check()
    assert result.destinations is None
    assert [row["question"] for row in result.rows()][:3] == ["position", "heading", "pose"]


def test_the_best_point() -> None:
    array = ns.load("off-center")
    assert isinstance(array, ns.Array)
    result = array.check(at="auto")
    assert (result.at, result.position.verdict) == ((0.5, 0.25), Position.COMES_HOME)


def test_rows_and_films_of_a_closed_loop_are_those_of_the_command(tmp_path: Path) -> None:
    array = ring()
    closed = array.simulate((0.2, 0.1, 0.3), until=1, feedback=True)
    table = closed.save(tmp_path / "path.csv").read_text(encoding="utf-8").splitlines()
    rows = closed.rows()
    assert ",".join(rows[0]) == table[0] == "t,x,y,theta,u_1,u_2,u_3,u_4"
    assert [float(cell or "nan") for cell in table[-1].split(",")] == pytest.approx(
        [float("nan") if value is None else value for value in rows[-1].values()], abs=0, nan_ok=True
    )
    driven = array.with_(rule="ellipse").simulate((0.05, 0.02, 0.1), until=0.02, feedback=True)
    with pytest.raises(ValueError, match="film"):  # which would show the speeds of the open loop
        driven.animate(tmp_path / "path.html")
    assert not (tmp_path / "path.html").exists()


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


def test_a_table_of_pandas_where_there_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    class Pandas:
        DataFrame: Any = staticmethod(list)

    monkeypatch.setattr("nonsmooth.reports.studies.result.import_module", lambda name: Pandas)
    assert ring().check().to_dataframe() == ring().check().rows()
    assert len(ns.load("eq-4").check().to_dataframe()) > 3
    assert len(ring().simulate((0.1, 0.2, 0)).to_dataframe()) > 1


# ---- What a check in Python is asked by keywords is what the command is asked by options ---------

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


def test_all_rules_are_compared() -> None:
    found = four_wheel().check(rule="all")
    assert isinstance(found, RulesResult)
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


# ---- The Filippov set at a point as a script holds it, and what of it a notebook shows -----------


def test_the_velocities_that_meet_at_a_point() -> None:
    array = ring()
    edge = array.filippov_set((0, "1/4"))
    assert edge.twists == filippov_twists(array.partition, edge.point)
    assert [state.name for _, state in edge.members] == ["R1 S1 R2", "R2 S2 R1"]
    assert edge.upper_derivative == upper_derivative_at(array.partition, edge.point) == edge.rates[0]
    assert [str(entry) for entry in edge.velocities[0]] == ["-sqrt(2)/8", "-sqrt(2)"]
    assert not edge.holds_zero


def test_weights_mix_the_velocities_into_zero() -> None:
    centre = ring().filippov_set((0, 0))
    assert centre.holds_zero
    assert centre.weights is not None
    assert sum(centre.weights) == 1
    for k in range(2):
        mixed = [weight * velocity[k] for weight, velocity in zip(centre.weights, centre.velocities, strict=True)]
        assert sum(mixed) == 0


def test_rates_are_about_the_checked_point() -> None:
    """``V = |c - c*|^2``: the same numbers as of the array moved to the origin."""
    array = ns.load("off-center")
    assert isinstance(array, ns.Array)
    moved = array.with_(at=("1/2", "1/4"))
    found = moved.filippov_set(("1/4", "1/8"))
    recentred = moved.check().evidence.partition
    assert recentred is not None
    x, y = (recentred.scene.field.one * Fraction(value) for value in ("-1/4", "-1/8"))
    assert found.upper_derivative == upper_derivative_at(recentred, (x, y))


@pytest.mark.parametrize("quarter", [0.25, "1/4", "0.25", Fraction(1, 4), Decimal("0.25"), sympy.Rational(1, 4)])
def test_a_coordinate_means_what_it_says(quarter: object) -> None:
    assert ring().filippov_set((0, quarter)).point[1] == Fraction(1, 4)


@pytest.mark.parametrize("rule", ["nearest", "box"])
@pytest.mark.parametrize("point", [(0, 0), (0, "1/4"), ("1/8", "1/4")])
def test_it_shows_itself(rule: str, point: tuple[object, object]) -> None:
    found = ring(rule=rule, name="<i>").filippov_set(point)
    lines = repr(found).splitlines()
    assert len(lines) == 1 + len(found.members)
    html = found._repr_html_()
    assert html.count("<tr>") == 1 + len(found.members)
    assert "<i>" not in html
    _, axes = plt.subplots()
    assert found.plot(axes) is axes
    labels = " ".join(text.get_text() for text in axes.texts)
    assert all(str(cell) in labels for cell, _ in found.members)


def test_the_scale_of_the_rates_stands_beside_a_figure_of_its_own() -> None:
    assert len(ring().plot(show="rates").figure.axes) == 2
    figure, axes = plt.subplots()
    ring().plot(axes, show="rates")
    assert figure.axes == [axes]


@pytest.mark.usefixtures("without_other_rules")
def test_destinations_are_a_table_in_a_notebook() -> None:
    array = ns.load("off-center")
    assert isinstance(array, ns.Array)
    destinations = array.check().destinations
    assert destinations is not None
    assert "rests at a point" in destinations._repr_html_()
    assert "(0.5, 0.25)" in destinations._repr_html_()


def test_constraints_are_matrices_in_a_notebook() -> None:
    array = ring()
    wheel, state = array.scene.wheels[0], array.partition.states[0]
    own = sympy.Matrix([[entry.to_sympy() for entry in row] for row in constraint_matrix(wheel)])
    assert wheel_constraints(wheel) == own
    assert sympy.simplify(stacked_constraints(state) * annihilator(state)) == sympy.zeros(3, 1)
    assert state.twist.omega._repr_latex_() == f"${state.twist.omega.latex()}$"


def test_it_is_a_public_name() -> None:
    assert ns.FilippovSet is FilippovSet
