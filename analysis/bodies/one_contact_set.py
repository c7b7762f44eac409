"""A path of a body with an outline on one set of wheels, up to where another set carries it.

What is known of one set, such as a certified law, ends where a wheel enters or leaves.  Within every step of the path
the depths of all wheels are looked at in some places; the time at which one changes its sign is then right to rounding.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.trajectories.follow import DenseStep, Guards, first_event
from nonsmooth.analysis.trajectories.result import End, EndReason, Event, EventKind, Piece, Trajectory, samples
from nonsmooth.symbolic.contact_set import whole
from nonsmooth.symbolic.number_text import numbers_text
from nonsmooth.symbolic.scene import Scene

LOOKS = 12  # places within a step where depths are looked at


class OneContactSet:
    """The wheels that carry the body of a scene at its checked pose.

    Raises:
        ValueError: for a scene without a body.
    """

    def __init__(self, scene: Scene) -> None:
        if scene.body is None:
            raise ValueError("required a scene with a body")
        wheels = whole(scene).wheels
        self.carrying = tuple(wheel.index for wheel in scene.wheels)
        self._numbers = [wheel.index for wheel in wheels]
        self._outline = MovingOutline(scene.body, np.array([[float(x) for x in wheel.position] for wheel in wheels]))
        self._signs = np.array([1.0 if number in self.carrying else -1.0 for number in self._numbers])

    def require_start(self, start: Sequence[float]) -> None:
        """Refuse a start on other wheels.

        Raises:
            ValueError: naming both sets.
        """
        under = self._outline.depths(np.array(start, float)) > 0
        found = tuple(number for number, carries in zip(self._numbers, under.tolist(), strict=True) if carries)
        if found != self.carrying:
            raise ValueError(
                f"required a start on wheels {numbers_text(self.carrying)}, of which alone the law is certified, "
                f"received one on {f'wheels {numbers_text(found)}' if found else 'none'}"
            )

    def until_change(self, path: Trajectory) -> Trajectory:
        """A path with finite pieces, cut where the first wheel enters or leaves; there it ends."""
        for piece in path.pieces:
            change = self._first_change(piece)
            if change is not None:
                return self._cut(path, *change)
        return path

    def _first_change(self, piece: Piece) -> tuple[float, int] | None:
        """When the first wheel comes or goes, and its place among all."""
        guards = _SameWheels(self._signs, self._outline)
        for step in _steps_of(piece):
            before, after = guards.at(step.start, step.first), guards.at(step.end, step.last)
            found = first_event(guards, before, after, step)
            if found is not None:
                return found
        return None

    def _cut(self, path: Trajectory, time: float, wheel: int) -> Trajectory:
        """The path up to a time, with the event of a wheel that ends it."""
        pieces = [_until(piece, time) for piece in path.pieces if piece.start <= time]
        state = pieces[-1].state(time - pieces[-1].start)
        leaves = self._signs[wheel] > 0
        kind, words = (EventKind.LEAVE, "beside") if leaves else (EventKind.ENTER, "under")
        told = Event(time, state, kind, f"wheel {self._numbers[wheel]} {words} the body")
        end = End(time, state, EndReason.WHEELS)
        events = (*(event for event in path.events if event.t <= time), told)
        times, states = samples(pieces, end)
        return replace(path, times=times, states=states, events=events, end=end, pieces=tuple(pieces))


class _SameWheels(Guards):
    """Signed depths of all wheels, positive as long as the same wheels carry."""

    looks = LOOKS

    def __init__(self, signs: Floats, outline: MovingOutline) -> None:
        self._signs, self._outline = signs, outline
        self.slacks = [0.0] * len(signs)

    def at(self, t: float, x: Floats) -> Sequence[float]:
        """All signed depths."""
        return (self._signs * self._outline.depths(x)).tolist()

    def at_all(self, times: Sequence[float], states: Floats) -> list[Sequence[float]]:
        """The same at many poses."""
        return (self._signs * self._outline.depths(states)).tolist()


def _steps_of(piece: Piece) -> Iterator[DenseStep]:
    """A piece as steps between its sample times."""

    def pose(time: float) -> Floats:
        return np.array(piece.state(time - piece.start), float)

    def poses(times: float | Floats) -> Floats:
        return pose(times) if isinstance(times, float) else np.array([pose(time) for time in times.tolist()]).T

    for before, after in pairwise(float(time) for time in piece.times):
        yield DenseStep((before, pose(before)), (after, pose(after)), lambda: poses)


def _until(piece: Piece, time: float) -> Piece:
    if piece.end is not None and piece.end <= time:
        return piece
    return replace(piece, end=time, times=(*(t for t in piece.times if t < time), time))
