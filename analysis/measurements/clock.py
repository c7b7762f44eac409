"""A time limit that work asks after wherever it loops.

Cooperative: nothing is interrupted from outside, so the limit is overrun by at most one step of a loop, results are
never half-made, and no signal, thread or second process is needed.  Time is the processor time of this process (all its
threads): what a method costs, whatever else the machine does meanwhile.
"""

from __future__ import annotations

import time


class OutOfTime(Exception):
    """A trial that reached its time limit."""


class Clock:
    """A time limit that work asks after.

    Args:
        seconds: the limit, from now, in processor time.
    """

    def __init__(self, seconds: float) -> None:
        self._start, self._limit = time.process_time(), seconds

    @property
    def elapsed(self) -> float:
        """Seconds of processor time since the start."""
        return time.process_time() - self._start

    def check(self) -> None:
        """Raise :class:`OutOfTime` once the limit is reached."""
        if self.elapsed > self._limit:
            raise OutOfTime
