"""How fast the feedback clause's law decreases V: the largest certified rate on the cones at the equilibrium.

With ``u = -k (a, b)`` and ``V = c^T P c + w theta^2`` one has ``V' = -2 k (a^2 + b^2)``, where a and b are linear in
(c, tau), ``tau = w theta + c^T P J c``.  So ``V' <= -2 k kappa V`` near the equilibrium if on every cone ``c = s r_1 +
t r_2`` (s, t >= 0, tau free) ::

    (s, t, tau) M (s, t, tau)^T >= 0,     M = A A^T + B B^T - kappa' G

with A, B the coefficients of a, b and G the Gram matrix of ``c^T P c + tau^2/w``.  Tau is free, so its entry must be
positive and the Schur complement copositive on the quadrant: ``S_11, S_22 >= 0`` and ``S_12 >= -sqrt(S_11 S_22)`` (the
S-procedure for a cone of two rays is exact).  Floats bisect for kappa; a rational below it is verified exactly.

For ``P = I`` tau is ``w theta``, and kappa' = kappa.  Otherwise ``|c^T P J c| <= rho |c|^2`` with
``rho^2 = e^2 + f^2``; so
``kappa' = (1 + eta) kappa`` suffices where ``|c|^2 <= eta^2 (1 - rho) w/((1 + eta) rho^2)``, a disc about c*.

The rate grows with w (a larger w lets theta count more in the law) up to that of ``tau^2/w = 0``; the weight taken is
``l^2`` times the smallest power of two that gives at least half of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import isqrt
from typing import Any

from flint import arb

from nonsmooth.analysis.cells.fan import CellCone, build_fan
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.support import limiting_support
from nonsmooth.proofs.clauses.feedback.control_lyapunov import SQUARES, ControlLyapunov, Shape
from nonsmooth.proofs.clauses.translation.quadratic import root_above
from nonsmooth.symbolic.constraints import Triple
from nonsmooth.symbolic.numbers.lazy import FEW_ROOTS, Lazy
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.rounded import plain
from nonsmooth.symbolic.plane import dot

DIGITS = 4  # significant digits of the certified rate
_BISECTIONS = 60
_SMALLER = Fraction(9, 10)  # next try where rounding made the proposal too large
_TRIES = 40
SLACK = Fraction(1, 100)  # eta
_LARGEST_EXPONENT = 64  # of the weight, in the square of the array's own length
_FLOAT_RANGE = 10**300
_FEW_BITS = 8  # correct ones of a size


@dataclass(frozen=True)
class ConeRate:
    """The quadratic form of one cone.

    Attributes:
        cell: number of the cell.
        rays: ``r_1, r_2``.
        fields: the control vector fields ``g_i, g_j``.
        lyapunov: V.
    """

    cell: int
    rays: tuple[Point, Point]
    fields: tuple[Triple, ...]
    lyapunov: ControlLyapunov = SQUARES

    @cached_property
    def products(self) -> tuple[tuple[Any, ...], list[tuple[Any, ...]]]:
        """What the form holds whatever kappa and w are: products of the rays, and of each field with them."""
        p, q = self.rays
        slope_p, slope_q = self.lyapunov.slope(p), self.lyapunov.slope(q)
        rays = tuple(dot(*pair) for pair in ((p, slope_p), (p, slope_q), (q, slope_q)))
        fields: list[tuple[Any, ...]] = []
        for x, y, turn in self.fields:
            a, b = slope_p[0] * x + slope_p[1] * y, slope_q[0] * x + slope_q[1] * y
            fields.append((a * a, a * b, b * b, a * turn, b * turn, turn * turn))
        return rays, fields

    def holds(self, kappa: Fraction) -> bool:
        """Whether ``a^2 + b^2 >= kappa V`` on the closed cone near the equilibrium, exactly."""
        inner = kappa * (1 + SLACK) if any(self.lyapunov.shape) else kappa
        # Schur complement with respect to tau, times the corner entry
        s11, s12, s22, corner = _complement(self.products, inner, 1 / self.lyapunov.weight, self.fields[0][2] * 0)
        if corner.sign() <= 0 or s11.sign() < 0 or s22.sign() < 0:
            return False
        return s12.sign() >= 0 or sign(s11 * s22 - s12 * s12) >= 0


@dataclass(frozen=True)
class FeedbackRate:
    """Certified ``V' <= -2 k kappa V`` near the equilibrium.

    Attributes:
        kappa: the rate.
        cones: the forms of all cones.
        limit: distance of the border of the support polygon, or a little less, where the checked square leaves it.
    """

    kappa: Fraction
    cones: tuple[ConeRate, ...]
    limit: Fraction | None = None

    @property
    def reach(self) -> Fraction | None:
        """The rate holds within this distance of c*, in the cells there; None where they alone bound it."""
        bounds = [bound for bound in (self._shape_reach(), self.limit) if bound is not None]
        return min(bounds, default=None)

    def _shape_reach(self) -> Fraction | None:
        """Where exact kinematics turn V no more than the rate allows; None for ``P = I``, which they do not turn."""
        (e, f), weight = self.cones[0].lyapunov.shape, self.cones[0].lyapunov.weight
        if not e and not f:
            return None
        rho = root_above(e * e + f * f)
        square = SLACK**2 * (1 - rho) * weight / ((1 + SLACK) * rho**2)
        shift = max(0, 32 - (square.numerator.bit_length() - square.denominator.bit_length()) // 2)
        scaled = square * 4**shift  # at least 2^62
        return Fraction(isqrt(scaled.numerator // scaled.denominator), 2**shift)

    def check(self, lyapunov: ControlLyapunov = SQUARES) -> bool:
        """Re-verify the inequality on every cone, with the given V."""
        about_it = bool(self.cones) and all(cone.lyapunov == lyapunov for cone in self.cones)
        return about_it and self.kappa > 0 and all(cone.holds(self.kappa) for cone in self.cones)


def certified_rate(partition: Partition, lyapunov: ControlLyapunov = SQUARES) -> FeedbackRate | None:
    """The largest rate found for a centred partition of rule ``nearest`` with a stabilizing law; None if none is."""
    cones = _build_cones(partition, lyapunov)
    length = partition.scene.check.length
    floats, unit = _in_floats(cones, length)
    proposal = _proposal(floats, _lightness(lyapunov.weight / length**2, unit))
    if proposal <= 0:
        return None
    kappa = rounded_down(proposal / float(1 + SLACK) if any(lyapunov.shape) else proposal)
    for _ in range(_TRIES):
        if all(cone.holds(kappa) for cone in cones):
            support = limiting_support(partition)
            limit = support.distance_below if support is not None and support.stands else None
            return FeedbackRate(kappa, cones, limit)
        kappa *= _SMALLER
    return None


def balanced(partition: Partition, shape: Shape) -> ControlLyapunov:
    """V with the smallest w, ``l^2`` times a power of two, that gives at least half the rate that any w can give."""
    length = partition.scene.check.length
    floats, unit = _in_floats(_build_cones(partition, ControlLyapunov(shape)), length)
    enough = _proposal(floats, 0.0) / 2
    low, high = -_LARGEST_EXPONENT, _LARGEST_EXPONENT
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if _proposal(floats, 2.0**-middle) >= enough else (middle + 1, high)
    return ControlLyapunov(shape, length**2 * Fraction(2) ** (low - 2 * unit))


def _build_cones(partition: Partition, lyapunov: ControlLyapunov) -> tuple[ConeRate, ...]:
    late = len(partition.scene.field.radicands) > FEW_ROOTS
    return tuple(
        _cone_rate(cone, tuple(state.control_fields.values()), lyapunov, late=late)
        for cone in build_fan(partition)
        for state in cone.cell.states
    )


def _cone_rate(cone: CellCone, fields: tuple[Triple, ...], lyapunov: ControlLyapunov, *, late: bool) -> ConeRate:
    """The form of one cone; over many square roots its numbers are evaluated late, since products of four occur."""

    def entry(value: Any) -> Any:
        return Lazy.of(value) if late and isinstance(value, Number) else value

    start, end = ((entry(ray[0]), entry(ray[1])) for ray in (cone.start, cone.end))
    entries = tuple((entry(x), entry(y), entry(w)) for x, y, w in fields)
    return ConeRate(cone.cell.index, (start, end), entries, lyapunov)


def _complement(
    products: tuple[tuple[Any, ...], list[tuple[Any, ...]]], kappa: Any, lightness: Any, zero: Any
) -> tuple[Any, Any, Any, Any]:
    rays, fields = products
    m11, m12, m22 = (product * -kappa for product in rays)
    m13, m23, corner = zero, zero, zero - kappa * lightness
    for aa, ab, bb, a_turn, b_turn, turns in fields:
        m11, m12, m22 = m11 + aa, m12 + ab, m22 + bb
        m13, m23, corner = m13 + a_turn, m23 + b_turn, corner + turns
    return corner * m11 - m13 * m13, corner * m12 - m13 * m23, corner * m22 - m23 * m23, corner


def _in_floats(cones: Sequence[ConeRate], length: Fraction) -> tuple[list[ConeRate], int]:
    """The same forms with floats for numbers, the same ones in every unit of length.

    Rays have entries up to one, and rotation rates are multiples of ``2^unit/l``, about the largest of them.
    """
    unit = max((exponent_of(field[2] * length) for cone in cones for field in cone.fields if field[2]), default=0)
    factor = length * Fraction(2) ** -unit
    floats = []
    for cone in cones:
        sizes = [max(abs(x), abs(y)) for x, y in cone.rays]
        rays: Any = tuple((float(x / size), float(y / size)) for (x, y), size in zip(cone.rays, sizes, strict=True))
        fields: Any = tuple((float(x), float(y), float(w * factor)) for x, y, w in cone.fields)
        floats.append(replace(cone, rays=rays, fields=fields))
    return floats, unit


def exponent_of(value: Any) -> int:
    """About log2 of the size of a nonzero number, also beyond the range of floats.

    Balls of fixed precision do not do: over a field of high degree they may hold zero.
    """
    ball = value.tight_ball() if isinstance(value, Lazy) else plain(value).accurate_ball(_FEW_BITS)
    if isinstance(value, Lazy) and ball.contains(0):  # rounding decides its sign
        numerator, denominator = (plain(part).accurate_ball(_FEW_BITS) for part in value.quotient())
        ball = numerator / denominator
    return round(float(abs(ball).log() / arb(2).log()))


def _lightness(weight: Fraction, unit: int) -> float:
    """``l^2/w`` in the unit of the rotation rates, by ``weight = w/l^2``; too large for a float in enormous units."""
    light = 1 / (weight * Fraction(2) ** (2 * unit))
    return float(light) if light < _FLOAT_RANGE else float("inf")


def _proposal(floats: Sequence[ConeRate], lightness: float) -> float:
    """Largest kappa' of all cones in floats."""
    return min((_largest(cone, lightness) for cone in floats), default=0.0)


def _largest(cone: ConeRate, lightness: float) -> float:
    """Largest kappa' of one cone, by bisection in floats; at most ``2 sum |g_v|^2``, since P is at most 2."""
    low, high = 0.0, 2.0 * sum(float(x) ** 2 for field in cone.fields for x in field[:2])
    products = cone.products
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        s11, s12, s22, corner = _complement(products, middle, lightness, 0.0)
        good = corner > 0 and s11 >= 0 and s22 >= 0 and (s12 >= 0 or s12 * s12 <= s11 * s22)
        low, high = (middle, high) if good else (low, middle)
    return low


def rounded_down(value: float) -> Fraction:
    """A rational of few digits, not above the value."""
    mantissa, exponent = f"{value:.{DIGITS - 1}e}".split("e")
    digits = Fraction(mantissa) - Fraction(1, 10 ** (DIGITS - 1))
    return digits * Fraction(10) ** int(exponent)
