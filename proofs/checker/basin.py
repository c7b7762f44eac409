"""A basin as a mesh of triangles: a function W, affine on each triangle, falls until a level set that attracts is met.

*Mesh.*  Corners are points of the plane, each with a value of W; a triangle is three numbers of corners,
counterclockwise.  No side is run through twice in one direction; one that is run through in both is *inner*, the others
and their ends are the *border*.  Triangles that share an inner side lie on different sides of it.

*Theorem.*  Let L be a set from which every solution tends to the point, and c a number, such that

1. for every triangle T and every field f of a cell that meets the inside of T: ``grad W_T . f < 0`` on T;
2. for every inner side e, with a normal n and one of its triangles T, there is a number t with
   ``(grad W_T + t n) . f < 0`` on e for all fields f of cells whose closures meet the inside of e;
3. at every corner that is not on the border the fields of all cells whose closures hold it lie in an open half plane;
4. every side of the border lies in L, or has ``W >= c`` at both ends.

Then every solution from a point p of a triangle T with ``W_T(p) < c`` tends to the point.

*Proof.*  Let S be the triangles glued along inner sides: a compact surface, on which W is continuous.  It maps to the
plane.  Near every point off the border this map is one to one, or it is a corner, around which the triangles go a whole
number of times.  So a path in the plane is lifted to S from any point over its start until the lift meets the border:
beside corners in one way; and a piece of the path that comes from a corner, or goes to it, has a lift that does, in any
of the ways around it.  (Triangles may overlap, and W may have several values at a place: what is said is said of each
triangle.  A corner that is on the border and also inside by other triangles counts as border.)

Let x be a solution from p, and s its lift.  W(s) is absolutely continuous.  At almost all times at which s is inside T
its derivative is ``grad W_T . x'``, and x' is a mixture of fields of 1.  At almost all times at which s is inside an
inner side e, the solution has such times arbitrarily near, so x' is along e: the derivative is ``grad W_T . x' =
(grad W_T + t n) . x'``, and x' is a mixture of fields of 2.  At almost all times at which s is at a corner x' is zero,
by 3 no mixture of its fields: such times have measure zero.  All conditions are strict on compact sets, so W(s) falls
at a speed that is bounded from below.  W is bounded on S, and a solution in the compact image of S goes on; so s meets
the border after a finite time, with ``W < c``.  By 4 the solution is in L there.

An inner side whose cells all meet the inside of one of its triangles fulfils 2 with t = 0.  Polynomials are negative on
a triangle, or on a side, if all of their Bernstein coefficients there are.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from math import comb, lcm
from typing import Any, Protocol, TypeAlias

from .cells import Domain, Function, Pattern, Surfaces, System
from .polynomials import Exponents, Polynomial
from .positivity import Proofs
from .theorems import Statement, show_stability
from .work import BUDGET, items, rational, require, take

MAX_CORNERS, MAX_TRIANGLES = 500_000, 1_000_000
CORNER = re.compile(r"-?[0-9]{1,40} -?[0-9]{1,40} -?[0-9]{1,40}")
TRIANGLE = re.compile(r"[0-9]{1,6} [0-9]{1,6} [0-9]{1,6}")

Place: TypeAlias = tuple[int, int]  # a point of the plane, in units of the mesh
Form: TypeAlias = Mapping[Exponents, int]  # a polynomial in the place, times a positive number


@dataclass(frozen=True)
class Field:
    """Polynomials with whole coefficients, all times one positive number.

    Attributes:
        parts: the polynomials.
        degree: the largest of their degrees.
        bits: the length of the longest coefficient.
    """

    parts: tuple[Form, ...]
    degree: int
    bits: int

    @classmethod
    def of(cls, polynomials: Sequence[Polynomial]) -> Field:
        """Polynomials with rational coefficients, times their common denominator."""
        BUDGET.spend(sum(len(own.terms) * (1 + own.bits**2 // 4096) for own in polynomials))
        bottom = lcm(*(value.denominator for own in polynomials for value in own.terms.values()))
        parts = tuple({e: int(value * bottom) for e, value in own.terms.items()} for own in polynomials)
        bits = max((abs(value).bit_length() for part in parts for value in part.values()), default=0)
        return cls(parts, max(own.degree for own in polynomials), bits)

    def along(self, vector: Sequence[int]) -> Field:
        """The product with a vector, a polynomial."""
        total: dict[Exponents, int] = {}
        for factor, part in zip(vector, self.parts, strict=True):
            for exponents, value in part.items():
                total[exponents] = total.get(exponents, 0) + factor * value
        return Field((total,), self.degree, self.bits + max(abs(own).bit_length() for own in vector))

    def on(self, corners: Sequence[Place]) -> list[int]:
        """The Bernstein coefficients of one polynomial on a triangle, a side or at a corner, times a positive number.

        The coefficient of corners ``v_1, ..., v_d`` is the polar form: of the polynomial, made homogeneous of degree d
        by a variable that is 1, the derivative in the directions of all of them.
        """
        (form,) = self.parts
        length = self.bits + self.degree * max(abs(own).bit_length() for place in corners for own in place)
        BUDGET.spend((1 + len(form)) * comb(self.degree + len(corners), len(corners)) * (1 + length**2 // 4096))
        forms = [(0, form)]
        for left in range(self.degree, 0, -1):
            forms = [(k, toward(own, left, corners[k])) for j, own in forms for k in range(j, len(corners))]
        return [own.get((0, 0), 0) for _, own in forms]


def toward(form: Form, degree: int, place: Place) -> Form:
    """The derivative of a polynomial, made homogeneous of some degree, in the direction of a place."""
    found: dict[Exponents, int] = {}
    for (a, b), value in form.items():
        if a:
            found[a - 1, b] = found.get((a - 1, b), 0) + a * value * place[0]
        if b:
            found[a, b - 1] = found.get((a, b - 1), 0) + b * value * place[1]
        if degree > a + b:
            found[a, b] = found.get((a, b), 0) + (degree - a - b) * value
    return found


class CellFields(Protocol):
    """Cells that a mesh meets, each with its velocities; the names of cells are told apart, no more.

    Attributes:
        has_borders: whether there may be several cells.
    """

    has_borders: bool

    def crossing(self, corners: Sequence[Place]) -> frozenset[Any]:
        """The cells that may meet the inside of a triangle."""

    def touching(self, corners: Sequence[Place]) -> frozenset[Any]:
        """The cells whose closures may meet the inside of a side, or hold a corner."""

    def fields(self, cell: Any) -> tuple[Field, ...]:
        """Velocities of which all of a cell's are mixtures."""


class Plane:
    """The cells of a system in the places of a mesh, by the patterns of signs of its surfaces."""

    def __init__(self, system: System, unit: Any, surfaces: Any, proofs: Proofs) -> None:
        self.domain = Domain(system, unit)
        self.surfaces = Surfaces(self.domain, surfaces, [], proofs)
        self._guards = [Field.of([own]) for own in self.surfaces.listed]
        self.has_borders = bool(self.surfaces.listed)
        self._formulas = system.fields(self.domain.place)
        self.sides, self.fields = cache(self._sides), cache(self._fields)

    def _sides(self, signs: Pattern) -> list[list[Polynomial]]:
        """The right-hand sides on a cell."""
        return [[own.on(lambda value: self.surfaces.sign_on(signs, value)) for own in side] for side in self._formulas]

    def _fields(self, signs: Pattern) -> tuple[Field, ...]:
        """The same with whole coefficients."""
        return tuple(map(Field.of, self.sides(signs)))

    def crossing(self, corners: Sequence[Place]) -> frozenset[Pattern]:
        """The cells that may meet the inside of a triangle: a surface has their sign at some point of it."""
        return self._patterns(any(s * c > 0 for c in own) for own, s in self._on(corners))

    def touching(self, corners: Sequence[Place]) -> frozenset[Pattern]:
        """The cells whose closures may meet the inside of a side, or hold a corner.

        A polynomial whose Bernstein coefficients are not all zero, and none positive, is negative inside the side.
        """
        return self._patterns(any(s * c > 0 for c in own) or not any(own) for own, s in self._on(corners))

    def _on(self, corners: Sequence[Place]) -> Iterator[tuple[list[int], int]]:
        for own in self._guards:
            values = own.on(corners)
            yield from ((values, -1), (values, 1))

    def _patterns(self, allowed: Iterable[bool]) -> frozenset[Pattern]:
        both = list(allowed)
        signs = [[s for s, holds in ((-1, both[k]), (1, both[k + 1])) if holds] for k in range(0, len(both), 2)]
        size = 1
        for own in signs:
            size *= len(own)
            require(size <= 64, "triangles that meet at most 64 cells")
        BUDGET.spend(size * (1 + len(signs)))
        return frozenset(product(*signs))


class Mesh:
    """Corners with their values, and triangles; see the head of this file."""

    def __init__(self, data: Any) -> None:
        self.unit, corners, triangles = take(data, "unit corners triangles")
        places = [numbers(own, CORNER) for own in items(corners, most=MAX_CORNERS)]
        self.places, self.values = [(x, y) for x, y, _ in places], [value for *_, value in places]
        self.triangles = [numbers(own, TRIANGLE) for own in items(triangles, most=MAX_TRIANGLES)]
        require(self.triangles, "a triangle")
        self.left: dict[tuple[int, int], int] = {}  # the triangle to the left of a side that is run through
        for number, own in enumerate(self.triangles):
            BUDGET.spend(20)
            for side in pairwise((*own, own[0])):
                require(side not in self.left, "sides that are run through once in each direction")
                self.left[side] = number
        self.border = [side for side in self.left if side[::-1] not in self.left]

    def corners(self, own: Iterable[int]) -> list[Place]:
        """The places of some corners."""
        return [self.places[k] for k in own]

    def inner_corners(self) -> set[int]:
        """The numbers of the corners that are on no side of the border."""
        return {k for own in self.triangles for k in own} - {k for side in self.border for k in side}

    def slope(self, triangle: int) -> tuple[int, int]:
        """The gradient of W on a triangle, times twice its area, which must be positive."""
        (ax, ay), (bx, by), (cx, cy) = self.corners(self.triangles[triangle])
        first, second, third = (self.values[k] for k in self.triangles[triangle])
        require((bx - ax) * (cy - ay) > (cx - ax) * (by - ay), "counterclockwise triangles")
        up, across = second - first, third - first
        return up * (cy - ay) - across * (by - ay), across * (bx - ax) - up * (cx - ax)


def numbers(data: Any, form: re.Pattern[str]) -> tuple[int, int, int]:
    """Three whole numbers from a text such as ``-3 0 12``."""
    require(type(data) is str and form.fullmatch(data), "three whole numbers in a text")
    a, b, c = map(int, data.split(" "))
    return a, b, c


def show_falls(mesh: Mesh, plane: CellFields) -> None:
    """W falls along every solution until the border is met: conditions 1 to 3."""
    met = []
    for number, own in enumerate(mesh.triangles):
        corners, slope = mesh.corners(own), mesh.slope(number)
        met.append(plane.crossing(corners))
        for field in (field for signs in met[-1] for field in plane.fields(signs)):
            require(max(field.along(slope).on(corners)) < 0, f"a function that falls on triangle {number}")
    if not plane.has_borders:
        return
    for (i, j), number in mesh.left.items():
        other = mesh.left.get((j, i))
        if other is not None and i < j:
            touching = plane.touching(mesh.corners((i, j)))
            if not touching <= met[number] and not touching <= met[other]:
                fields = [field for signs in touching for field in plane.fields(signs)]
                require(falls_along(mesh, (i, j), mesh.slope(number), fields), f"a function that falls on side {i} {j}")
    for k in mesh.inner_corners():
        (place,) = corners = mesh.corners((k,))
        touching = plane.touching(corners)
        fields = [field for signs in touching for field in plane.fields(signs)]
        velocities = [(field.along((1, 0)).on(corners)[0], field.along((0, 1)).on(corners)[0]) for field in fields]
        require(len(touching) == 1 or in_half_plane(velocities), f"velocities in a half plane at {place}")


def falls_along(mesh: Mesh, side: tuple[int, int], slope: tuple[int, int], fields: Iterable[Field]) -> bool:
    """Whether there is a number t with ``(slope + t n) . f < 0`` on a side for all of the fields: bounds of t."""
    corners = mesh.corners(side)
    (ax, ay), (bx, by) = corners
    low: Fraction | None = None
    high: Fraction | None = None
    for field in fields:
        rates, pushes = field.along(slope).on(corners), field.along((by - ay, ax - bx)).on(corners)
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
            room = Field.of([Polynomial(2, {(0, 0): below}) - near.on(signs)])
            inside = all(abs(own) <= reach for place in corners for own in place)
            require(inside and min(room.on(corners)) > 0, f"a border in the level set, or at the level: {side}")


def show_basin(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """Every start in a triangle at which W is below the level tends to the point.

    Hypotheses: ``local`` (those of theorem ``lyapunov`` with a level, which is shown first: L is its level set),
    ``surfaces`` on which fields and V switch, ``mesh`` (``unit``; ``corners``, each its place in units from the point
    and its value, whole numbers; ``triangles``) and ``below``, the level c.
    """
    local, surfaces, mesh, below = take(hypotheses, "local surfaces mesh below")
    require(system.count == 2 and system.coordinates == system.states, "a system in the plane, in its states")
    shown = show_stability(system, local, proofs)
    levels = [own["attracts"] for own in shown if type(own.get("attracts")) is dict]
    require(levels, "a level set that attracts")
    own = Mesh(mesh)
    require(type(below) is int, "a level that is a whole number")
    plane = Plane(system, own.unit, surfaces, proofs)
    near = Plane(system, own.unit, local["cells"]["surfaces"], proofs)
    show_falls(own, plane)
    show_border(own, below, near, Function(near.domain, near.surfaces, local["function"]), levels[0])
    return [*shown, {"attracts": {"mesh": mesh, "below": below}}]
