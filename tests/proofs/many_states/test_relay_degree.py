"""Relays of high relative degree are unstable: against paths of fine steps, and forged evidence."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray

import nonsmooth as ns
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.many_states.decision import first_cells
from nonsmooth.proofs.many_states.relay_degree import high_degree_relay
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.findings import Method
from tests.certificates.inclusion import contradiction
from tests.thorough import few, keep

Floats = NDArray[np.float64]
STEP, START, FAR = 1 / 512, 1e-3, 30.0


def decided(rhs: Sequence[str], states: str = "xyzuvw") -> StabilityResult:
    return decide_system(ns.System(list(states[: len(rhs)]), list(rhs)).system)


@few(3)
@pytest.mark.parametrize(
    ("rhs", "degree"),
    keep(
        5,
        [
            (["y", "z", "-sgn(x)"], 3),
            (["y", "z", "sgn(x) - x - y - z"], 3),
            (["y", "z", "-sgn(x) - 100*x - 50*y - 20*z - z**3"], 3),
            (["y", "z", "u", "v", "-sgn(x)"], 5),
            (["y", "z", "-sgn(x) + u", "-u + x"], 3),
            (["y", "z + x**2", "-2*sgn(x) - sgn(y) - z"], 3),
            (["y", "sgn(x) - y", "-z + x"], 2),
            (["y", "z", "u", "-sgn(x) - u"], 4),
        ],
    ),
)
def test_known_degrees(rhs: list[str], degree: int) -> None:
    result = decided(rhs)
    assert result.verdict is Translation.UNSTABLE
    assert result.check()
    if result.method is Method.RELAY:
        assert result.deciding.proofs.degree == degree
    else:
        assert result.method is Method.ESCAPE


@few(2)
@pytest.mark.parametrize(
    "rhs",
    [
        ["y", "z", "-sgn(x)"],
        ["y", "z", "sgn(x) - x - y - z"],
        ["y", "z + x**2", "-2*sgn(x) - sgn(y) - z"],
        ["y", "z", "u", "v", "-sgn(x)"],
        ["y", "z", "-sgn(x) + u", "-u + x"],
    ],
)
def test_the_function_of_a_relay_is_certified(rhs: list[str]) -> None:
    """Products of neighbouring derivatives rise one after the other where it is kept."""
    certificate = certificate_of(decided(rhs))
    (entry,) = certificate["evidence"]
    assert entry["theorem"] == "instability"
    assert entry["hypotheses"]["second"]["functions"]
    assert not contradiction(certificate["statement"], 1 / 16)


@pytest.mark.parametrize(
    "rhs",
    [
        ["y", "z", "u", "v", "w", "-sgn(x)"],  # degree 6: terms of both signs
        ["y", "-sgn(x) - y", "-z"],  # degree 2, pushed back: stable
        ["y", "z", "-x - y - z - sgn(x + y + z)"],  # degree 1
        ["y", "z", "-sgn(x) - 2*sgn(y)"],  # the sign of s does not decide that of its third derivative
        ["y + sgn(z)", "z", "-sgn(x)"],  # another relay acts in the first derivative
        ["y", "z", "-x*sgn(x) - y - z"],  # the field does not jump at the point
    ],
)
@pytest.mark.parametrize("whole", keep(1, [False, True]), ids=["relay", "whole check"])
def test_other_relays_are_left_to_others(rhs: list[str], whole: bool) -> None:
    system = ns.System(list("xyzuvw"[: len(rhs)]), rhs).system
    found = decided(rhs).by(Method.RELAY) if whole else high_degree_relay(system, first_cells(system))
    assert found is None


def test_the_function_of_a_relay_never_falls_near_the_point() -> None:
    """W along the field at random points, and on the way from the point in its direction."""
    relay = decided(["y", "z", "-sgn(x) - z"]).deciding.proofs

    def value(polynomial: Polynomial, place: Floats) -> float:
        return sum(float(c) * float(np.prod(place ** np.array(e))) for e, c in polynomial.terms.items())

    slopes = [relay.rising.derivative(k) for k in range(3)]
    for x, y, z in np.random.default_rng(0).uniform(-1 / 8, 1 / 8, (400, 3)):
        rate = (y, z, -np.sign(x) - z)
        assert sum(value(slope, np.array([x, y, z])) * v for slope, v in zip(slopes, rate, strict=True)) >= -1e-12
    direction = np.array([float(d) for d in relay.direction])
    assert all(value(relay.rising, direction * 0.5**k) > 0 for k in range(4, 20))


# ---- against paths -------------------------------------------------------------------------------


def random_relay(seed: int) -> tuple[list[str], Callable[[Floats], Floats]]:
    """Integrators in a row with a relay and random linear terms, perhaps a further state, in other coordinates."""
    rng = np.random.default_rng(seed)
    degree, more = int(rng.integers(3, 5)), int(rng.integers(0, 2))
    count = degree + more
    matrix = np.zeros((count, count), dtype=int)
    matrix[np.arange(degree - 1), np.arange(1, degree)] = 1
    matrix[degree - 1 :] = rng.integers(-3, 2, (count - degree + 1, count))
    push = np.zeros(count, dtype=int)
    push[degree - 1] = -int(rng.integers(1, 4))
    turn = np.eye(count, dtype=int)
    for i, j in itertools.permutations(range(count), 2):
        turn[i] += int(rng.integers(-1, 2)) * turn[j]
    old = sp.Matrix(turn.tolist()).inv()
    moved, pushed, output = sp.Matrix(turn.tolist()) * sp.Matrix(matrix.tolist()) * old, turn @ push, old.row(0)
    names = sp.symbols("x y z u v")[:count]
    surface = sum(a * b for a, b in zip(output, names, strict=True))
    rows = [sum(moved[k, i] * names[i] for i in range(count)) for k in range(count)]
    rhs = [f"{row} + ({p})*sgn({surface})" for row, p in zip(rows, pushed, strict=True)]
    a, b, c = np.array(moved.tolist(), dtype=float), pushed.astype(float), np.array(output.tolist()[0], dtype=float)
    return rhs, lambda point: a @ point + b * np.sign(c @ point)


def leaves(field: Callable[[Floats], Floats], start: Floats) -> bool:
    """Whether a path of fine steps comes many times as far as it began."""
    point, size = start.copy(), float(np.abs(start).max())
    for _ in range(40_000):
        point = point + STEP * size ** (1 / 3) * field(point + STEP * size ** (1 / 3) / 2 * field(point))
        if np.abs(point).max() > FAR * size:
            return True
    return False


@pytest.mark.parametrize("seed", range(8))
def test_paths_leave(seed: int) -> None:
    rhs, field = random_relay(seed)
    result = decided(rhs, "xyzuv")
    assert result.verdict is Translation.UNSTABLE
    assert result.check()
    relay = high_degree_relay(result.scene, first_cells(result.scene))
    assert relay is not None
    direction = np.array([float(d) for d in relay.direction])
    assert leaves(field, START * direction / np.abs(direction).max())
