"""Smoothed twists of many bodies at once against proved minimizers, one by one."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.fields.contact_model import contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.many_twists import EACH_STEP, MovingTwists
from nonsmooth.analysis.trajectories import smooth_ends as smooth_ends_module
from nonsmooth.analysis.trajectories.smooth_ends import LEFT, MOVING, smooth_ends
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import keep

POINTS = 40
ERRORS = {"ellipse": 1e-5, "roller": 2e-3}  # of the fastest wheel's speed: by how much they are smoothed


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("name", keep(3, ["omni-3", "mecanum-4", "spiral-30", "grid-4x4", "conveyor-3"]))
def test_twists_are_the_minimizers(name: str, rule: str) -> None:
    """From the proved ones of points beside them: all settle, and lie where D is least."""
    scene = load_scene(name, rule=rule).recentred()
    smooth = smooth_rule_of(scene)
    model, radius = contacts_under(smooth, scene), float(scene.check.radius)
    points = np.random.default_rng(3).uniform(-0.9, 0.9, (POINTS, 2)) * radius
    paths = np.arange(POINTS)
    moving = MovingTwists(model, POINTS)
    moving.remember(minima_under(smooth, scene, 0.95 * points).twists, paths)
    found, settled = moving.at(points, paths)
    proved = minima_under(smooth, scene, points).twists
    assert settled.all()
    assert np.abs(found - proved).max() <= ERRORS[rule] * np.abs(model.speeds).max()


def test_paths_keep_their_own_twists() -> None:
    """A few paths of many: the others begin where they were."""
    scene = load_scene("conveyor-3", rule="ellipse").recentred()
    smooth = smooth_rule_of(scene)
    points = np.random.default_rng(4).uniform(-0.4, 0.4, (POINTS, 2)) * float(scene.check.radius)
    moving = MovingTwists(contacts_under(smooth, scene), POINTS)
    proved = minima_under(smooth, scene, points).twists
    moving.remember(proved, np.arange(POINTS))
    odd = np.arange(1, POINTS, 2)
    found, settled = moving.at(points[odd], odd)
    assert settled.all()
    assert np.abs(found - proved[odd]).max() <= ERRORS["ellipse"]


def test_a_step_counts_as_work_however_few_bodies_take_it() -> None:
    """What a call costs is that of its Newton steps: one body alone takes hardly less time than many together."""
    scene = load_scene("mecanum-4", rule="roller").recentred()
    smooth = smooth_rule_of(scene)
    points = np.random.default_rng(5).uniform(-0.4, 0.4, (POINTS, 2)) * float(scene.check.radius)
    spent = []
    for count in (1, POINTS):
        moving = MovingTwists(contacts_under(smooth, scene), count)
        moving.remember(minima_under(smooth, scene, points[:count]).twists, np.arange(count))
        for turn in range(10):
            moving.at(points[:count] * (1 - 0.01 * turn), np.arange(count))
        spent.append(moving.work)
    assert spent[0] >= 10 * EACH_STEP
    assert spent[0] < spent[1] < POINTS * spent[0]


def test_paths_end_when_their_work_is_spent(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same starts with less work: those that still moved are said to, and no other end changes."""
    scene = load_scene("conveyor-3", rule="roller").recentred()
    starts = np.random.default_rng(6).uniform(-0.9, 0.9, (5, 2)) * float(scene.check.radius)
    whole = smooth_ends(scene, starts)
    monkeypatch.setattr(smooth_ends_module, "MOST_WORK", 20 * EACH_STEP)
    short = smooth_ends(scene, starts)
    assert (short.reached == MOVING).any()
    ended = short.reached == LEFT
    assert (whole.reached[ended] == LEFT).all()
