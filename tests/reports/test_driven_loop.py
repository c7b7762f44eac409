"""The closed loop of imposed twists: V falls as certified, and small steps with minimizers of D lead the same way."""

from __future__ import annotations

import runpy
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import Floats, contact_model
from nonsmooth.analysis.fields.driven_field import Motion
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.trajectories.held_law import follow_held
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs.clauses.feedback.by_friction import decide_driven_feedback
from nonsmooth.proofs.own_paths import ContradictionError
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.reports.laws.driven_loop import DrivenLoop
from nonsmooth.reports.laws.law_program import law_of
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

Speeds: TypeAlias = Callable[..., Mapping[int, float]]

INTEGRATION = 1e-9  # relative, of an event-driven path
STEP = 1e-3  # of the oracle, which slides along a tie by chattering across it
CHATTERED = 0.02  # of the start: how far such steps may be from the path


def loop_of(name: str, rule: str) -> DrivenLoop:
    scene = load_scene(name, rule=rule).recentred()
    return DrivenLoop(scene, decide_driven_feedback(scene))


def start_of(loop: DrivenLoop, direction: tuple[float, float, float], part: float) -> tuple[float, float, float]:
    """In the direction, with ``V = (part reach)^2``; the reach is a tenth of the square where it is not known."""
    reach = loop.reach or 0.1 * float(loop.scene.check.radius)
    x, y, theta = (part * reach / loop.value(direction) ** 0.5 * value for value in direction)
    return x, y, theta


@few(3)
@pytest.mark.parametrize("name", ["four-wheel", "rectangle", "ring-3", "ring-5", "off-center", "conveyor-3"])
def test_under_box_v_falls_at_the_certified_rate(name: str) -> None:
    loop = loop_of(name, "box")
    kappa = float(loop.feedback.kappa or 0)
    for direction in ((0.4, 0.8, 0.3), (-0.7, 0.3, -0.5)):
        path = loop.follow(start_of(loop, direction, 0.9), 8.0)
        values = np.array([loop.value(state) for state in path.states])
        times = np.array([float(t) for t in path.times])
        assert (values <= values[0] * np.exp(-2 * kappa * times) * (1 + INTEGRATION)).all()
        assert float(path.end.t) == 8.0


def test_a_length_that_is_not_one_changes_the_law_and_not_what_is_certified() -> None:
    scene = load_scene("ring-5", rule="box").recentred()
    other = replace(scene, check=replace(scene.check, length=scene.check.length / 3))
    loop = DrivenLoop(other, decide_driven_feedback(other))
    path = loop.follow(start_of(loop, (0.4, 0.8, 0.3), 0.9), 4.0)
    bound = loop.value(path.states[0]) * np.exp(-8 * float(loop.feedback.kappa or 0))
    assert loop.value(path.end.state) <= bound * (1 + INTEGRATION)


def stepped(scene: Scene, speeds: Speeds, start: Any, until: float, minimizer: Any) -> Floats:
    """Small steps: at every one the exported program's speeds, and the twist that minimizes D for them."""
    model, pose = contact_model(scene), np.array(start)
    for _ in range(round(until / STEP)):
        given = speeds(*pose.tolist())
        targets = np.zeros(2 * model.wheels)
        targets[0::2] = [given[wheel.index] for wheel in scene.wheels]
        vx, vy, omega = minimizer.minimize(replace(model, targets=targets), loads_at(model, pose[None, :2])).twists[0]
        pose = pose + STEP * np.array([vx - omega * pose[1], vy + omega * pose[0], omega])
    return pose


@few(1)
@pytest.mark.parametrize(("rule", "minimizer"), [("box", BoxHighs()), ("ellipse", EllipseMinimizer())])
@pytest.mark.parametrize(("name", "until"), keep(1, [("four-wheel", 0.2), ("four-wheel", 0.6), ("ring-5", 0.6)]))
def test_small_steps_with_a_minimizer_lead_the_same_way(
    name: str, until: float, rule: str, minimizer: Any, tmp_path: Path
) -> None:
    loop = loop_of(name, rule)
    start = start_of(loop, (0.4, 0.8, 0.3), 0.9)
    law = runpy.run_path(str(law_of(check_theorem4(loop.scene)).save(tmp_path / "law.py")))
    found = stepped(loop.scene, law["speeds"], start, until, minimizer)
    path = loop.follow(start, until)
    assert np.abs(found - np.array(path.end.state, dtype=float)).max() <= CHATTERED * np.abs(start).max()


def reversed_motion(motion: Motion) -> Motion:
    return lambda c: -motion(c)


def test_a_path_that_contradicts_the_certificate_is_refused() -> None:
    """The same twists, driven the wrong way."""
    loop = loop_of("ring-5", "box")
    start = start_of(loop, (0.4, 0.8, 0.3), 0.9)
    wrong = [replace(cone, motions=tuple(map(reversed_motion, cone.motions))) for cone in loop.cones]
    loop.__dict__["cones"] = tuple(wrong)
    with pytest.raises(ContradictionError, match="lets V rise"):
        loop.follow(start, 0.5)


def test_a_path_beyond_the_reach_is_refused() -> None:
    loop = loop_of("ring-5", "box")
    reach = loop.reach
    assert reach is not None
    with pytest.raises(TrajectoryError, match="leaves the square in which the speeds impose their twists"):
        loop.follow((1.01 * reach, 0.0, 0.0), 0.5)


# ---- in the report -------------------------------------------------------------------------------


@thorough  # the small one: derive differential-drive of the golden matrix
@pytest.mark.parametrize(("rule", "rows"), keep(1, [("box", 4), ("ellipse", 1)]))
def test_the_report_tabulates_and_draws_the_closed_loop(invoke: Invoke, rule: str, rows: int) -> None:
    out = invoke("derive", "ring-3", "--rule", rule, "--only", "feedback").out
    assert "## Feedback law" in out
    assert len([line for line in out.splitlines() if line.startswith("| (")]) == rows
    assert "**Figure.** The closed loop of clause 4" in out
    assert ("V < 0.183^2" in out) == (rule == "box")
    assert ("the motion minimizes D" in out) == (rule == "ellipse")
    written = invoke("derive", "ring-3", "--rule", rule, "--only", "feedback", "-o", "r.html")
    assert written.status == 0
    assert "<svg" in Path("r.html").read_text(encoding="utf-8")


def test_a_law_of_many_cones_is_sampled(invoke: Invoke) -> None:
    out = invoke("derive", "ring-8", "--rule", "box", "--only", "feedback").out
    assert "the law sampled and its speeds held in between" in out
    assert len([line for line in out.splitlines() if line.startswith("| (") and "not located" in line]) == 4
    assert "**Figure.** The closed loop of clause 4" in out


def test_sampling_leads_where_events_lead() -> None:
    """The same law, sampled ever more often, and followed event by event."""
    loop = loop_of("ring-5", "box")
    start, length = start_of(loop, (0.4, 0.8, 0.3), 0.9), loop.length
    exact = np.array(loop.follow(start, 1.5).end.state, dtype=float)
    own = (start[0] / length, start[1] / length, start[2])
    found = follow_held(loop.held, own, 1.5).in_lengths(length)
    assert np.abs(np.array(found.end.state) - exact).max() <= 0.01 * np.abs(start).max()


@pytest.mark.parametrize("direction", [(0.4, 0.8, 0.3), (-0.8, 0.4, -0.3)])
def test_a_sampled_path_falls_at_the_certified_rate(direction: tuple[float, float, float]) -> None:
    loop = loop_of("ring-8", "box")
    path = loop.follow(start_of(loop, direction, 0.9), 16.0)
    values = np.array([loop.value(pose) for pose in path.states])
    bound = values[0] * np.exp(-2 * float(loop.feedback.kappa or 0) * np.array(path.times, dtype=float))
    assert path.method == "sampled"
    assert (values <= bound * (1 + INTEGRATION)).all()
