"""The motion of a body on each set of wheels that may carry it, under a rule without cells.

Along a path few sets are met, each many times, so what a set needs is built once.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.bodies.set_motion import SetMotion
from nonsmooth.analysis.bodies.some_contacts import contacts_of
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.dynamics.path_minimizer import needs_drag
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats

Wheels = frozenset[int]  # places in the scene's list of wheels


class TippedError(Exception):
    """No loads balance the weight: the centre of mass is not over the hull of the wheels."""


class ContactSets:
    """Pose rates ``(c', theta')`` by set of carrying wheels."""

    def __init__(self, model: ContactModel) -> None:
        """For the contacts of all wheels, with their friction sets."""
        self._model = model
        self._motions: dict[Wheels, SetMotion] = {}
        self.evaluations = 0  # of rates so far: what a path costs
        self._last = np.zeros(3)  # twist of any set: where Newton's method begins on a new one

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
        motion = self.motion(wheels, pose)
        if self._last.any():
            motion.guess(self._last)
        rate = motion.rate(pose)
        self._last = rate - rate[2] * np.array([-pose[1], pose[0], 0.0])
        return rate

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
                self._motions[wheels] = SetMotion(contacts_of(self._model, sorted(wheels)), pose)
            except LoadError as error:
                raise TippedError from error
        return self._motions[wheels]
