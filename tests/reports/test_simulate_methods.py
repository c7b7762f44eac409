"""``simulate --method``: hysteresis and smoothing follow the event-driven path within their width."""

from __future__ import annotations

import json
from contextlib import redirect_stdout
from io import StringIO
from typing import Any

import pytest

from nonsmooth.reports.cli import app
from nonsmooth.reports.console import run

WIDTH = 1e-3
ERROR_PER_WIDTH = 4  # as in tests/analysis/test_hysteresis.py


def end_of(*options: str) -> tuple[str, list[float]]:
    stream = StringIO()
    with redirect_stdout(stream):
        start = ("--from", "0.4,0.15,0", "--until", "0.3")
        assert run(app, ["simulate", "four-wheel", *start, *options, "--json"]) == 0
    record: dict[str, Any] = json.loads(stream.getvalue())
    return record["method"], record["end"]["state"]


@pytest.mark.parametrize("method", ["hysteresis", "smoothed"])
def test_layers_stay_near_the_events(method: str) -> None:
    _, exact = end_of()
    name, found = end_of("--method", method, "--width", str(WIDTH))
    assert name == method
    assert found != exact
    assert found == pytest.approx(exact, abs=ERROR_PER_WIDTH * WIDTH)
