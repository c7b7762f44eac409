"""Small linear programs, solved exactly: which weights mix given vectors into a target, at the best price.

``maximize sum_k prices_k w_k  subject to  sum_k w_k columns_k = target, w >= 0`` with a handful of rows.
Primal simplex with Bland's rule (it cannot cycle) over the scene's field: the optimum is exact and comes with
its own proof, the multipliers ``y`` with ``y . columns_k >= prices_k`` for all k and ``y . target`` equal to the value.
With three rows the exact pivots cost less than starting a float solver; only over many square roots, where a pivot
divides by long sums, a float solver proposes the basis and exact signs confirm it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from nonsmooth.symbolic.mechanics.constraints import Triple, cofactors, independent, inner
from nonsmooth.symbolic.numbers.lazy import FEW_ROOTS, divided
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points
from nonsmooth.symbolic.numbers.rounded import either_way

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult


Column: TypeAlias = Sequence[Number]


FEW_COLUMNS = 64  # beyond, exact pivots are many and long: floats propose the basis first


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


def best_mixture(columns: Sequence[Column], target: Column, prices: Sequence[Number]) -> Mixture | None:
    """Solve the program; None where no weights reach the target.

    Of rounded numbers any path of pivots will do; what counts are the signs that show the outcome.

    Raises:
        ValueError: if the program is unbounded.
    """
    field = target[0].field
    with either_way(field):
        found = _solve(columns, target, prices)
    if isinstance(found, Mixture):
        if field.measured:
            found.check(columns, target, prices)
        return found
    for column in (*columns, target) if field.measured else ():
        _product(found, column).sign()
    return None


def _solve(columns: Sequence[Column], target: Column, prices: Sequence[Number]) -> Mixture | tuple[Number, ...]:
    """The optimum, or multipliers y with ``y . columns_k >= 0`` and ``y . target < 0``: then nothing is feasible.

    Rows with a negative target are negated first, and one artificial column per row starts phase one.
    """
    one = target[0].field.one
    is_long = len(one.field.radicands) > FEW_ROOTS or len(columns) > FEW_COLUMNS
    if is_long and len(columns) >= len(target):  # fewer are no basis, and to load the solver takes longer than all else
        proposed = _verified_proposal(columns, target, prices)
        if proposed is not None:
            return proposed
    zero = one - one
    rows = len(target)
    flips = [-1 if t.sign() < 0 else 1 for t in target]
    padded = [[flip * entry for flip, entry in zip(flips, column, strict=True)] for column in columns]
    padded += [[one if r == k else zero for r in range(rows)] for k in range(rows)]
    goal = [flip * t for flip, t in zip(flips, target, strict=True)]
    real = len(columns)
    basis = list(range(real, real + rows))
    phase_one = [zero] * real + [-one] * rows
    tableau = _Tableau(padded, goal, basis)
    tableau.maximize(phase_one, allowed=real + rows)
    if any(basic >= real and level.sign() > 0 for basic, level in zip(tableau.basis, tableau.levels, strict=True)):
        return tuple(flip * y for flip, y in zip(flips, tableau.multipliers(phase_one), strict=True))
    tableau.expel_artificials(real)
    tableau.maximize([*prices, *[zero] * rows], allowed=real)
    weights = {k: w for k, w in zip(tableau.basis, tableau.levels, strict=True) if k < real and w}
    multipliers = [flip * y for flip, y in zip(flips, tableau.multipliers([*prices, *[zero] * rows]), strict=True)]
    return Mixture(weights, _sum([prices[k] * w for k, w in weights.items()], zero), tuple(multipliers))


def _verified_proposal(columns: Sequence[Column], target: Column, prices: Sequence[Number]) -> Mixture | None:
    """The optimum, if floats find its basis and exact signs confirm it; None where they do not.

    With many square roots an exact pivot divides by long sums.  For three rows the basis B alone decides: with
    ``det = det B``, the weights are ``det(B with the target in place of column k)/det`` and the multipliers
    ``y = prices_B B^-1``; all signs are those of numerators times that of det.
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
    for column, price in zip(columns, prices, strict=True):
        if (_sum(y * c for y, c in zip(multipliers, column, strict=True)) - price * det).sign() * side < 0:
            return None
    value = _sum(prices[k] * top for k, top in zip(basis, tops, strict=True))
    weights = {k: divided(top, det) for k, top in zip(basis, tops, strict=True) if top}
    return Mixture(weights, divided(value, det), tuple(divided(y, det) for y in multipliers))


def _float_basis(columns: Sequence[Column], target: Column, prices: Sequence[Number]) -> list[int] | None:
    """Columns of an optimal vertex according to HiGHS, completed to three."""
    from scipy.optimize import linprog

    matrix = float_points(columns).T
    largest = max(abs(price) for price in prices)
    costs = np.array([float(divided(price, largest)) if largest else 0.0 for price in prices])
    if not np.isfinite(matrix).all():
        return None
    result = linprog(-costs, A_eq=matrix, b_eq=[float(t) for t in target], method="highs-ds")
    if result.status != 0 or len(target) != 3:
        return None
    slack = matrix.T @ -result.eqlin.marginals - costs
    order = np.lexsort((slack, -result.x))  # columns in use first, then those that would cost least
    basis: list[int] = []
    for k in order.tolist():
        if len(independent([_triple(columns[i]) for i in [*basis, k]])) > len(basis):
            basis.append(k)
    return basis if len(basis) == 3 else None


def _triple(column: Column) -> Triple:
    return column[0], column[1], column[2]


class _Tableau:
    """Dense simplex tableau: ``body[k]`` is column k in the current basis, ``levels`` the basic values."""

    def __init__(self, columns: Sequence[Column], target: Column, basis: list[int]) -> None:
        self.body = [list(column) for column in columns]
        self.levels = list(target)
        self.basis = basis
        self.start = len(columns) - len(target)  # the artificial columns hold the inverse of the basis

    def maximize(self, prices: Sequence[Number], allowed: int) -> None:
        while True:
            entering = self._entering(prices, allowed)
            if entering is None:
                return
            self._pivot(self._leaving(entering), entering)

    def _entering(self, prices: Sequence[Number], allowed: int) -> int | None:
        for k in range(allowed):
            if k not in self.basis:
                gain = prices[k] - _sum(prices[b] * e for b, e in zip(self.basis, self.body[k], strict=True))
                if gain.sign() > 0:
                    return k
        return None

    def _leaving(self, entering: int) -> int:
        best: int | None = None
        for r, entry in enumerate(self.body[entering]):
            if entry.sign() > 0:
                if best is None:
                    best = r
                    continue
                order = (self.levels[r] * self.body[entering][best] - self.levels[best] * entry).sign()
                if order < 0 or (order == 0 and self.basis[r] < self.basis[best]):
                    best = r
        if best is None:
            raise ValueError("required a bounded linear program")
        return best

    def _pivot(self, row: int, entering: int) -> None:
        inverse = self.body[entering][row].inverse()
        factors = [entry * inverse for entry in self.body[entering]]
        for column in [*self.body, self.levels]:
            if column[row]:
                head = column[row]
                for r in range(len(column)):
                    column[r] = head * inverse if r == row else column[r] - factors[r] * head
        self.basis[row] = entering

    def expel_artificials(self, real: int) -> None:
        """Pivot zero-level artificials out where a real column can replace them."""
        for row, basic in enumerate(self.basis):
            if basic >= real:
                entering = next((k for k in range(real) if k not in self.basis and self.body[k][row]), None)
                if entering is not None:
                    self._pivot(row, entering)

    def multipliers(self, prices: Sequence[Number]) -> list[Number]:
        """``y = prices_B B^-1``; the artificial columns hold ``B^-1``."""
        return [
            _sum(prices[b] * e for b, e in zip(self.basis, column, strict=True)) for column in self.body[self.start :]
        ]


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
TOO_MANY = 1  # status


def solve_program(costs: Any, **stated: Any) -> OptimizeResult:
    """The result of :func:`scipy.optimize.linprog`, without a solution where none is found in so many steps.

    Args:
        costs: c of ``min c . x``.
        stated: constraints and bounds, as there.
    """
    from scipy.optimize import linprog

    for method in METHODS:
        found = linprog(costs, method=method, options={"maxiter": MOST_STEPS}, **stated)
        if found.status != TOO_MANY:
            break
    return found


def least_sum(rows: Floats, limits: Floats, costs: Floats, most: float | None) -> Floats | None:
    """The c with ``rows . c <= limits`` of the least ``sum_k costs_k |c_k|``; None where there is none.

    Args:
        rows: shape (m, k).
        limits: shape (m,).
        costs: positive, shape (k,).
        most: of an ``|c_k|``; None without a bound.
    """
    found = solve_program(np.r_[costs, costs], A_ub=np.hstack([rows, -rows]), b_ub=limits, bounds=(0, most))
    if found.status != 0:
        return None
    above, below = np.split(found.x, 2)
    return np.asarray(above - below)


KEPT = 0.5  # of the largest margin, with the least sum of sizes
LEAST_MARGIN = 2.0**-20  # of rows, each in units of its largest entry, that is proposed


def with_margin(rows: Floats, costs: Floats) -> Floats | None:
    """The c, at most 1 in size, of the least weighted sum of sizes that keeps half of the largest margin.

    Args:
        rows: r, where the margin is the least ``r . c``.
        costs: of the sizes.

    Returns:
        None without a margin.
    """
    table = np.hstack([-rows, np.ones((len(rows), 1))])
    found = solve_program([*np.zeros(rows.shape[1]), -1.0], A_ub=table, b_ub=np.zeros(len(rows)), bounds=(-1, 1))
    if found.status or found.x[-1] < LEAST_MARGIN:
        return None
    least = least_sum(-rows, np.full(len(rows), -KEPT * found.x[-1]), costs, 1)
    return np.asarray(found.x[:-1]) if least is None else least
