"""The search for further functions W that rise where a weak Lyapunov function V is kept, and for bounds of the rates.

LaSalle's principle as :func:`nonsmooth.proofs.checker.theorems.show_stability` states it: W_1, W_2, ... one after the
other rise along all velocities with which the functions before stay constant, until nothing is left off the point.

At points of the places that are left the velocities of solutions are mixtures of finitely many extreme ones.  That W
rises along them is linear in its coefficients.  Monomials alone are tried first, then the least sum of coefficients.
If no W rises along all of them, one that falls along none and rises along many makes the places fewer.  Floats propose;
what is proposed is shown by the proofs of the theorem.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, product
from math import comb
from typing import Any

import numpy as np

from nonsmooth.proofs.checker.cells import Cell, Face, Inclusion, System
from nonsmooth.proofs.checker.invariance import MAX_OTHERS, THEN, Bound, Chain, common_signs
from nonsmooth.proofs.checker.polynomials import Exponents, Polynomial
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import solve_program, with_margin
from nonsmooth.proofs.kernel.bounds import Bounds
from nonsmooth.proofs.kernel.cells import BeyondReachError, sharpened, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import NotShownError, Search, gradient, stability_hypotheses
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.kernel.written import formula_text, slopes
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, distinct_rows
from nonsmooth.symbolic.numbers.polynomial import float_values
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

SCALES = (1.0, 0.5, 0.25, 0.1, 0.03)  # of the points, in units of the cube
DIRECTIONS = 16  # at random, on each scale and in each subspace of coordinates
SMALL = 2.0**-33  # relative size of a rate that is called zero
NEAR = 2.0**-30  # distance from a surface that is called zero
DEGREES = {1: 8, 2: 6, 3: 4, 4: 4}  # of W by the number of states; 3 in more
BENT_DEGREES = {1: 4, 2: 5}  # where W bends on surfaces
WEIGHTS = {2: ((1, 1), (2, 1), (1, 2), (3, 1), (1, 3), (3, 2), (2, 3))}  # of the states; ones for other numbers of them
MOST_HELPFUL = 3  # functions that make the places fewer, tried at each step
MOST_BENDING = 4  # surfaces
SLOWEST = 2.0**-80  # velocities below that are called zero
DENOMINATORS = (1, 2, 3, 4, 6, 8, 16, 64)
MOST_TRIES = 24  # lists of functions
MOST_MIXTURES = 20_000  # of velocities on one face: 7 thousand where four of five relays slide, a million for six


def find_second(
    system: System,
    cells: Mapping[str, Any],
    function: Any,
    search: Search | None = None,
    *,
    below: Fraction | None = None,
    others: Sequence[str] = (),
) -> Record | None:
    """Functions and bounds for the hypothesis ``second`` of the theorems about a V that does not rise.

    Args:
        system: the subject.
        cells: as a certificate states them.
        function: V, likewise.
        search: keeps the proofs that are found.
        below: a level of V, where nothing is asked of points at which V is not less.
        others: the first of the functions, where some are known.

    Returns:
        The hypothesis; None where V rises somewhere, and where nothing was found or shown.
    """
    search, tries = search or Search(), 0

    def extended(functions: list[Any]) -> Record | None:
        """The hypothesis with some functions, and further ones where places are left."""
        nonlocal tries
        tries += 1
        try:
            survey = Survey(system, cells, function, functions, search, below)
        except (NotShownError, RejectedError):
            return None
        if not survey.left:
            return {"functions": functions, "zeros": survey.zeros}
        for candidate in next_functions(survey) if len(functions) < MAX_OTHERS else ():
            hypothesis = extended([*functions, candidate])
            if hypothesis is not None or tries >= MOST_TRIES:
                return hypothesis
        return None

    return extended([*others])


def find_attraction(
    system: SwitchedSystem, potential: PiecewiseExpression, radius: Number, *, everywhere: bool = False
) -> Record | None:
    """The entry of a certificate that shows asymptotic stability by V and further functions; None where none is found.

    Args:
        system: in any number of states.
        potential: V in the displacement, which does not rise.
        radius: half the side of a cube about the point.
        everywhere: whether it is also asked if V and the fields are forms on cones: then every solution is attracted.
    """
    try:
        subject, search = started(system)
        cells = sharpened(stated_cells(system, radius, surfaces_of(system, potential)), subject, search)
        second = find_second(subject, cells.record, potential.text, search)
        if second is None:
            return None
        hypotheses = stability_hypotheses(cells.record, potential.text, ASYMPTOTICALLY_STABLE, second)
        if everywhere:
            with suppress(NotShownError):
                return search.entry(subject, "lyapunov", {**hypotheses, "everywhere": True})[0]
        return search.entry(subject, "lyapunov", hypotheses)[0]
    except (NotShownError, BeyondReachError, NoCertificateError):
        return None


# ---- what is left ----------------------------------------------------------------------------------


class Survey(Chain):
    """The places that some functions leave, with bounds of their rates, which are shown.

    Attributes:
        zeros: the bounds by the names of claims.
        left: where the functions may stay constant: points with velocities, and a cell with their polynomials there.

    Raises:
        NotShownError: where a rate is negative at a point, or a bound is not shown, and where a face has too many
            mixtures of velocities.
    """

    def __init__(
        self,
        system: System,
        cells: Mapping[str, Any],
        function: Any,
        others: Sequence[Any],
        search: Search,
        below: Fraction | None,
    ) -> None:
        self.system, self.stated = system, cells
        super().__init__(Inclusion(system, dict(cells), [function, *others], search), search, {})
        self.below, self.failed = below, {name.split(THEN)[0] for name in search.missed}
        self.left: list[tuple[Cell, Samples]] = []
        if any(_mixtures(place, cells) > MOST_MIXTURES for place, _, cells in self.bends):
            raise NotShownError("too many mixtures of velocities that slide on a face")
        self.show_chain()

    def show_chain(self) -> None:
        """The chain; places at which other functions failed are looked at first, as this one fails there soonest."""
        for name, place, cells in self.first_places():
            if name in self.failed:
                self.show_step(name, (), place, cells)
        self.left, self.zeros = [], {}
        super().show_chain()

    def leave(self, name: str, place: Face, cells: Sequence[Cell]) -> None:
        """Note a place at which all functions may stay constant."""
        self.left.append((cells[0], self.sampled(place, cells).still(cells[0].functions)))

    def sampled(self, place: Face, cells: Sequence[Cell]) -> Samples:
        """Points of a place where V is below the level."""
        samples = sampled(place, cells)
        if self.below is None:
            return samples
        return samples.where(float_values(cells[0].functions[0].terms, samples.points) < float(self.below))

    def bound(self, name: str, step: int, place: Face, cells: Sequence[Cell]) -> Bound | None:
        """Propose a bound of the rate of a step; None where it is positive at all points that are looked at."""
        functions, signs, samples = cells[0].functions, common_signs(cells), self.sampled(place, cells)
        still = samples.still(functions[:step])
        values, sizes = rates(functions, step, still.points, still.velocities)
        if np.any(values < -SMALL * sizes):
            raise NotShownError(f"a rate is negative in {name}")
        is_positive = bool(np.all(values > SMALL * sizes))
        bounds = Bounds(place, signs, self.system.coordinates, self.stated["surfaces"], samples.coordinates)
        terms = None
        if not place.zero:
            ((_, field),) = cells[0].fields
            terms = bounds.below(self.rate(place, functions[step] if step else -functions[0], field))
        if terms is None and not is_positive:
            terms = bounds.at_points(still.coordinates, values)
        if terms is None:
            return None
        written = bounds.written(terms)
        bound = Bound(written, place, signs)
        if is_positive and not bound.places():
            return None
        self.zeros[name] = written
        return bound


def rates(functions: Sequence[Polynomial], step: int, points: Floats, velocities: Floats) -> tuple[Floats, Floats]:
    """The rate of a step at points along velocities, and the sizes of the numbers that it is a sum of."""
    sign = 1.0 if step else -1.0
    parts = gradient(functions[step], points) * velocities
    return sign * np.sum(parts, axis=1), np.sum(np.abs(parts), axis=1) + 2.0**-1000


def slopes_along(samples: Samples, functions: Sequence[Polynomial]) -> Floats:
    """The rates of functions at points along their velocities, of shape (m, k)."""
    slopes = [np.sum(gradient(function, samples.points) * samples.velocities, axis=1) for function in functions]
    return np.stack(slopes, axis=1)


@dataclass(frozen=True)
class Samples:
    """Points of a place, each with an extreme velocity of the solutions there.

    Attributes:
        coordinates: of shape (m, d), in the free variables of the place.
        points: of shape (m, n).
        velocities: of shape (m, n).
    """

    coordinates: Floats
    points: Floats
    velocities: Floats

    def still(self, functions: Sequence[Polynomial]) -> Samples:
        """Those where some functions stay constant."""
        mask = np.ones(len(self.points), dtype=bool)
        for k in range(len(functions)):
            values, sizes = rates(functions, k, self.points, self.velocities)
            mask &= np.abs(values) <= SMALL * sizes
        return self.where(mask)

    def where(self, mask: Mask) -> Samples:
        """Some of them."""
        return Samples(self.coordinates[mask], self.points[mask], self.velocities[mask])


def _mixtures(place: Face, cells: Sequence[Cell]) -> int:
    """How many sets of velocities beside a face are looked at for mixtures that keep its surfaces zero."""
    fields = sum(len(cell.fields) for cell in cells)
    return sum(comb(fields, size) for size in range(1, len(place.zero) + 2))


def sampled(place: Face, cells: Sequence[Cell], coordinates: Floats | None = None) -> Samples:
    """Points of a place off the origin, with the extreme velocities that keep its surfaces zero.

    Args:
        place: a face, or the whole domain.
        cells: beside it.
        coordinates: of points, of which those count that lie in the place; None for some at random.
    """
    listed = place.inclusion.surfaces.listed
    coordinates = points_of(place) if coordinates is None else coordinates
    points = np.stack([float_values(form.terms, coordinates) for form in place.coordinates], axis=1)
    inside = np.all(np.abs(points) <= 1 + NEAR, axis=1) & np.any(np.abs(points) > NEAR, axis=1)
    for j in place.curved:
        inside &= np.abs(float_values(listed[j].terms, points)) <= NEAR
    coordinates, points = coordinates[inside], points[inside]
    values = [float_values(surface.terms, points) for surface in listed]
    normals = [gradient(listed[j], points) for j in place.zero]
    fields: list[tuple[Mask, Floats]] = []
    for cell in cells:
        beside = np.ones(len(points), dtype=bool)
        for j, sign in enumerate(cell.signs):
            beside &= (sign * values[j] >= -NEAR) | (j in place.zero)
        fields += [
            (beside, np.stack([float_values(part.terms, points) for part in field], axis=1)) for _, field in cell.fields
        ]
    places, velocities = extreme_velocities(fields, normals)
    return Samples(coordinates[places], points[places], velocities)


def points_of(place: Face) -> Floats:
    """Coordinates of points on several scales: in subspaces of coordinates, and from there on affine surfaces."""
    size, rng = place.dimension, np.random.default_rng(0)
    subsets = list(product((0.0, 1.0), repeat=size)) if size <= 4 else [tuple(np.ones(size)), *map(tuple, np.eye(size))]
    points = [np.zeros((1, size))]
    for scale, chosen in product(SCALES, subsets):
        drawn = rng.uniform(-1, 1, (DIRECTIONS, size)) * np.array(chosen)
        points.append(scale * drawn / np.max(np.abs(drawn), axis=1, keepdims=True, initial=NEAR))
    return with_projected(place, np.vstack(points))


def with_projected(place: Face, points: Floats) -> Floats:
    """Coordinates of points of a place, with those nearest to them on affine surfaces; each once."""
    projected = [points]
    for surface in place.inclusion.surfaces.listed:
        form = place.restricted(surface)
        if form.degree == 1:
            normal = np.array(slopes(form), dtype=float)
            projected.append(points - np.outer(float_values(form.terms, points), normal) / (normal @ normal))
    return distinct_rows(np.round(np.vstack(projected), 12))


def extreme_velocities(fields: Sequence[tuple[Mask, Floats]], normals: Sequence[Floats]) -> tuple[Indices, Floats]:
    """Of the mixtures of some velocities that are tangent to surfaces, those of which all others are mixtures.

    Args:
        fields: at which of m points each acts, and its velocities there, of shape (m, n).
        normals: of each surface at the points, of shape (m, n).

    Returns:
        The numbers of the points in ascending order, of shape (k,), and a velocity there, of shape (k, n).
    """
    target = np.r_[np.zeros(len(normals)), 1.0]
    # More velocities than independent normals and one are mixtures of mixtures of fewer (Caratheodory).
    rank = int(np.linalg.matrix_rank(np.stack(normals, axis=1)).max(initial=0)) if normals else 0
    extremes = []
    for size in range(1, rank + 2):
        for chosen in combinations(fields, size):
            (indices,) = np.nonzero(np.all([acts for acts, _ in chosen], axis=0))
            velocities = np.stack([velocity[indices] for _, velocity in chosen], axis=2)
            rows = [np.einsum("mi,mis->ms", normal[indices], velocities) for normal in normals]
            matrix = np.stack([*rows, np.ones((len(indices), size))], axis=1)
            weights = _weights(matrix, target)
            mixes = np.all(weights > NEAR, axis=1)
            mixes &= np.all(np.abs(np.einsum("mrs,ms->mr", matrix, weights) - target) <= NEAR, axis=1)
            extremes.append((indices[mixes], np.einsum("mis,ms->mi", velocities[mixes], weights[mixes])))
    places, velocities = (np.concatenate(parts) for parts in zip(*extremes, strict=True))
    order = np.argsort(places, kind="stable")
    return places[order], velocities[order]


def _weights(matrix: Floats, target: Floats) -> Floats:
    """Solutions of ``A w = b``, or what comes closest, for matrices (m, r, s), ``r >= s``; zero for singular ones."""
    rows, size = matrix.shape[1:]
    if size == 1:
        return np.ones((len(matrix), 1))
    if size < rows:
        return np.linalg.pinv(matrix) @ target
    weights = np.zeros((len(matrix), size))
    regular = np.linalg.det(matrix) != 0
    weights[regular] = np.linalg.solve(matrix[regular], target[:, None])[..., 0]
    return weights


# ---- the next function -----------------------------------------------------------------------------


def next_functions(survey: Survey) -> Iterator[str]:
    """Candidates for the next function: those that rise along all velocities that are left, then those that help.

    Args:
        survey: of the functions before.
    """
    places = [(cell, samples) for cell, samples in survey.left if len(samples.points)]
    if rests([samples for _, samples in places]):
        return
    if not places:
        yield survey.system.coordinates[0]  # at no point that was looked at something is left
        return
    of_forms = [(basis, basis.rows(places)) for basis in forms(survey)]
    for basis, rows in [*of_forms, *((basis, basis.rows(places)) for basis in sums(survey))]:
        yield from (basis.text(coefficients) for coefficients in rising(rows, basis.weights))
    for bent in (False, True):
        helpful: dict[str, float] = {}
        for basis, rows in of_forms:
            for coefficients in not_falling(rows, basis.weights) if basis.bends is bent else ():
                helpful.setdefault(
                    basis.text(coefficients), -float(np.mean(rows @ np.array(coefficients, dtype=float) > SMALL))
                )
        yield from sorted(helpful, key=lambda text: helpful[text])[:MOST_HELPFUL]


@dataclass(frozen=True)
class Basis:
    """Monomials, alone or times the absolute value of a surface.

    Attributes:
        survey: for the states, the radius and the surfaces.
        functions: each monomial with the number of its surface.
        weights: what a coefficient costs.
    """

    survey: Survey
    functions: tuple[tuple[Exponents, int | None], ...]
    weights: Floats

    @property
    def bends(self) -> bool:
        """Whether there are absolute values."""
        return any(j is not None for _, j in self.functions)

    def rows(self, places: Sequence[tuple[Cell, Samples]]) -> Floats:
        """The rates of all functions, of shape (m, k), each row in units of its largest entry, if that is not zero."""
        total = np.vstack([slopes_along(samples, list(self._on(cell))) for cell, samples in places])
        largest = np.max(np.abs(total), axis=1, keepdims=True)
        return distinct_rows(np.round(total / np.where(largest > 0, largest, 1.0), 13))

    def _on(self, cell: Cell) -> Iterator[Polynomial]:
        """The functions on a cell."""
        for exponents, j in self.functions:
            monomial = Polynomial(len(exponents), {exponents: Fraction(1)})
            yield monomial if j is None else monomial * self.survey.inclusion.surfaces.signed(j, cell.signs[j])

    def text(self, coefficients: Sequence[Fraction]) -> str:
        """W as a formula in the displacement."""
        states, radius = self.survey.system.coordinates, self.survey.inclusion.domain.radius
        by_surface: dict[int | None, dict[Exponents, Fraction]] = {}
        for (exponents, j), value in zip(self.functions, coefficients, strict=True):
            if value:
                by_surface.setdefault(j, {})[exponents] = value / radius ** sum(exponents)
        largest = max(abs(value) for terms in by_surface.values() for value in terms.values())
        parts = []
        for j, terms in by_surface.items():
            formula = formula_text(Polynomial(len(states), {e: c / largest for e, c in terms.items()}), states)
            parts.append(formula if j is None else f"({formula})*Abs({self.survey.stated['surfaces'][j]})")
        return " + ".join(parts)


def rests(places: Sequence[Samples]) -> bool:
    """Whether at a point a mixture of the velocities that are left is zero, which no function changes."""
    from scipy.optimize import nnls

    at: dict[bytes, list[Floats]] = {}
    for samples in places:
        for point, velocity in zip(np.round(samples.points, 9) + 0.0, samples.velocities, strict=True):
            at.setdefault(point.tobytes(), []).append(velocity)
    for velocities in at.values():
        size = np.abs(velocities).max()  # near the point solutions may be as slow as a high power of the distance
        matrix = np.vstack([np.array(velocities).T / max(size, SLOWEST), np.ones(len(velocities))])
        if nnls(matrix, np.r_[np.zeros(len(matrix) - 1), 1.0])[1] < NEAR:
            return True
    return False


def forms(survey: Survey) -> Iterator[Basis]:
    """Forms of one degree, for some weights of the states; then with absolute values of surfaces that are forms too.

    Those that are the same for several weights come once.
    """
    count, listed = survey.system.count, survey.inclusion.surfaces.listed
    earlier: set[tuple[tuple[Exponents, int | None], ...]] = {()}
    through = [j for j, surface in enumerate(listed) if not surface.at_origin]
    for bent, weights in product((False, True), WEIGHTS.get(count, ((1,) * count,))):
        degrees = {j: {_weight(e, weights) for e in listed[j].terms} for j in through[:MOST_BENDING]}
        graded = {j: max(occurring) for j, occurring in degrees.items() if len(occurring) == 1}
        for degree in range(1, (BENT_DEGREES if bent else DEGREES).get(count, 3) + 1):
            basis = _basis(survey, weights, range(degree, degree + 1), graded if bent else {})
            if basis.functions not in earlier and (graded or not bent):
                earlier.add(basis.functions)
                yield basis


def sums(survey: Survey) -> Iterator[Basis]:
    """Polynomials of rising degree."""
    count = survey.system.count
    for degree in range(2, DEGREES.get(count, 3) + 1):
        yield _basis(survey, (1,) * count, range(1, degree + 1), {})


def _weight(exponents: Exponents, weights: Sequence[int]) -> int:
    return sum(map(int.__mul__, exponents, weights))


def _basis(survey: Survey, weights: Sequence[int], degrees: range, surfaces: Mapping[int, int]) -> Basis:
    """Monomials of some weighted degrees, alone and times the absolute values of surfaces of known degrees."""
    every = list(product(*(range(degrees[-1] // weight + 1) for weight in weights)))
    functions: list[tuple[Exponents, int | None]] = [(e, None) for e in every if _weight(e, weights) in degrees]
    for j, degree in surfaces.items():
        functions += [(e, j) for e in every if _weight(e, weights) + degree in degrees]
    costs = np.array([1.0 + sum(e) / 4 + (j is not None) for e, j in functions])
    return Basis(survey, tuple(functions), costs)


def rising(rows: Floats, weights: Floats) -> Iterator[list[Fraction]]:
    """Coefficients of functions that rise along all rows: a monomial alone, then the least sum of coefficients."""
    size = rows.shape[1]
    if not np.all(np.any(rows, axis=1)):
        return
    alone = [(weights[k], k, sign) for k in range(size) for sign in (1, -1) if np.all(sign * rows[:, k] > SMALL)]
    for _, k, sign in sorted(alone)[:2]:
        yield [Fraction(sign * int(i == k)) for i in range(size)]
    if alone or size == 1:  # a multiple of one function does no more than the function
        return
    values = with_margin(rows, weights)
    coefficients = None if values is None else rounded(values, lambda c: bool(np.all(rows @ c > SMALL)))
    if coefficients is not None:
        yield coefficients


def not_falling(rows: Floats, weights: Floats) -> Iterator[list[Fraction]]:
    """Coefficients of a function that falls along no row and rises along some."""
    size = rows.shape[1]
    helps = []
    for k in range(size):
        for sign in (1, -1):
            column = sign * rows[:, k]
            if np.all(column > -SMALL) and np.any(column > SMALL):
                helps.append((-int(np.sum(column > SMALL)), weights[k], k, sign))
    for _, _, k, sign in sorted(helps)[:1]:
        yield [Fraction(sign * int(i == k)) for i in range(size)]
    if helps or size == 1:
        return
    count = len(rows)
    costs = np.r_[np.tile(weights, 2) * 2.0**-10, -np.ones(count)]
    matrix = np.hstack([-rows, rows, np.eye(count)])
    limits = [(0, 10.0)] * (2 * size) + [(0, 0.1)] * count
    solved = solve_program(costs, A_ub=matrix, b_ub=np.zeros(count), bounds=limits)
    if solved.status == 0 and solved.x[2 * size :].sum() > 0.05:
        values = solved.x[:size] - solved.x[size : 2 * size]
        coefficients = rounded(values, lambda c: bool(np.all(rows @ c > -SMALL) and np.any(rows @ c > SMALL)))
        if coefficients is not None:
            yield coefficients


def rounded(values: Floats, holds: Any) -> list[Fraction] | None:
    """Rational numbers of small denominators near multiples of some values, with which something holds."""
    largest = float(np.max(np.abs(values)))
    if largest < NEAR:
        return None
    smallest = float(np.min(np.abs(values)[np.abs(values) > 2.0**-10 * largest]))
    for unit_value in (largest, smallest):
        for denominator in DENOMINATORS:
            fractions = [Fraction(round(float(v) / unit_value * denominator), denominator) for v in values]
            if holds(np.array(list(map(float, fractions)))):
                return fractions
    return None
