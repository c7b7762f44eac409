"""A polynomial V whose certified sublevel set fills much of the region of attraction within the checked square.

Floats follow solutions from points on rays: how far those come back is an outline of the region.  On a part of the
outline a linear program asks for a polynomial V with ``V' < 0`` inside and ``V >= 1`` from there on, and as little
above 1 as possible on it, so that its level sets follow the outline.  Where rounded V rises too early, the point
becomes a row, and the program is solved again.  Exact arithmetic then proves V positive and the largest level
(:mod:`nonsmooth.proofs.falling_function`): what floats took for the region is no part of the claim.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from nonsmooth.proofs.checker.cells import whole_domain
from nonsmooth.proofs.falling_function import claims_about
from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.proofs.kernel.bases import PiecewiseFunction, formula_text, functions_on, monomials
from nonsmooth.proofs.kernel.cells import BeyondReachError, SignCells, stated_cells
from nonsmooth.proofs.kernel.search import Functions
from nonsmooth.proofs.kernel.second_function import sampled, slopes_along
from nonsmooth.proofs.systems.domain import SublevelRegion
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, no_sign, parse_piecewise
from nonsmooth.symbolic.messages.notebook import html_table
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, are_finite, max_norms, squared_norms, unit_vectors
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS, float_values
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, require_plane, with_known_numbers

DEGREES = range(2, 13)  # of V
ANGLES, DISTANCES, BEYOND = 120, 32, 12  # of rays, points on each up to the outline, and from there to the border
NEAREST = (1 / 128, 1 / 512)  # distances against the outline, because near the point terms of low degree decide
SHARES = (0.98, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5)  # of the outline, tried in turn
CANDIDATES = 2  # of the parts of the outline whose V are certified
ROUNDS = 20  # of proposals and rises for one share
MARGIN = 1 / 64  # of V and of its derivative, against the squared distance
ENOUGH = 0.9  # of the share's level: a V that rises no earlier is kept
LARGEST = 8.0  # of V on the outline: beyond it level sets have quite another shape
DENOMINATOR = 2**14  # of coefficients
STEP, STEPS, ARRIVED = 1 / 32, 800, 1 / 64  # of paths: in time, and the distance against the half-width


@dataclass(frozen=True, repr=False)
class LargerRegion:
    """A V with a certified region.

    Attributes:
        formula: V, a polynomial in the displacement under the states' names.
        region: every solution that starts with ``V < level`` in the square stays there and reaches the point.
    """

    formula: PiecewiseExpression
    region: SublevelRegion

    def __repr__(self) -> str:
        return f"{self._starts} with V = {one_line(self.formula.text)}"

    @property
    def _starts(self) -> str:
        return f"{self.region} on the square of half-width {brief_text(self.region.radius)} about the point"

    def _repr_html_(self) -> str:
        rows = [(one_line(self.formula.text), self._starts)]
        return html_table("certified region", ("V", "every start there reaches the point"), rows)


def find_larger_region(system: SwitchedSystem, degree: int = 4) -> LargerRegion | None:
    """Search a V of a degree whose certified region in the checked square is large; None where none is certified.

    Args:
        system: in two states.
        degree: of V, from two to twelve.

    Raises:
        SceneError: for another number of states, and for formulas that cannot be used.
        ValueError: for another degree.
    """
    if degree not in DEGREES:
        raise ValueError(f"degree: required a whole number from {DEGREES[0]} to {DEGREES[-1]}, received {degree}")
    require_plane(system)
    basis = tuple(monomial for k in range(2, degree + 1) for monomial in monomials(system.states, k))
    try:
        rational = with_known_numbers(system)
        stated = stated_cells(rational, rational.check.radius)
        conditions = functions_on(rational, stated, [monomial.text for monomial in basis])
    except BeyondReachError:
        return None
    outline = _outline(stated.cells)
    if not outline.reach.min() > 0:
        return None
    certified: list[LargerRegion] = []
    for shrunk in _promising(conditions, outline)[:CANDIDATES]:
        formula = _proposed(system, conditions, basis, shrunk)
        larger = None if formula is None else _certified(system, formula)
        certified += [] if larger is None else [larger]
    return max(certified, key=lambda larger: _seen_area(system, larger, outline), default=None)


def _certified(system: SwitchedSystem, formula: PiecewiseExpression) -> LargerRegion | None:
    falling = claims_about(system, formula, system.check.radius)
    region = None if falling is None else falling.largest_sublevel(falls=False)
    return None if region is None else LargerRegion(formula, region)


def _seen_area(system: SwitchedSystem, larger: LargerRegion, outline: _Outline) -> float:
    """How much of the square is below the level, as points on rays show it."""
    potential = larger.formula.polynomial(system.named(), no_sign)
    places = _Outline(outline.units, outline.border, outline.border).inside
    below = float_values(potential.terms, places) < float(larger.region.level)
    return float((below * squared_norms(places) ** 0.5).sum())


# ---- floats: what to ask for ---------------------------------------------------------------------


@dataclass(frozen=True)
class _Outline:
    """Directions (n, 2), how far starts on them come back (n), and how far the square reaches (n)."""

    units: Floats
    reach: Floats
    border: Floats

    def shrunk(self, share: float) -> _Outline:
        return _Outline(self.units, self.reach * share, self.border)

    @property
    def rim(self) -> Floats:
        return self.reach[:, None] * self.units

    @property
    def inside(self) -> Floats:
        shares = np.concatenate([np.arange(1, DISTANCES + 1) / DISTANCES, NEAREST])
        return (shares[:, None, None] * self.rim).reshape(-1, 2)

    @property
    def outside(self) -> Floats:
        shares = (np.arange(1, BEYOND + 1) / BEYOND)[:, None]
        distances = self.reach + shares * (self.border - self.reach)
        return (distances[:, :, None] * self.units).reshape(-1, 2)


def _outline(cells: SignCells) -> _Outline:
    """How far starts come back within the square, on rays."""
    radius = float(cells.radius)
    angles = np.linspace(-np.pi, np.pi, ANGLES, endpoint=False)
    units = unit_vectors(angles)
    border = radius / max_norms(units)
    shares = np.arange(1, DISTANCES + 1) / DISTANCES
    starts = (shares[:, None, None] * (border[:, None] * units)).reshape(-1, 2)
    back = _comes_back(cells, starts).reshape(DISTANCES, ANGLES)
    count = np.where(back.all(axis=0), DISTANCES, np.argmin(back, axis=0))
    return _Outline(units, count / DISTANCES * border, border)


def _comes_back(cells: SignCells, starts: Floats) -> Mask:
    """Whether solutions reach the point without leaving the square, by the classical Runge-Kutta method.

    Those that stand still, as all do beyond the square, are followed no further.
    """
    places, back, radius = starts.copy(), np.zeros(len(starts), dtype=bool), float(cells.radius)
    going = np.arange(len(starts))
    for _ in range(STEPS):
        if not len(going):
            break
        x = places[going]
        first = _field(cells, x)
        second = _field(cells, x + STEP / 2 * first)
        third = _field(cells, x + STEP / 2 * second)
        last = _field(cells, x + STEP * third)
        places[going] = x + STEP / 6 * (first + 2 * second + 2 * third + last)
        sizes = max_norms(places[going])
        back[going[sizes <= radius * ARRIVED]] = True
        going = going[(sizes > radius * ARRIVED) & (sizes <= radius * (1 + STEP)) & first.any(axis=1)]
    return back


def _field(cells: SignCells, places: Floats) -> Floats:
    """The field of a cell that holds each place; zero beyond the square."""
    velocities = np.zeros_like(places)
    within = max_norms(places) <= float(cells.radius)
    for cell in cells.cells:
        held = within.copy()
        for sign, surface in zip(cell.signs, cells.surfaces, strict=True):
            held &= sign * float_values(surface.terms, places) >= 0
        for k, part in enumerate(cell.velocities[0]):
            velocities[held, k] = float_values(part.terms, places[held])
    return velocities


def _promising(conditions: Functions, outline: _Outline) -> list[_Outline]:
    """Parts of the outline on which there is a program's V, those first of which its level 1 seems to hold most."""
    solved = []
    for share in SHARES:
        shrunk = outline.shrunk(share)
        solution = _solved(conditions, shrunk.inside, shrunk)
        if solution is not None:
            solved.append((share**2 / solution[1], shrunk))
    return [shrunk for _, shrunk in sorted(solved, key=lambda entry: -entry[0])]


def _proposed(
    system: SwitchedSystem, conditions: Functions, basis: Sequence[PiecewiseFunction], outline: _Outline
) -> PiecewiseExpression | None:
    """A rounded V that rises, if at all, near its level on the outline; None where no program has one."""
    inside = outline.inside
    for _ in range(ROUNDS):
        solved = _solved(conditions, inside, outline)
        if solved is None:
            return None
        rounded = [Fraction(round(float(c) * DENOMINATOR), DENOMINATOR) for c in solved[0]]
        formula = parse_piecewise(formula_text(basis, rounded), system.states)
        falling = claims_about(system, formula, system.check.radius)
        if falling is None:
            return None
        value, place = falling.first_rise()
        if value >= ENOUGH:
            return formula
        inside = np.vstack([inside, place])
    return None


@BEYOND_FLOATS
def _solved(conditions: Functions, inside: Floats, outline: _Outline) -> tuple[Floats, float] | None:
    """Coefficients with the least maximum of V on the outline, and that; None where there are none."""
    inclusion = conditions.inclusion
    functions, radius = inclusion.cells[0].functions, float(inclusion.domain.radius)
    rows, bounds = [], []

    def ask(row: Floats, of_top: float, bound: Floats) -> None:
        """``row . c + of_top top <= bound``."""
        rows.append(np.column_stack([row, np.full(len(row), of_top)]))
        bounds.append(bound)

    for cell in inclusion.cells:
        near = sampled(whole_domain(inclusion), [cell], inside / radius)
        ask(slopes_along(near, functions) / radius, 0, -MARGIN * squared_norms(near.points) * radius**2)
    values = [
        np.column_stack([float_values(term.terms, points / radius) for term in functions])
        for points in (inside, outline.rim, outline.outside)
    ]
    ask(-values[0], 0, -MARGIN * squared_norms(inside))
    ask(values[1], -1, np.zeros(len(outline.rim)))
    for points in values[1:]:
        ask(-points, 0, -np.ones(len(points)))
    costs = np.append(np.zeros(len(functions)), 1.0)
    limits = [(None, None)] * len(functions) + [(1, LARGEST)]
    system, right = np.vstack(rows), np.concatenate(bounds)
    if not (are_finite(system) and are_finite(right)):
        return None
    solution = solve_program(costs, A_ub=system, b_ub=right, bounds=limits)
    return (np.asarray(solution.x[:-1]), float(solution.x[-1])) if solution.status == 0 else None
