"""Accumulating switches of smooth fields (Zeno): the limit of a loop of crossings that repeats ever faster.

When a loop of crossings repeats with durations in a ratio q below one, the tail of the geometric series is the time
left, and its error is about ``tail |change of q|/(1 - q)``.  As soon as that error is below ``ZENO_ERROR`` the limit of
time and state is taken (Aitken's extrapolation).  Crossings get slower, and their times less sure: where the error
begins to grow the limit before is taken, if it was below ``ZENO_NOISE``.  Loops that never get so regular, or whose
durations fall more slowly than any geometric series, run on until the largest number of events, or until they are
within the slack of a corner.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.analysis.trajectories.result import Piece

ZENO_ERROR = 1e-12  # relative to the time passed: the integrator's own error
ZENO_NOISE = 1e-9  # the same, where rounding keeps loops from getting more regular
ZENO_DRAWN = 1e-3  # relative to the time passed: longer tails are followed turn by turn
ZENO_LOOP = 4  # longest loop of crossings that is recognized, in crossings


@dataclass(frozen=True)
class _Estimate:
    """The time and state of a limit, with an estimate of the error of the time, by the last two turns of a loop."""

    loop: int
    time: float
    x: Vector
    error: float


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
        self._before: _Estimate | None = None

    def limit_after(self, time: float, x: Vector, place: str, until: float) -> LoopLimit | None:
        """Take note of a crossing out of ``place``; the limit, if a loop converges regularly before ``until``."""
        self.times.append(time)
        self.states.append(x)
        self.places.append(place)
        before, now = self._before, self._estimate()
        self._before = now
        if now is None:
            return None
        if now.error <= ZENO_ERROR * time:
            return self._limit(now) if now.time < until else None
        if before is None or now.error < before.error or before.error > ZENO_NOISE * time:
            return None
        return self._limit(before) if time < before.time < until else None

    def _estimate(self) -> _Estimate | None:
        """The surest one, by the loops that repeat; None where none does, or all tails are long enough to be drawn."""
        found = []
        for loop in range(1, ZENO_LOOP + 1):
            if len(self.times) < 3 * loop + 1 or self.places[-loop:] != self.places[-2 * loop : -loop]:
                continue
            turns = [self.times[k] - self.times[k - loop] for k in (-1 - 2 * loop, -1 - loop, -1)]
            if not turns[0] > turns[1] > turns[2] > 0:
                continue
            ratio = turns[2] / turns[1]
            factor = ratio / (1 - ratio)
            tail, change = turns[2] * factor, abs(ratio - turns[1] / turns[0])
            if tail < ZENO_DRAWN * self.times[-1]:
                x = self.states[-1] + (self.states[-1] - self.states[-1 - loop]) * factor
                found.append(_Estimate(loop, self.times[-1] + tail, x, tail * change / (1 - ratio)))
        return min(found, key=lambda estimate: estimate.error, default=None)

    def _limit(self, found: _Estimate) -> LoopLimit:
        start, here, tail = self.times[-1], self.states[-1], found.time - self.times[-1]
        names = tuple(dict.fromkeys(self.places[-found.loop :]))

        def state(time: float) -> tuple[float, ...]:
            return tuple((here + (found.x - here) * min(time / tail, 1.0)).tolist())

        piece = Piece(start, found.time, " | ".join(names), names, state, (start, found.time))
        return LoopLimit(found.time, found.x, self.states[-found.loop :], piece)
