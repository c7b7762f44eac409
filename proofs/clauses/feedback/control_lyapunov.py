"""Control Lyapunov functions ``V = c^T P c + w theta^2`` of the feedback clause: which P serve, decided completely.

Under exact kinematics ``c' = v + omega J c``, and with both rows of wheel i and the roll row of wheel j ::

    V'/2 = a u_i + b u_j,   b = (w theta - P c . J(p_i - c))/Delta,   a = P c . d_i - (d_i . d_j) b

Theta is free, so both vanish off the equilibrium iff ``P c . d_i = 0`` at a nonzero c of the cell, with w theta = P c .
J(p_i - c): the criterion asks for one strict sign of ``c^T P d_i`` on every closed cell, for any w > 0 and any
kinematics.  With ``P = [[1 + e, f], [f, 1 - e]]`` (a factor of V changes nothing) it is linear in (e, f) at each
vertex; so the P that serve, for each choice of the cells' signs, fill a convex polygon in the disc ``e^2 + f^2 < 1``
of positive definite P.  Cutting a square cell by cell, once for each sign, finds all of these polygons exactly; where
none is left there is no such V.  In each a conic program (CVXPY) proposes the P whose worst vertex is farthest from
zero, which is rounded and verified exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import Any, SupportsFloat, TypeAlias

from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, clipped_by, square
from nonsmooth.proofs.clauses.feedback.rational_bounds import late
from nonsmooth.proofs.clauses.translation.on_cells import squared_distance
from nonsmooth.proofs.clauses.translation.quadratic import propose_shape, root_above, shaped
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import Vector, around, dot, turned

Shape: TypeAlias = tuple[Fraction, Fraction]

DENOMINATORS = (2**6, 2**12, 2**24)  # of e and f: the first that verifies

LAW = "u_i = -k a, u_j = -k b with b = (theta - c.J p_i)/(d_j.J(p_j - p_i)), a = c.d_i - (d_i.d_j) b"
WEIGHED_LAW = (
    "u_i = -k a, u_j = -k b with b = (l^2 theta - c.J p_i)/(d_j.J(p_j - p_i)), a = c.d_i - (d_i.d_j) b, l = {}"
)
SHAPED_LAW = (
    "u_i = -k a, u_j = -k b with b = (w theta - P c.J(p_i - c))/(d_j.J(p_j - p_i)), a = P c.d_i - (d_i.d_j) b, "
    "P = [[{}, {}], [{}, {}]], w = {}"
)


@dataclass(frozen=True)
class ControlLyapunov:
    """``V = c^T P c + w theta^2`` with ``P = [[1 + e, f], [f, 1 - e]]``.

    Attributes:
        shape: (e, f).
        weight: w.
    """

    shape: Shape = (Fraction(0), Fraction(0))
    weight: Fraction = Fraction(1)

    def __str__(self) -> str:
        e, f = self.shape
        if self.length is not None:
            return "|c|^2 + theta^2" if self.length == 1 else f"|c|^2 + l^2 theta^2 with l = {self.length}"
        mixed = f" {'-' if f < 0 else '+'} ({abs(2 * f)}) x y" if f else ""
        return f"({1 + e}) x^2{mixed} + ({1 - e}) y^2 + ({self.weight}) theta^2"

    @property
    def length(self) -> Fraction | None:
        """The length l with ``V = |c|^2 + l^2 theta^2``; None where there is no such rational."""
        top, bottom = isqrt(max(self.weight.numerator, 0)), isqrt(self.weight.denominator)
        length = Fraction(top, bottom)
        return length if not any(self.shape) and length * length == self.weight else None

    @property
    def law(self) -> str:
        """The law ``u = -k (a, b)`` (Jurdjevic and Quinn) by V, under exact kinematics."""
        if self.length is not None:
            return LAW if self == SQUARES else WEIGHED_LAW.format(self.length)
        (e, f), w = self.shape, self.weight
        return SHAPED_LAW.format(1 + e, f, f, 1 - e, w)

    @property
    def eccentricity(self) -> Fraction:
        """A rational from ``rho = sqrt(e^2 + f^2)`` up to one: ``(1 - rho) |c|^2 <= c^T P c <= (1 + rho) |c|^2``."""
        e, f = self.shape
        return root_above(e * e + f * f) if e or f else Fraction(0)

    @property
    def is_positive(self) -> bool:
        """Whether V is positive definite."""
        e, f = self.shape
        return e * e + f * f < 1 and self.weight > 0

    def slope(self, c: Point) -> Vector:
        """``P c``: half the gradient in c."""
        return shaped(self.shape, c) if any(self.shape) else c

    def coefficients(self, fields: Sequence[Sequence[Any]], c: Point, theta: Any) -> tuple[Any, ...]:
        """Coefficient of each input in ``V'/2 = P c . (v + omega J c) + w theta omega``, from the control fields."""
        slope = self.slope(c)
        turning = theta * self.weight + dot(slope, turned(c))
        return tuple(slope[0] * x + slope[1] * y + turning * turn for x, y, turn in fields)

    def value(self, pose: Sequence[SupportsFloat]) -> float:
        """V at ``(x, y, theta)``, in floats."""
        (e, f), w = (float(entry) for entry in self.shape), float(self.weight)
        x, y, theta = map(float, pose)
        return (1 + e) * x * x + 2 * f * x * y + (1 - e) * y * y + w * theta * theta

    def squared_norm(self, twist: Sequence[Any]) -> Any:
        """``v^T P v + w omega^2``: the square of a twist in the metric of V."""
        v, turn = (twist[0], twist[1]), twist[2]
        return dot(self.slope(v), v) + turn * turn * self.weight

    def stalling_theta(self, c: Point, position: Point) -> Any:
        """The theta at which both coefficients vanish where ``P c . d_i = 0``: ``P c . J(p_i - c)/w``."""
        arm = (position[0] - c[0], position[1] - c[1])
        return dot(self.slope(c), turned(arm)) / self.weight


SQUARES = ControlLyapunov()


def sum_of_squares(length: Fraction) -> ControlLyapunov:
    """``V = |c|^2 + l^2 theta^2``."""
    return ControlLyapunov(weight=length * length)


@dataclass(frozen=True)
class Demand:
    """``c^T P d_i`` is to have one strict sign at the nonzero vertices of a closed cell at the equilibrium.

    Attributes:
        vertices: of the cell, without the equilibrium.
        direction: a positive multiple of ``d_i``.
    """

    vertices: tuple[Point, ...]
    direction: Vector

    def sign(self, lyapunov: ControlLyapunov) -> int:
        """The one strict sign; 0 where there is none."""
        signs = {sign(dot(lyapunov.slope(vertex), self.direction)) for vertex in self.vertices}
        return signs.pop() if signs in ({1}, {-1}) else 0

    def half_planes(self, side: int) -> Iterator[HalfPlane]:
        """The (e, f) with ``side c^T P d_i >= 0`` at each vertex."""
        p, q = self.direction
        for x, y in self.vertices:
            values = (x * p + y * q, x * p - y * q, x * q + y * p)
            constant, along, across = (late(value * side) for value in values)
            yield HalfPlane((-along, -across), constant)


def shape_regions(demands: Sequence[Demand]) -> list[tuple[tuple[int, ...], Polygon]]:
    """All polygons of (e, f) that meet the unit disc and on whose inside every demand has one strict sign.

    The signs of the demands stand beside each.
    """
    zero = demands[0].direction[0].field.zero
    start = square((zero, zero), zero + 1)
    found: list[tuple[tuple[int, ...], Polygon]] = [((), start)]
    for demand in demands:
        before, found = found, []
        for signs, polygon in before:
            for side in (1, -1):
                part = clipped_by(polygon, demand.half_planes(side))
                if part is not None and _meets_disc(part):
                    found.append(((*signs, side), part))
    return found


def find_shapes(demands: Sequence[Demand]) -> Iterator[Shape]:
    """One rational (e, f) for each region, verified exactly; none where rounding leaves a thin region."""
    for signs, _ in shape_regions(demands):
        falling = [
            (vertex, (demand.direction[0] * -side, demand.direction[1] * -side))
            for demand, side in zip(demands, signs, strict=True)
            for vertex in demand.vertices
        ]
        proposal = propose_shape(falling)
        if proposal is None:
            continue
        for denominator in DENOMINATORS:
            e, f = (Fraction(round(x * denominator), denominator) for x in proposal)
            trial = ControlLyapunov((e, f))
            if trial.is_positive and all(demand.sign(trial) for demand in demands):
                yield e, f
                break


def _meets_disc(polygon: Polygon) -> bool:
    """Whether a polygon of positive area has points in the open unit disc."""
    zero = polygon.vertices[0][0] * 0
    return polygon.contains((zero, zero)) or any(
        sign(1 - squared_distance(*side)) > 0 for side in around(polygon.vertices)
    )
