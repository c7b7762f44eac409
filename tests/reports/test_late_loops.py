"""Closed loops whose pose is late and wrong: what is certified of them against paths that suffer the worst errors."""

from __future__ import annotations

import math
import runpy
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.clauses.feedback.by_friction import decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.loop_bounds import ultimate_bound
from nonsmooth.proofs.findings.verdicts import Certainty
from nonsmooth.reports.laws.driven_loop import DrivenLoop
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import LoopErrors, Scene
from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

TEXT = """name = "late"
[friction]
mu_roll = 1
mu_side = "1/2"
[ring]
count = {count}
radius = {radius}
[contact]
rule = "{rule}"
[feedback]
{errors}
"""
LATE = 'delay = 0.02\nposition_error = 0.0005\nheading_error = "0.05 deg"'
SLACK = 1e-3  # relative: the path is sampled, and switches late by a step


def write(folder: Path, rule: str, errors: str = LATE, count: int = 5, radius: str = "1") -> str:
    file = folder / "late.toml"
    file.write_text(TEXT.format(rule=rule, errors=errors, count=count, radius=radius), encoding="utf-8")
    return str(file)


def pose_answer(invoke: Invoke, file: str, *options: str) -> Any:
    return invoke("check", file, "--json", *options).record["answers"]["pose"]


@few(1)
@pytest.mark.parametrize(("radius", "until"), keep(1, [("1", "20"), ("1", "60"), ("3", "60")]))
def test_paths_end_within_the_bound(radius: str, until: str, invoke: Invoke, tmp_path: Path) -> None:
    """In another unit of length too; the worst errors do keep it at half of the error of the place and farther."""
    file = write(tmp_path, "box", radius=radius)
    loop = pose_answer(invoke, file)["loop"]
    assert loop["verdict"] == "certified"
    start = 0.6 * loop["from_within"]
    length = float(load_scene(file).check.length)
    at = f"{start},{start / 2},{-start / 2 / length}"
    path = invoke("simulate", file, "--feedback", "--json", "--from", at, "--until", until).record
    assert path["method"] == "sampled"
    poses = np.array(path["state"]) * [1, 1, length]
    sizes = np.linalg.norm(poses, axis=1)
    assert sizes.max() <= sizes[0] * (1 + SLACK)
    assert sizes[-200:].max() <= loop["ends_within"] * (1 + SLACK)
    assert sizes[-200:].max() > 5e-4 / 2


def test_an_exact_pose_that_is_only_late_comes_home(invoke: Invoke, tmp_path: Path) -> None:
    for rule in ("box", "ellipse"):
        loop = pose_answer(invoke, write(tmp_path, rule, "delay = 0.02"))["loop"]
        assert (loop["verdict"], loop["ends_within"]) == ("certified", 0.0)
        assert (loop["from_within"] is None) == (rule == "ellipse")


def late_scene(folder: Path, delay: Fraction) -> tuple[Scene, DrivenLoop, Any]:
    scene = load_scene(write(folder, "box", f"delay = {float(delay)!r}")).recentred()
    feedback = decide_driven_feedback(scene)
    return scene, DrivenLoop(scene, feedback), ultimate_bound(feedback, scene.loop_errors or _none(scene))


def _none(scene: Scene) -> LoopErrors:
    return LoopErrors(scene.field.zero, scene.field.zero, Fraction(0))


def test_long_delays_are_not_certified_and_do_swing(tmp_path: Path) -> None:
    """A delay of 20/k keeps the error from falling; below the stated limit it falls."""
    _, loop, bound = late_scene(tmp_path, Fraction(20))
    assert bound.verdict is Certainty.UNDECIDED
    assert "too old" in bound.reason
    assert bound.largest_delay is not None
    path = loop.follow((0.05, 0.0, 0.02), 200.0)
    assert loop.value(path.end.state) > loop.value((0.05, 0.0, 0.02)) / 2
    _, loop, bound = late_scene(tmp_path, bound.largest_delay * Fraction(9, 10))
    assert bound.verdict is Certainty.CERTIFIED
    path = loop.follow((0.02, 0.0, 0.02), 60.0)
    assert math.sqrt(loop.value(path.end.state)) < 1e-3


@few(2)
@pytest.mark.parametrize(
    ("rule", "errors", "reason"),
    [
        ("nearest", LATE, "contact state"),
        ("ellipse", LATE, "how near is not known"),
        ("roller", LATE, "how near is not known"),
        ("box", "position_error = 0.5", "too large"),
        ("box", 'heading_error = "90 deg"', "too large"),
    ],
)
def test_what_is_open_says_why(rule: str, errors: str, reason: str, invoke: Invoke, tmp_path: Path) -> None:
    loop = pose_answer(invoke, write(tmp_path, rule, errors))["loop"]
    assert loop["verdict"] == "undecided"
    assert reason in loop["reason"]
    assert loop["ends_within"] is None
    assert loop["gain"] is None


@pytest.mark.parametrize(
    ("rule", "delay", "rest"), keep(1, [("box", 5, "position_error = 0.0001"), ("box", 20, ""), ("ellipse", 20, "")])
)
def test_a_pose_that_is_too_old_says_which_gain_serves(
    rule: str, delay: int, rest: str, invoke: Invoke, tmp_path: Path
) -> None:
    """With k for the unit of rates the loop is that at k = 1 with k times the delay, and that is certified."""
    answer = pose_answer(invoke, write(tmp_path, rule, f"delay = {delay}\n{rest}"))
    gain = answer["loop"]["gain"]
    assert answer["loop"]["verdict"] == "undecided"
    assert "take a gain k of at most" in answer["reason"]
    path = invoke(
        "simulate", str(tmp_path / "late.toml"), "--feedback", "--json", "--from", "0.01,0,0", "--gain", f"{gain}",
        "--until", f"{20 / gain}",
    ).record  # fmt: skip
    assert math.hypot(*path["state"][-1]) < 0.01 / 2
    shorter = pose_answer(invoke, write(tmp_path, rule, f"delay = {delay * gain}\n{rest}"))
    assert shorter["loop"]["verdict"] == "certified"


def test_where_no_gain_is_known_to_serve_that_is_said(invoke: Invoke, tmp_path: Path) -> None:
    """An error of the place is larger than a disc whose size is not known, however slow the law is."""
    answer = pose_answer(invoke, write(tmp_path, "ellipse", LATE))
    assert answer["loop"]["gain"] is None
    assert "no gain k is known that serves" in answer["reason"]


def test_a_law_says_where_it_does_not_return_the_body_and_which_gain_serves(invoke: Invoke, tmp_path: Path) -> None:
    invoke("check", "four-wheel", "--law", "cells.st")
    invoke("check", write(tmp_path, "box", "delay = 20"), "--law", "twists.st")
    cells, twists = (" ".join((tmp_path / name).read_text().split()) for name in ("cells.st", "twists.st"))
    assert "outside of its regions it gives no speed (region 0 and rims at rest; in Python a ValueError)" in cells
    assert "of a late one no k is known that does" in cells
    assert "it gives speeds at every place" in twists
    assert "take a gain k of at most" in twists


@thorough  # the small one: test_an_exact_pose_that_is_only_late_comes_home
def test_closed_loops_of_imposed_twists_through_the_command(invoke: Invoke, tmp_path: Path) -> None:
    """Their speeds are those of the exported law; films and other laws are refused in one line."""
    run = ("simulate", "ring-5", "--feedback", "--rule", "ellipse", "--from", "0.02,0.01,0.02", "--until", "0.02")
    found = invoke(*run, "--gain", "3", "--json").record
    assert found["law"]["certified"]
    assert invoke("check", "ring-5", "--rule", "ellipse", "--law", "law.py").status in {0, 1}
    expected = runpy.run_path(str(tmp_path / "law.py"))["speeds"](*found["state"][0], k=3.0)
    assert found["speeds"][0] == pytest.approx(list(expected.values()), rel=1e-9)
    for name in ("path.csv", "path.svg"):
        assert invoke(*run, "-o", name).status == 0
    for options in (("-o", "path.html"), ("--law", "printed"), ("--method", "hysteresis")):
        refused = invoke(*run, *options)
        assert (refused.status, refused.out) == (2, "")
        assert len(refused.err.splitlines()) == 1
