"""Accumulating switches of smooth fields (Zeno): the limit of a loop of crossings that repeats ever faster.

When a loop of crossings repeats with durations in a ratio q below one, the tail of the geometric series is the time
left, and its error is about ``tail |change of q|/(1 - q)``.  As soon as that error is below ``ZENO_ERROR`` the limit of
time and state is taken (Aitken's extrapolation).  Loops that never get so regular, or whose durations fall more slowly
than any geometric series, run on until the largest number of events, or until they are within the slack of a corner.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.analysis.trajectories.result import Piece

ZENO_ERROR = 1e-12  # relative to the time passed: the integrator's own error
ZENO_DRAWN = 1e-3  # relative to the time passed: longer tails are followed turn by turn
ZENO_LOOP = 4  # longest loop of crossings that is recognized, in crossings


@dataclass(frozen=True)
class LoopLimit:
    """Limit of a loop.

    Attributes:
        time: limit time.
        x: extrapolated limit state.
        states: states at the crossings of the last loop.
        piece: what is left, drawn as a straight line.
    """

    time: float
    x: Vector
    states: list[Vector]
    piece: Piece


class LoopMemory:
    """The crossings of a path since it last slid or rested."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self.states: list[Vector] = []
        self.places: list[str] = []

    def limit_after(self, time: float, x: Vector, place: str, until: float) -> LoopLimit | None:
        """Take note of a crossing out of ``place``; the limit, if a loop converges regularly before ``until``."""
        self.times.append(time)
        self.states.append(x)
        self.places.append(place)
        for loop in range(1, ZENO_LOOP + 1):
            if len(self.times) < 3 * loop + 1 or self.places[-loop:] != self.places[-2 * loop : -loop]:
                continue
            turns = [self.times[k] - self.times[k - loop] for k in (-1 - 2 * loop, -1 - loop, -1)]
            if not turns[0] > turns[1] > turns[2] > 0:
                continue
            ratio = turns[2] / turns[1]
            change = abs(ratio - turns[1] / turns[0])
            tail = turns[2] * ratio / (1 - ratio)
            if tail < min(ZENO_DRAWN * time, until - time) and tail * change <= ZENO_ERROR * time * (1 - ratio):
                return self._limit(loop, tail, ratio / (1 - ratio))
        return None

    def _limit(self, loop: int, tail: float, factor: float) -> LoopLimit:
        start, here = self.times[-1], self.states[-1]
        x = here + (here - self.states[-1 - loop]) * factor
        names = tuple(dict.fromkeys(self.places[-loop:]))

        def state(time: float) -> tuple[float, ...]:
            return tuple((here + (x - here) * min(time / tail, 1.0)).tolist())

        piece = Piece(start, start + tail, " | ".join(names), names, state, (start, start + tail))
        return LoopLimit(start + tail, x, self.states[-loop:], piece)
