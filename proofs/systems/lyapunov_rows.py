"""What a linear program may propose a V from: functions of a basis, and linear conditions on their coefficients.

Functions are monomials, and monomials times ``|l|`` of lines and ``|q|`` of curves: switching surfaces through the
equilibrium.  Each is continuous and bends at most along its surface, so a sum is continuous however its coefficients
are rounded.

For ``V = sum_k c_k phi_k`` every condition is linear in c: ``V > 0`` and ``grad V . f < 0`` at points of closed cells,
and ``grad V . f_s < 0`` on edges that the fields of both sides oppose, with the sliding field f_s.  V may bend along
such an edge, but only across it, so f_s, which is tangent, does not depend on c.  Points lie on rays at distances that
fall by a constant factor, because near the equilibrium the terms of lowest degree decide.  Floats: nothing here proves,
and rows beyond their range hold no number; programs propose nothing from such rows.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Region, Segment, common_edges
from nonsmooth.analysis.cells.switched_cells import LyapunovCell, sign_on
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf, parse_piecewise
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, float_points
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS, Polynomial, float_values
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

DIVISIONS = 6  # of every side of a cell
SHRINKING = 0.5  # from one distance to the next
DISTANCES = 8
KEPT = 512  # regions, and pairs of them, whose points are kept: families of functions share most cells
RIM, HALVINGS = 24, 30  # parts of each side of an outline on which curves are looked for, and how often they are halved


@dataclass(frozen=True)
class BasisFunction:
    """A monomial in the displacement, times the absolute value of a surface or alone.

    Attributes:
        monomial: with coefficient 1.
        line: a linear form, or the polynomial of a curve; None for the monomial alone.
    """

    monomial: Polynomial
    line: Polynomial | None

    @property
    def degree(self) -> int:
        """The total degree."""
        return self.monomial.degree + (0 if self.line is None else self.line.degree)

    def piece(self, sign_of: SignOf) -> Polynomial:
        """The polynomial that it is where the line has the given sign."""
        if self.line is None:
            return self.monomial
        return self.monomial * self.line * sign_of(self.line)

    def text(self, states: tuple[str, ...]) -> str:
        """The function as a formula of the states."""
        monomial = str(replace(self.monomial, variables=states))
        if self.line is None:
            return monomial
        bent = f"Abs({replace(self.line, variables=states)})"
        return bent if monomial == "1" else f"{monomial}*{bent}"


def bent_functions(field: NumberField, lines: Iterable[Polynomial], degree: int) -> tuple[BasisFunction, ...]:
    """Monomials times ``|l|`` for each line or curve, of a total degree if l is a line."""
    return tuple(BasisFunction(m, line) for line in lines for m in _monomials(field, degree - 1))


def smooth_functions(field: NumberField, degree: int) -> tuple[BasisFunction, ...]:
    """Monomials of a total degree."""
    return tuple(BasisFunction(m, None) for m in _monomials(field, degree))


def _monomials(field: NumberField, degree: int) -> Iterator[Polynomial]:
    for k in range(degree, -1, -1):
        yield Polynomial(field, PLANE, {(k, degree - k): field.one})


def lines_through(system: SwitchedSystem) -> tuple[Polynomial, ...]:
    """The switching surfaces of a planar system that are lines through the checked point."""
    return tuple(s for s in system.surfaces(system.displaced(PLANE)) if s.degree == 1 and s.is_homogeneous)


def curves_through(system: SwitchedSystem) -> tuple[Polynomial, ...]:
    """The switching surfaces of a planar system that are curves through the checked point with a tangent there."""
    curves = (s for s in system.surfaces(system.displaced(PLANE)) if s.degree > 1)
    return tuple(s for s in curves if (0, 0) not in s.terms and ((1, 0) in s.terms or (0, 1) in s.terms))


def build_formula(
    basis: Sequence[BasisFunction], coefficients: Sequence[Fraction], states: tuple[str, ...]
) -> PiecewiseExpression:
    """The sum as a formula of the states, functions of low degree first.

    Raises:
        ExpressionError: for a sum that is too long.
    """
    used = [(c, function) for c, function in zip(coefficients, basis, strict=True) if c]
    used.sort(key=lambda term: term[1].degree)
    text = " + ".join(term_text(c, function.text(states)) for c, function in used) or "0"
    return parse_piecewise(text.replace("+ -", "- "), states)


def term_text(coefficient: Fraction, function: str) -> str:
    """``9*x*y/11`` for a coefficient and a function."""
    top, bottom = coefficient.numerator, coefficient.denominator
    factor = {1: "", -1: "-"}.get(top, f"{top}*")
    return f"{factor}{function}" + (f"/{bottom}" if bottom != 1 else "")


# ---- rows ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sides:
    """A cell with the values and rates of every function of the basis.

    Attributes:
        cell: where the lines of the basis have one sign each.
        values: the functions.
        rates: their derivatives along the field.
        slopes: their derivatives along x and y.
    """

    cell: LyapunovCell
    values: tuple[Polynomial, ...]
    rates: tuple[Polynomial, ...]
    slopes: tuple[tuple[Polynomial, Polynomial], ...]


def build_sides(cells: Iterable[LyapunovCell], basis: Sequence[BasisFunction]) -> list[Sides]:
    """The functions of a basis on each cell and along each of its fields."""
    found: list[Sides] = []
    for cell in cells:
        pieces = tuple(function.piece(lambda line, r=cell.region: sign_on(r, line)) for function in basis)  # type: ignore[misc]
        slopes = tuple((p.derivative("x"), p.derivative("y")) for p in pieces)
        for f, g in cell.velocities:
            found.append(Sides(cell, pieces, tuple(a * f + b * g for a, b in slopes), slopes))
    return found


@BEYOND_FLOATS
def build_rows(sides: Sequence[Sides]) -> Floats:
    """Rows r with the condition ``r . c > 0`` for points all over the cells."""
    blocks: list[Floats] = []
    for side in sides:
        blocks += _cell_rows(side, _samples(side.cell.region, side.cell.potential.field))
    for first, second in combinations(sides, 2):
        field = first.cell.potential.field
        for points, normals in _shared_points(first.cell.region, second.cell.region, field):
            blocks += _slide_rows(first, second, points, normals)
    return normalized(np.vstack(blocks)) if blocks else np.zeros((0, 0))


@BEYOND_FLOATS
def rows_at(sides: Sequence[Sides], points: Sequence[Point]) -> Floats:
    """Rows at given points and at points on the way from them to the equilibrium, for all cells that hold them."""
    blocks: list[Floats] = []
    for point in points:
        if not any(map(sign, point)):
            continue
        near = np.array([[float(v) * SHRINKING**k for v in point] for k in range(DISTANCES)])
        for side in sides:
            if side.cell.region.contains(point):
                blocks += _cell_rows(side, near[where_guards_hold(side.cell.region, near)])
    return normalized(np.vstack(blocks)) if blocks else np.zeros((0, len(sides[0].values)))


def normalized(rows: Floats) -> Floats:
    """Rows scaled to a largest entry of one, without those that are zero; no numbers where one is not finite."""
    sizes = np.abs(rows).max(axis=1, initial=0.0)
    with np.errstate(invalid="ignore"):
        return np.asarray(rows[sizes != 0] / sizes[sizes != 0, None])


@BEYOND_FLOATS
def values_at(polynomial: Polynomial, points: Floats) -> Floats:
    """A polynomial at many points, in floats."""
    return float_values(polynomial.terms, points)


def _cell_rows(side: Sides, points: Floats) -> Iterator[Floats]:
    if len(points):
        yield np.column_stack([values_at(p, points) for p in side.values])
        yield -np.column_stack([values_at(p, points) for p in side.rates])


@lru_cache(maxsize=KEPT)
def _samples(region: Region, field: NumberField) -> Floats:
    """The sample points of a region; its field is named because numbers of two fields are not compared."""
    return sample_points(region)


@lru_cache(maxsize=KEPT)
def _shared_points(first: Region, second: Region, field: NumberField) -> list[tuple[Floats, Floats]]:
    """Points of edges and of curves between two regions, with normals there; the field as for :func:`_samples`."""
    return list(_points_between(first, second))


def _points_between(first: Region, second: Region) -> Iterator[tuple[Floats, Floats]]:
    for edge in common_edges(first, second):
        points = _edge_points(edge)
        points = points[where_guards_hold(first, points) & where_guards_hold(second, points)]
        (ax, ay, aw), (bx, by, bw) = ([float(v) for v in end] for end in edge)
        along = np.array([bx / bw - ax / aw, by / bw - ay / aw]) if aw and bw else np.array([bx, by])
        yield points, np.broadcast_to([-along[1], along[0]], points.shape)
    for curve in first.guards:
        if any(not curve + guard for guard in second.guards):
            points = _curve_points(curve, first)
            held = where_guards_hold(second, points, curve)
            slopes = (curve.derivative(name) for name in curve.variables)
            yield points[held], np.column_stack([values_at(p, points[held]) for p in slopes])


def _slide_rows(first: Sides, second: Sides, points: Floats, normals: Floats) -> list[Floats]:
    """At those points between two cells that both fields oppose, with the sliding field."""
    (f, g) = (np.column_stack([values_at(p, points) for p in s.cell.velocities[0]]) for s in (first, second))
    a, b = (f * normals).sum(axis=1), (g * normals).sum(axis=1)
    opposed = a * b < 0
    if not opposed.any():
        return []
    points, f, g, a, b = points[opposed], f[opposed], g[opposed], a[opposed], b[opposed]
    sliding = (a[:, None] * g - b[:, None] * f) / (a - b)[:, None]
    slopes = [(values_at(p, points), values_at(q, points)) for p, q in first.slopes]
    return [-np.column_stack([p * sliding[:, 0] + q * sliding[:, 1] for p, q in slopes])]


# ---- where to look -------------------------------------------------------------------------------


def _corners(region: Region) -> Floats:
    """The corners of a bounded region in floats, shape (corners, 2)."""
    places = float_points(region.generators)
    return np.asarray(places[:, :2] / places[:, 2:])


def sample_points(region: Region) -> Floats:
    """Points of a closed bounded region, at distances from the equilibrium that fall by a constant factor."""
    corners = _corners(region)
    zero: Any = region.generators[0][2] - region.generators[0][2]
    convex = Region(region.generators)
    if convex.contains((zero, zero)):
        outline = np.vstack([_between(a, b) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
        points = np.vstack([outline * SHRINKING**k for k in range(DISTANCES)])
    else:
        points = np.vstack([_triangle(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)])
    points = np.unique(points, axis=0)
    points = points[np.any(points != 0, axis=1)]
    on_curves = [_curve_points(guard, region) for guard in region.guards]
    return np.vstack([points[where_guards_hold(region, points)], *on_curves])


def _edge_points(edge: Segment) -> Floats:
    ends = [np.array([float(x) / float(w), float(y) / float(w)]) if w else None for x, y, w in edge]
    if ends[0] is None or ends[1] is None:
        return np.zeros((0, 2))
    points = _between(ends[0], ends[1])
    if any(not np.any(end) for end in ends):
        tip = ends[0] if np.any(ends[0]) else ends[1]
        points = np.vstack([points, *(tip * SHRINKING**k for k in range(DISTANCES))])
    return np.asarray(points[np.any(points != 0, axis=1)])


def _curve_points(curve: Polynomial, region: Region) -> Floats:
    """Points of a curve in a region that has the equilibrium as a corner, at distances that fall by a constant factor.

    Where the curve changes its sign between neighbours on a scaled outline, halving finds it.
    """
    corners = _corners(region)
    outline = np.vstack([_between(a, b, RIM) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
    rims = [outline * SHRINKING ** (k / 2) for k in range(2 * DISTANCES)]
    start, end = np.vstack([rim[:-1] for rim in rims]), np.vstack([rim[1:] for rim in rims])
    crossed = values_at(curve, start) * values_at(curve, end) < 0
    start, end = start[crossed], end[crossed]
    side = values_at(curve, start)
    for _ in range(HALVINGS):
        middle = (start + end) / 2
        before = (values_at(curve, middle) * side > 0)[:, None]
        start, end = np.where(before, middle, start), np.where(before, end, middle)
    return np.asarray(start[where_guards_hold(region, start, curve)])


def _between(start: Floats, end: Floats, divisions: int = DIVISIONS) -> Floats:
    shares = np.linspace(0.0, 1.0, divisions + 1)[:, None]
    return np.asarray(start + shares * (end - start))


def _triangle(first: Floats, second: Floats, third: Floats) -> Floats:
    weights = [(i / DIVISIONS, j / DIVISIONS) for i in range(DIVISIONS + 1) for j in range(DIVISIONS + 1 - i)]
    return np.array([first + a * (second - first) + b * (third - first) for a, b in weights])


def where_guards_hold(region: Region, points: Floats, curve: Polynomial | None = None) -> Mask:
    """Where no guard is negative, but that of a curve on which the points lie."""
    kept = np.ones(len(points), dtype=bool)
    for guard in region.guards:
        if curve is None or (guard - curve and guard + curve):
            kept &= values_at(guard, points) >= 0
    return kept
