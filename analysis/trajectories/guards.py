"""Guards of a smooth path: functions that are positive as long as it keeps to its face, and where they cease to be.

Guards are looked at after every step; where the slope of one turns from falling to rising within the step, its lowest
value in between is looked for too, so that a short excursion is not stepped over.  A guard that starts at zero is
expected to rise first; one that never does counts as met only beyond its slack, so that every stretch takes time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.fields.smooth_field import SmoothField, Surface, Vector, length, unit_normal
from nonsmooth.analysis.trajectories.faces import FaceChoice, FaceMotion

Interpolant: TypeAlias = Callable[[float], Vector]

HALVINGS = 40  # of a step, in search of a moment at which a guard that starts at zero is positive
ROOT_STEPS = 100  # bisection alone needs 60
CUBIC_STEPS = 4  # of Newton's method from the secant's root; the cubic itself is off by more than what they leave
ROOT_SLACK = 4 * np.finfo(np.float64).eps  # relative to the times at hand: what floats can resolve
# Relative to the size of the states (lengths) or of the fields (speeds): the integrator's error per step.
GUARD_SLACK = 1e-12


@dataclass(frozen=True)
class Guard:
    """Positive on the face; ``slope`` is its derivative along the motion where that is cheap."""

    value: Callable[[float, Vector], float]
    slack: float
    slope: Callable[[Vector, Vector], float] | None = None
    surface: Surface | None = None


@dataclass(frozen=True)
class Step:
    """Both ends of a step, ``(t, x, f)``, and how to get the dense output between them."""

    before: tuple[float, Vector, Vector]
    after: tuple[float, Vector, Vector]
    dense_output: Callable[[], Interpolant]

    @cached_property
    def interpolant(self) -> Interpolant:
        """Dense output, made at most once."""
        return self.dense_output()


def guards_of(field: SmoothField, choice: FaceChoice, t: float, x: Vector) -> list[Guard]:
    """Bounds of the face, then normal speeds of its members or the existence of its mode."""
    motion, face = choice.motion, choice.motion.face
    guards = [_bound(surface, side, GUARD_SLACK * field.size, x) for surface, side in face.bounds]
    if choice.orders is not None:
        slack = GUARD_SLACK * float(np.abs(motion.fields(t, x)).max())
        guards += [_exit(motion, k, order, slack) for k, order in enumerate(choice.orders) if order]
    elif face.keep and len(face.members) > 1:
        guards.append(Guard(lambda t, x: 1.0 if motion.possible(t, x) else -1.0, 0.0))
    return guards


def _bound(surface: Surface, side: int, slack: float, x: Vector) -> Guard:
    def slope(x: Vector, velocity: Vector) -> float:
        return side * float(surface.gradient(x) @ velocity)

    return Guard(lambda t, x: side * surface.value(x), slack * length(surface.gradient(x)), slope, surface)


def _exit(motion: FaceMotion, member: int, order: int, slack: float) -> Guard:
    """A member's normal speed, with the sign it has inside the mode."""
    surface, velocity = motion.face.keep[0], motion.face.members[member].velocity
    return Guard(lambda t, x: order * float(unit_normal(surface, x) @ velocity(t, x)), slack)


def first_event(
    guards: Sequence[Guard], values: Sequence[float], following: Sequence[float], step: Step
) -> tuple[float, Guard] | None:
    """Earliest time in a step at which a guard falls below zero."""
    best: tuple[float, Guard] | None = None
    for guard, first, last in zip(guards, values, following, strict=True):
        if last < -guard.slack:
            time: float | None = _fall(guard, (step.before[0], first), (step.after[0], last), step)
        elif guard.slope is not None and guard.slope(*step.before[1:]) < 0 < guard.slope(*step.after[1:]):
            time = _dip(guard, first, step)
        else:
            continue
        if time is not None and (best is None or time < best[0]):
            best = time, guard
    return best


def _fall(guard: Guard, before: tuple[float, float], after: tuple[float, float], step: Step) -> float:
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


def _dip(guard: Guard, first: float, step: Step) -> float | None:
    """Time at which a guard falls through zero on its way to a lowest value below zero within the step."""
    from scipy.optimize import minimize_scalar

    low, high = float(step.before[0]), float(step.after[0])
    lowest = minimize_scalar(lambda t: guard.value(t, step.interpolant(t)), bounds=(low, high), method="bounded")
    if lowest.fun >= -guard.slack:
        return None
    return _fall(guard, (low, first), (float(lowest.x), float(lowest.fun)), step)


def _hermite_root(
    guard: Guard, before: tuple[float, float], after: tuple[float, float], step: Step
) -> tuple[float, float]:
    """Root, and slope there, of the cubic through values and slopes at both ends; without slopes, of the line."""
    (low, first), (high, last) = before, after
    s, span = first / (first - last), high - low
    if guard.slope is None or high != step.after[0]:
        return low + s * span, (last - first) / span
    rise, fall = guard.slope(*step.before[1:]) * span, guard.slope(*step.after[1:]) * span
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
        following = t - here / slope if slope else t
        if here == 0 or abs(following - t) <= ROOT_SLACK * abs(t):
            break
        if not low < following < high:
            following = (low + high) / 2
        there = value(following)
        slope = (there - here) / (following - t)
        t, here = following, there
    return float(t)
