"""Arrays as they are measured, at large: a hundred of each kind under every rule, and scenes that are too large."""

from __future__ import annotations

import json
import statistics
import time
from collections import Counter
from pathlib import Path

import pytest

from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from tests.benchmarks.conftest import Stopwatch
from tests.measured_arrays import Kind, measured_array

ARRAYS = 100
MEDIAN, LONGEST = 1, 10  # seconds of processor time
RULES = ("nearest", "box", "ellipse")
MINUTES = 120  # seconds for whatever is too large: an answer, or one line that says what is too much


def checked(path: Path, rule: str, capsys: pytest.CaptureFixture[str]) -> tuple[float, str]:
    """Seconds and verdict of ``check --json``."""
    start = time.process_time()
    status = run(app, ["check", str(path), "--rule", rule, "--json"])
    seconds = time.process_time() - start
    printed = capsys.readouterr()
    if status == 2:
        assert printed.err.count("\n") == 1
        return seconds, "refused"
    return seconds, str(json.loads(printed.out)["theorem4"]["verdict"])


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", Kind)
def test_a_hundred_measured_arrays(
    kind: Kind, rule: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], stopwatch: Stopwatch
) -> None:
    path, times, verdicts = tmp_path / "my.toml", list[float](), Counter[str]()
    for seed in range(ARRAYS):
        path.write_text(measured_array(kind, seed), encoding="utf-8")
        seconds, verdict = checked(path, rule, capsys)
        times.append(seconds)
        verdicts[verdict] += 1
    median, longest = statistics.median(times), max(times)
    stopwatch.report(f"{ARRAYS} {kind}, {rule}: median {median:.2f} s, longest {longest:.2f} s, {dict(verdicts)}")
    assert median <= MEDIAN
    assert longest <= LONGEST


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("count", [101, 360])
def test_rings_of_many_wheels_end(
    count: int, rule: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], stopwatch: Stopwatch
) -> None:
    path = tmp_path / "my.toml"
    ring = f"[ring]\ncount = {count}\n[check]\nradius = 0.25\n"
    path.write_text(f"[friction]\nmu_roll = 1\nmu_side = 0.2\n{ring}", encoding="utf-8")
    seconds, verdict = checked(path, rule, capsys)
    stopwatch.report(f"ring of {count}, {rule}: {seconds:.1f} s, {verdict}")
    assert seconds <= MINUTES
