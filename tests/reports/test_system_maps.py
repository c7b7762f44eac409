"""Maps of a plain system: where a grid of starts has come to, beside an integrator of its own and the certified V."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.fields.cell_values import potential_values
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.reports.checks.phase_portrait import PhasePortrait
from nonsmooth.reports.simulations import system_maps
from nonsmooth.reports.simulations.system_maps import SystemMap, Whereabouts, mapped, ratios_figure
from nonsmooth.symbolic.files.system_file import load_system
from tests.proofs.forged import with_deciding, with_reach
from tests.reports.conftest import Invoke
from tests.thorough import keep

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
    assert {Whereabouts.NEARER, Whereabouts.OUTSIDE, Whereabouts.ARRIVED} <= set(found.whereabouts)
    assert found.ratios[24] == 0  # of the point itself, in the middle of 7 x 7


def test_the_parts_add_up_to_all_starts(found: SystemMap) -> None:
    counted = {str(kind): found.whereabouts.count(kind) for kind in found.whereabouts}
    parts = {part["end"]: part["starts"] for part in found.facts()["parts"]}
    assert parts == counted
    assert sum(parts.values()) == 49
    for text in (found.summary(), ratios_figure(found).get_suptitle()):
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
    for until in (0.1, 2.0):
        assert mapped(PhasePortrait(load_system(name)), 3, until).contradictions == ()


def test_the_command_writes_every_form(invoke: Invoke, tmp_path: Path) -> None:
    grid = ("simulate", "eq-4", "--grid", "2", "--until", "1")
    record = invoke(*grid, "--json", "-o", str(tmp_path / "map.csv")).record
    assert record["schema"] == "nonsmooth-system-map/1"
    assert sum(record["shares"].values()) == pytest.approx(1)
    assert "proved" in invoke(*grid).out
    assert "4 starts" in invoke(*grid, "-o", str(tmp_path / "map.svg")).out
    header, *rows = csv.reader((tmp_path / "map.csv").read_text(encoding="utf-8").splitlines())
    assert header == ["x", "y", "x_end", "y_end", "whereabouts"]
    assert len(rows) == 4


def test_paths_of_a_map_that_end_early_are_not_said_to_be_anywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """Circles, followed for too long: beyond the work that all starts share nothing is said of ends."""
    system = ns.System(("x", "y"), ["y", "-x"], radius=1)
    monkeypatch.setattr(system_maps, "MAX_WORK", 20_000)
    found = mapped(PhasePortrait(system.system), 3, 200.0)
    assert 0 < found.whereabouts.count(Whereabouts.LOST) < 9
    for start, end, kind in zip(found.starts, found.ends, found.whereabouts, strict=True):
        if kind is Whereabouts.LOST:
            assert np.isnan(end).all()
        else:
            turn = complex(*start) * np.exp(-200j)
            assert end == pytest.approx([turn.real, turn.imag], abs=1e-8)
