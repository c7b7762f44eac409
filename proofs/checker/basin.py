"""A basin as a mesh of simplices: a function W, affine on each of them, falls until a level set that attracts is met.

*Mesh.*  Corners are points of the plane or of space, each with a value of W; a simplex is the numbers of the corners of
a triangle, counterclockwise, or of a tetrahedron, of which the first corner sees the others counterclockwise from
inside: its determinant is positive.  Every side, with one of its two orders, has at most one simplex to its left.  A
side that has one in each order is *inner*; the others, with their ends and edges, are the *border*.

*Theorem.*  Let L be a set from which every solution tends to the point, and c a number, such that

1. for every simplex T and every field f of a cell that meets the inside of T: ``grad W_T . f < 0`` on T;
2. for every inner side e, with a normal n and one of its simplices T, there is a number t with
   ``(grad W_T + t n) . f < 0`` on e for all fields f of cells whose closures meet the inside of e;
3. at every corner that is not on the border the fields of all cells whose closures hold it lie in an open half plane;
4. every side of the border lies in L, or has ``W >= c`` at all of its corners.

In space 2 and 3 are for every side, edge and corner e, but those that belong to a side of the border: a mixture g of
``grad W_T`` of two simplices that hold e has ``g . f < 0`` on e for all fields f of cells whose closures meet the
inside of e, or hold the corner.  Then every solution from a point p of a simplex T with ``W_T(p) < c`` tends to the
point.

*Proof.*  Let S be the simplices glued along inner sides: a compact space, on which W is continuous.  It maps to the
plane, or to space, and off the border and what is of codimension two (corners, and edges in space) this map is one to
one near every point: simplices that share a side lie on different sides of it.  Lengths of paths are measured in S as
below.  Simplices may overlap, and W may have several values at a place; what is said is said of each simplex.  (What is
on the border by one simplex and inside by others counts as border.)

*Lifts.*  Let x be a path whose speed is at most v, and s_0 a point of S over x(0).  There is a path s over x from s_0,
of speed at most v, until s meets the border.  For x is a uniform limit of polygons of speed at most v that begin near
x(0), inside a simplex at s_0, and miss the images of all that is of codimension two: finitely many points in the plane,
and finitely many segments in space, which almost all polygons miss.  Each polygon is lifted, step by step, in one way
until the lift meets the border, where it stops.  The lifts have speed at most v in the compact space S, so some of them
converge uniformly (Arzela and Ascoli), to a path over x until it stops; and where it stops it is on the border.

Let x be a solution from p, and s such a lift.  W(s) is absolutely continuous.  At almost all times at which s is inside
T, or inside a face of T of any dimension, its derivative is ``grad W_T . x'``: the solution has such times arbitrarily
near, so x' is along this face.  Inside T it is negative by 1, with x' a mixture of fields of 1.  In the plane, at
almost all times at which s is inside an inner side e it is ``grad W_T . x' = (grad W_T + t n) . x'``, because x' is
along e, and x' is a mixture of fields of 2.  At almost all times at which s is at a corner x' is zero, by 3 no
mixture of its fields: such times have measure zero.  In space the W of all simplices that hold e agree on e, so for x'
along e, or zero at a corner, ``grad W_T . x' = g . x'``, and x' is a mixture of fields for which that is negative.  All
conditions are strict on compact sets, so W(s) falls at a speed that is bounded from below.  W is bounded on S, and a
solution in the compact image of S goes on; so s meets the border after a finite time, with ``W < c``.  By 4 the
solution is in L there.

What is asked of e follows from 1 where all of its cells meet the inside of one simplex that holds it.  Polynomials are
negative on a simplex, or on a side, if all of their Bernstein coefficients there are.  In ``f = f_0 + sum_j w_j f_j``
sines, cosines, tanh and atan w_j of affine functions are replaced by the bounds that :mod:`.waves` gives on the
simplex, or at the corner; on a side by those of its simplex T.  Each is an affine function and a number times some e
from -1 to 1, so a coefficient is largest where every e has the sign of what it is multiplied by.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property, partial
from itertools import combinations, permutations, product
from math import comb, factorial, lcm, prod
from operator import add, mul, sub
from typing import Any, Protocol, TypeAlias, TypeVar

from .cells import Domain, Function, Pattern, Surfaces, System
from .formulas import Formula
from .polynomials import Exponents, Polynomial, constant
from .positivity import Proofs
from .theorems import Statement, show_stability
from .waves import BITS, KINDS, interpolation_error, wave_value
from .work import BUDGET, items, rational, require, take

MAX_CORNERS, MAX_SIMPLICES = 500_000, 1_000_000
CORNER = re.compile(r"-?[0-9]{1,40}( -?[0-9]{1,40}){2,3}")
SIMPLEX = re.compile(r"[0-9]{1,6}( [0-9]{1,6}){2,3}")
NAMES = {2: "triangles", 3: "tetrahedra"}  # of the simplices of a mesh

Place: TypeAlias = tuple[int, ...]  # a point of the plane or of space, in units of the mesh
Corner = TypeVar("Corner")  # a number of one, or its place
Form: TypeAlias = Mapping[Exponents, int]  # a polynomial in the place, times a positive number


@dataclass(frozen=True)
class Field:
    """Polynomials with whole coefficients, all times one positive number.

    Attributes:
        parts: the polynomials.
        degree: the largest of their degrees.
        bits: the length of the longest coefficient.
        spreads: what may be added to them, each times a number from -1 to 1; of the same degree.
    """

    parts: tuple[Form, ...]
    degree: int
    bits: int
    spreads: tuple[Field, ...] = ()

    @classmethod
    def of(cls, polynomials: Sequence[Polynomial]) -> Field:
        """Polynomials with rational coefficients, times their common denominator."""
        BUDGET.spend(sum(len(polynomial.terms) * (1 + polynomial.bits**2 // 4096) for polynomial in polynomials))
        bottom = lcm(*(value.denominator for polynomial in polynomials for value in polynomial.terms.values()))
        parts = tuple({e: int(value * bottom) for e, value in polynomial.terms.items()} for polynomial in polynomials)
        bits = max((abs(value).bit_length() for part in parts for value in part.values()), default=0)
        return cls(parts, max(polynomial.degree for polynomial in polynomials), bits)

    def plus(self, other: Field, factor: Form) -> Field:
        """The sum with the product of another one and an affine function, in the same units."""
        total = [dict(part) for part in self.parts]
        for terms, part in zip(total, other.parts, strict=True):
            for exponents, value in part.items():
                for others, weight in factor.items():
                    key = tuple(map(add, exponents, others))
                    terms[key] = terms.get(key, 0) + value * weight
        bits = max(self.bits, other.bits + max(abs(value).bit_length() for value in factor.values())) + 2
        BUDGET.spend(sum(map(len, total)) * (1 + bits**2 // 4096))
        return Field(tuple(total), max(self.degree, other.degree + 1), bits)

    def times(self, factor: int) -> Field:
        """A multiple."""
        return Field(tuple(scaled(part, factor) for part in self.parts), self.degree, self.bits + factor.bit_length())

    def along(self, vector: Sequence[int]) -> Field:
        """The product with a vector, a polynomial."""
        total: dict[Exponents, int] = {}
        for factor, part in zip(vector, self.parts, strict=True):
            for exponents, value in part.items():
                total[exponents] = total.get(exponents, 0) + factor * value
        bits = self.bits + max(abs(entry).bit_length() for entry in vector)
        return Field((total,), self.degree, bits, tuple(spread.along(vector) for spread in self.spreads))

    def ends(self) -> list[Field]:
        """Fields without spreads that have all that this one may be in their hull."""
        fields = [replace(self, spreads=())]
        for spread in self.spreads:
            moved = [tuple(scaled(part, sign) for part in spread.parts) for sign in (-1, 1)]
            both = [tuple(map(added, zip(field.parts, more, strict=True))) for field in fields for more in moved]
            fields = [replace(self, parts=parts, bits=self.bits + 1, spreads=()) for parts in both]
        return fields

    def highest(self, corners: Sequence[Place], end: Place | None = None) -> list[int]:
        """The largest values that the coefficients may have (:meth:`on`)."""
        values = self.on(corners, end)
        for spread in self.spreads:
            values = [value + abs(more) for value, more in zip(values, spread.on(corners, end), strict=True)]
        return values

    def on(self, corners: Sequence[Place], end: Place | None = None) -> list[int]:
        """The Bernstein coefficients of one polynomial on a simplex, a side or at a corner, times a positive number.

        The coefficient of corners ``v_1, ..., v_d`` is the polar form: of the polynomial, made homogeneous of degree d
        by a variable that is 1, the derivative in the directions of all of them.  A half-line from a corner c has its
        direction e as another corner, where that variable is 0: coefficients of the powers of t at ``c + t e``, times
        positive numbers, from the lowest on.
        """
        (form,) = self.parts
        ends = [(corner, 1) for corner in corners] + ([] if end is None else [(end, 0)])
        length = self.bits + self.degree * max(abs(x).bit_length() for place, _ in ends for x in place)
        BUDGET.spend((1 + len(form)) * comb(self.degree + len(ends), len(ends)) * (1 + length**2 // 4096))
        count = len(corners[0])
        weighted = [form.get(power, 0) * weight for power, weight in listed_powers(self.degree, count).items()]
        forms = [(0, weighted)]
        for degree in range(self.degree, 0, -1):
            forms = [(k, toward(polar, degree, *ends[k])) for j, polar in forms for k in range(j, len(ends))]
        return [value for _, (value,) in forms]


@cache
def listed_powers(degree: int, count: int) -> dict[Exponents, int]:
    """The powers in some variables up to a degree, each with the product of the factorials of all its exponents.

    These include that of the variable which is 1.  A coefficient times this product is the derivative by all of them.
    """
    powers = (power for power in product(range(degree + 1), repeat=count) if sum(power) <= degree)
    return {power: prod(map(factorial, power)) * factorial(degree - sum(power)) for power in powers}


@cache
def raised_powers(degree: int, count: int) -> list[tuple[int, ...]]:
    """For each power below a degree where those higher by one variable stand in the list, last that higher by 1."""
    at = {power: number for number, power in enumerate(listed_powers(degree, count))}
    raised = [
        [(*power[:k], power[k] + 1, *power[k + 1 :]) for k in range(count)] + [power]
        for power in listed_powers(degree - 1, count)
    ]
    return [tuple(at[power] for power in powers) for powers in raised]


def toward(form: Sequence[int], degree: int, place: Place, weight: int = 1) -> list[int]:
    """A homogeneous polynomial of some degree, given by all its derivatives, in the direction of a place once less.

    The variable that is 1 is the weight there: 0 of a direction.
    """
    listed = raised_powers(degree, len(place))
    if not weight:
        return [sum(step * form[i] for step, i in zip(place, indices, strict=False)) for indices in listed]
    if len(place) == 2:
        x, y = place
        return [x * form[i] + y * form[j] + form[k] for i, j, k in listed]
    x, y, z = place
    return [x * form[i] + y * form[j] + z * form[k] + form[m] for i, j, k, m in listed]


@dataclass(frozen=True)
class Side:
    """A right-hand side on a cell: ``f_0 + sum_j w_j f_j`` with the sines and cosines w_j of the side.

    Attributes:
        parts: f_0, f_1, ..., each an entry for each state.
    """

    parts: tuple[tuple[Polynomial, ...], ...]

    @cached_property
    def fields(self) -> tuple[Field, ...]:
        """The same with whole coefficients, all times one positive number."""
        whole = Field.of([polynomial for part in self.parts for polynomial in part])
        degrees = [max(polynomial.degree for polynomial in part) for part in self.parts]
        n = len(self.parts[0])
        return tuple(Field(whole.parts[n * k : n * k + n], degree, whole.bits) for k, degree in enumerate(degrees))


class CellFields(Protocol):
    """Cells that a mesh meets, each with its velocities; the names of cells are told apart, no more.

    Attributes:
        has_borders: whether there may be several cells.
    """

    has_borders: bool

    def crossing(self, corners: Sequence[Place]) -> frozenset[Any]:
        """The cells that may meet the inside of a simplex."""

    def touching(self, corners: Sequence[Place]) -> frozenset[Any]:
        """The cells whose closures may meet the inside of a side, or hold a corner."""

    def fields(self, cell: Any, corners: Sequence[Place]) -> Iterable[Field]:
        """Fields that have those of a cell in their hull on a simplex, or at a corner, times positive numbers."""


class Plane:
    """The cells of a system in the places of a mesh, by the patterns of signs of its surfaces; also those in space."""

    def __init__(self, system: System, unit: Any, surfaces: Any, proofs: Proofs) -> None:
        require(unit is not None, "a unit of lengths")  # without one Domain would be the whole space
        self.domain = Domain(system, unit)
        self.surfaces = Surfaces(self.domain, surfaces, [], proofs)
        self._guards = [Field.of([surface]) for surface in self.surfaces.listed]
        self.has_borders = bool(self.surfaces.listed)
        self.waves: list[list[tuple[str, Polynomial]]] = []  # of each side, with what they are of
        self._whole_arguments: list[list[list[int]]] = []
        self._formulas = system.fields(self.domain.place, lambda _, v, end: constant(v.count, end))
        self._counts = [sum(counts) for counts in system.waves]
        self.sides, self.value = cache(self._sides), cache(self._value)
        self._guard_at = cache(lambda k, place: self._guards[k].on((place,))[0])
        self._read_waves(system)

    def _read_waves(self, system: System) -> None:
        """The waves of all sides, in the order in which they are at their ends in a side's formulas."""
        for counts, side in zip(system.waves, system.rhs, strict=True):
            waves: list[tuple[str, Polynomial]] = []
            for count, text in zip(counts, side, strict=True):
                waves += Formula(text, self.domain.place, [0] * count).arguments()
            affine = all(name in KINDS and v.degree <= 1 for name, v in waves)
            require(affine, "sines, cosines, tanh and atan of affine functions")
            self.waves.append(waves)
            self._whole_arguments.append([whole_argument(v) for _, v in waves])

    def _sides(self, signs: Pattern) -> list[Side]:
        """The right-hand sides on a cell.

        A formula with all waves at numbers 0 or 1 has ``f_0 + sum_j w_j f_j`` for values where no two are multiplied.
        """
        sign_on, start, sides = partial(self.surfaces.sign_on, signs), 0, []
        for count in self._counts:
            fields = [tuple(part.on(sign_on) for part in field) for field in self._formulas[start : start + 2**count]]
            start += 2**count
            parts = [fields[0]] + [difference(fields[1 << (count - 1 - j)], fields[0]) for j in range(count)]
            for ends, value in zip(product((0, 1), repeat=count), fields, strict=True):
                rest = value
                for end, part in zip(ends, parts[1:], strict=True):
                    rest = difference(rest, part) if end else rest
                require(rest == fields[0], "sines and cosines that are not multiplied by each other")
            sides.append(Side(tuple(parts)))
        return sides

    def _value(self, side: int, wave: int, place: Place) -> tuple[int, int]:
        """What a wave is of at a place, times the common denominator of its coefficients, and its value there."""
        bottom, start, *slopes = self._whole_arguments[side][wave]
        numerator = start + sum(map(mul, slopes, place))
        return numerator, wave_value(self.waves[side][wave][0], Fraction(numerator, bottom))

    def fields(self, signs: Pattern, corners: Sequence[Place]) -> Iterator[Field]:
        """Fields that have those of a cell in their hull on a simplex, or at a corner, times positive numbers."""
        for k, side in enumerate(self.sides(signs)):
            whole, *moved = side.fields
            if not moved:
                yield whole
                continue
            size, weights = barycentric(corners)
            whole, spreads = whole.times(size << BITS), []
            for j, part in enumerate(moved):
                at = [self.value(k, j, place) for place in corners]
                mean = added([scaled(weight, value) for weight, (_, value) in zip(weights, at, strict=True)])
                whole = whole.plus(part, mean)
                v, bottom = [numerator for numerator, _ in at], self._whole_arguments[k][j][0]
                spreads.append(part.times(interpolation_error(max(v) - min(v), bottom) * size))
            yield replace(whole, spreads=tuple(replace(spread, degree=whole.degree) for spread in spreads))

    def crossing(self, corners: Sequence[Place]) -> frozenset[Pattern]:
        """The cells that may meet the inside of a simplex: a surface has their sign at some point of it."""
        return self._patterns(any(s * c > 0 for c in values) for values, s in self._on(corners))

    def touching(self, corners: Sequence[Place], end: Place | None = None) -> frozenset[Pattern]:
        """The cells whose closures may meet the inside of a side or of a half-line, or hold a corner.

        A polynomial whose Bernstein coefficients are not all zero, and none positive, is negative inside the side.
        """
        return self._patterns(any(s * c > 0 for c in values) or not any(values) for values, s in self._on(corners, end))

    def _on(self, corners: Sequence[Place], end: Place | None = None) -> Iterator[tuple[list[int], int]]:
        for k, guard in enumerate(self._guards):
            is_affine = guard.degree == 1 and end is None
            values = [self._guard_at(k, place) for place in corners] if is_affine else guard.on(corners, end)
            yield from ((values, -1), (values, 1))

    def _patterns(self, allowed: Iterable[bool]) -> frozenset[Pattern]:
        both = list(allowed)
        signs = [[s for s, holds in ((-1, both[k]), (1, both[k + 1])) if holds] for k in range(0, len(both), 2)]
        size = 1
        for surface_signs in signs:
            size *= len(surface_signs)
            require(size <= 64, "simplices that meet at most 64 cells")
        BUDGET.spend(size * (1 + len(signs)))
        return frozenset(product(*signs))


def whole_argument(v: Polynomial) -> list[int]:
    """The common denominator of the coefficients of an affine function, then its value at the point and its slopes."""
    numbers = [v.at_origin, *map(v.slope, range(v.count))]
    bottom = lcm(*(number.denominator for number in numbers))
    return [bottom, *(int(number * bottom) for number in numbers)]


def difference(first: Sequence[Polynomial], second: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
    """Of two fields."""
    return tuple(a - b for a, b in zip(first, second, strict=True))


def barycentric(corners: Sequence[Place]) -> tuple[int, list[Form]]:
    """The size of a simplex times d!, and the weights of its corners at a place, times that.

    Of a side in the plane it is the square of its length, with the weights of the nearest place on its line; of one
    corner it is 1.
    """
    if len(corners) == 1:
        return 1, [{(0,) * len(corners[0]): 1}]
    if len(corners) == 2:
        (ax, ay), (bx, by) = corners
        x, y = bx - ax, by - ay
        to_first: Form = {(0, 0): bx * x + by * y, (1, 0): -x, (0, 1): -y}
        return x * x + y * y, [to_first, {(0, 0): -ax * x - ay * y, (1, 0): x, (0, 1): y}]
    weights: list[Form] = []
    for side in sides_of(corners):
        outward, place = normal(side), side[0]
        form = {(0,) * len(place): sum(map(mul, outward, place))}
        for k, component in enumerate(outward):
            form[(*(0,) * k, 1, *(0,) * (len(place) - k - 1))] = -component
        weights.append(form)
    return sum(next(iter(weight.values())) for weight in weights), weights


def sides_of(corners: Sequence[Corner]) -> list[tuple[Corner, ...]]:
    """The sides of a simplex of positive size, opposite to its corners in turn, so that it lies to their left."""
    if len(corners) == 3:
        a, b, c = corners
        return [(b, c), (c, a), (a, b)]
    a, b, c, d = corners
    return [(b, c, d), (a, d, c), (a, b, d), (a, c, b)]


def difference_of(first: Place, last: Place) -> Place:
    """The way from one place to another."""
    return tuple(map(sub, last, first))


def normal(side: Sequence[Place]) -> Place:
    """Of a side to its right: outward of the simplex to its left."""
    if len(side) == 2:
        x, y = difference_of(*side)
        return y, -x
    (ax, ay, az), (bx, by, bz) = (difference_of(side[0], corner) for corner in side[1:])
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def scaled(form: Form, factor: int) -> Form:
    """A multiple of a polynomial."""
    return {e: value * factor for e, value in form.items()}


def added(forms: Sequence[Form]) -> Form:
    """A sum of polynomials."""
    total: dict[Exponents, int] = {}
    for form in forms:
        for e, value in form.items():
            total[e] = total.get(e, 0) + value
    return total


class Mesh:
    """Corners with their values, and simplices; see the head of this file.

    Args:
        data: of a certificate.
        dimension: of the space, 2 or 3.
    """

    def __init__(self, data: Any, dimension: int = 2) -> None:
        self.dimension = dimension
        self.unit, corners, simplices = take(data, f"unit corners {NAMES[dimension]}")
        places = [numbers(text, dimension + 1, CORNER) for text in items(corners, most=MAX_CORNERS)]
        self.places, self.values = [corner[:-1] for corner in places], [corner[-1] for corner in places]
        self.simplices = [numbers(text, dimension + 1, SIMPLEX) for text in items(simplices, most=MAX_SIMPLICES)]
        require(self.simplices, "a simplex")
        self.left: dict[Place, int] = {}  # the simplex to the left of a side in one of its two orders
        for number, simplex in enumerate(self.simplices):
            BUDGET.spend(20)
            for side in map(in_order, sides_of(simplex)):
                require(side not in self.left, "sides of one simplex to the left, and of one to the right")
                self.left[side] = number
        self.border = [side for side in self.left if turned(side) not in self.left]

    def corners(self, indices: Iterable[int]) -> list[Place]:
        """The places of some corners."""
        return [self.places[k] for k in indices]

    def inner_corners(self) -> set[int]:
        """The numbers of the corners that are on no side of the border."""
        return {k for simplex in self.simplices for k in simplex} - {k for side in self.border for k in side}

    def slope(self, simplex: int) -> Place:
        """The gradient of W on a simplex, times its size and d!, which must be positive."""
        indices = self.simplices[simplex]
        corners, values = self.corners(indices), [self.values[k] for k in indices]
        normals = [normal(side) for side in sides_of(corners)]
        away = difference_of(corners[1], corners[0])
        require(sum(map(mul, normals[0], away)) < 0, "simplices of positive size")
        rises = [value - values[0] for value in values]
        return tuple(-sum(map(mul, rises, parts)) for parts in zip(*normals, strict=True))


def in_order(side: tuple[int, ...]) -> Place:
    """A side in space begins with its least corner; one in the plane is run through in one direction."""
    start = side.index(min(side)) if len(side) == 3 else 0
    return side[start:] + side[:start]


def turned(side: Place) -> Place:
    """The same side in the other order."""
    return in_order((*side[:-2], side[-1], side[-2]))


def numbers(data: Any, count: int, form: re.Pattern[str]) -> Place:
    """Some whole numbers from a text such as ``-3 0 12``."""
    require(type(data) is str and form.fullmatch(data), f"{count} whole numbers in a text")
    values = tuple(map(int, data.split(" ")))
    require(len(values) == count, f"{count} whole numbers in a text")
    return values


def show_falls(mesh: Mesh, cells: CellFields) -> None:
    """W falls along every solution until the border is met: conditions 1 to 3."""
    crossing = []
    for number, simplex in enumerate(mesh.simplices):
        corners, slope = mesh.corners(simplex), mesh.slope(number)
        crossing.append(cells.crossing(corners))
        for field in (field for signs in crossing[-1] for field in cells.fields(signs, corners)):
            require(max(field.along(slope).highest(corners)) < 0, f"a function that falls on simplex {number}")
    if cells.has_borders:
        (show_across if mesh.dimension == 2 else show_across_in_space)(mesh, cells, crossing)


def show_across(mesh: Mesh, plane: CellFields, crossing: Sequence[frozenset[Any]]) -> None:
    """W falls along solutions that stay on a side, or at a corner, where cells meet: conditions 2 and 3 in the plane.

    Args:
        mesh: of triangles.
        plane: the cells.
        crossing: those that the inside of each triangle may meet.
    """
    for (i, j), number in mesh.left.items():
        other = mesh.left.get((j, i))
        if other is not None and i < j:
            touching = plane.touching(mesh.corners((i, j)))
            if not touching <= crossing[number] and not touching <= crossing[other]:
                beside = mesh.corners(mesh.simplices[number])
                fields = [end for signs in touching for field in plane.fields(signs, beside) for end in field.ends()]
                across = normal(mesh.corners((i, j)))
                falls = falls_along(mesh, (i, j), mesh.slope(number), across, fields)
                require(falls, f"a function that falls on side {i} {j}")
    for k in mesh.inner_corners():
        (place,) = corners = mesh.corners((k,))
        touching = plane.touching(corners)
        fields = [end for signs in touching for field in plane.fields(signs, corners) for end in field.ends()]
        velocities = [(field.along((1, 0)).on(corners)[0], field.along((0, 1)).on(corners)[0]) for field in fields]
        require(len(touching) == 1 or in_half_plane(velocities), f"velocities in a half plane at {place}")


def show_across_in_space(mesh: Mesh, space: CellFields, crossing: Sequence[frozenset[Any]]) -> None:
    """W falls along solutions that stay on a side, an edge or a corner where cells meet: conditions 2 and 3 in space.

    Args:
        mesh: of tetrahedra.
        space: the cells.
        crossing: those that the inside of each tetrahedron may meet.
    """
    holding: dict[Place, list[int]] = {}
    for number, simplex in enumerate(mesh.simplices):
        BUDGET.spend(20)
        for count in (1, 2, 3):
            for face in combinations(sorted(simplex), count):
                holding.setdefault(face, []).append(number)
    for side in mesh.border:
        for count in (1, 2, 3):
            for face in combinations(sorted(side), count):
                holding.pop(face, None)
    for face, numbers in holding.items():
        touching = space.touching(mesh.corners(face))
        if not any(touching <= crossing[number] for number in numbers):
            beside = mesh.corners(mesh.simplices[numbers[0]] if len(face) > 1 else face)
            fields = [end for signs in touching for field in space.fields(signs, beside) for end in field.ends()]
            slopes = [mesh.slope(number) for number in numbers]
            BUDGET.spend(len(slopes) ** 2)
            falls = any(falls_along(mesh, face, *pair, fields, least=0) for pair in permutations(slopes, 2))
            require(falls, f"a function that falls on the face {face}")


def falls_along(
    mesh: Mesh, side: Place, slope: Place, across: Place, fields: Iterable[Field], least: int | None = None
) -> bool:
    """Whether there is a number t with ``(slope + t across) . f < 0`` on a side for all of the fields: bounds of t.

    Args:
        mesh: of simplices.
        side: the numbers of the corners of one, or in space those of an edge, or of one corner.
        slope: a vector.
        across: another one.
        fields: velocities.
        least: of t; any number where None.
    """
    corners = mesh.corners(side)
    low = None if least is None else Fraction(least)
    high: Fraction | None = None
    for field in fields:
        rates, pushes = field.along(slope).on(corners), field.along(across).on(corners)
        for rate, push in zip(rates, pushes, strict=True):
            if not push and rate >= 0:
                return False
            bound = Fraction(-rate, push) if push else None
            if push > 0:
                high = bound if high is None or bound is None else min(high, bound)
            elif push < 0:
                low = bound if low is None or bound is None else max(low, bound)
    return low is None or high is None or low < high


def in_half_plane(vectors: Sequence[tuple[int, int]]) -> bool:
    """Whether vectors have positive products with one vector: all others lie less than a half turn from the first."""
    for ax, ay in vectors:
        turns = [(ax * by - ay * bx, ax * bx + ay * by) for bx, by in vectors]
        if all(turn > 0 or (not turn and along > 0) for turn, along in turns):
            return True
    return False


def show_border(mesh: Mesh, level: int, plane: Plane, near: Function, local: Statement) -> None:
    """Every side of the border lies in the level set that attracts, or has values of at least the level."""
    reach, below = rational(local["within"]) / rational(mesh.unit), rational(local["below"])
    for side in mesh.border:
        if min(mesh.values[k] for k in side) >= level:
            continue
        corners = mesh.corners(side)
        for signs in plane.touching(corners):
            room = Field.of([constant(mesh.dimension, below) - near.on(signs)])
            inside = all(abs(coordinate) <= reach for place in corners for coordinate in place)
            require(inside and min(room.on(corners)) > 0, f"a border in the level set, or at the level: {side}")


def show_basin(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """Every start in a simplex at which W is below the level tends to the point.

    Hypotheses: ``local`` (those of theorem ``lyapunov`` with a level, which is shown first: L is its level set),
    ``surfaces`` on which fields and V switch, ``mesh`` (``unit``; ``corners``, each its place in units from the point
    and its value, whole numbers; ``triangles``, or in space ``tetrahedra``) and ``below``, the level c.
    """
    local, surfaces, mesh_data, below = take(hypotheses, "local surfaces mesh below")
    require(not system.numbers, "rational numbers, for a mesh")
    require("denominator" not in local, "a V without a denominator beside a mesh")
    conclusions = show_stability(system, local, proofs)
    levels = [conclusion["attracts"] for conclusion in conclusions if type(conclusion.get("attracts")) is dict]
    mesh = Mesh(mesh_data, system.count)
    require(type(below) is int, "a level that is a whole number")
    plane = Plane(system, mesh.unit, surfaces, proofs)
    near = Plane(system, mesh.unit, local["cells"]["surfaces"], proofs)
    show_falls(mesh, plane)
    show_border(mesh, below, near, Function(near.domain, near.surfaces, local["function"]), levels[0])
    return [*conclusions, {"attracts": {"mesh": mesh_data, "below": below}}]
