"""Sines and cosines whose first terms cancel: further terms of their series decide, and certificates name them."""

from __future__ import annotations

import copy
import math
from fractions import Fraction
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.proofs import system_decision
from nonsmooth.proofs.checker.formulas import series
from nonsmooth.proofs.checker.polynomials import variable
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_certificates import certificate_text
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.thorough import thorough

KNOWN = {
    ("sin(x) - x + x**3/6",): ("unstable", 1),  # x^5/120
    ("x - x**3/6 - sin(x)",): ("asymptotically stable", 1),
    ("1 - x**2/2 + x**4/24 - cos(x) - x**7/1000",): ("unstable", 1),  # x^6/720: on the right alone
    ("sin(x) - x + x**3/6 - x**5/120",): ("asymptotically stable", 2),  # -x^7/5040
    ("-x", "sin(y) - y + y**3/6"): ("unstable", 1),
    ("y", "sin(x) - x + x**3/6 - y"): ("unstable", 1),
    ("y", "-sin(x) - y"): ("asymptotically stable", 0),
}


class Open:
    verdict = Translation.UNDECIDED


def decided(rhs: tuple[str, ...]) -> Any:
    return ns.System(["x", "y"][: len(rhs)], list(rhs)).check()


@pytest.mark.parametrize("rhs", [own if len(own) < 2 else pytest.param(own, marks=thorough) for own in KNOWN])
def test_further_terms_decide(rhs: tuple[str, ...]) -> None:
    """Of those in two states test_another_order_does_not_show_it decides one."""
    verdict, order = KNOWN[rhs]
    result = decided(rhs)
    assert result.verdict == verdict
    certificate = result.certificate()
    assert certificate["statement"]["subject"].get("order", 0) == order
    assert not refusal(certificate, len(certificate_text(certificate)))


def test_further_terms_are_not_tried_where_first_ones_are_larger(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[int]()

    def ask(system: SwitchedSystem) -> Open:
        asked.append(system.order)
        return Open()

    monkeypatch.setattr(system_decision, "_decided", ask)
    for rhs, orders in ((("y", "sin(x) - x + x**3/6 - y"), [0, 1, 2]), (("y", "-k*sin(x)"), [0])):
        decide_system(ns.System(["x", "y"], list(rhs), parameters={"k": [1, 2]}).system)
        assert asked == orders
        asked.clear()


def test_another_order_does_not_show_it() -> None:
    certificate = decided(("sin(x) - x + x**3/6",)).certificate()
    assert certificate["statement"]["subject"]["order"] == 1
    assert not refusal(certificate, len(certificate_text(certificate)))
    for order in (0, 5, -1, True, "1", 1.0, None):
        forged = copy.deepcopy(certificate)
        forged["statement"]["subject"]["order"] = order
        assert refusal(forged, len(certificate_text(forged)))


@pytest.mark.parametrize("order", range(5))
@pytest.mark.parametrize("name", ["sin", "cos"])
def test_values_lie_between_neighbouring_sums(name: str, order: int) -> None:
    """Up to where rounding tells nothing."""
    ends = [series(name, variable(1, 0), e, order) for e in (0, 1)]
    for k in range(-40, 41):
        at = Fraction(k, 8)
        low, high = sorted(float(sum(c * at ** e[0] for e, c in own.terms.items())) for own in ends)
        assert low - 1e-9 <= getattr(math, name)(float(at)) <= high + 1e-9
