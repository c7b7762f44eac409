"""One solution of the motion of a body between events, step by step.

Where friction ellipses are whole the field is analytic between its kinks (:mod:`nonsmooth.analysis.bodies.set_motion`).
There Runge-Kutta steps of order 8 follow the pose together with twists and forces of the regime in which they begin; a
step beyond the end of the regime is cut off there, so that kinks cost no order.  Where many such steps are needed the
field is stiff, and LSODA goes on.  Where the slip of a wheel passes through zero, or drag acts, the field is so stiff
that its own rounding is all that LSODA sees: backward differentiation formulas with wider tolerances follow it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from nonsmooth.analysis.bodies.set_motion import with_kinematics
from nonsmooth.analysis.bodies.switching import Mode, Switching
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.trajectories.result import TrajectoryError

TOLERANCE = 1e-12  # of the body's size, per step, with which events are right to 1e-10
STIFF_TOLERANCES = 1e-12, 1e-14  # relative and absolute, of LSODA
ROUGH_TOLERANCES = 1e-10, 1e-12  # of the last method, where the field is so stiff that its rounding counts
MANY_STEPS = 150  # of Runge-Kutta in one stretch, after which the field is taken for stiff
MANY_STIFF_STEPS = 1_000  # of LSODA, after which rounding is taken for the field
DIFFERENCE = 1e-7  # of the body's size: for slopes of the field
LOOKS = 8  # places within a step where regimes are looked at
AHEAD = 1e-7  # of the time in which the body crosses itself: where the next regime is read off
CLOSE = 1e-10  # of a step: error of the end of a regime, which enters the path by its square
UNKNOWNS = 1e-9  # error of twists and forces within a step; after it they are exact again


@dataclass(frozen=True)
class DenseStep:
    """The dense output of a step, and the times between which it holds."""

    start: float
    end: float
    state: Any


class Parts:
    """The parts of one stretch."""

    def __init__(
        self, switching: Switching, mode: Mode, pose: Floats, scale: float, size: float, *, drags: bool
    ) -> None:
        """For a mode that begins at a pose; ``scale`` is the time in which the body crosses its own ``size``."""
        self._switching, self._mode = switching, mode
        self._motions = switching.motions(mode, pose)
        self._weights = np.full(len(mode.sliding), 0.5)
        self._scale, self._size, self._drags = scale, size, drags

    def from_pose(self, pose: Floats, start: float, until: float) -> Iterator[DenseStep]:
        """One after the other, up to the last time.

        Raises:
            TrajectoryError: where the integrator stops.
        """
        time, taken = start, 0
        for part in () if self._drags else self._smooth_parts(pose, start, until):
            yield part
            time, pose, taken = part.end, part.state(part.end), taken + 1
            if taken == MANY_STEPS:
                break
        yield from self._stiff_parts(pose, time, until)

    def _stiff_parts(self, pose: Floats, time: float, until: float) -> Iterator[DenseStep]:
        """Steps of implicit methods: LSODA, and where its steps become lost in rounding backward differentiation."""
        from scipy.integrate import BDF, LSODA

        taken = 0
        for part in () if self._drags else self._steps_of(LSODA, STIFF_TOLERANCES, pose, time, until):
            yield part
            time, pose, taken = part.end, part.state(part.end), taken + 1
            if taken == MANY_STIFF_STEPS:
                break
        yield from self._steps_of(BDF, ROUGH_TOLERANCES, pose, time, until)

    def _steps_of(
        self, method: Any, tolerances: tuple[float, float], pose: Floats, time: float, until: float
    ) -> Iterator[DenseStep]:
        """Steps of one of SciPy's methods, to the end."""
        if time >= until:
            return
        relative, absolute = tolerances
        options = {} if self._drags else {"jac": self._jacobian}
        solver = method(self._rate, time, pose, until, rtol=relative, atol=absolute, **options)
        while solver.status == "running":
            before, state = solver.t, _stepped(solver)
            yield DenseStep(before, solver.t, state)

    def _rate(self, time: float, pose: Floats) -> Floats:
        rate, self._weights = self._switching.rate(self._mode, pose, self._weights)
        return rate

    def _jacobian(self, time: float, pose: Floats) -> Floats:
        """Exact where one motion acts and has a regime, else by differences."""
        exact = None if self._mode.sliding else self._motions[0].jacobian(pose)
        if exact is not None:
            return exact
        step = DIFFERENCE * self._size
        ahead = [self._rate(time, pose + step * unit) - self._rate(time, pose - step * unit) for unit in np.eye(3)]
        return np.column_stack(ahead) / (2 * step)

    # ---- regimes ---------------------------------------------------------------------------------

    def _smooth_parts(self, pose: Floats, time: float, until: float) -> Iterator[DenseStep]:
        """Runge-Kutta steps, each in one regime; they end early where a regime cannot be held."""
        from scipy.integrate import DOP853

        length, whole = None, self._held(pose, time)
        while whole is not None and time < until:
            first = None if length is None else min(length, until - time)
            errors = np.full(len(whole), UNKNOWNS)
            errors[:3] = TOLERANCE * self._size
            solver = DOP853(self._slopes, time, whole, until, first_step=first, rtol=TOLERANCE, atol=errors)
            try:
                state = _stepped(solver)
            except TrajectoryError:
                return
            end = self._end_of_regime(state, time, solver.t)
            if end is None:
                return
            yield DenseStep(time, end, lambda t, state=state: state(t)[:3])
            kept = self._kept(solver.y) if end == solver.t else None
            time, pose, length = end, state(end)[:3], float(solver.h_abs)
            whole = self._held(pose, time) if kept is None else kept

    def _held(self, pose: Floats, time: float) -> Floats | None:
        """The pose and the unknowns of the regimes that follow it."""
        ahead = pose + AHEAD * self._scale * self._rate(time, pose)
        unknowns = [motion.hold(ahead, pose) for motion in self._motions]
        if any(found is None for found in unknowns):
            return None
        known = [found for found in unknowns if found is not None]
        ends = np.cumsum([3, *(len(found) for found in known)])
        self._cuts = [slice(*pair) for pair in pairwise(ends.tolist())]
        return np.concatenate([pose, *known])

    def _slopes(self, time: float, whole: Floats) -> Floats:
        """Rates of the pose and of all unknowns."""
        pose, unknowns = whole[:3], [whole[cut] for cut in self._cuts]
        corners = [with_kinematics(found[:3], pose) for found in unknowns]
        rate, self._weights = self._switching.mixed(self._mode, pose, corners, self._weights)
        pairs = zip(self._motions, unknowns, strict=True)
        return np.concatenate([rate, *(motion.slope(pose, rate, found) for motion, found in pairs)])

    def _kept(self, whole: Floats) -> Floats | None:
        """The pose and the exact unknowns of the same regimes after a step; None where others are to be read off."""
        pose, unknowns = whole[:3], [whole[cut] for cut in self._cuts]
        kept = [pose]
        for motion, found in zip(self._motions, unknowns, strict=True):
            exact = motion.settled(pose, found)
            if exact is None or motion.is_near_rest(pose, exact):
                return None
            kept.append(exact)
        return np.concatenate(kept)

    def _end_of_regime(self, state: Any, low: float, high: float) -> float | None:
        """The time within a step at which some regime ends; that of the step's end where none does."""

        def validities(times: Floats) -> Floats:
            whole = state(times)
            pose, unknowns = whole[:3], [whole[cut] for cut in self._cuts]
            pairs = zip(self._motions, unknowns, strict=True)
            return np.min([motion.validities(pose.T, found.T) for motion, found in pairs], axis=0)

        marks = np.linspace(low, high, LOOKS + 1)
        found = validities(marks)
        if not np.isfinite(state(marks)).all():
            return None
        ended = np.flatnonzero(found[1:] < 0)
        if not len(ended):
            return high
        before, after = marks[ended[0]], marks[ended[0] + 1]
        if ended[0] == 0 and found[0] <= 0:  # the regime was read off wrongly: go a little way in it
            return min(low + AHEAD * self._scale, high)
        while after - before > CLOSE * (high - low):
            middle = (before + after) / 2
            before, after = (middle, after) if validities(np.array([middle]))[0] >= 0 else (before, middle)
        return float(after)


def _stepped(solver: Any) -> Any:
    """The dense output of the next step."""
    message = solver.step()
    if solver.status == "failed":
        raise TrajectoryError(f"the integrator stopped at t = {solver.t:.6g}: {message}")
    return solver.dense_output()
