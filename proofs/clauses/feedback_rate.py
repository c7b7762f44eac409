"""How fast the feedback clause's law decreases V: the largest certified rate on the cones at the equilibrium.

With ``u = -k (a, b)`` and ``V = |c|^2 + theta^2`` one has ``V' = -2 k (a^2 + b^2)``, where a and b are linear in
(c, theta).  So ``V' <= -2 k kappa V`` near the equilibrium iff on every cone ``c = s r_1 + t r_2`` (s, t >= 0, theta
free) ::

    (s, t, theta) M (s, t, theta)^T >= 0,     M = A A^T + B B^T - kappa G

with A, B the coefficients of a, b and G the Gram matrix of V.  Theta is free, so its entry must be positive and the
Schur complement copositive on the quadrant: ``S_11, S_22 >= 0`` and ``S_12 >= -sqrt(S_11 S_22)`` (the S-procedure for a
cone of two rays is exact).  Floats bisect for kappa; a rational below it is verified exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from nonsmooth.analysis.partitions.partition import Partition
from nonsmooth.analysis.partitions.polygon import Point
from nonsmooth.proofs.clauses.fan import CellCone, build_fan
from nonsmooth.symbolic.constraints import Triple
from nonsmooth.symbolic.numbers.lazy import FEW_ROOTS, Lazy
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.scene import dot

DIGITS = 4  # significant digits of the certified rate
_BISECTIONS = 60
_SMALLER = Fraction(9, 10)  # next try where rounding made the proposal too large
_TRIES = 40


@dataclass(frozen=True)
class ConeRate:
    """The quadratic form of one cone.

    Attributes:
        cell: number of the cell.
        rays: ``r_1, r_2``.
        fields: the control vector fields ``g_i, g_j``.
    """

    cell: int
    rays: tuple[Point, Point]
    fields: tuple[Triple, ...]

    def holds(self, kappa: Fraction) -> bool:
        """Whether ``a^2 + b^2 >= kappa (|c|^2 + theta^2)`` on the closed cone, exactly."""
        s11, s12, s22, corner = _schur(self.rays, self.fields, kappa)
        if corner.sign() <= 0 or s11.sign() < 0 or s22.sign() < 0:
            return False
        return s12.sign() >= 0 or sign(s11 * s22 - s12 * s12) >= 0


@dataclass(frozen=True)
class FeedbackRate:
    """Certified ``V' <= -2 k kappa V`` near the equilibrium."""

    kappa: Fraction
    cones: tuple[ConeRate, ...]

    def check(self) -> bool:
        """Re-verify the inequality on every cone."""
        return self.kappa > 0 and bool(self.cones) and all(cone.holds(self.kappa) for cone in self.cones)


def certified_rate(partition: Partition) -> FeedbackRate | None:
    """The largest rate found for a centred partition of rule ``nearest`` with a stabilizing law; None if none is."""
    late = len(partition.scene.field.radicands) > FEW_ROOTS
    cones = tuple(
        _cone_rate(cone, tuple(state.control_fields.values()), late=late)
        for cone in build_fan(partition)
        for state in cone.cell.states
    )
    proposal = min((_largest(cone) for cone in cones), default=0.0)
    if proposal <= 0:
        return None
    kappa = _rounded_down(proposal)
    for _ in range(_TRIES):
        if all(cone.holds(kappa) for cone in cones):
            return FeedbackRate(kappa, cones)
        kappa *= _SMALLER
    return None


def _cone_rate(cone: CellCone, fields: tuple[Triple, ...], *, late: bool) -> ConeRate:
    """The form of one cone; over many square roots its numbers are evaluated late, since products of four occur."""

    def entry(value: Any) -> Any:
        return Lazy.of(value) if late and isinstance(value, Number) else value

    start, end = ((entry(ray[0]), entry(ray[1])) for ray in (cone.start, cone.end))
    return ConeRate(cone.cell.index, (start, end), tuple((entry(x), entry(y), entry(w)) for x, y, w in fields))


def _schur(
    rays: tuple[Point, Point], fields: Sequence[Triple], kappa: Fraction
) -> tuple[Number, Number, Number, Number]:
    """Schur complement with respect to theta (times the corner entry), and the corner entry."""
    (p, q), zero = rays, fields[0][2] * 0
    m11, m12, m22 = (-kappa * dot(*pair) for pair in ((p, p), (p, q), (q, q)))
    m13, m23, corner = zero, zero, zero - kappa
    for x, y, turn in fields:
        along_p, along_q = p[0] * x + p[1] * y, q[0] * x + q[1] * y
        m11, m12, m22 = m11 + along_p * along_p, m12 + along_p * along_q, m22 + along_q * along_q
        m13, m23, corner = m13 + along_p * turn, m23 + along_q * turn, corner + turn * turn
    return corner * m11 - m13 * m13, corner * m12 - m13 * m23, corner * m22 - m23 * m23, corner


def _largest(cone: ConeRate) -> float:
    """Largest kappa of one cone, by bisection in floats (a proposal)."""
    rays = tuple((float(r[0]), float(r[1])) for r in cone.rays)
    fields = [tuple(float(x) for x in field) for field in cone.fields]
    low, high = 0.0, sum(x * x for field in fields for x in field)
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        s11, s12, s22, corner = _schur(rays, fields, middle)  # type: ignore[arg-type]  # the same formula in floats
        good = corner > 0 and s11 >= 0 and s22 >= 0 and (s12 >= 0 or s12 * s12 <= s11 * s22)
        low, high = (middle, high) if good else (low, middle)
    return low


def _rounded_down(value: float) -> Fraction:
    """A rational of few digits, not above the value."""
    mantissa, exponent = f"{value:.{DIGITS - 1}e}".split("e")
    digits = Fraction(mantissa) - Fraction(1, 10 ** (DIGITS - 1))
    return digits * Fraction(10) ** int(exponent)
