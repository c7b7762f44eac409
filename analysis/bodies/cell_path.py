"""The path of a body with an outline under a rule with cells, from event to event.

It is a solution of a switched field of poses (:mod:`nonsmooth.analysis.bodies.outline_field`) and is followed as every
other one (:mod:`nonsmooth.analysis.trajectories.smooth_path`): through the cells of the wheels that carry, along
borders of cells and along edges over wheels, where Filippov's construction mixes motions.  Here its switches are told
apart: wheels that ``enter`` and ``leave``, wheels under the edge that the body slides along (``slide``), and where it
``tips``.  All is counted in the scene's length l, so that a path is the same in every unit of length.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.outline_field import OutlineField
from nonsmooth.analysis.bodies.set_cells import CellsBySet
from nonsmooth.analysis.bodies.supports import CarryingWheels, finite_start, tipping_edge, wheel_changes
from nonsmooth.analysis.contact_rule import CellRule
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.switched_field import Face
from nonsmooth.analysis.trajectories.faces import FaceChoice
from nonsmooth.analysis.trajectories.follow import Mode, Path
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.analysis.trajectories.smooth_path import MAX_EVENTS, MAX_WORK, FilippovFaces, Weights, near_rounding
from nonsmooth.symbolic.contact_set import require_elastic
from nonsmooth.symbolic.numbers.work_limit import WorkMeter
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
        path = _OnWheels(self._field, self._scene).path(self._own(pose).tolist(), until, near_rounding(self._field))
        return path.in_lengths(self._length)

    def _own(self, pose: Sequence[float] | Floats) -> Floats:
        """A pose with the scene's length l for the unit."""
        return np.array(pose, float) / [self._length, self._length, 1.0]


class _OnWheels(FilippovFaces):
    """The solutions of the field, with the wheels that come and go told apart from other switches."""

    def __init__(self, field: OutlineField, scene: Scene) -> None:
        super().__init__(field, None, WorkMeter(MAX_WORK), MAX_EVENTS)
        self._outlined, self._scene = field, scene

    def next_mode(self, path: Path) -> Mode | EndReason:
        """The next face; beyond the border of the field the body tips."""
        mode = super().next_mode(path)
        if mode is not EndReason.OUTSIDE:
            return mode
        path.tell(EventKind.TIPS, tipping_edge(self._scene, self._outlined.under(path.state), path.state))
        return EndReason.TIPS

    def tell_switch(self, path: Path, choice: FaceChoice, weights: Weights) -> None:
        """Where wheels come or go, one event for each kind of change."""
        face, before = choice.motion.face, self.before
        told = False
        if before is not None:
            for kind, words in wheel_changes(self._scene, self._wheels(before), self._wheels(face)):
                mixed = {"weights": weights, "rates": choice.rates} if face.keep else {}
                path.tell(kind, words, **mixed)
                told = True
        if not told:
            super().tell_switch(path, choice, weights)

    def _wheels(self, face: Face) -> CarryingWheels:
        """The wheels that carry in all cells of a face, and those that carry in some."""
        sets = [self._outlined.wheels_of[member.name] for member in face.members]
        carrying = frozenset.intersection(*sets)
        return CarryingWheels(carrying, tuple(sorted(frozenset.union(*sets) - carrying)))
