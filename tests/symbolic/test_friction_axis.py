"""Friction axes that are not the rims: constraints against a derivation with SymPy, files, and what is refused."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy

import nonsmooth as ns
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.constraints import Twist, combine, rows_with_friction, scene_rows
from nonsmooth.symbolic.mechanics.contact_states import regular_states, take_census, triples_with_friction
from nonsmooth.symbolic.mechanics.equations import input_symbol, wheel_constraints
from nonsmooth.symbolic.mechanics.free_rollers import free_text, free_twists, with_rims_along_axes
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.mechanics.similar_scenes import moved, scaled
from nonsmooth.symbolic.messages.scene_error import SceneError

SEEDS = range(6)
FRICTION = "[friction]\nmu_roll = 1\nmu_side = '1/2'\n"
REST = "[[wheel]]\nposition = [-1, 1]\n[[wheel]]\nposition = [-1, -1]\n"


def askew(seed: int, count: int = 4, side: str = "1/3") -> Scene:
    """Random places, rims, axes and speeds; every third wheel has no axis of its own."""
    rng = np.random.default_rng(seed)
    wheels = []
    for k in range(count):
        x, y = (int(v) for v in rng.integers(-8, 9, 2))
        (a, b), (c, d) = ([int(v) for v in pair] for pair in rng.integers(-4, 5, (2, 2)))
        place = (x + 20 * (k % 2), y + 20 * (k // 2))
        axis = None if k % 3 == 2 else (c, d or 1)
        wheels.append(ns.Wheel(place, heading=(a or 1, b), speed=int(rng.integers(-3, 4)), axis=axis))
    return ns.Array(wheels, mu_roll=1, mu_side=side, radius=1).scene


def sympy_rows(wheel: Wheel) -> sympy.Matrix:
    """Slip along and across the axis from vectors: the surface runs with ``u d``, the body with ``v + omega J p``."""
    vx, vy, omega, u = sympy.symbols("vx vy omega u", real=True)
    p, rim, axis = (sympy.Matrix([x.to_sympy() for x in v]) for v in (wheel.position, wheel.direction, wheel.grip))
    turn = sympy.Matrix([[0, -1], [1, 0]])
    slip = sympy.Matrix([vx, vy]) + omega * turn * p - u * rim / rim.norm()
    along = axis / axis.norm()
    parts = [(along.T * slip)[0], ((turn * along).T * slip)[0]]
    return sympy.Matrix([[sympy.diff(part, name) for name in (vx, vy, omega, u)] for part in parts])


@pytest.mark.parametrize("seed", SEEDS)
def test_the_constraints_are_those_of_the_slip(seed: int) -> None:
    for wheel in askew(seed).wheels:
        derived = sympy_rows(wheel)
        inputs = wheel_constraints(wheel, symbolic_input=True)
        derived[:, 3] *= input_symbol(wheel.index)
        assert (inputs - derived).applyfunc(sympy.simplify) == sympy.zeros(2, 4)
        at_speed = wheel_constraints(wheel) - derived.subs(input_symbol(wheel.index), wheel.speed.to_sympy())
        assert at_speed.applyfunc(sympy.simplify) == sympy.zeros(2, 4)


@pytest.mark.parametrize("seed", SEEDS)
def test_control_fields_add_up_to_the_twist(seed: int) -> None:
    scene = askew(seed, 3)
    speeds = {wheel.index: wheel.speed for wheel in scene.wheels}
    states = regular_states(scene)
    assert states
    for state in states:
        fields = state.control_fields
        assert tuple(state.twist) == combine([speeds[w] for w in fields], fields.values())


def test_mecanum_wheels_follow_the_textbook() -> None:
    """``u = v_x -+ v_y -+ (l_x + l_y) omega`` for rollers on the ground along the ring (Lynch and Park 2017, 13.2)."""
    scene = load_scene("mecanum-4")
    signs = [(-1, -1), (1, -1), (-1, 1), (1, 1)]
    for vx, vy, omega in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (3, -2, 5)):
        speeds = [vx + a * vy + b * 3 * omega for a, b in signs]
        twist = Twist(*(scene.field(value) for value in (vx, vy, omega)))
        for row, speed in zip(rows_with_friction(scene), speeds, strict=True):
            assert row.residual(twist) + row.rhs == row.gain * speed


@pytest.mark.parametrize("axis", [(-2, -2), (3, 3), "225 deg", "inward"])
def test_an_axis_along_the_rim_is_none(axis: object) -> None:
    wheels = [ns.Wheel(p, heading="inward") for p in ((1, 1), (-1, 1), (-1, -1))]
    own = [ns.Wheel((1, 1), heading="inward", axis=axis), *wheels[1:]]
    plain, named = (ns.Array(group, mu_roll=1, mu_side="1/2", radius="1/4") for group in (wheels, own))
    assert [repr(wheel) for wheel in plain.scene.wheels] == [repr(wheel) for wheel in named.scene.wheels]
    assert named.scene.wheels[0].axis is None


def test_an_axis_has_no_sense() -> None:
    forth, back = (
        ns.Array([ns.Wheel((1, 0), axis=(a, 2 * a)), ns.Wheel((0, 1))], mu_roll=1, mu_side=0).scene for a in (1, -1)
    )
    first, second = ([(*map(str, row.normal), str(row.rhs)) for row in scene_rows(scene)] for scene in (forth, back))
    assert first == second


def test_files_tables_and_python_say_the_same(tmp_path: Path) -> None:
    toml = tmp_path / "scene.toml"
    toml.write_text(
        f"{FRICTION}[[wheel]]\nposition = [1, 1]\naxis = '30 deg'\n"
        "[[wheel]]\nposition = [-1, 1]\naxis = [1, 2]\n[[wheel]]\nposition = [-1, -1]\n"
    )
    (tmp_path / "wheels.csv").write_text('x,y,Axis\n1,1,30 deg\n-1,1,"[1, 2]"\n-1,-1,\n')
    table = tmp_path / "table.toml"
    table.write_text(f"{FRICTION}[wheels]\nfile = 'wheels.csv'\n")
    wheels = [ns.Wheel((1, 1), axis="30 deg"), ns.Wheel((-1, 1), axis=(1, 2)), ns.Wheel((-1, -1))]
    scenes = load_scene(toml), load_scene(table), ns.Array(wheels, mu_roll=1, mu_side="1/2").scene
    axes = [[None if w.axis is None else tuple(map(str, w.axis)) for w in scene.wheels] for scene in scenes]
    assert axes[0] == axes[1] == axes[2]
    assert axes[0][1] == ("-1", "-2")  # towards the heading, inward
    assert axes[0][2] is None


def test_the_axis_of_all_wheels_yields_to_their_own(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(f"{FRICTION}axis = [1, 0]\n[[wheel]]\nposition = [1, 1]\naxis = [0, 1]\n{REST}")
    axes = [wheel.axis and tuple(map(str, wheel.axis)) for wheel in load_scene(file).wheels]
    assert axes == [("0", "-1"), ("1", "0"), ("1", "0")]
    array = ns.Array([ns.Wheel((1, 1)), ns.Wheel((1, 0))], mu_roll=1, mu_side=0).with_(axis=(1, 0))
    first, second = (wheel.axis for wheel in array.scene.wheels)
    assert first is not None
    assert [str(x) for x in first] == ["-1", "0"]
    assert second is None


REFUSED = [
    ("axis = [0, 0]", "wheel[1].axis: required a nonzero direction at wheel 1, position (1, 1)"),
    ("axis = 'rim'", 'wheel[1].axis: required "inward", "outward", an angle such as'),
    ("axis = [1]", "wheel[1].axis: required"),
    ("axis = nan", "wheel[1].axis: required"),
    ("axes = [1, 0]", "wheel[1].axes: required one of the keys"),
]


@pytest.mark.parametrize(("line", "message"), REFUSED)
def test_one_line_says_what_is_wrong(tmp_path: Path, line: str, message: str) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(f"{FRICTION}[[wheel]]\nposition = [1, 1]\n{line}\n{REST}")
    with pytest.raises(SceneError) as caught:
        load_scene(file)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_common_axis_without_direction_names_the_wheel(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(f"{FRICTION}axis = 'inward'\n[[wheel]]\nposition = [0, 0]\nheading = 0\n{REST}")
    with pytest.raises(SceneError, match=r"friction.axis: required a nonzero direction at wheel 1, position \(0, 0\)"):
        load_scene(file)


def test_similar_scenes_keep_their_axes() -> None:
    scene = askew(1)
    for other in (scaled(scene, Fraction(3)), moved(scene, Fraction(1), Fraction(2)), scene.recentred()):
        assert [wheel.axis for wheel in other.wheels] == [wheel.axis for wheel in scene.wheels]


@pytest.mark.parametrize("seed", SEEDS)
def test_free_rollers_are_wheels_with_rims_along_their_axes(seed: int) -> None:
    """The same rows with friction, up to their scale, at the scene's speeds."""
    scene = askew(seed, side="0")
    plain = with_rims_along_axes(scene)
    if plain is None:
        assert any(w.axis is not None and not w.gains[0] for w in scene.wheels)
        return
    for own, other in zip(rows_with_friction(scene), rows_with_friction(plain), strict=True):
        assert own.normal == other.normal
        assert own.rhs == other.rhs
        assert own.unit_normal == other.unit_normal


def test_friction_across_the_axis_or_a_drive_across_it_is_another_wheel() -> None:
    assert with_rims_along_axes(askew(0)) is None
    wheels = [ns.Wheel((1, 0), heading=(1, 0), axis=(0, 1)), ns.Wheel((0, 1))]
    assert with_rims_along_axes(ns.Array(wheels, mu_roll=1, mu_side=0).scene) is None


def test_rows_without_friction_are_no_contact_states() -> None:
    scene = load_scene("mecanum-4")
    assert triples_with_friction(scene) == 4
    assert take_census(scene).possible == len(regular_states(scene)) == 4
    assert all(row.kind == "R" for state in regular_states(scene) for row in state.rows)


def test_free_twists_are_the_kernel_of_the_rows() -> None:
    """Free rollers with all axes through one point do not resist a turn about it, (-J p, 1) from the origin."""
    at = (Fraction(1, 3), 2)
    places = ((1, 1), (-1, 1), (-1, -1))
    wheels = [ns.Wheel(p, axis=(p[0] - at[0], p[1] - at[1]), heading=(1, 0)) for p in places]
    scene = ns.Array(wheels, mu_roll=1, mu_side=0).scene
    (free,) = free_twists(scene)
    assert [str(x) for x in free] == ["2", "-1/3", "1"]
    assert free_text(free_twists(scene)) == "no row with friction resists the motion xi = (2, -1/3, 1)"
    assert free_twists(load_scene("mecanum-4")) == ()
