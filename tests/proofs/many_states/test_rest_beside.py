"""Points beside which others of rest lie: friction and relays, and points that attract."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.optimize import nnls

import nonsmooth as ns
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.many_states.lyapunov_search import proposals
from nonsmooth.proofs.many_states.rest_beside import ray_of_rest
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.certificates.inclusion import FloatInclusion

AGREE = ["sign(y - x) + sign(z - x)", "sign(x - y) + sign(z - y)", "sign(x - z) + sign(y - z)"]
FRICTION = ["u", "v", "-2*x + y - sign(u)/2", "x - 2*y - sign(v)/2"]
RESTS = [(["x", "y", "z"], AGREE), (["x", "y", "u", "v"], FRICTION), (["x", "y", "z"], ["-x*z**2", "-y", "-z"])]
MOVES = [
    (["x", "y", "z"], ["-sign(x)", "-sign(y)", "-sign(z)"]),
    (["x", "y", "u", "v"], ["u", "v", "-2*x + y - sign(u)/2", "x - 2*y - v"]),  # only one mass sticks
    (["x", "y", "z"], ["-1 - sign(y) - x**2", "-y", "-z"]),  # 0 is at the border of the mixtures at the point alone
    (["x", "y", "z"], ["-sign(x*y - z)", "-y", "-z"]),  # a curved surface: its cells are not known to have points
]


def system(states: Sequence[str], rhs: Sequence[str]) -> SwitchedSystem:
    return ns.System(list(states), list(rhs)).system


def test_no_function_that_falls_is_proposed_beside_places_of_rest() -> None:
    """Both searches took 45 s of a processor here, and could find nothing."""
    own = system("xyz", ["-2*x + 3*x*sin(z)/2", "-2*x - x*y", "-z + 2*x*sign(y)"])
    assert not any(True for positive in (True, False) for _ in proposals(own, positive=positive))


@pytest.mark.parametrize(("states", "rhs"), RESTS)
def test_places_of_the_ray_are_equilibria(states: list[str], rhs: list[str]) -> None:
    ray = ray_of_rest(system(states, rhs))
    assert ray is not None
    inclusion = FloatInclusion({"states": states, "rhs": [rhs], "at": ["0"] * len(states)}, 1)
    for distance in (0.1, 0.01):
        places = distance * np.tile(np.array(ray, dtype=float), (200, 1))
        values = inclusion.corners(places, np.full(200, 1e-9)).reshape(-1, len(states))
        _, rest = nnls(np.vstack([values.T, np.ones(len(values))]), np.append(np.zeros(len(states)), 1.0))
        assert rest < 1e-6


@pytest.mark.parametrize(("states", "rhs"), RESTS[:2])
def test_the_point_is_said_not_to_attract(states: list[str], rhs: list[str]) -> None:
    result = decide_system(system(states, rhs))
    assert result.verdict is Translation.STABLE
    assert "not asymptotically: every point of the ray through" in result.reason


@pytest.mark.parametrize(("states", "rhs"), MOVES)
def test_no_ray_is_found_of_others(states: list[str], rhs: list[str]) -> None:
    assert ray_of_rest(system(states, rhs)) is None
