"""The path of a body without mass under a rule without cells: it moves with the least dissipation.

Between events the same wheels carry, and the pose follows the minimizer at their loads.  Where a wheel comes to the
edge of an outline, Filippov's construction says how the body goes on (:mod:`nonsmooth.analysis.bodies.switching`).
Events: ``enter``, ``leave``, ``slide``.  The path ends in time or where the body tips; with an outline also at rest, or
after so much work.

A plain array is a body that covers all its wheels.  Its field is continuous and has few kinks, so LSODA follows it,
which turns implicit where that pays (near an equilibrium it decays like ``(mu_R/mu_S)^2``), and backward
differentiation formulas where drag stands in for jumps of the twist.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.bodies.regimes import Regimes, SupportRate
from nonsmooth.analysis.bodies.set_motion import ContactSets, TippedError, Wheels
from nonsmooth.analysis.bodies.supports import CarriedBody, CarryingWheels, SupportMode, finite_start
from nonsmooth.analysis.bodies.switching import Switching
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.follow import DenseStep, Mode, Path, Stepper, Stretch, follow
from nonsmooth.analysis.trajectories.result import EndReason, Trajectory
from nonsmooth.analysis.trajectories.steppers import Integrator
from nonsmooth.symbolic.scene import Scene

MOST_EVENTS = 2_000  # stretches between events; a path that needs more may switch for ever
# Evaluations of pose rates along a path, a step counted as some: twenty seconds; with drag each takes ten times longer.
MOST_RATES, MOST_DRAGGED = 50_000, 6_000
OF_A_STEP = 12  # stages of a Runge-Kutta step, which follow regimes without asking for rates
RESTS = 1e-10  # speed relative to the fastest wheel's below which the body rests
RELATIVE_TOLERANCE = 1e-9  # per step of a plain array's path; the minimizer itself is right to about 1e-12
ABSOLUTE_TOLERANCE = 1e-11  # length and radians
LOOSER = 100.0  # of both with drag, which moves a path by more, and turns rounding of forces into 1e-9 of a twist


def ellipse_path(model: ContactModel, start: Sequence[float], until: float) -> Trajectory:
    """Follow an array from ``(x, y, theta)`` at time zero, by the model with its friction sets.

    Raises:
        ValueError: for a last time that is not positive, or numbers that are not finite.
        nonsmooth.analysis.cells.loads.LoadError: for a start without loads.
        nonsmooth.analysis.trajectories.result.TrajectoryError: where the integrator gives up, or a minimizer is not
            proved to be the motion.
    """
    return BodyPath(model).follow(start, until)


class BodyPath(CarriedBody):
    """Follows one body that the least dissipation moves."""

    method = "minimizer"

    def __init__(self, model: ContactModel, scene: Scene | None = None) -> None:
        """For contacts with their friction sets, and the scene of a body with an outline, with the same wheels.

        Raises:
            ValueError: for a scene without a body.
        """
        super().__init__(model, scene)
        self._sets = ContactSets(model)
        self._switching = Switching(self._sets, self.outline)
        fastest = float(np.abs(model.speeds).max())
        self._slow = RESTS * fastest
        self._scale = self.outline.size / (fastest or 1.0)
        self._support: CarryingWheels | None = None
        self._steps = 0

    def follow(self, start: Sequence[float], until: float) -> Trajectory:
        """The path from ``(x, y, theta)``, theta measured from the checked heading.

        Raises:
            ValueError: for a last time that is not positive, numbers that are not finite, and a start where the body
                tips.
            LoadError: for a start of an array without loads.
            TrajectoryError: where the path cannot be followed.
        """
        pose, self._support = finite_start(start, until), None
        self._steps = self._sets.evaluations = 0
        return follow(self, (0.0, pose), until, self._stepper()).trajectory(Kinematics.EXACT.value, self.method)

    def _stepper(self) -> Stepper:
        if self.scene is not None:
            return Regimes(self._scale, self.outline.size)
        looser = LOOSER if self._sets.is_stiff else 1.0
        tolerances = looser * RELATIVE_TOLERANCE, looser * ABSOLUTE_TOLERANCE
        return Integrator("BDF" if self._sets.is_stiff else "LSODA", *tolerances, exact_slopes=False)

    # ---- supports ----------------------------------------------------------------------------------

    def next_mode(self, path: Path) -> Mode | EndReason:
        """The support at a pose, with its motion; the path ends where the body tips or rests."""
        before = self._support
        if len(path.stretches) >= MOST_EVENTS:
            return EndReason.EVENTS
        try:
            support = self._support_at(path.state)
        except TippedError as error:
            if before is None:
                raise self.refusal(error) from None
            return self.tipped(path, self._well_under(path.state))
        if before is not None:
            self.tell_changes(path, before, support, "" if support.unique else "other choices go on too")
        path.unique = bool(path.unique and support.unique)
        self._support = support
        rate = SupportRate(self._switching, support, path.state, self.outline.size)
        mode = SupportMode(self, support, rate)
        if self.scene is not None and self._is_slow(rate(path.time, path.state), 1.0):
            path.pieces.append(mode.piece(Stretch([path.time], [path.state], [])))
            return EndReason.REST
        return mode

    def arrive(self, path: Path, mode: Mode, met: int | None) -> EndReason | None:
        """The body tips where its centre of mass leaves the hull of the wheels."""
        if isinstance(mode, SupportMode) and met == mode.guards.margin:
            return self.tipped(path, mode.support.carrying)
        return None

    def _support_at(self, pose: Floats) -> CarryingWheels:
        """How the body goes on from a pose; wheels that slide stay under the edge whatever rounding says."""
        depths, before = self.outline.depths(pose), self._support
        near = {int(k) for k in np.flatnonzero(np.abs(depths) <= self.edge_depth)}
        if before is not None:
            near |= set(before.sliding)
        inside = frozenset(int(k) for k in np.flatnonzero(depths > 0) if int(k) not in near)
        if near:
            return self._switching.next_support(pose, inside, sorted(near))
        if self.scene is not None and not self._sets.carries(inside, pose):
            raise TippedError
        self._sets.motion(inside, pose)
        return CarryingWheels(inside)

    def _well_under(self, pose: Floats) -> Wheels:
        """The wheels that carried the body and have not come to its edge."""
        carrying = frozenset() if self._support is None else self._support.carrying
        depths = self.outline.depths(pose)
        return frozenset(k for k in carrying if depths[k] > self.edge_depth)

    def _is_slow(self, move: Floats, time: float) -> bool:
        """Whether a pose that moves so far in a time is at rest."""
        return float(np.hypot(*move[:2]) + abs(move[2]) * self.outline.size) <= self._slow * time

    def weights(self, support: CarryingWheels, state: Floats) -> Floats:
        """See :class:`nonsmooth.analysis.bodies.supports.CarriedBody`."""
        return self._switching.rate(support, state, np.full(len(support.sliding), 0.5))[1]

    def margins(self, carrying: Wheels, states: Floats) -> Floats:
        """See :class:`nonsmooth.analysis.bodies.supports.CarriedBody`."""
        return self._sets.motion(carrying, states[0]).margins(states)

    def passed(self, step: DenseStep, end: float) -> EndReason | None:
        """With an outline the path ends where the body hardly moves in a step, or has taken all the work it may."""
        if self.scene is None:
            return None
        if self._is_slow(step.last - step.first, step.end - step.start):
            return EndReason.REST
        self._steps += 1
        if self._sets.is_stiff:
            is_spent = self._sets.evaluations >= MOST_DRAGGED
        else:
            is_spent = self._sets.evaluations + OF_A_STEP * self._steps >= MOST_RATES
        return EndReason.STEPS if is_spent else None
