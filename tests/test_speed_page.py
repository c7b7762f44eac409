"""The committed page on speed: it shows every comparison that is made, and none that was missed."""

from __future__ import annotations

import re
from pathlib import Path

from tests.speed_page import COMMANDS, MEASURED, MOST, PAIRS, SIDES

PAGE = Path(__file__).parents[1] / "docs" / "speed.md"


def measured_rows(part: str) -> list[list[str]]:
    """The entries of the table of a measured part, without its header."""
    found = next(match for match in MEASURED.finditer(PAGE.read_text(encoding="utf-8")) if match[2] == part)
    lines = [line.strip("| ").split(" | ") for line in found[0].splitlines() if line.startswith("| ")]
    return lines[2:]


def test_every_ratio_is_shown_and_reached() -> None:
    rows = measured_rows("ratios")
    assert [row[:2] for row in rows] == [[pair.work, pair.other] for pair in PAIRS]
    for row, pair in zip(rows, PAIRS, strict=True):
        assert float(row[5]) == pair.required
        assert float(row[4]) >= pair.required


def test_every_start_is_shown_and_fast() -> None:
    rows = measured_rows("starts")
    assert [row[0] for row in rows] == [f"`nonsmooth {' '.join(command)}`" for command in COMMANDS]
    assert all(float(row[1]) <= MOST for row in rows)


def test_growth_is_shown() -> None:
    rows = measured_rows("growth")
    assert [int(row[0]) for row in rows] == [side**2 for side in SIDES]
    assert all(re.fullmatch(r"[0-9.]+", entry) for row in rows for entry in row)


def test_comparisons_exist() -> None:
    for pair in PAIRS:
        assert (Path(__file__).parent / "benchmarks" / f"{pair.source}.py").exists()
