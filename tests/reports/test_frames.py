"""Frames of a path against the definitions: slips from the twist, twists from the cells, contact sets by the rules."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.motion.frames import Frames, WheelContact, build_frames
from nonsmooth.reports.laws.feedback_loop import FeedbackLoop
from nonsmooth.reports.output.study_options import PathMethod
from nonsmooth.reports.simulations.paths import PathResult, follow_cells
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from tests.thorough import thorough

PATHS: dict[str, tuple[str, tuple[float, float, float], dict[str, Any]]] = {
    "open": ("four-wheel", (0.2, 0.4, 0.1), {}),
    "sliding": ("ring-5", (0.11, 0.2, 0.0), {}),
    "box": ("four-wheel", (0.2, 0.45, 0.0), {"rule": "box", "mu_side": "1/10"}),
    "ellipse": ("ring-6", (0.1, 0.2, 0.0), {"rule": "ellipse"}),
    "closed": ("ring-5", (0.1, 0.12, 0.2), {"feedback": True, "gain": 2.0}),
    "cascade": ("ring-6", (0.1, 0.05, 0.1), {"feedback": "cascade"}),
}


def followed(name: str) -> PathResult:
    scene, start, options = PATHS[name]
    array = ns.load(scene)
    assert isinstance(array, ns.Array)
    return array.simulate(start, 1.0, **options)


def frames_of(path: PathResult, count: int = 37) -> Frames:
    assert path.scene
    inputs = path.loop.inputs(path.partition) if isinstance(path.loop, FeedbackLoop) and path.partition else None
    times = np.linspace(0, path.t[-1], count)
    return build_frames(path.scene, path.trajectory, times, partition=path.partition, inputs=inputs)


@pytest.mark.parametrize("name", PATHS)
def test_slips_are_those_of_the_twist(name: str) -> None:
    path = followed(name)
    frames = frames_of(path)
    assert path.scene
    for k in range(len(frames)):
        v_x, v_y, omega = frames.twists[k]
        for i, wheel in enumerate(path.scene.wheels):
            (x, y), (a, b) = ([float(e) for e in pair] for pair in (wheel.position, wheel.unit_direction))
            moving = (v_x - omega * y, v_y + omega * x)  # v + omega J p
            along = moving[0] * a + moving[1] * b - frames.speeds[k, i]
            across = -moving[0] * b + moving[1] * a
            assert np.allclose(frames.slips[k, i], (along, across), rtol=0, atol=1e-12, equal_nan=True)


@pytest.mark.parametrize("name", ["open", "sliding", "box"])
def test_twists_are_in_the_hull_of_the_cells_that_hold_the_point(name: str) -> None:
    path = followed(name)
    frames = frames_of(path)
    assert path.partition
    seen = set()
    for pose, twist in zip(frames.poses, frames.twists, strict=True):
        slack = 1e-9
        held = [
            np.array([float(entry) for entry in cell.twists[0]])
            for cell in path.partition.cells
            if all(
                float(side.normal[0]) * pose[0] + float(side.normal[1]) * pose[1] <= float(side.offset) + slack
                for side in cell.polygon.sides
            )
        ]
        seen.add(min(len(held), 3))
        if len(held) == 1:
            assert np.abs(twist - held[0]).max() < 1e-7
        if len(held) == 2:
            ahead = held[1] - held[0]
            share = float((twist - held[0]) @ ahead) / float(ahead @ ahead)
            assert -1e-6 <= share <= 1 + 1e-6
            assert np.abs(held[0] + share * ahead - twist).max() < 1e-6
    assert seen >= {1} if name != "sliding" else seen >= {1, 2}


def test_a_law_gives_the_acting_wheels_what_their_rows_ask_for() -> None:
    """In the closed loop both rows of the nearest wheel hold, and the roll row of the second."""
    frames = frames_of(followed("closed"), 101)
    acting = np.isfinite(frames.speeds)
    assert set(acting.sum(axis=1)) == {2}
    assert (frames.contacts[acting] != WheelContact.FREE).all()
    assert (frames.contacts[~acting] == WheelContact.FREE).all()
    assert np.abs(frames.slips[..., 0][acting]).max() < 1e-6
    across = np.where(acting, np.abs(frames.slips[..., 1]), np.inf)
    assert across.min(axis=1).max() < 1e-6
    slips = np.abs(frames.slips).max(axis=2)
    sticking, slipping = (slips[frames.contacts == kind] for kind in (WheelContact.STICKS, WheelContact.SLIPS))
    assert sticking.size
    assert sticking.max() < 1e-5 < slipping.max()


@thorough  # the small one: test_twists_are_in_the_hull_of_the_cells_that_hold_the_point
def test_rule_ellipse_moves_with_its_minimizer_and_is_carried_by_loaded_wheels() -> None:
    path = followed("ellipse")
    frames = frames_of(path, 9)
    assert path.scene
    rule, model = smooth_rule_of(path.scene), contact_model(path.scene)
    expected = minima_under(rule, path.scene, frames.poses[:, :2]).twists
    assert np.abs(frames.twists - expected).max() < 1e-5
    assert np.array_equal(frames.contacts != WheelContact.FREE, loads_at(model, frames.poses[:, :2]) > 1e-9)


def test_leading_order_kinematics_and_samples_without_pieces() -> None:
    array = ns.load("off-center")
    assert isinstance(array, ns.Array)
    partition = array.partition
    radius = float(array.scene.check.radius)
    x, y = (float(entry) + 0.3 * radius for entry in array.scene.check.equilibrium)
    for method in (PathMethod.EVENTS, PathMethod.HYSTERESIS):
        options = SimulateOptions(start=(x, y, 0.0), until=0.05, kinematics=Kinematics.LEADING, method=method)
        path = follow_cells(partition, options)
        frames = build_frames(array.scene, path, [0.01], partition=partition, pivot=(0.0, 0.0))
        point = [array.scene.field.rational(Fraction(float(entry))) for entry in frames.poses[0, :2]]
        cell = partition.cells_at((point[0], point[1]))[0]
        assert np.abs(frames.twists[0] - [float(x) for x in cell.twists[0]]).max() < 1e-6


def test_a_path_of_no_time_has_one_still_frame() -> None:
    path = followed("open")
    assert path.scene
    end = build_frames(path.scene, path.trajectory, [float(path.t[-1])], partition=path.partition)
    assert np.abs(end.twists).max() < 1e-9
