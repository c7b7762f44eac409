"""What a V is searched from, in any number of states: functions, and linear conditions on their coefficients.

*Functions* from simple to rich: quadratic forms; ``Abs(l)`` of hyperplanes l through the point on which the field
jumps; products of these with states and with each other (continuous piecewise quadratics, after Johansson and Rantzer
1998); ``relu(s)**2`` of surfaces beside the point; monomials of degree four; where that is asked for, ``Abs(l)`` of all
hyperplanes.  Each is continuous, so a sum is whatever its coefficients are.

*Conditions.*  For ``V = sum_k c_k phi_k`` the value of V at a point, and its rate along an extreme velocity of the
solutions there, are linear in c: on cells along the fields, and where functions bend also along their mixtures that
slide.  Floats: nothing here proves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, combinations_with_replacement
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq

from nonsmooth.proofs.checker.cells import Face, whole_domain
from nonsmooth.proofs.checker.polynomials import Polynomial as CheckedPolynomial
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.work import MALFORMED, RejectedError
from nonsmooth.proofs.kernel.cells import BeyondReachError, SignCells, StatedCells
from nonsmooth.proofs.kernel.search import Functions, Search
from nonsmooth.proofs.kernel.second_function import points_of, sampled, slopes_along
from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.proofs.sums_of_squares.ansatz import monomials_of
from nonsmooth.symbolic.numbers.plane_arrays import Floats, distinct_rows
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS, Exponents, Polynomial, float_values, written_powers
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

FAINT = 2.0**-33  # a rate, in units of the cube: places are rounded to twelve digits

LookedAt: TypeAlias = Callable[[Face], Floats]  # coordinates of points of a place


@dataclass(frozen=True)
class PiecewiseFunction:
    """A continuous function of the displacement.

    Attributes:
        text: as a formula of the states.
        degree: of its growth near the point.
    """

    text: str
    degree: int


def families(cells: SignCells, *, all_lines: bool = False) -> Iterator[tuple[PiecewiseFunction, ...]]:
    """Bases to try in turn.

    Args:
        cells: of the system.
        all_lines: whether terms of first order are tried in the end that bend where the field does not jump.
    """
    states = cells.states
    quadratic = monomials(states, 2)
    lines = [s for s in cells.surfaces if s.degree == 1 and s.is_homogeneous]
    first = tuple(bent(line) for line in lines if field_jumps(cells, line))
    second = [*_with_states(states, lines), *(_product(a, b) for a, b in combinations(lines, 2))]
    beside = tuple(_beyond(s) for s in cells.surfaces if s.degree == 1 and not s.is_homogeneous)
    yield quadratic
    if first:
        yield (*first, *quadratic)
    if second or beside:
        yield (*first, *quadratic, *second, *beside)
    if _degree(cells) > 1:
        yield (*first, *quadratic, *monomials(states, 4))
    if all_lines and len(first) < len(lines):
        yield (*map(bent, lines), *quadratic, *second)


def piecewise_quadratics(states: Sequence[str], lines: Sequence[Polynomial]) -> tuple[PiecewiseFunction, ...]:
    """Functions whose sums are all continuous functions that are quadratic between lines through the point.

    Args:
        states: two.
        lines: in the order of their directions.
    """
    count = len(lines)
    beside = (
        (i, j) for i, j in combinations(range(count), 2) if {j - i, i - j + count} & {1, 2}
    )  # products of others are sums of these
    products = (_product(lines[i], lines[j]) for i, j in beside)
    return (*monomials(states, 2), *_with_states(states, lines), *products)


def _with_states(states: Sequence[str], lines: Sequence[Polynomial]) -> list[PiecewiseFunction]:
    return [PiecewiseFunction(f"{state}*{bent(line).text}", 2) for line in lines for state in states]


def _product(first: Polynomial, second: Polynomial) -> PiecewiseFunction:
    return PiecewiseFunction(f"{bent(first).text}*{bent(second).text}", 2)


def formula_text(functions: Sequence[PiecewiseFunction], coefficients: Sequence[fmpq | Fraction]) -> str:
    """The sum, functions of low degree first."""
    used = [(c, f) for c, f in zip(coefficients, functions, strict=True) if c]
    used.sort(key=lambda term: term[1].degree)
    return " + ".join(_term_text(c, f.text) for c, f in used).replace("+ -", "- ") or "0"


def _term_text(coefficient: fmpq | Fraction, function: str) -> str:
    """``9*x*y/11`` for a coefficient and a function."""
    top, slash, bottom = str(coefficient).partition("/")
    factor = {"1": "", "-1": "-"}.get(top, f"{top}*")
    return f"{factor}{function}{slash}{bottom}"


def quadratic_text(doubled: Sequence[Sequence[Any]], states: Sequence[str]) -> str:
    """``x^T P x`` as a formula, by the entries of 2 P: numbers of flint, or whole ones."""
    pairs = combinations_with_replacement(range(len(states)), 2)
    return formula_text(monomials(states, 2), [fmpq(doubled[i][j]) / (2 if i == j else 1) for i, j in pairs])


def monomial(states: Sequence[str], exponents: Exponents) -> PiecewiseFunction:
    """A product of powers of states."""
    return PiecewiseFunction("*".join(written_powers(states, exponents)), sum(exponents))


def monomials(states: Sequence[str], degree: int) -> tuple[PiecewiseFunction, ...]:
    """All of a degree."""
    return tuple(monomial(states, exponents) for exponents in monomials_of(len(states), degree))


def bent(surface: Polynomial) -> PiecewiseFunction:
    """The absolute value of a surface with a tangent at the point."""
    return PiecewiseFunction(f"Abs({surface})", 1)


def _beyond(surface: Polynomial) -> PiecewiseFunction:
    """``relu(s)**2``, with the sign for which it vanishes near the point."""
    return PiecewiseFunction(f"relu({surface if surface.at_origin.sign() < 0 else -surface})**2", 2)


def _degree(cells: SignCells) -> int:
    return max((part.degree for cell in cells.cells for field in cell.velocities for part in field), default=0)


def field_jumps(cells: SignCells, surface: Polynomial) -> bool:
    """Whether the field differs on the two sides of a hyperplane."""
    j = cells.surfaces.index(surface)
    by_signs = {cell.signs: cell.velocities for cell in cells.cells}
    for signs, fields in by_signs.items():
        other = by_signs.get((*signs[:j], -signs[j], *signs[j + 1 :]), fields)
        for first, second in zip(fields, other, strict=True):
            gaps = (a - b for a, b in zip(first, second, strict=True))
            if any(gap.divided(cells.forms[j]) is None for gap in gaps):
                return True
    return False


def functions_on(
    system: SwitchedSystem, stated: StatedCells, texts: Sequence[str | list[list[str]]], search: Search | None = None
) -> Functions:
    """Functions on cells of a system.

    Args:
        system: in any number of states.
        stated: its cells.
        texts: the functions.
        search: shows that they are continuous, where they bend on curves.

    Raises:
        BeyondReachError: for functions that are not continuous, or bend on curves without a search.
    """
    try:
        return Functions(read_subject(about(system)), stated.record, texts, search)
    except (*MALFORMED, RejectedError, NoCertificateError) as error:
        raise BeyondReachError(f"required {error}") from None


# ---- conditions at points ------------------------------------------------------------------------


def rates(conditions: Functions, looked_at: LookedAt = points_of, faint: float = FAINT) -> Floats:
    """The rates of all functions along extreme velocities, of shape (m, k), each row over its largest entry.

    Args:
        conditions: of the functions.
        looked_at: the points of each place.
        faint: rates that are no larger are the rounding of places at rest, and left out.
    """
    rows, _ = rates_and_values(conditions, looked_at)
    rows[np.max(np.abs(rows), axis=1, initial=0.0) <= faint] = 0.0
    return distinct(rows)


def rates_and_values(conditions: Functions, looked_at: LookedAt) -> tuple[Floats, Floats]:
    """The rates of all functions along extreme velocities, and their values there, of shape (m, k)."""
    inclusion = conditions.inclusion
    space = whole_domain(inclusion)
    points = looked_at(space)
    places = [(space, [cell], points) for cell in inclusion.cells]
    places += [(face, list(cells), looked_at(face)) for face, _, cells in conditions.bends]
    blocks = [np.zeros((2, 0, len(inclusion.cells[0].functions)))]
    for place, cells, coordinates in places:
        functions, samples = cells[0].functions, sampled(place, cells, coordinates)
        blocks.append(np.stack([slopes_along(samples, functions), _values_at(functions, samples.points)]))
    slopes, heights = np.concatenate(blocks, axis=1)
    return slopes, heights


def distinct(rows: Floats) -> Floats:
    """Rows over their largest entries, without those that are zero or alike."""
    return distinct_rows(np.round(normalized(rows), 12))


def _values_at(functions: Sequence[CheckedPolynomial], points: Floats) -> Floats:
    return np.stack([float_values(function.terms, points) for function in functions], axis=1)


def values(conditions: Functions, looked_at: LookedAt = points_of) -> tuple[Floats, Floats]:
    """Points of all cells, and the values of the functions there, of shapes (m, n) and (m, k)."""
    space, places, heights = whole_domain(conditions.inclusion), [], []
    coordinates = looked_at(space)
    for cell in conditions.inclusion.cells:
        points = sampled(space, [cell], coordinates).points
        places.append(points)
        heights.append(_values_at(cell.functions, points))
    return np.vstack(places), np.vstack(heights)


@BEYOND_FLOATS
def normalized(rows: Floats) -> Floats:
    """Rows over their largest entries, without those that are zero; no numbers where one is not finite."""
    largest = np.max(np.abs(rows), axis=1, initial=0.0)
    return rows[largest != 0] / largest[largest != 0, None]
