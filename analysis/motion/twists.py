"""The spatial twist along a path, from the path alone.

A pose moves by ``theta' = omega`` and ``c' = v + omega J q``, where q is c under exact kinematics, and one fixed point
under leading-order kinematics.  So ``xi = (v, omega)`` follows from the derivative of the pose, whatever moved the
body: also while it slides along an edge, where no cell's own twist is the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.plane_arrays import turned
from nonsmooth.analysis.trajectories.result import Piece, Trajectory

Times: TypeAlias = NDArray[Any]

STEP = 1e-4  # of a piece's duration: differences of second order err by its square, rounding by about 1e-12/1e-4


def last_time(trajectory: Trajectory) -> float:
    """The last finite time of a path."""
    return float(trajectory.times[-1])


def poses_at(trajectory: Trajectory, times: Times) -> Floats:
    """States (m, 3) at times; between samples a straight line where the method keeps samples only."""
    if trajectory.pieces:
        return trajectory.sample(times.tolist())
    own, states = np.array([float(t) for t in trajectory.times]), trajectory.array
    return np.column_stack([np.interp(times, own, column) for column in states.T])


def path_twists(trajectory: Trajectory, times: Times, pivot: Sequence[float] | None = None) -> Floats:
    """Twists ``(v_x, v_y, omega)`` at times, shape (m, 3): at a switch those of the motion that begins there.

    Args:
        trajectory: of ``(x, y, theta)``.
        times: within the path.
        pivot: q where it is fixed (leading-order kinematics); None for exact kinematics, where it is c.
    """
    poses = poses_at(trajectory, times)
    rates = np.array([_rate(trajectory, float(time)) for time in times]).reshape(-1, 3)
    points = poses[:, :2] if pivot is None else np.broadcast_to(np.asarray(pivot, float), (len(times), 2))
    velocities = rates[:, :2] - rates[:, 2:] * turned(points)
    return np.column_stack([velocities, rates[:, 2]])


def _rate(trajectory: Trajectory, time: float) -> Floats:
    """The derivative of the pose within the smooth stretch that holds a time."""
    start, end = _stretch(trajectory, time)
    if not end > start:
        return np.zeros(3)
    if not trajectory.pieces:
        first, second = poses_at(trajectory, np.array([start, end]))
        return np.asarray((second - first) / (end - start))
    step = STEP * (end - start)
    middle = min(max(time, start), end)
    if middle - step < start:
        here, near, far = poses_at(trajectory, middle + step * np.arange(3.0))
        return np.asarray((4 * near - far - 3 * here) / (2 * step))
    if middle + step > end:
        here, near, far = poses_at(trajectory, middle - step * np.arange(3.0))
        return np.asarray((3 * here - 4 * near + far) / (2 * step))
    before, after = poses_at(trajectory, middle + step * np.array([-1.0, 1.0]))
    return np.asarray((after - before) / (2 * step))


def _stretch(trajectory: Trajectory, time: float) -> tuple[float, float]:
    """Where the smooth stretch about a time begins and ends; the later one of two that meet, if there is one."""
    last = last_time(trajectory)
    if not trajectory.pieces:
        own = np.array([float(t) for t in trajectory.times])
        after = min(max(int(np.searchsorted(own, time, side="right")), 1), len(own) - 1)
        return float(own[after - 1]), float(own[after])
    spans = [span for span in (_span(piece, last) for piece in trajectory.pieces) if span[1] > span[0]]
    return next((span for span in reversed(spans) if span[0] <= time), (time, time))


def _span(piece: Piece, last: float) -> tuple[float, float]:
    end = last if piece.end is None else min(float(piece.end), last)
    return float(piece.start), end
