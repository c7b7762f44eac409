"""Formulas of systems that were rewritten: short in reports, and with the same values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nonsmooth.proofs.system_facts import rewriting_words
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.formulas.formula_text import tidied

RATES = ["sin(x) - 2*sgn(x + y) - y", "1/4 - (1 - x)*cos(2*x - y) + Abs(y)", "-(x/2 + sin(y + pi/2)) + 10*sin(x)**2"]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("(((1*((+ (x)) - (+ (x))**3/6 + 0*(+ (x))**5/120)) - (2*sgn(x + y))) - (y))", "x - x**3/6 - 2*sgn(x + y) - y"),
        ("(0 - x)*1 + 0/7", "-x"),
        ("x/(y*1)/2 - (x - (y - 0))", "x/y/2 - (x - y)"),
        ("-(0) + -x**2", "-x**2"),
        ("10*x + 0.5*(+y)", "10*x + 0.5*y"),
        ("(-1)**2*x", "(-1)**2*x"),
        ("1 + (x - (-1/2))**2", "1 + (x + 1/2)**2"),
        ("x - (-2)*y + (-3) - (y - -1)", "x + 2*y - 3 - (y + 1)"),
    ],
)
def test_what_changes_nothing_is_left_out(text: str, shown: str) -> None:
    assert tidied(text) == shown


@pytest.mark.parametrize("rate", RATES)
def test_values_stay(rate: str) -> None:
    data = {"system": {"states": ["x", "y"], "rhs": ["y", rate]}, "check": {"equilibrium": ["0", "0"]}}
    x, y = np.random.default_rng(0).uniform(-2, 2, (2, 50))
    names = {"x": x, "y": y, "sgn": np.sign, "Abs": np.abs}
    for member in build_system(data, "t", Path("t.toml")).members:
        written, shown = member.rhs[1].text, tidied(member.rhs[1].text)
        assert len(shown) < len(written)
        first, second = (eval(text, names) for text in (written, shown))  # noqa: S307 - formulas of this file
        assert np.allclose(first, second, rtol=1e-12, atol=1e-12)


def test_the_factor_that_clears_fractions_is_tidied() -> None:
    data = {"system": {"states": ["x", "y"], "rhs": ["y", "-x/(1 + Abs(y))"]}}
    said = rewriting_words(build_system(data, "t", Path("t.toml")))
    assert said.startswith("multiplied by (1 + Abs(y))*(1 + Abs(y)), which is positive")
