"""Sampled maps of a carton: how long 50 x 50 starts over 20 x 20 wheels take, and 20 ends against paths by events."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.bodies.many_paths import BodyEnd, ManyPaths
from nonsmooth.analysis.bodies.path import BodyPath
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.fields.contact_model import contacts_under
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.reports.simulations.body_maps import pose_starts
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.benchmarks.conftest import Stopwatch

MOST_SECONDS = 60.0  # of this process
MOST_OF_TWELVE = 8.0  # the same, of 21 x 21 starts over twelve wheels
STARTS = 20
PLACE_ERROR, HEADING_ERROR = 0.01, 0.02  # of the spacing, and radians
NEAR = 0.02  # a start so close to others with other ends lies near a border of basins
MOST_NEAR_BORDERS = 3


def carton(folder: Path, count: int) -> Scene:
    file = folder / "carton.toml"
    file.write_text(
        f'[grid]\nrows = {count}\ncolumns = {count}\n[field]\nkind = "radial"\nspeed = "unit"\n'
        '[body]\nshape = "rectangle"\nwidth = 3\nheight = 2\n[friction]\nmu_roll = 1\nmu_side = 1\n'
        '[contact]\nrule = "ellipse"\n'
    )
    return load_scene(file)


def test_a_map_of_2500_starts_takes_less_than_a_minute(stopwatch: Stopwatch, tmp_path: Path) -> None:
    scene = carton(tmp_path, 20)
    paths, starts = ManyPaths(scene, smooth_rule_of(scene)), pose_starts(scene, 50, 0.3)
    begun, used = time.perf_counter(), time.process_time()
    found = paths.follow(starts)
    wall, used = time.perf_counter() - begun, time.process_time() - used
    rests = int(found.by(BodyEnd.REST).sum())
    stopwatch.report(f"50 x 50 starts over 20 x 20 wheels: {wall:.1f} s, {used:.1f} s of processors, {rests} rest")
    assert not found.by(BodyEnd.UNKNOWN).any()
    assert used < MOST_SECONDS


@pytest.mark.parametrize(
    ("side", "angle", "height"),
    [
        pytest.param("1", "0", "2", id="paths that chatter at edges"),
        pytest.param("1/2", "0", "2", id="two motions in turn on the same wheels"),
        pytest.param("1", "pi/200", "2.2", id="bodies that turn on slowly"),
    ],
)
def test_a_map_over_twelve_wheels(side: str, angle: str, height: str, stopwatch: Stopwatch, tmp_path: Path) -> None:
    file = tmp_path / "carton.toml"
    file.write_text(
        f'[grid]\nrows = 3\ncolumns = 4\n[field]\nkind = "spiral"\nangle = "{angle}"\nspeed = "unit"\n'
        f'[body]\nshape = "rectangle"\nwidth = 3\nheight = "{height}"\n'
        f'[friction]\nmu_roll = 1\nmu_side = "{side}"\n[contact]\nrule = "ellipse"\n'
    )
    scene, used = load_scene(file), time.process_time()
    found = ManyPaths(scene, smooth_rule_of(scene)).follow(pose_starts(scene, 21, 0.0))
    used = time.process_time() - used
    rests = int(found.by(BodyEnd.REST).sum())
    stopwatch.report(
        f"21 x 21 starts over 12 wheels: {used:.1f} s of processors, {rests} rest (asked {MOST_OF_TWELVE})"
    )
    assert not found.by(BodyEnd.UNKNOWN).any()
    assert used < MOST_OF_TWELVE


def test_ends_agree_with_paths_by_events(stopwatch: Stopwatch, tmp_path: Path) -> None:
    scene = carton(tmp_path, 6)
    chance = np.random.default_rng(11)
    starts = chance.uniform([-2.2, -2.2, -np.pi], [2.2, 2.2, np.pi], (STARTS, 3))
    many, path = ManyPaths(scene, smooth_rule_of(scene)), BodyPath(contacts_under(smooth_rule_of(scene), scene), scene)
    found = many.follow(starts)
    apart, worst = [], np.zeros(2)
    for k, start in enumerate(starts):
        away, same = distance(path, start, found.poses[k], rests=bool(found.by(BodyEnd.REST)[k]))
        if same:
            worst = np.maximum(worst, away)
        else:
            apart.append((start, away))
    stopwatch.report(f"{STARTS} starts: {len(apart)} apart {apart}; else place {worst[0]:.1e}, heading {worst[1]:.1e}")
    assert len(apart) <= MOST_NEAR_BORDERS
    for start, _ in apart:
        assert lies_near_a_border(many, start)


def distance(path: BodyPath, start: np.ndarray, pose: np.ndarray, *, rests: bool) -> tuple[np.ndarray, bool]:
    """Differences of place and heading at the ends, and whether they agree."""
    try:
        end = path.follow(tuple(start), 60.0).end
    except ValueError:  # it tips where it starts
        return np.zeros(2), not rests
    if (end.reason is EndReason.REST) != rests:
        return np.full(2, np.inf), False
    if not rests:
        return np.zeros(2), end.reason is EndReason.TIPS
    away = np.abs(np.array(end.state) - pose)
    errors = np.array([away[:2].max(), away[2]])
    return errors, bool((errors <= [PLACE_ERROR, HEADING_ERROR]).all())


def lies_near_a_border(many: ManyPaths, start: np.ndarray) -> bool:
    """Whether starts beside it end elsewhere, by more than the starts are apart."""
    around = start + NEAR * np.vstack([np.eye(3), -np.eye(3), np.zeros((1, 3))])
    ends = many.follow(around)
    spread = np.ptp(ends.poses, axis=0)
    return len(set(ends.reasons.tolist())) > 1 or bool((spread > 2 * NEAR).any())
