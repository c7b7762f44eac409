"""What is to be seen at a time of a path: pose, twist, speeds of the rims, slips, and which wheels carry the body.

With the twist ``xi = (v, omega)`` of the body at a time, the body point over wheel i moves with
``v(p_i) = v + omega J p_i``; the slip is ``(d_i . v(p_i) - u_i, n_i . v(p_i))``, along the rim and across it.

The contact set: under a rule that keeps rows the wheels whose rows are kept in a cell whose closure holds the centre
of mass (of both cells while the body slides along an edge), under others the wheels whose load is not zero.  A wheel
sticks where its slip is zero to within :data:`STICKS`; floats tell no more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.cells.cell_complex import float_polygon
from nonsmooth.analysis.cells.contact_rule import contact_rule
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.constant_field import Speeds, control_columns
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.fields.convex_weights import nearest_weights
from nonsmooth.analysis.fields.polygon_field import CellSides
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.trajectories.result import Piece, Trajectory
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, max_norms, norms, turned

# ---- the spatial twist along a path, from the path alone -----------------------------------------
#
# A pose moves by ``theta' = omega`` and ``c' = v + omega J q``, where q is c under exact kinematics, and one fixed
# point under leading-order kinematics.  So ``xi = (v, omega)`` follows from the derivative of the pose, whatever moved
# the body: also while it slides along an edge, where no cell's own twist is the motion.


Times: TypeAlias = NDArray[Any]

STEP = 1e-4  # of a piece's duration: differences of second order err by its square, rounding by about 1e-12/1e-4


def last_time(trajectory: Trajectory) -> float:
    """The last finite time of a path."""
    return float(trajectory.times[-1])


def path_twists(trajectory: Trajectory, times: Times, pivot: Sequence[float] | None = None) -> Floats:
    """Twists ``(v_x, v_y, omega)`` at times, shape (m, 3): at a switch those of the motion that begins there.

    Args:
        trajectory: of ``(x, y, theta)``.
        times: within the path.
        pivot: q where it is fixed (leading-order kinematics); None for exact kinematics, where it is c.
    """
    path, at = _Path(trajectory), np.asarray(times, float)
    rates = np.array([path.rate(float(time)) for time in at]).reshape(-1, 3)
    points = trajectory.sample(at)[:, :2] if pivot is None else np.broadcast_to(np.asarray(pivot, float), (len(at), 2))
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
        self.times = trajectory.t
        self.states = trajectory.array

    def rate(self, time: float) -> Floats:
        """The derivative of the pose, by differences of second order within the stretch that holds a time."""
        if not self.pieces:
            return self._slope(time)
        k = self._stretch(time)
        start, end = self.spans[k]
        step, middle = STEP * (end - start), min(max(time, start), end)
        if middle - step < start:
            here, near, far = (self._pose(k, middle + i * step) for i in range(3))
            return (4 * near - far - 3 * here) / (2 * step)
        if middle + step > end:
            here, near, far = (self._pose(k, middle - i * step) for i in range(3))
            return (3 * here - 4 * near + far) / (2 * step)
        return (self._pose(k, middle + step) - self._pose(k, middle - step)) / (2 * step)

    def _stretch(self, time: float) -> int:
        """The piece about a time; the later one of two that meet."""
        return max(int(np.searchsorted(self.starts, time, side="right")) - 1, 0)

    def _pose(self, k: int, time: float) -> Floats:
        start, end = self.spans[k]
        since = min(max(time, start), end) - start
        exact = not isinstance(self.pieces[k].start, float)
        return np.array(self.pieces[k].state(Fraction(since) if exact else since), float)

    def _slope(self, time: float) -> Floats:
        """Of the line between two samples; zero for a path of one."""
        after = int(np.searchsorted(self.times, time, side="right"))
        after = min(max(after, 1), len(self.times) - 1)
        span = self.times[after] - self.times[after - 1] if after else 0.0
        return (self.states[after] - self.states[after - 1]) / span if span > 0 else np.zeros(3)


def _span(piece: Piece, last: float) -> tuple[float, float]:
    end = last if piece.end is None else min(float(piece.end), last)
    return float(piece.start), end


# ---- frames --------------------------------------------------------------------------------------


STICKS = 1e-6  # slip over the largest speed: above the error of a difference along a path (1e-8)
LOADED = 1e-9  # of the weight: a smaller load is rounding of none
MIXED = 1e-6  # smaller weights of a cell's motion are rounding of none, as where an edge is crossed
ON_EDGE = 1e-9  # of the square's size: the distance within which a path keeps to an edge it slides along


class WheelContact(IntEnum):
    """What a wheel does."""

    FREE = 0
    SLIPS = 1
    STICKS = 2


@dataclass(frozen=True, eq=False)
class Frames:
    """A path at m times, over n wheels.

    Attributes:
        times: shape (m,).
        poses: ``(x, y, theta)``, shape (m, 3).
        twists: ``(v_x, v_y, omega)``, shape (m, 3).
        speeds: ``u_i``, shape (m, n); nan where a law gives a wheel none, as it does not act.
        slips: along the rim and across it, shape (m, n, 2); that along the rim is nan where the speed is.
        contacts: values of :class:`WheelContact`, shape (m, n).
    """

    times: Floats
    poses: Floats
    twists: Floats
    speeds: Floats
    slips: Floats
    contacts: Indices

    def __len__(self) -> int:
        return len(self.times)


def build_frames(
    scene: Scene,
    trajectory: Trajectory,
    times: ArrayLike,
    *,
    partition: Partition | None = None,
    inputs: Sequence[Speeds] | None = None,
    pivot: Sequence[float] | None = None,
) -> Frames:
    """The frames of a path.

    Args:
        scene: the array.
        trajectory: of ``(x, y, theta)``.
        times: at which.
        partition: the cells it goes through; None under rules without cells, and for a body with mass.
        inputs: under feedback, the speeds from the pose in each cell of the partition; None for the scene's own.
        pivot: see :func:`nonsmooth.analysis.motion.frames.path_twists`.

    Raises:
        nonsmooth.analysis.cells.loads.LoadError: where loads decide and there are none.
    """
    at = np.asarray(times, float)
    model = contact_model(scene)
    poses, twists = trajectory.sample(at), path_twists(trajectory, at, pivot)
    keeps_rows = partition is not None and contact_rule(partition.rule).keeps_rows
    if partition is None or not keeps_rows:
        carrying = _loaded(scene, model, poses)
        speeds = np.broadcast_to(model.speeds, carrying.shape)
    else:
        cells = _CellsAt(partition, scene)
        held = [cells.holding(pose) for pose in poses]
        carrying = np.array([cells.carrying(found) for found in held])
        speeds = np.broadcast_to(model.speeds, carrying.shape)
        if inputs is not None:
            mixed = [
                cells.mixed_speeds(found, inputs, pose, xi) for found, pose, xi in zip(held, poses, twists, strict=True)
            ]
            speeds = np.array(mixed)
    slips = wheel_slips(model, twists, speeds)
    contacts = np.where(
        carrying, np.where(_sticks(slips, twists, model, speeds), WheelContact.STICKS, WheelContact.SLIPS), 0
    )
    return Frames(at, poses, twists, np.array(speeds), slips, contacts)


def _loaded(scene: Scene, model: ContactModel, poses: Floats) -> Mask:
    """The wheels whose load is not zero, shape (m, n); of a body with an outline among those under it."""
    if scene.body is None:
        return loads_at(model, poses[:, :2]) > LOADED
    under = MovingOutline(scene.body, model.positions).depths(poses) >= 0
    loaded = np.zeros_like(under)
    for carrying in np.unique(under, axis=0):
        places, frames = np.flatnonzero(carrying), np.flatnonzero((under == carrying).all(axis=1))
        try:
            loads = loads_at(model.on(places.tolist()), poses[frames, :2])
        except LoadError:  # where it tips
            loads = np.ones((len(frames), len(places)))
        loaded[np.ix_(frames, places)] = loads > LOADED
    return loaded


def wheel_slips(model: ContactModel, twists: Floats, speeds: Floats) -> Floats:
    """``(d_i . v(p_i) - u_i, n_i . v(p_i))`` for twists (m, 3) and speeds (m, n); shape (m, n, 2).

    Along and across the friction axes, where these are not the rims.
    """
    surface = model.targets_of(speeds).reshape(*speeds.shape, 2)
    moving = (twists @ model.rows.T).reshape(*speeds.shape, 2)
    return moving - surface


def _sticks(slips: Floats, twists: Floats, model: ContactModel, speeds: Floats) -> Mask:
    """Whether a slip is zero beside the largest speed of any rim or body point over a wheel, at each time."""
    moving = max_norms(twists @ model.rows.T)
    largest = np.maximum(moving, np.nanmax(np.abs(speeds), axis=1, initial=0.0))
    return np.nan_to_num(norms(slips), nan=np.inf) <= STICKS * largest[:, None]


class _CellsAt:
    """The cells of a partition whose closure holds a point, in floats."""

    def __init__(self, partition: Partition, scene: Scene) -> None:
        """For a scene that has the wheels of the partition, perhaps among others."""
        self.cells, self.places = partition.cells, scene.places
        self.slack = ON_EDGE * partition.size
        self.sides = CellSides([float_polygon(cell.polygon).sides for cell in partition.cells])

    def holding(self, pose: Floats) -> list[int]:
        """Positions of the cells that hold the pose's point, or are nearest to it."""
        gaps = self.sides.depths(pose[:2])
        return np.flatnonzero(gaps >= -self.slack).tolist() or [int(np.argmax(gaps))]

    def carrying(self, held: Sequence[int]) -> Mask:
        """Which wheels keep rows in some cells."""
        found = np.zeros(len(self.places), dtype=bool)
        for k in held:
            for state in self.cells[k].states:
                found[[self.places[row.wheel.index] for row in state.rows]] = True
        return found

    def mixed_speeds(self, held: Sequence[int], inputs: Sequence[Speeds], pose: Floats, twist: Floats) -> Floats:
        """The speeds of the cell; while the body slides the mean of its cells', mixed as their motions are."""
        given = [self._row(inputs[k](pose)) for k in held]
        if len(held) == 1:
            return given[0]
        motions = np.array([self._motion(k, row) for k, row in zip(held, given, strict=True)])
        weights = nearest_weights(motions, twist)
        stacked = np.array(given)
        weights = np.where(weights > MIXED, weights, 0.0)
        weights /= weights.sum()
        unknown = np.isnan(stacked[weights > 0]).all(axis=0)
        mean: Floats = weights @ np.nan_to_num(stacked)
        mean[unknown] = np.nan
        return mean

    def _row(self, speeds: Mapping[int, float]) -> Floats:
        """Speeds of all wheels; nan where one is given none."""
        row = np.full(len(self.places), np.nan)
        for wheel, speed in speeds.items():
            row[self.places[wheel]] = speed
        return row

    def _motion(self, k: int, speeds: Floats) -> Floats:
        """``sum_w g_w u_w`` with the control vector fields of a cell."""
        motion = np.zeros(3)
        for wheel, *column in control_columns(self.cells[k].states[0]):
            motion += speeds[self.places[wheel]] * np.array(column)
        return motion
