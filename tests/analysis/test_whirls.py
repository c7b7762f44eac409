"""Turns around a corner that get ever faster without a limit: the mean that is drawn, against the turns themselves."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.cellwise_field import CellwiseField, feedback_field
from nonsmooth.analysis.fields.feedback_laws import gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import affine_surface
from nonsmooth.analysis.trajectories import guards
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import keep, thorough

STARTS = [((0.1, 0.1, 0.1), 8.0), ((0.1, 0.05, -0.1), 8.8), ((0.05, 0.2, 0.3), 5.9)]
DRAWN = 5e-4 * 0.5  # of the size of the square: the turns that are drawn as their corner


@pytest.fixture
def rectangle() -> CellwiseField:
    """The built-in array under the law that is certified for it."""
    return feedback_field(build_nearest_partition(load_scene("rectangle")), gradient_law(1.0), Kinematics.EXACT)


@thorough  # the small one: test_turns_end_neither_in_time_nor_at_rest
@pytest.mark.parametrize(("start", "until"), keep(1, STARTS))
def test_turns_ever_faster_are_followed_in_their_mean(
    rectangle: CellwiseField, monkeypatch: pytest.MonkeyPatch, start: tuple[float, float, float], until: float
) -> None:
    path = simulate(rectangle, start, until)
    assert path.end.reason is EndReason.TIME
    (event,) = [event for event in path.events if "mean" in event.note]
    monkeypatch.setattr(guards, "WHIRL_EXTENT", 0.0)
    turns = simulate(rectangle, start, until)
    assert len(turns.events) > 1.5 * len(path.events)
    times = np.linspace(float(event.t), until, 50)
    mean, literal = path.sample(times), turns.sample(times)
    assert np.abs(mean[:, :2] - literal[:, :2]).max() <= DRAWN
    assert np.abs(mean[:, 2] / literal[:, 2] - 1).max() <= 1e-3  # the mean over turns that last some 1e-2


@pytest.mark.parametrize(("start", "until"), keep(1, STARTS))
def test_turns_end_neither_in_time_nor_at_rest(
    rectangle: CellwiseField, start: tuple[float, float, float], until: float
) -> None:
    """On the way V falls; theta falls exponentially, however long that takes."""
    path = simulate(rectangle, start, 60.0)
    assert path.end.reason is EndReason.TIME
    assert path.unique
    assert (np.diff((path.array**2).sum(axis=1)) <= 1e-12).all()
    theta = path.sample(np.linspace(until, 60, 20))[:, 2]
    ratios = theta[1:] / theta[:-1]
    assert 0 < ratios.min() < ratios.max() < 1
    assert np.ptp(ratios) < 1e-3


@pytest.mark.parametrize(("gain", "lasts"), [(1.0, True), (0.99, True), (1.01, False)])
def test_a_mean_lasts_as_long_as_turns_do_not_grow(gain: float, lasts: bool) -> None:
    """Four quadrants, entered at the speed ``gain`` and left at one: by every one distance changes by that factor."""
    flows: dict[tuple[int, ...], tuple[float, float]] = {
        (1, 1): (-1.0, gain),
        (-1, 1): (-gain, -1.0),
        (-1, -1): (1.0, -gain),
        (1, -1): (gain, 1.0),
    }
    surfaces = (affine_surface("x", (1, 0)), affine_surface("y", (0, 1)))
    field = SignField(("x", "y"), surfaces, lambda signs: lambda t, x: np.array(flows[signs]))
    faces = field.faces_at(np.zeros(2))
    names = [face.name for face in faces if not face.keep]
    fields = {tuple(member.velocity(0, np.zeros(2))): member.name for member in faces[0].members}
    assert sorted(names) == sorted(fields.values())
    order = [(1, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)]  # left through y = 0, x = 0, y = 0, ...
    turn = [
        guards.SurfaceCrossing(float(k), np.zeros(2), fields[flows[signs]], surfaces[(k + 1) % 2])
        for k, signs in enumerate(order)
    ]
    motion = guards.whirl_around(faces, turn, 5.0, np.zeros(2))
    assert (motion is not None) is lasts
    if motion is not None:
        assert np.allclose(motion(5.0, np.zeros(2)), 0)
