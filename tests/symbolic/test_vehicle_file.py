"""Vehicle files: what is built, and what is refused in one line; robot descriptions."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.scene_file import builtin_scenes, builtin_systems, builtin_vehicles, load_scene
from nonsmooth.symbolic.files.urdf import read_urdf
from nonsmooth.symbolic.files.vehicle_file import load_vehicle, vehicle_descriptions
from nonsmooth.symbolic.scene_error import SceneError
from nonsmooth.symbolic.vehicles import Vehicle

FRICTION = "[friction]\nmu_roll = 1\nmu_side = 1\n"
SIDES = "[vehicle]\ntrack = 0.6\nwheel_base = 0.5\n"
ROBOT = """<?xml version="1.0"?>
<!-- a comment -->
<robot name="r">
  <link name="base"/>
  {wheels}
  <joint name="mast" type="continuous"><parent link="base"/><child link="m"/><axis xyz="0 0 1"/></joint>
  <link name="m"/>
</robot>
"""
WHEEL = """<joint name="{name}" type="continuous"><parent link="base"/><child link="{name}_link"/>
  <origin xyz="{x} {y} 0.05" rpy="{rpy}"/><axis xyz="{axis}"/></joint>
  <link name="{name}_link"><collision><geometry><cylinder radius="0.1" length="0.04"/></geometry></collision></link>"""
CORNERS = [("fl", "0.25", "0.3"), ("fr", "0.25", "-0.3"), ("rl", "-0.25", "0.3"), ("rr", "-0.25", "-0.3")]


def vehicle(folder: Path, text: str) -> Vehicle:
    file = folder / "v.toml"
    file.write_text(text, encoding="utf-8")
    return load_vehicle(file)


def robot(rpy: str = "0 0 0", axis: str = "0 1 0") -> str:
    wheels = "".join(WHEEL.format(name=name, x=x, y=y, rpy=rpy, axis=axis) for name, x, y in CORNERS)
    return ROBOT.format(wheels=wheels)


def test_names_of_built_in_vehicles_are_files_of_their_own() -> None:
    folder = Path(__file__).resolve().parents[2] / "symbolic" / "scenes" / "vehicles"
    assert sorted(builtin_vehicles()) == sorted(path.stem for path in folder.glob("*.toml"))
    assert not set(builtin_vehicles()) & {*builtin_scenes(), *builtin_systems()}
    assert tuple(vehicle_descriptions()) == builtin_vehicles()
    assert all(load_vehicle(name).name == name for name in builtin_vehicles())


def test_rows_stand_evenly_and_run_at_the_speed_of_their_side(tmp_path: Path) -> None:
    built = vehicle(tmp_path, f"{SIDES}rows = 3\nleft = 2\nright = 3\n{FRICTION}")
    places = [tuple(map(str, wheel.position)) for wheel in built.scene.wheels]
    assert places == [(x, y) for x in ("1/4", "0", "-1/4") for y in ("3/10", "-3/10")]
    assert [str(wheel.speed) for wheel in built.scene.wheels] == ["2", "3"] * 3
    assert (str(built.left), str(built.right)) == ("2", "3")
    assert built.scene.contact.rule == "ellipse"


def test_wheels_of_their_own_leave_no_side_speeds(tmp_path: Path) -> None:
    text = f"{SIDES}{FRICTION}[[wheel]]\nposition = [0.4, 0.1]\nheading = 30\nspeed = 2\n"
    built = vehicle(tmp_path, text)
    assert len(built.scene.wheels) == 5
    assert (built.left, str(built.right)) == (None, "1")
    assert built.turn is None


def test_units_of_speed_are_converted(tmp_path: Path) -> None:
    text = f'[units]\nlength = "m"\nspeed = "cm/s"\n{SIDES}left = 10\nright = 20\n{FRICTION}'
    assert str(vehicle(tmp_path, text).right) == "1/5"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            f"[vehicle]\nwheel_base = 1\n{FRICTION}",
            "vehicle.track: required a track beside wheel_base, received nothing",
        ),
        (f"[vehicle]\n{FRICTION}", "vehicle.wheel_base: required track and wheel_base, or wheels of"),
        (
            f"[vehicle]\ntrack = -1\nwheel_base = 1\n{FRICTION}",
            "vehicle.track: required a positive number, received -1",
        ),
        (f"{SIDES}rows = 1\n{FRICTION}", "vehicle.rows: required"),
        (f"{SIDES}rows = 501\n{FRICTION}", "vehicle.rows: required"),
        (f"{SIDES}speed = 1\n{FRICTION}", "vehicle.speed: required one of"),
        (SIDES, "friction.mu_roll: required a number, since wheel 1 names none"),
        (f"{SIDES}measured = 0\n{FRICTION}", "vehicle.measured: required a positive number"),
        (f"{SIDES}{FRICTION}[grid]\nrows = 2\ncolumns = 2\n", "grid: required one of"),
        (f'{SIDES}{FRICTION}[contact]\nrule = "x"\n', "contact.rule: required"),
        (f'{SIDES}urdf = "../x.urdf"\n{FRICTION}', "vehicle.urdf: required a file in the scene's folder or below it"),
        (f'{SIDES}urdf = "x.urdf"\n{FRICTION}', "vehicle.urdf: required a file, received no such file"),
        (FRICTION, "vehicle: required a vehicle on its own wheels"),
        ('[system]\nstates = ["x"]\nrhs = ["-x"]\n', "vehicle: required a vehicle on its own wheels"),
        ("vehicle = 3\n", "vehicle: required"),
    ],
)
def test_what_cannot_be_used_is_refused(tmp_path: Path, text: str, line: str) -> None:
    with pytest.raises(SceneError) as caught:
        vehicle(tmp_path, text)
    assert line in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_vehicle_is_no_array() -> None:
    with pytest.raises(SceneError, match="husky-a200: vehicle: required an array of wheels"):
        load_scene("husky-a200")


# ---- robot descriptions --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rpy", "axis"), [("0 0 0", "0 1 0"), ("-1.5707963267948966 0 0", "0 0 1"), ("0 0 3.141592653589793", "0 -1 0")]
)
def test_wheels_of_a_robot(tmp_path: Path, rpy: str, axis: str) -> None:
    (tmp_path / "r.urdf").write_text(robot(rpy, axis), encoding="utf-8")
    built = vehicle(tmp_path, f'[vehicle]\nurdf = "r.urdf"\n{FRICTION}')
    places = [tuple(map(float, wheel.position)) for wheel in built.scene.wheels]
    assert places == [(0.25, 0.3), (0.25, -0.3), (-0.25, 0.3), (-0.25, -0.3)]
    assert [str(wheel.speed) for wheel in built.scene.wheels] == ["-1", "1"] * 2
    assert [tuple(map(str, wheel.direction)) for wheel in built.scene.wheels] == [("1", "0")] * 4
    assert (str(built.track), str(built.wheel_base), str(built.wheel_radius)) == ("3/5", "1/2", "1/10")


def test_joints_are_followed_from_the_root() -> None:
    arm = '<joint name="arm" type="fixed"><parent link="base"/><child link="arm"/>'
    arm += '<origin xyz="1 0 0" rpy="0 0 {}"/></joint>'
    wheel = '<joint name="w" type="continuous"><parent link="arm"/><child link="w"/><origin xyz="0.5 0 0"/>'
    text = f'<robot name="r">{arm.format("1.5707963267948966")}{wheel}<axis xyz="0 1 0"/></joint></robot>'
    (found,) = read_urdf(text, "r.urdf", "")
    assert found.position == (Fraction(1), Fraction(1, 2))
    assert found.heading == (Fraction(0), Fraction(1))
    assert found.radius is None


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('<!DOCTYPE robot [<!ENTITY a "b">]><robot>&a;</robot>', "without declarations"),
        ("<robot>", "required a robot description"),
        ("<sdf/>", "required a <robot> of URDF"),
        ("<robot/>", "required continuous joints with level axles, received none"),
        (robot(rpy="0 0"), "required three numbers in rpy"),
        (robot(axis="0 ${y} 0"), "required finite numbers (expand xacro first)"),
        (robot(axis="0 nan 0"), "required finite numbers"),
        (
            ROBOT.format(wheels=WHEEL.format(name="a", x=0, y=0, rpy="0 0 0", axis="0 1 0").replace("base", "a_link")),
            "ring",
        ),
    ],
)
def test_descriptions_that_cannot_be_used(text: str, line: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_urdf(text, "scene.toml", "vehicle.urdf")
    assert line in str(caught.value)


def test_only_level_axles_are_wheels() -> None:
    assert [wheel.joint for wheel in read_urdf(robot(), "r", "")] == ["fl", "fr", "rl", "rr"]
