"""Vehicle files: what is built, and what is refused in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from nonsmooth.symbolic.files.documents import builtin_scenes, builtin_systems, builtin_vehicles
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.vehicle_file import load_vehicle, vehicle_descriptions
from nonsmooth.symbolic.mechanics.vehicles import Vehicle
from nonsmooth.symbolic.messages.scene_error import SceneError

FRICTION = "[friction]\nmu_roll = 1\nmu_side = 1\n"
SIDES = "[vehicle]\ntrack = 0.6\nwheel_base = 0.5\n"


def vehicle(folder: Path, text: str) -> Vehicle:
    file = folder / "v.toml"
    file.write_text(text, encoding="utf-8")
    return load_vehicle(file)


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
