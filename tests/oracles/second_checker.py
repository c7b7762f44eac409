"""A second checker of plain systems, written from docs/specification.md alone: what a V shows, and departures.

It shares no code with the first one, and takes polynomials, common divisors and quotients from FLINT.  It knows no
roots of states, no curved surfaces on which functions bend and no theorems but these, and refuses what has them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, product
from math import prod
from typing import Any, TypeAlias

from flint import fmpq, fmpq_mat

from tests.oracles.second_formulas import (
    GENS,
    SIZE,
    ZERO,
    Claim,
    Poly,
    Proofs,
    Reading,
    RefusedError,
    Row,
    along,
    at_zero,
    degree,
    keys,
    need,
    number,
    on,
    solve,
    terms,
)

# ---- cells, functions by pieces, and faces -------------------------------------------------------

Signs: TypeAlias = tuple[int, ...]
Subspace: TypeAlias = tuple[list[Poly], int]  # all variables on it, and its dimension
Term: TypeAlias = tuple[fmpq, list[tuple[Poly, int]]]  # a factor, and bases with their powers


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
        within, listed, empty = keys(cells, "within surfaces empty", "frame coordinates")
        need(all(type(own) is list for own in (states, at, rhs, listed, empty)), "lists")
        self.count = n = len(states)
        need(1 <= n == len(set(states)) == len(at) and n < SIZE and rhs, "a system in one to eight states")
        self.z = list(GENS[:n])
        self.bounded, self.radius = within is not None, fmpq(1) if within is None else number(within)
        need(self.radius > 0, "a cube of positive size")
        self.is_framed = cells.get("frame") is not None or cells.get("coordinates") is not None
        to_states, back = self.maps(states, cells)
        units = [z * self.radius for z in self.z]
        self.away = dict(zip(states, [on(own, units) for own in to_states], strict=True))
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
            slopes = [[on(own.derivative(k), list(self.away.values())) for k in range(n)] for own in back]
            fields = [[sum((a * b for a, b in zip(row, f, strict=True)), ZERO) for row in slopes] for f in stated]
            different = [(k, f) for k, f in enumerate(fields) if f not in fields[:k]]
            self.cells.append(Cell(signs, different, [self.function_on(signs, own) for own in functions]))
        self.bending = sorted(self.bending_surfaces())
        self.parted = set(self.parted_pieces(proofs))

    def maps(self, states: Sequence[str], cells: Any) -> tuple[list[Poly], list[Poly]]:
        """From coordinates to states, and back."""
        frame, texts = cells.get("frame"), cells.get("coordinates")
        if texts is not None:
            need(frame is None and len(texts) == 2, "one pair of maps")
            reading = Reading(dict(zip(states, self.z, strict=True)))
            first, second = ([reading.value(own) for own in way] for way in texts)
        elif frame is not None:
            need(len(frame) == 2 and all(len(row) == self.count for own in frame for row in own), "two square matrices")
            first, second = (
                [sum((z * number(c) for z, c in zip(self.z, row, strict=True)), ZERO) for row in own] for own in frame
            )
        else:
            first, second = self.z, self.z
        need(len(first) == len(second) == self.count and not any(map(at_zero, first)), "maps that keep the point")
        need([on(own, first) for own in second] == self.z, "a map and its inverse")
        return first, second

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


# ---- theorems ------------------------------------------------------------------------------------

Fields: TypeAlias = list[tuple[Cell, list[Poly]]]
LYAPUNOV = "cells function second verdict everywhere level below rate"
ATTRACTS, STABLE = "asymptotically stable", "stable"


class Lyapunov:
    """The claims about V; with a level, asked below it alone, and not strictly at it if it is a border."""

    def __init__(self, inclusion: Inclusion, below: fmpq | None, proofs: Proofs, border: str = "sl") -> None:
        self.inclusion, self.below, self.proofs, self.border = inclusion, below, proofs, border
        self.kept: list[tuple[Subspace, Fields]] | None = None  # where V may be kept, if that is asked for

    def guards(self, coordinates: Sequence[Poly], signs: Mapping[int, int], v: Poly) -> dict[str, Poly] | None:
        """None where one of them is a negative number, or V is never below the level."""
        found = self.inclusion.cube(coordinates)
        named = {f"s{j}": on(self.inclusion.surfaces[j], coordinates) * s for j, s in signs.items()}
        for name, guard in named.items():
            if degree(guard):
                found[name] = guard
            elif at_zero(guard) < 0:
                return None
        room = ZERO if self.below is None else self.below - on(v, coordinates)
        if degree(room):
            found["sl"] = room
        return None if self.below is not None and not degree(room) and at_zero(room) <= 0 else found

    def show(self, name: str, n: int, rows: list[Row], *, strict: bool, at_origin: bool = False) -> None:
        border = "" if self.below is None else self.border
        self.proofs.show(Claim(name, n, rows, strict, self.inclusion.bounded, at_origin, border))

    def show_positive(self) -> None:
        for name, signs, v in self.pieces():
            guards = self.guards(self.inclusion.z, signs, v) or {}
            self.show(f"V {name}", self.inclusion.count, [Row(v, guards, open=guards)], strict=True)

    def show_zero(self) -> None:
        own = self.inclusion
        need(all(not at_zero(cell.v) for cell in own.cells_at_point()), "V(0) = 0")

    def pieces(self) -> Iterator[tuple[str, dict[int, int], Poly]]:
        own = self.inclusion
        found = {own.name(cell.signs, own.bending): cell for cell in reversed(own.cells)}
        for name, cell in found.items():
            yield name, {j: cell.signs[j] for j in own.bending}, cell.v

    def show_falls(self, prefix: str, shift: Callable[[Poly], Poly], *, strict: bool, gain: bool = False) -> None:
        own = self.inclusion
        for cell in own.cells:
            guards = self.guards(own.z, dict(enumerate(cell.signs)), cell.v) or {}
            for k, f in cell.fields:
                name = f"{prefix}cell {own.name(cell.signs, range(len(cell.signs)))} field {k}"
                row = Row(-(along(cell.v, f) + shift(cell.v)), guards, open=guards)
                self.show(name, own.count, [row], strict=strict)
        for name, cells, zero, (coordinates, n) in self.groups():
            need(not gain or len(zero) == 1, "a V that bends on one surface at a time")
            rows = list(self.rows(cells, zero, coordinates, shift))
            if rows:
                away = any(map(at_zero, coordinates))
                self.show(f"{prefix}face {name}", n, rows, strict=strict, at_origin=away)

    def groups(self) -> Iterator[tuple[str, list[Cell], tuple[int, ...], Subspace]]:
        """The groups of cells beside faces that are not settled, with the surfaces that vanish there."""
        own = self.inclusion
        for zero, coordinates, n in own.faces():
            groups: dict[str, list[Cell]] = {}
            for cell in own.cells:
                groups.setdefault(own.name(cell.signs, own.bending, zero), []).append(cell)
            for name, cells in self.parts(groups):
                if not is_settled(cells, coordinates):
                    yield name, cells, zero, (coordinates, n)

    def parts(self, groups: dict[str, list[Cell]]) -> Iterator[tuple[str, list[Cell]]]:
        own = self.inclusion
        for name, cells in groups.items():
            found = list(joined({own.piece(cell) for cell in cells}, own.parted))
            for k, part in enumerate(found):
                yield (
                    f"{name} part {k}" if len(found) > 1 else name,
                    [cell for cell in cells if own.piece(cell) in part],
                )

    def rows(
        self, cells: Sequence[Cell], zero: Sequence[int], coordinates: Sequence[Poly], shift: Callable[[Poly], Poly]
    ) -> Iterator[Row]:
        first = cells[0].v
        for cell in cells:
            guards = self.guards(coordinates, {j: s for j, s in enumerate(cell.signs) if j not in zero}, first)
            side = tuple(cell.signs[j] for j in zero)
            for _, f in cell.fields if guards is not None else ():
                value = on(along(first, f) + shift(first), coordinates)
                pushes = [-on(along(self.inclusion.surfaces[j], f), coordinates) for j in zero]
                yield Row(-value, guards or {}, pushes, side)

    def show_fall(self, second: Any, *, strict: bool) -> None:
        """V falls, by itself or by the steps of further functions."""
        if second is None:
            self.show_falls("", lambda v: ZERO, strict=strict)
        else:
            self.show_further(second)

    def show_further(self, second: Any) -> None:
        """V does not rise, and on what solutions tend to a further function says where they go."""
        own, zeros = self.inclusion, keys(second, "functions zeros")[1]
        for cell in own.cells:
            for k, f in cell.fields:
                name = f"cell {own.name(cell.signs, range(len(cell.signs)))} field {k}"
                self.show_steps(name, [(cell, f)], (), (own.z, own.count), zeros)
        for name, cells, zero, part in self.groups():
            fields = [(cell, f) for cell in cells for _, f in cell.fields]
            self.show_steps(f"face {name}", fields, zero, part, zeros)

    def show_steps(
        self, name: str, fields: Fields, zero: Sequence[int], part: Subspace, zeros: Any, path: tuple[int, ...] = ()
    ) -> None:
        """The claim of a step on a part of a closed cell or a face, and those after it where its bound is zero."""
        (coordinates, n), own, cells = part, self.inclusion, [cell for cell, _ in fields]
        if self.kept is not None and path:
            self.kept.append((part, fields))
            return
        need(len(path) < len(cells[0].functions), "a further function")
        full = f"{name} then {'.'.join(map(str, path))}" if path else name
        bound = [own.bound_term(cells, term) for term in zeros[full]] if full in zeros else []
        least = sum((prod((on(h, coordinates) ** m for h, m in powers), start=ZERO + c) for c, powers in bound), ZERO)
        rows = []
        for cell, f in fields:
            guards = self.guards(coordinates, {j: s for j, s in enumerate(cell.signs) if j not in zero}, cells[0].v)
            if guards is None:
                continue
            rates = [on(along(w, f), coordinates) * (1 if k else -1) for k, w in enumerate(cells[0].functions)]
            earlier, q = rates[: len(path)], [on(along(own.surfaces[j], f), coordinates) for j in zero]
            if len(zero) > 1:
                q += earlier
            else:
                guards |= {f"sv{k}": -rate for k, rate in enumerate(earlier) if degree(rate)}
            opened = guards if not zero and n == own.count else {}
            side = tuple(cell.signs[j] for j in zero)
            rows.append(Row(rates[len(path)] - least, guards, q, side, opened, earlier))
        if rows:
            away = any(map(at_zero, coordinates))
            self.show(full, n, rows, strict=full not in zeros, at_origin=full not in zeros and away)
            for k, smaller in enumerate(own.zeros_of(bound, part) if full in zeros else []):
                self.show_steps(name, fields, zero, smaller, zeros, (*path, k))

    def show_gradient(self, bound: fmpq) -> None:
        for name, signs, v in self.pieces():
            guards = self.guards(self.inclusion.z, signs, v) or {}
            square = sum((v.derivative(k) ** 2 for k in range(self.inclusion.count)), ZERO)
            self.show(
                f"gradient {name}",
                self.inclusion.count,
                [Row(bound * bound - square, guards, open=guards)],
                strict=False,
            )

    def show_border(self, level: fmpq) -> None:
        for name, signs, v in self.pieces():
            for k, side in product(range(self.inclusion.count), (1, -1)):
                coordinates = list(GENS[: self.inclusion.count - 1])
                coordinates.insert(k, ZERO + side)
                guards = Lyapunov(self.inclusion, None, self.proofs).guards(coordinates, signs, v)
                if guards is not None:
                    row = Row(on(v, coordinates) - level, guards)
                    self.proofs.show(
                        Claim(f"border {name} {'-.+'[side + 1]}{k}", self.inclusion.count - 1, [row], strict=False)
                    )


def joined(patterns: set[Signs], parted: set[frozenset[Signs]]) -> Iterator[set[Signs]]:
    left = set(patterns)
    while left:
        part, before = {min(left)}, set[Signs]()
        while part != before:
            before = set(part)
            steps = {(a, b) for a in before for k in range(len(a)) if (b := flip(a, k)) in left}
            part |= {b for a, b in steps if frozenset((a, b)) not in parted}
        left -= part
        yield part


def is_settled(cells: Sequence[Cell], coordinates: Sequence[Poly]) -> bool:
    fields = [{tuple(str(on(p, coordinates)) for p in f) for _, f in cell.fields} for cell in cells]
    return all(cell.functions == cells[0].functions for cell in cells) or all(own == fields[0] for own in fields)


def statements(subject: Any, entry: Any) -> list[Any]:
    """What an entry of the evidence shows."""
    theorem, hypotheses, evidence = keys(entry, "theorem hypotheses proofs")
    if theorem == "instability":
        return instability(subject, hypotheses, evidence)
    if theorem == "departure":
        return departure(subject, hypotheses, evidence)
    if theorem == "approach":
        return approach(subject, hypotheses, evidence)
    need(theorem == "lyapunov", "theorem lyapunov, instability, departure or approach")
    cells, function, second, verdict, everywhere, level, below, rate = keys(hypotheses, LYAPUNOV, "gain")
    gain = hypotheses.get("gain")
    need(verdict in (ATTRACTS, STABLE), "a verdict")
    need(type(everywhere) is type(below) is bool, "everywhere and below as true or false")
    proofs = Proofs(evidence)
    inclusion = Inclusion(subject, cells, [function, *further(second)], proofs)
    alone = second is None and level is None and rate is None and everywhere is False
    need(alone or not inclusion.is_framed, "a verdict alone in a frame")
    own = Lyapunov(inclusion, number(level) if below else None, proofs)
    own.show_zero()
    own.show_positive()
    own.show_fall(second, strict=verdict == ATTRACTS)
    need(second is None or not everywhere, "a V alone for the whole space")
    shown: list[Any] = [{"stability": verdict}]
    about = {"function": function, "within": cells["within"]}
    about |= {} if type(function) is str else {"surfaces": cells["surfaces"]}
    if everywhere:
        cones = all(degree(g) == 1 and not at_zero(g) for g in inclusion.surfaces)
        need(cones and proofs.are_forms and not below and verdict == ATTRACTS, "forms on cones")
        shown.append({"attracts": "everywhere"})
    if level is not None:
        need(inclusion.bounded and number(level) > 0 and verdict == ATTRACTS, "a level on a cube")
        own.show_border(number(level))
        shown.append({"attracts": {**about, "below": level}})
    if rate is not None:
        kind, kappa = keys(rate, "kind kappa")
        speed = number(kappa) * inclusion.radius
        need(speed > 0 and kind in ("exponential", "finite", "algebraic"), "a rate")

        def shift(v: Poly) -> Poly:
            return {"finite": ZERO + speed, "exponential": v * speed, "algebraic": v * v * speed}[kind]

        own.show_falls("rate ", shift, strict=False, gain=gain is not None)
        shown.append({"rate": {**about, **rate, **({"below": level} if below else {})}})
        if gain is not None:
            need(number(gain) > 0, "a positive gain")
            own.show_gradient(number(gain) * inclusion.radius)
            shown.append({"gain": {**shown[-1]["rate"], "gamma": gain}})
    need(not proofs.left, "proofs that are asked for")
    return shown


def instability(subject: Any, hypotheses: Any, evidence: Any) -> list[Any]:
    """V falls where it is not positive, and is negative in a direction, inside a cell."""
    cells, function, second, direction = keys(hypotheses, "cells function second direction")
    need(cells["within"] is not None and len(direction) == len(subject["states"]), "a cube and a direction")
    proofs, ray = Proofs(evidence), [number(x) for x in direction]
    inclusion = Inclusion(subject, cells, [function, *further(second)], proofs)
    own = Lyapunov(inclusion, fmpq(0), proofs, border="")
    own.show_zero()
    own.show_fall(second, strict=True)
    inside = [
        cell
        for cell in inclusion.cells
        if all(sign_along(g, ray) * s > 0 for g, s in zip(inclusion.surfaces, cell.signs, strict=True))
    ]
    need(any(sign_along(cell.v, ray) < 0 for cell in inside), "a V that is negative in the direction")
    need(not proofs.left, "proofs that are asked for")
    return [{"stability": "unstable"}]


def further(second: Any) -> list[Any]:
    """Further functions, at most four."""
    functions = [] if second is None else keys(second, "functions zeros")[0]
    need(type(functions) is list and len(functions) <= 4, "at most four further functions")
    return functions


def departure(subject: Any, hypotheses: Any, evidence: Any) -> list[Any]:
    """All fields at the point have a positive part in a direction."""
    cells, direction = keys(hypotheses, "cells direction")
    proofs, n = Proofs(evidence), [number(x) for x in direction]
    inclusion = Inclusion(subject, cells, ["0"], proofs)
    need(not {"frame", "coordinates"} & set(cells), "the states themselves")
    fields = [f for cell in inclusion.cells_at_point() for _, f in cell.fields]
    need(all(sum(x * at_zero(p) for x, p in zip(n, f, strict=True)) > 0 for f in fields), "fields in a direction")
    need(not proofs.left, "proofs that are asked for")
    return [{"stability": "unstable"}, {"equilibrium": False}]


def approach(subject: Any, hypotheses: Any, evidence: Any) -> list[Any]:
    """Where V may be kept the span of all velocities holds no direction along the place."""
    cells, function, zeros, level, proper = keys(hypotheses, "cells function zeros level proper")
    need(type(function) is str and proper is None, "V as one formula, on a cube")
    proofs = Proofs(evidence)
    inclusion = Inclusion(subject, cells, [function], proofs)
    need(inclusion.bounded and not inclusion.is_framed, "a cube of the states")
    own, span = Lyapunov(inclusion, None, proofs), list[list[fmpq]]()
    own.kept = []
    own.show_zero()
    own.show_positive()
    own.show_further({"functions": [], "zeros": zeros})
    for (coordinates, _), fields in own.kept:
        need(all(degree(p) <= 1 for p in coordinates), "flat places")
        for _, f in fields:
            parts = [on(p, coordinates).to_dict() for p in f]
            span += [[part.get(e, fmpq(0)) for part in parts] for e in {e for part in parts for e in part}]
    for (coordinates, n), _ in own.kept:
        directions = [[at_zero(p.derivative(i)) for p in coordinates] for i in range(n)]
        need(rank(span + directions) == rank(span) + n, "no velocity along a place")
    shown: list[Any] = [{"stability": STABLE}, {"approaches": "near"}]
    if level is not None:
        need(number(level) > 0, "a positive level")
        own.show_border(number(level))
        shown.append({"approaches": {"function": function, "within": cells["within"], "below": level}})
    need(not proofs.left, "proofs that are asked for")
    return shown


def rank(rows: list[list[fmpq]]) -> int:
    return int(fmpq_mat(rows).rank()) if rows else 0


def sign_along(p: Poly, ray: Sequence[fmpq]) -> int:
    """The sign at all small distances along a ray."""
    along_ray = on(p, [GENS[0] * x for x in ray])
    lowest = min(terms(along_ray), default=((), fmpq(0)))[1]
    return (lowest > 0) - (lowest < 0)


def refusal(certificate: Any) -> str:
    """Why a certificate is refused; empty where it is valid."""
    try:
        version, statement, evidence = keys(certificate, "version statement evidence", "notes")
        subject, claims = keys(statement, "subject claims")
        need(version == "nonsmooth-certificate/2" and claims, "the version, and a claim")
        shown = [own for entry in evidence for own in statements(subject, entry)]
        need(all(claim in shown for claim in claims), "claims that are shown")
    except (RefusedError, KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        return str(error) or type(error).__name__
    return ""
