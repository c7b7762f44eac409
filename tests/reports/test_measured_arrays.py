"""Headings in whole degrees and positions in millimetres, through the command line: every check ends soon.

The benchmarks hold the same at large (``tests/benchmarks/test_measured_speed.py``).
"""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest

from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from tests.measured_arrays import Kind, measured_array
from tests.thorough import few, keep

LONGEST = 10  # seconds of processor time


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@few(3)
@pytest.mark.parametrize("rule", ["nearest", "box", "ellipse"])
@pytest.mark.parametrize("kind", keep(2, Kind))
@pytest.mark.parametrize("seed", keep(1, [4, 1]))
def test_a_check_of_a_measured_array_ends_soon(
    kind: Kind, seed: int, rule: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "my.toml"
    path.write_text(measured_array(kind, seed), encoding="utf-8")
    start = time.process_time()
    status = run(app, ["check", str(path), "--rule", rule, "--json"])
    assert time.process_time() - start < LONGEST
    record = json.loads(capsys.readouterr().out)
    assert status == {"holds": 0, "undecided": 3}.get(record["theorem4"]["verdict"], 1)
    assert len(record["notes"]) == 1
    if kind is Kind.MIRRORED and rule != "nearest":  # a map of the array onto itself keeps no velocity but zero
        assert record["equilibrium"]["verdict"] == "holds"


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@few(3)
@pytest.mark.parametrize("rule", ["nearest", "box", "ellipse"])
@pytest.mark.parametrize("field", ['kind = "spiral"\nangle = "pi/180"', 'kind = "radial"\nspeed = "cos(pi/180)"',
                                   'kind = "radial"\nspeed = "cos(2*pi/359)"'])  # fmt: skip
def test_one_angle_of_high_degree_ends_soon(
    field: str, rule: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "my.toml"
    ring = '[ring]\ncount = 4\nradius = "sqrt(2)"\nphase = "pi/4"\n'
    path.write_text(f"[friction]\nmu_roll = 1\nmu_side = 0.5\n{ring}[field]\n{field}\n", encoding="utf-8")
    start = time.process_time()
    assert run(app, ["check", str(path), "--rule", rule, "--json"]) in {0, 1, 3}
    assert time.process_time() - start < LONGEST
    record = json.loads(capsys.readouterr().out)
    assert record["equilibrium"]["verdict"] == "holds"
    assert len(record["notes"]) == 1
