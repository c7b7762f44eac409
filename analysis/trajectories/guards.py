"""Guards of a smooth path: functions that are positive as long as it keeps to its face, and where they cease to be.

Guards are looked at after every step; where the slope of one turns from falling to rising within the step, its lowest
value in between is looked for too, so that a short excursion is not stepped over.  Within a step that the integrator
found easy a guard may do so more than once, and is sampled.  A guard that starts at zero is
expected to rise first; one that never does counts as met only beyond its slack, so that every stretch takes time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.analysis.fields.convex_weights import WEIGHT_SLACK
from nonsmooth.analysis.fields.switched_field import FacedField, Surface, Vector, length, unit_normal
from nonsmooth.analysis.trajectories.face_motion import LOOK_AHEAD, SMALLEST_SPEED, TANGENT_SLACK, FaceMotion
from nonsmooth.analysis.trajectories.faces import FaceChoice
from nonsmooth.analysis.trajectories.two_fold import BECOMES_TANGENT, CLEAR_OF_TANGENCY, IS_TANGENT, tangency
from nonsmooth.analysis.trajectories.whirls import WhirlMotion

Interpolant: TypeAlias = Callable[[Any], Vector]  # also of times (n,), as states (states, n)

HALVINGS = 40  # of a step, in search of a moment at which a guard that starts at zero is positive
ROOT_STEPS = 100  # bisection alone needs 60
CUBIC_STEPS = 4  # of Newton's method from the secant's root; the cubic itself is off by more than what they leave
SAMPLED_PARTS = 12  # of an easy step: more than the extrema of a polynomial of the dense output's degree
ROOT_SLACK = 4 * np.finfo(np.float64).eps  # relative to the times at hand: what floats can resolve
# Relative to the size of the states (lengths) or of the fields (speeds): the integrator's error per step.
GUARD_SLACK = 1e-12


@dataclass(frozen=True)
class Guard:
    """Positive on the face; ``slope`` is its derivative along the motion, exact where that is cheap."""

    value: Callable[[float, Vector], float]
    slack: float
    slope: Callable[[float, Vector, Vector], float]
    surface: Surface | None = None


@dataclass(frozen=True)
class IntegratorStep:
    """Both ends of a step, ``(t, x, f)``, and how to get the dense output between them.

    ``easy`` is a step whose error is far below the tolerance: the solution is nearly a polynomial of low degree there,
    and no bound on the step keeps a guard from falling and rising more than once within it.
    """

    before: tuple[float, Vector, Vector]
    after: tuple[float, Vector, Vector]
    dense_output: Callable[[], Interpolant]
    easy: bool = False

    @cached_property
    def interpolant(self) -> Interpolant:
        """Dense output, made at most once."""
        return self.dense_output()

    @cached_property
    def samples(self) -> list[tuple[float, Vector]]:
        """Times and states within an easy step; none within any other."""
        if not self.easy:
            return []
        start, span = float(self.before[0]), float(self.after[0] - self.before[0])
        times = [start + span * k / SAMPLED_PARTS for k in range(1, SAMPLED_PARTS)]
        return list(zip(times, self.interpolant(np.array(times)).T, strict=True))


def guards_of(field: FacedField, choice: FaceChoice, t: float, x: Vector) -> list[Guard]:
    """Bounds of the face, then normal speeds of its members or the least weight of its mode."""
    motion, face = choice.motion, choice.motion.face
    if isinstance(motion, WhirlMotion):
        return [Guard(motion.lasts, GUARD_SLACK, _difference(motion.lasts, field.size))]
    guards = [_bound(surface, side, GUARD_SLACK * field.size, x) for surface, side in face.bounds]
    if motion.is_pair:
        guards.append(_tangent(field, motion))
    if motion.is_pair and motion.weights_open:
        return guards
    if choice.orders is not None:
        guards += _exits(field, choice, float(np.abs(motion.fields(t, x)).max()))
    elif face.keep and len(face.members) > 1:
        guards.append(Guard(motion.least_weight, WEIGHT_SLACK, _difference(motion.least_weight, field.size)))
    return guards


def _bound(surface: Surface, side: int, slack: float, x: Vector) -> Guard:
    def slope(t: float, x: Vector, velocity: Vector) -> float:
        return side * float(surface.gradient(x) @ velocity)

    return Guard(lambda t, x: side * surface.value(x), slack * length(surface.gradient(x)), slope, surface)


def _exits(field: FacedField, choice: FaceChoice, scale: float) -> list[Guard]:
    """The members' normal speeds, with the signs they have inside the mode.

    One that nothing decides has the other's opposite, and turns clearly before that is told.
    """
    first, second = choice.orders or (0, 0)
    guards = []
    for member, (order, other) in enumerate(((first, second), (second, first))):
        if order or other:
            value = _exit(choice.motion, member, order or -other)
            slack = GUARD_SLACK if order else IS_TANGENT * TANGENT_SLACK
            guards.append(Guard(value, slack * scale, _difference(value, field.size)))
    return guards


def _exit(motion: FaceMotion, member: int, order: int) -> Callable[[float, Vector], float]:
    """A member's normal speed, with the sign it has inside the mode."""
    surface, velocity = motion.face.keep[0], motion.face.members[member].velocity
    return lambda t, x: order * float(unit_normal(surface, x) @ velocity(t, x))


def _tangent(field: FacedField, motion: FaceMotion) -> Guard:
    """Whether the weights of a slide follow from its speeds, or still do not: where that changes, so does its law.

    A dip within a step needs no search: there the exits are met, at a state that is tangent too.
    """

    def value(t: float, x: Vector) -> float:
        fields = motion.fields(t, x)
        here = tangency(motion, t, x, field.size, fields, motion.normal_speeds(x, fields))
        return CLEAR_OF_TANGENCY - here if motion.weights_open else here - BECOMES_TANGENT

    return Guard(value, GUARD_SLACK, lambda t, x, velocity: 0.0)


def _difference(value: Callable[[float, Vector], float], size: float) -> Callable[[float, Vector, Vector], float]:
    """The derivative of a guard along a motion, by a short step ahead."""

    def slope(t: float, x: Vector, velocity: Vector) -> float:
        ahead = LOOK_AHEAD * size / max(length(velocity), SMALLEST_SPEED)
        return (value(t + ahead, x + ahead * velocity) - value(t, x)) / ahead

    return slope


def first_event(
    guards: Sequence[Guard], values: Sequence[float], following: Sequence[float], step: IntegratorStep
) -> tuple[float, Guard] | None:
    """Earliest time in a step at which a guard falls below zero."""
    best: tuple[float, Guard] | None = None
    for guard, first, last in zip(guards, values, following, strict=True):
        time = _first_fall(guard, first, last, step)
        if time is not None and (best is None or time < best[0]):
            best = time, guard
    return best


def _first_fall(guard: Guard, first: float, last: float, step: IntegratorStep) -> float | None:
    """Earliest time in a step at which one guard falls below zero."""
    if not step.easy:  # by far the most
        return _first_fall_between(guard, first, last, step)
    inner = [(t, guard.value(t, x)) for t, x in step.samples]
    known = [(float(step.before[0]), first), *inner, (float(step.after[0]), last)]
    for k, (before, after) in enumerate(pairwise(known)):
        if after[1] < -guard.slack:
            return _fall(guard, before, after, step)
        if k and known[k - 1][1] > before[1] < after[1]:
            time = _dip(guard, known[k - 1], after[0], step)
            if time is not None:
                return time
    return None


def _first_fall_between(guard: Guard, first: float, last: float, step: IntegratorStep) -> float | None:
    """The same where the guard falls once at most, or falls and rises again."""
    before, after = (float(step.before[0]), first), (float(step.after[0]), last)
    if last < -guard.slack:
        return _fall(guard, before, after, step)
    falls_then_rises = guard.slope(*step.before) < 0 < guard.slope(*step.after)
    return _dip(guard, before, after[0], step) if falls_then_rises else None


def _fall(guard: Guard, before: tuple[float, float], after: tuple[float, float], step: IntegratorStep) -> float:
    """Time at which a guard falls through zero; through its slack, where it starts at zero and never rises."""
    (low, first), (high, _) = before, after

    def value(t: float) -> float:
        return guard.value(t, step.interpolant(t))

    if first > guard.slack:
        return find_root(value, before, after, _hermite_root(guard, before, after, step))
    for k in range(1, HALVINGS):
        middle = low + (high - low) * 2.0**-k
        risen = value(middle)
        if risen > 0:
            return find_root(value, (middle, risen), after)
    return find_root(lambda t: value(t) + guard.slack, (low, max(first, 0.0) + guard.slack), after)


def _dip(guard: Guard, before: tuple[float, float], high: float, step: IntegratorStep) -> float | None:
    """Time at which a guard falls through zero on its way to a lowest value below zero between two times."""
    from scipy.optimize import minimize_scalar

    bounds = (before[0], float(high))
    lowest = minimize_scalar(lambda t: guard.value(t, step.interpolant(t)), bounds=bounds, method="bounded")
    if lowest.fun >= -guard.slack:
        return None
    return _fall(guard, before, (float(lowest.x), float(lowest.fun)), step)


def _hermite_root(
    guard: Guard, before: tuple[float, float], after: tuple[float, float], step: IntegratorStep
) -> tuple[float, float]:
    """Root, and slope there, of the cubic through values and slopes at both ends of a step; within it, of the line."""
    (low, first), (high, last) = before, after
    s, span = first / (first - last), high - low
    if (low, high) != (step.before[0], step.after[0]):
        return low + s * span, (last - first) / span
    rise, fall = guard.slope(*step.before) * span, guard.slope(*step.after) * span
    square, cube = 3 * (last - first) - 2 * rise - fall, 2 * (first - last) + rise + fall
    slope = last - first
    for _ in range(CUBIC_STEPS):
        slope = rise + s * (2 * square + 3 * s * cube)
        s = min(max(s - (first + s * (rise + s * (square + s * cube))) / slope, 0.0), 1.0) if slope else s
    return low + s * span, slope / span


def find_root(
    value: Callable[[float], float],
    before: tuple[float, float],
    after: tuple[float, float],
    guess: tuple[float, float] | None = None,
) -> float:
    """Root between two times with values of opposite signs: the secant method, kept inside the bracket.

    Known values at the ends and a good guess of root and slope save half of what a bracketing method evaluates.
    """
    (low, first), (high, last) = before, after
    secant = (last - first) / (high - low)
    t, slope = (low - first / secant, secant) if guess is None else guess
    here = value(t)
    for _ in range(ROOT_STEPS):
        low, high = (t, high) if here > 0 else (low, t)
        if here == 0 or abs(high - low) <= ROOT_SLACK * abs(t):
            break
        following = t - here / slope if slope else (low + high) / 2  # a flat secant says nothing of the root
        if abs(following - t) <= ROOT_SLACK * abs(t):
            break
        if not low < following < high:
            following = (low + high) / 2
        there = value(following)
        slope = (there - here) / (following - t)
        t, here = following, there
    return float(t)
