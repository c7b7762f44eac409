"""``nonsmooth partition SCENE --compare``: table, JSON and picture."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

from nonsmooth.reports.checks.agreement import compare_scene
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.reports.conftest import Invoke


def test_record_holds_exact_shares() -> None:
    record = compare_scene(load_scene("ring-6")).facts()["agreement"]
    assert Fraction(record["nearest_box"]["exact"]["share"]) == Fraction(1, 2)
    assert record["nearest_box"]["share"] == 0.5
    assert len(record["nearest_box"]["shared_twists"]) == 12
    for other in ("ellipse_nearest", "ellipse_box"):
        assert 0 < record[other]["mean"] <= record[other]["largest"]
    json.dumps(record, allow_nan=False)


def test_pictures_are_reproducible_vectors() -> None:
    compared = compare_scene(load_scene("four-wheel"))
    first, second = (compared.content(".svg") for _ in range(2))
    assert first == second
    assert first.startswith(b"<?xml")


def test_the_command_prints_the_table_and_writes_the_picture(invoke: Invoke, tmp_path: Path) -> None:
    shown = invoke("partition", "four-wheel", "--compare")
    assert shown.status == 0
    assert "share of 0 of the area (exact)" in " ".join(shown.out.replace("│", " ").split())  # 1 - 2 mu_S/mu_R
    assert invoke("partition", "four-wheel", "--compare", "-o", "agreement.png").status == 0
    assert (tmp_path / "agreement.png").read_bytes().startswith(b"\x89PNG")
