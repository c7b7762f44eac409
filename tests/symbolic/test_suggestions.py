"""Messages that guess what was meant."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import BAD_INPUT, run
from nonsmooth.symbolic.files.scene_values import read_exact
from nonsmooth.symbolic.files.start_values import read_start_angle
from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.messages.scene_error import RULES, is_meant

SCENE = """
name = "guess"
[friction]
mu_roll = 1
{side} = 0.5
[[wheel]]
position = [1, 0]
heading = "inward"
speed = 1
[contact]
rule = "{rule}"
"""


def test_every_other_name_of_a_rule_is_one_of_ours() -> None:
    assert set(RULES.values()) <= set(CONTACT_RULES)
    assert not set(RULES) & set(CONTACT_RULES)


@pytest.mark.parametrize(
    ("given", "known", "meant"),
    [
        ("mu_syde", ["mu_roll", "mu_side"], " (is mu_side meant?)"),
        ("Omni-wheels", list(CONTACT_RULES), " (is roller meant?)"),
        ("omni", ["nearest", "box"], ""),
        ("frog", list(CONTACT_RULES), ""),
        ("weight", ["height", "mass", "width"], " (is mass meant?)"),
        ("weight", ["height", "width"], " (is height meant?)"),
        ("direction", ["heading", "speed"], " (is heading meant?)"),
        (7, list(CONTACT_RULES), ""),
        ("x" * 10**6, ["x"], ""),
    ],
)
def test_what_is_meant(given: object, known: list[str], meant: str) -> None:
    assert is_meant(given, known) == meant


@pytest.mark.parametrize(
    ("side", "rule", "said"),
    [("mu_syde", "nearest", "(is mu_side meant?)"), ("mu_side", "omni", "(is roller meant?)")],
)
def test_a_scene_is_refused_with_a_guess(
    side: str, rule: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "guess.toml"
    file.write_text(SCENE.format(side=side, rule=rule))
    assert run(app, ["check", str(file)]) == BAD_INPUT
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("15 %", '(for 15 % write "15/100")'),
        ("15%", '(for 15 % write "15/100")'),
        ("4 kg", "mass in kg (is 4 meant?)"),
        ("0.5m", "(is 0.5 meant?)"),
        ("0.25 m/s", "(is 0.25 meant?)"),
        ("4 cats", 'a formula such as "sqrt(2)/2"'),
    ],
)
def test_a_number_with_a_unit_is_told_what_to_write(text: str, hint: str) -> None:
    with pytest.raises(ExpressionError, match=re.escape(hint)):
        read_exact(text)


def test_options_guess_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["check", "four-wheel", "--rule", "mecanum"]) == BAD_INPUT
    assert "(is roller meant?)" in capsys.readouterr().err
    assert run(app, ["derive", "four-wheel", "-o", "report.pdf"]) == BAD_INPUT
    assert "(pdflatex makes a .pdf of a .tex)" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "value"),
    [("30deg", math.pi / 6), (" -90 deg", -math.pi / 2), ("0.5 rad", 0.5), ("0 deg", 0.0), ("pi/6", math.pi / 6)],
)
def test_angles_may_name_their_unit(text: str, value: float) -> None:
    assert abs(read_start_angle(text) - value) <= math.ulp(value)
