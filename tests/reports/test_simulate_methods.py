"""``simulate --method``: hysteresis and smoothing follow the event-driven path within their width."""

from __future__ import annotations

import pytest

from tests.reports.conftest import Invoke

WIDTH = 1e-3
ERROR_PER_WIDTH = 4  # as in tests/analysis/test_steppers.py


def end_of(invoke: Invoke, *options: str) -> tuple[str, list[float]]:
    start = ("--from", "0.4,0.15,0", "--until", "0.3")
    found = invoke("simulate", "four-wheel", *start, *options, "--json")
    assert found.status == 0
    return found.record["method"], found.record["end"]["state"]


@pytest.mark.parametrize("method", ["hysteresis", "smoothed"])
def test_layers_stay_near_the_events(method: str, invoke: Invoke) -> None:
    _, exact = end_of(invoke)
    name, found = end_of(invoke, "--method", method, "--width", str(WIDTH))
    assert name == method
    assert found != exact
    assert found == pytest.approx(exact, abs=ERROR_PER_WIDTH * WIDTH)
