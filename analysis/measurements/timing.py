"""Processor time of a method, within a limit that work asks after wherever it loops.

Cooperative: nothing is interrupted from outside, so the limit is overrun by at most one step of a loop, results are
never half-made, and no signal, thread or second process is needed.  Time is the processor time of this process (all its
threads): what a method costs, whatever else the machine does meanwhile.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

REPEATED = 0.25  # share of the time limit that the runs of one trial may take together
BETWEEN = 0.01  # seconds between two looks at the processor time

Result = TypeVar("Result")


class OutOfTime(Exception):
    """A trial that reached its time limit."""


class Clock:
    """A time limit that work asks after.

    Args:
        seconds: the limit, from now, in processor time.
    """

    def __init__(self, seconds: float) -> None:
        self._start, self._limit = time.process_time(), seconds
        self._asked = time.perf_counter()

    @property
    def elapsed(self) -> float:
        """Seconds of processor time since the start."""
        return time.process_time() - self._start

    def check(self) -> None:
        """Raise :class:`OutOfTime` once the limit is reached.

        Work asks at every step, and asking the system for processor time may take longer than the step does: within
        :data:`BETWEEN` it is not asked again.
        """
        now = time.perf_counter()
        if now - self._asked < min(BETWEEN, self._limit / 10):
            return
        self._asked = now
        if self.elapsed > self._limit:
            raise OutOfTime


@dataclass(frozen=True)
class Limits:
    """How long to measure.

    Attributes:
        runs: number of runs of which the shortest counts; fewer where they would take more than :data:`REPEATED` of
            the limit, since long runs are disturbed less.
        seconds: time limit of one run.
    """

    runs: int = 3
    seconds: float = 5.0


def timed(work: Callable[[Clock], Result], limits: Limits) -> tuple[Result, float]:
    """The result of the first run, and the time of the shortest: the one that the machine disturbed least.

    Raises:
        OutOfTime: where the first run takes longer than the limit.
    """
    clock = Clock(limits.seconds)
    result = work(clock)
    clock.check()
    best = clock.elapsed
    for _ in range(limits.runs - 1):
        if clock.elapsed + best > REPEATED * limits.seconds:
            break
        again = Clock(limits.seconds)
        work(again)
        best = min(best, again.elapsed)
    return result, best
