"""The checker of version 1 for certificates of plain systems in one and two states, kept as an independent oracle.

It shares no code with the workbench that wrote the certificate.  A certificate names a switched system
``(x, y)' = f(x, y)`` by its formulas, a point, a Lyapunov function V in the displacement from the point, a square
about the point (or the plane), and a verdict.  The checker reads the formulas itself, cuts the domain along the lines
on which they switch, and proves by rational arithmetic, with F the convex hull of the fields of all closed cells at a
point:

- V is continuous, zero at the point and positive elsewhere;
- ``grad V . f <= -q`` on every closed cell, for every field f of the cell;
- on edges across which V changes its formula, and at their corners: of all velocities in F, V has one derivative only
  along those that have the same product with all its gradients there, and this derivative is at most ``-q``.

A continuous V that is polynomial on finitely many convex cells changes along every solution by such derivatives, at
almost all times (Bacciotti and Ceragioli 1999; Davis, Drusvyatskiy, Kakade and Lee 2020).  With ``q = 0`` and strict
inequalities off the point it is asymptotically stable; with ``<=`` it is stable; with all fields reversed, and strict
inequalities, it is unstable.  With ``<=`` it is asymptotically stable too where no other solution stays on a level of
V (LaSalle's principle, :class:`Invariance`).  With ``q = kappa V`` or ``q = kappa`` the rate is shown, and with
``V >= level`` on the border of the square every start with ``V < level`` in the square stays there and reaches the
point.

With ``sqrt(Abs(x))`` in the formulas V is about signed roots, where solutions cross the axes (:class:`RootedFormula`).
In one state the signs of all fields on either side of the point decide, and no V is needed: see
:class:`ScalarCertificate`.

A polynomial is at least 0 on a simplex of the plane (corners, or directions of unbounded cells) if its coefficients in
the homogeneous coordinates of the simplex are; where some are not, the simplex is cut in two.  Whatever is not shown
within the limits below is rejected: that is no counterexample.
"""

from __future__ import annotations

import ast
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import combinations, pairwise, product
from math import isqrt
from typing import Any, TypeAlias

from tests.oracles import earlier_formulas
from tests.oracles.earlier_formulas import (
    BUDGET,
    MALFORMED,
    MAX_DEGREE,
    NAME,
    RejectedError,
    SignOf,
    add_to,
    rational,
    require,
)

SCHEMA = "nonsmooth-system-certificate/1"  # of two states
SCALAR_SCHEMA = "nonsmooth-scalar-certificate/1"  # of one state
MORE_KEYS = ("curves", "roots")
KEYS = "schema states rhs at radius lyapunov verdict level rate notes"
ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE = "asymptotically stable", "stable", "unstable"

# ---- limits: no certificate keeps the checker busy for ever ------------------------------------

MAX_FIELDS, MAX_PIECES, MAX_LINES, MAX_CELLS = 8, 64, 12, 200
MAX_PARTS = 3_000  # into which a cell or an edge is cut
MAX_HALVINGS = 200  # of an interval of starts
MAX_WORK = 2_000_000  # products of two short numbers, of some microseconds each; see Budget


Exponents: TypeAlias = tuple[int, int]
Line: TypeAlias = tuple[Fraction, Fraction, Fraction]  # a X + b Y + c W
Generator: TypeAlias = tuple[Fraction, Fraction, Fraction]  # (X, Y, W): a corner with W = 1, a direction with W = 0


# ---- polynomials -------------------------------------------------------------------------------


class Polynomial:
    """A polynomial in the displacement ``(x, y)`` with rational coefficients."""

    __slots__ = ("terms",)

    def __init__(self, terms: dict[Exponents, Fraction]) -> None:
        self.terms = {exponents: value for exponents, value in terms.items() if value}
        require(self.degree <= MAX_DEGREE, f"polynomials of degree at most {MAX_DEGREE}")

    @property
    def degree(self) -> int:
        """The largest sum of exponents; 0 for the zero polynomial."""
        return max((i + j for i, j in self.terms), default=0)

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Polynomial) and self.terms == other.terms

    def __hash__(self) -> int:
        BUDGET.spend(len(self.terms) // 4)
        return hash(frozenset(self.terms.items()))

    def __add__(self, other: Polynomial) -> Polynomial:
        BUDGET.spend_on(len(other.terms), (*self.terms.values(), *other.terms.values()))
        total = dict(self.terms)
        for exponents, value in other.terms.items():
            add_to(total, exponents, value)
        return Polynomial(total)

    def __neg__(self) -> Polynomial:
        return Polynomial({exponents: -value for exponents, value in self.terms.items()})

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self + -other

    def __mul__(self, other: Polynomial) -> Polynomial:
        BUDGET.spend_on(len(self.terms) * len(other.terms), (*self.terms.values(), *other.terms.values()))
        total: dict[Exponents, Fraction] = {}
        for (i, j), a in self.terms.items():
            for (k, m), b in other.terms.items():
                add_to(total, (i + k, j + m), a * b)
        return Polynomial(total)

    def derivative(self, which: int) -> Polynomial:
        """By x (0) or y (1)."""
        lowered: dict[Exponents, Fraction] = {}
        for exponents, value in self.terms.items():
            if exponents[which]:
                own = (exponents[0] - (which == 0), exponents[1] - (which == 1))
                lowered[own] = value * exponents[which]
        return Polynomial(lowered)

    def at(self, x: Fraction, y: Fraction) -> Fraction:
        """Its value."""
        BUDGET.spend_on(len(self.terms), (x, y, *self.terms.values()), 1 + self.degree)
        return sum((value * x**i * y**j for (i, j), value in self.terms.items()), Fraction(0))


def constant(value: Fraction | int) -> Polynomial:
    """A polynomial without variables."""
    return Polynomial({(0, 0): Fraction(value)})


Field: TypeAlias = tuple[Polynomial, Polynomial]


# ---- formulas ----------------------------------------------------------------------------------


class Cut(Exception):
    """A line on which a formula switches inside a cell."""

    def __init__(self, line: Line) -> None:
        super().__init__(line)
        self.line = line


class Formula(earlier_formulas.Formula):
    """A formula in one state or two."""

    def constant(self, value: Fraction | int) -> Polynomial:
        """A polynomial in them."""
        return constant(value)


class RootedFormula(Formula):
    """A right-hand side in the signed roots ``w = sgn(x) sqrt(Abs(x))`` of some states, times ``2 Abs(w)`` of others.

    Args:
        text: of the right-hand side.
        states: the polynomial for each name that is no root.
        roots: the polynomial of w by the name of its state.
        scaled: of which states the factors are.
    """

    def __init__(
        self, text: Any, states: dict[str, Polynomial], roots: dict[str, Polynomial], scaled: Sequence[str]
    ) -> None:
        super().__init__(text, states)
        self.roots, self.scaled = roots, scaled

    def on(self, sign_of: SignOf) -> Polynomial:
        """With the factors."""
        value = self.stated(sign_of)
        for name in self.scaled:
            value *= self._square_root_of(name, sign_of) * constant(2)
        return value

    def stated(self, sign_of: SignOf) -> Polynomial:
        """Without them; cells are cut where a root is zero."""
        for root in self.roots.values():
            sign_of(root)
        return super().on(sign_of)

    def _state(self, name: str, sign_of: SignOf) -> Polynomial:
        if name in self.roots:
            return self.roots[name] * self._square_root_of(name, sign_of)
        return super()._state(name, sign_of)

    def _square_root_of(self, name: str, sign_of: SignOf) -> Polynomial:
        return self.roots[name] * constant(sign_of(self.roots[name]))

    def _square_root(self, arguments: Sequence[ast.expr], sign_of: SignOf) -> Polynomial:
        """``sqrt(Abs(x))`` is ``Abs(w)``."""
        require(self.roots and len(arguments) == 1, "rational numbers")
        (inner,) = arguments
        known = isinstance(inner, ast.Call) and isinstance(inner.func, ast.Name) and inner.func.id == "Abs"
        require(known and len(inner.args) == 1 and not inner.keywords, "roots sqrt(Abs(x))")  # type: ignore[attr-defined]
        (state,) = inner.args  # type: ignore[attr-defined]
        require(isinstance(state, ast.Name) and state.id in self.roots, "roots of states that are listed")
        return self._square_root_of(state.id, sign_of)


# ---- geometry ----------------------------------------------------------------------------------


def height(line: Line, place: Generator) -> Fraction:
    """The linear form at homogeneous coordinates."""
    BUDGET.spend_on(1, (*line, *place), 2)
    return line[0] * place[0] + line[1] * place[1] + line[2] * place[2]


def normalized(place: Generator) -> Generator:
    """A corner with W = 1, a direction with largest entry 1."""
    x, y, w = place
    size = w or max(abs(x), abs(y))
    return (x / size, y / size, Fraction(1) if w else Fraction(0))


def midpoint(a: Generator, b: Generator) -> Generator:
    """Between two corners; of a corner and a direction, or two directions, their sum."""
    BUDGET.spend_on(1, (*a, *b))
    return normalized((a[0] + b[0], a[1] + b[1], a[2] + b[2]))


def clipped(polygon: Sequence[Generator], line: Line) -> tuple[Generator, ...] | None:
    """The part of a convex polygon where the form is not negative; None where that has no inside."""
    heights = [height(line, place) for place in polygon]
    if max(heights) <= 0:
        return None
    kept: list[Generator] = []
    for k, place in enumerate(polygon):
        here, before = heights[k], heights[k - 1]
        if here * before < 0:
            last = polygon[k - 1]
            mixed = tuple(abs(here) * u + abs(before) * v for u, v in zip(last, place, strict=True))
            kept.append(normalized(mixed))  # type: ignore[arg-type]
        if here >= 0:
            kept.append(place)
    return tuple(kept)


def factors(value: Polynomial) -> list[Line]:
    """The lines on which a polynomial vanishes, if it is a product of lines as far as this checker factors it.

    A linear polynomial; a monomial times such; a quadratic form or a product of two parallel lines with rational roots.
    """
    for which in (0, 1):
        if value.degree > 1 and all(exponents[which] for exponents in value.terms):
            lowered = {(i - (which == 0), j - (which == 1)): v for (i, j), v in value.terms.items()}
            axis = (Fraction(which == 0), Fraction(which == 1), Fraction(0))
            return [axis, *factors(Polynomial(lowered))]
    if value.degree == 0:
        return []
    if value.degree == 1:
        return [tuple(value.terms.get(e, Fraction(0)) for e in ((1, 0), (0, 1), (0, 0)))]  # type: ignore[list-item]
    require(value.degree == 2, "switching expressions that are products of lines")
    return _quadratic_factors(value)


def _quadratic_factors(value: Polynomial) -> list[Line]:
    """Of ``p u^2 + q u w + r w^2``: a form in (x, y), or a polynomial in one of them."""
    zero, one = Fraction(0), Fraction(1)
    x, y, w = (one, zero, zero), (zero, one, zero), (zero, zero, one)
    shapes = (((2, 0), (1, 1), (0, 2), x, y), ((2, 0), (1, 0), (0, 0), x, w), ((0, 2), (0, 1), (0, 0), y, w))
    for first, mixed, last, u, v in shapes:
        if set(value.terms) <= {first, mixed, last} and first in value.terms:
            p, q, r = (value.terms.get(e, zero) for e in (first, mixed, last))
            discriminant = q * q - 4 * p * r
            if discriminant < 0:
                return []  # of one sign off one point
            root = _square_root(discriminant)
            roots = [(-q + sign * root) / (2 * p) for sign in (1, -1)]
            return [tuple(a - t * b for a, b in zip(u, v, strict=True)) for t in roots]  # type: ignore[misc]
    raise RejectedError("switching expressions that are products of lines")


def _square_root(value: Fraction) -> Fraction:
    top, bottom = isqrt(value.numerator), isqrt(value.denominator)
    require(top * top == value.numerator and bottom * bottom == value.denominator, "switching lines in rationals")
    return Fraction(top, bottom)


def sign_on(polygon: Sequence[Generator], value: Polynomial) -> int:
    """The sign of a switching expression inside a cell.

    Raises:
        Cut: where one of its lines runs through the cell.
    """
    for line in factors(value):
        heights = [height(line, place) for place in polygon]
        if min(heights) < 0 < max(heights):
            raise Cut(line)
    inner = [sum(entries) for entries in zip(*polygon, strict=True)]
    found = value.at(inner[0] / inner[2], inner[1] / inner[2])
    require(found, "switching expressions that do not vanish inside cells")
    return 1 if found > 0 else -1


# ---- proofs of signs ---------------------------------------------------------------------------


def in_simplex(value: Polynomial, degree: int, corners: Sequence[Generator]) -> dict[tuple[int, ...], Fraction]:
    """Coefficients of the polynomial, made homogeneous of a degree by W, in the coordinates of a simplex."""
    powers = [_powers([corner[k] for corner in corners], degree) for k in range(3)]
    total: dict[tuple[int, ...], Fraction] = {}
    for (i, j), own in value.terms.items():
        part = _times(_times(powers[0][i], powers[1][j]), powers[2][degree - i - j])
        BUDGET.spend_on(len(part), (own, *part.values()))
        for exponents, coefficient in part.items():
            add_to(total, exponents, own * coefficient)
    return total


def _powers(form: Sequence[Fraction], degree: int) -> list[dict[tuple[int, ...], Fraction]]:
    count = len(form)
    linear = {tuple(int(k == m) for m in range(count)): form[k] for k in range(count) if form[k]}
    powers = [{(0,) * count: Fraction(1)}]
    for _ in range(degree):
        powers.append(_times(powers[-1], linear))
    return powers


def _times(
    first: dict[tuple[int, ...], Fraction], second: dict[tuple[int, ...], Fraction]
) -> dict[tuple[int, ...], Fraction]:
    BUDGET.spend_on(len(first) * len(second), (*first.values(), *second.values()))
    total: dict[tuple[int, ...], Fraction] = {}
    for a, u in first.items():
        for b, v in second.items():
            key = tuple(map(sum, zip(a, b, strict=True)))
            add_to(total, key, u * v)
    return total


def is_origin(place: Generator) -> bool:
    """Whether a corner is the checked point."""
    return bool(place[2]) and not place[0] and not place[1]


Coefficients: TypeAlias = dict[tuple[int, ...], Fraction]


def shows(value: Polynomial, corners: Sequence[Generator], *, strict: bool) -> bool:
    """Whether the coefficients show ``value >= 0`` on a simplex, or ``> 0`` except at the checked point."""
    return coefficients_show(in_simplex(value, value.degree, corners), corners, strict=strict)


def coefficients_show(found: Coefficients, corners: Sequence[Generator], *, strict: bool) -> bool:
    """The same for given coefficients.

    With no negative coefficient the value is not negative.  A point of the simplex has positive coordinates for some
    set of corners, one of them not a direction; there the value is positive if a positive coefficient belongs to the
    set.
    """
    if min(found.values(), default=Fraction(0)) < 0:
        return False
    if not strict:
        return True
    supports = [{k for k, e in enumerate(exponents) if e} for exponents, own in found.items() if own > 0]
    for size in range(1, len(corners) + 1):
        for chosen in combinations(range(len(corners)), size):
            bounded = any(corners[k][2] for k in chosen)
            exempt = size == 1 and is_origin(corners[chosen[0]])
            if bounded and not exempt and not any(support <= set(chosen) for support in supports):
                return False
    return True


def fails_at_corner(found: Coefficients, degree: int, corners: Sequence[Generator], *, strict: bool) -> bool:
    """Whether the value at a corner refutes the claim: there it is the coefficient of the power of one coordinate."""
    for k, corner in enumerate(corners):
        if corner[2] and not (strict and is_origin(corner)):
            own = found.get(tuple(degree * int(m == k) for m in range(len(corners))), Fraction(0))
            if own < 0 or (strict and own == 0):
                return True
    return False


def edge_of_doubt(found: Coefficients, corners: Sequence[Generator]) -> tuple[int, int] | None:
    """The edge to cut: between the corners to which the most negative coefficient belongs most; None without one."""
    lowest = min(found, key=lambda exponents: found[exponents], default=None)
    if lowest is None or found[lowest] >= 0:
        return None
    first, second = sorted(range(len(corners)), key=lambda k: -lowest[k])[:2]
    return (first, second) if lowest[second] else None


def edge_across(found: Coefficients, corners: Sequence[Generator]) -> tuple[int, int] | None:
    """The edge across from the checked point, where the terms of lowest order there do not show the sign.

    These are the terms with the largest power of the point's coordinate.  They decide near the point, on every ray from
    it, and no part of the triangle that keeps both rays shows more than the triangle does: only narrower cones help.
    None where the point is no corner, and where these terms show the sign.
    """
    at = next((k for k, corner in enumerate(corners) if is_origin(corner)), None)
    if at is None or len(corners) < 3:
        return None
    lowest = max((exponents[at] for exponents, own in found.items() if own), default=0)
    if all(own >= 0 for exponents, own in found.items() if exponents[at] == lowest):
        return None
    first, second = (k for k in range(3) if k != at)
    return first, second


def longest_edge(corners: Sequence[Generator]) -> tuple[int, int]:
    """Where the plane is drawn into a square."""
    BUDGET.spend_on(6, (entry for corner in corners for entry in corner), 4)
    places = [_shown(corner) for corner in corners]

    def length(pair: tuple[int, int]) -> Fraction:
        (a, b), (c, d) = places[pair[0]], places[pair[1]]
        return (a - c) ** 2 + (b - d) ** 2

    return max(combinations(range(len(corners)), 2), key=length)


def parts_of(
    corners: Sequence[Generator], edge: tuple[int, int]
) -> tuple[tuple[Generator, ...], tuple[Generator, ...]]:
    """A simplex cut in two at the middle of an edge."""
    i, j = edge
    middle = midpoint(corners[i], corners[j])
    near, far = list(corners), list(corners)
    near[j], far[i] = middle, middle
    return tuple(near), tuple(far)


def _shown(place: Generator) -> tuple[Fraction, Fraction]:
    """Where a corner or direction lies when the plane is drawn into a square."""
    x, y, w = place
    size = max(abs(x), abs(y), w)
    return (x / size, y / size)


def proved_sign(value: Polynomial, corners: Sequence[Generator], *, strict: bool) -> bool:
    """Whether ``value >= 0``, or ``> 0`` except at the checked point, is shown on a simplex within the limits.

    Where to cut follows from the coefficients (:func:`edge_across`, :func:`edge_of_doubt`), but for every fourth cut
    of other parts, which halves the longest edge.
    """
    waiting = deque([(tuple(corners), 0)])
    for _ in range(MAX_PARTS):
        if not waiting:
            return True
        part, depth = waiting.popleft()
        found = in_simplex(value, value.degree, part)
        if coefficients_show(found, part, strict=strict):
            continue
        if fails_at_corner(found, value.degree, part, strict=strict):
            return False
        edge = edge_across(found, part) or (edge_of_doubt(found, part) if depth % 4 < 3 else None)
        waiting.extend((half, depth + 1) for half in parts_of(part, edge or longest_edge(part)))
    return not waiting


# ---- cells -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Cell:
    """A convex cell with its fields and V, all polynomials.

    Attributes:
        polygon: corners and directions, counterclockwise.
        fields: one or more.
        potential: V.
    """

    polygon: tuple[Generator, ...]
    fields: tuple[Field, ...]
    potential: Polynomial

    def rate(self, field: Field) -> Polynomial:
        """``grad V . f``."""
        return self.potential.derivative(0) * field[0] + self.potential.derivative(1) * field[1]

    @property
    def triangles(self) -> Iterator[tuple[Generator, ...]]:
        """The cell as simplices; from the checked point where it is a corner, so that edges there are shared."""
        first = next((k for k, place in enumerate(self.polygon) if is_origin(place)), 0)
        turned = self.polygon[first:] + self.polygon[:first]
        for k in range(1, len(turned) - 1):
            yield (turned[0], turned[k], turned[k + 1])


@dataclass(frozen=True)
class Edge:
    """A side that two cells share."""

    first: Cell
    second: Cell
    ends: tuple[Generator, Generator]


def quadrants(radius: Fraction | None) -> list[tuple[Generator, ...]]:
    """The square, or the plane, cut along both axes through the point."""
    zero, one = Fraction(0), Fraction(1)
    size, weight = (one, zero) if radius is None else (radius, one)
    cells = []
    for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        x, y = (a * size, zero, weight), (zero, b * size, weight)
        ends = (x, y) if a * b > 0 else (y, x)
        corner = () if radius is None else ((a * size, b * size, weight),)
        cells.append(((zero, zero, one), ends[0], *corner, ends[1]))
    return cells


class Piecewise:
    """V by one formula, or by one formula on each of some cones at the point."""

    def __init__(self, data: Any, states: dict[str, Polynomial]) -> None:
        if type(data) is str:
            self.pieces: list[tuple[Generator, Generator, Formula]] | None = None
            self.formula = Formula(data, states)
            return
        require(type(data) is list and 0 < len(data) <= MAX_PIECES, "V as a formula or as pieces on cones")
        self.pieces = []
        for entry in data:
            require(type(entry) is dict and sorted(entry) == ["V", "from", "to"], "pieces with from, to and V")
            start, end = (_direction(entry[key]) for key in ("from", "to"))
            self.pieces.append((start, end, Formula(entry["V"], states)))

    def on(self, polygon: Sequence[Generator], sign_of: SignOf) -> Polynomial:
        """V on a cell; all cones that hold the cell must agree."""
        if self.pieces is None:
            return self.formula.on(sign_of)
        found = {formula.on(sign_of) for start, end, formula in self.pieces if _holds(start, end, polygon)}
        require(len(found) == 1, "one piece of V on every cell")
        return found.pop()


def _direction(data: Any) -> Generator:
    require(type(data) is list and len(data) == 2, "directions of two numbers")
    x, y = map(rational, data)
    require(x or y, "directions that are not zero")
    return (x, y, Fraction(0))


def _holds(start: Generator, end: Generator, polygon: Sequence[Generator]) -> bool:
    """Whether a cone of at most a half turn holds a cell; a cell that it cuts is cut."""
    sides = [(-start[1], start[0], Fraction(0)), (end[1], -end[0], Fraction(0))]  # not negative inside
    heights = [[height(side, place) for place in polygon] for side in sides]
    opposite = start[0] * end[1] == start[1] * end[0]
    turns = start[0] * end[1] - start[1] * end[0]
    require(turns > 0 or (opposite and start[0] * end[0] + start[1] * end[1] < 0), "cones of at most a half turn")
    if any(max(own) <= 0 for own in heights):
        return False
    for side, own in zip(sides, heights, strict=True):
        if min(own) < 0:
            raise Cut(side)
    return True


def build_cells(fields: Sequence[tuple[Formula, Formula]], potential: Piecewise, radius: Fraction | None) -> list[Cell]:
    """The domain cut along every line on which a formula switches, with the polynomials of each cell.

    Every line cuts all cells that it meets, so that neighbours share whole sides.
    """
    polygons, lines = quadrants(radius), 0
    while True:
        try:
            return [_cell(polygon, fields, potential) for polygon in polygons]
        except Cut as cut:
            lines += 1
            require(lines <= MAX_LINES, f"formulas with at most {MAX_LINES} switching lines")
            opposite = tuple(-v for v in cut.line)
            halves = [(clipped(polygon, line)) for polygon in polygons for line in (cut.line, opposite)]  # type: ignore[arg-type]
            polygons = [half for half in halves if half is not None]
            require(len(polygons) <= MAX_CELLS, f"at most {MAX_CELLS} cells")


def _cell(polygon: tuple[Generator, ...], fields: Sequence[tuple[Formula, Formula]], potential: Piecewise) -> Cell:
    def sign_of(value: Polynomial) -> int:
        return sign_on(polygon, value)

    own = tuple((first.on(sign_of), second.on(sign_of)) for first, second in fields)
    return Cell(polygon, own, potential.on(polygon, sign_of))


def sides_of(cell: Cell) -> Iterator[tuple[Generator, Generator]]:
    """The sides of a cell; that between two directions lies at infinity."""
    for k, place in enumerate(cell.polygon):
        yield (cell.polygon[k - 1], place)


def on_border(ends: Sequence[Generator], radius: Fraction | None) -> bool:
    """Whether a side lies on the border of the domain."""
    if radius is None:
        return not any(place[2] for place in ends)
    return any(ends[0][k] == ends[1][k] and abs(ends[0][k]) == radius for k in (0, 1))


def edges_of(cells: Sequence[Cell], radius: Fraction | None) -> list[Edge]:
    """Sides that two cells share, where their formulas of V differ.

    Raises:
        RejectedError: for a side that is neither shared nor on the border: the cells would leave a gap.
    """
    sides: dict[frozenset[Generator], list[Cell]] = {}
    for cell in cells:
        for ends in sides_of(cell):
            sides.setdefault(frozenset(ends), []).append(cell)
    found = []
    for pair, own in sides.items():
        first, second = pair
        require(len(own) == (1 if on_border((first, second), radius) else 2), "cells that share their sides")
        if len(own) == 2 and own[0].potential != own[1].potential:
            found.append(Edge(own[0], own[1], (first, second)))
    return found


# ---- claims ------------------------------------------------------------------------------------


class Conditions:
    """The conditions on V, for a shift q."""

    def __init__(self, cells: Sequence[Cell], radius: Fraction | None) -> None:
        self.cells, self.edges = cells, edges_of(cells, radius)

    def show_continuous(self) -> None:
        """Neighbouring formulas of V agree along the side that their cells share, and V is zero at the point."""
        for edge in self.edges:
            gap = edge.first.potential - edge.second.potential
            values = in_simplex(gap, gap.degree, edge.ends)
            require(not any(values.values()), "a V that is continuous")
        require(all((0, 0) not in cell.potential.terms for cell in self.cells), "a V that is zero at the point")

    def show_positive(self) -> None:
        """V is positive on every closed cell, except at the point."""
        for cell in self.cells:
            for triangle in cell.triangles:
                require(proved_sign(cell.potential, triangle, strict=True), "V > 0 except at the point")

    def show_falls(self, shift: Callable[[Cell], Polynomial], *, strict: bool) -> None:
        """V falls at least by the shift: on closed cells, along edges, at corners."""
        for cell in self.cells:
            for field in cell.fields:
                rise = -(cell.rate(field) + shift(cell))
                for triangle in cell.triangles:
                    require(proved_sign(rise, triangle, strict=strict), "V' below its bound on every cell")
        for edge in self.edges:
            for fields in product(edge.first.fields, edge.second.fields):
                require(self._falls_along(edge, fields, shift, strict), "V' below its bound along every edge")
        for corner in self._corners():
            require(self._falls_at(corner, shift, strict), "V' below its bound at every corner")

    def _falls_along(
        self, edge: Edge, fields: tuple[Field, Field], shift: Callable[[Cell], Polynomial], strict: bool
    ) -> bool:
        """The mixture of two fields that is tangent to the edge: ``(b f - a g)/(b - a)``, where ``a b < 0``.

        a and b are the parts of f and g along the normal into the first cell.  Along the edge V has one derivative,
        which both gradients give.
        """
        (x0, y0, w0), (x1, y1, w1) = edge.ends
        normal = (y0 * w1 - w0 * y1, w0 * x1 - x0 * w1)
        inner = [sum(entries) for entries in zip(*edge.first.polygon, strict=True)]
        offset = x0 * y1 - y0 * x1
        if normal[0] * inner[0] + normal[1] * inner[1] + offset * inner[2] < 0:
            normal = (-normal[0], -normal[1])
        f, g = fields
        a, b = (constant(normal[0]) * own[0] + constant(normal[1]) * own[1] for own in (f, g))
        along_f, along_g = (edge.first.rate(own) + shift(edge.first) for own in (f, g))
        mixed = along_f * b - along_g * a  # times b - a the derivative along the tangent mixture

        waiting = deque([edge.ends])
        for _ in range(MAX_PARTS):
            if not waiting:
                return True
            part = waiting.popleft()
            if _settles(part, a, b, mixed, strict=strict):
                continue
            if any(place[2] and _refutes(place, a, b, mixed, strict=strict) for place in part):
                return False
            waiting.extend(parts_of(part, (0, 1)))  # type: ignore[arg-type]
        return not waiting

    def _corners(self) -> set[Generator]:
        ends = {place for edge in self.edges for place in edge.ends}
        return {place for place in ends if place[2] and not is_origin(place)}

    def _falls_at(self, corner: Generator, shift: Callable[[Cell], Polynomial], strict: bool) -> bool:
        """All velocities in the hull there that have one product with all gradients of V there."""
        x, y, _ = corner
        around = [cell for cell in self.cells if corner in cell.polygon]
        gradients = [tuple(cell.potential.derivative(k).at(x, y) for k in (0, 1)) for cell in around]
        velocities = [tuple(own.at(x, y) for own in field) for cell in around for field in cell.fields]
        bound = -shift(around[0]).at(x, y)
        first, *others = gradients
        bends = [(g[0] - first[0], g[1] - first[1]) for g in others if g != first]

        def low(v: tuple[Fraction, ...]) -> bool:
            value = first[0] * v[0] + first[1] * v[1]
            return value < bound or (not strict and value == bound)

        if not bends:
            return all(map(low, velocities))
        m = bends[0]
        if any(m[0] * n[1] != m[1] * n[0] for n in bends):
            return (not strict and bound >= 0) or not _hull_holds_zero(velocities)
        return all(map(low, _tangent_mixtures(velocities, m)))


def _settles(part: Sequence[Generator], a: Polynomial, b: Polynomial, mixed: Polynomial, *, strict: bool) -> bool:
    """Whether V falls along the tangent mixture on a part of an edge: where ``a < 0 < b`` by mixed, else by -mixed."""
    rises = {v: shows(v, part, strict=False) for v in (a, -a, b, -b)}
    if (rises[a] and rises[b]) or (rises[-a] and rises[-b]):
        return True  # no tangent mixture but of fields that are tangent themselves
    if (rises[-a] or rises[b]) and shows(-mixed, part, strict=strict):
        return True
    return (rises[a] or rises[-b]) and shows(mixed, part, strict=strict)


def _refutes(place: Generator, a: Polynomial, b: Polynomial, mixed: Polynomial, *, strict: bool) -> bool:
    """Whether V does not fall along the tangent mixture at a corner of a part of an edge."""
    x, y, _ = place
    into, out = a.at(x, y), b.at(x, y)
    if into * out >= 0 or (strict and is_origin(place)):
        return False
    value = mixed.at(x, y) if out > into else -mixed.at(x, y)
    return value > 0 or (strict and value == 0)


def _tangent_mixtures(velocities: Sequence[tuple[Fraction, ...]], m: tuple[Fraction, Fraction]) -> Iterator[Any]:
    """The ends of the part of the hull with ``m . v = 0``, each as a mixture of one or two velocities."""
    BUDGET.spend_on(len(velocities) ** 2, (entry for v in (m, *velocities) for entry in v), 4)
    parts = [m[0] * v[0] + m[1] * v[1] for v in velocities]
    yield from (v for v, part in zip(velocities, parts, strict=True) if not part)
    for (u, p), (v, q) in combinations(zip(velocities, parts, strict=True), 2):
        if p * q < 0:
            yield tuple((q * a - p * b) / (q - p) for a, b in zip(u, v, strict=True))


def _hull_holds_zero(velocities: Sequence[tuple[Fraction, ...]]) -> bool:
    """Whether 0 is in the convex hull: no line through 0 has all of them strictly on one side."""
    if any(not any(v) for v in velocities):
        return True
    BUDGET.spend_on(2 * len(velocities) ** 2, (entry for v in velocities for entry in v), 2)
    # A separating direction exists iff the normal of one velocity, turned a little, separates: test both sides of each.
    for v in velocities:
        for sign in (1, -1):
            normal = (-sign * v[1], sign * v[0])
            heights = [normal[0] * u[0] + normal[1] * u[1] for u in velocities]
            along = [v[0] * u[0] + v[1] * u[1] for u, h in zip(velocities, heights, strict=True) if not h]
            if min(heights) >= 0 and all(value > 0 for value in along):
                return False
    return True


# ---- what stays where V' = 0 -------------------------------------------------------------------


def divided(value: Polynomial, divisor: Polynomial) -> Polynomial | None:
    """The quotient; None where a remainder is left."""
    lead = max(divisor.terms)
    quotient, rest = constant(0), value
    while rest:
        top = max(rest.terms)
        step = (top[0] - lead[0], top[1] - lead[1])
        if min(step) < 0:
            return None
        part = Polynomial({step: rest.terms[top] / divisor.terms[lead]})
        quotient, rest = quotient + part, rest - part * divisor
    return quotient


def curves_of(value: Polynomial, hints: Sequence[Polynomial]) -> list[Polynomial]:
    """Polynomials that are zero, together, where a nonzero one is: the hints that divide it, and what is left."""
    found = []
    for hint in hints:
        while hint.degree and value.degree and (quotient := divided(value, hint)) is not None:
            value = quotient
            found.append(hint)
    return [*dict.fromkeys(found), value]


def meet_in_points(a: Polynomial, b: Polynomial) -> bool:
    """Whether two polynomials have finitely many common zeros, as far as this is seen at a few places.

    Infinitely many would lie on a common factor.  Where that held x (or y), the resultant in x (in y) would be zero
    for all values of the other variable.
    """
    places = [Fraction(k, 7) for k in range(1, 8)]
    return bool(a and b) and all(any(resultant(a, b, which, t) for t in places) for which in (0, 1))


def resultant(a: Polynomial, b: Polynomial, which: int, place: Fraction) -> Fraction:
    """The determinant of Sylvester's matrix in one variable, at a value of the other one; 1 without that variable."""
    rows = [_coefficients(own, which, place) for own in (a, b)]
    m, n = (len(row) - 1 for row in rows)
    if not m or not n:
        return Fraction(1)
    shifts = ((rows[0], n), (rows[1], m))
    zero = Fraction(0)
    return _determinant([[zero] * k + row + [zero] * (count - 1 - k) for row, count in shifts for k in range(count)])


def _coefficients(value: Polynomial, which: int, place: Fraction) -> list[Fraction]:
    """By powers of one variable, descending from its degree, at a value of the other one."""
    BUDGET.spend_on(len(value.terms), value.terms.values())
    top = max(e[which] for e in value.terms)
    found = [Fraction(0)] * (top + 1)
    for exponents, own in value.terms.items():
        found[top - exponents[which]] += own * place ** exponents[1 - which]
    return found


def _determinant(matrix: list[list[Fraction]]) -> Fraction:
    total = Fraction(1)
    for k in range(len(matrix)):
        pivot = next((i for i in range(k, len(matrix)) if matrix[i][k]), None)
        if pivot is None:
            return Fraction(0)
        if pivot != k:
            matrix[k], matrix[pivot], total = matrix[pivot], matrix[k], -total
        total *= matrix[k][k]
        for i in range(k + 1, len(matrix)):
            BUDGET.spend_on(len(matrix) - k, (*matrix[i], *matrix[k]), 2)
            factor = matrix[i][k] / matrix[k][k]
            matrix[i] = [u - factor * v for u, v in zip(matrix[i], matrix[k], strict=True)]
    return total


class Invariance:
    """That no solution but the point stays on one level of a V that does not rise (LaSalle's principle).

    A bounded solution of a Filippov inclusion tends to a weakly invariant set on one level of V (Ryan 1998; Bacciotti
    and Ceragioli 1999).  A solution in it has V' = 0 at almost all times, so it is then in the closed cells where V'
    vanishes altogether, on sides where V bends or beside those, or on a zero set of V' in another cell.  Of the last
    two each level holds finitely many points, as is shown first; a solution that is in finitely many points at almost
    all times rests.  No other point rests, so it is in those cells for ever; there it turns, without end, and would
    meet a direction in which none of them lies.
    """

    def __init__(self, cells: Sequence[Cell], radius: Fraction | None, hints: Sequence[Polynomial]) -> None:
        require(all(len(cell.fields) == 1 for cell in cells), "one right-hand side, where solutions may stay")
        self.cells, self.radius, self.hints = cells, radius, hints
        self.still = [cell for cell in cells if not cell.rate(cell.fields[0])]
        self.sides: dict[frozenset[Generator], list[Cell]] = {}
        for cell in cells:
            for ends in sides_of(cell):
                self.sides.setdefault(frozenset(ends), []).append(cell)

    def show(self) -> None:
        """Every step."""
        for cell in self.cells:
            if cell not in self.still:
                self._show_points(cell)
        for ends, beside in self.sides.items():
            self._show_changes(tuple(ends), beside)
        self._show_turning()
        self._show_no_rest()

    def _show_points(self, cell: Cell) -> None:
        """A level of V holds finitely many zeros of V' in the cell.

        If it held infinitely many, then an arc, on which a polynomial q of ``V' = q_1 ... q_k`` vanishes; both
        gradients are normal to it, so ``V_x q_y - V_y q_x`` vanishes on it too.
        """
        potential = cell.potential
        for q in curves_of(cell.rate(cell.fields[0]), self.hints):
            across = potential.derivative(0) * q.derivative(1) - potential.derivative(1) * q.derivative(0)
            if not q.degree or meet_in_points(q, across):
                continue
            definite = any(all(proved_sign(v, t, strict=True) for t in cell.triangles) for v in (q, -q))
            require(definite, "finitely many points of a level of V with V' = 0")

    def _show_changes(self, ends: tuple[Generator, ...], beside: Sequence[Cell]) -> None:
        """V is constant on no part of a side where it bends, or beside a cell where V' vanishes altogether."""
        bends = len(beside) == 2 and beside[0].potential != beside[1].potential
        still = any(cell in self.still for cell in beside)
        if not any(place[2] for place in ends) or not (bends or still):
            return
        degree = beside[0].potential.degree
        found = in_simplex(beside[0].potential, degree, ends)
        level = in_simplex(constant(1), degree, ends)
        first = next(iter(level))
        share = found.get(first, Fraction(0)) / level[first]
        same = all(found.get(e, Fraction(0)) == share * level.get(e, Fraction(0)) for e in {*found, *level})
        require(not same, "a V that changes along sides")

    def _show_turning(self) -> None:
        """In the cells where V' vanishes altogether all solutions turn about the point in one sense, not for ever."""
        if not self.still:
            return
        turns = any(all(_turns(cell, sense) for cell in self.still) for sense in (1, -1))
        require(turns, "solutions that turn where V' vanishes altogether")
        sums = [[sum(entries, Fraction(0)) for entries in zip(*cell.polygon, strict=True)] for cell in self.cells]
        middles = [(x, y) for x, y, _ in sums]
        free = any(not any(_points_into(cell, ray) for cell in self.still) for ray in middles)
        require(free, "a direction in which V' does not vanish altogether")

    def _show_no_rest(self) -> None:
        """0 is in F at no other point: no field vanishes in its closed cell, no mixture on a side or at a corner."""
        for cell in self.cells:
            require(all(_none_vanishes(t, cell.fields[0]) for t in cell.triangles), "no other point at rest in a cell")
        for ends, beside in self.sides.items():
            if len(beside) == 2 and beside[0].fields != beside[1].fields:
                require(_none_rests(tuple(ends), beside[0].fields[0], beside[1].fields[0]), "no rest on a side")
        corners = {place for ends in self.sides for place in ends if place[2] and not is_origin(place)}
        for corner in corners:
            around = [cell for cell in self.cells if corner in cell.polygon]
            velocities = [tuple(own.at(corner[0], corner[1]) for own in cell.fields[0]) for cell in around]
            require(not _hull_holds_zero(velocities), "no rest at a corner")


def _turns(cell: Cell, sense: int) -> bool:
    """Whether the field of a closed cell turns about the point in one sense: the sign of ``z x f``."""
    x, y = Polynomial({(1, 0): Fraction(sense)}), Polynomial({(0, 1): Fraction(sense)})
    f, g = cell.fields[0]
    return all(proved_sign(x * g - y * f, triangle, strict=True) for triangle in cell.triangles)


def _none_vanishes(corners: tuple[Generator, ...], field: Field) -> bool:
    """Whether a field is zero nowhere on a simplex, but perhaps at the point: on each part an entry has one sign."""
    f, g = field
    return _one_is_positive((f, -f, g, -g), corners)


def _none_rests(ends: tuple[Generator, ...], f: Field, g: Field) -> bool:
    """Whether no mixture of two fields is zero on a side, but perhaps at the point: they are not opposite.

    On each of its parts their product is positive, or one of them is always on the same side of the other.
    """
    across = f[0] * g[1] - f[1] * g[0]
    return _one_is_positive((f[0] * g[0] + f[1] * g[1], across, -across), ends)


def _one_is_positive(values: Sequence[Polynomial], corners: tuple[Generator, ...]) -> bool:
    """Whether one of some polynomials is shown to be positive on each part of a simplex, but perhaps at the point."""
    waiting = deque([(corners, 0)])
    for _ in range(MAX_PARTS):
        if not waiting:
            return True
        part, depth = waiting.popleft()
        if any(shows(value, part, strict=True) for value in values):
            continue
        bounded = (place for place in part if place[2] and not is_origin(place))
        if any(max(value.at(x, y) for value in values) <= 0 for x, y, _ in bounded):
            return False
        others = [k for k, place in enumerate(part) if not is_origin(place)]
        narrower = len(others) == 2 < len(part) and depth % 2 == 0  # the cone that it spans from the point
        edge = (others[0], others[1]) if narrower else longest_edge(part)
        waiting.extend((half, depth + 1) for half in parts_of(part, edge))
    return not waiting


def _points_into(cell: Cell, ray: tuple[Fraction, Fraction]) -> bool:
    """Whether a ray from the point meets a closed cell elsewhere: it is a mixture of two of its corners."""
    places = [(x, y) for x, y, _ in cell.polygon if x or y]
    for u, v in product(places, repeat=2):
        turn = u[0] * v[1] - u[1] * v[0]
        first, second = ray[0] * v[1] - ray[1] * v[0], u[0] * ray[1] - u[1] * ray[0]
        if (turn > 0 and first >= 0 and second >= 0) or (u == v and not second and u[0] * ray[0] + u[1] * ray[1] > 0):
            return True
    return False


# ---- the certificate ---------------------------------------------------------------------------


class Certificate:
    """One certificate: reading it builds the cells; :meth:`check` shows the claims."""

    def __init__(self, data: Any) -> None:
        require(type(data) is dict, f"an object with the keys {KEYS}")
        own = {key: value for key, value in data.items() if key not in MORE_KEYS}
        require(sorted(own) == sorted(KEYS.split()), f"an object with the keys {KEYS}, perhaps curves or roots")
        require(data["schema"] == SCHEMA, f"the schema {SCHEMA}")
        BUDGET.left = MAX_WORK
        self.states = data["states"]
        require(type(self.states) is list and len(self.states) == 2, "two states")
        require(all(type(name) is str and NAME.fullmatch(name) for name in self.states), "states with names")
        require(self.states[0] != self.states[1], "two states with different names")
        self.at = [rational(text) for text in data["at"]]
        require(len(self.at) == 2, "a point of two numbers")
        self.radius = None if data["radius"] is None else rational(data["radius"])
        require(self.radius is None or self.radius > 0, "a square of positive size, or null for the plane")
        self.verdict, self.level, self.rate = data["verdict"], data["level"], data["rate"]
        require(self.verdict in (ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE), "a verdict")
        self.rooted = self._read_roots(data["roots"]) if "roots" in data else ()
        self.cells = self._build(data["rhs"], data["lyapunov"])
        self.curves = self._read_curves(data["curves"]) if "curves" in data else None

    def _read_roots(self, data: Any) -> tuple[str, ...]:
        """The states whose signed roots V is about; rates in the time of the roots are none of the states."""
        require(type(data) is list and data and all(name in self.states for name in data), "roots of states")
        require(len(set(data)) == len(data) and self.rate is None, "different roots, and no rate")
        return tuple(data)

    def _build(self, rhs: Any, lyapunov: Any) -> list[Cell]:
        axes = (Polynomial({(1, 0): Fraction(1)}), Polynomial({(0, 1): Fraction(1)}))
        moved, self.roots, seen = {}, dict[str, Polynomial](), {}
        for name, axis, at in zip(self.states, axes, self.at, strict=True):
            if name in self.rooted:
                root = _square_root(abs(at))
                self.roots[name] = axis + constant(root if at > 0 else -root)
            else:
                moved[name] = axis + constant(at)
            seen[f"root_{name}" if name in self.rooted else name] = axis
        require(len(seen) == 2, "two names in V")
        require(type(rhs) is list and 0 < len(rhs) <= MAX_FIELDS, f"one to {MAX_FIELDS} right-hand sides")
        require(all(type(side) is list and len(side) == 2 for side in rhs), "two formulas in each right-hand side")
        self.fields = [self._read_field(side, moved) for side in rhs]
        return build_cells(self.fields, Piecewise(lyapunov, seen), self.radius)

    def _read_field(self, side: Sequence[Any], moved: dict[str, Polynomial]) -> tuple[RootedFormula, RootedFormula]:
        """``f_k`` times ``2 Abs(w_j)`` of the rooted j other than k: the field of the roots, times all of these."""
        factors = [[name for name in self.rooted if name != state] for state in self.states]
        first, second = (RootedFormula(text, moved, self.roots, own) for text, own in zip(side, factors, strict=True))
        return first, second

    def _show_crossed(self) -> None:
        """Where a root is zero, but at the point, all velocities cross in one sense.

        There every solution has a speed x' of one sign, bounded away from 0: it is there at single instants.  Between
        them the root w has the velocity ``x'/(2 Abs(w))``, so (w, y) moves along the scaled field, faster by a positive
        factor.  V is continuous and falls in between; hence it falls, and solutions tend to invariant sets on one level
        of V: to the point.
        """
        for k, name in enumerate(self.states):
            if name in self.rooted:
                own = self.roots[name].terms
                line = tuple(own.get(e, Fraction(0)) for e in ((1, 0), (0, 1), (0, 0)))
                self._show_crossed_line(line, k)  # type: ignore[arg-type]

    def _show_crossed_line(self, line: Line, k: int) -> None:
        sides: dict[frozenset[Generator], list[Polynomial]] = {}
        corners: dict[Generator, list[Fraction]] = {}
        for cell in self.cells:
            speeds = [field[k].stated(partial(sign_on, cell.polygon)) for field in self.fields]
            for ends in sides_of(cell):
                if any(place[2] for place in ends) and not any(height(line, place) for place in ends):
                    sides.setdefault(frozenset(ends), []).extend(speeds)
            for place in cell.polygon:
                if place[2] and not is_origin(place) and not height(line, place):
                    corners.setdefault(place, []).extend(speed.at(place[0], place[1]) for speed in speeds)
        for side, own in sides.items():
            ends = tuple(side)  # type: ignore[assignment]
            crossed = any(all(proved_sign(p * constant(s), ends, strict=True) for p in own) for s in (1, -1))
            require(crossed, "velocities that cross where a root is zero")
        for values in corners.values():
            require(min(values) > 0 or max(values) < 0, "velocities that cross where a root is zero")

    def _read_curves(self, data: Any) -> list[Polynomial]:
        """Factors of V' that may be curves on which it vanishes: hints, which prove nothing."""
        require(self.verdict == ASYMPTOTICALLY_STABLE and not self.rooted, "curves of a point that attracts, no roots")
        require(type(data) is list and len(data) <= MAX_PIECES, "a list of curves")
        axes = {name: Polynomial({(1 - k, k): Fraction(1)}) for k, name in enumerate(self.states)}
        return [Formula(text, axes).on(refused_sign) for text in data]

    def check(self) -> None:
        """Show every claim."""
        cells = self.cells
        if self.verdict == UNSTABLE:
            cells = [Cell(c.polygon, tuple((-f, -g) for f, g in c.fields), c.potential) for c in cells]
        conditions = Conditions(cells, self.radius)
        self._show_crossed()
        conditions.show_continuous()
        conditions.show_positive()
        conditions.show_falls(lambda cell: constant(0), strict=self.verdict != STABLE and self.curves is None)
        if self.curves is not None:
            Invariance(cells, self.radius, [curve for curve in self.curves if curve]).show()
        if self.level is not None:
            self._show_region(rational(self.level))
        if self.rate is not None:
            self._show_rate(conditions)

    def _show_region(self, level: Fraction) -> None:
        """V is at least the level on the border of the square: no solution leaves ``V < level``."""
        require(self.verdict == ASYMPTOTICALLY_STABLE and self.radius is not None, "a region in a square that attracts")
        require(level > 0, "a positive level")
        for cell in self.cells:
            above = cell.potential - constant(level)
            for ends in sides_of(cell):
                shown = not on_border(ends, self.radius) or proved_sign(above, ends, strict=False)
                require(shown, "V >= level on the border of the square")

    def _show_rate(self, conditions: Conditions) -> None:
        """``V' <= -kappa V`` or ``V' <= -kappa``."""
        require(type(self.rate) is dict and sorted(self.rate) == ["kappa", "kind"], "a rate with kind and kappa")
        require(self.verdict == ASYMPTOTICALLY_STABLE, "a rate of a point that attracts")
        kappa, kind = rational(self.rate["kappa"]), self.rate["kind"]
        require(kappa > 0 and kind in ("finite", "exponential"), "a positive rate, finite or exponential")
        whole = constant(kappa)
        conditions.show_falls(
            (lambda cell: whole) if kind == "finite" else (lambda cell: whole * cell.potential), strict=False
        )


def refused_sign(value: Polynomial) -> int:
    """Curves are polynomials: no formula of one may ask for a sign."""
    raise RejectedError("curves without switching")


# ---- one state ---------------------------------------------------------------------------------

SCALAR_KEYS = "schema states rhs at verdict starts notes"
MAX_ANSWERS = 64  # pieces of a formula where signs are not known

Dense: TypeAlias = list[Fraction]  # coefficients of a polynomial in one variable, ascending
Sure: TypeAlias = Callable[[Polynomial], int]  # the sign of a polynomial on a part of the line; 0 where it is not known


class UnknownSignError(Exception):
    """A sign that a formula needs and nobody knows."""

    def __init__(self, value: Polynomial) -> None:
        super().__init__(value)
        self.value = value


def dense(value: Polynomial) -> Dense:
    """The coefficients of a polynomial in x alone."""
    return [value.terms.get((k, 0), Fraction(0)) for k in range(value.degree + 1)] if value else []


def value_at(own: Dense, place: Fraction) -> Fraction:
    """By Horner's scheme."""
    BUDGET.spend_on(len(own), (place, *own), len(own))
    total = Fraction(0)
    for coefficient in reversed(own):
        total = total * place + coefficient
    return total


def without_root(own: Dense, root: Fraction) -> Dense:
    """A nonzero polynomial divided by ``(x - root)`` as often as that divides it."""
    while len(own) > 1 and not value_at(own, root):
        BUDGET.spend_on(len(own), (root, *own), len(own))
        quotient: Dense = []
        for coefficient in reversed(own):
            quotient.append(coefficient + root * (quotient[-1] if quotient else 0))
        own = quotient[-2::-1]  # the last one is the remainder, which is zero
    return own


def negated_remainder(top: Dense, bottom: Dense) -> Dense:
    """``-(top mod bottom)``, divided by a positive number."""
    rest = list(top)
    while len(rest) >= len(bottom):
        BUDGET.spend_on(len(bottom), (*rest, *bottom), 2)
        factor = rest[-1] / bottom[-1]
        for k, coefficient in enumerate(bottom, len(rest) - len(bottom)):
            rest[k] -= factor * coefficient
        rest.pop()
    while rest and not rest[-1]:
        rest.pop()
    return [-coefficient / abs(rest[-1]) for coefficient in rest]


def variations(chain: Sequence[Dense], place: Fraction) -> int:
    """Changes of sign along a chain, zeros left out."""
    values = [value for own in chain if (value := value_at(own, place))]
    return sum(1 for a, b in pairwise(values) if a * b < 0)


def has_root_between(own: Dense, low: Fraction, high: Fraction) -> bool:
    """Whether a nonzero polynomial vanishes in an open interval: Sturm's theorem.

    Divided by the factors that vanish at the ends, it has as many distinct roots between them as its chain ``p, p',
    -(p mod p'), ...`` loses changes of sign; this holds for multiple roots too.
    """
    own = without_root(without_root(own, low), high)
    chain = [own, [k * coefficient for k, coefficient in enumerate(own)][1:]]
    while chain[-1]:
        chain.append(negated_remainder(chain[-2], chain[-1]))
    return variations(chain, low) != variations(chain, high)


def sign_between(value: Polynomial, low: Fraction, high: Fraction) -> int:
    """The sign of a nonzero polynomial in an open interval; 0 where it vanishes inside."""
    own = dense(value)
    middle = value_at(own, (low + high) / 2)
    return 0 if not middle or has_root_between(own, low, high) else (1 if middle > 0 else -1)


def germ_sign(value: Polynomial) -> int:
    """The sign at all small positive x: that of the coefficient of the lowest power; 0 for the zero polynomial."""
    return (1 if value.terms[min(value.terms)] > 0 else -1) if value else 0


def pieces_of(formula: Formula, sure: Sure) -> list[Polynomial]:
    """What a formula can be where some signs are not known: every answer of these is tried, 1 and -1.

    At a point where switching expressions vanish, the limits of the formula from either side are among these.
    """
    found: list[Polynomial] = []
    waiting: list[dict[Polynomial, int]] = [{}]
    while waiting:
        answers = waiting.pop()

        def sign_of(value: Polynomial, answers: dict[Polynomial, int] = answers) -> int:
            known = sure(value) or answers.get(value) or -answers.get(-value, 0)
            if not known:
                raise UnknownSignError(value)
            return known

        try:
            found.append(formula.on(sign_of))
        except UnknownSignError as asked:
            waiting += [{**answers, asked.value: sign} for sign in (1, -1)]
        require(len(found) + len(waiting) <= MAX_ANSWERS, f"at most {MAX_ANSWERS} pieces of a formula near a point")
    return found


class ScalarCertificate:
    """A certificate of a system in one state: F is the hull of all limits of its fields at a point."""

    def __init__(self, data: Any) -> None:
        require(type(data) is dict and sorted(data) == sorted(SCALAR_KEYS.split()), f"the keys {SCALAR_KEYS}")
        BUDGET.left = MAX_WORK
        self.states, rhs = data["states"], data["rhs"]
        require(type(self.states) is list and len(self.states) == 1, "one state")
        require(type(self.states[0]) is str and NAME.fullmatch(self.states[0]), "a state with a name")
        require(type(data["at"]) is list and len(data["at"]) == 1, "a point of one number")
        self.at, self.verdict = rational(data["at"][0]), data["verdict"]
        require(self.verdict in (ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE), "a verdict")
        require(type(rhs) is list and 0 < len(rhs) <= MAX_FIELDS, f"one to {MAX_FIELDS} right-hand sides")
        require(all(type(side) is list and len(side) == 1 for side in rhs), "one formula in each right-hand side")
        self.right, self.left = ([self._formula(text, turn) for (text,) in rhs] for turn in (1, -1))
        self.starts = data["starts"]

    def _formula(self, text: Any, turn: int) -> Formula:
        """A right-hand side in the distance from the point to one side."""
        distance = Polynomial({(1, 0): Fraction(turn)})
        return Formula(text, {self.states[0]: distance + constant(self.at)})

    def check(self) -> None:
        """Show every claim."""
        right = [formula.on(germ_sign) for formula in self.right]
        left = [-formula.on(germ_sign) for formula in self.left]
        if self.verdict == UNSTABLE:
            self._show_unstable(right, left)
        else:
            self._show_stable(right, left)
        if self.starts is not None:
            self._show_starts()

    def _show_stable(self, right: Sequence[Polynomial], left: Sequence[Polynomial]) -> None:
        """No field leads away near the point; for asymptotic stability every one leads back.

        Off the point the velocity is, at almost all times, a mixture of speeds of that side.  If none of these is
        positive (away from the point), the distance never grows.  If all are negative they stay below a negative number
        on each compact part of the side, so every distance is left behind.
        """
        most = max(map(germ_sign, (*right, *left)))
        require(most < 0 or (most == 0 and self.verdict == STABLE), "fields that lead back on both sides")

    def _show_unstable(self, right: Sequence[Polynomial], left: Sequence[Polynomial]) -> None:
        """A field that leads away on one side, or 0 outside F at the point.

        A positive speed in ``(0, d)`` carries a solution of this field from every start there to d.  If all limits at
        the point have one sign, so have all fields near it, and every solution leaves.
        """
        limits = [f.terms.get((0, 0), Fraction(0)) for f in right]
        limits += [-f.terms.get((0, 0), Fraction(0)) for f in left]
        rests = min(limits) <= 0 <= max(limits)
        require(not rests or max(map(germ_sign, (*right, *left))) > 0, "a field that leads away, or 0 outside F")

    def _show_starts(self) -> None:
        """Every start in the open interval reaches the point, or tends to it."""
        require(self.verdict == ASYMPTOTICALLY_STABLE, "starts of a point that attracts")
        require(type(self.starts) is list and len(self.starts) == 2, "an interval of starts: two numbers")
        low, high = map(rational, self.starts)
        require(low < self.at < high, "an interval of starts around the point")
        show_inward(self.right, high - self.at, 1)
        show_inward(self.left, self.at - low, -1)


def show_inward(formulas: Sequence[Formula], end: Fraction, turn: int) -> None:
    """Every field leads back at all distances in ``(0, end)``, on one side.

    The interval is cut until, in each open part and at each cut, all pieces that the formulas can be there are
    negative (away is positive).  Where a switching expression vanishes inside a part both its signs are tried, so the
    mixtures of the limits at its roots are negative too.  Then the distance falls at a speed that is bounded from
    below on each compact part.
    """
    waiting = [(Fraction(0), end)]
    for _ in range(MAX_PARTS):
        if not waiting:
            return
        low, high = waiting.pop()

        def between(value: Polynomial, low: Fraction = low, high: Fraction = high) -> int:
            return sign_between(value, low, high)

        if _all_lead_back(formulas, between, turn):
            continue
        require((high - low) * 2**MAX_HALVINGS > end, "a proof within the limits of this checker")
        middle = (low + high) / 2

        def at_middle(value: Polynomial, middle: Fraction = middle) -> int:
            return _sign(value_at(dense(value), middle))

        require(_all_lead_back(formulas, at_middle, turn), "fields that lead back from all starts")
        waiting += [(low, middle), (middle, high)]
    raise RejectedError("a proof within the limits of this checker")


def _all_lead_back(formulas: Sequence[Formula], sure: Sure, turn: int) -> bool:
    """Whether all pieces of all fields are surely negative (positive where the state falls with the distance)."""
    pieces = (piece for formula in formulas for piece in pieces_of(formula, sure))
    return all(piece and sure(piece) * turn < 0 for piece in pieces)


def _sign(value: Fraction) -> int:
    return (value > 0) - (value < 0)


# ---- what is said of a certificate -------------------------------------------------------------


def check_certificate(data: Any) -> str:
    """The claim of a certificate (parsed JSON) that is not shown; empty where all are."""
    try:
        schema = data.get("schema") if type(data) is dict else None
        (ScalarCertificate if schema == SCALAR_SCHEMA else Certificate)(data).check()
    except MALFORMED as error:
        return str(error) if isinstance(error, RejectedError) else f"well-formed data, not a {type(error).__name__}"
    return ""
