"""The closed loop of a body with an outline ends where other wheels carry it than those of its certified law."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.reports.figures.path import MARKERS
from nonsmooth.reports.simulations.paths import follow_array
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing
from tests.outlined import polygon_depths
from tests.reports.conftest import Invoke
from tests.thorough import few

LEAVES = (-0.189, 0.088, -0.242)  # from here wheel 14 comes under the carton
STAYS = (0.05, 0.03, 0.05)
LOOKS = 3000


def closed_loop(start: tuple[float, float, float], rule: str = "nearest") -> Trajectory:
    scene = load_scene("carton-on-6x6", rule=rule)
    return follow_array(scene, SimulateOptions(start=start, feedback=True)).trajectory


def first_change(path: Trajectory) -> float:
    """When other wheels than at first are under the carton, by looking closely; infinite where none ever are."""
    scene = load_scene("carton-on-6x6")
    assert scene.body is not None
    corners = np.array([[float(x) for x in corner] for corner in scene.body.vertices])
    places = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
    first = polygon_depths(corners, places, np.array(path.at(0.0))) > 0
    for time in np.linspace(0.0, 2.0, LOOKS):
        if ((polygon_depths(corners, places, np.array(path.at(time))) > 0) != first).any():
            return float(time)
    return np.inf


def as_if_without_outline(start: tuple[float, float, float], rule: str = "nearest") -> Trajectory:
    """The closed loop on the same wheels, which carry for ever."""
    scene = replace(standing(load_scene("carton-on-6x6", rule=rule)), body=None, idle=())
    return follow_array(scene, SimulateOptions(start=start, feedback=True)).trajectory


@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_a_loop_ends_where_a_wheel_enters(rule: str) -> None:
    path, whole = closed_loop(LEAVES, rule), as_if_without_outline(LEAVES, rule)
    assert path.end.reason is EndReason.WHEELS
    assert path.events[-1].kind is EventKind.ENTER
    assert path.events[-1].surface == "wheel 14 under the body"
    change = first_change(whole)
    assert change - 2.0 / (LOOKS - 1) <= path.end.t <= change
    for time in np.linspace(0.0, path.end.t, 7):
        assert path.at(time) == pytest.approx(whole.at(time), abs=1e-12)
    assert path.pieces[-1].end == path.times[-1] == path.end.t


@few(1)
@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_a_loop_that_keeps_its_wheels_goes_on(rule: str) -> None:
    path, whole = closed_loop(STAYS, rule), as_if_without_outline(STAYS, rule)
    assert first_change(whole) == np.inf
    assert path.end == whole.end


def test_the_command_says_for_which_wheels_an_imposed_twist_is_certified(invoke: Invoke) -> None:
    start = ",".join(map(str, LEAVES))
    done = invoke("simulate", "carton-on-6x6", "--rule", "box", "--from", start, "--feedback")
    assert done.status == 0
    assert "certified while wheels 15, 16, 21, 22 carry the body" in " ".join(done.out.split())
    assert "wheel 14 under the body" in " ".join(done.out.split())


def test_the_command_says_for_which_wheels(invoke: Invoke, tmp_path: Path) -> None:
    start = ",".join(map(str, LEAVES))
    options = ("simulate", "carton-on-6x6", "--rule", "nearest", "--from", start, "--feedback")
    done = invoke(*options)
    assert done.status == 0
    assert "certified while wheels 15, 16, 21, 22 carry the body" in " ".join(done.out.split())
    found = json.loads(invoke(*options, "--json", "-o", str(tmp_path / "loop.csv")).out)
    assert found["end"]["reason"] == "a wheel enters or leaves: the law is certified for the wheels before"
    assert len(found["speeds"][0]) == 4
    for name in ("loop.html", "loop.svg"):
        assert invoke(*options, "-o", str(tmp_path / name)).status == 0
    assert (tmp_path / "loop.csv").read_text().startswith("t,x,y,theta,u_15,u_16,u_21,u_22")
    drawn = (tmp_path / "loop.svg").read_text()
    assert "u_15" in drawn
    assert "u_1<" not in drawn


def test_every_event_has_a_mark() -> None:
    assert set(MARKERS) == set(EventKind)
