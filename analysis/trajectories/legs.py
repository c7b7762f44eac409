"""The legs of a path: its stretches with the motions that it follows, for those who differentiate along it."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.fields.switched_field import Surface, Vector
from nonsmooth.analysis.trajectories.face_motion import FaceMotion
from nonsmooth.analysis.trajectories.follow import Stretch


@dataclass(frozen=True)
class Leg:
    """A stretch of a path with the motion that it follows.

    Attributes:
        motion: on the face that it keeps to.
        stretch: times, states and dense output; its end is not yet moved onto the surface it met.
        last: where it ends, on the surfaces it met.
        met: the surface it met at its end, if any.
    """

    motion: FaceMotion
    stretch: Stretch
    last: Vector
    met: tuple[Surface, ...]

    @property
    def start(self) -> float:
        """Time at which it begins."""
        return float(self.stretch.times[0])

    @property
    def end(self) -> float:
        """Time at which it ends."""
        return float(self.stretch.times[-1])

    @property
    def first(self) -> Vector:
        """Where it begins."""
        return self.stretch.states[0]

    def at(self, time: float) -> Vector:
        """State at a time of the path within the leg."""
        return self.stretch.at(time)
