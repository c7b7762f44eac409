"""A path cut into frames at a constant pace, with all that films and pages draw of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.motion.frames import Frames, WheelContact, build_frames, last_time
from nonsmooth.analysis.trajectories.result import Event, Trajectory
from nonsmooth.reports.figures.wheels import outline_of, placed, rim_length
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points, max_norm, norms, places_of, turned

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.reports.laws.feedback_loop import FeedbackLoop

RATE = 20  # frames for each second of a film: a GIF counts hundredths of a second
MOST_FRAMES = 300
SHORTEST = 3.0  # seconds of a film: faster motions are shown in slow motion
MOST_WHEELS = 150  # that are drawn: those nearest to the path
TRAIL = 500  # points of the path
LONGEST_ARROW = 4.5  # in half-lengths of the rim: not as far as to the next wheel
MARGIN = 0.05  # of the view's width, around what is shown


@dataclass(frozen=True, eq=False)
class Film:
    """A path with its frames.

    Attributes:
        scene: the array.
        title: what is shown, in a line.
        frames: at equal steps of time, the first at the start and the last at the end of the path.
        events: switches along the path, by time.
        seconds: how long the film runs.
        trail: the path's points (k, 2).
        outline: corners of the body from its reference point, at heading zero; None where the scene gives none.
        is_closed: whether a law sets the speeds.
    """

    scene: Scene
    title: str
    frames: Frames
    events: tuple[Event, ...]
    seconds: float
    trail: Floats
    outline: Floats | None
    is_closed: bool

    @property
    def duration(self) -> float:
        """How long the motion takes, in the scene's time."""
        return float(self.frames.times[-1])

    @property
    def pace(self) -> float:
        """Time of the scene for each second of the film."""
        return self.duration / self.seconds if self.seconds else 1.0

    @property
    def pace_text(self) -> str:
        """The pace in words."""
        if abs(self.pace - 1) < 1e-6:
            return "real time"
        return f"{self.pace:.3g} x real time"

    @cached_property
    def shown(self) -> list[int]:
        """Positions of the wheels that are drawn: all, or those nearest to the path."""
        places = self.places
        if len(places) <= MOST_WHEELS:
            return list(range(len(places)))
        gaps = np.hypot(*(places[:, None] - self.trail[None, ::10]).transpose(2, 0, 1)).min(axis=1)
        return sorted(np.argsort(gaps, kind="stable")[:MOST_WHEELS].tolist())

    @property
    def places(self) -> Floats:
        """Where the wheels are (n, 2)."""
        return places_of(self.scene.wheels)

    @property
    def rims(self) -> Floats:
        """Unit vectors along the rims (n, 2)."""
        return float_points(wheel.unit_direction for wheel in self.scene.wheels)

    @property
    def axes(self) -> Floats:
        """Unit vectors along the friction axes (n, 2)."""
        return float_points(wheel.unit_grip for wheel in self.scene.wheels)

    @cached_property
    def view(self) -> tuple[float, float, float, float]:
        """Left, right, low and high end of what is shown (length)."""
        rim = self.rim
        around = self.places[self.shown]
        parts = [around - 3 * rim, around + 3 * rim, self.trail]
        if self.outline is not None:
            parts += [placed(self.outline, pose) for pose in self.frames.poses[:: max(1, len(self.frames) // 20)]]
        low, high = np.vstack(parts).min(axis=0), np.vstack(parts).max(axis=0)
        room = MARGIN * float((high - low).max())
        (left, bottom), (right, top) = low - room, high + room
        return float(left), float(right), float(bottom), float(top)

    @cached_property
    def rim(self) -> float:
        """Half of a rim's length, as drawn."""
        places = self.places[self.shown]
        return rim_length(places, np.vstack([places, self.trail]))

    @cached_property
    def arrow_scale(self) -> float:
        """Length that an arrow has for each unit of speed, the same for speeds of rims and slips.

        The longest arrow of a rim, or of a wheel that carries, reaches as far as :data:`LONGEST_ARROW`.
        """
        slips, speeds = self.frames.slips[:, self.shown], self.frames.speeds[:, self.shown]
        sizes = norms(slips)[self.frames.contacts[:, self.shown] != WheelContact.FREE]
        largest = max(_largest(speeds), _largest(sizes))
        return LONGEST_ARROW * self.rim / largest if largest > 0 else 0.0

    def slip_arrows(self, k: int) -> Floats:
        """Slips of frame k as vectors of the plane, as long as they are drawn (n, 2); nan where there is none.

        Those of wheels that carry nothing are cut to the longest arrow.
        """
        slips, axes = self.frames.slips[k], self.axes
        sides = turned(axes)
        arrows = self.arrow_scale * (slips[:, :1] * axes + slips[:, 1:] * sides)
        lengths = norms(arrows)
        longest = LONGEST_ARROW * self.rim
        cut = np.where(lengths > longest, longest / np.where(lengths > 0, lengths, 1.0), 1.0)
        return arrows * cut[:, None]

    def speed_arrows(self, k: int) -> Floats:
        """Speeds of the rims of frame k in the same way."""
        return self.arrow_scale * self.frames.speeds[k][:, None] * self.rims


def build_film(
    scene: Scene,
    trajectory: Trajectory,
    partition: Partition | None = None,
    loop: FeedbackLoop | None = None,
) -> Film:
    """Cut a path into frames.

    Raises:
        ValueError: for a path without an end in time that can be shown.
    """
    duration = last_time(trajectory)
    if not math.isfinite(duration):
        raise ValueError(f"required a path that ends at a finite time, received one until {duration}")
    times, seconds = frame_times(duration)
    inputs = None if loop is None or partition is None else loop.inputs(partition)
    pivot = _pivot(scene, trajectory, closed=loop is not None)
    frames = build_frames(scene, trajectory, times, partition=partition, inputs=inputs, pivot=pivot)
    return Film(
        scene=scene,
        title=_title(scene, trajectory, partition, loop),
        frames=frames,
        events=tuple(event for event in trajectory.events if float(event.t) <= duration),
        seconds=seconds,
        trail=trajectory.sample(np.linspace(0, duration, TRAIL))[:, :2],
        outline=outline_of(scene),
        is_closed=loop is not None,
    )


def frame_times(duration: float) -> tuple[Floats, float]:
    """Equal steps over a path, and the seconds of the film: real time where that makes 3 to 15 seconds."""
    if duration <= 0:
        return np.zeros(1), 0.0
    seconds = min(max(duration, SHORTEST), (MOST_FRAMES - 1) / RATE)
    steps = round(seconds * RATE)
    return np.linspace(0, duration, steps + 1), steps / RATE


def _pivot(scene: Scene, trajectory: Trajectory, *, closed: bool) -> Sequence[float] | None:
    """The point about which leading-order kinematics turn; None under exact ones."""
    if trajectory.kinematics == Kinematics.EXACT:
        return None
    return scene.check.place if closed else (0.0, 0.0)


def _title(scene: Scene, trajectory: Trajectory, partition: Partition | None, loop: FeedbackLoop | None) -> str:
    rule = scene.contact.rule if partition is None else partition.rule
    head = f"{one_line(scene.name)}: "
    if trajectory.method == "dynamics":
        head += "full dynamics"
    else:
        head += f"rule {rule}, {trajectory.kinematics} kinematics"
        head += ", without inertia" if scene.inertia is not None else ""
    return head if loop is None else f"{head}, {loop.title}, k = {loop.gain:g}"


def _largest(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return max_norm(known)
