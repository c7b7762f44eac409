"""``nonsmooth partition SCENE --compare``: table, JSON and picture."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.analysis.partitions.agreement import compare_rules
from nonsmooth.reports.agreement_views import agreement_map, agreement_record
from nonsmooth.reports.cli import app
from nonsmooth.reports.console import run
from nonsmooth.symbolic.files.scene_file import load_scene


def test_record_holds_exact_shares() -> None:
    record = agreement_record(compare_rules(load_scene("ring-6")))["agreement"]
    assert Fraction(record["nearest_box"]["exact"]["share"]) == Fraction(1, 2)
    assert record["nearest_box"]["share"] == 0.5
    assert len(record["nearest_box"]["shared_twists"]) == 12
    for other in ("ellipse_nearest", "ellipse_box"):
        assert 0 < record[other]["mean"] <= record[other]["largest"]
    json.dumps(record, allow_nan=False)


def test_pictures_are_reproducible_vectors() -> None:
    agreement = compare_rules(load_scene("four-wheel"))
    first, second = (agreement_map(agreement, ".svg") for _ in range(2))
    assert first == second
    assert first.startswith(b"<?xml")


def test_the_command_prints_the_table_and_writes_the_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(app, ["partition", "four-wheel", "--compare"]) == 0
    assert "share of 0 of the area (exact)" in " ".join(capsys.readouterr().out.replace("│", " ").split())
    target = tmp_path / "agreement.png"
    assert run(app, ["partition", "four-wheel", "--compare", "-o", str(target)]) == 0
    assert target.read_bytes().startswith(b"\x89PNG")


def test_a_body_that_tips_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "agreement.svg"
    assert run(app, ["partition", "four-wheel", "--radius", "2", "--compare", "-o", str(target)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "support polygon" in error
    assert not target.exists()
