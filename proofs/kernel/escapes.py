"""Writers of the theorem ``escape``: a solution that leaves inside a cell, or along a face of cells, in any states.

A *motion* is a linear subspace S (the whole space, a switching surface, a line) with a mixture of fields that is
tangent to it: a polynomial field h in the coordinates of S.  Its first terms at the point propose where a solution
leaves: along ``h(0)``, perhaps along the border of a cell; along an eigenvector of the linear part, inside a quadratic
cone; along a ray that attracts its neighbours; where states push each other, or beside a curve along which solutions
are slow; or, on a line, to either side.  Floats propose, the theorem's own claims decide.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, islice, permutations

import numpy as np
from flint import fmpq_mat

from nonsmooth.proofs.checker.cells import pattern
from nonsmooth.proofs.checker.lyapunov import sign_along
from nonsmooth.proofs.checker.polynomials import Polynomial, constant, lie_derivative, solve, variable
from nonsmooth.proofs.checker.positivity import identity
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.cells import SignCell, SignCells, adjoining, build_cells, started
from nonsmooth.proofs.kernel.first_terms import MIDDLE, Field, lyapunov_solution, quadratic_form
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search
from nonsmooth.proofs.kernel.written import formula_text, null_basis, part_of, slopes
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm
from nonsmooth.symbolic.numbers.polynomial import float_values
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

RADII = 6  # half-widths of cubes that are tried, each a quarter of the one before
WIDTHS = tuple(Fraction(1, 1 << bits) for bits in (1, 3, 5, 7))  # of cones about a direction, over its length
SHARES = (Fraction(1, 2), Fraction(1, 4), Fraction(3, 4))  # of the first of two right-hand sides
FINE = 1 << 10  # denominators of what floats propose
WORK = 4_000  # of the search for simplices, for one claim
SPEED = Fraction(1, 16)  # with which W rises where it need not on the border
DIRECTIONS = 200
LATE = 8  # how much of the product of a sum and a square is enough to turn back later
BENDS = (0, 1, 8, 64)  # factors c of barriers: their derivative is at least -c times themselves


@dataclass(frozen=True)
class Weighted:
    """A field of a cell in a mixture.

    Attributes:
        cell: with its signs.
        number: of the right-hand side.
        field: on the cell.
        weight: how much of it is taken.
        toward: a vector that leads into the cell from a surface beside it.
    """

    cell: SignCell
    number: int
    field: Field
    weight: Polynomial
    toward: tuple[Fraction, ...]


@dataclass(frozen=True)
class FollowedField:
    """A polynomial field on a subspace that the inclusion may follow.

    Attributes:
        signs: of all surfaces on the subspace, 0 where they vanish on it.
        along: further linear forms that vanish on it.
        mixture: the fields with their weights.
        names: the states that are its coordinates.
        coordinates: all states as forms in these.
        field: the rates of its coordinates.
    """

    signs: str
    along: tuple[str, ...]
    mixture: tuple[Weighted, ...]
    names: tuple[str, ...]
    coordinates: Field
    field: Field

    @property
    def count(self) -> int:
        """The dimension of the subspace."""
        return len(self.names)

    def lifted(self, direction: Sequence[Fraction]) -> list[str]:
        """A vector of the subspace in all states."""
        forms = self.coordinates
        return [str(sum((form.slope(k) * x for k, x in enumerate(direction)), Fraction(0))) for form in forms]


@dataclass(frozen=True)
class BarrierRegion:
    """Where a solution stays until it leaves: ``p_i > 0`` and ``W > 0``, in the coordinates of a motion.

    Attributes:
        barriers: each p with its factor lambda: of p' with a speed, else of a multiple of p' that falls with the cube.
        rise: W.
        direction: a vector in it.
        speed: with which ``W' >= speed W^2`` there, where W need not rise on its border.
    """

    barriers: tuple[tuple[Polynomial, Polynomial], ...]
    rise: Polynomial
    direction: tuple[Fraction, ...]
    speed: Fraction | None = None


def show_escape_of(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence that one solution leaves the checked point.

    Args:
        system: in any number of states.  Where right-hand sides only enclose the field, one solution says nothing.
        verdict: unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    if system.only_encloses:
        raise NotShownError("fields that are only enclosed: one solution of the inclusion says nothing of theirs")
    subject, search = started(system, search or Search(WORK))
    cells = build_cells(system, system.check.radius)
    for motion in motions(cells):
        for region in regions(motion, cells.forms):
            for k in range(RADII if _may_leave(cells, motion, region) else 0):
                radius = Fraction(str(cells.radius)) / 4**k
                entry = search.tried(subject, "escape", _hypotheses(cells, motion, region, radius))
                if entry is not None:
                    return entry
    raise NotShownError("no solution was found that leaves inside a cell or along a face")


def _may_leave(cells: SignCells, motion: FollowedField, region: BarrierRegion) -> bool:
    """Whether near the point, in its direction, a region lies where it is said to lie, and W rises there."""
    direction = [Fraction(x) for x in motion.lifted(region.direction)]
    for surface, mark in zip(cells.forms, motion.signs, strict=True):
        sign = sign_along(surface, direction)
        if mark != "0" and sign != "-0+".index(mark) - 1:
            return False
    mixes = all(sign_along(weighted.weight, direction) >= 0 for weighted in motion.mixture)
    return mixes and sign_along(lie_derivative(region.rise, motion.field), region.direction) > 0


def _hypotheses(cells: SignCells, motion: FollowedField, region: BarrierRegion, radius: Fraction) -> Record:
    unit = Fraction(1) if region.speed is None else radius  # the checker takes lengths in units of the half-width

    def written(value: Polynomial) -> str:
        return formula_text(value, motion.names)

    return {
        "within": str(radius),
        "surfaces": list(map(str, cells.surfaces)),
        "signs": motion.signs,
        "along": list(motion.along),
        "mixture": [
            [
                pattern(weighted.cell.signs),
                weighted.number,
                formula_text(weighted.weight, cells.states),
                list(map(str, weighted.toward)),
            ]
            for weighted in motion.mixture
        ],
        "barriers": [[written(barrier), written(factor.times(unit))] for barrier, factor in region.barriers],
        "function": written(region.rise),
        "direction": motion.lifted(region.direction),
        **({} if region.speed is None else {"speed": str(region.speed)}),
    }


# ---- motions: fields on subspaces ----------------------------------------------------------------


def motions(cells: SignCells) -> Iterator[FollowedField]:
    """Inside open cells, on surfaces between two cells and where two surfaces meet, on lines and planes in cells."""
    near = adjoining(cells)
    for cell in near:
        for mixture in _mixtures(cell):
            yield from _on_subspace(cells, pattern(cell.signs), mixture)
    pairs = [(_apart(first, second), first, second) for first, second in combinations(near, 2)]
    for number in (1, 2):
        for apart, first, second in pairs:
            if len(apart) == number:
                yield from _between(cells, apart, first, second)
    states = identity(len(cells.states))
    planes = [forms for size in range(1, len(states) - 1) for forms in combinations(states, size)]
    for cell in near:
        for mixture in _mixtures(cell)[: len(cell.velocities)]:
            for along in (*_invariant_lines(mixture[0].field), *planes):
                yield from _on_subspace(cells, pattern(cell.signs), mixture, along)


def _mixtures(cell: SignCell) -> list[list[Weighted]]:
    """Each field of a cell alone, and pairs of fields."""
    fields = cell.velocities
    count = len(fields[0])
    still = (Fraction(0),) * count

    def part(number: int, share: Fraction | int) -> Weighted:
        return Weighted(cell, number, fields[number], constant(count, share), still)

    pairs = [[part(i, share), part(j, 1 - share)] for i, j in combinations(range(len(fields)), 2) for share in SHARES]
    return [[part(number, 1)] for number in range(len(fields))] + pairs


def _apart(first: SignCell, second: SignCell) -> list[int]:
    """The surfaces between two cells."""
    return [j for j, (a, b) in enumerate(zip(first.signs, second.signs, strict=True)) if a != b]


def _between(cells: SignCells, apart: Sequence[int], first: SignCell, second: SignCell) -> Iterator[FollowedField]:
    """Sliding between two cells where the surfaces between them, through the point, meet.

    The weights make the speeds across the first of them cancel; where they do not cancel those across the other, there
    is no such motion.  A field that is tangent to the surface is taken alone too.
    """
    count = len(cells.states)
    surfaces = {j: cells.forms[j] for j in apart}
    if any(surface.at_origin for surface in surfaces.values()):
        return
    signs = pattern(0 if j in apart else sign for j, sign in enumerate(first.signs))

    def part(cell: SignCell, number: int, field: Field, weight: Polynomial) -> Weighted:
        toward = (
            sum((cell.signs[j] * surface.slope(k) for j, surface in surfaces.items()), Fraction(0))
            for k in range(count)
        )
        return Weighted(cell, number, field, weight, tuple(toward))

    across = surfaces[apart[0]]
    for a, f in enumerate(first.velocities):
        yield from _on_subspace(cells, signs, [part(first, a, f, constant(count, 1))])
        for b, g in enumerate(second.velocities):
            speed, other = lie_derivative(across, f), lie_derivative(across, g)
            for mixture in ((-other, speed), (other, -speed)):
                yield from _on_subspace(cells, signs, [part(first, a, f, mixture[0]), part(second, b, g, mixture[1])])


def _on_subspace(
    cells: SignCells, signs: str, mixture: Sequence[Weighted], along: Sequence[Polynomial] = ()
) -> Iterator[FollowedField]:
    """The motion of a mixture on the subspace where surfaces with the sign 0, and further forms, vanish.

    There is none where the mixture is not tangent to the subspace, or rests on it.
    """
    count = len(cells.states)
    zero = [surface for surface, sign in zip(cells.forms, signs, strict=True) if sign == "0"]
    flat = [*along, *(surface for surface in zero if surface.degree == 1)]
    coordinates = solve(flat, count)
    if coordinates is None or not coordinates[0].count:
        return
    dimension = coordinates[0].count
    field = [constant(count, 0)] * count
    for weighted in mixture:
        field = [part + weighted.weight * speed for part, speed in zip(field, weighted.field, strict=True)]
    if any(lie_derivative(form, field).on(coordinates, dimension) for form in (*flat, *zero)):
        return
    free = [coordinates.index(variable(dimension, i)) for i in range(dimension)]
    names = tuple(cells.states[k] for k in free)
    rates = tuple(field[k].on(coordinates, dimension) for k in free)
    if any(rates):
        texts = tuple(formula_text(form, cells.states) for form in along)
        yield FollowedField(signs, texts, tuple(mixture), names, coordinates, rates)


def _invariant_lines(field: Field) -> Iterator[tuple[Polynomial, ...]]:
    """Lines through the point to which a field is tangent, by the forms that vanish on them."""
    count = len(field)
    if count < 2 or any(part.at_origin for part in field) or not any(field):
        return
    for proposed in _radial_directions(field):
        top = int(np.argmax(np.abs(proposed)))
        ratios = [Fraction(float(x / proposed[top])).limit_denominator(FINE) for x in proposed]
        forms = tuple(variable(count, k) - variable(count, top, ratio) for k, ratio in enumerate(ratios) if k != top)
        coordinates = solve(forms, count)
        if coordinates is not None and not any(lie_derivative(form, field).on(coordinates, 1) for form in forms):
            yield forms


def _radial_directions(field: Field) -> Iterator[Floats]:
    """Directions along which the first terms of a field lead, in floats."""
    count, degree = len(field), _lowest(field)
    if degree == 1:
        values, vectors = np.linalg.eig(_jacobian(field))
        for k in range(count):
            if abs(values[k].imag) < 2.0**-30:
                yield np.asarray(vectors[:, k].real)
    elif count == 2:
        yield from _planar_rays(field, degree)


# ---- regions: where a solution of a motion stays -------------------------------------------------


def regions(motion: FollowedField, surfaces: Field) -> Iterator[BarrierRegion]:
    """Proposals by the first terms of a motion; the surfaces of all cells are among its barriers where it is slow."""
    if motion.count == 1:
        for side in (1, -1):
            yield BarrierRegion((), variable(1, 0, side), (Fraction(side),))
        return
    degree = _lowest(motion.field)
    if degree == 0:
        velocity = [part.at_origin for part in motion.field]
        for width in WIDTHS:
            yield narrow_cone(velocity, width, constant(motion.count, 0))
        yield from _along_border(motion, surfaces)
    elif degree == 1:
        yield from _by_linear_part(motion)
        yield from _by_double_zero(motion, surfaces)
        yield from _by_pushes(motion)
        yield from _beside_slow_curve(motion)
    elif motion.count == 2:
        for ray in _planar_rays(motion.field, degree):
            yield from _about_ray(ray, degree)


def narrow_cone(velocity: Sequence[Fraction], width: Fraction, factor: Polynomial) -> BarrierRegion:
    """``|x_i - (v_i/v_k) x_k| < width s x_k`` with the largest entry ``v_k`` of a vector and its sign s."""
    count = len(velocity)
    k = max(range(count), key=lambda i: abs(velocity[i]))
    ahead = variable(count, k, 1 if velocity[k] > 0 else -1)
    barriers = []
    for i in range(count):
        if i != k:
            beside = variable(count, i) - variable(count, k, velocity[i] / velocity[k])
            barriers += [(ahead.times(width) + beside, factor), (ahead.times(width) - beside, factor)]
    return BarrierRegion(tuple(barriers), ahead, tuple(velocity))


def _about_ray(ray: Floats, degree: int) -> Iterator[BarrierRegion]:
    """Narrow cones about a ray that attracts its neighbours."""
    vector = rounded(ray)
    top = max(range(2), key=lambda i: abs(vector[i]))
    ahead = variable(2, top, 1 if vector[top] > 0 else -1)
    for width in WIDTHS:
        for bend in BENDS:
            yield narrow_cone(vector, width, ahead.power(degree - 1).times(-bend))


def _by_linear_part(motion: FollowedField) -> Iterator[BarrierRegion]:
    """Quadratic cones ``p = -x^T P x > 0`` with ``(A - mu I)^T P + P (A - mu I) = -R``: ``p' = 2 mu p + x^T R x``.

    Of mu between real parts of eigenvalues; where one real eigenvalue alone is larger, with the eigenvector v and the
    left eigenvector l, the cone has two parts, divided by ``l . x = 0``, and R may make it narrow.
    """
    from scipy.linalg import eig

    matrix = _jacobian(motion.field)
    values, duals, vectors = eig(matrix, left=True)
    parts = sorted({round(float(value.real), 9) for value in values}, reverse=True)
    for above, below in zip(parts, [*parts[1:], min(parts[-1], 0.0) - 1], strict=True):
        if above <= 2.0**-30:
            return
        yield from _chetaev(matrix, max(below, 0.0) + MIDDLE * (above - max(below, 0.0)))
        right = [k for k, value in enumerate(values) if value.real > (above + below) / 2]
        if len(right) == 1:
            lead = duals[:, right[0]].real
            yield from _half_cones(matrix, below + MIDDLE * (above - below), vectors[:, right[0]].real, lead)


def _chetaev(matrix: Floats, mu: float) -> Iterator[BarrierRegion]:
    """``W = -x^T P x`` alone, which rises where it is positive."""
    solution = lyapunov_solution(matrix, mu, np.eye(len(matrix)))
    if solution is None:
        return
    quadratic, direction = quadratic_form(-solution, FINE), rounded(np.linalg.eigh(-solution)[1][:, -1])
    if quadratic.lowest_at(direction) > 0:
        yield BarrierRegion((), quadratic, direction)


def _half_cones(matrix: Floats, mu: float, vector: Floats, lead: Floats) -> Iterator[BarrierRegion]:
    """Both parts of cones about an eigenvector, wide and narrow."""
    size = len(matrix)
    lead = lead / float(lead @ vector)
    beside = np.eye(size) - np.outer(vector, lead)
    for width in (Fraction(1, 4), Fraction(1, 16), Fraction(1)):
        weight = beside.T @ beside + float(width) ** 2 * np.outer(lead, lead)
        solution = lyapunov_solution(matrix, mu, weight)
        if solution is None:
            continue
        barrier = quadratic_form(-solution, FINE)
        factor = constant(size, Fraction(2 * mu).limit_denominator(FINE))
        for side in (1, -1):
            rise = sum((variable(size, k, x) for k, x in enumerate(rounded(side * lead))), constant(size, 0))
            direction = rounded(side * vector)
            if barrier.lowest_at(direction) > 0:
                yield BarrierRegion(((barrier, factor),), rise, direction)


def _by_double_zero(motion: FollowedField, surfaces: Field) -> Iterator[BarrierRegion]:
    """``W = (l . x)(m . x)`` with ``l A = 0`` and ``m A = l``, so that ``W' = (l . x)^2 + ...``, inside a cell."""
    count = motion.count
    jacobian = fmpq_mat([[as_fmpq(part.slope(k)) for part in motion.field] for k in range(count)])
    sides = _sides(motion, surfaces)
    within = list(_directions(count, sides))
    for column in null_basis(jacobian * jacobian).transpose().tolist():
        image = jacobian * fmpq_mat([[value] for value in column])
        lead, late = (
            sum((variable(count, k, as_fraction(x)) for k, x in enumerate(vector)), constant(count, 0))
            for vector in (image.entries(), column)
        )
        for further in ([], [lead], [-lead]):
            for direction in within:
                if all(sign_along(polynomial, direction) > 0 for polynomial in (*further, lead * late)):
                    barriers = tuple((barrier, constant(count, 0)) for barrier in (*sides, *further))
                    yield BarrierRegion(barriers, lead * late, direction, SPEED)
                    break


def _sides(motion: FollowedField, surfaces: Field) -> list[Polynomial]:
    """The surfaces through the point with their signs: what is positive in the cell of a motion."""
    signed = [surface.times("-0+".index(mark) - 1) for surface, mark in zip(surfaces, motion.signs, strict=True)]
    return [surface.on(motion.coordinates, motion.count) for surface in signed if surface and not surface.at_origin]


def _directions(count: int, positive: Sequence[Polynomial]) -> Iterator[tuple[Fraction, ...]]:
    """Vectors of whole numbers at which the terms of lowest degree of polynomials are positive."""
    for drawn in np.random.default_rng(0).integers(-9, 10, size=(DIRECTIONS, count)).tolist():
        direction = tuple(map(Fraction, drawn))
        if all(polynomial.lowest_at(direction) > 0 for polynomial in positive):
            yield direction


# ---- states that push each other -----------------------------------------------------------------


def _in_barriers(field: Field, positive: Sequence[Polynomial], rise: Polynomial) -> Iterator[BarrierRegion]:
    """Where W and ``p = a x_k + ...`` are positive, each with an x_k in no other term: ``p' = lambda p + p + ...``.

    Nothing where no direction is seen along which they are.
    """
    barriers = []
    for barrier in positive:
        rate = lie_derivative(barrier, field)
        part = (rate - rate.on(_zeros(barrier), barrier.count)).divided(barrier) or constant(barrier.count, 0)
        barriers.append((barrier, part - constant(barrier.count, 1)))
    for direction in islice(_directions(rise.count, (*positive, rise)), 1):
        yield BarrierRegion(tuple(barriers), rise, direction, SPEED)


def _zeros(polynomial: Polynomial) -> list[Polynomial]:
    """The variables where ``a x_k + ...`` is zero, with the first x_k that stands there by itself by the others."""
    places = list(identity(polynomial.count))
    alone = next(k for k in range(polynomial.count) if polynomial.slope(k))
    places[alone] -= polynomial.times(1 / polynomial.slope(alone))
    return places


def _with_supports(forms: Sequence[Polynomial], field: Field) -> list[Polynomial]:
    """Linear forms with those that keep them positive: where ``l' = a l + m + ...``, m, and so on."""
    extended = list(forms)
    for form in extended:  # which grows meanwhile
        rate = lie_derivative(form, field)
        pivot = next(k for k in range(form.count) if form.slope(k))
        rest = part_of(rate, 1) - form.times(rate.slope(pivot) / form.slope(pivot))
        if rest and not rate.at_origin and len(extended) <= form.count and rest not in extended:
            extended.append(rest)
    return extended


def _along_border(motion: FollowedField, surfaces: Field) -> Iterator[BarrierRegion]:
    """Along a velocity in the border of its cell, which states keep off: ``-x, -sign(x)`` leaves beside x = 0."""
    sides = _sides(motion, surfaces)
    rates = [lie_derivative(side, motion.field).at_origin for side in sides]
    if all(side.degree == 1 for side in sides) and min(rates, default=1) == 0:
        steps = (variable(motion.count, k, part.at_origin) for k, part in enumerate(motion.field))
        ahead = sum(steps, constant(motion.count, 0))
        yield from _in_barriers(motion.field, _with_supports(sides, motion.field), ahead)


def _by_pushes(motion: FollowedField) -> Iterator[BarrierRegion]:
    """Where ``u' = v + ...``, ``v' = w + ...``, and v turns back so late that u, which adds it up, has left the cube.

    In ``u, v, w + 8 u v^2 > 0`` the product u v rises: of ``v, w, -v^3`` the sum of v is the same in all sizes.
    """
    rows = _linear_parts(motion)
    for first, second, third in permutations(range(motion.count), 3):
        if rows[first] != [second] or rows[second] != [third]:
            continue
        for side in (1, -1):
            u = variable(motion.count, first, side)
            v = _next(u, motion.field)
            w, *supports = _with_supports([_next(v, motion.field)], motion.field)
            barrier = w + (u * v * v).times(LATE)
            yield from _in_barriers(motion.field, [u, v, barrier, *supports], u * v)


def _linear_parts(motion: FollowedField) -> list[list[int]]:
    """Which coordinates stand in the linear part of the rate of each."""
    return [[k for k in range(motion.count) if part.slope(k)] for part in motion.field]


def _next(state: Polynomial, field: Field) -> Polynomial:
    """The one coordinate in the linear part of the rate of another one, with the sign that it has there."""
    ((exponents, factor),) = part_of(lie_derivative(state, field), 1).terms.items()
    return Polynomial(state.count, {exponents: Fraction(1 if factor > 0 else -1)})


def _beside_slow_curve(motion: FollowedField) -> Iterator[BarrierRegion]:
    """In the plane, where ``u' = a v + g(u)`` is zero on a curve over which ``v' = e u^q + ...`` leads.

    There u rises where ``u' > u^q``, slowly.
    """
    rows = _linear_parts(motion)
    for side in (1, -1) if rows in ([[1], []], [[], [0]]) else ():
        u = variable(2, 0 if rows[0] else 1, side)
        ahead = lie_derivative(u, motion.field)
        over = lie_derivative(ahead, motion.field).on(_zeros(ahead), 2)
        if over.lowest_at([Fraction(side)] * 2) > 0:
            order = min(map(sum, over.terms))
            yield from _in_barriers(motion.field, [u, ahead - u.power(order)], u.power((order - 1) // 2 * 2 + 1))  # odd


def rounded(vector: Floats) -> tuple[Fraction, ...]:
    """A vector in short fractions, its largest entry one."""
    scale = max_norm(vector)
    return tuple(Fraction(float(x) / scale).limit_denominator(FINE) for x in vector)


def _lowest(field: Field) -> int:
    """The lowest degree of the terms of a field."""
    return min(sum(e) for part in field for e in part.terms)


def _jacobian(field: Field) -> Floats:
    return np.array(list(map(slopes, field)), dtype=float)


def _planar_rays(field: Field, degree: int) -> Iterator[Floats]:
    """Directions in the plane in which the first terms of a field lead outward, those that attract first."""
    f, g = (part_of(component, degree) for component in field)
    x, y = variable(2, 0), variable(2, 1)
    across = x * g - y * f
    along = [float(across.terms.get((degree + 1 - k, k), 0)) for k in range(degree, -2, -1)]
    roots = [root.real for root in np.roots(along) if abs(root.imag) < 2.0**-30] if any(along) else []
    vectors = [np.array([1.0, root]) for root in roots]
    if not along[0]:
        vectors.append(np.array([0.0, 1.0]))
    for ray in (side * vector for vector in vectors for side in (1, -1)):
        if _at(f, ray) * ray[0] + _at(g, ray) * ray[1] > 0:
            yield ray


def _at(value: Polynomial, place: Floats) -> float:
    return float(float_values(value.terms, place[None, :])[0])
