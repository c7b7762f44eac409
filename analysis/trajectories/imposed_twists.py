"""The law of imposed twists: its closed loop, and as a digital controller runs it, speeds held between samples.

The event-driven path of the closed loop follows the exact Filippov solution; where many cones of directions of c meet
at ``c = 0`` it has too many patterns of modes to try.  Here the law chooses at times h
apart, so that switches are late by at most h; V falls to the order of ``h^2`` beside its start.

The pose that the law is given may be late, by whole samples or by less than one, and off: at every sample by the worst
of 27 errors, the one after which V rises most (or falls least).  Speeds that would exceed a limit are scaled by one
factor.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations, product
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.fields.constant_field import flow_of
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import Surface, Velocity, affine_surface
from nonsmooth.analysis.trajectories.closed_forms import Free
from nonsmooth.analysis.trajectories.follow import DenseStep, HybridField, Mode, Path, follow
from nonsmooth.analysis.trajectories.result import End, EndReason, State, Trajectory
from nonsmooth.symbolic.messages.under_way import tell_count
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats, even_angles, squared_norms

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
        turns = even_angles(SIDES)
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
        sides: rows ``(n_x, n_y, offset)`` with ``n . c + offset <= 0`` in the hull of the wheels, outside of which the
            body tips; None where that is not asked.
    """

    cones: Sequence[ImposedMotions]
    gain: float
    limits: Floats | None = None
    sides: Floats | None = None

    def speeds(self, seen: Floats) -> Floats:
        """The speeds of all wheels for a pose that the law is given."""
        cone, chosen, factor = self._choice(seen)
        return np.asarray(factor * cone.speeds[chosen])

    def twist(self, seen: Floats, pose: Floats) -> Floats:
        """How a body at a pose moves under the speeds for another one."""
        cone, chosen, factor = self._choice(seen)
        return factor * cone.motions[chosen](pose[:2])

    def tips(self, pose: Floats) -> bool:
        """Whether the centre of mass is outside the hull of the wheels."""
        return self.sides is not None and float((self.sides @ (*pose[:2], 1.0)).max()) > 0

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
        until: last time, unless 20,000 samples end before, or the body tips.
        errors: of the pose that the law is given.

    Returns:
        Method ``sampled``: states without events, as no switch is located.
    """
    fastest = max(float(squared_norms(cone.twists).max()) for cone in law.cones)
    step, errors = STEP / (law.gain * fastest), errors or PoseErrors()
    late = math.ceil(errors.delay / step)
    step = errors.delay / late if late > 1 else step
    asked = math.ceil(until / step)
    count = min(asked, MOST_STEPS)
    step = step if late > 1 else min(step, until / count)
    loop = _SampledLoop(law, errors.candidates(), late, errors.delay / (max(late, 1) * step), count)
    path = follow(loop, (0.0, np.array(start, dtype=float)), None, _Held(step))
    times, states = path.ends_of_steps()
    taken = len(times) - 1
    kept = np.unique(np.linspace(0, taken, min(taken, SHOWN) + 1).round().astype(int))
    shown: list[State] = [tuple(state) for state in states[kept].tolist()]
    ended = path.reason if count == asked or taken < count else EndReason.STEPS
    end = End(float(times[-1]), shown[-1], ended)
    return Trajectory("exact", "sampled", (), end, None, sampled=(tuple(times[kept].tolist()), tuple(shown)))


class _SampledLoop(HybridField):
    """A law at samples: each is a mode, whose twist holds until the next."""

    dense = False

    def __init__(self, law: HeldLaw, errors: Floats, late: int, share: float, count: int) -> None:
        """For errors (m, 3) of the pose that the law is given, which is so many times that share of a sample old."""
        self._law, self._errors, self._late, self._share, self._count = law, errors, late, share, count

    def next_mode(self, path: Path) -> Mode | EndReason:
        """The motion for one of the poses that the law may be given, of which V' is largest."""
        taken = len(path.stretches)
        if taken == self._count:
            return EndReason.TIME
        if self._law.tips(path.state):
            return EndReason.TIPS
        tell_count(taken, self._count, "samples")
        older = min(self._late, taken)
        seen = path.stretches[taken - older].states[0] if older else path.state
        if older == 1 and self._share < 1:  # on the straight line between two samples
            seen = path.state + self._share * (seen - path.state)
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
        motion = Free((x[0], x[1]), x[2], flow_of(rate.tolist(), Kinematics.EXACT))
        after = t + self._step, np.array(motion.state(self._step))
        yield DenseStep((t, x), after, lambda: lambda time: np.array(motion.state(time - t)))


def _holds(cone: ImposedMotions, pose: Floats) -> bool:
    """Whether the direction of c lies in the cone: left of its first ray and right of its last."""
    if cone.rays is None:
        return True
    (ax, ay), (bx, by) = (ray[:2] for ray in cone.rays)
    x, y = pose[:2]
    return bool(ax * y - ay * x >= 0 >= bx * y - by * x)


# ---- the closed loop as a switched field ---------------------------------------------------------
#
# The law imposes one of some twists: a switched field whose modes are known.
#
# The law of the rules ``box`` and ``ellipse`` imposes ``-k (g . xi_l) xi_l`` with the ``xi_l`` of the largest
# ``|g . xi_l|``, where ``g = (c, theta)`` with l for the unit of length.  Its modes switch on planes through the
# checked point: ``g . (xi_l - xi_m) = 0`` and ``g . (xi_l + xi_m) = 0``, and where the law has twists of its own for
# each cone of directions of c, on the lines between the cones.  D is homogeneous in twist and speeds together: a
# mode's motion is its motion at unit gain times ``-k (g . xi_l)``.


STATES = ("x", "y", "theta")
# Entries of unit normals that differ by less are the same plane: far above their rounding, and a plane that is taken
# for another one would have to be this close to it.
SAME_PLANE = 1e-12

Motion: TypeAlias = Callable[[Floats], Floats]  # the twist about c*, at unit gain, by the displacement c of the body


@dataclass(frozen=True, eq=False)
class ImposedMotions:
    """The twists of one cone of directions of c, in floats.

    Attributes:
        rays: first and last direction of the cone, counterclockwise; None all around.
        twists: xi_l, shape (m, 3).
        motions: the motion that the speeds of each impose.
        speeds: the speeds that impose each, wheel by wheel, shape (m, n).
    """

    rays: tuple[Floats, Floats] | None
    twists: Floats
    motions: tuple[Motion, ...]
    speeds: Floats


def driven_field(cones: Sequence[ImposedMotions], size: float, gain: float) -> SignField:
    """The closed loop under exact kinematics, in lengths l from the checked point.

    Args:
        cones: the law; they go around.
        size: of the states, which sets the slack of the surfaces.
        gain: k.
    """
    lines = _distinct([np.array([-ray[1], ray[0], 0.0]) for cone in cones for ray in cone.rays or ()])
    planes = _distinct([normal for cone in cones for normal in _ties(cone.twists)])
    normals = [*lines, *planes]

    @cache
    def flow(signs: Signs) -> Velocity:
        cone = _cone(cones, lines, signs)
        chosen = _largest(cone, normals, signs)
        return lambda t, x: _rate(cone, chosen, x, gain)

    surfaces = [_surface(normal, k, len(lines)) for k, normal in enumerate(normals)]
    return SignField(STATES, tuple(surfaces), flow, size, kinematics="exact")


def _surface(normal: Floats, index: int, lines: int) -> Surface:
    name = f"direction {index + 1}" if index < lines else f"tie {index - lines + 1}"
    return affine_surface(name, normal.tolist())


def _rate(cone: ImposedMotions, chosen: int, g: Floats, gain: float) -> Floats:
    """The pose rate ``(v + omega J c, omega)`` of the imposed motion."""
    vx, vy, omega = -gain * float(g @ cone.twists[chosen]) * cone.motions[chosen](g[:2])
    return np.array([vx - omega * g[1], vy + omega * g[0], omega])


def _ties(twists: Floats) -> list[Floats]:
    """Normals of the planes on which two of the products are equally large."""
    return [a + side * b for a, b in combinations(twists, 2) for side in (-1.0, 1.0)]


def _distinct(normals: Sequence[Floats]) -> list[Floats]:
    """Unit normals of different planes."""
    found: list[Floats] = []
    for normal in normals:
        unit = normal / np.linalg.norm(normal)
        if all(min(np.abs(unit - other).max(), np.abs(unit + other).max()) > SAME_PLANE for other in found):
            found.append(unit)
    return found


def _side(normals: Sequence[Floats], signs: Signs, normal: Floats) -> int:
    """On which side of its plane a pattern of signs lies."""
    products = [float(other @ normal) / float(np.linalg.norm(normal)) for other in normals]
    index = int(np.argmax(np.abs(products)))
    return signs[index] * sign(products[index])


def _cone(cones: Sequence[ImposedMotions], lines: Sequence[Floats], signs: Signs) -> ImposedMotions:
    """The cone of a pattern: left of its first ray and right of its last; the first of all where none is.

    Patterns without points are asked for too, by smoothing.
    """
    for cone in cones:
        if cone.rays is None:
            return cone
        start, end = (np.array([-ray[1], ray[0], 0.0]) for ray in cone.rays)
        if _side(lines, signs, start) > 0 > _side(lines, signs, end):
            return cone
    return cones[0]


def _largest(cone: ImposedMotions, normals: Sequence[Floats], signs: Signs) -> int:
    """The twist with the largest ``|g . xi_l|``: ``|a| > |b|`` where ``(a - b)(a + b) > 0``."""
    wins = [0] * len(cone.twists)
    for first, second in combinations(range(len(cone.twists)), 2):
        a, b = cone.twists[first], cone.twists[second]
        larger = _side(normals, signs, a - b) * _side(normals, signs, a + b) > 0
        wins[first if larger else second] += 1
    return int(np.argmax(wins))
