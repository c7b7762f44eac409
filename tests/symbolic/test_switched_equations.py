"""Switched equations in any number of states: their surfaces, their pieces, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.equations_file import MAX_STATES, holds_system, load_equations
from nonsmooth.symbolic.files.scene_file import builtin_systems
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.scene_error import SceneError
from nonsmooth.symbolic.surfaces import switching_factors
from nonsmooth.symbolic.switched_equations import SwitchedEquations, UnknownSign

Load = Callable[..., SwitchedEquations]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    def from_text(states: list[str], rhs: list[str], rest: str = "") -> SwitchedEquations:
        file = tmp_path / "my.toml"
        file.write_text(f"[system]\nstates = {states}\nrhs = {rhs}\n{rest}")
        return load_equations(file)

    return from_text


@pytest.mark.parametrize(
    ("rhs", "surfaces"),
    [
        (["sign(x - y)", "sign(2*y - 2*x)"], {"x - y"}),
        (["sign(y**2 - x**2)", "0"], {"x - y", "x + y"}),
        (["sign(x + Abs(y))", "1"], {"y", "x + y", "x - y"}),
        (["sign(x**2 + y**2 - 1)", "sign(x**3)"], {"x**2 + y**2 - 1", "x"}),
        (["sign(x**2 + x*y + y**2)", "Abs(3)"], set()),
        (["x", "sign(y**2 - 2*x**2)"], {"x + sqrt(2)/2*y", "x - sqrt(2)/2*y"}),
    ],
)
def test_surfaces_are_irreducible_and_listed_once(load: Load, rhs: list[str], surfaces: set[str]) -> None:
    found = [str(surface) for surface in load(["x", "y"], rhs).surfaces()]
    assert set(found) == surfaces
    assert len(found) == len(surfaces)


@pytest.mark.parametrize("name", builtin_systems())
def test_planar_pieces_are_those_that_are_checked(name: str) -> None:
    """About the origin both readers give the same polynomials for the same signs."""
    equations, scene = load_equations(name), load_system(name)
    signs = {surface: 1 if k % 2 else -1 for k, surface in enumerate(equations.surfaces())}
    pieces = equations.velocity(signs)

    def sign_of(surface: Polynomial) -> int:
        total, factors = switching_factors(surface)
        for factor in factors:
            total *= next(sign for own, sign in signs.items() if str(own) == str(factor))
        return total

    assert [str(piece) for piece in pieces] == [str(piece) for piece in scene.velocity(sign_of)]


def test_an_open_sign_is_asked_for(load: Load) -> None:
    with pytest.raises(UnknownSign):
        load(["x"], ["sign(x)"]).velocity({})


def test_plain_systems_are_told_from_arrays() -> None:
    assert holds_system("flower")
    assert not holds_system("four-wheel")


@pytest.mark.parametrize(
    ("states", "rhs", "named"),
    [
        ([], [], "1 to 8 different names"),
        (["x", "x"], ["1", "1"], "1 to 8 different names"),
        (["x", "sign"], ["1", "1"], "1 to 8 different names"),
        ([f"x{k}" for k in range(MAX_STATES + 1)], ["1"] * (MAX_STATES + 1), "1 to 8 different names"),
        (["x", "y"], ["1"], "2 formulas"),
        (["x"], ["y"], "system.rhs[1]"),
        (["x"], ["__import__('os')"], "system.rhs[1]"),
    ],
)
def test_bad_files_are_refused(load: Load, states: list[str], rhs: list[str], named: str) -> None:
    with pytest.raises(SceneError, match=r"my\.toml") as caught:
        load(states, rhs)
    assert named in str(caught.value)


def test_pieces_that_are_no_polynomials_are_refused(load: Load) -> None:
    with pytest.raises(SceneError, match=r"system.rhs\[1\]"):
        load(["x"], ["1/x"]).surfaces()


def test_too_many_surfaces_are_refused(load: Load) -> None:
    relays = " + ".join(f"sign(x - {k})*sign(y - {k})" for k in range(8))
    with pytest.raises(SceneError, match="fewer switching surfaces"):
        load(["x", "y"], [relays, "0"]).surfaces()
