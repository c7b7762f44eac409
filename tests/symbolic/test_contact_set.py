"""The wheels that carry a body, and loads that are measured at one pose."""

from __future__ import annotations

import math
import random
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from flint import arb
from scipy.spatial import ConvexHull

from nonsmooth.analysis.bodies.sampled_tables import drawn_model
from nonsmooth.proofs.boxes.balanced_forces import load_box
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Disc
from nonsmooth.symbolic.mechanics.contact_set import TipsError, alone, contact_set, standing
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.mechanics.springs import NoSpringsError, carried_table, centre_of
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.springs import pressed
from tests.thorough import few

# ---- The wheels that carry a body, and how far it may move: against places turned and shifted one by one, in floats.

GRID = "[friction]\nmu_roll = 1\nmu_side = 0.5\n[grid]\nrows = 6\ncolumns = 6\npitch = 1\n"
BOX = '[body]\nshape = "rectangle"\nwidth = 2.6\nheight = 1.6\n'


def scene_of(folder: Path, text: str, at: str = "0,0") -> Scene:
    file = folder / "scene.toml"
    file.write_text(GRID + text)
    return load_scene(file, at=at)


def covered(scene: Scene, shift: tuple[float, float], turn: float) -> set[int]:
    """The wheels under a moved body, by the definition, in floats: the hull of its turned corners, or the disc."""
    body = scene.body
    assert body is not None
    c, s = (float(entry) for entry in body.heading)
    heading = np.array([[c, -s], [s, c]])
    spin = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    at = np.array([float(entry) for entry in scene.check.equilibrium]) + shift
    middle = at + spin @ heading @ np.array([float(entry) for entry in body.centre])
    places = {w.index: np.array([float(x) for x in w.position]) for w in (*scene.wheels, *scene.idle)}
    if isinstance(body.outline, Disc):
        radius = float(body.outline.radius)
        return {index for index, place in places.items() if np.hypot(*(place - middle)) < radius}
    corners = np.array([[float(x) for x in v] for v in body.outline.vertices]) @ (spin @ heading).T + middle
    sides = ConvexHull(corners).equations
    return {index for index, place in places.items() if (sides[:, :2] @ place + sides[:, 2] < 0).all()}


SHAPES = [
    BOX,
    f"{BOX}heading = 30\n",
    f"{BOX}centre_of_mass = [0.3, -0.2]\nheading = 77\n",
    '[body]\nshape = "disc"\nradius = 1.3\n',
    '[body]\nshape = "disc"\nradius = 1.7\ncentre_of_mass = ["1/4", "-1/3"]\n',
    '[body]\nshape = "polygon"\nvertices = [[-1, -1], [2, -1.25], [1.5, 1], [0, 1.75]]\nheading = 10\n',
]


@few(1)
@pytest.mark.parametrize("shape", SHAPES)
def test_the_wheels_under_a_body_and_its_margins(shape: str, tmp_path: Path) -> None:
    draw = random.Random(3)
    seen = 0
    tipping: TipsError | None
    for _ in range(12):
        at = f"{draw.randint(-199, 199)}/101,{draw.randint(-199, 199)}/101"
        scene = scene_of(tmp_path, shape, at)
        try:
            stands = standing(scene)
        except TipsError as error:
            tipping = error
        else:
            tipping = None
            seen += 1
        if tipping is not None:
            assert set(tipping.carrying) == covered(scene, (0, 0), 0)
            continue
        found, here = contact_set(stands), covered(stands, (0, 0), 0)
        assert set(found.wheels) == here == {wheel.index for wheel in stands.wheels}
        assert len(stands.wheels) + len(stands.idle) == 36
        assert found.margin is not None
        width = float(stands.check.radius)
        for _ in range(60):
            share, angle = draw.uniform(0, 0.999), draw.uniform(0, 2 * math.pi)
            r = share * float(found.margin)
            turn = 0.0 if found.angle is None else (0.999 - share) * float(found.angle) * draw.choice((-1, 1))
            assert covered(stands, (r * math.cos(angle), r * math.sin(angle)), turn) == here
            square = draw.uniform(-0.999, 0.999) * width, draw.uniform(-0.999, 0.999) * width
            assert covered(stands, square, 0) == here
    assert seen >= 6


@few(1)
@pytest.mark.parametrize("shape", SHAPES)
def test_the_margin_is_the_largest(shape: str, tmp_path: Path) -> None:
    stands = standing(scene_of(tmp_path, shape, "0.05,0.07"))
    found, here = contact_set(stands), covered(stands, (0, 0), 0)
    assert found.margin is not None
    r = 1.001 * float(found.margin)
    turns = np.linspace(0, 2 * math.pi, 2000)
    assert any(covered(stands, (r * math.cos(a), r * math.sin(a)), 0) != here for a in turns)


def test_the_square_of_a_stated_radius_is_cut_where_a_wheel_enters(tmp_path: Path) -> None:
    stands = standing(scene_of(tmp_path, f"{BOX}[check]\nradius = 1\n"))
    assert str(stands.check.radius) == "1/5"
    assert str(contact_set(stands).margin) == "1/5"
    assert str(stands.check.wider) == "1"
    within = standing(scene_of(tmp_path, f'{BOX}[check]\nradius = "1/9"\n')).check
    assert (str(within.radius), within.wider) == ("1/9", None)
    assert standing(scene_of(tmp_path, BOX)).check.wider is None


def test_a_wheel_under_the_edge_is_named_with_the_way_out(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"wheel 17 under its edge: a small shift along \(8/5, 0\)"):
        standing(scene_of(tmp_path, BOX, "0.2,0"))


@pytest.mark.parametrize(
    ("at", "why"),
    [
        ("2.9,2.9", "wheel 36 alone under it"),
        ("3,0", "wheels 18 and 24 alone under it"),
        ("5,5", "no wheel under it"),
        ("2.6,0.05", "line through wheels 18 and 24"),
        ("2.5,0.05", "line through wheels 18 and 24"),  # on that line
    ],
)
def test_bodies_that_tip(at: str, why: str, tmp_path: Path) -> None:
    with pytest.raises(TipsError, match=why):
        standing(scene_of(tmp_path, BOX, at))


def test_wheels_on_one_line(tmp_path: Path) -> None:
    with pytest.raises(TipsError, match="all 4 wheels under it on one line"):
        standing(scene_of(tmp_path, '[body]\nshape = "rectangle"\nwidth = 3.6\nheight = 0.4\n', "0,0.5"))


def test_tables_of_loads_ask_for_all_wheels(tmp_path: Path) -> None:
    table = "[contact]\nloads = [" + ", ".join(['["1/36", 0, 0]'] * 36) + "]\n"
    with pytest.raises(SceneError, match=r"contact\.loads"):
        standing(scene_of(tmp_path, BOX + table))


def test_an_array_of_its_own_is_numbered_anew(tmp_path: Path) -> None:
    own = alone(scene_of(tmp_path, BOX))
    assert [wheel.index for wheel in own.wheels] == [1, 2, 3, 4]
    assert own.body is None
    assert standing(own) == own == alone(own)


def test_polygons_with_a_corner_that_turns_inward(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"body.vertices: required a convex polygon"):
        scene_of(tmp_path, '[body]\nshape = "polygon"\nvertices = [[0, 0], [2, 0], [2, 2], [1, 0.5], [0, 2]]\n')


# ---- Loads measured at one pose and carried to others, against springs of unequal height that are pressed there.

ROUNDING = 1e-9


@pytest.mark.parametrize("seed", range(12))
def test_springs_of_unequal_height_are_predicted_while_none_lifts(seed: int) -> None:
    rng, field = np.random.default_rng(seed), NumberField()
    count = int(rng.integers(3, 9))
    places = np.concatenate([[(2, 1), (-2, 1), (0, -2)], rng.integers(-3, 4, (count - 3, 2))])
    moments = np.column_stack([np.ones(count), places])
    heights = rng.uniform(-0.1, 0.1, count) / count
    measured = pressed(moments, heights, np.ones(count), (0.1, -0.05))
    exact = [field(Fraction(load)) for load in measured]
    table = carried_table(exact, [(field(int(x)), field(int(y))) for x, y in places])
    rows = np.array([[float(entry) for entry in row] for row in table.rows])
    for centre in ((0.1, -0.05), (0.0, 0.0), (-0.15, 0.2)):
        loads = pressed(moments, heights, np.ones(count), centre)
        if loads.min() > 0:
            np.testing.assert_allclose(rows @ [1, *centre], loads, atol=ROUNDING)


def test_sum_and_moments_balance_exactly_everywhere() -> None:
    field = NumberField()
    places = [(field(x), field(y)) for x, y in ((1, 1), (-1, 1), (-1, -2), (1, -1), (0, 0))]
    values = [field(k) for k in (3, 1, 4, 1, 5)]
    rows = carried_table(values, places).rows
    assert [sum(row[k] for row in rows) for k in range(3)] == [1, 0, 0]
    for axis in (0, 1):
        moment = [sum(row[k] * p[axis] for row, p in zip(rows, places, strict=True)) for k in range(3)]
        assert moment == [0, int(axis == 0), int(axis == 1)]
    x, y = centre_of(values, places)
    assert [a + b * x + c * y for a, b, c in rows] == [value / 14 for value in values]


@pytest.mark.parametrize("seed", range(4))
def test_tolerances_of_positions_hold_the_measured_loads_of_wheels_that_stand_elsewhere(
    seed: int, tmp_path: Path
) -> None:
    """Their centre is off with the wheels; loads were taken to be those of the wheels as drawn."""
    scene, rng = (
        load_scene(str(four(tmp_path, '{kind = "measured", values = [1, 2, 1, 3]}'))),
        np.random.default_rng(seed),
    )
    off, field = Fraction(1, 100), scene.field
    loads = load_box(scene, arb(off.numerator) / off.denominator)
    corners = rng.choice([-1, 1], (4, 2)) if seed else np.ones((4, 2), int)
    moved = [(x + off * int(a), y + off * int(b)) for (x, y), (a, b) in zip(scene.positions, corners, strict=True)]
    own = carried_table([field(k) for k in (1, 2, 1, 3)], moved)
    assert loads is not None
    for place in ((0, 0), (Fraction(1, 10), Fraction(-1, 5))):
        values = [float(a + b * place[0] + c * place[1]) for a, b, c in own.rows]
        held = loads.at([arb(Fraction(entry).numerator) / Fraction(entry).denominator for entry in place])
        assert all(arb(value, 2.0**-40).overlaps(ball) for value, ball in zip(values, held, strict=True))
        assert max(float(ball.rad()) for ball in held) < 0.05


def test_drawn_tables_carry_the_measured_loads_where_their_wheels_stand(tmp_path: Path) -> None:
    scene = load_scene(str(four(tmp_path, '{kind = "measured", values = [1, 2, 1, 3]}')))
    field = scene.field
    box = Tolerance(field(Fraction(1, 50)), Fraction(0), field(0), field(0), field(0), field(0))
    model = drawn_model(scene, box, np.random.default_rng(3))
    places = [(field(Fraction(x)), field(Fraction(y))) for x, y in model.positions.tolist()]
    rows = carried_table([field(k) for k in (1, 2, 1, 3)], places).rows
    assert model.load_table == pytest.approx(np.array([[float(entry) for entry in row] for row in rows]), abs=ROUNDING)


def test_wheels_on_a_line_are_refused() -> None:
    field = NumberField()
    with pytest.raises(NoSpringsError):
        carried_table([field(1)] * 3, [(field(k), field(0)) for k in range(3)])


def four(tmp_path: Path, loads: str) -> Path:
    text = "[friction]\nmu_roll = 1\nmu_side = 1\n"
    text += "".join(f"[[wheel]]\nposition = {place}\n" for place in ("[1, 1]", "[-1, 1]", "[-1, -1]", "[1, -1]"))
    path = tmp_path / "four.toml"
    path.write_text(f'{text}[contact]\nrule = "ellipse"\nloads = {loads}\n', encoding="utf-8")
    return path


def test_a_pose_that_does_not_balance_the_values_is_refused(tmp_path: Path) -> None:
    """At (0, 0) each load would change by 1/14 of the weight, 2/7 of the mean load."""
    values = "values = [1, 2, 1, 3]"
    with pytest.raises(SceneError, match=r"contact.loads.at: required \(0.142857, -0.142857\)"):
        load_scene(str(four(tmp_path, f'{{kind = "measured", {values}, at = [0, 0]}}')))
    for keys in ("at = [0, 0], within = 0.3", 'at = ["1/7", -0.14]'):
        assert load_scene(str(four(tmp_path, f'{{kind = "measured", {values}, {keys}}}')))
