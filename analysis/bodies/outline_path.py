"""What the paths of a body with an outline have in common: what ends a stretch, and what happens to wheels there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from nonsmooth.analysis.bodies.body_stretch import DenseStep
from nonsmooth.analysis.bodies.first_change import first_change
from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.switching import Mode
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.trajectories.result import Event, EventKind, Piece, State
from nonsmooth.symbolic.plane import Vector, around
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.support_polygon import outer_positions, support_polygon

Wheels = frozenset[int]  # places in the scene's list of wheels


class OutlinePath(ABC):
    """Follows one body in stretches on which the same wheels carry it, or stay under its edge."""

    def __init__(self, scene: Scene) -> None:
        """For a scene with a body, all its wheels in ``scene.wheels``.

        Raises:
            ValueError: for a scene without a body.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        self._scene = scene
        places = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
        self._outline = MovingOutline(scene.body, places)

    @abstractmethod
    def _weights(self, mode: Mode, state: Floats) -> Floats:
        """The weights of the sliding wheels at a state."""

    @abstractmethod
    def _margins(self, carrying: Wheels, states: Floats) -> Floats:
        """Distances of the centre of mass from the border of the support polygon, negative outside; states (m, d)."""

    def _first_change(self, mode: Mode, part: DenseStep, *, first: bool) -> tuple[float, int, int] | None:
        """The first time in a step at which the mode ends, by which signal, and how many there are."""
        return first_change(partial(self._signals, mode), part, first=first)

    def _signals(self, mode: Mode, states: Floats) -> Floats:
        """What is positive as long as the mode goes on, at states (m, d) that begin with the pose.

        Signed depths, weights of a slide, and the support's margin, which ends a slide too: there the body could not
        leave the wheels that slide.
        """
        signs = np.full(self._outline.count, -1.0)
        signs[list(mode.carrying)] = 1.0
        signed = signs * self._outline.depths(states[:, :3])
        columns = [signed]
        if mode.sliding:
            signed[:, list(mode.sliding)] = 1.0
            weights = np.array([self._weights(mode, state) for state in states])
            columns += [weights, 1 - weights]
        return np.column_stack([*columns, self._margins(mode.carrying, states)])

    def _piece(self, mode: Mode, start: float, times: Sequence[float], state: Callable[[float], Floats]) -> Piece:
        """A stretch that is over, of a path by the time."""
        names = tuple(str(self._scene.wheels[k].index) for k in sorted(mode.touched))

        def pose(since: float) -> State:
            return tuple(state(start + float(since))[:3].tolist())

        return Piece(start, times[-1], f"wheels {', '.join(names)}", names, pose, tuple(times))

    def _tipping(self, time: float, pose: Floats, carrying: Wheels) -> Event:
        over = tipping_edge(self._scene, carrying, pose)
        return Event(time, tuple(pose.tolist()), EventKind.TIPS, over)


def wheel_changes(scene: Scene, before: Mode, after: Mode) -> Iterator[tuple[EventKind, str]]:
    """What happens to wheels from one stretch to the next: each kind of change, in words."""
    changes = (
        (EventKind.SLIDE, frozenset(after.sliding) - frozenset(before.sliding), "under the edge"),
        (EventKind.ENTER, after.carrying - before.carrying, "under the body"),
        (EventKind.LEAVE, before.touched - after.touched, "beside the body"),
    )
    for kind, wheels, words in changes:
        if wheels:
            yield kind, f"wheel {', '.join(str(scene.wheels[k].index) for k in sorted(wheels))} {words}"


def tipping_edge(scene: Scene, carrying: frozenset[int], pose: Floats) -> str:
    """The side of the hull of the carrying wheels that the centre of mass is farthest beyond, in words.

    Args:
        scene: the array.
        carrying: places in its list of wheels.
        pose: of the body.
    """
    number = {scene.wheels[k].position: scene.wheels[k].index for k in carrying}
    if not number:
        return "with no wheel under it"
    if len(number) == 1:
        return f"over wheel {min(number.values())}"
    corners = support_polygon(outer_positions(list(number)))
    sides = [(number[a], number[b], _line_distance(a, b, pose)) for a, b in around(corners)]
    first, second, _ = min(sides, key=lambda side: side[2])
    return f"over the line through wheels {first} and {second}"


def _line_distance(a: Vector, b: Vector, pose: Floats) -> float:
    """Distance of the centre of mass from the inner side of the line through two corners; negative beyond it."""
    (ax, ay), (bx, by) = ((float(x), float(y)) for x, y in (a, b))
    along = np.array([bx - ax, by - ay])
    return float((along[0] * (pose[1] - ay) - along[1] * (pose[0] - ax)) / np.hypot(*along))
