"""Regions of arrays as triangles at the command line: words, JSON, certificates, and why there is none."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from nonsmooth.proofs.answers import array_basin
from nonsmooth.proofs.answers.array_basin import NoBasin, find_array_basin
from nonsmooth.proofs.systems.basin import BasinEffort
from nonsmooth.proofs.systems.basin_rings import Pace
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.oracles.measured_tables import MeasuredTable
from tests.reports.conftest import Invoke

COARSE = BasinEffort(Pace(0.2, 0.05, 0.04), 15, way=12.0, triangles=40_000)


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(array_basin.EFFORTS, "fast", (COARSE,))


@pytest.mark.usefixtures("coarse")
def test_the_command(invoke: Invoke, tmp_path: Path) -> None:
    """Words, JSON, and a certificate that verify accepts line by line."""
    file = tmp_path / "four.json"
    found = invoke("check", "four-wheel", "--region", "fast", "--certificate", str(file), "--json")
    assert found.status == 0
    record = json.loads(found.out)["basin"]
    assert record["share"]["sampled"] > 0.9
    assert record["ends_within"] is None
    assert "from anywhere in a region of 3." in record["text"]
    assert len(record["vertices"]) == len(record["values"]) > 100
    verified = invoke("verify", str(file))
    assert verified.status == 0
    assert f"attracts: from one of {len(record['simplices'])} triangles" in " ".join(verified.out.split())


@pytest.mark.parametrize(("name", "why"), [("rule", "has no cells"), ("rest", "reaches the border")])
def test_why_there_is_none(name: str, why: str, tmp_path: Path) -> None:
    """A rule without cells, and bodies that rest all over the square: one line."""
    table = MeasuredTable.random(2, "ellipse" if name == "rule" else "box", off=9.0)
    file = tmp_path / "table.toml"
    file.write_text(table.toml)
    found = find_array_basin(load_scene(str(file)), "fast", lambda what, done, total: None)
    assert isinstance(found, NoBasin)
    assert why in found.why
