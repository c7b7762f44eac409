"""Irrational numbers between rational ones: the stated field is a mixture of those that enclose it, by its values."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import sympy
from scipy.optimize import linprog

from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.systems.enclosed_numbers import NoEnclosureError, enclose_numbers
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.plain import built
from tests.thorough import few

FORMULAS = [
    ["-sqrt(2)*x + y", "-x/sqrt(3) - sign(y)*sqrt(5)"],
    ["y*cos(pi/7) - x", "-Max(x, y)*sqrt(2)/3 - 10**9*sqrt(7)*y"],
    ["(sqrt(2) - 1)*(x + sqrt(3)*(y - x**2))", "-y - sign(x)/(1 + sqrt(2))"],
    ["-x + sqrt(2)*sin(x)", "-y", "-sqrt(3)/10**12*z"],
    [["-sqrt(2)*x", "-y"], ["-x", "-2*y"]],
]


def fields(system: SwitchedSystem, place: Sequence[sympy.Rational]) -> list[list[sympy.Expr]]:
    """The values of all right-hand sides to sixty digits, by SymPy."""
    at = dict(zip(map(sympy.Symbol, system.states), place, strict=True))
    sides = [[side.text for side in member.rhs] for member in system.members]
    return [[sympy.sympify(text, locals={"Max": sympy.Max}).subs(at).evalf(60) for text in side] for side in sides]


@few(2)
@pytest.mark.parametrize("rhs", FORMULAS, ids=str)
def test_the_stated_field_is_a_mixture(rhs: list[Any]) -> None:
    stated = built(rhs)
    enclosing = enclose_numbers(stated)
    assert enclosing.encloses_numbers
    assert enclosing.only_encloses
    assert len(enclosing.members) > len(stated.members)
    assert enclose_numbers(enclosing) is enclosing
    source = random.Random(3)
    for _ in range(6):
        place = [sympy.Rational(source.randint(-99, 99), 100) for _ in stated.states]
        bounds = fields(enclosing, place)
        for own in fields(stated, place):
            away = [[a - b for a, b in zip(bound, own, strict=True)] for bound in bounds]
            sizes = [max(*map(abs, column), sympy.Rational(1, 10**40)) for column in zip(*away, strict=True)]
            rows = np.array([[float(d / size) for d, size in zip(row, sizes, strict=True)] for row in away])
            table = np.vstack([rows.T, np.ones(len(rows))])
            assert linprog(np.zeros(len(rows)), A_eq=table, b_eq=np.r_[np.zeros(len(own)), 1.0]).status == 0


def test_rational_systems_stay_as_they_are() -> None:
    stated = built(["-x + sqrt(4)*y", "-y/3 - sign(x)"])
    assert enclose_numbers(stated) is stated


@pytest.mark.parametrize(
    "rhs",
    [
        ["-sign(x - sqrt(2)*y)", "-y"],
        ["-Abs(x*sqrt(2))", "-y"],
        ["-(x*sqrt(2) + y)**2", "-y"],
        [" + ".join(f"sqrt({k})*x" for k in (2, 3, 5, 6, 7, 10)), "-y"],
    ],
)
def test_other_systems_are_refused(rhs: list[str]) -> None:
    with pytest.raises(NoEnclosureError, match="irrational numbers"):
        enclose_numbers(built(rhs))


@pytest.mark.parametrize(
    ("rhs", "verdict"),
    [
        (["x*(sqrt(2) - 141421356237/10**11)"], Translation.UNSTABLE),
        (["sqrt(2)*x - 141421356237/10**11*x"], Translation.UNSTABLE),  # of the bounds one attracts, one repels
        (["sqrt(2) - 141421356237/10**11 - x"], Translation.UNSTABLE),
    ],
)
def test_what_no_bounds_tell_is_certified_by_the_numbers(rhs: list[str], verdict: Translation) -> None:
    result = decide_system(built(rhs))
    assert result.verdict is verdict
    assert {"stability": str(verdict)} in certificate_of(result)["statement"]["claims"]


@pytest.mark.parametrize(
    ("rhs", "function", "verdict"),
    [
        (["-sqrt(2)*x + y", "-y", "-z/sqrt(3)"], "x**2 + y**2 + z**2", AuditVerdict.VALID),
        (["-sqrt(2)*x + y", "-y", "-z/sqrt(3)"], "x**2 - y**2 + z**2", AuditVerdict.INVALID),
        (["-sqrt(2)*x", "y", "-z"], "x**2 + y**2 + z**2", AuditVerdict.UNDECIDED),  # true of all of them, not asked
        (["sqrt(2)*y", "-sqrt(2)*x", "-z"], "x**2 + y**2 + z**2", AuditVerdict.UNDECIDED),
    ],
)
def test_functions_are_judged_by_what_holds_of_all_bounds(rhs: list[str], function: str, verdict: AuditVerdict) -> None:
    found = audit(built(rhs), function)
    assert found.verdict is verdict
