"""The feedback clause as a user meets it: on the terminal, in JSON, in reports, in simulations and certificates."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.number_text import lower_text
from tests.reports.conftest import Invoke
from tests.thorough import few

START = ("--from", "0.1,0.05,0.3")


# ---- what is certified is shown from below -------------------------------------------------------


@pytest.mark.parametrize("digits", [1, 3, 4])
def test_a_shown_bound_is_not_above_the_exact_one(digits: int) -> None:
    field = load_scene("four-wheel").field
    for value in (Fraction(18398, 100_000), Fraction(2, 3), Fraction(1), Fraction(999_999, 10**6), Fraction(3, 10**20)):
        for number in (value, field(value), field(value) * field.sqrt(2)):
            exact = float(number)
            shown = Fraction(lower_text(number, digits))
            assert not number < shown if isinstance(number, Fraction) else (number - shown).sign() >= 0
            assert exact * (1 - 2 * 10.0 ** (1 - digits)) <= float(shown) <= exact * (1 + 1e-15)


@few(1)
@pytest.mark.parametrize(("name", "rule"), [("rectangle", "ellipse"), ("grid-4x4", "box"), ("spiral-30", "box")])
def test_rates_and_reaches_on_the_terminal_are_true(invoke: Invoke, name: str, rule: str) -> None:
    record = invoke("check", name, "--rule", rule, "--json").record["feedback"]
    text = " ".join(invoke("check", name, "--rule", rule, "--evidence").out.replace("│", " ").split())
    rate = Fraction(text.split("V' <= -")[1].split(" k V")[0])
    assert rate <= Fraction(record["exact"]["rate"])
    assert Fraction(text.split("V' <= -")[1].split(" k V")[0]) > 0
    if rule == "box":
        assert float(text.split("|x|, |y| < ")[1].split(":")[0]) <= record["rate_reach"]


# ---- simulate ------------------------------------------------------------------------------------


def test_the_cascade_is_followed(invoke: Invoke) -> None:
    common = ("simulate", "conveyor-3", *START, "--until", "60", "--feedback", "--json")
    slow = invoke(*common, "--law", "cascade").record
    assert slow["feedback"] == "cascade"
    assert max(map(abs, slow["end"]["state"])) < 0.02
    stuck = invoke(*common, "--law", "gradient").record
    assert abs(stuck["end"]["state"][0]) > 0.1


# ---- reports -------------------------------------------------------------------------------------


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@few(1)
@pytest.mark.parametrize(
    ("name", "rule", "words"),
    [
        ("conveyor-3", "nearest", ("(r, s) = (c . p_i, c . J p_i)/|p_i|", "u_w = d_w . (v + omega J p_w)", "like 1/t")),
        ("four-wheel", "box", ("0 to 90 degrees", "270 to 360 degrees", "xi = -k (g . xi_l) xi_l")),
        ("spiral-30", "ellipse", ("near c*", "xi = -k (g . xi_l) xi_l")),
        ("differential-drive", "box", ("no static feedback stabilizes", "V' = 0 for every input")),
    ],
)
def test_the_report_states_the_law(
    invoke: Invoke, tmp_path: Path, name: str, rule: str, words: tuple[str, ...]
) -> None:
    path = tmp_path / "report.json"
    invoke("derive", name, "--rule", rule, "--only", "theorem,feedback", "-o", str(path))
    text = path.read_text(encoding="utf-8")
    for expected in words:
        assert expected in text, expected


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_an_array_with_contracting_turns_has_a_table_of_signs(invoke: Invoke, tmp_path: Path) -> None:
    """The four-wheel array with rims turned by 46.4 degrees: no quadratic V, but turns that contract."""
    scene = tmp_path / "turned.toml"
    wheels = "".join(
        f"[[wheel]]\nposition = [{x}, {y}]\nheading = [{21 * y - 20 * x}, {-21 * x - 20 * y}]\n"
        for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    )
    head = 'friction = { mu_roll = 1, mu_side = "1/2" }\ncheck = { equilibrium = [0, 0], radius = "1/2" }\n'
    scene.write_text('name = "turned"\n' + head + wheels, encoding="utf-8")
    path = tmp_path / "report.json"
    assert invoke("check", str(scene), "--json").record["feedback"]["cascade"]["descent"] == "full turns that contract"
    invoke("derive", str(scene), "--only", "theorem,feedback", "-o", str(path))
    assert "which multiply |c| by" in path.read_text(encoding="utf-8")


# ---- certificates --------------------------------------------------------------------------------


def test_a_clause_that_the_certificate_leaves_open_is_named(invoke: Invoke, tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    outcome = invoke("check", "four-wheel", "--rule", "box", "--certificate", str(path))
    assert "feedback stands as undecided" in outcome.err
    assert invoke("check", "ring-3", "--rule", "box", "--certificate", str(path)).err == ""
    assert invoke("verify", str(path)).status == 0
