"""Wherever a pose is said to be held there is a law: it is printed, exported, followed, and moves bodies as D asks.

The arrays are random, of wheels that grip more along their rims, more across, or each as it likes.  What speeds do to a
body is judged by the words of the rules: the dissipation written down once more, and sampled about the motion.
"""

from __future__ import annotations

import runpy
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from nonsmooth.analysis.fields.contact_model import Floats, contact_model
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.answers.answer import Pose
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import Check
from nonsmooth.reports.laws.law_program import law_of
from nonsmooth.reports.simulations.paths import follow_array
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays, WheelData
from tests.oracles.clause_evidence import evidence_holds
from tests.ruled import ruled
from tests.thorough import few, keep

POSES = 12
UNTIL = 1.0
NEAR = 1e-3  # of the length: starts where it is not known how near the point the law is certified
ROUNDING = 1e-9  # relative
FASTEST = 8.0  # of a rim, per unit of error and at gain one: 219 before speeds were chosen to be small


def random_array(arrays: Arrays, seed: int) -> Scene:
    """Three to eight wheels about a body that stands well between them."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 9))
    while True:
        places = rng.integers(-12, 13, (count, 2))
        spans = len(np.unique(places, axis=0)) == count and np.linalg.matrix_rank(places - places[0]) == 2
        if spans and (ConvexHull(places).equations[:, 2] < -2).all():
            break
    positions = [(Fraction(x, 8), Fraction(y, 8)) for x, y in places.tolist()]
    wheels = []
    for position in positions:
        a, b = rng.integers(-5, 6, 2).tolist()
        roll, share = Fraction(int(rng.integers(5, 16)), 10), Fraction(int(rng.integers(1, 20)), 10)
        wheels.append(WheelData(position, (a, b) if a or b else (1, 0), 1, (roll, roll * share)))
    return arrays.scene(wheels, radius=Fraction(1, 8))


def dissipation(scene: Scene, speeds: Mapping[int, float], twists: Floats) -> Floats:
    """D at the checked point, by the words of the rule, of twists (m, 3)."""
    model = contact_model(scene)
    loads = loads_at(model, np.zeros((1, 2)))[0]
    targets = np.zeros(2 * model.wheels)
    targets[::2] = [speeds[wheel.index] for wheel in scene.wheels]
    slips = (twists @ model.rows.T - targets).reshape(len(twists), -1, 2)
    along, across = np.abs(slips[..., 0]), np.abs(slips[..., 1])
    roll, side = model.friction.reshape(-1, 2).T
    match scene.contact.rule:
        case "box":
            each = roll * along + side * across
        case "ellipse":
            each = np.hypot(roll * along, side * across)
        case _:  # rollers turn where that costs less than slipping
            gripping = roll * np.hypot(along, across)
            cut = np.sqrt(np.maximum(roll**2 - side**2, 0))
            turning = cut * along + side * across
            each = np.where((side < roll) & (cut * across > side * along), turning, gripping)
    return np.asarray(each @ loads)


def said(check: Check) -> Mapping[str, Any]:
    """The numbers of the answer about the pose."""
    (answer,) = [answer for answer in answers_of(check) if answer.name == "pose"]
    return {fact.key: getattr(fact.value, "value", fact.value) for fact in answer.facts} | {"verdict": answer.verdict}


def assert_brought_home(scene: Scene, check: Check, numbers: Mapping[str, Any]) -> None:
    """Along the path of the closed loop V falls as said, from where the law is certified."""
    feedback, length = check.feedback.holding, float(scene.check.length)
    size = NEAR * length
    if isinstance(feedback, FeedbackResult):
        size = min(10 * size, float(feedback.region.level) ** 0.5 / 2) if feedback.region is not None else size
    elif feedback.reach is not None:
        size = 0.9 * float(feedback.reach)
    kappa = float(numbers["rate"] or 0)
    start = (0.6 * size, -0.5 * size, 0.6 * size / length)
    path = follow_array(scene, SimulateOptions(start=start, until=UNTIL, feedback=True))
    states = np.array(path.state, dtype=float) * (1, 1, length)
    values = (states**2).sum(axis=1)
    assert values[-1] < values[0]
    if feedback.lyapunov.length is not None:
        assert values[-1] <= values[0] * np.exp(-2 * kappa * float(path.t[-1])) * 1.01


def assert_moved_as_wanted(scene: Scene, check: Check, program: Mapping[str, Any], numbers: Mapping[str, Any]) -> None:
    """The exported speeds make D least at the motion by which V falls, at the point."""
    rng, length = np.random.default_rng(0), float(scene.check.length)
    kappa, weight = float(numbers["rate"]), length**2
    for _ in range(POSES):
        c_x, c_y, turn = rng.normal(size=3) * float(scene.check.radius) / 9
        g = np.array([c_x, c_y, weight * turn])
        axes = np.array(region_of(program, c_x, c_y)["axes"])
        wanted = -max(axes @ g, key=abs) * axes[np.argmax(np.abs(axes @ g))]
        speeds = program["speeds"](c_x, c_y, turn)
        steps = rng.normal(size=(400, 3)) * np.abs(wanted).max() * 10 ** rng.uniform(-6, 1, (400, 1))
        values = dissipation(scene, speeds, np.concatenate([wanted[None], wanted + steps]))
        assert values[1:].min() >= values[0] * (1 - ROUNDING)
        error = c_x**2 + c_y**2 + weight * turn**2
        assert g @ wanted <= -kappa * error * (1 - ROUNDING)
        assert max(map(abs, speeds.values())) <= numbers["wheel_speed"] * error**0.5 * (1 + ROUNDING)


def region_of(program: Mapping[str, Any], x: float, y: float) -> Mapping[str, Any]:
    region: Mapping[str, Any] = program["region_at"](x, y)
    return region


@pytest.mark.parametrize("rule", ["box", "ellipse", "roller"])
@few(2)
@pytest.mark.parametrize("number", keep(2, range(24)))
def test_where_a_pose_is_held_there_is_a_law(arrays: Arrays, rule: str, number: int, tmp_path: Path) -> None:
    scene = ruled(random_array(arrays, number), rule)
    check = check_theorem4(scene)
    assert isinstance(check.feedback, DrivenFeedback)
    numbers = said(check)
    if numbers["verdict"] is not Pose.CAN_BE_HELD:
        assert not check.feedback.holding.cones
        return
    assert evidence_holds(check.feedback)
    law = law_of(check)
    assert law.rows()
    law.save(tmp_path / "law.csv")
    program = runpy.run_path(str(law.save(tmp_path / "law.py")))
    assert numbers["law"] == check.feedback.holding.law
    assert numbers["wheel_speed"] < FASTEST
    assert_moved_as_wanted(scene, check, program, numbers)
    if rule == "box" or number % 12 == 5:  # paths take seconds where every motion is a minimization
        assert_brought_home(scene, check, numbers)


@pytest.mark.parametrize("rule", ["box", "ellipse"])
@pytest.mark.parametrize("number", keep(1, [1, 2, 4, 7, 8, 10]))
def test_rims_without_friction_turn_no_force(arrays: Arrays, rule: str, number: int, tmp_path: Path) -> None:
    """However fast such a rim runs, the force on its wheel is all across: D must be least all the same."""
    given = random_array(arrays, number)
    free = (
        replace(w, friction=replace(w.friction, roll=given.field.zero)) if w.index <= 2 else w for w in given.wheels
    )
    scene = ruled(replace(given, wheels=tuple(free)), rule)
    check = check_theorem4(scene)
    numbers = said(check)
    assert numbers["verdict"] is Pose.CAN_BE_HELD
    program = runpy.run_path(str(law_of(check).save(tmp_path / "law.py")))
    assert_moved_as_wanted(scene, check, program, numbers)


@pytest.mark.parametrize("seed", [1, 3, 4, 11, 13, 16])
def test_under_nearest_too(arrays: Arrays, seed: int, tmp_path: Path) -> None:
    scene = arrays.cocircular(seed)
    check = check_theorem4(scene)
    numbers = said(check)
    assert numbers["verdict"] is Pose.CAN_BE_HELD
    runpy.run_path(str(law_of(check).save(tmp_path / "law.py")))["speeds"](0.001, 0.002, 0.003)
    assert_brought_home(scene, check, numbers)
