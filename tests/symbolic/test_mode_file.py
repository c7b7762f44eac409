"""Scene files with modes: what is read, and what is refused in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from nonsmooth.symbolic.files.mode_file import holds_modes, load_modes, mode_descriptions
from nonsmooth.symbolic.files.scene_file import builtin_modes
from nonsmooth.symbolic.files.system_file import load_any
from nonsmooth.symbolic.scene_error import SceneError

GOOD = """
[system]
states = ["x"]
parameters = { k = 2 }
[[mode]]
name = "up"
rhs = ["k"]
leave = { down = "x - k" }
[[mode]]
name = "down"
rhs = ["-k"]
leave = { up = "-x" }
dwell = "1/3"
"""


def test_modes_are_read(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(GOOD, encoding="utf-8")
    system = load_modes(tmp_path / "my.toml")
    assert [mode.name for mode in system.modes] == ["up", "down"]
    assert str(system.modes[1].dwell) == "1/3"
    assert str(system.modes[0].exits[0].guard) == "x - 2"
    assert system.mode("down").exits[0].target == "up"


def test_the_built_in_ones_are_described() -> None:
    assert tuple(mode_descriptions()) == builtin_modes()
    assert all(holds_modes(name) for name in builtin_modes())
    assert not holds_modes("flower")


def test_verdicts_are_about_filippov_systems() -> None:
    with pytest.raises(SceneError, match=r"thermostat: mode: required a Filippov system.*modes are for simulate"):
        load_any("thermostat")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "down"', 'name = "up"', r"mode\[2\]\.name: required another name for each mode, received 'up'"),
        ("leave = { down", "leave = { away", r"mode\[1\]\.leave\.away: required a mode of this file: up, down"),
        ('"x - k"', '"Abs(x) - k"', r"mode\[1\]\.leave\.down: required a guard without sign"),
        ('"x - k"', '"y - k"', r"mode\[1\]\.leave\.down: required a formula of x"),
        ('rhs = ["k"]', 'rhs = ["k", "1"]', r"mode\[1\]\.rhs: required 1 formulas, one for each state, received 2"),
        ('rhs = ["k"]', 'rhs = ["q"]', r"mode\[1\]\.rhs\[1\]: required a formula of x"),
        ('rhs = ["k"]', 'rhs = [["k"], ["1"]]', r"mode\[1\]\.rhs: required one list of formulas"),
        ('dwell = "1/3"', "dwell = -1", r"mode\[2\]\.dwell: required a time that is not negative, received"),
        ('dwell = "1/3"', "wait = 1", r"mode\[2\]\.wait"),
        ('states = ["x"]', 'states = ["x"]\nrhs = ["1"]', r"system\.rhs"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    (tmp_path / "my.toml").write_text(GOOD.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(SceneError, match=message) as refused:
        load_modes(tmp_path / "my.toml")
    assert "\n" not in str(refused.value)
