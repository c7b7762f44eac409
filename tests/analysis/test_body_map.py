"""Sampled ends of a body with an outline: against paths by events, and against the proved minimizers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.bodies.many_paths import (
    BodyEnd,
    CellMotions,
    LeastDissipation,
    ManyPaths,
    ManyRates,
    destinations,
)
from nonsmooth.analysis.bodies.motions_on_sets import RowsOfWheels, elastic_loads_of, widest_gaps
from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.outline_field import CellPath
from nonsmooth.analysis.bodies.path import BodyPath
from nonsmooth.analysis.cells.contact_rule import CellRule, rule_of, smooth_rule_of
from nonsmooth.analysis.fields.contact_model import contacts_under
from nonsmooth.analysis.minimizers.float_loads import elastic_loads
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.small_steps import Contacts
from tests.thorough import few, keep, thorough

PLACE_ERROR, HEADING_ERROR = 0.01, 0.02  # of the spacing, and radians: Heun's steps of 0.04, chattering at edges
RATE_ERROR = {"ellipse": 1e-4, "roller": 2e-2}  # of the fastest wheel: norms are smoothed


def carton(folder: Path, rule: str = "ellipse", side: str = "1") -> Scene:
    """A carton of 3 x 2 on 6 x 6 wheels that point to the middle."""
    file = folder / "carton.toml"
    file.write_text(
        f'[grid]\nrows = 6\ncolumns = 6\n[field]\nkind = "radial"\nspeed = "unit"\n[body]\nshape = "rectangle"\n'
        f'width = 3\nheight = 2\n[friction]\nmu_roll = 1\nmu_side = "{side}"\n[contact]\nrule = "{rule}"\n'
        "[check]\nradius = 2\n"
    )
    return load_scene(file)


def random_poses(count: int, reach: float) -> np.ndarray:
    return np.random.default_rng(7).uniform([-reach, -reach, -3], [reach, reach, 3], (count, 3))


@few(1)
@pytest.mark.parametrize(("rule", "side"), [("ellipse", "1"), ("ellipse", "1/5"), ("roller", "1/10")])
def test_rates_are_those_of_paths_by_events(rule: str, side: str, tmp_path: Path) -> None:
    scene = carton(tmp_path, rule, side)
    model = contacts_under(smooth_rule_of(scene), scene)
    assert scene.body is not None
    outline, poses = MovingOutline(scene.body, model.positions), random_poses(40, 1.2)
    found = ManyRates(LeastDissipation(model, outline.size, 40), outline, poses).at(poses, np.arange(40))
    assert found.known.all()
    path = BodyPath(contacts_under(smooth_rule_of(scene), scene), scene)
    agree = 0
    for pose, rate, tips in zip(poses, found.rates, found.tips, strict=True):
        carrying = frozenset(int(k) for k in np.flatnonzero(outline.depths(pose) > 0))
        assert tips == (not path._sets.carries(carrying, pose))
        if not tips:
            agree += np.abs(path._sets.rate(carrying, pose) - rate).max() <= RATE_ERROR[rule]
    standing = int((~found.tips).sum())
    assert standing > 20
    assert agree >= (standing if rule == "ellipse" else standing - 1)


@few(1)
@pytest.mark.parametrize(("rule", "count"), [("nearest", 15), ("box", 6), ("nearest", 60)])
def test_rates_by_cells_are_those_of_the_words_of_the_rule(rule: str, count: int, tmp_path: Path) -> None:
    scene = carton(tmp_path, rule, "1/2")
    cells = rule_of(scene)
    assert isinstance(cells, CellRule)
    assert scene.body is not None
    contacts = Contacts.of(scene)
    outline, poses = MovingOutline(scene.body, contacts.positions), random_poses(count, 1.5)
    found = ManyRates(CellMotions(scene, cells), outline, poses).at(poses, np.arange(count))
    words = {"nearest": contacts.nearest, "box": contacts.box}[rule]
    assert (~found.tips).sum() > count / 3
    for pose, rate in zip(poses[~found.tips], found.rates[~found.tips], strict=True):
        v_x, v_y, omega = words(np.flatnonzero(outline.depths(pose) > 0).tolist(), pose[:2])
        np.testing.assert_allclose(rate, [v_x - omega * pose[1], v_y + omega * pose[0], omega], atol=1e-9)


@thorough  # the small one: test_ends_agree_with_paths_by_events
def test_bodies_end_by_cells_where_their_paths_by_events_do(tmp_path: Path) -> None:
    scene = carton(tmp_path, "nearest", "1/2")
    rule = rule_of(scene)
    assert isinstance(rule, CellRule)
    starts = random_poses(6, 1.0)
    ends = ManyPaths(scene, rule).follow(starts, until=6.0)
    path = CellPath(scene, rule)
    compared = 0
    for k, start in enumerate(starts):
        if not path.stands(start.tolist()):
            assert ends.by(BodyEnd.TIPS)[k]
            continue
        end = path.follow(start.tolist(), 6.0).end
        assert ends.by(BodyEnd.TIPS)[k] == (end.reason is EndReason.TIPS)
        if ends.by(BodyEnd.REST)[k]:
            assert np.abs(np.subtract(end.state[:2], ends.poses[k, :2])).max() < PLACE_ERROR
            compared += 1
    assert compared > 1


def test_loads_are_those_of_one_pose_at_a_time(tmp_path: Path) -> None:
    scene = carton(tmp_path)
    model, points = contacts_under(smooth_rule_of(scene), scene), random_poses(30, 2.4)[:, :2]
    levers = model.positions - points[:, None]
    loads, balanced = elastic_loads_of(levers, np.ones(levers.shape[:2], bool))
    assert balanced.all()
    np.testing.assert_allclose(loads, elastic_loads(model, points), atol=1e-10)
    rows, _ = RowsOfWheels(model).at(np.arange(36)[None], levers[:1], 1.0)
    assert rows.shape == (1, 36, 2, 3)


def test_a_body_tips_over_the_line_with_the_widest_gap() -> None:
    corners = np.array([[1.0, 0.2], [-1, 0.2], [-1, 1], [1, 1]])
    levers = np.stack([corners, corners - [0, 0.5]])
    gaps, first, second = widest_gaps(levers, np.ones((2, 4), bool))
    assert (gaps < np.pi).tolist() == [False, True]
    assert (first[0], second[0]) == (1, 0)
    assert np.isinf(widest_gaps(levers, np.zeros((2, 4), bool))[0]).all()


@pytest.mark.parametrize("count", keep(1, [1, 4]))
def test_ends_agree_with_paths_by_events(count: int, tmp_path: Path) -> None:
    scene = carton(tmp_path)
    starts = np.column_stack([random_poses(count, 1.6)[:, :2], np.full(count, 0.3)])
    told: list[str] = []
    found = ManyPaths(scene, smooth_rule_of(scene)).follow(starts, report=lambda done, total, up_to: told.append(up_to))
    assert len(set(told)) > 2  # it moves while no path has ended
    assert told[-1] == f"t = {found.until:.3g} of {found.until:.3g}"
    path = BodyPath(contacts_under(smooth_rule_of(scene), scene), scene)
    for k, start in enumerate(starts):
        end = path.follow(tuple(start), 60.0).end
        assert end.reason is EndReason.REST
        assert found.by(BodyEnd.REST)[k]
        away = np.abs(np.array(end.state) - found.poses[k])
        assert away[:2].max() <= PLACE_ERROR
        assert away[2] <= HEADING_ERROR


@pytest.mark.parametrize(("side", "reach"), keep(1, [(2, 1), (3, 2), (5, 2)]))
def test_destinations_share_all_starts(side: int, reach: float, tmp_path: Path) -> None:
    scene = carton(tmp_path)
    axis = np.linspace(-reach, reach, side)
    x, y = np.meshgrid(axis, axis)
    paths = ManyPaths(scene, smooth_rule_of(scene))
    found = paths.follow(np.column_stack([x.ravel(), y.ravel(), np.full(side**2, 0.4)]))
    places = destinations(found, 0.02 * paths.spacing)
    assert sum(len(one.starts) for one in places) == side**2
    assert sum(one.share for one in places) == pytest.approx(1)
    resting = [one for one in places if one.reason is BodyEnd.REST]
    assert resting
    assert all(one.headings is not None and one.headings[0] <= one.headings[1] for one in resting)


def test_what_still_moves_is_said_to(tmp_path: Path) -> None:
    scene = carton(tmp_path)
    found = ManyPaths(scene, smooth_rule_of(scene)).follow(np.array([[1.0, 0.9, 0.3], [4.0, 4.0, 0.0]]), 0.2)
    assert found.by(BodyEnd.TIME).tolist() == [True, False]
    assert found.times[0] == pytest.approx(0.2)
    assert found.by(BodyEnd.LEAVES).tolist() == [False, True]
