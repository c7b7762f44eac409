"""The path of a body without mass under a rule without cells: it moves with the least dissipation.

Between events the same wheels carry, and the pose follows the minimizer at their loads.  Where a wheel comes to the
edge of an outline, Filippov's construction says how the body goes on (:mod:`nonsmooth.analysis.bodies.switching`).
Events: ``enter``, ``leave``, ``slide``.  The path ends in time, where the body tips, or after so much work; with an
outline also at rest.

A plain array is a body that covers all its wheels.  Its field is continuous and has few kinks, so LSODA follows it,
which turns implicit where that pays (near an equilibrium it decays like ``(mu_R/mu_S)^2``), and backward
differentiation formulas where drag stands in for jumps of the twist.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import islice, pairwise
from typing import Any

import numpy as np

from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.set_motion import ContactSets, TippedError, Wheels, with_kinematics
from nonsmooth.analysis.bodies.supports import (
    LOOKS,
    CarriedBody,
    CarryingWheels,
    SupportMode,
    carried_contacts,
    finite_start,
    tipping_edge,
)
from nonsmooth.analysis.bodies.switching import Switching
from nonsmooth.analysis.cells.contact_rule import SmoothRule
from nonsmooth.analysis.cells.loads import LoadError, TipsThereError
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.follow import (
    DenseStep,
    GuardsOfStates,
    Interpolant,
    Mode,
    Path,
    Stepper,
    Stretch,
    first_event,
    follow,
)
from nonsmooth.analysis.trajectories.result import End, EndReason, Event, EventKind, Piece, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.steppers import Dop853, Integrator
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_text import numbers_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite, max_norm, places_of

MOST_EVENTS = 2_000  # stretches between events; a path that needs more may switch for ever
# Work along a path in evaluations of pose rates, steps in regimes and minimizers by multipliers counted as some: twenty
# seconds.
MOST_RATES = 50_000
OF_A_STEP = 12  # stages of a Runge-Kutta step, which follow regimes without asking for rates
RESTS = 1e-10  # speed relative to the fastest wheel's below which the body rests
ON_BORDER = 1e-9  # of the body's size: a centre of mass as near to the border of its support does not stand
RELATIVE_TOLERANCE = 1e-9  # per step of a plain array's path; the minimizer itself is right to about 1e-12
ABSOLUTE_TOLERANCE = 1e-11  # length and radians
LOOSER = 100.0  # of both with drag, which moves a path by more, and turns rounding of forces into 1e-9 of a twist


def ellipse_path(model: ContactModel, start: Sequence[float], until: float) -> Trajectory:
    """Follow an array from ``(x, y, theta)`` at time zero, by the model with its friction sets.

    Args:
        model: the array in floats.
        start: x, y, theta (radian).
        until: last time.

    Raises:
        ValueError: for a last time that is not positive, or numbers that are not finite.
        nonsmooth.analysis.cells.loads.LoadError: for a start without loads.
        nonsmooth.analysis.trajectories.result.TrajectoryError: where the integrator gives up, or a minimizer is not
            proved to be the motion.
    """
    return BodyPath(model).follow(start, until)


def smooth_path(rule: SmoothRule, scene: Scene, start: Sequence[float], until: float) -> Trajectory:
    """The path under a rule without cells from ``(x, y, theta)`` at time zero, exact kinematics.

    It is the minimizer of D, integrated; of a body with an outline from contact set to contact set.

    Raises:
        LoadError: for a start without loads; of a body without an outline with the line that it tips over.
        ValueError: for a last time that is not positive, or numbers that are not finite.
        TrajectoryError: where the path cannot be followed.
    """
    try:
        return BodyPath(*carried_contacts(rule, scene)).follow(start, until)
    except TipsThereError as error:
        edge = tipping_edge(scene, frozenset(range(len(scene.wheels))), np.array(start, float))
        raise LoadError(f"{error} {edge}") from None


class BodyPath(CarriedBody):
    """Follows one body that the least dissipation moves."""

    method = "minimizer"
    keeps_beginnings = True

    def __init__(self, model: ContactModel, scene: Scene | None = None) -> None:
        """For contacts with their friction sets, and the scene of a body with an outline, with the same wheels.

        Raises:
            ValueError: for a scene without a body.
        """
        super().__init__(model, scene)
        self._sets = ContactSets(model)
        self._switching = Switching(self._sets, self.outline)
        fastest = max_norm(model.speeds)
        self._slow = RESTS * fastest
        self._scale = self.outline.size / (fastest or 1.0)
        self._support: CarryingWheels | None = None
        self._steps = self._before = 0

    def follow(self, start: Sequence[float], until: float) -> Trajectory:
        """The path from ``(x, y, theta)``, theta measured from the checked heading.

        Raises:
            ValueError: for a last time that is not positive, numbers that are not finite, and a start where the body
                tips.
            LoadError: for a start of an array without loads.
            TrajectoryError: where the path cannot be followed.
        """
        pose, self._support = finite_start(start, until), None
        self._steps, self._before = 0, self._sets.work
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
                raise self.refusal(error, np.array(path.pose)) from None
            return self.tipped(path, self._well_under(path.state))
        if before is not None:
            self.tell_changes(path, before, support, "" if support.unique else "other choices go on too")
        self._support = support
        rate = SupportRate(self._switching, support, path.state, self.outline.size)
        if not support.unique:
            path.unique = False
        elif (self._sets.is_stiff or rate.drags) and path.unique:
            path.unique = None  # where the twist jumps away from a surface, drag draws one solution of several
        mode = SupportMode(self, support, rate)
        if self.scene is not None and self._is_slow(rate(path.time, path.state), 1.0):
            path.pieces.append(mode.piece(Stretch([path.time], [path.state], [])))
            return EndReason.REST
        return mode

    def arrive(self, path: Path, mode: Mode, met: int | None) -> EndReason | None:
        """The body tips where its centre of mass leaves the hull of the wheels, or comes to its border."""
        if isinstance(mode, SupportMode) and (met == mode.guards.margin or self._hangs(mode.support, path.state)):
            return self.tipped(path, mode.support.carrying)
        return None

    def _hangs(self, support: CarryingWheels, pose: Floats) -> bool:
        """Whether the centre of mass has come to the border of its support, which it may approach for ever.

        There two wheels carry all the weight, and what moves the body is rounding.
        """
        if self.model.load_table is not None:
            return False
        return float(self.margins(support.carrying, pose[None])[0]) <= ON_BORDER * self.outline.size

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
        """The path ends at the border of its support, at rest (with an outline), or when it has taken all its work."""
        if self._support is not None and end == step.end and self._hangs(self._support, step.last):
            return EndReason.TIPS
        if self.scene is not None and self._is_slow(step.last - step.first, step.end - step.start):
            return EndReason.REST
        self._steps += self.scene is not None
        steps = 0 if self._sets.is_stiff else OF_A_STEP * self._steps
        is_spent = self._sets.work - self._before + steps >= MOST_RATES
        return EndReason.STEPS if is_spent else None


# ---- the stepper ---------------------------------------------------------------------------------
#
# Where friction ellipses are whole the field is analytic between its kinks
# (:mod:`nonsmooth.analysis.bodies.set_motion`). There Runge-Kutta steps of order 8 follow the pose together with twists
# and forces of the regime in which they begin; a step beyond the end of the regime is cut off there, so that kinks cost
# no order.  Where many such steps are needed the field is stiff, and LSODA goes on.  Where the slip of a wheel passes
# through zero, or drag acts, the field is so stiff that its own rounding is all that LSODA sees: backward
# differentiation formulas with wider tolerances follow it.


TOLERANCE = 1e-12  # of the body's size, per step, with which events are right to 1e-10
STIFF = 1e-12, 1e-14  # tolerances of LSODA, relative and absolute
# Of the last method, where the field is so stiff that its rounding counts; the next where that needs too many steps.
ROUGH = ((1e-10, 1e-12), (1e-8, 1e-10), (1e-6, 1e-8))
MANY_STEPS = 150  # of Runge-Kutta in one stretch, after which the field is taken for stiff
MANY_STIFF_STEPS = 1_000  # of LSODA, or of the last at one tolerance, after which rounding is taken for the field
DIFFERENCE = 1e-7  # of the body's size: for slopes of the field where it slides
# The same where exact slopes fail, beside places where a wheel comes to stick: the field is straight only so near.
NEAR_DIFFERENCE = 1e-11
ROUNDING = 1e-12  # the same: shorter ones show but rounding
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
        self.drags = any(motion.drags for motion in self.motions)
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
        wide = DIFFERENCE
        if not self._support.sliding:
            exact = self.motions[0].jacobian(pose)
            if exact is not None:
                return exact
            wide = NEAR_DIFFERENCE
        room = min(float(motion.margins(pose[None])[0]) for motion in self.motions)
        step = min(wide * self._size, max(room / 2, ROUNDING * self._size))  # loads end with the support
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
        return np.min([motion.validities(whole[:3].T, whole[cut].T) for motion, cut in pairs], axis=0)


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
        methods: list[tuple[Callable[[Any, float, Floats, float], Iterator[DenseStep]], int]]
        methods = [(Integrator("BDF", *rough).steps, MANY_STIFF_STEPS) for rough in ROUGH]
        if not rate.drags:
            methods = [(self._in_regimes, MANY_STEPS), (Integrator("LSODA", *STIFF).steps, MANY_STIFF_STEPS), *methods]
        *others, (last, _) = methods
        for method, most in others:
            with suppress(TrajectoryError):  # the next method goes on from where this one gives up
                for step in islice(method(rate, t, x, until), most):
                    t, x = step.end, step.last
                    yield step
                if t >= until:
                    return
        yield from last(rate, t, x, until)

    def _in_regimes(self, rate: SupportRate, time: float, pose: Floats, until: float) -> Iterator[DenseStep]:
        """Runge-Kutta steps, each in one regime; they end early where a regime cannot be held."""
        length, whole = None, self._held(rate, time, pose)
        while whole is not None and time < until:
            first = None if length is None else min(length, until - time)
            errors = np.full(len(whole), UNKNOWNS)
            errors[:3] = TOLERANCE * self._size
            solver = Dop853(rate.of_regimes, time, whole, until, first, TOLERANCE, errors)
            try:
                step = solver.step()
            except TrajectoryError:
                return
            end = self._end_of_regime(rate, step)
            if end is None:
                return
            kept = rate.kept(step.last) if end == step.end else None
            pose, length = step(end)[:3], solver.following
            yield DenseStep((time, whole[:3]), (end, pose), partial(_pose_of, step))
            time = end
            whole = self._held(rate, time, pose) if kept is None else kept

    def _held(self, rate: SupportRate, time: float, pose: Floats) -> Floats | None:
        return rate.held(pose + AHEAD * self._scale * rate(time, pose), pose)

    def _end_of_regime(self, rate: SupportRate, step: DenseStep) -> float | None:
        """The time within a step at which some regime ends; that of the step's end where none does."""
        if not are_finite(step.last):
            return None
        guard = _Valid(rate)
        found = first_event(guard, guard.at(step.start, step.first), guard.at(step.end, step.last), step)
        if found is None:
            return step.end
        # a regime that ends where it begins was read off wrongly: go a little way in it
        return max(found[0], min(step.start + AHEAD * self._scale, step.end))


class _Valid(GuardsOfStates):
    """Whether the regimes of all motions go on."""

    looks, crossed = LOOKS, True

    def __init__(self, rate: SupportRate) -> None:
        self._rate = rate

    def values(self, states: Floats) -> Floats:
        """The least of what is positive in them."""
        return self._rate.validities(states.T)[:, None]


def _pose_of(step: DenseStep) -> Interpolant:
    """The dense output without the unknowns of regimes."""
    return lambda times: step(times)[:3]


# ---- on one set of wheels ------------------------------------------------------------------------
#
# What is known of one set, such as a certified law, ends where a wheel enters or leaves.  Within every step of the path
# the depths of all wheels are looked at in some places; the time at which one changes its sign is then right to
# rounding.


LOOKS = 12  # places within a step where depths are looked at


class OneContactSet:
    """The wheels that carry the body of a scene at its checked pose.

    Raises:
        ValueError: for a scene without a body.
    """

    def __init__(self, scene: Scene, how_far: str = "") -> None:
        """For a scene, and words on how far its body may move on these wheels, for refusals."""
        if scene.body is None:
            raise ValueError("required a scene with a body")
        wheels = whole(scene).wheels
        self._how_far = f" (they alone carry it for certain {how_far})" if how_far else ""
        self.carrying = scene.numbers
        self._numbers = [wheel.index for wheel in wheels]
        self._outline = MovingOutline(scene.body, places_of(wheels))
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
                f"required a start on wheels {numbers_text(self.carrying)}, of which alone the law is certified"
                f"{self._how_far}, received one on {f'wheels {numbers_text(found)}' if found else 'none'}"
            )

    def until_change(self, path: Trajectory) -> Trajectory:
        """A path with finite pieces, or of samples alone, cut where the first wheel enters or leaves; there it ends.

        Between samples it is looked for on straight lines.
        """
        for piece in path.pieces or (_chords(path),):
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
        pieces = [_until(piece, time) for piece in path.pieces or (_chords(path),) if piece.start <= time]
        state = pieces[-1].state(time - pieces[-1].start)
        leaves = self._signs[wheel] > 0
        kind, words = (EventKind.LEAVE, "beside") if leaves else (EventKind.ENTER, "under")
        told = Event(time, state, kind, f"wheel {self._numbers[wheel]} {words} the body")
        end = End(time, state, EndReason.WHEELS)
        cut = replace(path, events=(*(event for event in path.events if event.t <= time), told), end=end)
        if path.pieces:
            return replace(cut, pieces=tuple(pieces))
        kept = pieces[0].times
        return replace(cut, sampled=(kept, tuple(map(pieces[0].state, kept))))


class _SameWheels(GuardsOfStates):
    """Signed depths of all wheels, positive as long as the same wheels carry."""

    looks = LOOKS

    def __init__(self, signs: Floats, outline: MovingOutline) -> None:
        self._signs, self._outline = signs, outline
        self.slacks = [0.0] * len(signs)

    def values(self, states: Floats) -> Floats:
        """All signed depths."""
        return self._signs * self._outline.depths(states)


def _steps_of(piece: Piece) -> Iterator[DenseStep]:
    """A piece as steps between its sample times."""

    def pose(time: float) -> Floats:
        return np.array(piece.state(time - piece.start), float)

    def poses(times: float | Floats) -> Floats:
        return pose(times) if isinstance(times, float) else np.array([pose(time) for time in times.tolist()]).T

    for before, after in pairwise(float(time) for time in piece.times):
        yield DenseStep((before, pose(before)), (after, pose(after)), lambda: poses)


def _chords(path: Trajectory) -> Piece:
    """A path that keeps samples only, with straight lines between them; it begins at time zero."""
    times = path.times
    return Piece(times[0], times[-1], "", (), lambda time: tuple(path.sample([time])[0].tolist()), lambda: times)


def _until(piece: Piece, time: float) -> Piece:
    if piece.end is not None and piece.end <= time:
        return piece
    return replace(piece, end=time, drawn=lambda: (*(t for t in piece.times if t < time), time))
