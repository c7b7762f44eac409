"""A search for V: a linear program proposes, the exact audit decides, and what refutes a proposal becomes a new row.

Families of functions (:mod:`nonsmooth.proofs.kernel.bases`) are tried from simple to rich, each on the checked square
and on smaller ones; a V of a smaller one is then proved on the largest square that bisection finds.

*A V that falls.*  The program maximizes the margin m with ``r . c >= m`` for every row (rows have size one) and
``|c_k| <= 1``.  Functions with small coefficients are then left out and the program is solved again, so that what V
does not need is exactly zero and the formula is short.  A point at which the audit refutes a rounded V is added to the
rows.  In reversed time the same search finds a function that grows along every solution.

*A piecewise quadratic V* (Johansson and Rantzer 1998).  Where the linear parts of the fields decide, V may bend on
further lines through the point, closer and closer.  If cells are cones with linear fields, it is proved on the whole
plane; of the decays kappa with ``V' <= -kappa V`` that floats see nearly the fastest is asked for.

*A V that does not increase*, where none is found that falls everywhere, is proposed as in any number of states
(:mod:`nonsmooth.proofs.many_states.weak_functions`), and audited here.

(HiGHS; what comes out of it is a proposal.)
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import product

import numpy as np

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell, lyapunov_cells
from nonsmooth.proofs.checker.cells import Face
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.linear_program import largest_margin
from nonsmooth.proofs.inequalities.prover import Outcome, Proof, Undecided, prove
from nonsmooth.proofs.kernel.bases import (
    LookedAt,
    PiecewiseFunction,
    bent,
    distinct,
    families,
    formula_text,
    functions_on,
    monomials,
    normalized,
    piecewise_quadratics,
    rates_and_values,
    values,
)
from nonsmooth.proofs.kernel.cells import BeyondReachError, monic, stated_cells
from nonsmooth.proofs.kernel.fans import line_sets
from nonsmooth.proofs.kernel.search import Functions, NotShownError, moved_to
from nonsmooth.proofs.kernel.second_function import with_projected
from nonsmooth.proofs.kernel.subject import NoCertificateError, formula_in_names
from nonsmooth.proofs.kernel.written import roundings
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, examine, inhabited
from nonsmooth.proofs.systems.domain import Domain, plane_cells
from nonsmooth.proofs.systems.energies import falling_energies
from nonsmooth.proofs.systems.findings import PlaneFunction
from nonsmooth.proofs.systems.ray_moves import are_cones
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS, Polynomial, float_slopes
from nonsmooth.symbolic.numbers.work_limit import WorkMeter
from nonsmooth.symbolic.systems.switched_system import PLANE, Enclosed, SwitchedSystem, with_known_numbers

ROUNDS = 5  # of proposals for one family on one square
WORK = 240  # inequalities that one search may look at
FIRST_SHARE, LATER_SHARE = Fraction(2, 3), Fraction(1, 8)  # of them for the checked square, and for each smaller one
UNDECIDED_COST = 60  # of an inequality whose sign is not found, in inequalities that are decided
WORK_ON_CONES = 1_000  # inequalities that a search on cones may look at
SCALES = tuple(Fraction(1, 4**k) for k in range(4))  # of the checked square
BISECTIONS = 6  # of the square on which a V is proved, where that is not the checked one
ENLARGING_WORK = 180  # inequalities that these may look at
MAX_CELLS = 40  # beyond that the audit of one proposal takes too long

DIVISIONS, CONE_DIVISIONS = 6, 16  # of half a side of a square
SHRINKING = 0.5  # from one distance of points to the next
DISTANCES = 8
DENOMINATORS = (2, 8, 64, 4096)  # of the rounded coefficients, tried in turn
LEAST_MARGIN = 2.0**-24  # below that nothing is proposed: floats could not tell it from zero
DECAYS = tuple(2.0 ** (1 - k / 16) for k in range(192))  # over the sizes of linear fields, the fastest first
KEPT_DECAYS = (0.97, 0.9, 0.75, 0.5, 0.0)  # of the fastest one, tried in turn
FASTER = 1.125  # than on fewer lines V falls on more if these are taken
MOST_LINES = 6  # on which V bends for that
CLEAR_MARGIN = 2.0**-9  # of a quadratic form: where it is less, as beside relays, a richer V falls faster
NEGLIGIBLE = (2.0**-2, 2.0**-4, 2.0**-6)  # of the largest coefficient: what is left out, at first more

Coefficients = list[Fraction]


def in_time(cells: Sequence[FieldCell], *, grows: bool) -> tuple[FieldCell, ...]:
    """The cells, with time reversed where a V is asked that grows."""
    if not grows:
        return tuple(cells)
    return tuple(replace(cell, velocities=tuple((-f, -g) for f, g in cell.velocities)) for cell in cells)


def square_cells(system: SwitchedSystem, radius: Number, *, grows: bool = False) -> tuple[FieldCell, ...]:
    """The cells of a square."""
    return in_time(plane_cells(system, radius), grows=grows)


def searched_cells(
    system: SwitchedSystem, formula: PiecewiseExpression, radius: Number, *, grows: bool = False
) -> tuple[LyapunovCell, ...]:
    """The cells on which a searched V is judged."""
    return _judged(system, square_cells(system, radius, grows=grows), formula)


def _judged(
    system: SwitchedSystem, cells: Sequence[FieldCell], formula: PiecewiseExpression
) -> tuple[LyapunovCell, ...]:
    return inhabited(lyapunov_cells(cells, formula, system.states, system.origin))


def has_curves(system: SwitchedSystem) -> bool:
    """Whether a switching surface is no line: audits beside curves take long."""
    return any(surface.degree > 1 for surface in system.surfaces(system.displaced(PLANE)))


# ---- a V that falls --------------------------------------------------------------------------------


def find_lyapunov(system: SwitchedSystem, *, grows: bool = False, is_linear: bool = False) -> PlaneFunction | None:
    """A V that falls along every solution about the equilibrium; None where none is found and proved.

    Args:
        system: in two states.
        grows: whether time is reversed.
        is_linear: whether the linear parts of the fields decide what solutions near the point do.
    """
    whole = in_time(plane_cells(system), grows=grows) if is_linear else ()
    function = _on_cones(system, whole, grows=grows) if is_linear and are_cones(whole) else None
    if function is not None:
        return function
    curved = has_curves(system) or system.only_encloses  # polynomials of high degree, as slow to audit as curves
    work = WORK // 2 if curved else WORK
    for scale in SCALES[:2] if curved else SCALES:
        budget = WorkMeter(int(work * (FIRST_SHARE if scale == 1 else LATER_SHARE)))
        radius = system.check.radius * scale
        cells = square_cells(system, radius, grows=grows)
        program = _Program(system, cells, radius, budget, grows)
        for proposed in _proposed(program, is_linear=is_linear) if len(cells) <= MAX_CELLS else ():
            if proposed is not None:
                formula, result = proposed
                return _enlarged(system, PlaneFunction(result, Domain(radius), formula, system.states, grows))
    return None


def _on_cones(system: SwitchedSystem, cells: Sequence[FieldCell], *, grows: bool) -> PlaneFunction | None:
    """A piecewise quadratic V on the plane, of cones with linear fields; None where none is found and proved."""
    program = _Program(system, cells, system.check.radius, WorkMeter(WORK_ON_CONES), grows, conic=True)
    solution = program.on_cones()
    return None if solution is None else PlaneFunction(solution[1], Domain(None), solution[0], system.states, grows)


def _proposed(program: _Program, *, is_linear: bool) -> Iterator[tuple[PiecewiseExpression, LyapunovResult] | None]:
    """What each family proves, the simple ones first; energies before the richest."""
    bases = program.families()
    for basis in bases[:-1]:
        yield program.found(basis)
    for formula in falling_energies(program.system, program.radius):
        yield _falls(program.system, program.cells, formula, program.budget)
    for basis in bases[-1:]:
        yield program.found(basis)
    for lines in program.further_lines() if is_linear else ():
        yield program.found(piecewise_quadratics(program.system.states, lines), lines)


def _falls(
    system: SwitchedSystem, cells: Sequence[FieldCell], formula: PiecewiseExpression, budget: WorkMeter
) -> tuple[PiecewiseExpression, LyapunovResult] | None:
    """A candidate that is proved to fall; None for another, and once the budget is spent."""
    try:
        judged = _judged(system, cells, formula)
    except SceneError:
        return None
    if budget.left <= 0 or first_failure(judged, budget):
        return None
    result = examine(judged)
    return (formula, result) if result.verdict is Decrease.STRICT else None


def _enlarged(system: SwitchedSystem, function: PlaneFunction) -> PlaneFunction:
    """The same V on the largest square, up to the checked one, on which bisection proves that it falls."""
    high, budget = system.check.radius, WorkMeter(ENLARGING_WORK)
    for _ in range(BISECTIONS):
        low = function.domain.radius
        if low is None or not low < high or budget.left <= 0:
            break
        radius = (low + high) / 2
        cells = searched_cells(system, function.formula, radius, grows=function.grows)
        result = examine(cells) if len(cells) <= MAX_CELLS and not first_failure(cells, budget) else None
        if result is not None and result.verdict is Decrease.STRICT:
            function = replace(function, result=result, on=Domain(radius))
        else:
            high = radius
    return function


@dataclass
class _Program:
    """The linear programs about one square: rows are conditions on the coefficients of a family."""

    system: SwitchedSystem
    cells: Sequence[FieldCell]
    radius: Number
    budget: WorkMeter
    grows: bool
    conic: bool = False  # whether all looks the same at every distance

    @cached_property
    def rational(self) -> SwitchedSystem:
        """The system in rational numbers."""
        return with_known_numbers(self.system)

    def families(self) -> list[tuple[PiecewiseFunction, ...]]:
        """Bases from simple to rich; none where the cells are not looked at.

        The simple ones are all where curves cut the plane.
        """
        try:
            cells = stated_cells(self.rational, self.radius).cells
        except (BeyondReachError, NoCertificateError):
            return []
        bases = list(families(cells, all_lines=True))
        if self.system.others and not self.system.only_encloses:  # what encloses one field needs no more than that
            bases[1:1] = [monomials(cells.states, degree) for degree in (4, 6, 8, 10)]
        curves = tuple(bent(surface) for surface in cells.surfaces if surface.degree > 1 and _has_tangent(surface))
        if curves:  # relays on them need what bends; alone it is zero there
            return [(*curves, *bases[:2][-1]), bases[0]]
        # On the lines on which bounds of norms bend the stated field does not.
        is_short = has_curves(self.system) or Enclosed.NORMS in self.system.rewriting.encloses
        return bases[:2] if is_short else bases

    def further_lines(self) -> Iterator[list[Polynomial]]:
        """Lines through the point on which V may bend: the tangents of surfaces, then with others between them."""
        with suppress(NotShownError):
            yield from (list(map(monic, lines)) for lines in line_sets(self.rational))

    def found(
        self, basis: Sequence[PiecewiseFunction], lines: Sequence[Polynomial] = ()
    ) -> tuple[PiecewiseExpression, LyapunovResult] | None:
        """Rounds of proposals and refutations for one family, whose functions may bend on lines besides surfaces.

        None where sums are too long, or cannot be used.
        """
        with suppress(BeyondReachError, ExpressionError, SceneError):
            return self._rounds(basis, self._conditions(basis, lines))
        return None

    def on_cones(self) -> tuple[PiecewiseExpression, LyapunovResult] | None:
        """The same of a piecewise quadratic V on cones with linear fields, which falls nearly as fast as one can.

        It bends on as few lines as serve, or on more where it falls much faster then.
        """
        best: list[tuple[float, tuple[PiecewiseFunction, ...], Functions]] = []
        for lines in self.further_lines():
            if best and len(lines) > MOST_LINES:
                break
            basis = piecewise_quadratics(self.system.states, lines)
            with suppress(BeyondReachError):
                conditions = self._conditions(basis, lines)
                fastest = self._fastest_decay(conditions)
                if best and not (fastest or 0.0) > FASTER * best[-1][0]:
                    break
                best += [] if fastest is None else [(fastest, basis, conditions)]
        for fastest, basis, conditions in reversed(best):
            for decay in dict.fromkeys(share * fastest for share in KEPT_DECAYS):
                with suppress(ExpressionError, SceneError):
                    solution = self._rounds(basis, conditions, decay)
                    if solution is not None:
                        return solution
        return None

    @BEYOND_FLOATS
    def _fastest_decay(self, conditions: Functions) -> float | None:
        """As floats see it; 0 of a V that is to grow, and None where there is no V."""
        size = max(float(np.linalg.norm(float_slopes(velocity))) for cell in self.cells for velocity in cell.velocities)
        slopes, heights = rates_and_values(conditions, self._regular_points)
        decays = [*([] if self.grows else [size * decay for decay in DECAYS]), 0.0]

        def is_possible(decay: float) -> bool:
            rows = np.vstack([self._side * distinct(slopes + decay * heights), distinct(heights)])
            return _kept_margin(rows, list(range(rows.shape[1]))) is not None

        return decays[bisect_left(decays, True, key=is_possible)] if is_possible(0.0) else None

    def _conditions(self, basis: Sequence[PiecewiseFunction], lines: Sequence[Polynomial]) -> Functions:
        stated = stated_cells(self.rational, self.radius, lines, irrational=bool(lines))
        texts = [
            formula_in_names(parse_piecewise(function.text, self.system.states), self.rational) for function in basis
        ]
        return functions_on(self.rational, stated, texts)

    def _rounds(
        self, basis: Sequence[PiecewiseFunction], conditions: Functions, decay: float = 0.0
    ) -> tuple[PiecewiseExpression, LyapunovResult] | None:
        """The same.

        Raises:
            ExpressionError: for a sum that is too long.
            SceneError: for one that cannot be used.
        """
        rows, quadratic = self._rows(conditions, self._regular_points, decay), monomials(self.system.states, 2)
        for _ in range(ROUNDS):
            if self.budget.left <= 0:
                return None
            points: list[Point] = []
            for coefficients in propose(rows, LEAST_MARGIN if len(basis) > len(quadratic) else CLEAR_MARGIN):
                text = formula_text(basis, coefficients)
                formula = parse_piecewise(text, self.system.states)
                judged = _judged(self.system, self.cells, formula)
                failures = first_failure(judged, self.budget)
                result = None if failures else examine(judged)
                if result is None:
                    points += failures
                elif result.verdict is Decrease.STRICT:
                    return formula, result
                elif result.witness is not None:  # on an edge or at a corner
                    points.append(result.witness.point)
            more = self._rows_near(conditions, points, decay)
            if not len(more):
                return None
            rows = np.vstack([rows, more])
        return None

    def _regular_points(self, place: Face) -> Floats:
        return regular_points(place, CONE_DIVISIONS, 1) if self.conic else regular_points(place)

    @BEYOND_FLOATS
    def _rows(self, conditions: Functions, looked_at: LookedAt, decay: float) -> Floats:
        """Rows r with the condition ``r . c > 0``: V is positive, and falls along every solution (or grows)."""
        slopes, heights = rates_and_values(conditions, looked_at)
        falls = self._side * distinct(slopes + decay * heights)
        return np.vstack([falls, normalized(values(conditions, looked_at)[1])])

    @property
    def _side(self) -> int:
        """The sign of rates that are asked for."""
        return 1 if self.grows else -1

    def _rows_near(self, conditions: Functions, points: Sequence[Point], decay: float) -> Floats:
        """Rows at points, and at points on the way from them to the equilibrium, in all cells that hold them."""
        half = float(self.radius)
        scaled = [[float(v) / half * SHRINKING**k for v in point] for point in points for k in range(DISTANCES)]
        near = np.array(scaled).reshape(-1, len(PLANE))
        return self._rows(conditions, lambda place: near if not place.zero else np.zeros((0, place.dimension)), decay)


def _has_tangent(curve: Polynomial) -> bool:
    """Whether a curve runs through the checked point, with a tangent there."""
    return min(map(sum, curve.terms)) == 1


def regular_points(place: Face, divisions: int = DIVISIONS, distances: int = DISTANCES) -> Floats:
    """Points of a place all around the equilibrium, at distances that fall by a constant factor.

    Near the equilibrium the terms of lowest degree decide.  Newton's method takes points near curves to these.
    """
    grid = np.array(list(product(np.linspace(-1.0, 1.0, 2 * divisions + 1), repeat=place.dimension)))
    around = grid if place.dimension == 1 else grid[np.abs(grid).max(axis=1, initial=0.0) == 1]
    points = np.vstack([around * SHRINKING**k for k in range(distances)])
    beside = [
        moved_to(place.restricted(surface), points) for surface in place.inclusion.surfaces.listed if surface.degree > 1
    ]
    return np.vstack([with_projected(place, points), *beside])


def first_failure(cells: Sequence[LyapunovCell], budget: WorkMeter) -> list[Point]:
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


def propose(rows: Floats, least: float = LEAST_MARGIN) -> Iterator[Coefficients]:
    """Rounded coefficients that satisfy all rows in floats, short sums first; nothing without so large a margin."""
    widest = _kept_margin(rows, list(range(rows.shape[1])), least)
    if widest is None:
        return
    seen: list[Coefficients] = []
    for chosen in (*(_pruned(rows, widest, share) for share in NEGLIGIBLE), widest):
        proposed = () if chosen is None else roundings(chosen, DENOMINATORS)
        rounded = next(
            (coefficients for coefficients in proposed if np.all(rows @ np.array(coefficients, dtype=float) > 0)), None
        )
        if rounded is not None and rounded not in seen:
            seen.append(rounded)
            yield rounded


def _pruned(rows: Floats, coefficients: Floats, share: float) -> Floats | None:
    """The best coefficients without the small ones, again and again; None where none are left that serve."""
    while True:
        indices = np.flatnonzero(np.abs(coefficients) >= share * np.abs(coefficients).max())
        if len(indices) == np.count_nonzero(coefficients):
            return coefficients
        pruned = _kept_margin(rows, indices.tolist())
        if pruned is None:
            return None
        coefficients = pruned


def _kept_margin(rows: Floats, indices: Sequence[int], least: float = LEAST_MARGIN) -> Floats | None:
    """The coefficients of the functions that are kept, zero for the others; None without a margin, or beyond floats.

    Rows are scaled anew, because what is left out no longer counts for their size.
    """
    used = normalized(rows[:, indices])
    if len(used) < len(rows) or not len(rows):
        return None  # where all functions vanish, so does V or its derivative
    solution = largest_margin(used) if are_finite(used) else None
    if solution is None or not solution[-1] > least:
        return None
    coefficients = np.zeros(rows.shape[1])
    coefficients[list(indices)] = solution[:-1]
    return coefficients


# ---- a V that does not increase --------------------------------------------------------------------


def audited_weakly(
    system: SwitchedSystem, cells: Sequence[FieldCell], formula: PiecewiseExpression
) -> LyapunovResult | None:
    """The audit of a V that does not increase; None for any other."""
    try:
        judged = _judged(system, cells, formula)
    except SceneError:
        return None
    result = examine(judged) if all(map(_does_not_increase, judged)) else None
    return result if result is not None and result.verdict is Decrease.WEAK else None


def _does_not_increase(cell: LyapunovCell) -> bool:
    positive = prove(Sense.POSITIVE, cell.potential, cell.region, except_origin=True)
    return isinstance(positive, Proof) and all(
        isinstance(prove(Sense.NONPOSITIVE, rate, cell.region), Proof) for rate in cell.rates
    )
