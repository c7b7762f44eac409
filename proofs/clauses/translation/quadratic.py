"""A quadratic Lyapunov function where ``|c|^2`` is none: ``V = c^T P c`` with ``V* < 0`` on the fan.

On a cone with rays ``r_1, r_2`` and velocity v the derivative ``2 c^T P v`` is linear in c, so ``V* < 0`` off the
equilibrium iff ``r^T P v < 0`` at both rays of every cone: linear in P.  A small conic program (CVXPY) proposes
``P = [[1 + a, b], [b, 1 - a]]``, a and b are rounded to rationals, and the inequalities are verified exactly.  With
``-r^T P v >= m_k |r|`` on both rays of cone k its velocity alone gives ``-2 m_k |c|``.  Exact kinematics add
``2 omega_k c^T P J c``, at most ``2 |omega_k| rho |c|^2`` with ``rho^2 = a^2 + b^2``.  With m the least m_k that leaves
``V* <= -m |c|`` where ``|c| <= (2 m_k - m)/(2 |omega_k| rho)`` for every cone.  V falls, so the body stays in
``|c|^2 <= V(c_0)/(1 - rho) <= |c_0|^2 (1 + rho)/(1 - rho)``.

The region keeps every body at distances ``|c| <= C`` inside the fan, so any P that falls on the fan, not only the one
of the region, bounds the time of arrival: ``V <= (1 + rho) |c|^2`` and ``V* <= -2 (m_k - |omega_k| rho C) |c|`` make
sqrt(V) fall at least with the speed ``s/sqrt(1 + rho)``, s the least ``m_k - |omega_k| rho C``, so the body arrives
within ``(1 + rho) |c_0|/s``; C and s get better on the way.  The P that is best at the distance C is a conic
program too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import isqrt
from typing import Any

import numpy as np

from nonsmooth.analysis.cells.fan import CellCone
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.minimizers.cvxpy_import import load_cvxpy
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.enclosures import enclosure, rational_above, rational_below
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import lower_text, upper_text
from nonsmooth.symbolic.numbers.plane import Vector, around, dot, minus
from nonsmooth.symbolic.numbers.plane_arrays import Floats

DENOMINATOR = 2**12  # of the rounded a and b
DIGITS = 4  # significant digits of a radius, a decay and a speed, on the safe side
STEPS = 16  # of the way home, each with its own speed
_INSIDE = 0.98  # largest radius of (a, b): keeps P away from singular


@dataclass(frozen=True)
class QuadraticDecrease:
    """``r^T P v <= -m |r|`` on every ray of a fan, for each velocity v beside it.

    Attributes:
        shape: (a, b) of ``P = [[1 + a, b], [b, 1 - a]]``.
        decay: m > 0.
    """

    shape: tuple[Fraction, Fraction]
    decay: Fraction

    @property
    def eccentricity(self) -> Fraction:
        """A rational from rho, by which ``c^T P c`` differs at most from ``|c|^2``, up to one."""
        a, b = self.shape
        return root_above(a * a + b * b)


@dataclass(frozen=True)
class QuadraticCertificate:
    """``V = c^T P c`` that decreases on every cone of a fan.

    Attributes:
        shape: (a, b) of ``P = [[1 + a, b], [b, 1 - a]]``.
        decay: m > 0 with ``V* <= -m |c|`` on the region, under exact and leading-order kinematics.
        level: the region ``V < level`` lies in the cells of the fan.
        cones: the fan.
        swift: what bounds the time of arrival; None for the same P and m.
    """

    shape: tuple[Fraction, Fraction]
    decay: Fraction
    level: Number
    cones: tuple[CellCone, ...]
    swift: QuadraticDecrease | None = None

    def __str__(self) -> str:
        a, b = self.shape
        return f"({1 + a})*x**2 + ({2 * b})*x*y + ({1 - a})*y**2"

    @property
    def descent(self) -> QuadraticDecrease:
        """Of the P of the region."""
        return QuadraticDecrease(self.shape, self.decay)

    @property
    def arrival_per_distance(self) -> Fraction:
        """Bound on the arrival time per unit of |c_0|, from starts in the region.

        The way of sqrt(V) to zero is cut into equal steps, each taken at least with its own speed.  From nearer starts
        the bound is better.
        """
        swift = self.swift or self.descent
        times = [1 / self.speed(swift, Fraction(k, STEPS)) for k in range(1, STEPS + 1)]
        return (1 + swift.eccentricity) * sum(times, Fraction(0)) / STEPS

    def speed(self, swift: QuadraticDecrease, share: Fraction = Fraction(1)) -> Fraction:
        """The least ``m_k - |omega_k| rho C_s``, rounded down, where sqrt(V) is at most a share s of its largest value.

        There ``|c| <= C_s``, the less of C and ``s sqrt((1 + rho)/(1 - rho)) C``, and C bounds ``|c|`` on the region;
        zero where it is not positive.
        """
        rho = swift.eccentricity
        nearer = min(
            rational_ball(Fraction(1)),
            rational_ball(share) * rational_ball((1 + rho) / (1 - rho)).sqrt(),
            key=lambda x: x.upper(),
        )
        farthest = nearer * enclosure(self.level / (1 - self.descent.eccentricity)).sqrt()
        least: Fraction | None = None
        for cone, twist in _motions(self.cones):
            steep = rational_ball(steepness(swift.shape, cone, twist))
            left = rational_below(steep - enclosure(abs(twist.omega) * rho) * farthest)
            least = left if least is None else min(least, left)
        return Fraction(lower_text(least, DIGITS)) if least is not None and least > 0 else Fraction(0)

    @property
    def disc_radius(self) -> Number:
        """Radius of a disc inside the region: ``V <= (1 + rho) |c|^2``, so ``|c|^2 < level/(1 + rho)`` suffices."""
        squared = self.level / (1 + self.descent.eccentricity)
        root = rational_below(enclosure(squared).sqrt())
        return squared.field(Fraction(lower_text(root, DIGITS)))

    @property
    def swing_radius(self) -> Number:
        """A distance that no body from the disc exceeds: ``|c|^2 <= (1 + rho)/(1 - rho) |c_0|^2``."""
        rho = self.descent.eccentricity
        squared = self.disc_radius * self.disc_radius * ((1 + rho) / (1 - rho))
        return squared.field(Fraction(upper_text(rational_above(enclosure(squared).sqrt()), DIGITS)))

    def value(self, c: Point) -> Number:
        """``c^T P c``."""
        return dot(c, shaped(self.shape, c))

    def largest_level(self) -> Number:
        """Level of the largest region: inside the fan's cells, and where turning leaves the decay.

        ``V < level`` implies ``|c|^2 < level/(1 - rho)``; with ``rho <= r`` rational the bound is
        ``(1 - r) ((2 m_k - m)/(2 omega_k r))^2``, the least of all cones.
        """
        level = min(self.least_on(p, q) for p, q in rim(self.cones))
        r = self.descent.eccentricity
        for cone, twist in _motions(self.cones):
            if twist.omega and r:
                spare = 2 * steepness(self.shape, cone, twist) - self.decay
                reach = max(spare, Fraction(0)) / (2 * r * abs(twist.omega))
                level = min(level, (1 - r) * reach * reach)
        return level

    def least_on(self, start: Point, end: Point) -> Number:
        """Least value of V on a segment."""
        along = minus(end, start)
        least: Number = least_of_parabola(self.value(start), dot(start, shaped(self.shape, along)), self.value(along))
        return least


def least_of_parabola(constant: Any, slope: Any, curve: Any) -> Any:
    """The least ``constant + 2 slope t + curve t^2`` for t from 0 to 1, of numbers; of balls what it is not below."""
    if slope >= 0:
        return constant
    if slope + curve <= 0:
        return constant + 2 * slope + curve
    return constant - slope * slope / curve


def find_quadratic(
    cones: tuple[CellCone, ...], border: Sequence[tuple[Point, Point]] = ()
) -> QuadraticCertificate | None:
    """Search P for the fan; None where the search or the exact verification fails.

    Args:
        cones: the fan.
        border: segments that the region must not reach.
    """
    wide = _descent(cones, propose_shape(_pairs(cones)))
    if wide is None:
        return None
    trial = QuadraticCertificate(wide.shape, wide.decay, cones[0].start[0].field.one, cones)
    certificate = replace(trial, level=min([trial.largest_level(), *(trial.least_on(p, q) for p, q in border)]))
    swift = _descent(cones, propose_swift_shape(cones, certificate.swing_radius))
    swifter = replace(certificate, swift=swift)
    if swift is not None and swifter.speed(swift) > 0:
        certificate = min(certificate, swifter, key=lambda decrease: decrease.arrival_per_distance)
    falls = certificate.speed(certificate.swift or certificate.descent) > 0
    return certificate if falls and sign(certificate.level) > 0 else None


def _descent(cones: Sequence[CellCone], proposal: tuple[float, float] | None) -> QuadraticDecrease | None:
    """A proposed P, rounded, with the least steepness of all cones; None unless that and P are positive."""
    if proposal is None:
        return None
    shape = (_rounded(proposal[0]), _rounded(proposal[1]))
    if not shape[0] ** 2 + shape[1] ** 2 < 1:
        return None
    decay = min(steepness(shape, cone, twist) for cone, twist in _motions(cones))
    return QuadraticDecrease(shape, decay) if decay > 0 else None


def steepness(shape: tuple[Fraction, Fraction], cone: CellCone, twist: Twist) -> Fraction:
    """A rational m with ``-r^T P v >= m |r|`` on both rays of a cone, and therefore on all between them.

    It lies below the largest one by the last of :data:`DIGITS` digits, and is not positive where that is not.
    """
    down = [-dot(ray, shaped(shape, twist.velocity)) for ray in (cone.start, cone.end)]
    lengths = [enclosure(dot(ray, ray)).sqrt() for ray in (cone.start, cone.end)]
    least = min(rational_below(enclosure(fall) / length) for fall, length in zip(down, lengths, strict=True))
    return Fraction(lower_text(least, DIGITS)) if least > 0 else least


def shaped(shape: tuple[Fraction, Fraction], c: Point) -> Vector:
    """``P c`` with ``P = [[1 + a, b], [b, 1 - a]]``."""
    a, b = shape
    return (1 + a) * c[0] + b * c[1], b * c[0] + (1 - a) * c[1]


def propose_shape(pairs: Iterable[tuple[Point, Vector]]) -> tuple[float, float] | None:
    """The (a, b) for which the largest ``r^T P v`` of all pairs (r, v) of directions is lowest; None unless negative.

    A second-order cone program in floats: its answer is a proposal.
    """
    load_cvxpy()
    import cvxpy as cp

    shape, margin = cp.Variable(2), cp.Variable()
    constraints: list[cp.Constraint] = [cp.SOC(cp.Constant(_INSIDE), shape)]
    for ray, velocity in pairs:
        r, v = _direction(ray), _direction(velocity)
        if r is None or v is None:
            return None
        size = np.hypot(*r) * np.hypot(*v)
        constraints.append(_by_shape(r, v) @ shape / size + r @ v / size <= -margin)
    cp.Problem(cp.Maximize(margin), constraints).solve(solver=cp.CLARABEL)
    if shape.value is None or margin.value is None or not float(margin.value) > 0:
        return None
    a, b = (float(x) for x in shape.value)
    return a, b


def propose_swift_shape(cones: Sequence[CellCone], farthest: Number) -> tuple[float, float] | None:
    """The (a, b) with the largest ``min_k (m_k - |omega_k| rho C)/(1 + rho)`` for a C; None unless that is positive.

    With ``Q = P/(1 + rho) = [[t + a', b'], [b', t - a']]``, whose largest eigenvalue ``t + |(a', b')|`` is one, it is
    the largest s with ``-r^T Q v - |omega| C |(a', b')| |r| >= s |r|`` of all rays r and motions beside them.  A
    second-order cone program in floats: it only proposes.
    """
    load_cvxpy()
    import cvxpy as cp

    fastest = max(abs(part) for _, twist in _motions(cones) for part in twist.velocity)
    tilt, size, margin, bent = cp.Variable(2), cp.Variable(), cp.Variable(), cp.Variable()
    constraints: list[cp.Constraint] = [cp.SOC(bent, tilt), size + bent <= 1, bent <= _INSIDE * size]
    for cone, twist in _motions(cones):
        v = np.array([float(x / fastest) for x in twist.velocity])
        turning = float(abs(twist.omega) * farthest / fastest)
        for ray in (cone.start, cone.end):
            r = _direction(ray)
            if r is None:
                return None
            r = r / np.hypot(*r)
            constraints.append(_by_shape(r, v) @ tilt + size * float(r @ v) + turning * bent <= -margin)
    cp.Problem(cp.Maximize(margin), constraints).solve(solver=cp.CLARABEL)
    if tilt.value is None or size.value is None or margin.value is None or not float(margin.value) > 0:
        return None
    a, b = (float(x / size.value) for x in tilt.value)
    return a, b


def _by_shape(r: Floats, v: Floats) -> Floats:
    """What a and b add to ``r^T P v``, for each unit of them."""
    return np.array([r[0] * v[0] - r[1] * v[1], r[0] * v[1] + r[1] * v[0]])


def _rounded(value: float) -> Fraction:
    return Fraction(round(value * DENOMINATOR), DENOMINATOR)


def root_above(square: Fraction) -> Fraction:
    """A rational at least the square root, below one for squares below one."""
    scaled = square * DENOMINATOR**4
    root = Fraction(isqrt(scaled.numerator // scaled.denominator) + 1, DENOMINATOR**2)
    return min(root, (1 + square) / 2)  # the arithmetic mean of 1 and the square is above the root as well


def _direction(vector: Point) -> Floats | None:
    """A vector in floats of order one, whatever its unit; None for zero."""
    largest = max(abs(vector[0]), abs(vector[1]))
    return np.array([float(x / largest) for x in vector]) if largest else None


def _motions(cones: Sequence[CellCone]) -> Iterator[tuple[CellCone, Twist]]:
    """Each cone with each of its motions."""
    for cone in cones:
        for twist in cone.twists:
            yield cone, twist


def _pairs(cones: Sequence[CellCone]) -> Iterator[tuple[Point, Vector]]:
    """Each ray of each cone with each of the cone's velocities."""
    for cone, twist in _motions(cones):
        yield cone.start, twist.velocity
        yield cone.end, twist.velocity


def rim(cones: tuple[CellCone, ...]) -> Iterator[tuple[Point, Point]]:
    """Sides of the fan's cells that do not pass through the equilibrium."""
    for cone in cones:
        polygon = cone.cell.polygon
        for side, ends in zip(polygon.sides, around(polygon.vertices), strict=True):
            if sign(side.offset):
                yield ends
