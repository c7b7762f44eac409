"""Measuring: the best of several runs within one process, and one printed line per comparison."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest


class Stopwatch:
    """Wall-clock times in seconds."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys

    def best(self, work: Callable[[], object], runs: int = 5) -> float:
        """Shortest of several runs: the one that other processes disturbed least."""
        times = []
        for _ in range(runs):
            start = time.perf_counter()
            work()
            times.append(time.perf_counter() - start)
        return min(times)

    def in_turn(self, slow: Callable[[], object], fast: Callable[[], object], rounds: int = 5) -> tuple[float, float]:
        """Shortest runs of slow and of fast work, done in turn, since a machine's speed changes within seconds.

        Fast work is done several times in each round: one short run may fall into a slow moment.
        """
        times = [(self.best(slow, runs=1), self.best(fast, runs=10)) for _ in range(rounds)]
        return min(first for first, _ in times), min(second for _, second in times)

    def report(self, line: str) -> None:
        """Print a result past pytest's capture."""
        with self._capsys.disabled():
            print(f"\n  {line}", end="")


@pytest.fixture
def stopwatch(capsys: pytest.CaptureFixture[str]) -> Stopwatch:
    """Times work and reports ratios."""
    return Stopwatch(capsys)
