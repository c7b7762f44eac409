"""Parameters of several conditions, rounded so that every condition can still be met exactly.

Monomials that no plain sum of squares reaches (of too low or too high a degree) tie parameters to the numbers beside
guards by linear equations; the rounding keeps these.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import fmpq, fmpq_mat

from nonsmooth.proofs.sums_of_squares.ansatz import Ansatz, Condition, reached
from nonsmooth.proofs.sums_of_squares.conic_program import Solution, entries
from nonsmooth.proofs.sums_of_squares.rounding import nearest, particular_solution
from nonsmooth.symbolic.numbers.polynomial import Exponents


def round_parameters(
    problems: Sequence[tuple[Condition, Ansatz]], solution: Solution, denominator: int
) -> tuple[fmpq, ...] | None:
    """Rational parameters near those of a solution; None where the equations have no solution.

    Args:
        problems: as they were solved.
        solution: in floats.
        denominator: of those parameters that are free, and of numbers beside guards in the equations.
    """
    count = len(solution.parameters)
    values = [nearest(float(value), denominator) for value in solution.parameters]
    rows: list[dict[int, fmpq]] = []
    rights: list[fmpq] = []
    for (condition, ansatz), grams in zip(problems, solution.grams, strict=True):
        own, right, found = _outside(condition, ansatz, count, len(values))
        rows += own
        rights += right
        for block, entry in found:
            gram = grams[block]
            column = next(c for c in range(len(gram)) if (c + 1) * (c + 2) // 2 > entry)
            values.append(nearest(float(gram[entry - column * (column + 1) // 2, column]), denominator))
    if not rows:
        return tuple(values)
    return _solved(rows, rights, values, count)


def _outside(
    condition: Condition, ansatz: Ansatz, parameters: int, start: int
) -> tuple[list[dict[int, fmpq]], list[fmpq], list[tuple[int, int]]]:
    """The equations of one condition that the plain sum of squares does not enter, and the entries in them."""
    first, *others = ansatz.blocks
    within = reached(first.monomials)
    place: dict[Exponents, dict[int, fmpq]] = {}
    used: list[tuple[int, int]] = []
    for k, block in enumerate(others, 1):
        for entry, terms in entries(block):
            outer = {e: c for e, c in terms.items() if e not in within}
            if not outer:
                continue
            for e, c in outer.items():
                place.setdefault(e, {})[start + len(used)] = -c
            used.append((k, entry))
    for parameter, slope in condition.slopes.items():
        for e, c in slope.items():
            if e not in within and c:
                place.setdefault(e, {})[parameter] = c
    for e, c in condition.constant.items():
        if e not in within and c:
            place.setdefault(e, {})
    return list(place.values()), [-condition.constant.get(e, fmpq(0)) for e in place], used


def _solved(
    rows: Sequence[dict[int, fmpq]], rights: Sequence[fmpq], values: list[fmpq], count: int
) -> tuple[fmpq, ...] | None:
    """The values with those changed that the equations determine, parameters before others."""
    columns = sorted({k for row in rows for k in row})
    matrix = fmpq_mat(len(rows), len(columns), [row.get(k, fmpq(0)) for row in rows for k in columns])
    errors = [right - sum(c * values[k] for k, c in row.items()) for row, right in zip(rows, rights, strict=True)]
    change = particular_solution(matrix, fmpq_mat(len(rows), 1, errors))
    if change is None:
        return None
    for j, column in enumerate(columns):
        values[column] += change[j, 0]
    return tuple(values[:count])
