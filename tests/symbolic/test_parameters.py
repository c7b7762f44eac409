"""Named parameters of plain systems: complete formulas, and one line for what cannot be used."""

from __future__ import annotations

from pathlib import Path

import pytest

import nonsmooth as ns
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.messages.scene_error import SceneError

STATES = 'states = ["x", "v"]\n'


def written(folder: Path, rhs: str, parameters: str, check: str = "") -> Path:
    file = folder / "my.toml"
    file.write_text(f"[system]\n{STATES}rhs = {rhs}\nparameters = {parameters}\n[check]\n{check}", encoding="utf-8")
    return file


def test_formulas_are_complete_and_mean_the_same(tmp_path: Path) -> None:
    rhs = '["v", "-k1*sign(x) - k*v*1e1"]'
    system = load_system(written(tmp_path, rhs, '{ k = 0.5, k1 = "sqrt(2)" }', 'lyapunov = "k1*Abs(x) + v**2/2"'))
    assert [side.text for side in system.rhs] == ["v", "-(sqrt(2))*sign(x) - 0.5*v*1e1"]
    assert system.check.lyapunov.text == "(sqrt(2))*Abs(x) + v**2/2"
    velocity = system.velocity(lambda surface: 1)
    assert float(velocity[1]([system.field(1), system.field(2)])) == pytest.approx(-(2**0.5) - 10)


@pytest.mark.parametrize(
    ("parameters", "key"),
    [
        ("{ x = 1 }", "system.parameters.x"),
        ("{ sign = 1 }", "system.parameters.sign"),
        ('{ k = "x" }', "system.parameters.k"),
        ('{ k = "1/0" }', "system.rhs"),
        ("{ k = [1] }", "system.parameters.k"),
        ('{ "k k" = 1 }', "system.parameters.k k"),
        ("3", "system.parameters"),
        ("{ other = 1 }", "system.rhs"),
        ("{ k = \"__import__('os')\" }", "system.parameters.k"),
    ],
)
def test_what_cannot_be_used_is_said_in_one_line(tmp_path: Path, parameters: str, key: str) -> None:
    with pytest.raises(SceneError) as raised:
        load_system(written(tmp_path, '["v", "-k*x - v"]', parameters))
    assert f"my.toml: {key}" in str(raised.value)
    assert "\n" not in str(raised.value)


def test_python_changes_some_of_them() -> None:
    system = ns.System(["x", "v"], ["v", "-k*x - c*v"], parameters={"k": 2, "c": 1})
    assert system.check().verdict == "asymptotically stable"
    assert system.with_(parameters={"c": -1}).check().verdict == "unstable"
