"""Families of functions whose sums are proposed as V in many states, from simple to rich.

Quadratic forms; ``Abs(l)`` of hyperplanes l through the point on which the field jumps; products of these with states
and with each other (continuous piecewise quadratics, after Johansson and Rantzer 1998); ``relu(s)**2`` of surfaces
beside the point; monomials of degree four.  Each is continuous, so a sum is whatever its coefficients are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, combinations_with_replacement

from flint import fmpq

from nonsmooth.proofs.kernel.sign_cells import SignCells, rational_terms
from nonsmooth.proofs.kernel.written import as_checked
from nonsmooth.symbolic.numbers.polynomial import Polynomial


@dataclass(frozen=True)
class PiecewiseFunction:
    """A continuous function of the displacement.

    Attributes:
        text: as a formula of the states.
        degree: of its growth near the point.
    """

    text: str
    degree: int


def families(cells: SignCells) -> Iterator[tuple[PiecewiseFunction, ...]]:
    """Bases to try in turn."""
    states = cells.states
    quadratic = _monomials(states, 2)
    lines = [s for s in cells.surfaces if s.degree == 1 and s.is_homogeneous]
    jumps = [s for s in lines if field_jumps(cells, s)]
    first = tuple(PiecewiseFunction(_abs(line), 1) for line in jumps)
    second = [PiecewiseFunction(f"{state}*{_abs(line)}", 2) for line in lines for state in states]
    second += [PiecewiseFunction(f"{_abs(a)}*{_abs(b)}", 2) for a, b in combinations(lines, 2)]
    beside = tuple(_beyond(s) for s in cells.surfaces if s.degree == 1 and not s.is_homogeneous)
    yield quadratic
    if first:
        yield (*first, *quadratic)
    if second or beside:
        yield (*first, *quadratic, *second, *beside)
    if _degree(cells) > 1:
        yield (*first, *quadratic, *_monomials(states, 4))


def formula_text(functions: Sequence[PiecewiseFunction], coefficients: Sequence[fmpq]) -> str:
    """The sum, functions of low degree first."""
    used = [(c, f) for c, f in zip(coefficients, functions, strict=True) if c]
    used.sort(key=lambda term: term[1].degree)
    return " + ".join(_term(c, f.text) for c, f in used).replace("+ -", "- ") or "0"


def _term(coefficient: fmpq, text: str) -> str:
    top, bottom = int(coefficient.p), int(coefficient.q)
    factor = {1: "", -1: "-"}.get(top, f"{top}*")
    return f"{factor}{text}" + (f"/{bottom}" if bottom != 1 else "")


def _monomials(states: Sequence[str], degree: int) -> tuple[PiecewiseFunction, ...]:
    found = []
    for chosen in combinations_with_replacement(states, degree):
        powers = {name: chosen.count(name) for name in chosen}
        text = "*".join(name if k == 1 else f"{name}**{k}" for name, k in powers.items())
        found.append(PiecewiseFunction(text, degree))
    return tuple(found)


def _abs(line: Polynomial) -> str:
    return f"Abs({line})"


def _beyond(surface: Polynomial) -> PiecewiseFunction:
    """``relu(s)**2``, with the sign for which it vanishes near the point."""
    at_point = surface.terms[(0,) * len(surface.variables)]
    return PiecewiseFunction(f"relu({surface if at_point.sign() < 0 else -surface})**2", 2)


def _degree(cells: SignCells) -> int:
    return max((sum(e) for cell in cells.cells for field in cell.velocities for p in field for e in p), default=0)


def field_jumps(cells: SignCells, surface: Polynomial) -> bool:
    """Whether the field differs on the two sides of a hyperplane."""
    j, count = cells.surfaces.index(surface), len(cells.states)
    plane = as_checked(rational_terms(surface), count)
    by_signs = {cell.signs: cell.velocities for cell in cells.cells}
    for signs, own in by_signs.items():
        other = by_signs.get((*signs[:j], -signs[j], *signs[j + 1 :]), own)
        for first, second in zip(own, other, strict=True):
            gaps = (as_checked(a, count) - as_checked(b, count) for a, b in zip(first, second, strict=True))
            if any(gap.divided(plane) is None for gap in gaps):
                return True
    return False
