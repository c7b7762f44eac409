"""In three states a check is told a larger region without being asked: beside a region that is known exactly."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest
import sympy
from numpy.typing import NDArray

from nonsmooth.proofs.many_states.reshaped_region import EFFORTS
from nonsmooth.proofs.systems.basin_shells import EFFORTS as SHELLS
from nonsmooth.reports.checks.check import check_system
from nonsmooth.symbolic.files.system_builder import build_system
from tests.evidence.published_systems import astray, in_simplices
from tests.reports.conftest import Invoke
from tests.thorough import thorough

Floats: TypeAlias = NDArray[np.float64]

FORM = "x**2 + 2*y**2 + 3*z**2 + x*y"
SYSTEM = f"""
[system]
states = ["x", "y", "z"]
rhs = ["-x + ({FORM})*x", "-y + ({FORM})*y", "-z + ({FORM})*z"]
"""


def test_nine_tenths_of_a_level_and_no_more_than_it(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Along every ray ``r' = -r + q r`` with the form q: starts come to the point exactly where ``q < 1``."""
    monkeypatch.setitem(SHELLS, "fast", replace(SHELLS["fast"], frequency=4, shells=6))
    file = tmp_path / "ellipsoid.toml"
    file.write_text(SYSTEM, encoding="utf-8")
    certificate = tmp_path / "ellipsoid.json"
    found = json.loads(invoke("check", str(file), "--json", "--certificate", str(certificate)).out)
    own = found["reshaped"]
    q, v = (sympy.lambdify(sympy.symbols("x y z"), sympy.sympify(text), "numpy") for text in (FORM, own["V"]))
    rays = np.random.default_rng(0).normal(size=(3, 1000))
    border = rays / np.sqrt(q(*rays))
    assert (v(*(np.sqrt(0.9) * border)) < own["level"]).all()
    assert (v(*border) >= own["level"]).all()
    assert_inside_and_without_folds(found["basin"], q)
    assert f"one of {len(found['basin']['simplices'])} tetrahedra" in invoke("verify", str(certificate)).out


def assert_inside_and_without_folds(basin: dict[str, Any], q: Callable[..., Floats]) -> None:
    """Corners of tetrahedra lie where ``q < 1``, a convex set, and volumes add up to what is between two borders."""
    corners, values = np.array(basin["vertices"]), np.array(basin["values"])
    simplices = np.array(basin["simplices"])
    assert (q(*corners.T) < 1).all()
    assert basin["share"]["sampled"] > 0.85

    def sizes(own: Floats) -> Floats:
        return np.asarray(np.linalg.det(own[:, 1:] - own[:, :1]) / 6)

    own = sizes(corners[simplices])
    assert own.min() > 0
    between = 0.0
    for value, sign in ((0, -1), (values.max(), 1)):  # pyramids over the sides of a polyhedron, seen from the point
        listed = [side for cell in simplices for side in combinations(cell, 3) if (values[list(side)] == value).all()]
        places = corners[np.array(sorted(set(map(tuple, map(sorted, listed)))))]
        between += sign * float(np.abs(np.linalg.det(places)).sum()) / 6
    assert float(own.sum()) == pytest.approx(between)


RELAYS = {
    "sliding on a slanted plane": (["y", "z", "-2*sign(x + 2*y + 2*z) - z"], 0.5),
    "sliding on an axis": (["-x + y", "-y + x**3/2", "x/4 - sign(z)"], 1.5),
    "saturated": (["y", "-x - y + x**3/3 + z", "-z - sat(y, -1/4, 1/4)"], 1.0),
}


@thorough  # tetrahedra: the test above; fields that switch: test_region_triangles.py
@pytest.mark.parametrize("name", RELAYS)
def test_tetrahedra_where_fields_switch(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Starts in them are followed by polygons along the formulas."""
    effort = replace(SHELLS["fast"], frequency=4, shells=3, steps=60, starts=3)
    monkeypatch.setitem(SHELLS, "fast", effort)
    sides, reaches = RELAYS[name]
    document = {"system": {"states": ["x", "y", "z"], "rhs": sides}, "check": {"radius": "1/2"}}
    system = build_system(document, name, Path("relay.toml"))
    basin = check_system(system).with_region("fast").evidence.reach.basin
    assert basin is not None
    assert np.abs(basin.border).max() > reaches
    assert astray(system, in_simplices(basin, 200)) == 0


def test_programs_that_are_too_large_are_said_to_be(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The verdict is told at once, with a line on why no larger region was sought."""
    monkeypatch.setitem(EFFORTS, "fast", replace(EFFORTS["fast"], work=1_000))
    states = [f"x{k}" for k in range(4)]
    file = tmp_path / "four.toml"
    file.write_text(
        f"[system]\nstates = {json.dumps(states)}\nrhs = {json.dumps([f'-{x} + x0*{x}' for x in states])}\n",
        encoding="utf-8",
    )
    assert "no larger region was sought" in invoke("check", str(file)).out
    assert "no larger region was sought" not in invoke("check", str(file), "--region", "none").out
