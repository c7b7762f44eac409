"""``nonsmooth stress`` through the command line: formats, exit statuses, an interrupt, progress."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import pytest

from nonsmooth.analysis.measurements.harness import Case, ResultRow, Rows, judged, refused
from nonsmooth.proofs import measurements
from nonsmooth.reports.checks.measurements import Stress
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import INTERRUPTED, run
from tests.thorough import keep, thorough

GOOD = judged("spirals", "loss 1e-3", "1e5 switches", 1e-13, 1e-12, condition=1e3, why="rounding")
SILENT = refused("loads", "1e-3 outside", "the body tips there", expected=True)
BAD = judged("spirals", "loss 1e-5", "1e7 switches [b]", 1e-3, 1e-12, why="rounding")


def with_rows(monkeypatch: pytest.MonkeyPatch, *rows: ResultRow, interrupt: bool = False) -> None:
    def case(scene: object) -> Rows:
        yield from rows
        if interrupt:
            raise KeyboardInterrupt

    monkeypatch.setattr(measurements, "CASES", (Case("family", array=case),))


@thorough  # the small one: test_files
def test_a_whole_system_prints_every_row(capsys: pytest.CaptureFixture[str]) -> None:
    status = run(app, ["stress", "line-of-equilibria", "--json"])
    output = capsys.readouterr()
    record = json.loads(output.out)
    assert (status, record["schema"], record["scene"]) == (0, "nonsmooth-stress/1", "line-of-equilibria")
    assert record["ok"] is record["complete"] is True
    assert len(record["rows"]) >= 30
    assert {tuple(row) for row in record["rows"]} == {tuple(Stress.keys)}
    assert output.err == ""  # no progress where standard error is no terminal


@pytest.mark.parametrize(("rows", "expected"), [((GOOD, SILENT), 0), ((GOOD, BAD), 1)])
def test_the_status_says_whether_all_is_ok(
    rows: tuple[ResultRow, ...], expected: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with_rows(monkeypatch, *rows)
    assert run(app, ["stress", "four-wheel"]) == expected
    text = " ".join(capsys.readouterr().out.split())
    assert ("four-wheel: 2 rows, all ok" in text) == (not expected)
    assert ("not ok: spirals, loss 1e-5: 1e7 switches [b]; error <= 1e-12: rounding" in text) == bool(expected)


def test_files(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with_rows(monkeypatch, GOOD, SILENT, BAD)
    for suffix in ("json", "csv", "svg"):
        target = tmp_path / f"stress.{suffix}"
        assert run(app, ["stress", "four-wheel", "-o", str(target)]) == 1
        assert capsys.readouterr().out == f"{target}: four-wheel: 3 rows, 1 not ok\n"
        assert target.stat().st_size > 0
    with (tmp_path / "stress.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["ok"] for row in rows] == ["True", "True", "False"]
    assert (rows[1]["error"], float(rows[0]["error"])) == ("", 1e-13)
    assert json.loads((tmp_path / "stress.json").read_text())["rows"][1]["error"] is None


@pytest.mark.parametrize("suffix", keep(0, ["svg", "png", "pdf"]))  # the small one: test_files
def test_pictures_of_equal_rows_are_equal(
    suffix: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with_rows(monkeypatch, GOOD, SILENT, BAD)
    first, again = (tmp_path / f"{name}.{suffix}" for name in ("first", "again"))
    for target in (first, again):
        assert run(app, ["stress", "four-wheel", "-o", str(target)]) == 1
    capsys.readouterr()
    assert first.read_bytes() == again.read_bytes()


def test_an_interrupt_keeps_what_is_finished(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with_rows(monkeypatch, GOOD, SILENT, interrupt=True)
    assert run(app, ["stress", "four-wheel", "--json", "-o", str(tmp_path / "some.json")]) == INTERRUPTED
    record = json.loads(capsys.readouterr().out)
    assert [row["case"] for row in record["rows"]] == ["spirals", "loads"]
    assert record["complete"] is record["ok"] is False
    assert json.loads((tmp_path / "some.json").read_text()) == record
    assert run(app, ["stress", "four-wheel"]) == INTERRUPTED
    assert "interrupted, later cases are missing" in " ".join(capsys.readouterr().out.split())


def test_a_number_that_is_none_is_null(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with_rows(monkeypatch, judged("spirals", "loss 1e-3", "1e5 switches", math.nan, 1.0, why="rounding"))
    assert run(app, ["stress", "four-wheel", "--json"]) == 1
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    assert (row["error"], row["ok"]) == (None, False)
