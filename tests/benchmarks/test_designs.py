"""The three stories of the design page: what is found beats the given array, checks confirm it, and so does MuJoCo.

The physics engine runs the wheels of each found array beside the paths of the product, under friction ellipses.
"""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.reports.simulations.mjcf import export_scene
from nonsmooth.symbolic.files.documents import read_document
from nonsmooth.symbolic.files.scene_file import build_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.benchmarks.conftest import Stopwatch
from tests.body_engine import run_beside_engine
from tests.engine_export import error

STARTS = ((Fraction(1, 8), Fraction(1, 16)), (Fraction(-1, 10), Fraction(1, 8)))
UNTIL = 0.5  # of wheels of speed about one
TWISTS, POSES = 2e-3, 0.03  # relative errors of twists; lengths and radians between poses
PLATE = {"shape": "disc", "radius": 3}  # it covers all wheels at every pose

STORIES: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "a pose": (
        "four-wheel",
        {},
        {"free": "headings,speeds", "require": "position,pose", "maximize": "gain", "checks": 60},
    ),
    "tolerances": (
        "ring-6",
        {"tolerance": {"position": "1/1000", "heading": "1/2 deg", "mu_roll": "1/100", "mu_side": "1/100"}},
        {"free": "positions", "require": "position", "maximize": "tolerance", "checks": 60},
    ),
    "a carton": (
        "carton-on-6x6",
        {"body": {"shape": "rectangle", "width": "23/5", "height": "18/5"}},
        {"free": "wheels", "require": "position,pose", "maximize": "rate", "symmetry": 2, "checks": 40},
    ),
}


@pytest.mark.parametrize("story", STORIES)
def test_a_design_in_the_engine(story: str, stopwatch: Stopwatch, tmp_path: Path) -> None:
    name, tables, asked = STORIES[story]
    document, _, path = read_document(name, rule="ellipse")
    given = ns.Array.of_document({**document, **tables}, path.parent)
    found = given.design(**asked)
    assert found.is_found
    assert found.value is not None
    if asked["free"] != "wheels":
        assert found.given_value is None or found.value > found.given_value
    file = found.save(tmp_path / "found.toml")
    again = ns.load(file)
    assert isinstance(again, ns.Array)
    assert str(again.check().position.verdict) == "comes home"
    twists, poses, nearer = beside_engine(found.design.document, file)
    count = len(again.scene.wheels)
    stopwatch.report(
        f"{story}: {count} wheels, {asked['maximize']} {found.given_value} -> {found.value:.4g} in "
        f"{found.design.checks} checks; engine: twists {twists:.1e}, poses {poses:.3f} apart, {nearer:.2f} of the way"
    )
    assert twists < TWISTS
    assert poses < POSES
    assert nearer > 0


def beside_engine(document: dict[str, Any], file: Path) -> tuple[float, float, float]:
    """Largest errors of twists and of poses from two starts, and the least share of the way home that is done."""
    body = document.get("body", PLATE)
    scene: Scene = build_scene({**document, "body": body}, str(file), file)
    twists, poses, done = [], [], []
    for start in STARTS:
        place = scene.field(start[0]), scene.field(start[1])
        there = scene.checked_at(place, scene.check.radius)
        twists.append(error(export_scene(scene, place).text()))
        run = run_beside_engine(there, UNTIL)
        poses.append(run.error)
        far = math.hypot(float(start[0]), float(start[1]))
        done.append(1 - math.hypot(float(run.last[0]), float(run.last[1])) / far)
    return max(twists), max(poses), min(done)
