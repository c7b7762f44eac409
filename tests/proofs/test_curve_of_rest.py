"""Curves of equilibria to which everything beside them falls back: stable, and not asymptotically stable."""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.polynomials import Polynomial, constant, lie_derivative, variable
from nonsmooth.proofs.kernel_strategies import decide_beside_curve_of_rest
from nonsmooth.proofs.many_states.rest_beside import _adjugate, curve_of_rest
from nonsmooth.proofs.system_decision import checked_point
from tests.thorough import few, thorough

EPIDEMIC = (["S", "I"], ["-S*I", "S*I - I"])


@few(3)
@pytest.mark.parametrize(
    ("states", "rhs", "at", "curve"),
    [
        (["x", "y"], ["x*y", "-2*y"], None, "x = u, y = 0"),
        (*EPIDEMIC, ["1/2", 0], "S = u + 1/2, I = 0"),
        pytest.param(
            ["S", "E", "I"], ["-S*I", "S*I - E", "E - I"], ["1/2", 0, 0], "S = u + 1/2, E = 0, I = 0", marks=thorough
        ),
        (["u", "y"], ["u**2*y + y**2", "-2*y + u*y"], None, "u = r, y = 0"),
        (["x", "y", "z"], ["x*y + x*z", "-2*y + z", "-z/2 - y"], None, "x = u, y = 0, z = 0"),
        (["x", "y"], ["x*(y - x**2)", "-(y - x**2)"], None, "x = u, y = u**2"),
        (["x", "y"], ["y + x**2", "-y - x**2"], None, "x = u, y = -u**2"),  # of x, not of x + y
        pytest.param(["x", "y"], ["y - x**2", "-2*y + 2*x**2"], None, "x = u, y = u**2", marks=thorough),
    ],
)
def test_the_point_is_stable_and_does_not_attract(
    states: list[str], rhs: list[str], at: list[str | int] | None, curve: str
) -> None:
    result = ns.System(states, rhs, at=at).check()
    assert str(result.verdict) == "stable"
    assert f"not asymptotically: every point of the curve {curve} near the equilibrium" in result.reason
    claims = result.certificate()["statement"]["claims"]
    assert claims[0] == {"stability": "stable"}
    assert all(set(claim) == {"approaches"} for claim in claims[1:])
    assert result.evidence.check()


def test_an_epidemic_beyond_its_threshold_is_unstable() -> None:
    assert str(ns.System(*EPIDEMIC, at=["3/2", 0]).check().verdict) == "unstable"


@pytest.mark.parametrize(
    "rhs",
    [
        ["x*y + x**9", "-2*y"],  # rests at the origin alone
        ["x*y", "2*y"],  # everything leaves the line
        ["-x - x**2 - y**2", "0"],  # a circle
        ["x*y", "y**3"],  # two eigenvalues zero
    ],
)
def test_other_fields_have_no_such_curve(rhs: list[str]) -> None:
    assert decide_beside_curve_of_rest(checked_point(ns.System(["x", "y"], rhs).system)) is None


def _random_field(source: random.Random, count: int) -> list[Polynomial]:
    """A field that rests where all states but the first are zero, and is stable across that line."""

    def terms(number: int) -> Polynomial:
        polynomial = constant(count, 0)
        for _ in range(number):
            term = constant(count, Fraction(source.randint(-4, 4), 2))
            for _ in range(source.randint(1, 2)):
                term *= variable(count, source.randrange(count))
            polynomial += term * variable(count, source.randrange(1, count))
        return polynomial

    return [terms(3), *(terms(3) - variable(count, k, 2) for k in range(1, count))]


def _across(value: Polynomial) -> int:
    """The least degree of its terms in all states but the first."""
    return min((sum(exponents[1:]) for exponents in value.terms), default=2)


@pytest.mark.parametrize("count", [2, 3])
def test_the_derivative_of_v_is_of_degree_two_across_the_line(count: int) -> None:
    """It has no terms that the square of the distance from the line does not outweigh."""
    number = 0
    for seed in range(40):
        field = _random_field(random.Random(seed), count)
        curve = curve_of_rest(field)
        for function in curve.functions() if curve is not None else ():
            assert _across(lie_derivative(function, field)) >= 2
            number += 1
    assert number > 40


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_a_matrix_times_its_adjugate_is_its_determinant(size: int) -> None:
    source = random.Random(size)
    matrix = [
        [Polynomial(1, {(k,): Fraction(source.randint(-5, 5)) for k in range(3)}) for _ in range(size)]
        for _ in range(size)
    ]
    adjugate, determinant = _adjugate(matrix)
    for i in range(size):
        for j in range(size):
            assert _dot(matrix[i], [row[j] for row in adjugate]) == (determinant if i == j else constant(1, 0))
    floats = [[float(entry.on([constant(1, 1)], 1).at_origin) for entry in row] for row in matrix]
    assert np.linalg.det(floats) == pytest.approx(float(determinant.on([constant(1, 1)], 1).at_origin))


def _dot(first: Sequence[Polynomial], second: Sequence[Polynomial]) -> Polynomial:
    total = constant(1, 0)
    for a, b in zip(first, second, strict=True):
        total += a * b
    return total
