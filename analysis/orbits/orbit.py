"""A periodic orbit in floats: one turn of legs that closes, its period and Floquet multipliers, and how far these err.

The n - 1 multipliers beside the one along the orbit are eigenvalues of the derivative of a turn.  In two states there
is one, and Liouville's formula gives it without cancellation.  A surface that is held for the whole turn adds a
multiplier of its own, across it: zero where both sides push onto the surface, so that neighbours come onto it in finite
time, and infinite where both push away, so that solutions leave it at any moment.

How far all this may err is measured, not assumed: the turn is computed once more with tolerances ten times as wide, and
from starts on either side of it, as far away as the orbit itself may lie.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import FacedField, Velocity, length
from nonsmooth.analysis.trajectories.faces import TANGENT_SLACK, largest
from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.smooth_path import Leg, follow_legs, onto
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite, spread

# ---- what is said where no periodic orbit is found, or nothing can be said of one ----------------


class OrbitError(ValueError):
    """No periodic orbit, or one whose derivative does not exist; the message says where and why."""


# ---- orbits --------------------------------------------------------------------------------------


Multipliers = NDArray[np.complex128]

ENDED = 1e-9  # of a period: what is left of it at the end of a path
COARSER = 10.0  # tolerances of the second computation; what it changes is about nine times the error of the first
BESIDE = 4.0  # of the distance within which the orbit lies: how far beside it its multipliers are looked at
SAFETY = 2.0  # on the changes of the multipliers that were seen
ROUNDING = 1e-12  # of a multiplier: no computation is better
NEAREST = 0.1  # of the extent of the orbit: if it may lie farther away than this nothing is known
LOOKS = 8  # places within each step of a slide where its sides are looked at


class SlideSense(IntEnum):
    """What the sides of a slide do to neighbours all along it."""

    ATTRACTS = -1
    OPEN = 0  # neither, or it is not known
    REPELS = 1


@dataclass(frozen=True)
class OrbitErrors:
    """How far the numbers of an orbit may err; infinite where nothing is known.

    Attributes:
        period: of the period (time).
        multipliers: of each multiplier, in the order of :attr:`Orbit.multipliers`.
    """

    period: float
    multipliers: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Orbit:
    """One turn of a periodic orbit.

    Attributes:
        field: whose solution it is.
        path: the turn, from a point inside a leg back to it.
        legs: its legs, in order; the first and the last are parts of one.
        gap: by how much the computed turn fails to close (largest entry).
        coarseness: factor on the tolerances of its computation.
    """

    field: SignField
    path: Trajectory
    legs: tuple[Leg, ...]
    gap: float
    coarseness: float = 1.0

    @property
    def period(self) -> float:
        """Time of one turn."""
        return self.legs[-1].end

    @property
    def point(self) -> Floats:
        """Where the turn begins and ends."""
        return self.legs[0].first

    @property
    def extent(self) -> float:
        """Largest side of the box around it."""
        return spread(self.path.array)

    @property
    def slides(self) -> bool:
        """Whether it keeps to a switching surface for a while."""
        return any(leg.motion.face.keep for leg in self.legs)

    @property
    def is_one_slide(self) -> bool:
        """Whether it keeps to a switching surface for the whole turn."""
        return all(leg.motion.face.keep for leg in self.legs)

    @cached_property
    def slide_sense(self) -> SlideSense:
        """What all slides of the orbit do to neighbours; open where they differ, attracting where there is none."""
        senses = {_sense(leg) for leg in self.legs if leg.motion.face.keep and leg.end > leg.start}
        return senses.pop() if len(senses) == 1 else SlideSense.OPEN if senses else SlideSense.ATTRACTS

    @cached_property
    def variation(self) -> Variation:
        """Derivative (n, n) of the state after one turn by the state before.

        Raises:
            OrbitError: where it does not exist.
        """
        return path_variation(self.field, self.legs, self.coarseness)

    @cached_property
    def multipliers(self) -> Multipliers:
        """The n - 1 Floquet multipliers beside the one along the orbit, which is 1; largest first.

        Raises:
            OrbitError: where the orbit has no derivative.
        """
        normals = normals_held(self.legs[0])
        count, held = normals.shape
        across_surfaces = np.full(held, math.inf if self.slide_sense is SlideSense.REPELS else 0.0, complex)
        if count - held == 1:
            return across_surfaces
        if count == 2:
            return np.array([self.variation.determinant], complex)
        along = self.legs[0].motion(0.0, self.point)
        basis, _ = np.linalg.qr(np.column_stack([along, np.eye(count) - normals @ normals.T]))
        along_surfaces = slice(1, count - held)
        across = (basis.T @ self.variation.derivative @ basis)[along_surfaces, along_surfaces]
        values = np.concatenate([np.linalg.eigvals(across).astype(complex), across_surfaces])
        return values[np.argsort(-np.abs(values), kind="stable")]

    @cached_property
    def errors(self) -> OrbitErrors:
        """How far the period and the multipliers may err.

        The end of the turn errs by about what wider tolerances change, e.  The orbit then lies within ``e/sigma`` of
        the computed one, where sigma is the least singular value of Newton's system, most likely along the singular
        vector of sigma; its multipliers may be those of starts so far to either side.  Where that is not near, or a
        multiplier is not told apart from one, starts beside the orbit may be periodic too: then the period is that of
        the computed start, and the multiplier nearest to one may be one.
        """
        try:
            rough = follow_turn(self.field, self.point, self.period, COARSER)
            end_error = self.gap + largest(rough.legs[-1].last - self.legs[-1].last)
            system, speed = newton_system(self)
            left, values, right = np.linalg.svd(system)
            is_isolated = end_error <= NEAREST * self.extent * values[-1]
            beside = [rough]
            if is_isolated:
                move = BESIDE * end_error / values[-1] * right[-1, :-1]
                beside += [self._beside(move), self._beside(-move)]
            errors = self._changes(beside)
        except (OrbitError, TrajectoryError):
            return OrbitErrors(math.inf, (math.inf,) * len(self.multipliers))
        distances = np.abs(np.abs(self.multipliers) - 1)
        period_error = end_error / speed
        if is_isolated and (distances > errors).all():
            period_error *= float(np.linalg.norm((right.T / values @ left.T)[-1]))
        if not is_isolated:
            nearest = int(np.argmin(distances))
            errors[nearest] = max(errors[nearest], distances[nearest])
        return OrbitErrors(period_error, tuple(errors.tolist()))

    def _beside(self, move: Floats) -> Orbit:
        """A turn of the same length from a start beside this one, on the same surfaces."""
        start = onto(self.point + move, self.legs[0].motion.face.keep, self.field.size)
        return follow_turn(self.field, start, self.period)

    def _changes(self, others: Sequence[Orbit]) -> Floats:
        """How much other computations change the multipliers, with some safety and the rounding of any computation."""
        finite = np.where(np.isinf(self.multipliers), 0.0, np.abs(self.multipliers))
        changes = [_differences(self.multipliers, other.multipliers) for other in others]
        return SAFETY * np.max(changes, axis=0) + ROUNDING * np.maximum(1.0, finite)

    @property
    def stability(self) -> str:
        """``attracting``, ``repelling``, ``saddle`` or ``undecided``: by the multipliers as computed, with errors."""
        if self.slide_sense is SlideSense.OPEN or (self.slide_sense is SlideSense.REPELS and not self.is_one_slide):
            return "undecided"
        sizes, errors = np.abs(self.multipliers), np.array(self.errors.multipliers)
        inside, outside = sizes + errors < 1, sizes - errors > 1
        if not (inside | outside).all():
            return "undecided"
        if inside.all():
            return "attracting"
        return "repelling" if outside.all() else "saddle"


def follow_turn(field: SignField, x: Floats, period: float, coarseness: float = 1.0) -> Orbit:
    """The path from a start over a time that is supposed to be a period; whether it closes, its gap says.

    Raises:
        OrbitError: where the path ends before.
        TrajectoryError: where it cannot be followed.
    """
    path, legs = follow_legs(field, tuple(x.tolist()), period, coarseness)
    if not legs or legs[-1].end < period or sum(leg.end - leg.start for leg in legs) < period * (1 - ENDED):
        raise OrbitError("the path ends within a turn, or its switches accumulate")
    return Orbit(field, path, legs, largest(legs[-1].last - legs[0].first), coarseness)


def newton_system(turn: Orbit) -> tuple[Floats, float]:
    """Newton's matrix for ``(dx, |f| dT)``, all in units of the states, and the speed ``|f|`` where the turn begins.

    Raises:
        OrbitError: where the turn has no derivative.
    """
    first, last, count = turn.legs[0], turn.legs[-1], len(turn.point)
    begin = first.motion(0.0, turn.point)
    speed = length(begin)
    system = np.zeros((count + 1, count + 1))
    system[:count, :count] = turn.variation.derivative - np.eye(count)
    system[:count, count] = last.motion(last.end, last.last) / speed
    system[count, :count] = begin / speed
    return system, speed


def _differences(first: Multipliers, second: Multipliers) -> Floats:
    """Distances between multipliers of two computations, each with its own partner; zero between infinite ones."""
    from scipy.optimize import linear_sum_assignment

    with np.errstate(invalid="ignore"):
        distances = np.abs(first[:, None] - second[None, :])
    distances[np.isinf(first)[:, None] & np.isinf(second)[None, :]] = 0.0
    if not are_finite(distances):
        distances = np.where(np.isfinite(distances), distances, np.finfo(float).max / 4)
    row, partner = linear_sum_assignment(distances)
    return distances[row, partner]


def _sense(leg: Leg) -> SlideSense:
    """Whether all sides of a slide push onto its surfaces, or all away from them, as often as it is looked at."""
    face = leg.motion.face
    sides = np.array(list(product((-1, 1), repeat=len(face.keep))))
    if len(face.members) != len(sides):
        return SlideSense.OPEN
    steps = leg.stretch.times
    times = np.interp(np.linspace(0, len(steps) - 1, LOOKS * len(steps)), range(len(steps)), steps)
    senses = set()
    for t in times.tolist():
        x = leg.at(t)
        fields = leg.motion.fields(t, x)
        away = sides * leg.motion.normal_speeds(x, fields) / largest(fields)
        senses |= {int(sign) for sign in np.sign(away[np.abs(away) > TANGENT_SLACK])}
    return SlideSense(senses.pop()) if len(senses) == 1 else SlideSense.OPEN


# ---- variation along an orbit --------------------------------------------------------------------
#
# Along a leg ``Phi' = (df/dx) Phi``.  Where the field jumps from ``f`` to ``g`` as the path meets ``h = 0``, neighbours
# meet it a little sooner or later, so that ``Phi`` is multiplied by ``S = 1 + (g - f) n^T/(n^T f)`` with the normal
# ``n = grad h`` there (Aizerman & Gantmakher 1958).  A path that begins to slide has ``n^T g = 0``, so ``n^T S = 0``:
# distance from the surface is lost, which makes a multiplier of zero.  A path that leaves a surface where the sliding
# field and that of the cell agree has ``S = 1``.  Where a path begins on a surface that it slides along, neighbours
# beside it come onto it at once, so that distance from the surface is lost there too.
#
# Liouville's formula gives the determinant a second time, without the cancellation in that of the product: along a leg
# ``exp(int div f dt)``, over a jump ``det S = (n^T g)/(n^T f)``.
#
# (Leine & Nijmeijer 2004, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems", ch. 7; di Bernardo et al. 2008,
# "Piecewise-smooth Dynamical Systems", ch. 2.)


# Relative to the size of the states: step of differences of fourth order, exact for polynomials of degree four; for
# others truncation (step^4) and rounding (1e-16/step) are both some 1e-13.
JACOBIAN_STEP = 1e-3
TOLERANCES = 1e-12, 1e-14  # of DOP853 for the variational equation, relative and absolute
GRAZES = 1e-7  # relative to the field: a slower approach to a surface has no saltation matrix to speak of
JUMPS = 1e-9  # relative to the fields: a smaller change at the end of a leg is none


@dataclass(frozen=True)
class Variation:
    """The derivative of a path by its start.

    Attributes:
        derivative: of the last state by the first (n, n).
        determinant: its determinant by Liouville's formula.
    """

    derivative: Floats
    determinant: float

    def then(self, later: Variation) -> Variation:
        """This one, followed by a later one."""
        return Variation(later.derivative @ self.derivative, later.determinant * self.determinant)


def jacobian(velocity: Velocity, t: float, x: Floats, step: float) -> Floats:
    """``df/dx`` (n, n) by central differences of fourth order with a step in units of the states."""
    columns = []
    for move in np.eye(len(x)) * step:
        near = velocity(t, x + move) - velocity(t, x - move)
        far = velocity(t, x + 2 * move) - velocity(t, x - 2 * move)
        columns.append((8 * near - far) / (12 * step))
    return np.column_stack(columns)


def leg_variation(leg: Leg, size: float, coarseness: float = 1.0) -> Variation:
    """Of a leg's last state by its first, over a fixed time.

    Args:
        leg: the leg.
        size: the unit of the states.
        coarseness: factor on the tolerances of the integrator and on the step of the differences; a result that another
            factor changes is not known any better.

    Raises:
        OrbitError: where the integrator gives up.
    """
    from scipy.integrate import solve_ivp

    count = len(leg.first)
    if leg.end <= leg.start:
        return Variation(np.eye(count), 1.0)
    velocity, (rtol, atol), step = leg.motion.velocity, TOLERANCES, JACOBIAN_STEP * coarseness * size

    def rates(t: float, z: Floats) -> Floats:
        x, phi = z[:count], z[count:-1].reshape(count, count)
        slopes = jacobian(velocity, t, x, step)
        return np.concatenate([velocity(t, x), (slopes @ phi).ravel(), [np.trace(slopes)]])

    start = np.concatenate([leg.first, np.eye(count).ravel(), [0.0]])
    tolerances = {"rtol": rtol * coarseness, "atol": atol * coarseness * size}
    done = solve_ivp(rates, (leg.start, leg.end), start, method="DOP853", **tolerances)
    if not done.success:
        raise OrbitError(f"the derivative of the path could not be followed past t = {done.t[-1]:.6g}")
    last = done.y[:, -1]
    with np.errstate(over="ignore"):
        return Variation(np.asarray(last[count:-1].reshape(count, count)), float(np.exp(last[-1])))


def saltation(before: Leg, after: Leg, field: FacedField) -> Variation:
    """``S`` between two legs.

    Raises:
        OrbitError: for a path that only grazes the surface, or meets another one at the same moment.
    """
    x, t = before.last, before.end
    old, new = before.motion(t, x), after.motion(t, x)
    identity = np.eye(len(x))
    scale = max(largest(old), largest(new))
    if largest(new - old) <= JUMPS * scale:
        return Variation(identity, 1.0)
    if not before.met:
        raise OrbitError(
            f"the field jumps at {x.tolist()} where the path meets no surface: its derivative is not known"
        )
    if _surfaces_at(field, x) > len({*map(id, before.motion.face.keep), *map(id, before.met)}):
        raise OrbitError(f"the path meets several surfaces at once at {x.tolist()}: it has no derivative there")
    normal = before.met[0].gradient(x)
    approach = float(normal @ old)
    if abs(approach) <= GRAZES * length(normal) * scale:
        raise OrbitError(f"the path only grazes {before.met[0].name} = 0 at {x.tolist()}: it has no derivative there")
    jump = np.asarray(identity + np.outer(new - old, normal) / approach)
    return Variation(jump, 0.0 if before.met[0] in after.motion.face.keep else float(normal @ new) / approach)


def normals_held(leg: Leg) -> Floats:
    """Orthonormal normals (n, k) of the surfaces that a leg keeps to, at its first state."""
    held = [surface.normal(leg.first) for surface in leg.motion.face.keep]
    return np.linalg.qr(np.array(held).T)[0] if held else np.empty((len(leg.first), 0))


def path_variation(field: FacedField, legs: Sequence[Leg], coarseness: float = 1.0) -> Variation:
    """The variation along some legs, from the surfaces that the first one keeps to.

    Raises:
        OrbitError: where it does not exist.
    """
    normals = normals_held(legs[0])
    onto_surfaces = np.eye(len(normals)) - normals @ normals.T
    total = Variation(onto_surfaces, 0.0 if normals.shape[1] else 1.0)
    total = total.then(leg_variation(legs[0], field.size, coarseness))
    for before, leg in pairwise(legs):
        total = total.then(saltation(before, leg, field)).then(leg_variation(leg, field.size, coarseness))
    return total


def _surfaces_at(field: FacedField, x: Floats) -> int:
    """How many surfaces pass through a state."""
    return len({id(surface) for face in field.faces_at(x) for surface in face.keep})
