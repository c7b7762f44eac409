"""One solution of the motion of a body between events, by one integrator or the other, piece by piece.

Where friction ellipses are whole the field is analytic between its kinks (:mod:`nonsmooth.analysis.bodies.set_motion`).
There Runge-Kutta steps of order 8 hold the regime in which they begin; a step beyond the end of the regime is cut off
there, so that kinks cost no order.  Where many such steps are needed the field is stiff, and LSODA goes on.  Drag makes
the field so stiff that backward differentiation formulas follow it from the start.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.analysis.bodies.set_motion import SetMotion
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.trajectories.result import TrajectoryError

RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE = 1e-13, 1e-12  # per step, with which events are right to 1e-10
STIFF_TOLERANCES = 1e-10, 1e-12  # of the same where drag makes the field stiff and forces carry its rounding
MANY_STEPS = 150  # of Runge-Kutta in one stretch, after which the field is taken for stiff
LOOKS = 8  # places within a step where a regime is looked at that some trial pose has left
AHEAD = 1e-7  # of a stretch's time scale: where the next regime is read off
CLOSE = 1e-10  # of a step: error of the end of a regime, which enters the path by its square

Rate = Callable[[float, Floats], Floats]


@dataclass(frozen=True)
class Part:
    """The dense output of a step, and the times between which it holds."""

    start: float
    end: float
    state: Any


class Parts:
    """The parts of one stretch."""

    def __init__(self, rate: Rate, motions: Sequence[SetMotion], scale: float, size: float, *, drags: bool) -> None:
        """For a right-hand side made of some sets' motions; ``scale`` is the time in which a body crosses itself."""
        self._rate, self._motions, self._scale, self._size, self._drags = rate, motions, scale, size, drags

    def from_pose(self, pose: Floats, start: float, until: float) -> Iterator[Part]:
        """One after the other, up to the last time.

        Raises:
            TrajectoryError: where the integrator stops.
        """
        from scipy.integrate import BDF, LSODA

        time, taken = start, 0
        try:
            if not self._drags:
                for part in self._smooth_parts(pose, start, until):
                    yield part
                    time, pose, taken = part.end, part.state(part.end), taken + 1
                    if taken == MANY_STEPS:
                        break
        finally:
            for motion in self._motions:
                motion.release()
        if time >= until:
            return
        method = BDF if self._drags else LSODA
        relative, absolute = STIFF_TOLERANCES if self._drags else (1e-12,1e-14)
        solver = method(self._rate, time, pose, until, rtol=relative, atol=absolute)
        while solver.status == "running":
            before, state = solver.t, _stepped(solver)
            yield Part(before, solver.t, state)

    def _smooth_parts(self, pose: Floats, start: float, until: float) -> Iterator[Part]:
        """Runge-Kutta steps, each in one regime; they end early where a regime cannot be continued."""
        from scipy.integrate import DOP853

        time, length = start, None
        tolerances = {"rtol": RELATIVE_TOLERANCE, "atol": ABSOLUTE_TOLERANCE * self._size}
        while time < until:
            self._hold_ahead(pose, time)
            first = None if length is None else min(length, until - time)
            solver = DOP853(self._rate, time, pose, until, first_step=first, **tolerances)
            end = solver.t
            while end == solver.t < until:
                for motion in self._motions:
                    motion.lowest = np.inf
                try:
                    state = _stepped(solver)
                except TrajectoryError:
                    return
                end = self._end_of_regime(state, time, solver.t)
                yield Part(time, end, state)
                time, pose, length = end, state(end), float(solver.h_abs)

    def _hold_ahead(self, pose: Floats, time: float) -> None:
        """Let every set hold the regime that follows the pose."""
        for motion in self._motions:
            motion.release()
        ahead = pose + AHEAD * self._scale * self._rate(time, pose)
        for motion in self._motions:
            motion.hold(ahead)

    def _end_of_regime(self, state: Any, low: float, high: float) -> float:
        """The time within a step at which some regime ends; that of the step's end where none does."""
        def validity(time: float) -> float:
            return min(motion.validity(state(time)) for motion in self._motions)

        if all(motion.lowest >= 0 for motion in self._motions) and validity(high) >= 0:
            return high
        marks = np.linspace(low, high, LOOKS + 1)
        for before, after in zip(marks, marks[1:], strict=False):
            if validity(after) >= 0:
                continue
            if validity(before) <= 0:  # the regime was read off wrongly: go a little way in it
                return min(low + AHEAD * self._scale, high)
            while after - before > CLOSE * (high - low):
                middle = (before + after) / 2
                before, after = (middle, after) if validity(middle) >= 0 else (before, middle)
            return float(after)
        return high


def _stepped(solver: Any) -> Any:
    """The dense output of the next step."""
    message = solver.step()
    if solver.status == "failed":
        raise TrajectoryError(f"the integrator stopped at t = {solver.t:.6g}: {message}")
    return solver.dense_output()
