"""The motion of a body on one set of wheels, and the regime in which it is smooth.

Between changes of the contact set the motion still has kinks: where a spring comes free or a contact begins or ends to
stick.  Beside them it is analytic, and each of its pieces goes on analytically beyond the kink.  So a regime (which
wheels are loaded, which contact sticks) can be held while an integrator makes its step, and :meth:`SetMotion.validity`
says afterwards where it ended.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.dynamics.drag import needs_drag
from nonsmooth.analysis.dynamics.ellipse_path import path_minimizer
from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.proved import resists_every_motion
from nonsmooth.analysis.minimizers.smooth_newton import SmoothNewton
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.number_text import place_text


class SetMotion:
    """Pose rates ``(c', theta')`` on one set of wheels."""

    def __init__(self, model: ContactModel, pose: Floats) -> None:
        """For the contacts of the set, and a pose at which they carry the body.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where they do not.
        """
        self._model, self._loads = model, MovingLoads(model, pose[:2])
        self._minimize = path_minimizer(model)
        self._quick = None if needs_drag(model) else SmoothNewton(model)
        self._held = False
        self.lowest = np.inf  # validity of the regime held, over all poses since it was set to infinity

    def margins(self, poses: Floats) -> Floats:
        """Distance of the centre of mass from the border of the support polygon, negative outside; poses (m, 3)."""
        return self._loads.margins(poses[:, :2])

    def rate(self, pose: Floats) -> Floats:
        """``(c', theta')`` with exact kinematics; a little beyond the support polygon it is continued.

        Not a number where the regime held cannot be continued.

        Raises:
            TrajectoryError: where the minimizer is not proved to be the motion.
        """
        twist = self._held_twist(pose) if self._held else self._twist(self._loads.at(pose[:2])[0], pose)
        return twist + twist[2] * np.array([-pose[1], pose[0], 0.0])

    def _twist(self, loads: Floats, pose: Floats) -> Floats:
        """The minimizer of D: by Newton steps from the last one, else by interior points."""
        quick = self._quick
        found = None if quick is None else quick.minimize(loads)
        if found is not None:
            return found
        minima = self._minimize(loads)
        if not (minima.check() & resists_every_motion(self._model, loads[None]))[0]:
            place = place_text((float(pose[0]), float(pose[1])))
            raise TrajectoryError(f"required a certified motion, received a minimum without proof at {place}")
        (twist,) = minima.twists
        if quick is not None:
            quick.start_from(twist, loads)
        return np.asarray(twist)

    # ---- regimes ---------------------------------------------------------------------------------

    def hold(self, pose: Floats) -> None:
        """Hold the regime of a pose, where there is one that can be continued."""
        self.release()
        self.rate(pose)
        self._held = self._quick is not None and self._quick.is_ready and self._loads.margin(pose[:2]) > 0
        self.lowest = np.inf

    def release(self) -> None:
        """Take the regime of each pose from now on."""
        self._held = False

    def validity(self, pose: Floats) -> float:
        """Positive where the regime held is the one of the pose, negative where it is not; infinite where none is."""
        if not self._held:
            return np.inf
        before, self.lowest = self.lowest, np.inf
        lost = np.isnan(self._held_twist(pose, proof=True)).any()
        found, self.lowest = self.lowest, before
        return -np.inf if lost else found

    def _held_twist(self, pose: Floats, *, proof: bool = False) -> Floats:
        """The minimizer in the regime held, continued beyond its end; not a number where the continuation is lost."""
        assert self._quick is not None
        loads, free = self._loads.continued(pose[:2])
        twist = self._quick.continued(loads, proof=proof) if np.isfinite(free) or self._loads.has_table else None
        if twist is None:
            return np.full(3, np.nan)
        self.lowest = min(self.lowest, free, self._quick.validity)
        return twist
