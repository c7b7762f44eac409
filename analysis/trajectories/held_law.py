"""The law of imposed twists as a digital controller runs it: sampled, its speeds held until the next sample.

The event-driven path (:mod:`nonsmooth.analysis.fields.driven_field`) follows the exact Filippov solution; where many
cones of directions of c meet at ``c = 0`` it has too many patterns of modes to try.  Here the law chooses at times h
apart, so that switches are late by at most h; V falls to the order of ``h^2`` beside its start.

The pose that the law is given may be late, and off: at every sample by the worst of 27 errors, the one after which V
rises most (or falls least).  Speeds that would exceed a limit are scaled by one factor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from nonsmooth.analysis.fields.driven_field import ImposedMotions
from nonsmooth.analysis.trajectories.follow import DenseStep, HybridField, Mode, Path, follow
from nonsmooth.analysis.trajectories.result import End, EndReason, State, Trajectory
from nonsmooth.symbolic.numbers.plane_arrays import Floats

STEP = 0.02  # h, of the shortest time in which a twist answers: 1 over the gain and its squared size
MOST_STEPS = 20_000
SHOWN = 1_000  # states that the trajectory keeps
SIDES = 8  # directions of an error of the place


@dataclass(frozen=True)
class PoseErrors:
    """How old a pose is that a law is given, and how far it may be off.

    Attributes:
        delay: its age (time).
        place: largest distance from the true place, with l for the unit of length.
        heading: largest difference of headings (radian).
    """

    delay: float = 0.0
    place: float = 0.0
    heading: float = 0.0

    def candidates(self) -> Floats:
        """Errors ``(x, y, theta)`` that are tried, shape (m, 3): none, and those on the border."""
        turns = 2 * np.pi * np.arange(SIDES) / SIDES
        places = [(0.0, 0.0), *zip(self.place * np.cos(turns), self.place * np.sin(turns), strict=True)]
        found = [(*place, turn) for place, turn in product(places, (0.0, self.heading, -self.heading))]
        return np.unique(np.array(found), axis=0)


@dataclass(frozen=True)
class HeldLaw:
    """A law of imposed twists at samples.

    Attributes:
        cones: its twists; they go around.
        gain: k (1/time).
        limits: largest speeds, wheel by wheel, infinite where a wheel has none; None without limits.
    """

    cones: Sequence[ImposedMotions]
    gain: float
    limits: Floats | None = None

    def speeds(self, seen: Floats) -> Floats:
        """The speeds of all wheels for a pose that the law is given."""
        cone, chosen, factor = self._choice(seen)
        return np.asarray(factor * cone.speeds[chosen])

    def twist(self, seen: Floats, pose: Floats) -> Floats:
        """How a body at a pose moves under the speeds for another one."""
        cone, chosen, factor = self._choice(seen)
        return np.asarray(factor * cone.motions[chosen](pose[:2]))

    def _choice(self, seen: Floats) -> tuple[ImposedMotions, int, float]:
        """The cone, which of its twists, and the factor ``-k (g . xi_l)``, smaller where a speed would end."""
        cone = next((cone for cone in self.cones if _holds(cone, seen)), self.cones[0])
        products = cone.twists @ seen
        chosen = int(np.argmax(np.abs(products)))
        factor = -self.gain * float(products[chosen])
        if self.limits is None:
            return cone, chosen, factor
        demand = float((np.abs(factor * cone.speeds[chosen]) / self.limits).max())
        return cone, chosen, factor / max(1.0, demand)


def follow_held(law: HeldLaw, start: Sequence[float], until: float, errors: PoseErrors | None = None) -> Trajectory:
    """The path of ``(x, y, theta)`` from a start, measured from the checked point and with l for the unit of length.

    Before the start the body stood there.

    Args:
        law: what it samples.
        start: the pose.
        until: last time, unless 20,000 samples end before.
        errors: of the pose that the law is given.

    Returns:
        Method ``sampled``: states without events, as no switch is located.
    """
    fastest = max(float((cone.twists**2).sum(axis=1).max()) for cone in law.cones)
    step, errors = STEP / (law.gain * fastest), errors or PoseErrors()
    late = math.ceil(errors.delay / step)
    step = errors.delay / late if late else step
    count = min(math.ceil(until / step), MOST_STEPS)
    step = step if late else min(step, until / count)
    loop = _SampledLoop(law, errors.candidates(), late, count)
    times, states = follow(loop, (0.0, np.array(start, dtype=float)), None, _Held(step)).ends_of_steps()
    kept = np.unique(np.linspace(0, count, min(count, SHOWN) + 1).round().astype(int))
    shown: list[State] = [tuple(state) for state in states[kept].tolist()]
    end = End(float(times[-1]), shown[-1], EndReason.TIME)
    return Trajectory("exact", "sampled", tuple(times[kept].tolist()), tuple(shown), (), end, None)


class _SampledLoop(HybridField):
    """A law at samples: each is a mode, whose twist holds until the next."""

    dense = False

    def __init__(self, law: HeldLaw, errors: Floats, late: int, count: int) -> None:
        """For errors (m, 3) of the pose that the law is given, which is so many samples old."""
        self._law, self._errors, self._late, self._count = law, errors, late, count

    def next_mode(self, path: Path) -> Mode | EndReason:
        """The motion for one of the poses that the law may be given, of which V' is largest."""
        taken = len(path.stretches)
        if taken == self._count:
            return EndReason.TIME
        older = min(self._late, taken)
        seen = path.stretches[taken - older].states[0] if older else path.state
        twists = [self._law.twist(each, path.state) for each in seen + self._errors]
        return _Constant(max(twists, key=lambda twist: float(path.state @ twist)))


class _Constant(Mode):
    """A spatial twist that holds."""

    place, cells = "", ()

    def __init__(self, twist: Floats) -> None:
        self.rate = twist


class _Held:
    """The stepper of rigid motions of constant twist: one step to the next sample, exactly."""

    def __init__(self, step: float) -> None:
        self._step = step

    def steps(self, rate: Floats, t: float, x: Floats, until: None) -> Iterator[DenseStep]:
        """One step."""
        after = t + self._step, _moved(x, rate, self._step)
        yield DenseStep((t, x), after, lambda: lambda time: _moved(x, rate, time - t))


def _holds(cone: ImposedMotions, pose: Floats) -> bool:
    """Whether the direction of c lies in the cone: left of its first ray and right of its last."""
    if cone.rays is None:
        return True
    (ax, ay), (bx, by) = (ray[:2] for ray in cone.rays)
    x, y = pose[:2]
    return bool(ax * y - ay * x >= 0 >= bx * y - by * x)


def _moved(pose: Floats, twist: Floats, time: float) -> Floats:
    """A rigid motion of constant spatial twist ``c' = v + omega J c``, exactly."""
    x, y, theta = pose
    vx, vy, omega = twist
    turn = omega * time
    cosine, sine = np.cos(turn), np.sin(turn)
    along = np.sinc(turn / np.pi) * time  # sin(turn)/omega
    across = time * np.sinc(turn / (2 * np.pi)) * np.sin(turn / 2)  # (1 - cos(turn))/omega
    moved = (
        cosine * x - sine * y + along * vx - across * vy,
        sine * x + cosine * y + across * vx + along * vy,
        theta + turn,
    )
    return np.array(moved)
