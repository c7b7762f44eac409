"""The motion of a body on each set of wheels that may carry it, under a rule without cells.

Along a path few sets are met, each many times, so what a set needs is built once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.contact_rule import SmoothRule
from nonsmooth.analysis.dynamics.drag import needs_drag
from nonsmooth.analysis.dynamics.ellipse_path import Minimize, path_minimizer
from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.proved import resists_every_motion
from nonsmooth.analysis.minimizers.smooth_newton import SmoothNewton
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.number_text import place_text
from nonsmooth.symbolic.scene import Scene

Wheels = frozenset[int]  # places in the scene's list of wheels


class TippedError(Exception):
    """No loads balance the weight: the centre of mass is not over the hull of the wheels."""


class ContactSets:
    """Pose rates ``(c', theta')`` by set of carrying wheels."""

    def __init__(self, scene: Scene, rule: SmoothRule) -> None:
        self.scene, self._rule = scene, rule
        self._models: dict[Wheels, ContactModel] = {}
        self._loads: dict[Wheels, MovingLoads] = {}
        self._minimizers: dict[Wheels, Minimize] = {}
        self._quick: dict[Wheels, SmoothNewton] = {}

    @property
    def is_stiff(self) -> bool:
        """Whether a little drag stands in for jumps of the twist, which makes the field very stiff."""
        return needs_drag(self._rule.contacts(self.scene))

    def rate(self, wheels: Wheels, pose: Floats) -> Floats:
        """``(c', theta')`` with exact kinematics; a little beyond the support polygon it is continued.

        Integrators try poses there; that the body tips is for :meth:`margin` to say.

        Raises:
            TippedError: for wheels that carried the body nowhere yet, and do not here.
            TrajectoryError: where the minimizer is not proved to be the motion.
        """
        loads = self._loads_on(wheels, pose).at(pose[:2])[0]
        twist = self._twist(wheels, loads, pose)
        return twist + twist[2] * np.array([-pose[1], pose[0], 0.0])

    def _twist(self, wheels: Wheels, loads: Floats, pose: Floats) -> Floats:
        """The minimizer of D: by Newton steps from the last one where contacts slip, else by interior points."""
        quick = self._quick.get(wheels)
        found = None if quick is None else quick.minimize(loads)
        if found is not None:
            return found
        minima = self._minimizers[wheels](loads)
        if not (minima.check() & resists_every_motion(self._models[wheels], loads[None]))[0]:
            place = place_text((float(pose[0]), float(pose[1])))
            raise TrajectoryError(f"required a certified motion, received a minimum without proof at {place}")
        (twist,) = minima.twists
        if quick is not None:
            quick.start_from(twist)
        return np.asarray(twist)

    def carries(self, wheels: Wheels, pose: Floats) -> bool:
        """Whether the body stands on the wheels there."""
        try:
            return self.margin(wheels, pose) > 0
        except TippedError:
            return False

    def margin(self, wheels: Wheels, pose: Floats) -> float:
        """Distance of the centre of mass from the border of the support polygon, negative outside.

        Raises:
            TippedError: for wheels that carried the body nowhere yet, and do not here.
        """
        return self._loads_on(wheels, pose).margin(pose[:2])

    def _loads_on(self, wheels: Wheels, pose: Floats) -> MovingLoads:
        """What gives the loads of a set, built where the body first stands on it."""
        if wheels not in self._loads:
            if len(wheels) < 3:
                raise TippedError
            model = self._rule.contacts(replace(self.scene, wheels=tuple(self.scene.wheels[k] for k in sorted(wheels))))
            try:
                self._loads[wheels] = MovingLoads(model, pose[:2])
            except LoadError:
                raise TippedError from None
            self._models[wheels], self._minimizers[wheels] = model, path_minimizer(model)
            if not needs_drag(model):
                self._quick[wheels] = SmoothNewton(model)
        return self._loads[wheels]
