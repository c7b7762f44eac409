"""A search for V in many states: semidefinite programs propose coefficients, the exact examination decides.

V is a sum of functions of a family (:mod:`nonsmooth.proofs.kernel.bases`).

*Programs.*  The conditions on a V that is a sum of functions are affine in its coefficients, so one program looks for
coefficients and for all Gram matrices together.  Without the condition that V is positive it looks for a V that falls
along every solution and is negative somewhere at every distance: then the point is unstable (Lyapunov's first theorem
on instability, Chetaev), because a solution that starts there cannot stay near.

*Products* ``+-x_i x_j``, negative squares and differences of squares are asked as they are, in two states also
products such as ``-relu(x)**2*relu(-y)``: ``V' <= -V^2/16`` where V is negative.

*Instability.*  Where V falls along every solution and is negative at some points at every distance, a solution from
such a point has ``V < V(start) < 0`` from then on, so it stays away from the equilibrium, where V is zero; between
there and the border of the cube V falls at a rate that is bounded from below, so it leaves.  Relays of too high a
degree need no V (:func:`show_relay_of`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import combinations, pairwise, product

import numpy as np
from flint import fmpq, fmpq_mat

from nonsmooth.proofs.checker.polynomials import Polynomial as CheckedPolynomial
from nonsmooth.proofs.checker.polynomials import constant, lie_derivative
from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.bases import PiecewiseFunction, families, formula_text, functions_on
from nonsmooth.proofs.kernel.cells import (
    BeyondReachError,
    Field,
    SignCells,
    adjoining,
    build_cells,
    started,
    stated_cells,
)
from nonsmooth.proofs.kernel.search import (
    SLACK,
    Entry,
    NotShownError,
    directed_hypotheses,
    instability_hypotheses,
    negative_direction,
    sample_points,
)
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.squares import Shape, condition_of, mu_shapes
from nonsmooth.proofs.kernel.written import formula_text as polynomial_text
from nonsmooth.proofs.kernel.written import terms_of
from nonsmooth.proofs.many_states.examination import (
    POSITIVE,
    ExaminedLyapunov,
    answer,
    conditions_on,
    examine,
    find_failure,
)
from nonsmooth.proofs.many_states.rest_beside import ray_of_rest
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, build_blocks, gram_entries
from nonsmooth.proofs.sums_of_squares.conic_program import Problem, round_parameters, solve_inside
from nonsmooth.proofs.sums_of_squares.prove import Effort, normalized
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import Polynomial, float_values, written_powers
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

SCALES = tuple(Fraction(1, 4**k) for k in range(4))  # of the checked cube
DENOMINATORS = (1 << 3, 1 << 6, 1 << 10, 1 << 20)  # of the coefficients, tried in turn
# Entries of the Gram matrices of a program: small ones take up to two seconds each, large ones up to twenty.  Larger
# ones are not solved.
SMALL = range(8_000)
LARGE = range(8_000, 24_000)
MOST_KEPT = 16  # claims about sums of functions: of all families on all cubes


def find_lyapunov(system: SwitchedSystem, entries: range = SMALL) -> ExaminedLyapunov | None:
    """A V that is positive and falls along every solution on a cube about the point; None where none is found.

    Args:
        system: in two states or more.
        entries: the sizes of the programs that are solved.

    Raises:
        BeyondReachError: for a system that is not decided here.
    """
    for radius, formula in proposals(system, positive=True, entries=entries):
        examined = examine(system, formula, radius, effort=Effort.STRICT)
        if examined.decrease is Decrease.STRICT:
            return examined
    return None


def proposals(
    system: SwitchedSystem, *, positive: bool, entries: range = SMALL
) -> Iterator[tuple[Number, PiecewiseExpression]]:
    """Rounded proposals, family by family, on the checked cube and on smaller ones.

    What serves on a cube serves on smaller ones: a family without a proposal on the smallest is left out.  No V falls
    at a place of rest, so there is none beside rays of these.  A family that holds one whose program is too large has
    a larger one, which is not built: that alone may take minutes.
    """
    with suppress(BeyondReachError):
        if ray_of_rest(system) is not None:
            return
    cubes = _cubes(system)
    bases = [list(families(cells)) for _, cells in cubes]
    too_large: dict[int, Sequence[PiecewiseFunction]] = {}
    for number in range(max(map(len, bases), default=0)):
        for k in (0, *range(len(cubes) - 1, 0, -1)):
            if number >= len(bases[k]):
                continue
            (radius, cells), basis, formulas = cubes[k], bases[k][number], list[PiecewiseExpression]()
            if k not in too_large or not set(too_large[k]).issubset(basis):
                try:
                    formulas = list(_of_family(system, cells, basis, positive=positive, entries=entries))
                except _TooLargeError:
                    too_large[k] = basis
            yield from ((radius, formula) for formula in formulas)
            if k and not formulas:
                break


class _TooLargeError(ValueError):
    """A program with more entries than are solved."""


def _cubes(system: SwitchedSystem) -> list[tuple[Number, SignCells]]:
    """The checked cube and smaller ones, as far as their cells are looked at; one where all look alike."""
    cubes: list[tuple[Number, SignCells]] = []
    for scale in SCALES:
        radius = system.check.radius * scale
        try:
            cubes.append((radius, build_cells(system, radius)))
        except BeyondReachError:
            continue
        if scale == 1 and _looks_alike(cubes[0][1]):
            break
    return cubes


def _looks_alike(cells: SignCells) -> bool:
    """Whether the system is the same at every distance."""
    degrees = {sum(e) for cell in cells.cells for field in cell.velocities for p in field for e in p.terms}
    return cells.are_cones and len(degrees) <= 1


def _of_family(
    system: SwitchedSystem, cells: SignCells, basis: Sequence[PiecewiseFunction], *, positive: bool, entries: range
) -> Iterator[PiecewiseExpression]:
    """Sums of the functions of a basis, coefficients rounded more and more finely.

    Raises:
        _TooLargeError: for a program beyond the sizes that are solved.
    """
    try:
        above, falling, parameters = _problems(system, cells.radius, tuple(basis))
    except BeyondReachError:
        return
    problems = [*above, *falling] if positive else falling
    size = sum(gram_entries(blocks) for _, blocks in problems)
    if size >= entries.stop:
        raise _TooLargeError
    if size < entries.start:
        return
    solved = solve_inside(problems, parameters, bounded=True)
    seen = {"0"}
    for denominator in DENOMINATORS if solved is not None else ():
        coefficients = None if solved is None else round_parameters(*solved, denominator)
        text = "0" if coefficients is None else formula_text(basis, _unscaled(basis, coefficients, cells.radius))
        if text in seen:
            continue
        seen.add(text)
        try:
            yield parse_piecewise(text, system.states)
        except ExpressionError:
            return


@lru_cache(maxsize=MOST_KEPT)
def _problems(
    system: SwitchedSystem, radius: fmpq, basis: tuple[PiecewiseFunction, ...]
) -> tuple[list[Problem], list[Problem], int]:
    """That a sum of functions is positive, and that it falls, affine in its coefficients and in those of mu.

    In the displacement divided by the half-width of the cube, every function is as large near the point as that is.
    They are asked for by searches for both signs of V, in small programs and in large ones.

    Returns:
        The claims of either kind, and how many coefficients there are.
    """
    stated = stated_cells(system, system.field(radius))
    functions = functions_on(system, stated, [function.text for function in basis])
    by_function = [functions.claims(k) for k in range(len(basis))]
    sizes = [radius**function.degree for function in basis]
    parameters, above, falling = len(basis), list[Problem](), list[Problem]()
    for claims in zip(*by_function, strict=True):
        shapes = mu_shapes(claims)
        problems = above if claims[0].name.split()[0] == POSITIVE else falling
        for condition in map(normalized, about_sum(claims, sizes, shapes, parameters)):
            if condition.slopes:
                problems.append((condition, build_blocks(condition)))
        parameters += len(shapes)
    return above, falling, parameters


def about_sum(
    claims: Sequence[Claim], sizes: Sequence[fmpq], shapes: Sequence[Shape] = (), start: int = 0
) -> Iterator[Condition]:
    """The inequalities of a claim about a sum of functions, affine in its coefficients.

    Args:
        claims: the same about each function, on the unit cube.
        sizes: what each function is divided by.
        shapes: the monomials of functions mu.
        start: the number of the first coefficient of these.
    """
    for number, inequality in enumerate(claims[0].inequalities):
        condition = condition_of(claims[0], inequality, shapes)
        slopes = {start + k: slope for k, slope in condition.slopes.items() if slope}
        for k, (claim, size) in enumerate(zip(claims, sizes, strict=True)):
            terms = terms_of(claim.inequalities[number].value)
            if terms:
                slopes[k] = {e: c / size for e, c in terms.items()}
        yield replace(condition, constant={}, slopes=dict(sorted(slopes.items())))


def _unscaled(basis: Sequence[PiecewiseFunction], coefficients: Sequence[fmpq], radius: fmpq) -> list[fmpq]:
    top = max(function.degree for function in basis)
    values = [c * radius ** (top - f.degree) for f, c in zip(basis, coefficients, strict=False)]
    return values


SPEED = Fraction(1, 16)  # of a product that falls where it is negative
HIGHEST_POWER = 3  # of a state in a product


def find_growth(system: SwitchedSystem, entries: range = SMALL) -> Record | None:
    """The entry of a certificate that shows instability by a V; None where none is found.

    Args:
        system: in two states or more.
        entries: the sizes of the programs that are solved.

    Raises:
        BeyondReachError: for a system that is not decided here.
    """
    proposed = proposals(system, positive=False, entries=entries)
    falling = (_shown(system, formula, radius, Effort.STRICT) for radius, formula in proposed)
    return next(filter(None, falling), None)


def find_growing_product(system: SwitchedSystem) -> Record | None:
    """The same by a product of states or of their powers, or a difference of squares; None where none shows it.

    Raises:
        BeyondReachError: for a system that is not decided here.
    """
    for radius, cells in _cubes(system):
        for formula in _products(system):
            entry = _shown(system, formula, radius, Effort.FULL, SPEED) if _may_fall(system, cells, formula) else None
            if entry is not None:
                return entry
    return None


def _shown(
    system: SwitchedSystem, formula: PiecewiseExpression, radius: Number, effort: Effort, speed: Fraction | None = None
) -> Record | None:
    """The entry by a V that falls, or with a speed where it is negative; None where that is not shown."""
    stated, conditions = conditions_on(system, formula, radius)
    falls = conditions.claims(positive=False) if speed is None else conditions.claims_by_square(speed)
    direction = negative_direction(conditions)
    if direction is None or find_failure(stated.cells, falls) is not None:
        return None
    proofs = _proofs(falls, effort)
    if proofs is None:
        return None
    hypotheses = instability_hypotheses(stated.record, formula.text, direction)
    hypotheses |= {} if speed is None else {"speed": str(speed)}
    return {"theorem": "instability", "hypotheses": hypotheses, "proofs": {**stated.proofs, **proofs}}


def _products(system: SwitchedSystem) -> Iterator[PiecewiseExpression]:
    """Negative squares; products of two states, and differences of their squares, with both signs.

    In two states also ``x**4 - x*y``, and products of powers in one quadrant; with more, where relays slide, each takes
    a second to refute.
    """
    yield from (parse_piecewise(f"-({state}**2)", system.states) for state in system.states)
    for first, second in combinations(system.states, 2):
        for text in (f"{first}*{second}", f"{first}**2 - {second}**2"):
            yield from (parse_piecewise(formula, system.states) for formula in (text, f"-({text})"))
    if len(system.states) != 2:
        return
    first, second = system.states
    for state, power, sign in product(system.states, range(3, HIGHEST_POWER + 3), ("", "-")):
        yield parse_piecewise(f"{state}**{power} {sign or '+'} {first}*{second}", system.states)
    for powers in sorted(product(range(1, HIGHEST_POWER + 1), repeat=2), key=sum):
        for signs in product(("", "-"), repeat=2):
            sides = [f"relu({sign}{state})" for sign, state in zip(signs, system.states, strict=True)]
            yield parse_piecewise(f"-{'*'.join(written_powers(sides, powers))}", system.states)


def _may_fall(system: SwitchedSystem, cells: SignCells, formula: PiecewiseExpression) -> bool:
    """Whether a product is negative at some of many points, and falls with :data:`SPEED` at all of these."""
    value, positive = _where_not_zero(system, formula)
    slopes = [value.derivative(name).terms for name in system.states]
    points = float(cells.radius) * sample_points(len(slopes), bounded=True)
    for below in (value, *(-inner for inner in positive)):
        points = points[float_values(below.terms, points) < 0]
    for cell_points, field in _fields_at(cells, points):
        rates = [float(SPEED) * np.square(float_values(value.terms, cell_points))]
        for slope, part in zip(slopes, field, strict=True):
            rates.append(float_values(slope, cell_points) * float_values(part.terms, cell_points))
        if np.any(sum(rates) > SLACK * sum(map(np.abs, rates))):
            return False
    return len(points) > 0


def _where_not_zero(system: SwitchedSystem, formula: PiecewiseExpression) -> tuple[Polynomial, list[Polynomial]]:
    """A product as a polynomial where all its rectifiers act, and what is positive there."""
    positive: list[Polynomial] = []

    def sign_of(inner: Polynomial) -> int:
        positive.append(inner)
        return 1

    states = system.named()
    return formula.polynomial(states, sign_of), positive


def _fields_at(cells: SignCells, points: Floats) -> Iterator[tuple[Floats, Field]]:
    """The points (m, n) that lie in each cell, with each of its fields."""
    for cell in cells.cells:
        inside = np.ones(len(points), dtype=bool)
        for sign, surface in zip(cell.signs, cells.surfaces, strict=True):
            inside &= sign * float_values(surface.terms, points) > 0
        yield from ((points[inside], field) for field in cell.velocities)


def _proofs(claims: Sequence[Claim], effort: Effort) -> Record | None:
    """Evidence of all claims; None where that of one is not found."""
    proofs = {}
    for claim in claims:
        proof = answer(claim, effort).found
        if proof is None:
            return None
        proofs[claim.name] = proof.evidence
    return proofs


# ---- a relay whose sign shows late in the derivatives of its switching function ------------------
#
# Then the point is unstable.
#
# Let s be a switching surface through the point, ``h_0 = s`` and ``h_i`` its derivatives along the field, the same
# polynomial on all cells near the point for ``i < r``, while ``h_r`` at the point has the sign ``-e`` on every cell
# where s has the sign e (or e on every one).  Along a solution ``s h_r`` can be integrated by parts::
#
#     r = 2 m + 1:   B = sum_{i<m} (-1)^i h_i h_(2m-i) + (-1)^m h_m^2/2,    B' = s h_r
#     r = 2 m:       B = sum_{i<m} (-1)^i h_i h_(2m-1-i),                   B' = s h_r - (-1)^m h_m^2
#
# Near the point ``s h_r`` is ``-k abs(s)`` (or ``k abs(s)``) with k bounded away from zero, whatever else the field
# does. Where the signs of both terms agree, always for odd r, ``W = -B`` or ``W = B`` never falls.  For ``r > 1`` it
# takes positive values at all distances, as the gradients of ``h_0, ..., h_(r-1)`` are independent.  A solution that
# started there and stayed near would have a limit set of solutions on which W is a positive constant: then ``s = 0``
# all the time, so all ``h_i = 0`` and ``W = 0``.  Of relays and integrators in a row this is known since Anosov (1959);
# here the rest of the field is arbitrary.


@dataclass(frozen=True)
class RelayDegree:
    """A surface with its relative degree, and a function that shows instability.

    Attributes:
        surface: number of the surface s.
        degree: r, the first derivative of s that depends on its sign.
        rising: W, which never falls near the point, and rises where s is not zero.
        direction: d with ``W(t d) > 0`` for small t.
    """

    surface: int
    degree: int
    rising: CheckedPolynomial
    direction: tuple[Fraction, ...]


def high_degree_relay(system: SwitchedSystem, cells: SignCells) -> RelayDegree | None:
    """A surface that shows instability; None where none does.

    Args:
        system: right-hand sides that only enclose the field say nothing here.
        cells: of a cube about the point.
    """
    if system.only_encloses:
        return None
    return next(_found(cells), None)


def show_relay_of(system: SwitchedSystem, verdict: str) -> Entry:
    """Evidence that the point is unstable by W and by functions that rise where W is kept.

    Where ``s = h_0 = 0`` and W is kept, ``(h_0 h_1)' = h_1^2 + h_0 h_2`` is not negative, and zero where ``h_1 = 0``;
    there ``(h_1 h_2)' = h_2^2``, and so on up to ``h_(r-1)``.  Where all of these are zero W is zero, and points at
    which W is not positive do not count.

    Args:
        system: in any number of states.
        verdict: unstable.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where no surface shows it, or no such functions are found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    subject, search = started(system)
    for share in SCALES:
        stated = stated_cells(system, system.check.radius * share)
        relay = high_degree_relay(system, stated.cells)
        if relay is None:
            continue
        ladder = _ladder(stated.cells, relay.surface)
        products = (before * after for before, after in pairwise(ladder))
        function, *others = (polynomial_text(polynomial, system.states) for polynomial in (-relay.rising, *products))
        second = find_second(subject, stated.record, function, search, below=Fraction(0), others=others)
        if second is not None:
            near = [np.array(relay.direction, dtype=float)]
            with suppress(NotShownError):
                hypotheses = directed_hypotheses(subject, stated.record, function, search, second, near=near)
                return search.entry(subject, "instability", hypotheses)
    raise NotShownError("no relay was found whose relative degree shows it")


def _found(cells: SignCells) -> Iterator[RelayDegree]:
    for number in range(len(cells.surfaces)):
        ladder = _ladder(cells, number)
        degree = len(ladder)
        sense = _sense(cells, number, ladder[-1]) if 2 <= degree <= len(cells.states) else 0
        if not sense or (degree % 2 == 0 and sense != -((-1) ** (degree // 2))):
            continue
        direction = _direction(ladder, sense)
        if direction is not None:
            yield RelayDegree(number, degree, _by_parts(ladder).times(sense), direction)


def _fields(cells: SignCells, number: int) -> Iterator[tuple[int, Field]]:
    """The fields of all cells near the point, each with the sign of a surface there."""
    for cell in adjoining(cells):
        yield from ((cell.signs[number], field) for field in cell.velocities)


def _ladder(cells: SignCells, number: int) -> list[CheckedPolynomial]:
    """``h_0, ..., h_(r-1)``: as long as they vanish at the point and the next one is the same on all cells near it."""
    ladder: list[CheckedPolynomial] = []
    following = cells.forms[number]
    while following and not following.at_origin and len(ladder) <= len(cells.states):
        ladder.append(following)
        first, *others = (lie_derivative(following, field) for _, field in _fields(cells, number))
        if any(other != first for other in others):
            return ladder
        following = first
    return []


def _sense(cells: SignCells, number: int, last: CheckedPolynomial) -> int:
    """Whether the field pushes s away from zero in its last derivative (1) or back (-1) on all cells; else 0."""
    values = [sign * lie_derivative(last, field).at_origin for sign, field in _fields(cells, number)]
    return 1 if all(v > 0 for v in values) else -1 if all(v < 0 for v in values) else 0


def _by_parts(ladder: Sequence[CheckedPolynomial]) -> CheckedPolynomial:
    """B."""
    top, total = len(ladder) - 1, constant(ladder[0].count, 0)
    for i in range((top + 1) // 2):
        total += (ladder[i] * ladder[top - i]).times((-1) ** i)
    if top % 2 == 0:
        total += ladder[top // 2].power(2).times(Fraction((-1) ** (top // 2), 2))
    return total


def _direction(ladder: Sequence[CheckedPolynomial], sense: int) -> tuple[Fraction, ...] | None:
    """The d with ``grad h_0 . d = 1``, ``grad h_(r-1) . d = sense`` and zero between; None for dependent gradients."""
    count = ladder[0].count
    slopes = [[h.slope(k) for k in range(count)] for h in ladder]
    rows = fmpq_mat([list(map(as_fmpq, row)) for row in slopes])
    gram = rows * rows.transpose()
    if not gram.det():
        return None
    wanted = [[fmpq(0)] for _ in ladder]
    wanted[0], wanted[-1] = [fmpq(1)], [fmpq(sense)]
    direction = rows.transpose() * gram.inv() * fmpq_mat(wanted)
    return tuple(as_fraction(direction[k, 0]) for k in range(count))
