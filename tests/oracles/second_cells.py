"""Cells, functions by pieces and faces of a system in two states, by docs/specification.md: for the second checker."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, product
from typing import Any, TypeAlias

from flint import fmpq

from tests.oracles.second_evidence import Claim, Proofs, Row
from tests.oracles.second_formulas import GENS, ZERO, Poly, Reading, degree, keys, need, number, on, solve, terms

Signs: TypeAlias = tuple[int, ...]


Matrix: TypeAlias = list[list[fmpq]]


def unit_matrix() -> Matrix:
    return [[fmpq(1), fmpq(0)], [fmpq(0), fmpq(1)]]


def matrix_product(a: Matrix, b: Matrix) -> Matrix:
    return [[sum((a[i][k] * b[k][j] for k in range(2)), fmpq(0)) for j in range(2)] for i in range(2)]


def times(matrix: Matrix, vector: Sequence[Poly]) -> list[Poly]:
    return [vector[0] * row[0] + vector[1] * row[1] for row in matrix]


@dataclass(frozen=True)
class Cell:
    signs: Signs
    fields: list[tuple[int, list[Poly]]]
    v: Poly


class Inclusion:
    """The cells of a system in two states, with V on each."""

    def __init__(self, subject: Any, cells: Any, function: Any, proofs: Proofs) -> None:
        states, rhs, at = keys(subject, "states rhs at", "order")
        order = subject.get("order", 0)
        need(type(order) is int and 0 <= order <= 4, "further terms of sines and cosines")
        within, listed, empty = keys(cells, "within surfaces empty", "frame")
        need(all(type(own) is list for own in (states, at, rhs, listed, empty)), "lists")
        need(len(states) == len(at) == 2 and states[0] != states[1] and rhs, "a system in two states")
        self.bounded, self.radius = within is not None, fmpq(1) if within is None else number(within)
        need(self.radius > 0, "a cube of positive size")
        self.frame = [unit_matrix(), unit_matrix()]
        if cells.get("frame") is not None:
            self.frame = [[[number(c) for c in row] for row in own] for own in cells["frame"]]
            need(all(len(own) == 2 and all(len(row) == 2 for row in own) for own in self.frame), "square matrices")
        need(len(self.frame) == 2 and matrix_product(*self.frame) == unit_matrix(), "a matrix and its inverse")
        units = [GENS[k] * self.radius for k in range(2)]
        away = dict(zip(states, times(self.frame[0], units), strict=True))
        place = {name: z + number(x) for (name, z), x in zip(away.items(), at, strict=True)}
        self.surfaces = [Reading(away).value(own) for own in listed]
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
            need(all(len(own) == 2 for own in stated), "two formulas in every right-hand side")
            fields = [times(self.frame[1], field) for field in stated]
            different = [(k, f) for k, f in enumerate(fields) if f not in fields[:k]]
            self.cells.append(Cell(signs, different, self.function_on(signs, function, away)))
        self.bending = sorted(self.bending_surfaces())
        self.parted = set(self.parted_pieces(proofs))

    def marked(self, mark: str) -> dict[int, int]:
        need(len(mark) == len(self.surfaces) and set(mark) <= set("+-."), "a pattern")
        return {j: 1 if sign == "+" else -1 for j, sign in enumerate(mark) if sign != "."}

    def show_empty(self, signs: dict[int, int], proofs: Proofs, name: str) -> None:
        last = max(signs)
        guards = {f"s{j}": self.surfaces[j] * s for j, s in signs.items() if j != last}
        guards |= self.cube(GENS[:2])
        row = Row(-self.surfaces[last] * signs[last], guards, open=guards)
        proofs.show(Claim(name, 2, [row], strict=False, bounded=self.bounded))

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

    def function_on(self, signs: Signs, function: Any, away: Mapping[str, Poly]) -> Poly:
        pieces = [["." * len(signs), function]] if type(function) is str else function
        own = [text for mark, text in pieces if agrees(self.marked(mark), signs)]
        values = [Reading(away, partial(self.sign_on, signs)).value(text) for text in own]
        need(values and all(v == values[0] for v in values), "one polynomial of V on every cell")
        return values[0]

    def bending_surfaces(self) -> set[int]:
        by_signs = {cell.signs: cell.v for cell in self.cells}
        found = {j for s, v in by_signs.items() for j in range(len(s)) if by_signs.get(flip(s, j), v) != v}
        return found

    def piece(self, cell: Cell) -> Signs:
        return tuple(cell.signs[j] for j in self.bending)

    def parted_pieces(self, proofs: Proofs) -> Iterator[frozenset[Signs]]:
        pieces: dict[Signs, Poly] = {}
        for cell in self.cells:
            need(pieces.setdefault(self.piece(cell), cell.v) == cell.v, "a V that bends on its surfaces alone")
        for signs, v in pieces.items():
            for i, j in enumerate(self.bending):
                gap = v - pieces.get(flip(signs, i), v)
                if signs[i] > 0 and divmod(gap, self.surfaces[j])[1]:
                    self.show_parted(j, dict(zip(self.bending, signs, strict=True)), proofs)
                    yield frozenset((signs, flip(signs, i)))

    def show_parted(self, j: int, signs: Mapping[int, int], proofs: Proofs) -> None:
        need(degree(self.surfaces[j]) == 1, "a V that bends on lines")
        coordinates, dimension = solve([self.surfaces[j]])
        if self.bounded and any(not degree(z) and abs(z(0, 0, 0)) > 1 for z in coordinates):
            return
        guards = self.cube(coordinates)
        for k, s in signs.items():
            own = on(self.surfaces[k] * s, coordinates)
            if k == j:
                continue
            if degree(own):
                guards[f"s{k}"] = own
            elif own(0, 0, 0) < 0:
                return
        name = "".join("0" if k == j else "-.+"[signs.get(k, 0) + 1] for k in range(len(self.surfaces)))
        away = any(z(0, 0, 0) for z in coordinates)
        claim = Claim(f"parted {name}", dimension, [Row(ZERO - 1, guards)], True, self.bounded, away)
        need(claim.name in proofs.left, "a V that is continuous")
        proofs.show(claim)

    def name(self, signs: Signs, kept: Sequence[int], zero: Sequence[int] = ()) -> str:
        return "".join("0" if j in zero else "-.+"[s + 1] if j in kept else "." for j, s in enumerate(signs))

    def faces(self) -> Iterator[tuple[tuple[int, ...], list[Poly], int]]:
        """The surfaces that vanish, both variables there, and the dimension."""
        need(all(degree(self.surfaces[j]) == 1 for j in self.bending), "a V that bends on lines")
        seen = set()
        for chosen in [own for size in (1, 2) for own in combinations(self.bending, size)]:
            coordinates, dimension = solve([self.surfaces[j] for j in chosen])
            zero = tuple(j for j in self.bending if coordinates and not on(self.surfaces[j], coordinates))
            beyond = self.bounded and any(not degree(z) and abs(z(0, 0, 0)) > 1 for z in coordinates)
            at_point = not dimension and not any(coordinates)
            if zero and zero not in seen and not beyond and not at_point:
                yield zero, coordinates, dimension
            seen.add(zero)


def agrees(mark: Mapping[int, int], signs: Signs) -> bool:
    return all(signs[j] == s for j, s in mark.items())


def flip(signs: Signs, j: int) -> Signs:
    return (*signs[:j], -signs[j], *signs[j + 1 :])
