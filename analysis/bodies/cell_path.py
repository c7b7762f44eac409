"""The path of a body with an outline under a rule with cells, from event to event.

It is a solution of a switched field of poses (:mod:`nonsmooth.analysis.bodies.outline_field`) and is followed as every
other one (:mod:`nonsmooth.analysis.trajectories.smooth_path`): through the cells of the wheels that carry, along
borders of cells and along edges over wheels, where Filippov's construction mixes motions.  Here its switches are told
apart: wheels that ``enter`` and ``leave``, wheels under the edge that the body slides along (``slide``), and where it
``tips``.  All is counted in the scene's length l, so that a path is the same in every unit of length.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.outline_field import OutlineField
from nonsmooth.analysis.bodies.set_cells import CellsBySet
from nonsmooth.analysis.bodies.supports import CarryingWheels, finite_start, tipping_edge, wheel_changes
from nonsmooth.analysis.contact_rule import CellRule
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.trajectories.result import EndReason, Event, EventKind, Piece, Trajectory
from nonsmooth.analysis.trajectories.smooth_path import follow_smooth
from nonsmooth.symbolic.contact_set import require_elastic
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import counted_in_own_length


class CellPath:
    """Follows one body."""

    def __init__(self, scene: Scene, rule: CellRule) -> None:
        """For a scene with a body, all its wheels in ``scene.wheels``.

        Raises:
            ValueError: for a scene without a body.
            SceneError: for loads that are known for one set of wheels only, under a rule that needs them.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        if rule.needs_loads:
            require_elastic(scene)
        self._length = float(scene.check.length)
        self._scene = own = counted_in_own_length(scene)
        names = [str(wheel.index) for wheel in own.wheels]
        places = np.array([[float(x) for x in wheel.position] for wheel in own.wheels])
        outline = MovingOutline(own.body or scene.body, places)
        self._field = OutlineField(CellsBySet(own, rule), outline, names, self._length)

    def stands(self, pose: Sequence[float]) -> bool:
        """Whether the body stands at a pose ``(x, y, theta)``."""
        return bool(self._field.faces_at(self._own(pose)))

    def follow(self, start: Sequence[float], until: float) -> Trajectory:
        """The path from ``(x, y, theta)``, theta measured from the checked heading.

        Raises:
            ValueError: for a last time that is not positive, numbers that are not finite, and a start where the body
                tips.
            RefusalError: where the motion is not determined.
            TrajectoryError: where the path cannot be followed.
        """
        pose = finite_start(start, until)
        if not self.stands(start):
            raise ValueError("required a start where the body stands on its wheels, received one where it tips")
        return self._told(follow_smooth(self._field, self._own(pose).tolist(), until)).in_lengths(self._length)

    def _own(self, pose: Sequence[float] | Floats) -> Floats:
        """A pose with the scene's length l for the unit."""
        return np.array(pose, float) / [self._length, self._length, 1.0]

    def _told(self, path: Trajectory) -> Trajectory:
        """The same path with events of wheels, and tipping where it leaves the field."""
        events = list(self._events(path))
        end = path.end
        if end.reason is EndReason.OUTSIDE:
            pose = np.array(end.state)
            over = tipping_edge(self._scene, self._field.under(pose), pose)
            events.append(Event(end.t, end.state, EventKind.TIPS, over))
            end = replace(end, reason=EndReason.TIPS)
        return replace(path, events=tuple(events), end=end)

    def _events(self, path: Trajectory) -> Iterator[Event]:
        """Events of the switched field; where wheels come or go, one event for each kind of change instead."""
        for event in path.events:
            before = [piece for piece in path.pieces if piece.end is not None and piece.end <= event.t]
            after = [piece for piece in path.pieces if piece.start >= event.t]
            told = False
            if before and after and event.kind is not EventKind.NONUNIQUE:
                for kind, words in wheel_changes(self._scene, self._mode(before[-1]), self._mode(after[0])):
                    told = True
                    yield replace(event, kind=kind, surface=words)
            if not told:
                yield event

    def _mode(self, piece: Piece) -> CarryingWheels:
        """The wheels that carry in all cells of a stretch, and those that carry in some."""
        sets = [self._field.wheels_of[name] for name in piece.cells]
        carrying = frozenset.intersection(*sets)
        return CarryingWheels(carrying, tuple(sorted(frozenset.union(*sets) - carrying)))
