"""Maps through the command line and in Python: ends of arrays and plain systems, fields without cells."""

from __future__ import annotations

import csv
import io
import json
import math
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.fields.stated_field import potential_values
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.sampling import sample_field
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.systems.domain import DecayKind
from nonsmooth.reports.checks.phase_portrait import PhasePortrait
from nonsmooth.reports.cli import app
from nonsmooth.reports.figures.style import lay_out
from nonsmooth.reports.output import progress as progress_module
from nonsmooth.reports.output.console import run
from nonsmooth.reports.output.progress import progress
from nonsmooth.reports.simulations import system_maps
from nonsmooth.reports.simulations.maps import SettleMapResult
from nonsmooth.reports.simulations.system_maps import PathLocation, SystemMap, mapped
from nonsmooth.symbolic.files.scene_file import load_system
from tests.oracles.ellipse_dissipation import EllipseDissipation
from tests.proofs.forged import with_deciding, with_reach
from tests.reports.conftest import Invoke
from tests.thorough import few, keep

# ---- Maps of ends through the command line: the four-wheel formula, what is seen at a time, and every format.

FORMULA = 1e-12
KEYS = [
    "schema", "scene", "rule", "kinematics", "grid", "theta_0", "until", "summary", "starts", "theta", "arrival",
    "points", "basin", "ends", "unique", "accuracy", "home", "parts",
]  # fmt: skip


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert run(app, ["simulate", *arguments, "--json"]) == 0
    captured = capsys.readouterr()
    assert not captured.err
    return json.loads(captured.out)


def test_the_formula_of_the_four_wheel_array(capsys: pytest.CaptureFixture[str]) -> None:
    """theta_inf = theta_0 + g ||y0| - |x0||/2 and T = (|x0| + |y0|)/sqrt2."""
    record = printed(
        capsys, "four-wheel", "--grid", "12", "--heading", "0.25", "--kinematics", "leading", "--radius", "1/4"
    )
    assert list(record) == KEYS
    assert (record["schema"], record["grid"], record["theta_0"], record["until"]) == ("nonsmooth-map/1", 12, 0.25, None)
    x, y = np.array(record["starts"]).T
    assert (np.abs(x).max(), np.abs(y).max(), len(x)) == (0.25, 0.25, 144)
    g = np.sign(x * y * (y**2 - x**2))
    assert np.abs(np.array(record["theta"]) - 0.25 - g * np.abs(np.abs(y) - np.abs(x)) / 2).max() <= FORMULA
    assert np.abs(np.array(record["arrival"]) - (np.abs(x) + np.abs(y)) / math.sqrt(2)).max() <= FORMULA
    assert record["ends"] == [{"reason": "the body rests", "place": "corner (0, 0)"}]
    summary = record["summary"]
    assert (summary["shares"], summary["arrived"], summary["unique"]) == ([1.0], 1.0, 1.0)
    assert summary["latest_arrival"] == pytest.approx(0.5 / math.sqrt(2), abs=FORMULA)
    assert summary["theta"] == [min(record["theta"]), max(record["theta"])]


def test_starts_that_are_late_are_on_their_way(capsys: pytest.CaptureFixture[str]) -> None:
    record = printed(capsys, "four-wheel", "--grid", "10", "--kinematics", "leading", "--until", "0.4")
    x, y = np.array(record["starts"]).T
    late = (np.abs(x) + np.abs(y)) / math.sqrt(2) > 0.4
    assert 0 < late.sum() < 100
    reasons = [record["ends"][k]["reason"] for k in record["basin"]]
    assert [reason == "the time is over" for reason in reasons] == late.tolist()
    for key in ("theta", "arrival"):
        assert [value is None for value in record[key]] == late.tolist()
    assert [point == [None, None] for point in record["points"]] == late.tolist()
    assert record["summary"]["arrived"] == pytest.approx(1 - late.mean())


def test_the_parts_of_a_map_add_up_to_all_starts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Those that are late are named beside those that rest: in the record, the line, the title and the legend."""
    arguments = ["four-wheel", "--grid", "10", "--kinematics", "leading", "--until", "0.4"]
    record = printed(capsys, *arguments)
    late = sum(value is None for value in record["arrival"])
    parts = {part["end"]: part["starts"] for part in record["parts"]}
    assert parts == {"the body rests": 100 - late, "the time is over": late}
    assert run(app, ["simulate", *arguments, "-o", str(tmp_path / "map.json")]) == 0
    line = capsys.readouterr().out
    assert "100 starts: " in line
    assert f"the time is over ({late})" in line
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    shown = array.map(10, until=0.4, kinematics="leading")
    assert isinstance(shown, SettleMapResult)
    figure = shown.figure()
    assert f"the time is over ({late})" in figure.get_suptitle()
    shares = [text.get_text() for text in figure.legends[0].get_texts() if " %: " in text.get_text()]
    assert sum(float(label.split(" %")[0]) for label in shares) == pytest.approx(100, abs=0.1)


def test_a_table_holds_what_json_holds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, record_file = tmp_path / "map.csv", tmp_path / "map.json"
    arguments = ["simulate", "conveyor-3", "--grid", "6"]
    assert run(app, [*arguments, "-o", str(table)]) == 0
    assert run(app, [*arguments, "-o", str(record_file)]) == 0
    capsys.readouterr()
    record = printed(capsys, "conveyor-3", "--grid", "6")
    assert json.loads(record_file.read_text()) == record
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert [[float(row["x"]), float(row["y"])] for row in rows] == record["starts"]
    assert [float(row["theta"]) if row["theta"] else None for row in rows] == record["theta"]
    assert [record["ends"][k] for k in record["basin"]] == [{k: row[k] for k in ("reason", "place")} for row in rows]
    assert [row["unique"] == "yes" for row in rows] == record["unique"]


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_progress_is_shown_on_a_terminal_and_only_when_it_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    shown = {}
    for patience in (0.0, 60.0):
        stream = Terminal()
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setattr(progress_module, "PATIENCE", patience)
        with progress("counting starts") as report:
            report(1, 2)
            report(2, 2)
        shown[patience] = "counting starts" in stream.getvalue()
    assert shown == {0.0: True, 60.0: False}


@pytest.mark.parametrize("seed", range(6))
def test_cells_too_thin_for_floats_are_refused_or_mapped(seed: int) -> None:
    """Rings that are regular but for rounding: two borders that ought to be one are 1e-15 apart."""
    rng = np.random.default_rng(seed)
    count, off = (4, 8)[seed % 2], math.radians((0, 3, 7)[seed % 3])
    turns = 2 * math.pi * np.arange(count) / count
    places = np.stack([np.cos(turns), np.sin(turns)], axis=1) + rng.uniform(-1, 1, (count, 2)) * 10.0 ** -(
        14 + seed % 2
    )
    wheels = [ns.Wheel((x, y), t + math.pi + off, 1, 1, 0.5) for (x, y), t in zip(places.tolist(), turns, strict=True)]
    with suppress(RefusalError):
        found = ns.Array(wheels).map(5)
        assert isinstance(found, SettleMapResult)
        assert sum(found.found.shares) == pytest.approx(1)


def test_a_path_that_floats_lose_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def lost(*arguments: Any) -> Any:
        raise TrajectoryError("no edge of cell 1 at (0, 0): please report this")

    monkeypatch.setattr("nonsmooth.reports.simulations.maps.settled", lost)
    assert run(app, ["simulate", "four-wheel", "--grid", "2"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "required cells that floats tell apart, to follow paths, received thinner ones (no edge of cell 1" in said


# ---- Maps of a plain system: where a grid of starts has come to, beside an integrator of its own and the certified
# V.

# An unstable plant under a saturated gain: a strip of starts comes home, the others run away.
SATURATED = ns.System(["x", "v"], ["v", "x - sat(3*x + v, -1/2, 1/2)"], radius=1, at=[0, 0])


@pytest.fixture(scope="module")
def found() -> SystemMap:
    shown = SATURATED.map(7, until=6.0)
    assert isinstance(shown, SystemMap)
    return shown


def test_ends_are_those_of_an_integrator(found: SystemMap) -> None:
    def rate(t: float, state: list[float]) -> list[float]:
        x, v = state
        return [v, x - float(np.clip(3 * x + v, -0.5, 0.5))]

    for start, end in zip(found.starts[::3], found.ends[::3], strict=True):
        expected = solve_ivp(rate, (0, 6.0), start, rtol=1e-10, atol=1e-12, max_step=0.05).y[:, -1]
        assert end == pytest.approx(expected, rel=1e-4, abs=1e-6)
    assert {PathLocation.NEARER, PathLocation.OUTSIDE, PathLocation.ARRIVED} <= set(found.whereabouts)
    assert found.ratios[24] == 0  # of the point itself, in the middle of 7 x 7


def test_rounding_does_not_decide_where_a_closed_orbit_ends() -> None:
    """At t = 10 all paths of the relay oscillator from this grid are as far from the point as at first."""
    found = ns.load("relay-oscillator").map(4, until=10)
    assert isinstance(found, SystemMap)
    assert found.ratios == pytest.approx(np.ones(16), abs=1e-11)
    assert set(found.whereabouts) == {PathLocation.FARTHER}


def test_the_parts_add_up_to_all_starts(found: SystemMap) -> None:
    counted = {str(kind): found.whereabouts.count(kind) for kind in found.whereabouts}
    parts = {part["end"]: part["starts"] for part in found.facts()["parts"]}
    assert parts == counted
    assert sum(parts.values()) == 49
    for text in (found.summary(), found.figure().get_suptitle()):
        assert all(f"{kind} ({count})" in text.replace("\n", " ") for kind, count in counted.items())


def test_paths_from_the_certified_region_lower_v(found: SystemMap) -> None:
    function, region = found.portrait.stability.function, found.portrait.stability.reach.region
    assert region is not None
    before, after = (potential_values(function.result.cells, places) for places in (found.starts, found.ends))
    inside = before < float(region.level)
    assert inside.sum() >= 1
    assert (after[inside] <= before[inside]).all()


def test_a_path_that_contradicts_the_proof_makes_the_verdict_undecided(found: SystemMap) -> None:
    assert found.contradictions == ()
    assert (found.exit_status, str(found.verdict)) == (0, "asymptotically stable")
    ends = found.ends.copy()
    near = int(np.argmin(np.abs(found.starts).max(axis=1)))
    ends[near] = (0.2, 0.1)  # away from the point, though V is certified to fall
    planted = replace(found, ends=ends)
    (one,) = planted.contradictions
    assert one.between == "region and map"
    assert "every start with V <" in one.sides[0]
    assert "is at (0.2, 0.1) at t = 6" in one.sides[1]
    assert (planted.exit_status, planted.facts()["verdict"]) == (3, "undecided")
    assert planted.facts()["contradictions"][0]["sides"] == list(one.sides)


@pytest.mark.parametrize("damping", ["x**2", "sqrt(x**2 + y**2)"])
def test_paths_that_come_home_like_a_power_of_time_contradict_nothing(damping: str) -> None:
    """V falls like ``V0/(1 + kappa V0 t)`` at least: much slower than any exponential."""
    system = ns.System(("x", "y"), [f"y - x*{damping}", f"-x - y*{damping}"], radius="1/2")
    shown = system.map(4, until=30.0)
    assert isinstance(shown, SystemMap)
    reach = shown.portrait.stability.reach
    assert reach.rate is not None
    assert reach.rate.decay is DecayKind.ALGEBRAIC
    assert shown.contradictions == ()
    planted = replace(shown, ends=0.9 * shown.starts)
    assert [one.between for one in planted.contradictions] == ["region and map"]


@pytest.mark.parametrize("size", ["sqrt(x**2 + y**2)", "(Abs(x) + Abs(y))"])
@pytest.mark.parametrize(("sign", "kind"), [("-", PathLocation.ARRIVED), ("", PathLocation.OUTSIDE)])
def test_paths_come_to_a_point_where_a_denominator_is_zero(size: str, sign: str, kind: PathLocation) -> None:
    """They arrive within half a unit of time; the start at the point itself is followed only if the point is stable."""
    shown = ns.System(("x", "y"), [f"{sign}x/{size}", f"{sign}y/{size}"]).map(3, until=1.0)
    assert isinstance(shown, SystemMap)
    beside = [own for start, own in zip(shown.starts, shown.whereabouts, strict=True) if start.any()]
    assert set(beside) == {kind}
    assert shown.whereabouts[4] is (kind if sign else PathLocation.LOST)


def test_a_system_that_arrives_is_not_unstable(monkeypatch: pytest.MonkeyPatch) -> None:
    system = ns.System(["x", "y"], ["-sign(x)", "-sign(y)"], radius=1, at=[0, 0])
    shown = system.map(4, until=3.0)
    assert isinstance(shown, SystemMap)
    assert shown.contradictions == ()
    wrong = with_reach(with_deciding(shown.portrait.stability, verdict=Translation.UNSTABLE), region=None)
    monkeypatch.setitem(vars(shown.portrait), "stability", wrong)
    assert [one.between for one in replace(shown).contradictions] == ["stability and map"]


@pytest.mark.parametrize("name", keep(2, ["eq-4", "escaping-slide", "eq-3", "flower", "relay-oscillator-damped"]))
def test_maps_of_built_in_systems_contradict_nothing(name: str) -> None:
    portrait = PhasePortrait(load_system(name))
    for until in (0.1, 2.0):
        assert mapped(portrait, 3, until).contradictions == ()


def test_paths_of_a_map_that_end_early_are_not_said_to_be_anywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """Circles, followed for too long: beyond the work that all starts share nothing is said of ends."""
    system = ns.System(("x", "y"), ["y", "-x"], radius=1)
    monkeypatch.setattr(system_maps, "MAX_WORK", 20_000)
    found = mapped(PhasePortrait(system.system), 3, 2_000.0)
    assert 0 < found.whereabouts.count(PathLocation.LOST) < 9
    for start, end, kind in zip(found.starts, found.ends, found.whereabouts, strict=True):
        if kind is PathLocation.LOST:
            assert np.isnan(end).all()
        else:
            turn = complex(*start) * np.exp(-2_000j)
            assert end == pytest.approx([turn.real, turn.imag], abs=1e-8)


# ---- The field of a rule without cells: rows against the minimizer written from its definition, pictures, refusals.

SAME = 1e-4  # of velocities: a simplex finds a minimum to the root of its rounding


def array(name: str, rule: str = "ellipse") -> ns.Array:
    loaded = ns.load(name)
    assert isinstance(loaded, ns.Array)
    return loaded.with_(rule=rule)


@pytest.mark.parametrize("name", ["spiral-30", "off-center", "ring-5"])
def test_rows_are_minimizers_of_the_dissipation(name: str) -> None:
    own = array(name)
    field = sample_field(own.scene, 5)
    for k in (1, 13):
        place = field.points[k]
        loads = loads_at(contact_model(own.scene), place[None])[0]
        vx, vy, omega = EllipseDissipation(own.scene, loads).minimizer()
        expected = np.array([vx - omega * place[1], vy + omega * place[0], omega])
        assert np.abs(np.append(field.velocities[k], field.rates[k]) - expected).max() <= SAME


def test_the_checked_point_attracts_and_v_falls() -> None:
    field = sample_field(array("spiral-30").scene, 21)
    away = np.hypot(*field.points.T) > 0
    assert (field.upper_derivative[away] < 0).all()
    assert field.rests.sum() == 1


def test_a_carried_body_does_not_approach() -> None:
    """It turns about the point: V* is zero, and not what rounding leaves of it."""
    assert not sample_field(array("conveyor-3").scene, 11).upper_derivative.any()


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_pictures_records_and_views(rule: str, invoke: Invoke) -> None:
    out = " ".join(invoke("partition", "four-wheel", "--rule", rule).out.split())
    assert f"rule {rule} has no cells; its field at 41 x 41 points, sampled" in out
    drawn = f"f.svg: rule {rule} has no cells, so --show cells and rates draw one picture: streamlines over V*, 1681 "
    assert invoke("partition", "four-wheel", "--rule", rule, "--show", "rates", "-o", "f.svg").out.startswith(drawn)
    again = array("four-wheel", rule).field()
    assert again.save("again.svg").read_bytes() == Path("f.svg").read_bytes()
    assert invoke("partition", "four-wheel", "--rule", rule, "--json").record == again.to_dict()
    assert len(repr(again).splitlines()) <= 12


def test_a_sampled_field_has_units_and_names_what_is_white() -> None:
    table = ns.Array.grid(2, 2, pitch=0.2, mu_roll=1, mu_side="1/20", rule="roller", units={"length": "m"})
    field = table.field()
    said = dict(field.said)
    assert said["fastest"].endswith(" m/s")
    assert said["largest V*"].endswith(" m^2/s")
    (legend,) = field.figure().legends
    assert "white: not determined" in [text.get_text() for text in legend.get_texts()]


def test_a_map_of_bodies_keeps_its_labels_off_its_legend() -> None:
    figure = ns.load("carton-on-6x6").map(2, until=0.1).figure()
    lay_out(figure, ".png")
    below = figure.legends[0].get_window_extent().y1
    assert all(axes.xaxis.label.get_window_extent().y0 > below for axes in figure.axes)


def test_rounding_of_a_state_that_stays_is_no_curve() -> None:
    figure = ns.System(["x", "y"], ["-x", "-y - sign(y)"]).simulate((1, 1e-14), until=1).figure()
    low, high = figure.axes[1].get_ylim()
    assert high - low > 0.1
