"""A V that falls along every solution and is negative at some points at every distance: the point is unstable.

A solution from such a point has ``V < V(start) < 0`` from then on, so it stays away from the equilibrium, where V is
zero; between there and the border of the cube V falls at a rate that is bounded from below, so it leaves.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from nonsmooth.proofs.many_states.conditions import ConditionSense
from nonsmooth.proofs.many_states.examination import (
    Inequality,
    RationalPieces,
    answers,
    by_face,
    find_failure,
    potential_pieces,
    questions_on,
)
from nonsmooth.proofs.many_states.lyapunov_search import proposals
from nonsmooth.proofs.many_states.sign_cells import RationalTerms, SignCell, SignCells, rational_terms
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Exponents
from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.switched_system import SwitchedSystem

DIRECTIONS = 600  # drawn at random, beside those of the most negative curvature
FINE = 1 << 10  # denominator of a direction


@dataclass(frozen=True)
class GrowthEvidence:
    """The evidence of instability.

    Attributes:
        formula: V, in the displacement under the states' names.
        radius: half the side of the cube on which V falls.
        cells: the cube, cut until the fields and V are smooth.
        inequalities: that V falls, with their evidence.
        direction: V is negative at all points near the equilibrium in this direction.
    """

    formula: PiecewiseExpression
    radius: Number
    cells: SignCells
    inequalities: tuple[Inequality, ...]
    direction: tuple[fmpq, ...]

    def check(self, system: SwitchedSystem) -> bool:
        """Verify the inequalities and the direction, and that they are those of the system."""
        formula = parse_piecewise(self.formula.text, system.states)
        cells, questions = questions_on(system, formula, self.radius)
        falls = [q for q in questions.listed if q.sense is ConditionSense.FALLS]
        if cells != self.cells or falls != [i.question for i in self.inequalities]:
            return False
        if not all(i.proved is not None and i.proved.claim.strict and i.check() for i in self.inequalities):
            return False
        return is_negative_along(cells, potential_pieces(system, cells, formula), self.direction)


def find_growth(system: SwitchedSystem) -> GrowthEvidence | None:
    """A V that shows instability; None where none is found.

    Raises:
        BeyondReachError: for a system that is not decided here.
    """
    for radius, formula in proposals(system, positive=False):
        cells, questions = questions_on(system, formula, radius)
        falls = replace(questions, listed=tuple(q for q in questions.listed if q.sense is ConditionSense.FALLS))
        direction = negative_direction(cells, potential_pieces(system, cells, formula))
        if direction is None or find_failure(cells, falls) is not None:
            continue
        inequalities: list[Inequality] = []
        for asked in by_face(falls.listed):
            inequalities += answers(asked, Effort.STRICT)
            if inequalities[-1].proved is None:
                break
        if all(i.proved is not None for i in inequalities):
            return GrowthEvidence(formula, radius, cells, tuple(inequalities), direction)
    return None


def negative_direction(cells: SignCells, pieces: RationalPieces) -> tuple[fmpq, ...] | None:
    """A direction in which V is negative near the point; None where none is found."""
    count = len(cells.states)
    drawn = np.random.default_rng(0).normal(size=(DIRECTIONS, count))
    candidates = [*_curved(pieces, count), *drawn]
    for candidate in candidates:
        direction = _rounded(candidate)
        if any(direction) and is_negative_along(cells, pieces, direction):
            return direction
    return None


def is_negative_along(cells: SignCells, pieces: RationalPieces, direction: Sequence[fmpq]) -> bool:
    """Whether V is negative at all small distances in a direction, inside a cell."""
    for cell in cells.cells:
        if _holds_germ(cells, cell, direction) and _germ_sign(pieces[cell.signs][0], direction) < 0:
            return True
    return False


def _holds_germ(cells: SignCells, cell: SignCell, direction: Sequence[fmpq]) -> bool:
    """Whether all points near the equilibrium in a direction lie inside a cell."""
    return all(
        sign * _germ_sign(rational_terms(surface), direction) > 0
        for sign, surface in zip(cell.signs, cells.surfaces, strict=True)
    )


def _germ_sign(terms: Mapping[Exponents, fmpq], direction: Sequence[fmpq]) -> int:
    """The sign at small distances in a direction: that of the first form that does not vanish there."""
    by_degree: dict[int, fmpq] = {}
    for exponents, value in terms.items():
        product = value
        for x, exponent in zip(direction, exponents, strict=True):
            product *= x**exponent
        by_degree[sum(exponents)] = by_degree.get(sum(exponents), fmpq(0)) + product
    first = next((by_degree[degree] for degree in sorted(by_degree) if by_degree[degree]), fmpq(0))
    return (first > 0) - (first < 0)


def _curved(pieces: RationalPieces, count: int) -> Iterator[NDArray[np.float64]]:
    """Directions in which the quadratic part of a piece is least."""
    for (terms,) in pieces.values():
        vectors = np.linalg.eigh(_hessian(terms, count))[1]
        yield vectors[:, 0]
        yield -vectors[:, 0]


def _hessian(terms: RationalTerms, count: int) -> NDArray[np.float64]:
    matrix = np.zeros((count, count))
    for exponents, value in terms.items():
        if sum(exponents) == 2:
            i, j = (k for k, e in enumerate(exponents) for _ in range(e))
            matrix[i, j] += float(value)
            matrix[j, i] += float(value)
    return matrix


def _rounded(values: NDArray[np.float64]) -> tuple[fmpq, ...]:
    size = float(np.abs(values).max())
    return tuple(fmpq(round(float(x) / size * FINE), FINE) for x in values)
