"""Plain systems as fields to simulate: both forms agree with the formulas and with each other."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.fields.switched_field import ScalarVelocity, Vector
from nonsmooth.analysis.fields.system_field import constant_system, system_field
from nonsmooth.analysis.trajectories import faces as faces_module
from nonsmooth.analysis.trajectories.faces import FaceMotion, face_choices
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.system_file import load_system
from tests.built_in import planar_systems
from tests.oracles.differences import STEP

ROUNDING = 1e-14


ROOT_HALF = 0.5**0.5
LITERAL: dict[str, Callable[[float, float], tuple[float, float]]] = {
    "relay-oscillator": lambda x, y: (np.sign(y), -np.sign(x)),
    "relay-oscillator-damped": lambda x, y: (np.sign(y), -np.sign(x) - np.sign(y) / 2),
    "flower": lambda x, y: (-x / 10 + y, -5 * x - y / 10) if abs(x) >= abs(y) else (-x / 10 + 5 * y, -x - y / 10),
    "escaping-slide": lambda x, y: (-np.sign(x), 1.0),
    "line-of-equilibria": lambda x, y: (0.0, -np.sign(y)),
    "eq-3": lambda x, y: (
        -ROOT_HALF * np.sign(x) * (np.sign(y**2 - x**2) + 1),
        ROOT_HALF * np.sign(y) * (np.sign(y**2 - x**2) - 1),
    ),
    "eq-4": lambda x, y: (
        ROOT_HALF * np.sign(x) * (np.sign(y**2 - x**2) - 1),
        -ROOT_HALF * np.sign(y) * (np.sign(y**2 - x**2) + 1),
    ),
    "stick-slip": lambda x, v: (v, -5 / 6 - x - np.sign(v - 0.5) * (1 - abs(v - 0.5) / 3)),
}


@pytest.mark.parametrize("name", planar_systems())
def test_modes_are_the_formulas_off_the_surfaces(name: str) -> None:
    field, rng = system_field(load_system(name)), np.random.default_rng(1)
    for x in rng.uniform(-0.5, 0.5, (40, 2)):
        assert field.flow(field.mode_at(x))(0.0, x) == pytest.approx(LITERAL[name](x[0], x[1]), abs=ROUNDING)


@pytest.mark.parametrize("surface", ["x + y/3", "x**2 + y - 1/4"], ids=("flat", "curved"))
def test_slides_in_single_floats_are_those_of_arrays(surface: str) -> None:
    field = system_field(ns.System(["x", "y"], [f"y - 2*sign({surface})", f"x*y - sign({surface})"]).system)
    for x in np.random.default_rng(3).uniform(-0.5, 0.5, 20):
        place = np.array([x, -3 * x if surface == "x + y/3" else 0.25 - x**2])
        motion = FaceMotion(field.faces_at(place)[0])
        velocity = motion.velocity
        assert motion.is_pair
        assert isinstance(velocity, ScalarVelocity)
        assert velocity(0.0, place) == pytest.approx(motion(0.0, place), abs=ROUNDING)
        assert float(motion.face.keep[0].normal(place) @ velocity(0.0, place)) == pytest.approx(0, abs=ROUNDING)


def test_crossings_taken_at_once_are_those_that_trials_find(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside them the places where the field slides, escapes or nearly touches, which trials decide in any case."""
    rhs = ["y - 2*sign(x + y/3) + x*sign(x - y)", "x*y - sign(x + y/3)/3 - sign(x - y)/2"]
    field, crossings = system_field(ns.System(["x", "y"], rhs).system), 0
    for x in np.random.default_rng(4).uniform(-1, 1, 60):
        for place in (np.array([x, -3 * x]), np.array([x, x])):
            faces, at_once = field.faces_at(place), faces_module._crossing(field.faces_at(place), 0.0, place)
            with monkeypatch.context() as without:
                without.setattr(faces_module, "_crossing", lambda *_: None)
                tried = face_choices(field, faces, 0.0, place)
            if at_once is not None:
                crossings += 1
                assert [choice.motion.face for choice in tried] == [at_once.motion.face]
                assert (tried[0].sure, tried[0].free, tried[0].orders) == (at_once.sure, at_once.free, at_once.orders)
    assert 40 < crossings < 110


def test_written_polynomials_name_their_arguments_alone() -> None:
    """No word of a scene gets into the code that is compiled."""
    velocity = system_field(ns.System(["abs_x", "max_y"], ["max_y - abs_x**3/7", "-abs_x"]).system).flow(())
    assert isinstance(velocity, ScalarVelocity)
    assert velocity.rates.__code__.co_varnames == ("x0", "x1")
    assert velocity.rates.__code__.co_names == ()


def test_relays_may_ask_for_patterns_without_a_cell() -> None:
    """Beside the corner of eq. (4) hysteresis keeps x < 0 while |y| > |x| has changed: no cell, but a motion."""
    field = system_field(load_system("eq-4"))
    for signs in product((-1, 1), repeat=len(field.surfaces)):
        assert np.isfinite(field.flow(signs)(0.0, np.array([0.1, 0.2]))).all()


@pytest.mark.parametrize("power", [2, 16])  # the first is written out, the second has 1785 factors: too many for that
def test_polynomials_are_those_stated(power: int) -> None:
    velocity = system_field(ns.System(["x", "y"], [f"(x/2 + y + 1)**{power} - x", "y**2*x/3 - 3/7"]).system).flow(())
    for x, y in np.random.default_rng(power).uniform(-1, 1, (20, 2)):
        stated = ((x / 2 + y + 1) ** power - x, y**2 * x / 3 - 3 / 7)
        assert velocity(0.0, np.array([x, y])) == pytest.approx(stated, abs=1e-14 * 2.5**power)


@pytest.mark.parametrize("name", [name for name in planar_systems() if name not in {"flower", "stick-slip"}])
def test_constant_systems_have_closed_forms(name: str) -> None:
    scene = load_system(name)
    smooth, exact = system_field(scene), constant_system(scene, exact=True)
    assert exact is not None
    for start in ((0.31, 0.17), (-0.05, 0.4), (0.2, -0.45)):
        end = simulate(exact, (*start, 0), 0.03).end
        assert simulate(smooth, start, float(end.t)).end.state == pytest.approx(
            [float(x) for x in end.state[:2]], abs=1e-11
        )


def test_linear_modes_have_none(tmp_path: Path) -> None:
    assert constant_system(load_system("flower")) is None
    (tmp_path / "my.toml").write_text('[system]\nstates = ["x", "y"]\nrhs = ["-sign(x**2 + y**2 - 1)", "0"]\n')
    assert constant_system(load_system(tmp_path / "my.toml")) is not None  # the curve lies outside the square


# ---- formulas in any number of states, read as Python would ----

POLYNOMIAL_ROUNDING = 1e-13  # of polynomials of degree three at states of size two
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
def test_the_flow_of_the_mode_at_a_state_is_the_formula(
    states: list[str], rhs: list[str], value: Callable[[Vector], list[float]], tmp_path: Path
) -> None:
    file = tmp_path / "my.toml"
    file.write_text(f"[system]\nstates = {states}\nrhs = {rhs}\n")
    field = system_field(load_system(file), [1.0] * len(states))
    rng = np.random.default_rng(7)
    for state in rng.uniform(-2, 2, (200, len(states))):
        found = field.flow(field.mode_at(state))(0.0, state)
        assert found == pytest.approx(value(state), abs=POLYNOMIAL_ROUNDING)
        for surface in field.surfaces:
            for k, slope in enumerate(surface.gradient(state)):
                step = STEP * np.eye(len(states))[k]
                change = (surface.value(state + step) - surface.value(state - step)) / (2 * STEP)
                assert slope == pytest.approx(change, abs=DIFFERENCE)


def test_the_size_of_the_states(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text('[system]\nstates = ["x"]\nrhs = ["sign(x)"]\n[check]\nradius = 3\n')
    equations = load_system(file)
    assert (system_field(equations, [0.0]).size, system_field(equations, [-5.0]).size) == (3.0, 5.0)
