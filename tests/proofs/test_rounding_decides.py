"""Where rounding decides nothing is said: rings against symmetry, tables against minima of D at moved headings."""

from __future__ import annotations

import math
import random
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import Check, SmoothCheck
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.rounded_rings import RULES, contradiction, said_of_ring
from tests.thorough import few, keep

Array = NDArray[np.float64]
MOVED = 1e-13  # radians by which headings are moved
MU_SIDE = 0.5

TRIANGLE = """
[friction]
mu_roll = 1
mu_side = "1/2"
[[wheel]]
position = [1, 0]
heading = 187
[[wheel]]
position = ["-1/2", "sqrt(3)/2"]
heading = 307
[[wheel]]
position = ["-1/2", "-sqrt(3)/2"]
heading = 67
"""


def check_of(tmp_path: Path, text: str, rule: str) -> Check:
    source = tmp_path / "my.toml"
    source.write_text(text)
    return check_theorem4(load_scene(source, rule=rule))


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_a_ring_in_degrees_is_not_said_to_throw_bodies_out(tmp_path: Path, rule: str) -> None:
    check = check_of(tmp_path, TRIANGLE, rule)
    verdicts = [str(check.results[name].verdict) for name in ("equilibrium", "translation", "rotation")]
    assert verdicts == ["holds", "asymptotically stable", "unstable"]
    assert isinstance(check, SmoothCheck)
    assert 0 < (check.equilibrium.rounding_distance or 0) < 1e-12
    assert check.check()


@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_what_is_true_of_all_members_stays(tmp_path: Path, rule: str) -> None:
    check = check_of(tmp_path, TRIANGLE, rule)
    assert not check.by_rounding
    assert check.results["equilibrium"].verdict == "holds"
    assert check.results["translation"].verdict == {"nearest": "asymptotically stable", "box": "stable"}[rule]
    assert check.check()


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_an_equilibrium_of_the_rounded_member_alone_is_not_shown(tmp_path: Path, rule: str) -> None:
    """Three rims balance where they point along 3-4-5; one is stated by its angle, to sixteen digits."""
    exact = """
[friction]
mu_roll = 5
mu_side = 1
[[wheel]]
position = ["-3/5", "-4/5"]
heading = {}
[[wheel]]
position = ["3/5", "4/5"]
heading = [-3, -4]
[[wheel]]
position = ["4/5", "-3/5"]
heading = [-4, 3]
[[wheel]]
position = ["-4/5", "3/5"]
heading = [4, -3]
"""
    by_vectors = check_of(tmp_path, exact.format("[3, 4]"), rule)
    by_angle = check_of(tmp_path, exact.format('"53.13010235415598 deg"'), rule)
    assert isinstance(by_vectors, SmoothCheck)
    assert isinstance(by_angle, SmoothCheck)
    assert by_vectors.equilibrium.verdict == by_angle.equilibrium.verdict == "holds"
    assert by_vectors.equilibrium.rounding_distance is None
    assert by_angle.equilibrium.rounding_distance  # not the point itself
    assert by_angle.rotation.verdict == "undecided"


@pytest.mark.parametrize("rule", keep(1, ["box", "ellipse"]))
def test_unknown_loads_too(rule: str, tmp_path: Path) -> None:
    check = check_of(tmp_path, TRIANGLE + '[contact]\nloads = "any"\n', rule)
    assert check.results["equilibrium"].verdict != "fails"
    assert check.check()


@few(2)
@pytest.mark.parametrize(
    ("count", "turn", "rule"),
    keep(3, [(3, 7, "ellipse"), (3, 41, "nearest"), (4, 33, "box"), *product(range(3, 13), range(1, 90, 4), RULES)]),
)
def test_notations_of_a_ring_do_not_contradict_each_other(tmp_path: Path, count: int, turn: int, rule: str) -> None:
    assert not contradiction(said_of_ring(tmp_path, count, turn, rule))


# ---- random tables: the minimum of D by its definition, at headings beside those stated -------------


def random_table(draw: random.Random) -> tuple[str, Array, Array]:
    """Wheels about the unit circle, headings in whole degrees; the scene with its positions and headings."""
    count = draw.randint(3, 6)
    places, degrees = [], []
    for k in range(count):
        angle = 360 * k / count + draw.randint(-15, 15)
        x, y = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        places.append((round(x, 2), round(y, 2)))
        degrees.append(round(angle) + 180 + draw.randint(-25, 25))
    wheels = [
        f"[[wheel]]\nposition = [{x}, {y}]\nheading = {degree}\n"
        for (x, y), degree in zip(places, degrees, strict=True)
    ]
    head = f'[check]\nradius = "1/20"\n[friction]\nmu_roll = 1\nmu_side = {MU_SIDE}\n'
    return head + "".join(wheels), np.array(places), np.radians(degrees)


def least_loss(places: Array, headings: Array, *, still: bool) -> float:
    """Least power lost to friction (ellipse, elastic loads) at the middle; of ``still`` bodies only those that spin."""
    columns = np.column_stack([np.ones(len(places)), places])
    loads = columns @ np.linalg.pinv(columns.T @ columns) @ np.array([1.0, 0.0, 0.0])
    along = np.column_stack([np.cos(headings), np.sin(headings)])

    def loss(twist: Array) -> float:
        vx, vy, omega = (0.0, 0.0, twist[0]) if still else twist
        velocity = np.array([vx, vy]) + omega * np.column_stack([-places[:, 1], places[:, 0]])
        roll = np.sum(along * velocity, axis=1) - 1
        side = along[:, 0] * velocity[:, 1] - along[:, 1] * velocity[:, 0]
        return float(loads @ np.hypot(roll, MU_SIDE * side))

    size = 1 if still else 3
    options = {"xatol": 1e-10, "fatol": 1e-14, "maxiter": 4_000, "maxfev": 8_000}
    return float(minimize(loss, np.full(size, 0.01), method="Nelder-Mead", options=options).fun)


@pytest.mark.parametrize("seed", keep(4, range(60)))
def test_what_fails_fails_beside_the_stated_headings_too(tmp_path: Path, seed: int) -> None:
    draw = random.Random(seed)
    text, places, headings = random_table(draw)
    check = check_of(tmp_path, text, "ellipse")
    assert check.check()
    for _ in range(2):
        moved = headings + np.array([draw.uniform(-MOVED, MOVED) for _ in headings])
        gain = least_loss(places, moved, still=True) - least_loss(places, moved, still=False)
        if check.results["equilibrium"].verdict == "fails":
            assert gain > 1e-9  # a motion away from the point loses less than every spin
        assert not check.by_rounding or gain < 1e-9
