"""Linear systems that attract: a quadratic V with short coefficients, which falls nearly as fast as solutions do.

Let all eigenvalues of A have real parts of at most -s, s > 0, one of them -s.  Of ``x' = A x`` no V has
``V' <= -kappa V`` with ``kappa > 2 s``, and for each ``mu`` in ``[0, s)`` one P with

    (A + mu I)^T P + P (A + mu I) = -I

is positive, so that ``V = x^T P x`` has ``V' = -2 mu V - |x|^2`` (Lyapunov).  P is solved in floats for some mu.  Whole
numbers near its multiples are proposed, the sum of squares before all: the smallest that keep nine tenths of the rate
2 s, or else three quarters, and so on; long ones where no short ones do.  The exact audit decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, combinations_with_replacement
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.switched_cells import lyapunov_cells
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel.first_terms import lyapunov_solution
from nonsmooth.proofs.many_states.decision import SpacePoint
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease, examine
from nonsmooth.proofs.systems.domain import Domain
from nonsmooth.proofs.systems.findings import CheckedPoint, ExaminedFunction, Finding, Known, Method
from nonsmooth.proofs.systems.lyapunov_rows import BEYOND_FLOATS
from nonsmooth.proofs.systems.plane_function import PlaneFunction
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, no_sign, parse_piecewise
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

Floats: TypeAlias = NDArray[np.float64]

SHARES = (0.97, 0.85, 0.6, 0.3, 0.0)  # of s: mu of the forms that are rounded
SHORT, LONG = tuple(range(1, 65)), (1 << 9, 1 << 12, 1 << 18, 1 << 24)  # multiples of the largest coefficient
# With multiples of each kind: shares of the rate 2 s that a proposal has at least, tried in turn.
KEPT = ((SHORT, (0.9, 0.75, 0.5, 0.25)), (LONG, (0.9, 0.5, 0.0)))
MOST_PROPOSALS = 3


def decide_linear(point: CheckedPoint, known: Known) -> Finding | None:
    """A quadratic V of a linear system, where the scene names none."""
    system = point.system
    matrix = linear_matrix(system) if system.check.is_default else None
    for own in () if matrix is None else short_forms(matrix):
        function = _examined(point, parse_piecewise(_text(system, own), system.states))
        if function is not None and function.decrease is Decrease.STRICT:
            return Finding(Method.LYAPUNOV, Translation.ASYMPTOTICALLY_STABLE, function.reason, function)
    return None


@BEYOND_FLOATS
def linear_matrix(system: SwitchedSystem) -> Floats | None:
    """A of a system ``x' = A x`` in the displacement; None of any other, and beyond floats."""
    states = system.displaced(system.states)
    if system.others or system.scale is not None or system.by_roots is not None or system.surfaces(states):
        return None
    field = system.velocity(no_sign, states)
    if any(sum(exponents) != 1 for part in field for exponents in part.terms):
        return None
    units = np.eye(len(states), dtype=int).tolist()
    matrix = np.array([[float(part.terms.get(tuple(unit), 0)) for unit in units] for part in field])
    return matrix if np.isfinite(matrix).all() else None


def short_forms(matrix: Floats) -> Iterator[NDArray[np.int64]]:
    """Symmetric matrices 2 P of whole numbers, with even diagonals, of a good rate: the smallest first."""
    slowest = -float(np.linalg.eigvals(matrix).real.max())
    if not slowest > 0:
        return
    scaled, identity = matrix / slowest, np.eye(len(matrix))  # whatever the unit of time
    solved = [own for mu in SHARES if (own := lyapunov_solution(scaled, -mu, identity)) is not None]
    served = chain.from_iterable(_served(scaled, solved, *own) for own in KEPT)
    for _, own in zip(range(MOST_PROPOSALS), served, strict=False):
        yield own.astype(np.int64)


def _served(
    matrix: Floats, solved: Sequence[Floats], multiples: Sequence[int], kept: Sequence[float]
) -> Iterator[Floats]:
    """Rounded forms whose rates are at least a share of the best one, 2 in the given units, for each share in turn."""
    forms = [2 * np.eye(len(matrix)), *(_rounded(own, multiple) for multiple in multiples for own in solved)]
    rates = [rate_of(own, matrix) / 2 for own in forms]
    for share in kept:
        yield from (own for own, rate in zip(forms, rates, strict=True) if rate >= share and rate > 0)


def _rounded(solution: Floats, multiple: int) -> Floats:
    """2 P with the coefficients of V as whole numbers, the largest of which is given."""
    coefficients = 2 * solution - np.diag(np.diag(solution))
    rounded = np.round(coefficients / np.abs(coefficients).max() * multiple)
    return np.asarray(rounded + np.diag(np.diag(rounded)))


def rate_of(form: NDArray[Any], matrix: Floats) -> float:
    """The largest kappa with ``V' <= -kappa V`` for ``V = x^T P x`` along ``x' = A x``; 0 where P is not positive."""
    try:
        units = np.linalg.inv(np.linalg.cholesky(form)).T  # in these P is the identity
    except np.linalg.LinAlgError:
        return 0.0
    falls = -(matrix.T @ form + form @ matrix)
    return float(np.linalg.eigvalsh(units.T @ falls @ units).min())


def _text(system: SwitchedSystem, form: NDArray[np.int64]) -> str:
    """``x^T P x`` as a formula of the states."""
    own, total = system.coordinates(), Polynomial.constant(system.field, system.states, 0)
    for i, j in combinations_with_replacement(range(len(own)), 2):
        total += own[i] * own[j] * int(form[i, j] // (2 if i == j else 1))
    return str(total)


def _examined(point: CheckedPoint, formula: PiecewiseExpression) -> ExaminedFunction | None:
    """V with its conditions: on the plane, or on the cube, where they are about forms."""
    if isinstance(point, PlanePoint):
        cells = lyapunov_cells(point.cells, formula, point.system.states, point.system.origin)
        return PlaneFunction(examine(cells), Domain(None), formula, point.system.states)
    if isinstance(point, SpacePoint):
        return point.examine(formula, point.system.check.radius, Effort.STRICT)
    return None
