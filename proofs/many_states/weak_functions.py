"""A search for a V that does not rise along any solution, in many states: energies, with their sign turned or not.

At points of cells and of faces on which the functions of a basis bend, V' is at most zero along the extreme velocities
of the solutions there; that is linear in the coefficients of V.  The least weighted sum of coefficients is proposed for
which V is at least a norm at points of all cells (an energy that shows stability), or at most minus one at a point
of an axis (one that shows instability).  Energies have simple coefficients, so that rounding meets the equalities; what
is proposed is proved, or is dropped.  A relay that gains energy, ``x' = y, y' = -sign(x) + a y``, has
``V = -(abs(x) + y^2/2)`` with ``V' = -a y^2``; that nothing stays where ``V' = 0`` shows a further function
(:mod:`nonsmooth.proofs.kernel.second_function`).
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property, lru_cache, partial
from itertools import islice, product
from math import comb

import numpy as np
from flint import fmpq_mat

from nonsmooth.proofs.checker.cells import Face
from nonsmooth.proofs.checker.polynomials import Polynomial as CheckedPolynomial
from nonsmooth.proofs.checker.polynomials import lie_derivative
from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import least_sum, some_contradict
from nonsmooth.proofs.kernel.bases import (
    PiecewiseFunction,
    families,
    formula_text,
    functions_on,
    monomial,
    monomials,
    rates,
    values,
)
from nonsmooth.proofs.kernel.cells import BeyondReachError, StatedCells, sharpened, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.first_terms import fields_around, neutral_subspace
from nonsmooth.proofs.kernel.homogeneity import homogeneity_of
from nonsmooth.proofs.kernel.quotients import coefficients_of, kept_forms, proposed
from nonsmooth.proofs.kernel.search import Entry, Functions, NotShownError, Search, directed_hypotheses, sample_points
from nonsmooth.proofs.kernel.second_function import find_second, rounded
from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.proofs.kernel.written import (
    combined,
    formula_in_states,
    part_of,
    powers_between,
    terms_of,
    vanishing_columns,
    vanishing_combinations,
)
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, examine
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, build_blocks
from nonsmooth.proofs.sums_of_squares.conic_program import round_parameters, solve_inside
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.domain import cube_text
from nonsmooth.proofs.systems.energies import energies_within
from nonsmooth.symbolic.formulas.enclosed_functions import TURNING, Wave
from nonsmooth.symbolic.formulas.piecewise import MAX_DEGREE, PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.formulas.trees import ExpressionError, formula_tree, names_of, with_names, written
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.coefficients import as_fraction, fmpq_to_float
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

SHARES = (Fraction(1), Fraction(1, 8))  # of the checked cube
MOST = 64.0  # of a coefficient, over what a power of one state has that is one at the border of the cube
SLACK = 2.0**-30  # by which floats may miss an equality
THIN = 2.0**-20  # a distance from planes, in units of half the side of the cube
BESIDE = 2.0**-12  # of a distance from planes on which a velocity changes its sign
MOST_KEPT = 8  # cubes with their families
MOST_ROUNDS = 4  # of one program, with points that refuted the proposals before


def weak_functions(
    system: SwitchedSystem, radius: Number, *, positive: bool, power: int = 2
) -> Iterator[PiecewiseExpression]:
    """Proposals of V in the displacement.

    Args:
        system: in two states or more.
        radius: half the side of a cube.
        positive: whether V is to be positive; else it is to be negative at a point of an axis.
        power: of the distance, which V is at least; of a function of some degree.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
        ExpressionError: for sums that are too long.
    """
    seen = {"0"}
    for family in families_on(system, radius):
        basis = family.basis
        if power > max(function.degree for function in basis):
            continue
        for columns in (fmpq_mat(np.eye(len(basis), dtype=int).tolist()), family.kept):
            if not columns.ncols():
                continue
            for chosen in family.program.combined(columns).solutions(power, positive=positive):
                text = formula_text(basis, coefficients_of(columns, chosen))
                if text not in seen:
                    seen.add(text)
                    yield parse_piecewise(text, system.states)
        if positive and family.beside_neutral.ncols():
            rows = np.vstack([-family.program.rates, family.program.values])
            for chosen in proposed(rows @ np.array(family.beside_neutral.tolist(), dtype=float)):
                text = formula_text(basis, coefficients_of(family.beside_neutral, chosen))
                yield parse_piecewise(text, system.states)


@dataclass(frozen=True)
class FunctionFamily:
    """Functions whose sums are tried.

    Attributes:
        system: whose solutions they shall not rise along.
        stated: its cells.
        basis: the functions.
        search: shows that they are continuous, where they bend on curves.
    """

    system: SwitchedSystem
    stated: StatedCells
    basis: tuple[PiecewiseFunction, ...]
    search: Search | None = None

    @cached_property
    def program(self) -> LinearProgram:
        """The program of their sums."""
        costs = np.array([1.0 + function.degree / 8 + ("Abs" in function.text) for function in self.basis])
        beside = cache(partial(rates, self.conditions, near_planes))
        radius = fmpq_to_float(self.stated.cells.radius)
        return LinearProgram(rates(self.conditions), *values(self.conditions), costs, beside, radius)

    @cached_property
    def kept(self) -> fmpq_mat:
        """Columns of coefficients whose sums stay constant to first order."""
        return kept_forms(self._claims)

    @cached_property
    def beside_neutral(self) -> fmpq_mat:
        """Columns of coefficients whose sums do not rise beside the neutral subspaces of cells, to first order.

        Where eigenvalues of the field of a cell lie on the imaginary axis, no V falls on the whole subspace N of these:
        one that does not rise is kept there, and V' has no terms of first order beside N.  No columns without an N.
        """
        conditions = self.conditions
        fields = [field for cell in conditions.inclusion.cells for _, field in cell.fields]
        neutral = [
            (k, coordinates) for k, coordinates in enumerate(map(neutral_subspace, fields)) if coordinates is not None
        ]
        lists: list[list[CheckedPolynomial]] = [[] for _ in self.basis]
        for claims, polynomials in zip(self._claims, lists, strict=True):
            for k, coordinates in neutral:
                rate = claims[k].inequalities[0].value
                parts = (rate, *map(rate.derivative, range(rate.count)))
                polynomials += [part.on(coordinates, coordinates[0].count) for part in parts]
        return vanishing_columns(lists) if neutral else fmpq_mat(0, 0)

    @cached_property
    def vanishing(self) -> fmpq_mat:
        """Columns of coefficients whose sums stay constant on all cells."""
        return vanishing_columns(
            [[inequality.value for claim in same for inequality in claim.inequalities] for same in self._claims]
        )

    @cached_property
    def _claims(self) -> list[list[Claim]]:
        """Of each function, that it falls on closed cells."""
        return list(map(self.conditions.claims_on_cells, range(len(self.basis))))

    @cached_property
    def conditions(self) -> Functions:
        """The claims about the functions."""
        return functions_on(self.system, self.stated, [function.text for function in self.basis], self.search)


@lru_cache(maxsize=MOST_KEPT)
def families_on(system: SwitchedSystem, radius: Number) -> tuple[FunctionFamily, ...]:
    """The families on a cube, for energies and for what shows instability; raises as :func:`weak_functions`."""
    stated = stated_cells(system, radius)
    all_families = [FunctionFamily(system, stated, basis) for basis in families(stated.cells, all_lines=True)]
    bends = tuple(PiecewiseFunction(f"Abs({text})", 1) for text in dict.fromkeys(_bent_lines(system)))
    if bends and not any(system.check.equilibrium):
        with suppress(NotShownError, BeyondReachError):
            subject, search = started(system)
            sharpened_cells = sharpened(stated, subject, search)
            family = FunctionFamily(system, sharpened_cells, (*bends, *monomials(system.states, 2)), search)
            family.conditions  # noqa: B018 - whether they are shown to be continuous
            all_families.append(family)
    return tuple(all_families)


def _bent_lines(system: SwitchedSystem) -> Iterator[str]:
    """What right-hand sides take the sign of, where that itself switches, as a bang-bang law by a curved line does."""
    for side in system.rhs:
        for part in side.switching_parts:
            call = part.tree
            if isinstance(call, ast.Call) and len(call.args) == 1:
                inner = replace(part, tree=call.args[0])
                if inner.switching_parts:
                    yield written(inner.tree)


def near_planes(place: Face) -> Floats:
    """Coordinates of points of a place, many of them near planes, but none so near as to count as there.

    Planes of coordinates, and those on which a velocity that is a linear form changes its sign.
    """
    forms = (place.restricted(part) for cell in place.inclusion.cells for _, field in cell.fields for part in field)
    linear = (form for form in forms if form.degree == 1 and not form.at_origin)
    normals = {tuple(float(form.slope(k)) for k in range(place.dimension)) for form in linear}
    samples = [sample_points(place.dimension, bounded=True)]
    for normal in map(np.array, sorted(normals)):
        samples.append(samples[0] - (1 - BESIDE) * np.outer(samples[0] @ normal, normal) / (normal @ normal))
    points = np.vstack(samples)
    return points[np.all(np.abs(points) > THIN, axis=1)]


@dataclass(frozen=True)
class LinearProgram:
    """The least coefficients of functions whose sum V rises along no row, and is positive, or negative somewhere.

    Attributes:
        rates: of the functions along extreme velocities, of shape (m, k).
        points: of all cells, of shape (n, states).
        values: of the functions there, of shape (n, k).
        costs: of the functions.
        beside: further rates, of which those that refute a proposal are added.
        radius: half the side of the cube: what the functions are of, over the coordinates of points.
    """

    rates: Floats
    points: Floats
    values: Floats
    costs: Floats
    beside: Callable[[], Floats]
    radius: float

    def combined(self, columns: fmpq_mat) -> LinearProgram:
        """The same about sums of the functions; many rows need such sums to meet equalities that rounding breaks."""
        sums = np.array(columns.tolist(), dtype=float)
        beside = cache(lambda: self.beside() @ sums)
        costs = self.costs @ np.abs(sums)
        return replace(self, rates=self.rates @ sums, values=self.values @ sums, costs=costs, beside=beside)

    def solutions(self, power: int | Floats, *, positive: bool) -> Iterator[list[Fraction]]:
        """In short fractions, of a V that is positive like these powers of the states, or negative somewhere."""
        sizes = np.sum(np.abs(self.points) ** power, axis=1)
        most = MOST * max(1.0, self.radius ** -float(np.max(power)))
        if positive:
            constraints = [(-self.values, -sizes)]
        else:
            along = self.points / np.sqrt(sizes)[:, None]
            axes = [int(np.argmax(side * along[:, k])) for k in range(along.shape[1]) for side in (1, -1)]
            constraints = [(self.values[[k]], -sizes[[k]]) for k in axes]
        for matrix, limits in constraints:
            rows = self.rates
            for _ in range(MOST_ROUNDS):
                bounds = np.r_[np.zeros(len(rows)), limits]
                stated = np.vstack([rows, matrix]), bounds, self.costs, most
                solved = None if some_contradict(*stated) else least_sum(*stated)
                if solved is None:
                    break
                coefficients = rounded(solved, partial(_holds, rows, matrix))
                rising = (
                    self.beside() @ (solved if coefficients is None else np.array(list(map(float, coefficients))))
                    > SLACK
                )
                if not rising.any():
                    if coefficients is not None:
                        yield coefficients
                    break
                rows = np.vstack([rows, self.beside()[rising]])


def _holds(rows: Floats, matrix: Floats, coefficients: Floats) -> bool:
    """Whether V rises along no row, and has the signs that are asked for."""
    return bool(np.all(rows @ coefficients <= SLACK) and np.all(matrix @ coefficients < 0))


# ---- functions that are proved -------------------------------------------------------------------


def find_weak_lyapunov(system: SwitchedSystem) -> ExaminedLyapunov | None:
    """A positive V that does not rise; None where none is found.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    for formula, radius in energies_near(system):
        examined = examine(system, formula, radius)
        if examined.decrease in (Decrease.STRICT, Decrease.WEAK):
            return examined
    return None


def energies_near(system: SwitchedSystem) -> Iterator[tuple[PiecewiseExpression, Number]]:
    """Proposals of a positive V that does not rise, with half the side of a cube; none on cubes beyond reach."""
    for power, share in product((2, 4), SHARES):
        radius = system.check.radius * share
        for energy in energies_within(system, radius) if power == 2 else ():
            yield energy, radius
        with suppress(BeyondReachError, ExpressionError):
            for formula in weak_functions(system, radius, positive=True, power=power):
                yield formula, radius


def find_weak_growth(system: SwitchedSystem, search: Search | None = None) -> Entry | None:
    """The theorem on instability by a V that does not rise; None where none is found.

    Args:
        system: in two states or more, with rational numbers.
        search: with what was shown before.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    for share in SHARES:
        radius = system.check.radius * share
        for formula in weak_functions(system, radius, positive=False):
            try:
                subject, search = started(system, search)
                bent = stated_cells(system, radius, surfaces_of(system, formula))
                cells = sharpened(bent, subject, search).record
                second = find_second(subject, cells, formula.text, search, below=Fraction(0))
                if second is not None:
                    hypotheses = directed_hypotheses(subject, cells, formula.text, search, second)
                    return search.entry(subject, "instability", hypotheses)
            except NotShownError:
                continue
    return None


# ---- stability by energies with sines and cosines ------------------------------------------------
#
# The system on circles (:mod:`nonsmooth.proofs.checker.circles`).
#
# In the coordinates ``sin x`` and ``cos x - 1`` of its angles a system with sines is one with polynomials, in more
# states.  Energies are searched there as in any such system (:mod:`.weak_functions`); the checker shows what is found.


def find_energy_on_circles(system: SwitchedSystem) -> tuple[Record, str, str, bool] | None:
    """The entry of a certificate that shows stability, its V and its domain for people, and whether V is kept.

    None where none is found.

    Args:
        system: in any number of states, with sines or cosines of some.
    """
    angles = _angles(system)
    if not angles:
        return None
    try:
        circle_system = on_circles(system, angles)
        examined = None if circle_system is None else find_weak_lyapunov(circle_system)
        if circle_system is None or examined is None:
            return None
        cells = stated_cells(circle_system, examined.radius, surfaces_of(circle_system, examined.formula)).record
        hypotheses = {"angles": list(angles), "cells": cells, "function": examined.formula.text}
        entry, _ = Search().entry(read_subject(about(system)), "circles", hypotheses)
    except (BeyondReachError, NoCertificateError, NotShownError, SceneError):
        return None
    function, domain = examined.formula.text, cube_text(examined.radius, circle_system.states)
    for name in angles:
        sine, cosine = f"sin({name})", f"cos({name}) - 1"
        function = function.replace(f"sin_{name}", sine).replace(f"cos_{name}", f"({cosine})")
        domain = domain.replace(f"sin_{name}", sine).replace(f"cos_{name}", cosine)
    return entry, function, domain, examined.is_kept


def _angles(system: SwitchedSystem) -> tuple[str, ...]:
    """The states of which there are sines and cosines; none unless all of these are 0 at the point."""
    if system.rewriting.names_roots:
        return ()
    try:
        arguments = [system.argument_of(wave) for wave in system.rewriting.names]
    except ExpressionError:  # what switches
        return ()
    angles = set()
    for argument in arguments:
        for exponents in argument.terms:
            angles |= {name for name, exponent in zip(system.states, exponents, strict=True) if exponent}
    at = system.named(system.check.equilibrium)
    return () if any(at[name] for name in angles) else tuple(name for name in system.states if name in angles)


def on_circles(system: SwitchedSystem, angles: Sequence[str]) -> SwitchedSystem | None:
    """The system in the coordinates; None where an angle stands outside sines and cosines, or not in whole multiples.

    Raises:
        SceneError: for formulas that cannot be used.
    """
    pairs = [(f"sin_{name}", f"cos_{name}") if name in angles else (name,) for name in system.states]
    coordinates = tuple(coordinate for pair in pairs for coordinate in pair)
    if len(set(coordinates)) < len(coordinates):
        return None
    values = {name: Polynomial.variable(system.field, coordinates, name) for name in coordinates}
    try:
        polynomials = {wave.name: _turned(wave, system, values) for wave in system.rewriting.names}
        stated = [
            _text(side, polynomials, [name for name in system.states if name not in angles])
            for side in system.rewriting.named_rhs
        ]
    except ExpressionError:
        return None
    rhs = []
    for name, text in zip(system.states, stated, strict=True):
        rhs += [f"(1 + cos_{name})*({text})", f"-sin_{name}*({text})"] if name in angles else [text]
    at = system.named(system.check.equilibrium)
    squares = parse_piecewise(" + ".join(f"{name}**2" for name in coordinates), coordinates)
    zero = system.field.zero
    check = replace(
        system.check, equilibrium=tuple(at.get(name, zero) for name in coordinates), lyapunov=squares, is_default=True
    )
    sides = tuple(parse_piecewise(text, coordinates) for text in rhs)
    plain = replace(system.rewriting, written=(), waves=(), named_rhs=(), names=())
    return replace(system, states=coordinates, rhs=sides, check=check, others=(), rewriting=plain)


def _turned(wave: Wave, system: SwitchedSystem, values: Mapping[str, Polynomial]) -> Polynomial:
    """A sine or cosine of a sum of whole multiples of angles.

    Raises:
        ExpressionError: for another one.
    """
    if wave.kind not in TURNING:
        raise ExpressionError("required sines and cosines alone")
    one = next(iter(values.values())) * 0 + 1
    sine, cosine = one * 0, one
    for exponents, value in system.argument_of(wave).terms.items():
        turns = value.as_rational()
        if sum(exponents) != 1 or turns is None or turns.q != 1 or abs(turns) > MAX_DEGREE:
            raise ExpressionError(f"required sums of whole multiples of angles, none above {MAX_DEGREE}")
        name = system.states[exponents.index(1)]
        angle_sine, across = values[f"sin_{name}"], values[f"cos_{name}"] + 1
        angle_sine = angle_sine if turns > 0 else -angle_sine
        for _ in range(abs(int(turns.p))):
            sine, cosine = sine * across + cosine * angle_sine, cosine * across - sine * angle_sine
    return sine if wave.kind == "sin" else cosine


def _text(side: PiecewiseExpression, waves: Mapping[str, Polynomial], others: Sequence[str]) -> str:
    """A formula with polynomials in place of its sines and cosines.

    Raises:
        ExpressionError: where it names another state than these.
    """
    states = {name for name in side.states if name not in waves}
    if not names_of(side.tree) & states <= set(others):
        raise ExpressionError("required angles under sines and cosines alone")
    return written(with_names(side.tree, {name: formula_tree(str(value)) for name, value in waves.items()}))


# ---- polynomials that all solutions near a point keep --------------------------------------------
#
# Of these one that is positive shows that the point is stable.
#
# Where one polynomial field f acts near the point, ``grad I . f = 0`` is linear in the coefficients of I: the integrals
# of some degree are a linear space, with the products of integrals of lower degree.  Those without linear terms are
# sought whose quadratic form is positive definite, as energies with their Casimir functions are (Arnold 1966), or that
# are sums of squares, as energies of springs without a linear part are: V is kept exactly, and positive near the point.


MOST_DEGREE = 6
MOST_FORMS = 60  # of one weight
MOST_UNKNOWNS = 250  # coefficients of an integral
DENOMINATORS = (1, 8, 64)  # of the coefficients of integrals in V
INTEGRAL_SHARES = (Fraction(1), Fraction(1, 8), Fraction(1, 64))  # of the checked cube


def find_kept_function(system: SwitchedSystem) -> ExaminedLyapunov | None:
    """A positive V that solutions keep; None where none is found.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    try:
        subject, search = started(system)
        stated = stated_cells(system, system.check.radius)
        around = {tuple(field) for field in fields_around(stated, subject.stated, search)}
    except NotShownError:
        return None
    if len(around) != 1 or system.by_roots is not None:
        return None
    radius = as_fraction(stated.cells.radius)
    for proposal in _positive_integrals(around.pop()):
        text = formula_in_states(proposal, radius, system.states)
        formula = parse_piecewise(text, system.states)
        for share in INTEGRAL_SHARES:
            examined = examine(system, formula, system.check.radius * share, effort=Effort.FULL)
            if examined.decrease is Decrease.WEAK:
                return examined
    return None


def find_kept_form(system: SwitchedSystem) -> ExaminedLyapunov | None:
    """A positive form of one weight that solutions keep, of a field that is homogeneous beside the point.

    With weights ``r_k`` it is a sum of products of powers of weight ``2 max r``, one state perhaps in absolute value.
    The chain ``x' = y, y' = z, z' = -sign(y)`` has the weights 3, 2, 1, and with ``J = x + abs(y) z + z^3/3`` keeps
    ``J^2 + (abs(y) + z^2/2)^3``.  Raises as :func:`find_kept_function`.
    """
    homogeneity = homogeneity_of(system, system.check.radius)
    if homogeneity is None or homogeneity.orders != (1,) * len(system.states):
        return None
    degree, states = 2 * max(homogeneity.weights), system.states
    basis = tuple(islice(_forms_of_weight(states, homogeneity.weights, degree), MOST_FORMS + 1))
    if len(basis) > MOST_FORMS:
        return None
    bends = parse_piecewise(" + ".join(map("Abs({})".format, states)), states)
    family = FunctionFamily(system, stated_cells(system, system.check.radius, surfaces_of(system, bends)), basis)
    columns = family.vanishing
    if not columns.ncols():
        return None
    program = replace(family.program, points=system.check.half_width * family.program.points)
    powers = np.array([float(degree / weight) for weight in homogeneity.weights])
    for chosen in program.combined(columns).solutions(powers, positive=True):
        formula = parse_piecewise(formula_text(basis, coefficients_of(columns, chosen)), states)
        examined = examine(system, formula, system.check.radius, effort=Effort.FULL)
        if examined.decrease is Decrease.WEAK:
            return examined
    return None


def _forms_of_weight(
    states: Sequence[str], weights: Sequence[Fraction], degree: Fraction
) -> Iterator[PiecewiseFunction]:
    """Products of powers of some weight, alone and times the absolute value of a state."""
    for exponents in product(*(range(int(degree / weight) + 1) for weight in weights)):
        rest = degree - sum(map(operator.mul, exponents, weights))
        function = monomial(states, exponents)
        if not rest:
            yield function
        for weight, name in zip(weights, states, strict=True):
            if rest == weight:
                yield PiecewiseFunction(f"{function.text}*Abs({name})".removeprefix("1*"), function.degree + 1)


def _positive_integrals(field: Sequence[CheckedPolynomial]) -> list[CheckedPolynomial]:
    """Integrals of least degree with a positive definite quadratic form, or that are positive as they are."""
    count = len(field)
    for degree in range(2, MOST_DEGREE + 1):
        if comb(count + degree, degree) > MOST_UNKNOWNS:
            break
        monomials = powers_between(count, 2, degree)
        combinations = list(vanishing_combinations([[lie_derivative(polynomial, field)] for polynomial in monomials]))
        integrals = [combined(monomials, coefficients) for coefficients in combinations]
        forms = [part_of(integral, 2) for integral in integrals]
        for parts in (forms, integrals):
            proposals = _definite(integrals, parts, count)
            if proposals:
                return proposals
    return []


def _definite(
    integrals: Sequence[CheckedPolynomial], parts: Sequence[CheckedPolynomial], count: int
) -> list[CheckedPolynomial]:
    """Sums of integrals in which the sum of these parts is positive, as a semidefinite program proposes them."""
    condition = Condition({}, dict(enumerate(map(terms_of, parts))), (), (), count)
    if not condition.support:
        return []
    solved = solve_inside([(condition, build_blocks(condition))], len(parts), bounded=True)
    if solved is None:
        return []
    proposals = []
    for denominator in DENOMINATORS:
        values = round_parameters(*solved, denominator)
        if values is not None and any(values):
            proposals.append(combined(integrals, list(map(as_fraction, values))))
    return proposals
