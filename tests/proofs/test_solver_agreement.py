"""The audit of a V beside Z3 on inequalities that are built from the formulas anew; more of it in tests/benchmarks."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

import nonsmooth as ns
from nonsmooth.proofs.system_audit import audit
from nonsmooth.proofs.systems.derivatives import Decrease
from tests.oracles.solver_questions import Questions, read
from tests.oracles.solvers import ask, with_z3
from tests.thorough import thorough

RELAY, SKEW = ["y", "-3*sign(x) - 2*sign(y)"], ["y", "-2*sign(x + y) + x/2"]
CHAIN = ["-sgn(x) + y/2", "-sgn(y) + z/2", "-sgn(z) - x/2"]
DRAG = ["y", "-sign(x) - y*Abs(y)"]


def decrease(states: Sequence[str], rhs: Sequence[str], potential: str) -> Decrease:
    audited = audit(ns.System(list(states), list(rhs)).system, potential)
    assert audited.function is not None
    return audited.function.decrease


@pytest.mark.parametrize(
    ("states", "rhs", "potential", "truth"),
    [
        ("xy", RELAY, "Abs(x) - x**2/6 + x*y/6 + 2*y**2/7", Decrease.STRICT),
        ("xy", RELAY, "Abs(x) + x**2/6 - x*y/2 + 2*y**2/7", Decrease.REFUTED),
        pytest.param("xy", SKEW, "Abs(x + y) + x**2 + x*y/2 + y**2/2", Decrease.STRICT, marks=thorough),
        pytest.param("xy", SKEW, "Abs(x + y) - x**2 + x*y/2 + y**2/2", Decrease.REFUTED, marks=thorough),
        ("xy", DRAG, "Abs(x) + y**2/2", Decrease.WEAK),
        ("xyz", CHAIN, "Abs(x) + Abs(y) - Abs(z)/4", Decrease.REFUTED),
        pytest.param("xyz", CHAIN, "Abs(x) + Abs(y) + Abs(z)", Decrease.STRICT, marks=thorough),
    ],
)
def test_the_audit_agrees_with_z3(states: str, rhs: list[str], potential: str, truth: Decrease) -> None:
    assert decrease(states, rhs, potential) is truth
    stated = read(states, rhs, [0] * len(states), "1/2", potential)
    strict = ask(with_z3, list(Questions(stated)), 20)
    assert strict.said == ("proved" if truth is Decrease.STRICT else "refuted"), strict
    weak = ask(with_z3, list(Questions(stated, rises=">")), 20)
    assert weak.said == ("refuted" if truth is Decrease.REFUTED else "proved"), weak
