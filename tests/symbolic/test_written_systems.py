"""Fractions, sines of states and interval parameters: the rewritten field against the formula as it was written."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.system_field import system_field, wave_weight
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.formulas.sine_enclosures import Wave
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.plain import built
from tests.thorough import examples, few

NAMES = {
    **{"sin": math.sin, "cos": math.cos, "sqrt": math.sqrt, "pi": math.pi, "Abs": abs, "Max": max, "Min": min},
    "sign": lambda a: float(np.sign(a)),
    "sgn": lambda a: float(np.sign(a)),
    "relu": lambda a: max(a, 0.0),
}
WRITTEN = [
    "-sin(x) - y",
    "sin(x + pi/3)*y - sin(pi/3)*y",
    "cos(2*x - y) - 1",
    "-sin(x)**2*sgn(y) + cos(x)*sin(y)",
    "x/(1 + x**2) - y",
    "-x/(x - 2) + sgn(x + y)/(3 - y)",
    "Max(x/(2 + y), y)/(1 + Abs(x))",
    "sgn(x/(y - 2)) - 3*relu(y/(1 + x**2))**2",
    "sin(x)/(1 + y**2) - 1/(2 + x) + 1/2",
]


def velocity(system: SwitchedSystem, x: np.ndarray) -> np.ndarray:
    """Of the float field at a point off all surfaces."""
    field = system_field(system)
    signs = tuple(1 if surface.value(x) > 0 else -1 for surface in field.surfaces)
    return np.asarray(field.flow(signs)(0.0, x))


@few(2)
@pytest.mark.parametrize("formula", WRITTEN)
def test_the_float_field_is_the_formula(formula: str) -> None:
    system = built(["y", formula])
    rng = np.random.default_rng(1)
    for x in rng.uniform(-1.5, 1.5, (40, 2)):
        expected = eval(formula, dict(NAMES), {"x": x[0], "y": x[1]})  # noqa: S307 - formulas of this file
        assert velocity(system, x) == pytest.approx([x[1], expected], abs=1e-9)


@few(2)
@pytest.mark.parametrize("formula", [text for text in WRITTEN if "sin" in text or "cos" in text])
def test_right_hand_sides_enclose_the_formula(formula: str) -> None:
    system = built(["y", formula])
    assert system.others
    rng = np.random.default_rng(2)
    for x in rng.uniform(-3, 3, (40, 2)):
        expected = eval(formula, dict(NAMES), {"x": x[0], "y": x[1]})  # noqa: S307
        scale = eval(system.scale.text, dict(NAMES), {"x": x[0], "y": x[1]}) if system.scale else 1  # noqa: S307
        named = {"x": x[0], "y": x[1]}
        values = [eval(member.rhs[1].text, dict(NAMES), named) for member in system.members]  # noqa: S307
        assert min(values) - 1e-9 <= scale * expected <= max(values) + 1e-9


@examples(200)
@given(st.floats(-20, 20), st.sampled_from(["sin", "cos"]))
def test_weights_of_waves_lie_between_zero_and_one(v: float, kind: str) -> None:
    e = wave_weight(Wave(kind, "v"), v)
    assert -1e-9 <= e <= 1 + 1e-9
    if abs(v) < 3:
        enclosed = v - v**3 / 6 + e * v**5 / 120 if kind == "sin" else 1 - v**2 / 2 + v**4 / 24 - e * v**6 / 720
        assert enclosed == pytest.approx(getattr(math, kind)(v), abs=1e-9)


def test_a_sine_of_a_large_argument_is_not_mixed_of_powers() -> None:
    """Beyond it the rounding of ``v^5`` alone would be seen; where it is allowed, the value is right to nine digits."""
    for kind in ("sin", "cos"):
        e = wave_weight(Wave(kind, "v"), 49.0)
        enclosed = 49 - 49**3 / 6 + e * 49**5 / 120 if kind == "sin" else 1 - 49**2 / 2 + 49**4 / 24 - e * 49**6 / 720
        assert enclosed == pytest.approx(getattr(math, kind)(49), abs=1e-8)
        with pytest.raises(RefusalError, match="the argument of a sine is 1e"):
            wave_weight(Wave(kind, "v"), 1e5)


def test_paths_of_numbers_beyond_floats_are_refused() -> None:
    with pytest.raises(RefusalError, match="coefficients within the range of floats"):
        velocity(built(["y", "-x - sin(x*1e300)"]), np.array([0.1, 0.1]))


def test_interval_parameters_stand_for_their_ends() -> None:
    system = built(["y", "-k*x - c*sgn(y)"], {"k": [1, "3/2"], "c": ["1/4", 2]})
    found = {member.rhs[1].text for member in system.members}
    assert len(found) == len(list(itertools.product(range(2), repeat=2)))
    assert not system.written
    twice = built([["y", "-k*x - y"], ["y", "-3*x - y"]], {"k": [1, 2], "unused": [0, 1]})
    assert [member.rhs[1].text for member in twice.members] == ["-1*x - y", "-3*x - y", "-2*x - y"]
    assert twice.intervals == ("k",)


@pytest.mark.parametrize(
    ("rhs", "parameters", "said"),
    [
        (["y", "-x/y"], None, "required denominators that are not zero at the checked point"),
        (["y", "-x/(1 + 1/(1 + y))"], None, "required no fraction and no sine of states in a denominator"),
        (["y", "-x/(1 + sin(x))"], None, "required no fraction and no sine of states in a denominator"),
        (["y", "sin(x - 1)"], None, "system.rhs: required sin and cos of what is zero at the checked point"),
        (["y", "sin(x + 1 + pi)"], None, "up to a multiple of pi, received 'x + 1'"),
        (["y", "sin(x + 1 + pi*sqrt(2))"], None, "system.rhs[2]: required a rational multiple of pi"),
        (["y", "sgn(sin(x))"], None, "system.rhs[2]: required sin and cos of states in sums and products only"),
        (["y", "sin(sin(x))"], None, "system.rhs[2]: required no sine or cosine inside another"),
        (["-sin(x)", "sin(sin(y))"], None, "inside another, received 'sin(sin(y))'"),
        (["sin(x) + sin(2*x) + sin(3*x)", "sin(y) + sin(2*y) + sin(3*y)"], None, "system.rhs: required at most 5"),
        (["sin(x) + sin(2*x) + sin(3*x)", "sin(y) + sin(2*y) + sin(3*y)"], None, "of states, received 6"),
        (["y", "sin(Abs(x))"], None, "required sin and cos of polynomials in the states"),
        (["y", "sin(x)**4*cos(y)**3"], None, "system.rhs[2]: required at most 5 sines and cosines of states"),
        (["y", "-x/k"], {"k": [1, 2]}, "system.rhs[2]: required a formula that is affine in the interval parameter k"),
        (["y", "-Abs(k)*x"], {"k": [1, 2]}, "required a formula that is affine"),
        (["y", "-k*x"], {"k": [2, 1]}, "system.parameters.k: required an interval of two rational numbers"),
        (["y", "-k*x"], {"k": [1]}, "system.parameters.k: required an interval of two rational numbers"),
        (["y", "-k*x"], {"x": [1, 2]}, "system.parameters.x: required a name that is no state and no function"),
    ],
)
def test_bad_input_in_one_line(rhs: list[str], parameters: dict[str, Any] | None, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        built(rhs, parameters)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_sine_must_vanish_at_the_checked_point() -> None:
    with pytest.raises(SceneError, match="zero at the checked point"):
        built(["y", "-sin(x)"], equilibrium=[1, 0])
    assert decide_system(built(["y", "-sin(x - 1) - y"], equilibrium=[1, 0])).verdict == "asymptotically stable"
