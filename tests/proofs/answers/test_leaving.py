"""What ``leaves`` means: bodies end, or are carried, farther than the accuracy; with outlines, and loads left open."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.proofs.answers.answer import Position
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.answers.nearness import _escapes
from nonsmooth.proofs.robust.drift import _directions, driven_out, is_driven_out_on_one_side, largest_spin
from nonsmooth.proofs.robust.ends import decide_ends
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.mechanics.contact_set import ContactSet
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.oracles.measured_tables import MeasuredTable, SmallSteps
from tests.thorough import keep

LARGE = '[body]\nshape = "rectangle"\nwidth = 900\nheight = 700\n'
ROUND = '[body]\nshape = "disc"\nradius = 400\n'


def scene_of(folder: Path, text: str) -> Scene:
    file = folder / "table.toml"
    file.write_text(text, encoding="utf-8")
    return load_scene(str(file))


def position_of(scene: Scene) -> Any:
    return answers_of(check_theorem4(scene, beside=False))[0]


@pytest.mark.parametrize(
    ("rule", "body"), keep(1, [("nearest", LARGE), ("ellipse", ROUND), ("nearest", ROUND), ("ellipse", LARGE)])
)
def test_under_an_outline_that_covers_all_wheels_bodies_are_followed_as_without(
    rule: str, body: str, tmp_path: Path
) -> None:
    table = MeasuredTable.random(3, rule, off=3.0)
    plain, outlined = (position_of(scene_of(tmp_path, table.toml + more)) for more in ("", body))
    assert (plain.verdict, outlined.verdict) == (Position.COMES_NEAR, Position.COMES_NEAR)
    assert outlined["ends_within"] == plain["ends_within"]
    assert 2 * outlined["accuracy"] <= outlined["within"] <= plain["within"]
    assert "while the same wheels carry it" in outlined.sentence


@pytest.mark.parametrize(
    ("radius", "angle", "is_said"),
    keep(2, [(26, None, True), (None, None, False), (26, 2, True), (26, Fraction(1, 1000), False)]),
)
def test_a_narrow_outline_makes_the_disc_smaller_until_nothing_is_said(
    radius: int | None, angle: int | Fraction | None, is_said: bool, tmp_path: Path
) -> None:
    """None for a radius is that of twice the accuracy, within which all starts would have to be."""
    scene = scene_of(tmp_path, MeasuredTable.random(3, "ellipse", off=3.0).toml).recentred()
    least = 2 * scene.accuracy
    kept = ContactSet((), least if radius is None else Fraction(radius), None if angle is None else Fraction(angle))
    ends = decide_ends(scene, scene.accuracy, kept=kept)
    assert (ends is not None) == is_said
    assert ends is None or least <= ends.within < 26


@pytest.mark.parametrize("rule", keep(2, ["nearest", "ellipse", "box", "roller"]))
def test_a_carton_that_rollers_carry_along_leaves(rule: str) -> None:
    answer = position_of(load_scene("roller-bed", rule=rule))
    assert answer.verdict is Position.LEAVES
    assert answer["after"] >= answer["accuracy"]  # the rollers run at one


@pytest.mark.parametrize("rule", ["nearest", "ellipse"])
def test_a_carton_beside_the_middle_is_out_in_time(rule: str) -> None:
    array = ns.load("carton-on-6x6")
    assert isinstance(array, ns.Array)
    found = array.check(rule=rule, at=("1/10", 0)).position
    assert found.verdict == "leaves"
    path = array.simulate((0.1, 0, 0), float(found["after"]), rule=rule)
    away = [math.hypot(row["x"] - 0.1, row["y"]) for row in path.rows()]
    assert max(away) > found["accuracy"]


def test_where_other_wheels_come_under_a_body_within_the_accuracy_nothing_is_said() -> None:
    array = ns.load("carton-on-6x6")
    assert isinstance(array, ns.Array)
    found = array.check(at=("1/10", 0), accuracy="1/8").position
    assert found.verdict == "undecided"
    assert "within the accuracy other wheels come under it" in found.sentence


def loads_open(table: MeasuredTable) -> str:
    return table.toml.replace(f'rule = "{table.rule}"', f'rule = "{table.rule}", loads = "any"')


def three_wheels(off: float) -> MeasuredTable:
    """Three wheels leave no load open, so that the oracle for equal springs knows it."""
    rows = []
    for angle, turn in ((0, off), (120, 0.0), (240, -off / 2)):
        x, y = round(100 * math.cos(math.radians(angle))), round(100 * math.sin(math.radians(angle)))
        rows.append((x, y, round(angle + 180 + turn), 100.0))
    return MeasuredTable(tuple(rows), 0.8, 0.4, "ellipse")


def test_where_loads_are_open_a_body_must_be_carried_farther_than_the_accuracy(tmp_path: Path) -> None:
    near, far = three_wheels(1.0), three_wheels(60.0)
    answers = [position_of(scene_of(tmp_path, loads_open(table))) for table in (near, far)]
    assert [answer.verdict for answer in answers] == [Position.UNDECIDED, Position.LEAVES]
    assert "driven away from the point itself; whether farther than the accuracy" in answers[0].sentence
    assert "under one of the loads" in answers[1].sentence
    accuracy, after = float(answers[1]["accuracy"]), float(answers[1]["after"])
    assert SmallSteps(near).end(np.zeros(2), 5.0, accuracy)[1] < accuracy
    assert SmallSteps(far).end(np.zeros(2), after, accuracy)[1] >= accuracy * (1 - 1e-6)


@pytest.mark.parametrize("rule", ["nearest", "ellipse", "roller"])
def test_no_sampled_motion_turns_faster_than_the_bound(rule: str, tmp_path: Path) -> None:
    table = MeasuredTable.random(5, rule, off=9.0)
    scene = scene_of(tmp_path, table.toml).recentred()
    bound, body, rng = largest_spin(scene, Fraction(20)), SmallSteps(table), np.random.default_rng(0)
    assert bound is not None
    seen = []
    for angle in rng.uniform(0, 2 * math.pi, 30):
        place = 20 * rng.uniform(0.3, 1) * np.array([math.cos(angle), math.sin(angle)])
        seen.append(abs(body.twists(place[None])[0, 2] / body.length))
    assert 0.2 * bound <= max(seen) <= bound


def test_friction_axes_of_their_own_are_followed_by_the_exact_cells() -> None:
    scene = load_scene("omni-3")
    assert driven_out(scene.recentred(), scene.accuracy) is None
    assert largest_spin(scene.recentred(), scene.accuracy) is not None


IN_ONE_CELL = [("nearest", 104), ("box", 128), *(("nearest", seed) for seed in (100, 106, 110, 114, 116))]
TO_ONE_SIDE = [("nearest", 102), ("box", 114), ("nearest", 112), ("nearest", 122), ("box", 116)]


@pytest.mark.parametrize(("rule", "seed"), [*keep(2, IN_ONE_CELL), *keep(1, TO_ONE_SIDE)])
def test_a_body_that_is_carried_out_from_as_near_as_one_likes_leaves(rule: str, seed: int, tmp_path: Path) -> None:
    """One motion leads out of the disc before its cell ends; or all do, on one side of a line through the point."""
    table = MeasuredTable.symmetric(seed, rule)
    scene = scene_of(tmp_path, table.toml)
    answer, accuracy = position_of(scene), float(scene.accuracy)
    assert answer.verdict is Position.LEAVES
    assert "some starts as near as one likes" in answer.sentence
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    starts = 1e-3 * accuracy * np.column_stack([np.cos(angles), np.sin(angles)])
    assert max(SmallSteps(table).end(start, 5.0, accuracy)[1] for start in starts) >= accuracy


@pytest.mark.parametrize("turn", ["1/50", "1/7", "-3/2", "2"])
def test_an_arc_out_of_the_disc_lies_in_the_triangle_that_is_asked(turn: str) -> None:
    """Of speed 1: a body is carried at most twice the radius of its circle away."""
    spin, field, asked = Fraction(turn), NumberField(), list[Any]()

    def holds(corner: Any) -> bool:
        asked.append(corner)
        return True

    polygon = SimpleNamespace(contains=holds)
    twist = Twist(field(Fraction(3, 5)), field(Fraction(4, 5)), field(spin))
    cone: Any = SimpleNamespace(twists=(twist,), inward_normals=(), cell=SimpleNamespace(polygon=polygon))
    for distance in (Fraction(1, 10), Fraction(9, 10), Fraction(6, 5)):
        asked.clear()
        assert _escapes(cone, twist, distance) == (distance * abs(spin) < 2)
        if not asked:
            continue
        tangent, end = (np.array(corner, dtype=float) for corner in asked)
        assert distance < np.hypot(*end) < distance * 1.001
        path = solve_ivp(
            lambda t, c: [0.6 - float(spin) * c[1], 0.8 + float(spin) * c[0]], (0, 3), (0, 0), max_step=0.01, rtol=1e-10
        ).y.T
        inside = path[: np.argmax(np.hypot(*path.T) > float(distance))]
        weights = np.linalg.lstsq(np.stack([tangent, end], axis=1), inside.T, rcond=None)[0]
        assert np.allclose(np.stack([tangent, end], axis=1) @ weights, inside.T, atol=1e-9)
        assert weights.min() >= -1e-9
        assert weights.sum(axis=0).max() <= 1 + 1e-9


@pytest.mark.parametrize(("rule", "seed"), keep(1, TO_ONE_SIDE))
def test_bodies_on_one_side_of_a_line_never_come_back_over_it(rule: str, seed: int, tmp_path: Path) -> None:
    table = MeasuredTable.symmetric(seed, rule)
    scene = scene_of(tmp_path, table.toml).recentred()
    assert is_driven_out_on_one_side(scene, scene.accuracy)
    assert not is_driven_out_on_one_side(scene, Fraction(10**6))
    cells = [(cell.polygon, cell.twists) for cell in build_partition(scene).cells]
    accuracy, body, rng = float(scene.accuracy), SmallSteps(table), np.random.default_rng(0)
    places = accuracy * rng.uniform(-0.7, 0.7, (300, 2))
    velocities = np.array([body.velocity(place) for place in places]).reshape(-1, 2)
    directions = [np.array([float(x) for x in own]) for own in _directions(cells)]
    least = [(velocities[places @ own > 0] @ own).min() for own in directions]
    assert max(least) > 0
