"""All places in a cube where a plain system may rest, enclosed: equilibria of cells and of sliding motion, and corners.

A place rests if 0 is in F there.  In a cell that is ``f(x) = 0``.  On one surface ``s = 0`` between two fields it is

    s(x) = 0,    l f(x) + (1 - l) g(x) = 0,    0 <= l <= 1,

n + 1 equations for x and l: a *pseudo-equilibrium*, or *boundary equilibrium* where l is 0 or 1 (Kuznetsov, Rinaldi and
Gragnani 2003).  In the plane two surfaces meet in points, and 0 is in the hull of four fields,
or not.  Boxes that hold no zero by their balls, or by Krawczyk's operator, are dropped, those in which it shows exactly
one are kept, and others are halved: so nothing is missed, and what is left at the end is said to be left.
Polytopes in which every place rests are told first (:mod:`nonsmooth.proofs.rest_polytopes`).

Stability follows from the linearization where that decides, in balls: of f, or of the sliding motion with ``A = l f' +
(1 - l) g'``, ``b = f - g`` and ``c = grad s``,

    (1 - b c^T/(c^T b)) A,    on the surface,

which solutions come to in finite time if both fields lead to it, and leave if one does not (Filippov 1988, sec. 19).
Places whose coordinates are simple rational numbers are checked to be exact; there the whole search of theorems can be
asked.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from itertools import combinations, product

import numpy as np
from flint import acb_mat, arb, arb_mat

from nonsmooth.analysis.cells.switched_cells import square_regions, system_cells
from nonsmooth.analysis.fields.convex_weights import shortest_mixture
from nonsmooth.analysis.fields.stated_field import StatedField, stated_field, stated_fields
from nonsmooth.proofs.boxes.all_zeros import FINEST, MOST_BOXES, Box, all_zeros, halves, overlap
from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.kernel.cells import require_denominators
from nonsmooth.proofs.orbits.ball_steps import BallPolynomials
from nonsmooth.proofs.rest_equations import (
    FieldInBalls,
    cell_equations,
    corner_equations,
    in_direction,
    on_border,
    sliding_equations,
)
from nonsmooth.proofs.rest_polytopes import (
    RestKind,
    RestPolytope,
    joined,
    never_meet,
    of_border,
    resting_polytopes,
)
from nonsmooth.proofs.system_decision import checked_point
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart, border_parts, wave_border_parts
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.messages.under_way import tell_count
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import (
    CheckedCube,
    SwitchedSystem,
    require_one_field,
    signs_by_factors,
)

MOST_SURFACES = 6  # 2^6 cells are looked at
MOST_STATES = 4
CLUSTER = 2.0**-10  # of the cube: in a smaller cluster of boxes that are left one place may rest
ENDS = 2.0**-18  # of the cube: as near to the end of a stretch nothing is told apart from that
SIMPLE = 1_000  # denominators of coordinates that are tried


@dataclass(frozen=True)
class EnclosedEquilibrium:
    """One place of rest.

    Attributes:
        place: its coordinates in balls.
        exact: the same as numbers, where they are simple; else None.
        kind: where it lies.
        surfaces: the names of the surfaces on which it lies, or may lie.
        stability: by linearization.
        shape: node, focus or saddle, in two states; empty where that is open.
    """

    place: tuple[arb, ...]
    exact: tuple[Number, ...] | None
    kind: RestKind
    surfaces: tuple[str, ...]
    stability: Translation
    shape: str = ""


@dataclass(frozen=True)
class EnclosedEquilibria:
    """All places of rest of a cube.

    Attributes:
        places: those that are alone, from the nearest to the checked point on.
        stretches: segments and polytopes in which every place rests.
        left: boxes, in coordinates of the states, in which it is not known what rests, or how many places; those of
            a small cluster are one.
    """

    places: tuple[EnclosedEquilibrium, ...]
    stretches: tuple[RestPolytope, ...]
    left: tuple[tuple[arb, ...], ...]


def rest_places(system: SwitchedSystem) -> EnclosedEquilibria:
    """All places of rest of the checked cube.

    Raises:
        SceneError: for arbitrary switching, roots of states, norms, denominators that may be zero in the cube, and for
            too many states or surfaces.
    """
    require_one_field(system)
    _require_few(system)
    search = _Search(system)
    for held in range(3 if system.is_planar else len(search.surfaces) + 1):
        for chosen in combinations(range(len(search.surfaces)), held):
            search.look_on(chosen)
    if search.open:
        search.look_where_surfaces_meet()
    search.look_in_clusters()
    alone = (place for place in search.found if not search.is_on_polytope(place))
    places = sorted(alone, key=lambda place: sum(float(c) ** 2 for c in search.displaced(place.place)))
    radius = float(system.check.radius)
    left = [box for box in search.left if not (_is_small(radius, box) and search.is_at_end(box, ENDS))]
    return EnclosedEquilibria(tuple(places), tuple(joined(search.polytopes)), tuple(_joined_boxes(left, radius)))


def _require_few(system: SwitchedSystem) -> None:
    if len(system.states) > MOST_STATES:
        raise SceneError(system.origin, "system.states", f"at most {MOST_STATES} states", list(system.states))
    if system.vanishing or system.rewriting.norms:
        expected = "formulas without norms, and without denominators that are zero at the checked point (with them"
        raise SceneError(system.origin, "system.rhs", f"{expected} check decides one place)", StatedFact("some"))
    require_denominators(system)


# ---- the search over cells, surfaces and corners -------------------------------------------------


class _Search:
    """What is found so far; coordinates are displacements from the checked point."""

    def __init__(self, system: SwitchedSystem) -> None:
        self.system, self.count = system, len(system.states)
        self.centre, self.radius = system.check.equilibrium, system.check.radius
        moved = system.displaced(system.states)
        stated = system.surfaces()
        if len(stated) > MOST_SURFACES:
            raise SceneError(
                system.origin, "system.rhs", f"at most {MOST_SURFACES} switching surfaces", StatedFact(f"{len(stated)}")
            )
        self.surfaces = [surface.composed(moved) for surface in stated]
        self.names = [str(surface) for surface in stated]
        self._with_slopes = [
            BallPolynomials([surface, *(surface.derivative(name) for name in system.states)])
            for surface in self.surfaces
        ]
        self._fields: dict[tuple[int, ...], FieldInBalls] = {}
        self.found: list[EnclosedEquilibrium] = []
        self.polytopes = list(map(of_border, filter(self._is_stretch, self._borders)))
        self.open: list[tuple[tuple[int, ...], dict[int, int]]] = []  # where surfaces meet, with the signs of others
        self.left: list[tuple[arb, ...]] = []

    def displaced(self, place: Sequence[arb]) -> list[arb]:
        """Coordinates of the states as a displacement."""
        return [x - c.ball() for x, c in zip(place, self.centre, strict=True)]

    def stated(self, x: Sequence[arb]) -> tuple[arb, ...]:
        """A displacement as coordinates of the states."""
        return tuple(coordinate + c.ball() for coordinate, c in zip(x, self.centre, strict=True))

    def is_at_end(self, place: Sequence[arb], room: float) -> bool:
        """Whether a box may hold the corner of a polytope, or be as near to it as a share of the cube."""
        near = self.radius.ball() * room * UNIT
        ends = [end for part in self.polytopes for end in part.corners]
        boxes = [self.stated([coordinate.ball() + near for coordinate in end]) for end in ends]
        return any(overlap(box, place) for box in boxes)

    def is_on_polytope(self, place: EnclosedEquilibrium) -> bool:
        """Whether a place of rest is one of a polytope; where it is not exact, whether it may be a corner."""
        if place.exact is None:
            return self.is_at_end(place.place, 0.0)
        moved = [a - c for a, c in zip(place.exact, self.centre, strict=True)]
        return any(part.holds(moved) for part in self.polytopes) or self.is_at_end(place.place, 0.0)

    def field(self, signs: tuple[int, ...]) -> FieldInBalls:
        """The field where the surfaces have these signs."""
        if signs not in self._fields:
            sign_of = signs_by_factors(dict(zip(self.surfaces, signs, strict=True)))
            stated = stated_field(self.system, self.system.states, sign_of)
            self._fields[signs] = FieldInBalls(stated, self.system.states)
        return self._fields[signs]

    def value(self, k: int, x: Sequence[arb]) -> arb:
        """A surface at a place."""
        return arb(self._with_slopes[k](x)[0])

    # ---- equations -----------------------------------------------------------------------

    def look_on(self, chosen: tuple[int, ...]) -> None:
        """Find what rests on some surfaces, and on either side of all others."""
        others = [k for k in range(len(self.surfaces)) if k not in chosen]
        patterns = list(product((1, -1), repeat=len(others)))
        for number, sides in enumerate(patterns):
            tell_count(number, len(patterns), "cells")
            signs = dict(zip(others, sides, strict=True))
            around = [self._field_of(signs | dict(zip(chosen, side, strict=True))) for side in self._sides(chosen)]
            if (chosen and self._is_no_border(chosen, around)) or self._is_told(chosen, signs, around):
                continue
            if len(chosen) > 1 and not self.system.is_planar:
                self.open.append((chosen, signs))
                continue
            guards = [lambda z, k=k, side=side: self.value(k, z[: self.count]) * side for k, side in signs.items()]
            box = [self.radius.ball() * UNIT for _ in range(self.count)]
            if not chosen:
                equations = cell_equations(around[0])
            elif len(chosen) == 1:
                equations = sliding_equations(around[0], around[1], self._with_slopes[chosen[0]])
                box = [*box, (1 + UNIT) / 2]
            else:
                equations = corner_equations(*(self._with_slopes[k] for k in chosen))
            narrow = partial(on_border, around, self._with_slopes[chosen[0]]) if len(chosen) == 1 else list
            zeros = all_zeros(equations, guards, box, narrow, self.count)
            self.left += [self.stated(zero_box[: self.count]) for zero_box in zeros.left]
            for zero in zeros.found:
                self._note(chosen, signs, around, zero)

    def look_where_surfaces_meet(self) -> None:
        """Leave boxes on several surfaces, in three states and more, where 0 may be in the hull of all fields around.

        It is not where all of them lead along one direction.  Such places are seldom alone: on a curve in space four
        fields have one weight more than there are equations.  Boxes in which all is told by polytopes are dropped.
        """
        waiting, looked = deque([[self.radius.ball() * UNIT for _ in range(self.count)]]), 0
        while waiting:
            box, looked = waiting.popleft(), looked + 1
            signs = [_sign(self.value(k, box)) for k in range(len(self.surfaces))]
            if not any(self._may_be_on(signs, *surfaces) for surfaces in self.open):
                continue
            patterns = product(*((sign,) if sign else (1, -1) for sign in signs))
            if _lead_one_way([self.field(pattern).at(box)[0] for pattern in patterns]):
                continue
            if looked > MOST_BOXES or float(box[0].rad()) < FINEST * float(self.radius):
                self.left.append(self.stated(box))
            else:
                waiting += halves(box, [1.0] * self.count)

    @staticmethod
    def _may_be_on(signs: Sequence[int], chosen: Sequence[int], others: Mapping[int, int]) -> bool:
        """Whether a box may hold places on some surfaces and on a side of all others, by signs there, 0 if open."""
        return not any(signs[k] for k in chosen) and all(signs[k] in (0, side) for k, side in others.items())

    def look_in_clusters(self) -> None:
        """Note simple places that rest in small clusters of boxes that are left, as where zeros are not simple."""
        for hull in filter(partial(_is_small, float(self.radius)), _clusters(self.left)):
            x = self.displaced(hull)
            simple = [self._simple(coordinate, c) for coordinate, c in zip(x, self.centre, strict=True)]
            exact = tuple(number for number in simple if number is not None)
            if len(exact) < self.count:
                continue
            on = [k for k, surface in enumerate(self.surfaces) if not surface(exact)]
            kind = RestKind.CORNER if len(on) > 1 else RestKind.BOUNDARY if on else RestKind.CELL
            place = self._place([number.ball() for number in exact], exact, kind, on)
            moved = at_place(self.system, place)
            if moved is not None and checked_point(moved).equilibrium is Equilibrium.HOLDS:
                self._add(place)

    @staticmethod
    def _sides(chosen: Sequence[int]) -> Iterator[tuple[int, ...]]:
        return product((1, -1), repeat=len(chosen))

    def _field_of(self, signs: dict[int, int]) -> FieldInBalls:
        return self.field(tuple(signs[k] for k in range(len(self.surfaces))))

    def _is_no_border(self, chosen: tuple[int, ...], around: Sequence[FieldInBalls]) -> bool:
        """Whether the fields on the sides of what is held are one, all over or on the surface.

        What rests there rests in a closed cell then.
        """
        first, *others = (field.stated for field in around)
        return all(
            rates == first or (len(chosen) == 1 and _meet_on(first, rates, self.surfaces[chosen[0]]))
            for rates in others
        )

    def _is_told(self, chosen: tuple[int, ...], signs: Mapping[int, int], around: Sequence[FieldInBalls]) -> bool:
        """Whether all that rests there is known by linear algebra; it is noted."""
        planes = [self.surfaces[k] for k in chosen]
        if len(chosen) > 1 and self.system.is_planar:
            return never_meet(planes)  # where two lines meet there may be others: corners are looked at one by one
        if len(chosen) == 1 and self._rests_along(chosen[0], around):
            return True
        fields, guards = [field.stated for field in around], [self.surfaces[k] * side for k, side in signs.items()]
        polytopes = resting_polytopes(fields, planes, guards, self.radius)
        for polytope in polytopes or ():
            if polytope.dimension:
                self.polytopes.append(polytope)
                continue
            (place,), x = polytope.corners, [number.ball() for number in polytope.corners[0]]
            if len(chosen) > 1:
                on = [k for k, surface in enumerate(self.surfaces) if not surface(place)]
                self._add(self._place(x, place, RestKind.CORNER, on))
            else:
                self._note(chosen, dict(signs), around, [*x, *_share(around, place)])
        return polytopes is not None

    def _rests_along(self, k: int, around: Sequence[FieldInBalls]) -> bool:
        """Whether both fields are parallel all along a line in the plane, and stretches say where they are opposed."""
        if not self._borders or any(part.kind is BorderKind.UNDECIDED for part in self._borders):
            return False
        surface, fields = self.surfaces[k], [field.stated for field in around]
        if _along_line(_cross(*fields), surface):
            return False
        a, b = (surface.derivative(name).constant_value or 0 for name in surface.variables)
        return all(_along_line(field.rates[0] * a + field.rates[1] * b, surface) for field in fields)

    @cached_property
    def _borders(self) -> tuple[BorderPart, ...]:
        """What solutions do on the borders, in the plane, where all surfaces are lines; else none."""
        if not self.system.is_planar or any(surface.degree > 1 for surface in self.surfaces):
            return ()
        cells = system_cells(self.system, square_regions(self.radius))
        fields = stated_fields(self.system, cells)
        return tuple(wave_border_parts(cells, fields) if self.system.rewriting.names else border_parts(cells))

    def _is_stretch(self, part: BorderPart) -> bool:
        (a, b), (x, y) = part.normal, part.start
        line = Polynomial.coordinates(self.system.field, self.system.states)
        surface = (line[0] - x) * a + (line[1] - y) * b
        is_kept = part.kind in (BorderKind.SLIDING, BorderKind.REPELLING)
        return is_kept and not _along_line(_cross(*part.fields), surface)

    # ---- what a zero is ------------------------------------------------------------------

    def _note(
        self, chosen: tuple[int, ...], signs: dict[int, int], around: Sequence[FieldInBalls], zero: Sequence[arb]
    ) -> None:
        """Take a zero for the place of rest that it is; where that is not known, its box is left."""
        x, share = zero[: self.count], zero[self.count :]
        is_outside = any(bool(abs(coordinate) > self.radius.ball()) for coordinate in x)
        if is_outside or any(bool(weight < 0) or bool(weight > 1) for weight in share):
            return
        exact = self._exact(chosen, around, x)
        on = list(chosen)
        for k, side in signs.items():
            if not chosen and self._field_of(signs | {k: -side}).stated == around[0].stated:
                continue  # which is no border here
            value = sign(self.surfaces[k](exact)) if exact is not None else None
            known = value if value is not None else _sign(self.value(k, x))
            if known == -side:
                return
            if known == 0 and exact is None:
                self.left.append(self.stated(x))
                return
            on += [k] * (known == 0)
        is_mixed = not any(weight.contains(0) or weight.contains(1) for weight in share)
        if len(chosen) < 2 and len(on) == len(chosen) and is_mixed:
            self._add(self._regular(chosen, around, x, share, exact))
            return
        place = self._place(x, exact, RestKind.CORNER if len(on) > 1 else RestKind.BOUNDARY, on)
        holds = self._holds_zero(place, around, x)
        if holds is None:
            self.left.append(self.stated(x))
        elif holds:
            self._add(place)

    def _place(
        self, x: Sequence[arb], exact: Sequence[Number] | None, kind: RestKind, on: Sequence[int]
    ) -> EnclosedEquilibrium:
        numbers = None if exact is None else tuple(a + c for a, c in zip(exact, self.centre, strict=True))
        names = tuple(f"{self.names[k]} = 0" for k in sorted(on))
        return EnclosedEquilibrium(self.stated(x), numbers, kind, names, Translation.UNDECIDED)

    def _add(self, place: EnclosedEquilibrium) -> None:
        """Note a place, unless it is known: on surfaces places are found from several sides."""
        known = any(overlap(earlier.place, place.place) for earlier in self.found)
        if not known:
            self.found.append(place)

    def _regular(
        self,
        chosen: tuple[int, ...],
        around: Sequence[FieldInBalls],
        x: Sequence[arb],
        share: Sequence[arb],
        exact: Sequence[Number] | None,
    ) -> EnclosedEquilibrium:
        """An equilibrium of one field, or of sliding motion with a positive share of both."""
        if not chosen:
            matrix = around[0].at(x)[1]
            place = self._place(x, exact, RestKind.CELL, ())
            return replace(place, stability=_stability(matrix), shape=_shape(matrix))
        (f, f_slopes), (g, g_slopes) = (field.at(x) for field in around)
        normal = list(map(arb, self._with_slopes[chosen[0]](x)[1:]))
        out_of_first = in_direction(normal, f)  # the first field acts where the surface is positive
        kind = RestKind.SLIDING if out_of_first < 0 else RestKind.REPELLING
        across = in_direction(normal, [a - b for a, b in zip(f, g, strict=True)])
        if not (out_of_first < 0 or out_of_first > 0) or across.contains(0):
            return self._place(x, exact, RestKind.BOUNDARY, chosen)
        mixed = [
            [q + share[0] * (p - q) for p, q in zip(slopes, other, strict=True)]
            for slopes, other in zip(f_slopes, g_slopes, strict=True)
        ]
        falls = [in_direction(normal, [row[j] for row in mixed]) / across for j in range(self.count)]
        sliding = [
            [row[j] - (a - b) * falls[j] for j in range(self.count)] for row, a, b in zip(mixed, f, g, strict=True)
        ]
        matrix = _on_surface(sliding, normal)
        stability = _stability(matrix) if kind is RestKind.SLIDING else Translation.UNSTABLE
        place = self._place(x, exact, kind, chosen)
        return replace(place, stability=stability, shape=_sliding_shape(matrix, kind))

    def _exact(
        self, chosen: tuple[int, ...], around: Sequence[FieldInBalls], x: Sequence[arb]
    ) -> tuple[Number, ...] | None:
        """The displacement as numbers, where it is simple and shown to be that zero."""
        numbers = [self._simple(coordinate, c) for coordinate, c in zip(x, self.centre, strict=True)]
        place = tuple(number for number in numbers if number is not None)
        if len(place) < self.count or any(self.surfaces[k](place) for k in chosen):
            return None
        values = [rates for field in around if (rates := field.exactly_at(place)) is not None]
        if len(values) < len(around):
            return None
        if len(chosen) > 1:
            return place
        if not chosen:
            return None if any(values[0]) else place
        f, g = values
        parallel = all(not a * d - b * c for (a, c), (b, d) in combinations(zip(f, g, strict=True), 2))
        against = sum((a * b for a, b in zip(f, g, strict=True)), start=self.system.field.zero)
        return place if parallel and not against > 0 else None

    def _simple(self, x: arb, centre: Number) -> Number | None:
        """A displacement to a coordinate with a small denominator, where one lies in a ball."""
        stated = x + centre.ball()
        guess = self.system.field.rational(Fraction(float(stated.mid())).limit_denominator(SIMPLE))
        return guess - centre if stated.overlaps(guess.ball()) else None

    def _holds_zero(self, place: EnclosedEquilibrium, around: Sequence[FieldInBalls], x: Sequence[arb]) -> bool | None:
        """Whether 0 is in F; None where that is not known.

        Of a field that is zero on one surface it is; where more surfaces meet, by all cells that do.
        """
        if place.kind is RestKind.BOUNDARY:
            return None if place.exact is None else True
        moved = at_place(self.system, place)
        if moved is None:
            here = [tuple(field.at(x)[0]) for field in around]
            return _balls_hold_zero(here) if len(place.surfaces) == 2 else None  # type: ignore[arg-type]
        equilibrium = checked_point(moved).equilibrium
        return None if equilibrium is Equilibrium.UNDECIDED else equilibrium is Equilibrium.HOLDS


def at_place(system: SwitchedSystem, place: EnclosedEquilibrium) -> SwitchedSystem | None:
    """The system that is checked at a place of rest; None where it cannot be.

    It is checked on the largest cube within that which was searched; where the place is on its border on one as large.
    Sines are enclosed about the checked point, so it is at no other place, and coordinates must be exact.
    """
    check = system.check
    if place.exact == check.equilibrium:
        return system
    if place.exact is None or system.rewriting.names:
        return None
    away = zip(place.exact, check.equilibrium, strict=True)
    room = min((check.radius - abs(a - c) for a, c in away), key=float)
    if not room > 0:
        if system.rewriting.scale is not None:
            return None  # denominators may vanish beyond the cube
        room = check.radius
    lyapunov = parse_piecewise(" + ".join(f"{name}**2" for name in system.states), system.states)
    return replace(system, check=CheckedCube(place.exact, room, lyapunov, is_default=True))


def _clusters(boxes: Sequence[Sequence[arb]]) -> list[Box]:
    """The hulls of boxes that overlap each other."""
    hulls: list[Box] = []
    for box in boxes:
        joined, apart = list(box), list[Box]()
        for hull in hulls:
            if overlap(joined, hull):
                joined = [a.union(b) for a, b in zip(joined, hull, strict=True)]
            else:
                apart.append(hull)
        hulls = [*apart, joined]
    return hulls


def _is_small(radius: float, hull: Sequence[arb]) -> bool:
    return all(float(x.rad()) < radius * CLUSTER for x in hull)


def _joined_boxes(boxes: Sequence[tuple[arb, ...]], radius: float) -> list[tuple[arb, ...]]:
    """Boxes, those of a small cluster as one."""
    hulls = [hull for hull in _clusters(boxes) if _is_small(radius, hull)]
    apart = [box for box in boxes if not any(overlap(box, hull) for hull in hulls)]
    return [*map(tuple, hulls), *apart]


def _share(around: Sequence[FieldInBalls], place: Sequence[Number]) -> list[arb]:
    """The l with ``l f + (1 - l) g = 0`` at a place, between two fields; none of one field."""
    first, *others = (field.exactly_at(place) or [] for field in around)
    gaps = [(g, g - f) for other in others for f, g in zip(first, other, strict=True) if f != g]
    return [(gaps[0][0] / gaps[0][1]).ball() if gaps else arb(1) / 2] if others else []


# ---- vectors and matrices ------------------------------------------------------------------------


def _sign(value: arb) -> int:
    return 1 if value > 0 else -1 if value < 0 else 0


def _cross(first: StatedField, second: StatedField) -> Polynomial:
    (a, b), (c, d) = first.rates, second.rates
    return a * d - b * c


def _meet_on(first: StatedField, second: StatedField, plane: Polynomial) -> bool:
    """Whether two fields are equal all over a plane; on a curved surface that is not looked at."""
    if plane.degree > 1 or first.waves != second.waves:
        return False
    values = list(Polynomial.coordinates(plane.field, first.rates[0].variables))
    slopes = [plane.derivative(name).constant_value or plane.field.zero for name in plane.variables]
    k = next(j for j, slope in enumerate(slopes) if slope)
    values[k] -= plane.composed(values[: len(slopes)]) * slopes[k].inverse()
    return not any((a - b).composed(values) for a, b in zip(first.rates, second.rates, strict=True))


def _along_line(polynomial: Polynomial, line: Polynomial) -> Polynomial:
    """A polynomial in the plane, and in names of sines, at the points of a line, one after the other."""
    x, y = line.variables
    numbers = line.field
    zero = (numbers.zero, numbers.zero)
    c, a, b = line(zero), line.derivative(x)(zero), line.derivative(y)(zero)
    t, *names = Polynomial.coordinates(numbers, ("t", *polynomial.variables[2:]))
    size = (a * a + b * b).inverse()
    return polynomial.composed((t * -b - a * c * size, t * a - b * c * size, *names))


def _balls_hold_zero(vectors: Sequence[tuple[arb, arb]]) -> bool | None:
    """Whether 0 is in the hull of vectors of the plane; None where that is not known.

    It is in that of three that turn all around it, and in none of vectors in one open half-plane.
    """

    def cross(a: tuple[arb, arb], b: tuple[arb, arb]) -> arb:
        return a[0] * b[1] - a[1] * b[0]

    for a, b, c in combinations(vectors, 3):
        turns = [_sign(cross(*pair)) for pair in ((a, b), (b, c), (c, a))]
        if turns in ([1, 1, 1], [-1, -1, -1]):
            return True
    return False if _lead_one_way(vectors) else None


def _lead_one_way(vectors: Sequence[Sequence[arb]]) -> bool:
    """Whether all vectors lead along one direction, that of the shortest mixture of their middles."""
    middles = np.array([[float(entry) for entry in vector] for vector in vectors])
    weights = shortest_mixture(np.zeros((len(middles), 1)), middles)
    if weights is None or not np.isfinite(middles).all():
        return False
    direction = [arb(entry) for entry in (weights @ middles).tolist()]
    return all(bool(in_direction(direction, vector) > 0) for vector in vectors)


def _on_surface(matrix: Sequence[Sequence[arb]], normal: Sequence[arb]) -> list[list[arb]]:
    """A linear map on the vectors across a normal, by all coordinates but that with the largest entry there."""
    k = max(range(len(normal)), key=lambda j: abs(float(normal[j].mid())))
    kept = [j for j in range(len(normal)) if j != k]
    return [[matrix[i][j] - matrix[i][k] * normal[j] / normal[k] for j in kept] for i in kept]


def _stability(matrix: Sequence[Sequence[arb]]) -> Translation:
    """What the eigenvalues say; of a surface in one state there are none, and nothing moves on it."""
    signs = {_sign(value) for value in _real_parts(matrix)}
    if 1 in signs:
        return Translation.UNSTABLE
    return Translation.UNDECIDED if 0 in signs else Translation.ASYMPTOTICALLY_STABLE


def _real_parts(matrix: Sequence[Sequence[arb]]) -> list[arb]:
    """The real parts of all eigenvalues; in two dimensions numbers of the same signs."""
    if len(matrix) < 2:
        return [row[0] for row in matrix]
    if len(matrix) == 2:
        (a, b), (c, d) = matrix
        trace, determinant = a + d, a * d - b * c
        return [trace, trace] if determinant > 0 else [arb(1), arb(-1)] if determinant < 0 else [arb(0), trace]
    try:
        return [value.real for value in acb_mat(arb_mat(matrix)).eig(multiple=True, algorithm="vdhoeven_mourrain")]
    except ValueError:
        return [arb(0)]


def _shape(matrix: Sequence[Sequence[arb]]) -> str:
    """Saddle, node or focus, in two states."""
    if len(matrix) != 2:
        return ""
    (a, b), (c, d) = matrix
    determinant, bend = a * d - b * c, (a - d) ** 2 + 4 * b * c
    if determinant < 0:
        return "saddle"
    return "" if not determinant > 0 else "node" if bend > 0 else "focus" if bend < 0 else ""


def _sliding_shape(matrix: Sequence[Sequence[arb]], kind: RestKind) -> str:
    """Pseudo-node or pseudo-saddle, in two states: whether the sliding motion turns it the way that the fields do."""
    if len(matrix) != 1:
        return ""
    turn = _sign(matrix[0][0]) * (-1 if kind is RestKind.SLIDING else 1)
    return {1: "pseudo-node", -1: "pseudo-saddle", 0: ""}[turn]
