"""Sign fields of formulas against the formulas themselves, read as Python would."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.fields.equations_field import build_sign_field
from nonsmooth.analysis.fields.smooth_field import DIFFERENCE_STEP, Vector
from nonsmooth.symbolic.files.equations_file import load_equations

ROUNDING = 1e-13  # of polynomials of degree three at states of size two
DIFFERENCE = 1e-8  # of central differences

FORMULAS: list[tuple[list[str], list[str], Callable[[Vector], list[float]]]] = [
    (["x"], ["-x*sign(x - 1)"], lambda s: [-s[0] * np.sign(s[0] - 1)]),
    (
        ["x", "v"],
        ["v", "-x - Abs(v)*v/2 - sign(x*v)"],
        lambda s: [s[1], -s[0] - abs(s[1]) * s[1] / 2 - np.sign(s[0] * s[1])],
    ),
    (
        ["x", "y", "z"],
        ["sign(x + Abs(y - z))", "x*y*z - sqrt(2)*sign(x**2 + y**2 - z)", "3"],
        lambda s: [
            np.sign(s[0] + abs(s[1] - s[2])),
            s[0] * s[1] * s[2] - np.sqrt(2) * np.sign(s[0] ** 2 + s[1] ** 2 - s[2]),
            3.0,
        ],
    ),
]


@pytest.mark.parametrize(("states", "rhs", "value"), FORMULAS)
def test_the_flow_of_the_signs_at_a_state_is_the_formula(
    states: list[str], rhs: list[str], value: Callable[[Vector], list[float]], tmp_path: Path
) -> None:
    file = tmp_path / "my.toml"
    file.write_text(f"[system]\nstates = {states}\nrhs = {rhs}\n")
    field = build_sign_field(load_equations(file), [1.0] * len(states))
    rng = np.random.default_rng(7)
    for state in rng.uniform(-2, 2, (200, len(states))):
        found = field.flow(field.signs_at(state))(0.0, state)
        assert found == pytest.approx(value(state), abs=ROUNDING)
        for surface in field.surfaces:
            for k, slope in enumerate(surface.gradient(state)):
                step = DIFFERENCE_STEP * np.eye(len(states))[k]
                change = (surface.value(state + step) - surface.value(state - step)) / (2 * DIFFERENCE_STEP)
                assert slope == pytest.approx(change, abs=DIFFERENCE)


def test_the_size_of_the_states(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text('[system]\nstates = ["x"]\nrhs = ["sign(x)"]\n[check]\nradius = 3\n')
    equations = load_equations(file)
    assert (build_sign_field(equations, [0.0]).size, build_sign_field(equations, [-5.0]).size) == (3.0, 5.0)
