"""In three states a check is told a larger region without being asked: beside a region that is known exactly."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import sympy

if TYPE_CHECKING:
    from tests.reports.conftest import Invoke

FORM = "x**2 + 2*y**2 + 3*z**2 + x*y"
SYSTEM = f"""
[system]
states = ["x", "y", "z"]
rhs = ["-x + ({FORM})*x", "-y + ({FORM})*y", "-z + ({FORM})*z"]
"""


def test_nine_tenths_of_a_level_and_no_more_than_it(invoke: Invoke, tmp_path: Path) -> None:
    """Along every ray ``r' = -r + q r`` with the form q: starts come to the point exactly where ``q < 1``."""
    file = tmp_path / "ellipsoid.toml"
    file.write_text(SYSTEM, encoding="utf-8")
    own = json.loads(invoke("check", str(file), "--json").out)["reshaped"]
    q, v = (sympy.lambdify(sympy.symbols("x y z"), sympy.sympify(text), "numpy") for text in (FORM, own["V"]))
    rays = np.random.default_rng(0).normal(size=(3, 1000))
    border = rays / np.sqrt(q(*rays))
    assert (v(*(np.sqrt(0.9) * border)) < own["level"]).all()
    assert (v(*border) >= own["level"]).all()


def test_programs_that_are_too_large_are_said_to_be(invoke: Invoke, tmp_path: Path) -> None:
    """In eight states the verdict is told at once, with a line on why no larger region was sought."""
    states = [f"x{k}" for k in range(8)]
    file = tmp_path / "eight.toml"
    file.write_text(
        f"[system]\nstates = {json.dumps(states)}\nrhs = {json.dumps([f'-{x} + x0*{x}' for x in states])}\n",
        encoding="utf-8",
    )
    assert "no larger region was sought" in invoke("check", str(file)).out
    assert "no larger region was sought" not in invoke("check", str(file), "--region", "none").out
