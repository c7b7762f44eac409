"""Small linear programs, solved exactly: which weights mix given vectors into a target, at the best price.

``maximize sum_k prices_k w_k  subject to  sum_k w_k columns_k = target, w >= 0`` with a handful of rows.
Primal simplex with Bland's rule (it cannot cycle) over the scene's field: the optimum is exact and comes with
its own proof, the multipliers ``y`` with ``y . columns_k >= prices_k`` for all k and ``y . target`` equal to the value.
With three rows floats go the same way first, and exact signs confirm the basis at which they end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from nonsmooth.symbolic.mechanics.contact_states import Triple, cofactors, inner
from nonsmooth.symbolic.numbers.lazy import divided
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points
from nonsmooth.symbolic.numbers.rounded import either_way, plain

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult


Column: TypeAlias = Sequence[Number]


ROUNDING = 2.0**-30  # of the largest entry of a row: less is zero to floats
MOST_PIVOTS = 100  # of floats, which may go round in circles, for each column


@dataclass(frozen=True)
class Mixture:
    """Optimal weights of a linear program with its certificate.

    Attributes:
        weights: nonzero weights by column number.
        value: ``sum_k prices_k w_k``.
        multipliers: one per row; ``multipliers . column_k >= price_k`` and ``multipliers . target = value``.
    """

    weights: dict[int, Number]
    value: Number
    multipliers: tuple[Number, ...]

    def reaches(self, columns: Sequence[Column], target: Column) -> bool:
        """Re-verify that the weights are at least zero and mix the columns into the target."""
        zero = target[0].field.zero
        return all(w.sign() >= 0 for w in self.weights.values()) and all(
            _sum((w * columns[k][r] for k, w in self.weights.items()), zero) == goal for r, goal in enumerate(target)
        )

    def check(self, columns: Sequence[Column], target: Column, prices: Sequence[Number]) -> bool:
        """Re-verify feasibility and optimality from the definition."""
        rows = range(len(target))
        zero = target[0].field.zero
        bound = all(
            _sum(self.multipliers[r] * column[r] for r in rows) >= price
            for column, price in zip(columns, prices, strict=True)
        )
        attained = _sum(self.multipliers[r] * target[r] for r in rows) == self.value
        priced = _sum((prices[k] * w for k, w in self.weights.items()), zero) == self.value
        return self.reaches(columns, target) and bound and attained and priced


def mixtures_to_zero(vectors: Sequence[Column]) -> tuple[list[Column], Column]:
    """Columns and target of the convex weights that mix vectors into zero."""
    zero = vectors[0][0] * 0
    return [(*vector, zero + 1) for vector in vectors], (*(zero for _ in vectors[0]), zero + 1)


def best_mixture(
    columns: Sequence[Column], target: Column, prices: Sequence[Number], *, counts: bool = True
) -> Mixture | None:
    """Solve the program; None where no weights reach the target.

    Of rounded numbers any path of pivots will do; what counts are the signs that show the outcome; without ``counts``
    none do, and whoever rests on it asks for those that it needs.

    Raises:
        ValueError: if the program is unbounded.
    """
    field = target[0].field
    with either_way(field):
        result = _solve(columns, target, prices)
    if isinstance(result, Mixture):
        if counts and field.measured:
            result.check(columns, target, prices)
        return result
    for column in (*columns, target) if counts and field.measured else ():
        _product(result, column).sign()
    return None


def _solve(columns: Sequence[Column], target: Column, prices: Sequence[Number]) -> Mixture | tuple[Number, ...]:
    """The optimum, or multipliers y with ``y . columns_k >= 0`` and ``y . target < 0``: then nothing is feasible."""
    proposed = _verified_proposal(columns, target, prices) if len(target) == 3 else None
    if proposed is not None:
        return proposed
    tableau = _Tableau(columns, target, sign)
    if not tableau.optimize(prices):
        return tableau.multipliers(tableau.phase_one)
    weights = {k: w for k, w in zip(tableau.basis, tableau.levels, strict=True) if k < len(columns) and w}
    value = _sum([prices[k] * w for k, w in weights.items()], target[0] * 0)
    return Mixture(weights, value, tableau.multipliers(tableau.padded(prices)))


def _verified_proposal(columns: Sequence[Column], target: Column, prices: Sequence[Number]) -> Mixture | None:
    """The optimum, if floats find its basis and exact signs confirm it; None where they do not.

    For three rows the basis B alone decides: with ``det = det B``, the weights are ``det(B with the target in place of
    column k)/det`` and the multipliers ``y = prices_B B^-1``; all signs are those of numerators times that of det.
    Exact pivots take longer, and over many square roots they divide by long sums.
    """
    basis = _float_basis(columns, target, prices)
    if basis is None:
        return None
    chosen = [_triple(columns[k]) for k in basis]
    adjugate = cofactors(chosen[0], chosen[1], chosen[2])
    det = inner(chosen[0], adjugate[0])
    side = det.sign()
    tops = [inner(_triple(target), row) for row in adjugate]
    if not side or any(top.sign() * side < 0 for top in tops):
        return None
    rows = list(zip(*adjugate, strict=True))
    multipliers = [_sum(prices[k] * c for k, c in zip(basis, row, strict=True)) for row in rows]
    slopes, scale = [*map(plain, multipliers)], plain(det)  # rounded numbers have the signs of their members
    for column, price in zip(columns, prices, strict=True):
        if (_product(slopes, [*map(plain, column)]) - plain(price) * scale).sign() * side < 0:
            return None
    value = _sum(prices[k] * top for k, top in zip(basis, tops, strict=True))
    weights = {k: divided(top, det) for k, top in zip(basis, tops, strict=True) if top}
    return Mixture(weights, divided(value, det), tuple(divided(y, det) for y in multipliers))


def _float_basis(columns: Sequence[Column], target: Column, prices: Sequence[Number]) -> list[int] | None:
    """The columns at which the same pivots end in floats; None where they end at others than three, or nowhere."""
    entries, costs = _scaled(float_points([*columns, target])), _scaled(float_points([prices]).T)
    begun = _float_start(tuple(map(tuple, entries)))
    if begun is None:
        return None
    tableau = begun.copy(_most_pivots(columns))
    try:
        tableau.maximize(tableau.padded([cost for (cost,) in costs]), allowed=tableau.start)
    except ValueError:
        return None
    return tableau.basis if max(tableau.basis) < len(columns) else None


@lru_cache(maxsize=8)  # the same vectors are mixed at several prices
def _float_start(entries: tuple[tuple[float, ...], ...]) -> _Tableau | None:
    """Columns, and the target as the last one, after the first phase; None where no weights reach the target."""
    *columns, target = entries
    tableau = _Tableau(columns, target, _float_sign, _most_pivots(columns))
    try:
        return tableau if tableau.becomes_feasible() else None
    except ValueError:
        return None


def _most_pivots(columns: Sequence[object]) -> range:
    return range(MOST_PIVOTS * len(columns))


def _scaled(values: Floats) -> list[list[float]]:
    """Each entry in units of the largest of its kind, (m, kinds); zero where floats do not reach."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        scaled: list[list[float]] = np.nan_to_num(values / np.abs(values).max(axis=0)).tolist()
    return scaled


def _float_sign(value: float) -> int:
    return 0 if abs(value) <= ROUNDING else sign(value)


def _triple(column: Column) -> Triple:
    return column[0], column[1], column[2]


class _Tableau:
    """Dense simplex tableau over numbers whose sign is known: ``body[k]`` is column k in the current basis.

    Rows with a negative target are negated first, and one artificial column per row starts phase one: they come after
    the others, and hold the inverse of the basis.  ``levels`` are the values of the columns of the basis.
    """

    def __init__(
        self,
        columns: Sequence[Sequence[Any]],
        target: Sequence[Any],
        sign: Callable[[Any], int],
        pivots: Iterable[int] | None = None,
    ) -> None:
        zero, self.sign, self.pivots = target[0] * 0, sign, iter(count() if pivots is None else pivots)
        self.rows, self.start = range(len(target)), len(columns)
        self.flips = [-1 if sign(t) < 0 else 1 for t in target]
        self.body = [self._flipped(column) for column in columns]
        self.body += [[zero + (1 if r == k else 0) for r in self.rows] for k in self.rows]
        self.levels = self._flipped(target)
        self.basis = [self.start + r for r in self.rows]
        self.phase_one = [*(zero for _ in columns), *(zero - 1 for _ in self.rows)]

    def _flipped(self, column: Iterable[Any]) -> list[Any]:
        return [flip * entry for flip, entry in zip(self.flips, column, strict=True)]

    def padded(self, prices: Sequence[Any]) -> list[Any]:
        """With those of artificial columns, which are nothing."""
        return [*prices, *(self.levels[0] * 0 for _ in self.rows)]

    def copy(self, pivots: Iterable[int]) -> _Tableau:
        """One that goes on from here by itself."""
        other = copy(self)
        other.pivots, other.basis, other.levels = iter(pivots), [*self.basis], [*self.levels]
        other.body = [[*column] for column in self.body]
        return other

    def optimize(self, prices: Sequence[Any]) -> bool:
        """Both phases; False after the first where no weights reach the target.

        Raises:
            ValueError: if the program is unbounded, or floats go round in circles.
        """
        if not self.becomes_feasible():
            return False
        self.maximize(self.padded(prices), allowed=self.start)
        return True

    def becomes_feasible(self) -> bool:
        """The first phase; raises as above."""
        self.maximize(self.phase_one, allowed=len(self.body))
        levels = zip(self.basis, self.levels, strict=True)
        if any(basic >= self.start and self.sign(level) > 0 for basic, level in levels):
            return False
        self.expel_artificials()
        return True

    def maximize(self, prices: Sequence[Any], allowed: int) -> None:
        """Pivots by Bland's rule, until no column that is allowed raises the value."""
        for _ in self.pivots:
            entering = self._entering(prices, allowed)
            if entering is None:
                return
            self._pivot(self._leaving(entering), entering)
        raise ValueError("required a linear program that ends")

    def _entering(self, prices: Sequence[Any], allowed: int) -> int | None:
        for k in range(allowed):
            if k not in self.basis:
                gain = prices[k] - _sum(prices[b] * e for b, e in zip(self.basis, self.body[k], strict=True))
                if self.sign(gain) > 0:
                    return k
        return None

    def _leaving(self, entering: int) -> int:
        best: int | None = None
        for r, entry in enumerate(self.body[entering]):
            if self.sign(entry) > 0:
                if best is None:
                    best = r
                    continue
                order = self.sign(self.levels[r] * self.body[entering][best] - self.levels[best] * entry)
                if order < 0 or (order == 0 and self.basis[r] < self.basis[best]):
                    best = r
        if best is None:
            raise ValueError("required a bounded linear program")
        return best

    def _pivot(self, row: int, entering: int) -> None:
        inverse = 1 / self.body[entering][row]
        factors = [entry * inverse for entry in self.body[entering]]
        for column in [*self.body, self.levels]:
            if column[row]:
                head = column[row]
                for r in range(len(column)):
                    column[r] = head * inverse if r == row else column[r] - factors[r] * head
        self.basis[row] = entering

    def expel_artificials(self) -> None:
        """Pivot zero-level artificials out where a real column can replace them."""
        for row, basic in enumerate(self.basis):
            if basic >= self.start:
                others = (k for k in range(self.start) if k not in self.basis and self.sign(self.body[k][row]))
                entering = next(others, None)
                if entering is not None:
                    self._pivot(row, entering)

    def multipliers(self, prices: Sequence[Any]) -> tuple[Any, ...]:
        """``y = prices_B B^-1`` of the rows as they were given."""
        values = (_product([prices[b] for b in self.basis], column) for column in self.body[self.start :])
        return tuple(self._flipped(values))


def _product(left: Column, right: Column) -> Number:
    return _sum(a * b for a, b in zip(left, right, strict=True))


def _sum(values: object, start: Number | None = None) -> Number:
    total = start
    for value in values:  # type: ignore[attr-defined]
        total = value if total is None else total + value
    if total is None:
        raise ValueError("required at least one summand")
    return total


# ---- linear programs in floats: they propose, and exact arithmetic decides -----------------------


METHODS = ("highs", "highs-ipm")  # simplex steps, which may go round in circles where many rows meet; interior points
MOST_STEPS = 10_000  # of each
TOO_MANY, NOT_NUMBERS = 1, 4  # statuses


def solve_program(costs: Any, **stated: Any) -> OptimizeResult:
    """The result of :func:`scipy.optimize.linprog`, without a solution where none is found in so many steps.

    There is none either where floats do not hold the numbers.

    Args:
        costs: c of ``min c . x``.
        stated: constraints and bounds, as there.
    """
    from scipy.optimize import OptimizeResult, linprog
    from scipy.sparse import issparse

    tables = [costs, *(stated[name] for name in ("A_ub", "b_ub", "A_eq", "b_eq") if name in stated)]
    if not all(np.isfinite(table.data if issparse(table) else table).all() for table in tables):
        return OptimizeResult(x=None, status=NOT_NUMBERS, success=False)
    for method in METHODS:
        result = linprog(costs, method=method, options={"maxiter": MOST_STEPS}, **stated)
        if result.status != TOO_MANY:
            break
    return result


def least_sum(rows: Floats, limits: Floats, costs: Floats, most: float | None) -> Floats | None:
    """The c with ``rows . c <= limits`` of the least ``sum_k costs_k |c_k|``; None where there is none.

    Args:
        rows: shape (m, k).
        limits: shape (m,).
        costs: positive, shape (k,).
        most: of an ``|c_k|``; None without a bound.
    """
    solution = solve_program(np.r_[costs, costs], A_ub=np.hstack([rows, -rows]), b_ub=limits, bounds=(0, most))
    if solution.status != 0:
        return None
    above, below = np.split(solution.x, 2)
    return above - below


SOME, MOST_DRAWN = 2, 4  # rows for each column that are looked at first; how often as many further ones are


def some_contradict(rows: Floats, limits: Floats, costs: Floats, most: float | None) -> bool:
    """Whether few rows show that :func:`least_sum` finds nothing: of thousands it takes ten times as long to see.

    Rows that the least sum of those before breaks most are added in turn.
    """
    size = SOME * len(costs)
    drawn = np.unique(np.linspace(0, len(rows) - 1, size, dtype=int))
    for _ in range(MOST_DRAWN if len(rows) > size * MOST_DRAWN else 0):
        c = least_sum(rows[drawn], limits[drawn], costs, most)
        if c is None:
            return True
        excess = rows @ c - limits
        drawn = np.union1d(drawn, np.argsort(excess)[-size:])
    return False


KEPT = 0.5  # of the largest margin, with the least sum of sizes
LEAST_MARGIN = 2.0**-20  # of rows, each in units of its largest entry, that is proposed


def largest_margin(rows: Floats) -> Floats | None:
    """The c, at most 1 in size, of the largest margin m, the least ``r . c`` of all rows r; and m, the last entry.

    None without a margin of at least zero.
    """
    table, bounds = np.hstack([-rows, np.ones((len(rows), 1))]), [(-1, 1)] * rows.shape[1] + [(0, 1)]
    solution = solve_program([*np.zeros(rows.shape[1]), -1.0], A_ub=table, b_ub=np.zeros(len(rows)), bounds=bounds)
    return None if solution.status else solution.x


def with_margin(rows: Floats, costs: Floats) -> Floats | None:
    """The c, at most 1 in size, of the least weighted sum of sizes that keeps half of the largest margin.

    Args:
        rows: r, where the margin is the least ``r . c``.
        costs: of the sizes.

    Returns:
        None without a margin.
    """
    solution = largest_margin(rows)
    if solution is None or solution[-1] < LEAST_MARGIN:
        return None
    least = least_sum(-rows, np.full(len(rows), -KEPT * solution[-1]), costs, 1)
    return solution[:-1] if least is None else least
