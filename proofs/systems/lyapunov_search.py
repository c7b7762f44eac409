"""A search for V: a linear program proposes, the exact audit decides, and what refutes a proposal becomes a new row.

Families of functions are tried from simple to rich (:mod:`nonsmooth.proofs.systems.lyapunov_basis`), each on the
checked square and on smaller ones; a V of a smaller one is then proved on the largest square that bisection finds.
A point at which the audit refutes a rounded V is added to the rows, and the program is solved again.  In reversed time
the same search finds a function that grows along every solution.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import (
    FieldCell,
    LyapunovCell,
    lyapunov_cells,
    square_regions,
    system_cells,
)
from nonsmooth.proofs.inequalities.prover import Outcome, Proof, Sense, Undecided, prove
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, examine, inhabited
from nonsmooth.proofs.systems.lyapunov_basis import (
    BasisFunction,
    bent_functions,
    build_formula,
    curves_through,
    lines_through,
    smooth_functions,
)
from nonsmooth.proofs.systems.lyapunov_program import propose
from nonsmooth.proofs.systems.lyapunov_rows import build_rows, build_sides, rows_at
from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.scene_error import SceneError
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem

ROUNDS = 5  # of proposals for one family on one square
WORK = 240  # inequalities that one search may look at
FIRST_SHARE, LATER_SHARE = Fraction(2, 3), Fraction(1, 8)  # of them for the checked square, and for each smaller one
UNDECIDED_COST = 60  # of an inequality whose sign is not found, in inequalities that are decided
SCALES = (Fraction(1), Fraction(1, 4), Fraction(1, 16), Fraction(1, 64))  # of the checked square
BISECTIONS = 6  # of the square on which a V is proved, where that is not the checked one
ENLARGING_WORK = 180  # inequalities that these may look at
MAX_CELLS = 40  # beyond that the audit of one proposal takes too long

Turn = Callable[[Sequence[FieldCell]], tuple[FieldCell, ...]]


@dataclass(frozen=True)
class FoundLyapunov:
    """A V that was searched and proved.

    Attributes:
        formula: V, in the displacement under the states' names.
        radius: half the side of the square on which it is proved.
        result: Lyapunov's conditions with their evidence.
    """

    formula: PiecewiseExpression
    radius: Number
    result: LyapunovResult


@dataclass
class Budget:
    """What a search may still spend, in inequalities."""

    left: int


def find_lyapunov(system: SwitchedSystem, turn: Turn = tuple) -> FoundLyapunov | None:
    """A V that falls along every solution on a square about the equilibrium; None where none is found and proved.

    Args:
        system: in two states.
        turn: what is done to the cells first: nothing, or time reversed.
    """
    curved = has_curves(system) or bool(system.waves)  # polynomials of high degree, as slow to audit as curves
    work = WORK // 2 if curved else WORK
    for scale in SCALES[:2] if curved else SCALES:
        budget = Budget(int(work * (FIRST_SHARE if scale == 1 else LATER_SHARE)))
        radius = system.check.radius * scale
        cells = turn(system_cells(system, square_regions(radius)))
        if len(cells) > MAX_CELLS:
            continue
        for basis in families(system):
            found = _found(system, cells, basis, budget)
            if found is not None:
                return enlarged(system, FoundLyapunov(found[0], radius, found[1]), turn)
    return None


def enlarged(system: SwitchedSystem, found: FoundLyapunov, turn: Turn = tuple) -> FoundLyapunov:
    """The same V on the largest square within the checked one on which bisection proves it."""
    largest = system.check.radius
    low, high, best = found.radius, largest, found
    budget = Budget(ENLARGING_WORK)
    for _ in range(BISECTIONS if low < largest else 0):
        radius = (low + high) / 2
        cells = searched_cells(system, found.formula, radius, turn)
        result = examine(cells) if len(cells) <= MAX_CELLS and not first_failure(cells, budget) else None
        if result is not None and result.verdict is Decrease.STRICT:
            low, best = radius, FoundLyapunov(found.formula, radius, result)
        else:
            high = radius
        if budget.left <= 0:
            break
    return best


def families(system: SwitchedSystem) -> Iterator[tuple[BasisFunction, ...]]:
    """Bases from simple to rich; the simple ones alone where curves cut the plane."""
    field, curves = system.field, curves_through(system)
    lines = (*lines_through(system), *curves)
    linear, quadratic = smooth_functions(field, 1), smooth_functions(field, 2)
    first, second = bent_functions(field, lines, 1), bent_functions(field, lines, 2)
    if curves:  # relays on them need what bends; alone it is zero there
        yield (*first, *quadratic)
    yield quadratic
    if system.others and not system.waves:  # what encloses one field needs no more than that
        yield from (smooth_functions(field, degree) for degree in (4, 6, 8, 10))
    if lines and not curves:
        yield first
        yield (*first, *quadratic)
    if has_curves(system):
        return
    if lines:
        yield (*second, *quadratic)
        yield (*first, *linear, *second, *quadratic)
    axes = tuple(Polynomial.variable(field, PLANE, name) for name in PLANE)
    both = (*lines, *(axis for axis in axes if axis not in lines))
    if lines and len(both) > len(lines):
        yield (*bent_functions(field, both, 1), *linear, *bent_functions(field, both, 2), *quadratic)
    higher = (function for degree in (3, 4) for function in smooth_functions(field, degree))
    yield (*first, *second, *bent_functions(field, lines, 3), *quadratic, *higher)


def has_curves(system: SwitchedSystem) -> bool:
    """Whether a switching surface is no line: audits beside curves take long."""
    return any(surface.degree > 1 for surface in system.surfaces(system.displaced(PLANE)))


def searched_cells(
    system: SwitchedSystem, formula: PiecewiseExpression, radius: Number, turn: Turn = tuple
) -> tuple[LyapunovCell, ...]:
    """The cells on which a searched V is judged."""
    cells = turn(system_cells(system, square_regions(radius)))
    return inhabited(lyapunov_cells(cells, formula, system.states, system.origin))


def _found(
    system: SwitchedSystem, cells: Sequence[FieldCell], basis: Sequence[BasisFunction], budget: Budget
) -> tuple[PiecewiseExpression, LyapunovResult] | None:
    """Rounds of proposals and refutations for one family."""
    try:
        blank = build_formula(basis, [Fraction(1)] * len(basis), system.states)
        pieces = inhabited(lyapunov_cells(cells, blank, system.states, system.origin))
    except (ExpressionError, SceneError):
        return None
    sides = build_sides(pieces, basis)
    rows = build_rows(sides)
    for _ in range(ROUNDS):
        if budget.left <= 0:
            return None
        points: list[Point] = []
        for coefficients in propose(rows):
            try:
                formula = build_formula(basis, coefficients, system.states)
                judged = inhabited(lyapunov_cells(cells, formula, system.states, system.origin))
            except (ExpressionError, SceneError):
                return None
            failures = first_failure(judged, budget)
            result = None if failures else examine(judged)
            if result is not None and result.verdict is Decrease.STRICT:
                return formula, result
            points += failures if result is None else refuting_points(result)
        more = rows_at(sides, points) if points else np.zeros((0, 0))
        if not len(more):
            return None
        rows = np.vstack([rows, more])
    return None


def first_failure(cells: Sequence[LyapunovCell], budget: Budget) -> list[Point]:
    """Points of the first closed cell on which V is not positive or does not fall, or where that is left open."""
    for cell in cells:
        positive = (Sense.POSITIVE, cell.potential)
        for sense, polynomial in (positive, *((Sense.NEGATIVE, rate) for rate in cell.rates)):
            outcome = prove(sense, polynomial, cell.region, except_origin=True)
            budget.left -= UNDECIDED_COST if isinstance(outcome, Undecided) else 1
            if not isinstance(outcome, Proof):
                return _points_of(outcome)
    return []


def _points_of(outcome: Outcome) -> list[Point]:
    """Where an inequality fails, or the corners of the part on which its sign was not found."""
    if isinstance(outcome, Undecided):
        return [(corner[0], corner[1]) for corner in outcome.part]
    return [] if isinstance(outcome, Proof) else [(outcome.point[0], outcome.point[1])]


def refuting_points(result: LyapunovResult) -> list[Point]:
    """Where an audit fails on an edge or at a corner."""
    return [] if result.witness is None else [result.witness.point]
