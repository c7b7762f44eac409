"""The spatial twist along a path, from the path alone.

A pose moves by ``theta' = omega`` and ``c' = v + omega J q``, where q is c under exact kinematics, and one fixed point
under leading-order kinematics.  So ``xi = (v, omega)`` follows from the derivative of the pose, whatever moved the
body: also while it slides along an edge, where no cell's own twist is the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.plane_arrays import turned
from nonsmooth.analysis.trajectories.result import Piece, Trajectory

Times: TypeAlias = NDArray[Any]

STEP = 1e-4  # of a piece's duration: differences of second order err by its square, rounding by about 1e-12/1e-4


def last_time(trajectory: Trajectory) -> float:
    """The last finite time of a path."""
    return float(trajectory.times[-1])


def poses_at(trajectory: Trajectory, times: Times) -> Floats:
    """States (m, 3) at times; between samples a straight line where the method keeps samples only."""
    return _Path(trajectory).poses(np.asarray(times, float))


def path_twists(trajectory: Trajectory, times: Times, pivot: Sequence[float] | None = None) -> Floats:
    """Twists ``(v_x, v_y, omega)`` at times, shape (m, 3): at a switch those of the motion that begins there.

    Args:
        trajectory: of ``(x, y, theta)``.
        times: within the path.
        pivot: q where it is fixed (leading-order kinematics); None for exact kinematics, where it is c.
    """
    path, at = _Path(trajectory), np.asarray(times, float)
    rates = np.array([path.rate(float(time)) for time in at]).reshape(-1, 3)
    points = path.poses(at)[:, :2] if pivot is None else np.broadcast_to(np.asarray(pivot, float), (len(at), 2))
    velocities = rates[:, :2] - rates[:, 2:] * turned(points)
    return np.column_stack([velocities, rates[:, 2]])


class _Path:
    """A path whose smooth stretches are found by their times: its pieces, or else the lines between its samples."""

    def __init__(self, trajectory: Trajectory) -> None:
        last = last_time(trajectory)
        spans = [(_span(piece, last), piece) for piece in trajectory.pieces]
        self.pieces = [piece for (start, end), piece in spans if end > start]
        self.spans = [span for span, _ in spans if span[1] > span[0]]
        self.starts = np.array([start for start, _ in self.spans])
        self.times = np.array([float(time) for time in trajectory.times])
        self.states = trajectory.array

    def poses(self, times: Floats) -> Floats:
        """States (m, 3)."""
        if not self.pieces:
            return np.column_stack([np.interp(times, self.times, column) for column in self.states.T])
        return np.array([self._pose(self._stretch(time), time) for time in times.tolist()]).reshape(-1, 3)

    def rate(self, time: float) -> Floats:
        """The derivative of the pose, by differences of second order within the stretch that holds a time."""
        if not self.pieces:
            return self._slope(time)
        k = self._stretch(time)
        start, end = self.spans[k]
        step, middle = STEP * (end - start), min(max(time, start), end)
        if middle - step < start:
            here, near, far = (self._pose(k, middle + i * step) for i in range(3))
            return np.asarray((4 * near - far - 3 * here) / (2 * step))
        if middle + step > end:
            here, near, far = (self._pose(k, middle - i * step) for i in range(3))
            return np.asarray((3 * here - 4 * near + far) / (2 * step))
        return np.asarray((self._pose(k, middle + step) - self._pose(k, middle - step)) / (2 * step))

    def _stretch(self, time: float) -> int:
        """The piece about a time; the later one of two that meet."""
        return max(int(np.searchsorted(self.starts, time, side="right")) - 1, 0)

    def _pose(self, k: int, time: float) -> Floats:
        start, end = self.spans[k]
        since = min(max(time, start), end) - start
        exact = not isinstance(self.pieces[k].start, float)
        return np.array([float(x) for x in self.pieces[k].state(Fraction(since) if exact else since)])

    def _slope(self, time: float) -> Floats:
        """Of the line between two samples; zero for a path of one."""
        after = int(np.searchsorted(self.times, time, side="right"))
        after = min(max(after, 1), len(self.times) - 1)
        span = self.times[after] - self.times[after - 1] if after else 0.0
        return (self.states[after] - self.states[after - 1]) / span if span > 0 else np.zeros(3)


def _span(piece: Piece, last: float) -> tuple[float, float]:
    end = last if piece.end is None else min(float(piece.end), last)
    return float(piece.start), end
