"""The stepper of a body that the least dissipation moves, whose field has kinks.

Where friction ellipses are whole the field is analytic between its kinks (:mod:`nonsmooth.analysis.bodies.set_motion`).
There Runge-Kutta steps of order 8 follow the pose together with twists and forces of the regime in which they begin; a
step beyond the end of the regime is cut off there, so that kinks cost no order.  Where many such steps are needed the
field is stiff, and LSODA goes on.  Where the slip of a wheel passes through zero, or drag acts, the field is so stiff
that its own rounding is all that LSODA sees: backward differentiation formulas with wider tolerances follow it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import islice, pairwise

import numpy as np

from nonsmooth.analysis.bodies.set_motion import with_kinematics
from nonsmooth.analysis.bodies.supports import LOOKS, CarryingWheels
from nonsmooth.analysis.bodies.switching import Switching
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.trajectories.follow import DenseStep, Guards, Interpolant, first_event
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.analysis.trajectories.steppers import Integrator, stepped

TOLERANCE = 1e-12  # of the body's size, per step, with which events are right to 1e-10
STIFF = 1e-12, 1e-14  # tolerances of LSODA, relative and absolute
ROUGH = 1e-10, 1e-12  # of the last method, where the field is so stiff that its rounding counts
MANY_STEPS = 150  # of Runge-Kutta in one stretch, after which the field is taken for stiff
MANY_STIFF_STEPS = 1_000  # of LSODA, after which rounding is taken for the field
DIFFERENCE = 1e-7  # of the body's size: for slopes of the field
AHEAD = 1e-7  # of the time in which the body crosses itself: where the next regime is read off
UNKNOWNS = 1e-9  # error of twists and forces within a step; after it they are exact again


class SupportRate:
    """The pose rate on one support, as a function of time and pose.

    Attributes:
        motions: the motions that it mixes.
    """

    def __init__(self, switching: Switching, support: CarryingWheels, pose: Floats, size: float) -> None:
        self._switching, self._support, self._size = switching, support, size
        self.motions = switching.motions(support, pose)
        self.drags = switching.is_stiff
        self._weights = np.full(len(support.sliding), 0.5)

    def __call__(self, time: float, pose: Floats) -> Floats:
        """``(c', theta')``."""
        rate, self._weights = self._switching.rate(self._support, pose, self._weights)
        return rate

    @property
    def jacobian(self) -> object:
        """Slopes by the pose as a function of time and pose; None where drag makes them as rough as differences."""
        return None if self.drags else self._slopes

    def _slopes(self, time: float, pose: Floats) -> Floats:
        """Exact where one motion acts and has a regime, else by differences."""
        exact = None if self._support.sliding else self.motions[0].jacobian(pose)
        if exact is not None:
            return exact
        step = DIFFERENCE * self._size
        ahead = [self(time, pose + step * unit) - self(time, pose - step * unit) for unit in np.eye(3)]
        return np.column_stack(ahead) / (2 * step)

    # ---- the pose with the unknowns of the regimes of all motions ----------------------------

    def held(self, ahead: Floats, pose: Floats) -> Floats | None:
        """The pose and the unknowns of the regimes of a pose a little ahead; None where one has none."""
        unknowns = [found for motion in self.motions if (found := motion.hold(ahead, pose)) is not None]
        if len(unknowns) < len(self.motions):
            return None
        ends = np.cumsum([3, *map(len, unknowns)])
        self._cuts = [slice(*pair) for pair in pairwise(ends.tolist())]
        return np.concatenate([pose, *unknowns])

    def of_regimes(self, time: float, whole: Floats) -> Floats:
        """Rates of the pose and of all unknowns."""
        pose, unknowns = whole[:3], [whole[cut] for cut in self._cuts]
        corners = [with_kinematics(found[:3], pose) for found in unknowns]
        rate, self._weights = self._switching.mixed(self._support, pose, corners, self._weights)
        pairs = zip(self.motions, unknowns, strict=True)
        return np.concatenate([rate, *(motion.slope(pose, rate, found) for motion, found in pairs)])

    def kept(self, whole: Floats) -> Floats | None:
        """The pose and the exact unknowns of the same regimes after a step; None where others are to be read off."""
        pose, kept = whole[:3], [whole[:3]]
        for motion, cut in zip(self.motions, self._cuts, strict=True):
            exact = motion.settled(pose, whole[cut])
            if exact is None or motion.is_near_rest(pose, exact):
                return None
            kept.append(exact)
        return np.concatenate(kept)

    def validities(self, whole: Floats) -> Floats:
        """Negative where some regime has ended, at states (n, m); shape (m,)."""
        pairs = zip(self.motions, self._cuts, strict=True)
        return np.asarray(np.min([motion.validities(whole[:3].T, whole[cut].T) for motion, cut in pairs], axis=0))


class Regimes:
    """The stepper.

    Args:
        scale: the time in which the body crosses its own size.
        size: of the body.
    """

    def __init__(self, scale: float, size: float) -> None:
        self._scale, self._size = scale, size

    def steps(self, rate: SupportRate, t: float, x: Floats, until: float) -> Iterator[DenseStep]:
        """Steps of three methods, each for as long as it is worth it.

        Raises:
            TrajectoryError: where the last method stops.
        """
        if not rate.drags:
            lsoda = Integrator("LSODA", *STIFF)
            for method, most in ((self._in_regimes, MANY_STEPS), (lsoda.steps, MANY_STIFF_STEPS)):
                for step in islice(method(rate, t, x, until), most):
                    t, x = step.end, step.last
                    yield step
                if t >= until:
                    return
        yield from Integrator("BDF", *ROUGH).steps(rate, t, x, until)

    def _in_regimes(self, rate: SupportRate, time: float, pose: Floats, until: float) -> Iterator[DenseStep]:
        """Runge-Kutta steps, each in one regime; they end early where a regime cannot be held."""
        from scipy.integrate import DOP853

        length, whole = None, self._held(rate, time, pose)
        while whole is not None and time < until:
            first = None if length is None else min(length, until - time)
            errors = np.full(len(whole), UNKNOWNS)
            errors[:3] = TOLERANCE * self._size
            solver = DOP853(rate.of_regimes, time, whole, until, first_step=first, rtol=TOLERANCE, atol=errors)
            try:
                step = stepped(solver)
            except TrajectoryError:
                return
            end = self._end_of_regime(rate, step)
            if end is None:
                return
            kept = rate.kept(step.last) if end == step.end else None
            pose, length = step(end)[:3], float(solver.h_abs)
            yield DenseStep((time, whole[:3]), (end, pose), partial(_pose_of, step))
            time = end
            whole = self._held(rate, time, pose) if kept is None else kept

    def _held(self, rate: SupportRate, time: float, pose: Floats) -> Floats | None:
        return rate.held(pose + AHEAD * self._scale * rate(time, pose), pose)

    def _end_of_regime(self, rate: SupportRate, step: DenseStep) -> float | None:
        """The time within a step at which some regime ends; that of the step's end where none does."""
        if not np.isfinite(step.last).all():
            return None
        guard = _Valid(rate)
        found = first_event(guard, guard.at(step.start, step.first), guard.at(step.end, step.last), step)
        if found is None:
            return step.end
        # a regime that ends where it begins was read off wrongly: go a little way in it
        return max(found[0], min(step.start + AHEAD * self._scale, step.end))


class _Valid(Guards):
    """Whether the regimes of all motions go on."""

    looks, crossed = LOOKS, True

    def __init__(self, rate: SupportRate) -> None:
        self._rate = rate

    def at(self, t: float, x: Floats) -> Sequence[float]:
        """The least of what is positive in them."""
        return self._rate.validities(x[:, None]).tolist()

    def at_all(self, times: Sequence[float], states: Floats) -> list[Sequence[float]]:
        """The same at many states."""
        return self._rate.validities(states.T)[:, None].tolist()


def _pose_of(step: DenseStep) -> Interpolant:
    """The dense output without the unknowns of regimes."""
    return lambda times: step(times)[:3]
