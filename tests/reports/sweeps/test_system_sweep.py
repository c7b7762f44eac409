"""Sweeps of plain systems against checks one by one, and borders against eigenvalues and closed forms."""

from __future__ import annotations

import csv
import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.reports.sweeps.base import base_of
from nonsmooth.reports.sweeps.sweep import Means, Sweep, run_sweep
from nonsmooth.reports.sweeps.sweep_plan import read_plan
from tests.reports.conftest import Invoke
from tests.thorough import thorough

RELAY: dict[str, Any] = {"states": ["x", "y"], "rhs": ["y", "-a*x - k*y - sgn(x)"], "parameters": {"k": 1, "a": 0}}
INTERVAL: dict[str, Any] = {"states": ["x"], "rhs": ["-sgn(x)*(1 - k*x)"], "parameters": {"k": 4}}


def swept(system: dict[str, Any], vary: dict[str, str], means: Means | None = None, draws: int | None = None) -> Sweep:
    base = base_of({"system": system}, "t", Path("t.toml"))
    return run_sweep(base, read_plan(vary, base.document, base.file, draws), means or Means())


def written(folder: Path, system: dict[str, Any]) -> str:
    lines = [f"{key} = {json.dumps(value)}" for key, value in system.items() if key != "parameters"]
    values = ", ".join(f"{name} = {json.dumps(value)}" for name, value in system["parameters"].items())
    file = folder / "system.toml"
    file.write_text("[system]\n" + "\n".join(lines) + f"\nparameters = {{ {values} }}\n")
    return str(file)


def test_rows_are_checks_one_by_one() -> None:
    found = swept(RELAY, {"k": "-1,1/2", "a": "1"})
    system = ns.System(RELAY["states"], RELAY["rhs"], parameters=RELAY["parameters"])
    values = [(-1, 1), ("1/2", 1)]
    for outcome, (k, a) in zip(found.outcomes, values, strict=True):
        check = system.check(parameters={"k": k, "a": a})
        assert outcome["stability"] == check.verdict
        assert outcome["V"] == check.lyapunov or outcome["V"] is None
        region = check.to_dict()["lyapunov"]["region"]
        assert outcome["level"] == (None if region is None else region["level"])


def test_the_border_of_a_linear_system_is_where_its_eigenvalues_cross() -> None:
    system = {"states": ["x", "y"], "rhs": ["y - x", "k*x - 2*y"], "parameters": {"k": 0}}
    found = swept(system, {"k": "0:4:3"}, Means(borders=True))
    first, last = found.borders or ()
    assert first.point[0].number == last.point[0].number == 2.0
    assert (first.before, last.after) == (("asymptotically stable",), ("unstable",))
    assert first.after == first.there == last.there == last.before == ("stable",)  # a line of equilibria
    for k in (first.below.number, last.above.number):
        assert abs(np.linalg.eigvals(np.array([[-1.0, 1.0], [float(k or 0), -2.0]])).real.max()) < 1e-8


def test_random_draws_agree_with_the_formula_of_the_region() -> None:
    """The field ``-sgn(x)(1 - k x)`` turns at ``x = 1/k``."""
    found = swept(INTERVAL, {"k": "3:9"}, draws=8)
    for k, outcome in enumerate(found.outcomes):
        value = found.plan.point(k)[0].number
        assert value is not None
        assert outcome["to"] == pytest.approx(1 / value, rel=1e-12)
        assert outcome["from"] == -0.5


@thorough
def test_an_end_of_an_interval_varies() -> None:
    system = {"states": ["x", "y"], "rhs": ["y", "-x - k*y"], "parameters": {"k": [1, 2]}}
    found = swept(system, {"k.low": "-1,1"})
    assert [outcome["stability"] == "asymptotically stable" for outcome in found.outcomes] == [False, True]


def test_a_store_knows_what_was_checked(tmp_path: Path) -> None:
    means = Means(store=tmp_path / "store.db")
    first, second = (swept(INTERVAL, {"k": "1:5:3"}, means) for _ in range(2))
    assert (first.checked, second.checked) == (3, 0)
    assert first.outcomes == second.outcomes


def test_files_of_all_kinds(invoke: Invoke, tmp_path: Path) -> None:
    file = written(tmp_path, INTERVAL)
    done = invoke("sweep", file, "--vary", "k=-1:5:3", "--workers", "1", "-o", str(tmp_path / "rows.csv"))
    assert done.status == 0
    rows = list(csv.DictReader((tmp_path / "rows.csv").read_text().splitlines()))
    assert [row["system.parameters.k exact"] for row in rows] == ["-1", "2", "5"]
    assert Fraction(rows[2]["to"]) == Fraction("0.2")
    for vary in (["--vary", "k=-1:5:3"], ["--vary", "k=-1:5:2", "--vary", "radius=1/4,1/2"]):
        done = invoke("sweep", file, *vary, "--workers", "1", "-o", str(tmp_path / "picture.svg"))
        assert done.status == 0
        assert b"asymptotically stable" in (tmp_path / "picture.svg").read_bytes()


def test_in_python() -> None:
    system = ns.System(["x"], INTERVAL["rhs"], parameters={"k": 4})
    found = system.sweep(k="1:5:3")
    assert [row["stability"] for row in found.rows()] == ["asymptotically stable"] * 3
    assert "asymptotically stable" in repr(found)
    assert "stability" in found._repr_html_()
