"""A search for a V that does not increase, where no V that falls everywhere is found: energies of damped systems.

The linear program maximizes the margin of V > 0 while V' <= 0 may hold with equality.  Energies have simple
coefficients, so rounding meets the equalities, and the exact audit decides.  What stays where V' = 0 is asked of
:mod:`nonsmooth.proofs.systems.invariance`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np

from nonsmooth.analysis.cells.switched_cells import (
    FieldCell,
    LyapunovCell,
    lyapunov_cells,
    square_regions,
    system_cells,
)
from nonsmooth.proofs.inequalities.prover import Proof, Sense, prove
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, examine, inhabited
from nonsmooth.proofs.systems.invariance import attracts, resting_place
from nonsmooth.proofs.systems.lyapunov_basis import (
    BasisFunction,
    bent_functions,
    build_formula,
    lines_through,
    smooth_functions,
)
from nonsmooth.proofs.systems.lyapunov_program import Coefficients, largest_margin
from nonsmooth.proofs.systems.lyapunov_rows import Floats, build_sides, build_weak_rows
from nonsmooth.proofs.systems.lyapunov_search import MAX_CELLS, FoundLyapunov
from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.scene_error import SceneError
from nonsmooth.symbolic.switched_system import SwitchedSystem

SCALES = (Fraction(1), Fraction(1, 8))  # of the checked square
DENOMINATORS = (1, 2, 4, 12, 64)  # of the rounded coefficients, tried in turn
MOST_AUDITS = 16  # of proposals in one search
LEAST_MARGIN = 2.0**-20  # of V at the sampled points, rows scaled to one
KEPT_MARGIN = 0.125  # of the largest margin, where few terms are wanted
SLACK = 2.0**-30  # by which floats may miss an equality
NEGLIGIBLE = 2.0**-10  # of the largest coefficient: left out


def find_weak_lyapunov(system: SwitchedSystem, *, may_attract: bool = True) -> FoundLyapunov | None:
    """A V that does not increase: one that shows attraction by LaSalle's principle, else the first; None without one.

    Args:
        system: in two states.
        may_attract: whether the equilibrium may attract; otherwise the first V serves.
    """
    left, first = MOST_AUDITS, None
    for scale in SCALES:
        radius = system.check.radius * scale
        cells = system_cells(system, square_regions(radius))
        if len(cells) > MAX_CELLS:
            continue
        for basis in _families(system):
            for formula in _proposals(system, cells, basis):
                left -= 1
                result = _audited(system, cells, formula) if left >= 0 else None
                if result is None:
                    continue
                if not may_attract or (resting_place(result.cells) is None and attracts(system, formula, radius)):
                    return FoundLyapunov(formula, radius, result)
                first = first or FoundLyapunov(formula, radius, result)
        if first is not None:
            break
    return first


def _families(system: SwitchedSystem) -> Iterator[tuple[BasisFunction, ...]]:
    """From simple to rich: squares, lines, and what integrates cubic forces."""
    field, lines = system.field, lines_through(system)
    quadratic, quartic = smooth_functions(field, 2), smooth_functions(field, 4)
    yield quadratic
    bent = [bent_functions(field, lines, degree) for degree in (1, 2, 3, 4)] if lines else []
    if bent:
        yield (*bent[0], *quadratic)
        yield (*bent[0], *bent[1], *quadratic)
    for k in (0, 2):  # the square of one state alone: near the other axis higher powers must not be drowned
        yield (quadratic[k], *quartic)
        if bent:
            yield (quadratic[k], *bent[2])
    yield (*quadratic, *quartic)
    if bent:
        yield (*(function for functions in bent for function in functions), *quadratic, *quartic)


def _proposals(
    system: SwitchedSystem, cells: Sequence[FieldCell], basis: Sequence[BasisFunction]
) -> Iterator[PiecewiseExpression]:
    """Rounded proposals of one family as formulas."""
    for coefficients in _propose(system, cells, basis):
        try:
            yield build_formula(basis, coefficients, system.states)
        except ExpressionError:
            return


def _audited(system: SwitchedSystem, cells: Sequence[FieldCell], formula: PiecewiseExpression) -> LyapunovResult | None:
    """The audit of a V that does not increase; None for any other."""
    try:
        judged = inhabited(lyapunov_cells(cells, formula, system.states, system.origin))
    except SceneError:
        return None
    if not all(map(_does_not_increase, judged)):
        return None
    result = examine(judged)
    return result if result.verdict is Decrease.WEAK else None


def _does_not_increase(cell: LyapunovCell) -> bool:
    positive = prove(Sense.POSITIVE, cell.potential, cell.region, except_origin=True)
    return isinstance(positive, Proof) and all(
        isinstance(prove(Sense.NONPOSITIVE, rate, cell.region), Proof) for rate in cell.rates
    )


def _propose(
    system: SwitchedSystem, cells: Sequence[FieldCell], basis: Sequence[BasisFunction]
) -> Iterator[Coefficients]:
    """Rounded coefficients that keep all rows in floats."""
    try:
        blank = build_formula(basis, [Fraction(1)] * len(basis), system.states)
        pieces = inhabited(lyapunov_cells(cells, blank, system.states, system.origin))
    except (ExpressionError, SceneError):
        return
    positive, falling = build_weak_rows(build_sides(pieces, basis))
    widest = largest_margin(positive, falling, LEAST_MARGIN)
    if widest is None:
        return
    seen: set[Coefficients] = set()
    for chosen in (_shortest(positive, falling, widest), widest):
        for rounded in _rounded(positive, falling, chosen):
            if rounded not in seen:
                seen.add(rounded)
                yield rounded


def _rounded(positive: Floats, falling: Floats, coefficients: Floats) -> Iterator[Coefficients]:
    """Coefficients over the largest of them, with every denominator that keeps all rows."""
    scaled = coefficients / np.abs(coefficients).max()
    scaled[np.abs(scaled) < NEGLIGIBLE] = 0.0
    for denominator in DENOMINATORS:
        rounded = tuple(Fraction(float(c)).limit_denominator(denominator) for c in scaled)
        floats = np.array([float(c) for c in rounded])
        if np.all(positive @ floats > 0) and np.all(falling @ floats >= -SLACK):
            yield rounded


def _shortest(positive: Floats, falling: Floats, widest: Floats) -> Floats:
    """Coefficients of least sum of sizes that keep a part of the margin: energies have few terms."""
    from scipy.optimize import linprog

    margin = np.min(positive @ widest) * KEPT_MARGIN
    above, below = (np.hstack([-rows, rows]) for rows in (positive, falling))
    limits = np.concatenate([np.full(len(above), -margin), np.zeros(len(below))])
    costs = np.ones(2 * positive.shape[1])
    found = linprog(costs, A_ub=np.vstack([above, below]), b_ub=limits, bounds=(0, None), method="highs")
    if found.status != 0:
        return widest
    first, second = np.split(found.x, 2)
    return np.asarray(first - second)
