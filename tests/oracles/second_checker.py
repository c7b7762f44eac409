"""A second checker of plain systems in two states, written from docs/specification.md alone: what a V shows.

It shares no code with the first one, and takes polynomials, common divisors and quotients from FLINT.  It knows no
roots of states, no further functions and no curved surfaces on which V bends, and refuses what has them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any

from flint import fmpq

from tests.oracles.second_cells import Cell, Inclusion, Signs, flip
from tests.oracles.second_evidence import Claim, Proofs, Row
from tests.oracles.second_formulas import (
    GENS,
    ZERO,
    Poly,
    RefusedError,
    along,
    degree,
    keys,
    need,
    number,
    on,
    terms,
)

LYAPUNOV = "cells function second verdict everywhere level below rate"
ATTRACTS, STABLE = "asymptotically stable", "stable"


class Lyapunov:
    """The claims about V; with a level, asked below it alone, and not strictly at it if it is a border."""

    def __init__(self, inclusion: Inclusion, below: fmpq | None, proofs: Proofs, border: str = "sl") -> None:
        self.inclusion, self.below, self.proofs, self.border = inclusion, below, proofs, border

    def guards(self, coordinates: Sequence[Poly], signs: Mapping[int, int], v: Poly) -> dict[str, Poly] | None:
        """None where one of them is a negative number, or V is never below the level."""
        found = self.inclusion.cube(coordinates)
        named = {f"s{j}": on(self.inclusion.surfaces[j], coordinates) * s for j, s in signs.items()}
        for name, guard in named.items():
            if degree(guard):
                found[name] = guard
            elif guard(0, 0, 0) < 0:
                return None
        room = ZERO if self.below is None else self.below - on(v, coordinates)
        if degree(room):
            found["sl"] = room
        return None if self.below is not None and not degree(room) and room(0, 0, 0) <= 0 else found

    def show(self, name: str, n: int, rows: list[Row], *, strict: bool, at_origin: bool = False) -> None:
        border = "" if self.below is None else self.border
        self.proofs.show(Claim(name, n, rows, strict, self.inclusion.bounded, at_origin, border))

    def show_positive(self) -> None:
        for name, signs, v in self.pieces():
            guards = self.guards(GENS[:2], signs, v) or {}
            self.show(f"V {name}", 2, [Row(v, guards, open=guards)], strict=True)

    def show_zero(self) -> None:
        own = self.inclusion
        around = [
            cell
            for cell in own.cells
            if all(g(0, 0, 0) * s >= 0 for g, s in zip(own.surfaces, cell.signs, strict=True))
        ]
        need(all(not cell.v(0, 0, 0) for cell in around), "V(0) = 0")

    def pieces(self) -> Iterator[tuple[str, dict[int, int], Poly]]:
        own = self.inclusion
        found = {own.name(cell.signs, own.bending): cell for cell in reversed(own.cells)}
        for name, cell in found.items():
            yield name, {j: cell.signs[j] for j in own.bending}, cell.v

    def show_falls(self, prefix: str, shift: Callable[[Poly], Poly], *, strict: bool, gain: bool = False) -> None:
        own = self.inclusion
        for cell in own.cells:
            guards = self.guards(GENS[:2], dict(enumerate(cell.signs)), cell.v) or {}
            for k, f in cell.fields:
                name = f"{prefix}cell {own.name(cell.signs, range(len(cell.signs)))} field {k}"
                row = Row(-(along(cell.v, f) + shift(cell.v)), guards, open=guards)
                self.show(name, 2, [row], strict=strict)
        for zero, coordinates, n in own.faces():
            groups: dict[str, list[Cell]] = {}
            for cell in own.cells:
                groups.setdefault(own.name(cell.signs, own.bending, zero), []).append(cell)
            for name, cells in self.parts(groups):
                if not is_settled(cells, coordinates):
                    need(not gain or len(zero) == 1, "a V that bends on one surface at a time")
                    rows = list(self.rows(cells, zero, coordinates, shift))
                    if rows:
                        self.show(
                            f"{prefix}face {name}",
                            n,
                            rows,
                            strict=strict,
                            at_origin=any(z(0, 0, 0) for z in coordinates),
                        )

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

    def show_gradient(self, bound: fmpq) -> None:
        for name, signs, v in self.pieces():
            guards = self.guards(GENS[:2], signs, v) or {}
            square = v.derivative(0) ** 2 + v.derivative(1) ** 2
            self.show(f"gradient {name}", 2, [Row(bound * bound - square, guards, open=guards)], strict=False)

    def show_border(self, level: fmpq) -> None:
        for name, signs, v in self.pieces():
            for k, side in product((0, 1), (1, -1)):
                coordinates = [ZERO + side, GENS[0]] if k == 0 else [GENS[0], ZERO + side]
                guards = Lyapunov(self.inclusion, None, self.proofs).guards(coordinates, signs, v)
                if guards is not None:
                    row = Row(on(v, coordinates) - level, guards)
                    self.proofs.show(Claim(f"border {name} {'-.+'[side + 1]}{k}", 1, [row], strict=False))


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
    return all(cell.v == cells[0].v for cell in cells) or all(own == fields[0] for own in fields)


def statements(subject: Any, entry: Any) -> list[Any]:
    """What an entry of the evidence shows."""
    theorem, hypotheses, evidence = keys(entry, "theorem hypotheses proofs")
    if theorem == "instability":
        return instability(subject, hypotheses, evidence)
    need(theorem == "lyapunov", "theorem lyapunov or instability")
    cells, function, second, verdict, everywhere, level, below, rate = keys(hypotheses, LYAPUNOV, "gain")
    gain = hypotheses.get("gain")
    need(second is None and verdict in (ATTRACTS, STABLE), "a verdict by V alone")
    need(type(everywhere) is type(below) is bool, "everywhere and below as true or false")
    proofs = Proofs(evidence)
    inclusion = Inclusion(subject, cells, function, proofs)
    alone = second is None and level is None and rate is None and everywhere is False
    need(cells.get("frame") is None or alone, "a verdict alone in a frame")
    own = Lyapunov(inclusion, number(level) if below else None, proofs)
    own.show_zero()
    own.show_positive()
    own.show_falls("", lambda v: ZERO, strict=verdict == ATTRACTS)
    shown: list[Any] = [{"stability": verdict}]
    about = {"function": function, "within": cells["within"]}
    about |= {} if type(function) is str else {"surfaces": cells["surfaces"]}
    if everywhere:
        cones = all(degree(g) == 1 and not g(0, 0, 0) for g in inclusion.surfaces)
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
    need(second is None and cells["within"] is not None and len(direction) == 2, "V alone, a cube and a direction")
    proofs, ray = Proofs(evidence), [number(x) for x in direction]
    inclusion = Inclusion(subject, cells, function, proofs)
    own = Lyapunov(inclusion, fmpq(0), proofs, border="")
    own.show_zero()
    own.show_falls("", lambda v: ZERO, strict=True)
    inside = [
        cell
        for cell in inclusion.cells
        if all(sign_along(g, ray) * s > 0 for g, s in zip(inclusion.surfaces, cell.signs, strict=True))
    ]
    need(any(sign_along(cell.v, ray) < 0 for cell in inside), "a V that is negative in the direction")
    need(not proofs.left, "proofs that are asked for")
    return [{"stability": "unstable"}]


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
