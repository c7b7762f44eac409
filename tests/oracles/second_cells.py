"""Cells, functions by pieces and faces of a plain system, by docs/specification.md: for the second checker."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, product
from typing import Any, TypeAlias

from flint import fmpq

from tests.oracles.second_evidence import Claim, Proofs, Row
from tests.oracles.second_formulas import (
    GENS,
    SIZE,
    ZERO,
    Poly,
    Reading,
    RefusedError,
    at_zero,
    degree,
    keys,
    need,
    number,
    on,
    solve,
    terms,
)

Signs: TypeAlias = tuple[int, ...]
Matrix: TypeAlias = list[list[fmpq]]
Subspace: TypeAlias = tuple[list[Poly], int]  # all variables on it, and its dimension
Term: TypeAlias = tuple[fmpq, list[tuple[Poly, int]]]  # a factor, and bases with their powers


def unit_matrix(n: int) -> Matrix:
    return [[fmpq(i == k) for k in range(n)] for i in range(n)]


def matrix_product(a: Matrix, b: Matrix) -> Matrix:
    return [
        [sum((x * y for x, y in zip(row, column, strict=True)), fmpq(0)) for column in zip(*b, strict=True)]
        for row in a
    ]


def times(matrix: Matrix, vector: Sequence[Poly]) -> list[Poly]:
    return [sum((z * x for z, x in zip(vector, row, strict=True)), ZERO) for row in matrix]


@dataclass(frozen=True)
class Cell:
    signs: Signs
    fields: list[tuple[int, list[Poly]]]
    functions: list[Poly]

    @property
    def v(self) -> Poly:
        return self.functions[0]


class Inclusion:
    """The cells of a system, with V and further functions on each."""

    def __init__(self, subject: Any, cells: Any, functions: Sequence[Any], proofs: Proofs) -> None:
        states, rhs, at = keys(subject, "states rhs at", "order")
        order = subject.get("order", 0)
        need(type(order) is int and 0 <= order <= 4, "further terms of sines and cosines")
        within, listed, empty = keys(cells, "within surfaces empty", "frame")
        need(all(type(own) is list for own in (states, at, rhs, listed, empty)), "lists")
        self.count = n = len(states)
        need(1 <= n == len(set(states)) == len(at) and n < SIZE and rhs, "a system in one to eight states")
        self.z = list(GENS[:n])
        self.bounded, self.radius = within is not None, fmpq(1) if within is None else number(within)
        need(self.radius > 0, "a cube of positive size")
        self.frame = [unit_matrix(n), unit_matrix(n)]
        if cells.get("frame") is not None:
            self.frame = [[[number(c) for c in row] for row in own] for own in cells["frame"]]
            need(all(len(own) == n and all(len(row) == n for row in own) for own in self.frame), "square matrices")
        need(len(self.frame) == 2 and matrix_product(*self.frame) == unit_matrix(n), "a matrix and its inverse")
        units = [z * self.radius for z in self.z]
        self.away = dict(zip(states, times(self.frame[0], units), strict=True))
        place = {name: z + number(x) for (name, z), x in zip(self.away.items(), at, strict=True)}
        self.surfaces = [Reading(self.away).value(own) for own in listed]
        need(all(degree(g) for g in self.surfaces), "surfaces that are not constant")
        coprime = all(not degree(g.gcd(h)) for g, h in combinations(self.surfaces, 2))
        need(coprime, "surfaces without a common factor")
        for mark in empty:
            self.show_empty(self.marked(mark), proofs, f"empty {mark}")
        self.cells = []
        for signs in product((1, -1), repeat=len(listed)):
            if any(agrees(self.marked(mark), signs) for mark in empty):
                continue
            reading = Reading(place, partial(self.sign_on, signs), order)
            stated = [field for side in rhs for field in reading.fields(side)]
            need(all(len(own) == n for own in stated), "a formula for each state in every right-hand side")
            fields = [times(self.frame[1], field) for field in stated]
            different = [(k, f) for k, f in enumerate(fields) if f not in fields[:k]]
            self.cells.append(Cell(signs, different, [self.function_on(signs, own) for own in functions]))
        self.bending = sorted(self.bending_surfaces())
        self.parted = set(self.parted_pieces(proofs))

    def marked(self, mark: str) -> dict[int, int]:
        need(len(mark) == len(self.surfaces) and set(mark) <= set("+-."), "a pattern")
        return {j: 1 if sign == "+" else -1 for j, sign in enumerate(mark) if sign != "."}

    def show_empty(self, signs: dict[int, int], proofs: Proofs, name: str) -> None:
        last = max(signs)
        guards = {f"s{j}": self.surfaces[j] * s for j, s in signs.items() if j != last}
        guards |= self.cube(self.z)
        row = Row(-self.surfaces[last] * signs[last], guards, open=guards)
        proofs.show(Claim(name, self.count, [row], strict=False, bounded=self.bounded))

    def cube(self, coordinates: Sequence[Poly]) -> dict[str, Poly]:
        found = {}
        for k, z in enumerate(coordinates if self.bounded else ()):
            if degree(z):
                found.update({f"b{k}": 1 - z * z, f"u{k}": 1 - z, f"d{k}": 1 + z})
        return found

    def sign_on(self, signs: Signs, value: Poly) -> int:
        sign = 1
        for s, surface in zip(signs, self.surfaces, strict=True):
            while degree(value) and not divmod(value, surface)[1]:
                value, sign = divmod(value, surface)[0], sign * s
        left = 1 if terms(value)[0][1] > 0 else -1
        even = all(c * left > 0 and not any(k % 2 for k in e) for e, c in terms(value))
        need(even, "switching expressions that are products of surfaces")
        return sign * left

    def function_on(self, signs: Signs, function: Any) -> Poly:
        pieces = [["." * len(signs), function]] if type(function) is str else function
        own = [text for mark, text in pieces if agrees(self.marked(mark), signs)]
        values = [Reading(self.away, partial(self.sign_on, signs)).value(text) for text in own]
        need(values and all(v == values[0] for v in values), "one polynomial of V on every cell")
        return values[0]

    def bending_surfaces(self) -> set[int]:
        by_signs = {cell.signs: cell.functions for cell in self.cells}
        found = {j for s, v in by_signs.items() for j in range(len(s)) if by_signs.get(flip(s, j), v) != v}
        return found

    def bound_term(self, cells: Sequence[Cell], data: Any) -> Term:
        """A term of a bound, which is nowhere negative on cells."""
        factor, powers = data
        signs = [{cell.signs[j] for cell in cells} for j in range(len(self.surfaces))]
        known = [g * min(own) for g, own in zip(self.surfaces, signs, strict=True) if len(own) == 1]
        found = [(Reading(self.away).value(base), power) for base, power in powers]
        need(all(type(power) is int and 1 <= power <= 20 for _, power in found), "powers from 1 to 20")
        need(all(not power % 2 or base in known for base, power in found), "a bound that is not negative")
        need(number(factor) > 0, "a positive factor")
        return number(factor), found

    def zeros_of(self, bound: Sequence[Term], part: Subspace) -> list[Subspace]:
        """The parts of a part on which a bound is zero, but those outside the cube, and the point alone."""
        found = [part]
        for _, powers in bound:
            smaller = [own for place in found for base, _ in powers for own in where_zero(base, place)]
            found = [own for k, own in enumerate(smaller) if own not in smaller[:k]]
        return [own for own in found if any(own[0]) and not self.is_outside(own[0])]

    def piece(self, cell: Cell) -> Signs:
        return tuple(cell.signs[j] for j in self.bending)

    def parted_pieces(self, proofs: Proofs) -> Iterator[frozenset[Signs]]:
        pieces: dict[Signs, list[Poly]] = {}
        for cell in self.cells:
            alike = pieces.setdefault(self.piece(cell), cell.functions) == cell.functions
            need(alike, "functions that bend on their surfaces alone")
        for signs, functions in pieces.items():
            for i, j in enumerate(self.bending):
                beside = zip(functions, pieces.get(flip(signs, i), functions), strict=True)
                if signs[i] > 0 and any(divmod(own - other, self.surfaces[j])[1] for own, other in beside):
                    self.show_parted(j, dict(zip(self.bending, signs, strict=True)), proofs)
                    yield frozenset((signs, flip(signs, i)))

    def show_parted(self, j: int, signs: Mapping[int, int], proofs: Proofs) -> None:
        need(degree(self.surfaces[j]) == 1, "a V that bends on lines")
        coordinates, dimension = solve([self.surfaces[j]], self.count)
        if self.is_outside(coordinates):
            return
        guards = self.cube(coordinates)
        for k, s in signs.items():
            own = on(self.surfaces[k] * s, coordinates)
            if k == j:
                continue
            if degree(own):
                guards[f"s{k}"] = own
            elif at_zero(own) < 0:
                return
        name = "".join("0" if k == j else "-.+"[signs.get(k, 0) + 1] for k in range(len(self.surfaces)))
        away = any(map(at_zero, coordinates))
        claim = Claim(f"parted {name}", dimension, [Row(ZERO - 1, guards)], True, self.bounded, away)
        need(claim.name in proofs.left, "a V that is continuous")
        proofs.show(claim)

    def is_outside(self, coordinates: Sequence[Poly]) -> bool:
        """Whether a variable is constant on a subspace, and beyond the cube."""
        return self.bounded and any(not degree(z) and abs(at_zero(z)) > 1 for z in coordinates)

    def cells_at_point(self) -> list[Cell]:
        """Those that may hold the checked point in their closure."""
        around = [[at_zero(g) * s >= 0 for g, s in zip(self.surfaces, cell.signs, strict=True)] for cell in self.cells]
        return [cell for cell, sides in zip(self.cells, around, strict=True) if all(sides)]

    def name(self, signs: Signs, kept: Sequence[int], zero: Sequence[int] = ()) -> str:
        return "".join("0" if j in zero else "-.+"[s + 1] if j in kept else "." for j, s in enumerate(signs))

    def faces(self) -> Iterator[tuple[tuple[int, ...], list[Poly], int]]:
        """The surfaces that vanish, all variables there, and the dimension."""
        need(all(degree(self.surfaces[j]) == 1 for j in self.bending), "a V that bends on lines")
        seen = set()
        for chosen in [own for size in range(1, self.count + 1) for own in combinations(self.bending, size)]:
            coordinates, dimension = solve([self.surfaces[j] for j in chosen], self.count)
            zero = tuple(j for j in self.bending if coordinates and not on(self.surfaces[j], coordinates))
            at_point = not dimension and not any(coordinates)
            if zero and zero not in seen and not self.is_outside(coordinates) and not at_point:
                yield zero, coordinates, dimension
            seen.add(zero)


def agrees(mark: Mapping[int, int], signs: Signs) -> bool:
    return all(signs[j] == s for j, s in mark.items())


def flip(signs: Signs, j: int) -> Signs:
    return (*signs[:j], -signs[j], *signs[j + 1 :])


def where_zero(base: Poly, part: Subspace) -> list[Subspace]:
    """Where a base is zero on a part: solved for the first variable that stands in one term alone, linearly."""
    coordinates, n = part
    own = on(base, coordinates)
    if not degree(own):
        return [] if own else [part]
    for k in range(n):
        (exponents, slope), *more = [(e, c) for e, c in terms(own) if e[k]] or [((), fmpq(0))]
        if sum(exponents) == 1 and not more:
            without = [GENS[i - (i > k)] for i in range(n)]
            without[k] = ZERO
            without[k] = on(own, without) * (-1 / slope)
            return [([on(z, without) for z in coordinates], n - 1)]
    raise RefusedError("a base that is solved for a variable")
