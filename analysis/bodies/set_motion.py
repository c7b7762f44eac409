"""The motion of a body on each set of wheels that may carry it: the least dissipation, as rates of its pose."""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.ellipse_minimizer import PathMinimizer, needs_drag
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.number_text import place_text

Wheels = frozenset[int]  # places in the scene's list of wheels

TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # J, of poses


class SetMotion:
    """Pose rates ``(c', theta')`` on one set of wheels."""

    def __init__(self, model: ContactModel, pose: Floats) -> None:
        """For the contacts of the set, and a pose at which they carry the body.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where they do not.
        """
        self._loads, self._minimizer = MovingLoads(model, pose[:2]), PathMinimizer(model)

    def margins(self, poses: Floats) -> Floats:
        """Distance of the centre of mass from the border of the support polygon, negative outside; poses (m, 3)."""
        return self._loads.margins(poses[:, :2])

    def rate(self, pose: Floats) -> Floats:
        """``c' = v + omega J c, theta' = omega``; a little beyond the support polygon it is continued.

        Raises:
            TrajectoryError: where the minimizer is not proved to be the motion.
        """
        twist = self._minimizer.twist(self._loads.at(pose[:2])[0])
        if twist is None:
            place = place_text((float(pose[0]), float(pose[1])))
            raise TrajectoryError(f"required a certified motion, received a minimum without proof at {place}")
        return twist + twist[2] * np.array([-pose[1], pose[0], 0.0])

    def jacobian(self, pose: Floats) -> Floats | None:
        """Slopes of :meth:`rate` by the pose (3 x 3); None where they are not known.

        Differences would not do: beside a place where the slip of a wheel vanishes, slopes change within distances at
        which differences are lost in rounding.
        """
        omega = self.rate(pose)[2]
        slopes = self._minimizer.slopes(*self._loads.at(pose[:2]))
        if slopes is None or not np.isfinite(slopes).all():
            return None
        vx, vy, turning = np.column_stack([slopes, np.zeros(3)])
        return np.array([vx - turning * pose[1], vy + turning * pose[0], turning]) + omega * TURN


# ---- one set after the other -----------------------------------------------------------------------


class TippedError(Exception):
    """No loads balance the weight: the centre of mass is not over the hull of the wheels."""


class ContactSets:
    """Pose rates ``(c', theta')`` by set of carrying wheels."""

    def __init__(self, model: ContactModel) -> None:
        """For the contacts of all wheels, with their friction sets."""
        self._model = model
        self._motions: dict[Wheels, SetMotion] = {}
        self.evaluations = 0  # of rates so far: what a path costs

    @property
    def is_stiff(self) -> bool:
        """Whether a little drag stands in for jumps of the twist, which makes the field very stiff."""
        return needs_drag(self._model)

    def rate(self, wheels: Wheels, pose: Floats) -> Floats:
        """:meth:`nonsmooth.analysis.bodies.set_motion.SetMotion.rate` of a set.

        Raises:
            TippedError: for wheels that carried the body nowhere yet, and do not here.
            TrajectoryError: where the minimizer is not proved to be the motion.
        """
        self.evaluations += 1
        return self.motion(wheels, pose).rate(pose)

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
        return float(self.motion(wheels, pose).margins(pose[None])[0])

    def motion(self, wheels: Wheels, pose: Floats) -> SetMotion:
        """The motion on a set, built where the body first stands on it.

        Raises:
            TippedError: for wheels that carried the body nowhere yet, and do not here.
        """
        if wheels not in self._motions:
            if len(wheels) < min(3, self._model.wheels):
                raise TippedError
            try:
                self._motions[wheels] = SetMotion(self._model.on(sorted(wheels)), pose)
            except LoadError as error:
                raise TippedError from error
        return self._motions[wheels]
