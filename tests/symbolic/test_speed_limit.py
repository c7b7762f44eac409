"""``speed_limit`` of scene files: for all wheels, for one, in a CSV table; in units; and what is refused."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

import nonsmooth as ns
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import BAD_INPUT, run
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.similar_scenes import moved, scaled
from nonsmooth.symbolic.messages.scene_error import SceneError

HEAD = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n'
RING = "[ring]\ncount = 3\n"
SLOW = '[field]\nkind = "radial"\nspeed = "1/10"\n'
TWO = "[[wheel]]\nposition = [1, 0]\nspeed_limit = 2\n[[wheel]]\nposition = [0, 2]\n[[wheel]]\nposition = [-1, -1]\n"


def scene_of(tmp_path: Path, text: str, table: str = "") -> Path:
    (tmp_path / "w.csv").write_text(table, encoding="utf-8")
    file = tmp_path / "s.toml"
    file.write_text(HEAD + text, encoding="utf-8")
    return file


def limits(file: Path) -> list[Fraction | None]:
    found = []
    for wheel in load_scene(file).wheels:
        rational = None if wheel.speed_limit is None else wheel.speed_limit.as_rational()
        found.append(None if rational is None else Fraction(int(rational.p), int(rational.q)))
    return found


def test_there_is_none_unless_stated(tmp_path: Path) -> None:
    file = scene_of(tmp_path, RING)
    assert limits(file) == [None] * 3
    assert load_scene(file).speed_limits == {}


def test_for_all_wheels_and_for_one(tmp_path: Path) -> None:
    assert limits(scene_of(tmp_path, f"{RING}[drive]\nspeed_limit = 1.5\n")) == [Fraction(3, 2)] * 3
    assert limits(scene_of(tmp_path, f"{TWO}[drive]\nspeed_limit = 3\n")) == [2, 3, 3]
    assert limits(scene_of(tmp_path, TWO)) == [2, None, None]


def test_in_a_table(tmp_path: Path) -> None:
    table = "x,y,speed_limit\n1,0,2\n0,1,\n-1,-1,5/2\n"
    assert limits(scene_of(tmp_path, '[wheels]\nfile = "w.csv"\n', table)) == [2, None, Fraction(5, 2)]


def test_in_the_files_unit_of_speed(tmp_path: Path) -> None:
    units = '[units]\nlength = "mm"\nspeed = "m/s"\n'
    file = scene_of(tmp_path, f"{RING}{SLOW}{units}[drive]\nspeed_limit = 0.25\n")
    assert limits(file) == [250] * 3


def test_from_python_and_in_similar_scenes() -> None:
    array = ns.Array.ring(3, mu_roll=1, mu_side="1/2", speed_limit="3/2")
    one = array.scene.field.one
    assert array.scene.speed_limits == {k: one * Fraction(3, 2) for k in (1, 2, 3)}
    assert scaled(array.scene, Fraction(7)).speed_limits == array.scene.speed_limits
    assert moved(array.scene, Fraction(1), Fraction(2)).recentred().speed_limits == array.scene.speed_limits
    wheels = [ns.Wheel(p, speed_limit=2) for p in ((1, 0), (0, 1))]
    mixed = ns.Array([*wheels, ns.Wheel((-1, -1))], mu_roll=1, mu_side=1).scene.speed_limits
    assert {index: float(limit) for index, limit in mixed.items()} == {1: 2, 2: 2}


def test_a_speed_at_its_limit_is_within_it(tmp_path: Path) -> None:
    assert limits(scene_of(tmp_path, f"{RING}[drive]\nspeed_limit = 1\n")) == [1] * 3
    magnitude = '[field]\nkind = "radial"\nspeed = "magnitude"\n[ring]\ncount = 3\nradius = "sqrt(2)"\n'
    assert load_scene(scene_of(tmp_path, f'{magnitude}[drive]\nspeed_limit = "sqrt(2)"\n')).speed_limits


REFUSED = [
    (f"{RING}[drive]\nspeed_limit = 0\n", "drive.speed_limit: required a positive number, received 0"),
    (f"{RING}[drive]\nspeed_limit = -1\n", "drive.speed_limit: required a positive number, received -1"),
    (f"{RING}[drive]\nspeed_limit = nan\n", "drive.speed_limit: required"),
    (f"{RING}[drive]\nspeed_limit = inf\n", "drive.speed_limit: required"),
    (f'{RING}[drive]\nspeed_limit = "fast"\n', "drive.speed_limit: required"),
    (f"{RING}[drive]\nspeed_limit = true\n", "drive.speed_limit: required"),
    (f"{RING}[drive]\nspeed_limit = [1, 2]\n", "drive.speed_limit: required"),
    (f'{RING}[drive]\nspeed_limit = "1 - sqrt(2)"\n', "drive.speed_limit: required a positive number"),
    (f"{RING}[drive]\nlimit = 1\n", "drive.limit: required one of the keys speed_limit, received an unknown key"),
    (f"drive = 1\n{RING}", "drive: required a table"),
    (f"{TWO}speed_limit = 0\n", "wheel[3].speed_limit: required a positive number, received 0"),
    (f"{RING}speed_limit = 1\n", "ring.speed_limit: required one of the keys"),
    # the array's own speeds
    (f"{RING}[drive]\nspeed_limit = 0.5\n", "field.speed: required at wheel 1 a speed within its speed_limit 1/2, "),
    (
        f"{TWO}speed = -3\nspeed_limit = 2\n",
        "wheel[3].speed: required at wheel 3 a speed within its speed_limit 2, rec",
    ),
    (f'{TWO}heading = "inward"\nspeed_limit = 0.5\n', "wheel[3].speed: required at wheel 3 a speed within its speed_l"),
    (
        f'{RING}[field]\nkind = "radial"\nspeed = "magnitude"\n[drive]\nspeed_limit = "9/10"\n',
        "field.speed: required at wheel 1 a speed within its speed_limit 9/10, received 1",
    ),
    (
        f'{RING}{SLOW}[units]\nlength = "mm"\nspeed = "m/s"\n[drive]\nspeed_limit = "1/20"\n',
        "field.speed: required at wheel 1 a speed within its speed_limit 50 mm/s, received 100 mm/s",
    ),
]


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_bad_values_end_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, message: str
) -> None:
    # keys of the top table come before all others
    document = text + HEAD if text.startswith("drive") else HEAD + text
    file, output = tmp_path / "s.toml", tmp_path / "path.csv"
    file.write_text(document, encoding="utf-8")
    with pytest.raises(SceneError):
        load_scene(file)
    assert run(app, ("simulate", str(file), "--from", "0,0,0", "-o", str(output))) == BAD_INPUT
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.removeprefix(f"nonsmooth: {file}: ").startswith(message), err
    assert not output.exists()


def test_bad_cells_of_a_table_name_their_line(tmp_path: Path) -> None:
    for cell, message in (("0", "w.csv:3.speed_limit: required a positive number"), ("x", "w.csv:3.speed_limit: requ")):
        table = f"x,y,speed_limit\n1,0,2\n0,1,{cell}\n-1,-1,2\n"
        with pytest.raises(SceneError) as caught:
            load_scene(scene_of(tmp_path, '[wheels]\nfile = "w.csv"\n', table))
        assert message in str(caught.value)
