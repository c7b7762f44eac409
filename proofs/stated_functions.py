"""A function V that a search has found, as hypotheses of a certificate: its formulas, and the cells of system and V."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

from nonsmooth.proofs.kernel.cells import StatedCells, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.subject import NoCertificateError, exact_text, formula_in_names, polynomial_in_names
from nonsmooth.proofs.systems.findings import ExaminedFunction, PotentialPiece
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


def stated_function(
    system: SwitchedSystem, radius: Number | None, function: ExaminedFunction | PiecewiseExpression
) -> tuple[str | list[list[str]], StatedCells]:
    """V as a certificate states it, and the cells of the system and of V.

    Args:
        system: in any number of states.
        radius: half the side of the cube; None for the whole space.
        function: V, known on cones or as one formula.
    """
    if radius is not None:
        exact_text(radius)
    pieces = () if isinstance(function, PiecewiseExpression) else function.pieces
    if len(pieces) <= 1:
        own = parse_piecewise(str(pieces[0].potential) if pieces else function.text, system.states)
        return formula_in_names(own, system), stated_cells(system, radius, surfaces_of(system, own), irrational=True)
    sides = [_sides(system, piece) for piece in pieces]
    cells = stated_cells(system, radius, [line for own in sides for line, _ in own], irrational=True)
    return [
        [cells.signs(own), polynomial_in_names(piece.potential)] for own, piece in zip(sides, pieces, strict=True)
    ], cells


def growth_hypotheses(system: SwitchedSystem, function: ExaminedFunction) -> dict[str, Any]:
    """Of theorem ``instability``, by a V that grows: where it does on all of the plane a square is enough, and bounded.

    Raises:
        NoCertificateError: where V cannot be written, and where no direction leads into a cell.
    """
    stated, cells = stated_function(system, function.domain.radius or system.check.radius, function)
    direction = _open_direction(system, cells.surfaces)
    return {"cells": cells.record, "function": _negated(stated), "second": None, "direction": direction}


def _sides(system: SwitchedSystem, piece: PotentialPiece) -> list[tuple[Polynomial, int]]:
    """The lines through both rays of a cone, each with its sign inside."""
    if piece.start is None or piece.end is None:
        raise NoCertificateError("a certificate needs a V on cones with both rays")
    x, y = system.coordinates()
    first, last = (y * ray[0] - x * ray[1] for ray in (piece.start, piece.end))
    return [(first, 1), (last, -1)]


def _negated(function: str | list[list[str]]) -> Any:
    if isinstance(function, str):
        return f"-({function})"
    return [[signs, f"-({own})"] for signs, own in function]


def _open_direction(system: SwitchedSystem, surfaces: Sequence[Polynomial]) -> list[str]:
    """A direction that leads from the point into a cell: no surface vanishes along it."""
    for size in range(1, 20):
        for direction in product(range(-size, size + 1), repeat=len(system.states)):
            if any(direction) and all(_varies(surface, direction) for surface in surfaces):
                return list(map(str, direction))
    raise NoCertificateError("a certificate needs a direction that leads into a cell, found none")


def _varies(surface: Polynomial, direction: Sequence[int]) -> bool:
    """Whether a polynomial is not zero along a ray from the origin: the sums of terms of one degree decide."""
    by_degree: dict[int, Number] = {}
    for exponents, coefficient in surface.terms.items():
        factor = 1
        for x, exponent in zip(direction, exponents, strict=True):
            factor *= x**exponent
        degree = sum(exponents)
        by_degree[degree] = by_degree.get(degree, surface.field.zero) + coefficient * factor
    return any(by_degree.values())
