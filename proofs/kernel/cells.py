"""The cells of a system: the patterns of signs of its switching surfaces that the checked cube has.

*Affine surfaces.*  A pattern is left out only where its open cell is proved to be empty in the cube (an exact linear
program).

*Curved surfaces* are taken with both signs everywhere, also in cones that the surface does not meet near the point: a
pattern too many adds an inequality, and never a wrong verdict, because F is then the hull of more velocities.  Samples
propose patterns that they do not have, and the checker's claims show these.

*As certificates state them*, with functions: surfaces, and patterns that are empty, with the mixtures that show it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq

from nonsmooth.analysis.cells.switched_cells import TooManyCells, smooth_pieces, square_regions
from nonsmooth.proofs.checker import polynomials
from nonsmooth.proofs.checker.cells import Domain, Inclusion, Pattern, Surfaces, System, pattern
from nonsmooth.proofs.checker.polynomials import unit
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.linear_program import Mixture, best_mixture
from nonsmooth.proofs.inequalities.prover import Proof, prove
from nonsmooth.proofs.kernel.search import NotShownError, Search, sample_points
from nonsmooth.proofs.kernel.subject import NoCertificateError, about, polynomial_in_names
from nonsmooth.proofs.kernel.written import as_checked, written_number
from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.proofs.sums_of_squares.prove import prove_positive
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf, parse_piecewise
from nonsmooth.symbolic.formulas.surfaces import factorize, switching_factors
from nonsmooth.symbolic.formulas.trees import ExpressionError, float_value, minus, multiplied, number, plus, written
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import Exponents, Polynomial, float_values
from nonsmooth.symbolic.systems.switched_system import (
    MAX_PATTERNS,
    PLANE,
    SwitchedSystem,
    UnknownSign,
    signs_by_factors,
)

MAX_SURFACES = 24
MAX_CELLS = 160
SAMPLES = 3_000
MAX_MAGNITUDE = 40  # bits before or after the point: sixteenth powers of such numbers are floats

Field: TypeAlias = tuple[polynomials.Polynomial, ...]
RationalTerms: TypeAlias = dict[Exponents, Any]  # by fmpq, where irrational coefficients are not asked for


class BeyondReachError(ValueError):
    """A system or a V that is not decided here, with the reason for people."""


@dataclass(frozen=True)
class SignCell:
    """An open cell of the cube.

    Attributes:
        signs: of every surface.
        velocities: one for each right-hand side, in the displacement.
    """

    signs: Pattern
    velocities: tuple[Field, ...]


@dataclass(frozen=True)
class SignCells:
    """The cells of a cube about the checked point, or of the whole space.

    Attributes:
        states: names of the states; every polynomial is in the displacement.
        surfaces: the switching surfaces of the system, and of a V.
        cells: the patterns of signs that the cube has, with the fields.
        radius: half the side of the cube; 1 in the whole space.
        beyond: whether the fields are those of the system outside the cube too; denominators are positive inside only.
        asked: the switching expressions whose signs the fields ask for.
    """

    states: tuple[str, ...]
    surfaces: tuple[Polynomial, ...]
    cells: tuple[SignCell, ...]
    radius: fmpq
    beyond: bool
    asked: frozenset[Polynomial]

    @cached_property
    def forms(self) -> Field:
        """The surfaces, written as the fields are.

        Raises:
            BeyondReachError: for irrational numbers.
        """
        return tuple(map(checked, self.surfaces))

    @property
    def are_cones(self) -> bool:
        """Whether every surface is a hyperplane through the point."""
        return all(s.degree == 1 and s.is_homogeneous for s in self.surfaces)


def build_cells(
    system: SwitchedSystem, radius: Number | None, more: Iterable[Polynomial] = (), *, irrational: bool = False
) -> SignCells:
    """The cells of a cube, or of the whole space.

    Args:
        system: in any number of states.
        radius: half the side of the cube; None for the whole space.
        more: further surfaces, of a V.
        irrational: whether fields may have irrational coefficients; they are then left as they are.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
        SceneError: for formulas that cannot be used.
    """
    states = system.displaced(system.states)
    surfaces = tuple(dict.fromkeys(s for s in (*system.surfaces(states), *more) if s.degree))
    if len(surfaces) > MAX_SURFACES:
        raise BeyondReachError(f"over {MAX_SURFACES} switching surfaces")
    read = _unread if irrational else checked
    cells: list[SignCell] = []
    expressions: set[Polynomial] = set()
    for signs in patterns(surfaces, radius):
        if len(cells) == MAX_CELLS:
            raise BeyondReachError(f"over {MAX_CELLS} cells")
        by_factors = signs_by_factors(dict(zip(surfaces, signs, strict=True)))

        def sign_of(expression: Polynomial, by_factors: SignOf = by_factors) -> int:
            expressions.add(expression)
            return by_factors(expression)

        fields = (member.velocity(sign_of, states) for member in system.members)
        velocities = tuple(tuple(read(part) for part in field) for field in fields)
        cells.append(SignCell(signs, velocities))
    size = system.field.one if radius is None else radius
    half = size.as_rational() if len(system.states) == 1 else None  # intervals may be of any size
    half = rational(size) if half is None else half
    return SignCells(
        system.states, surfaces, tuple(cells), half, not system.rewriting.denominators, frozenset(expressions)
    )


def adjoining(cells: SignCells) -> list[SignCell]:
    """The cells whose closures may hold the point."""
    at_point = [surface.at_origin.sign() for surface in cells.surfaces]
    return [cell for cell in cells.cells if all(s * v >= 0 for s, v in zip(cell.signs, at_point, strict=True))]


def rational(number: Number) -> fmpq:
    """A number as a fraction.

    Raises:
        BeyondReachError: for an irrational one, and for one so large or small that its powers are no floats.
    """
    fraction = number.as_rational()
    if fraction is None:
        raise BeyondReachError("numbers with roots")
    if fraction and abs(int(fraction.p).bit_length() - int(fraction.q).bit_length()) > MAX_MAGNITUDE:
        raise BeyondReachError(f"numbers beyond 2**{MAX_MAGNITUDE} or below 2**-{MAX_MAGNITUDE}")
    return fraction


def rational_terms(polynomial: Polynomial) -> RationalTerms:
    """A polynomial with rational coefficients.

    Raises:
        BeyondReachError: for irrational ones.
    """
    return {exponents: rational(value) for exponents, value in polynomial.terms.items()}


def checked(polynomial: Polynomial) -> polynomials.Polynomial:
    """A polynomial as the checker has it.

    Raises:
        BeyondReachError: for irrational coefficients.
    """
    return as_checked(rational_terms(polynomial), len(polynomial.variables))


def _unread(polynomial: Polynomial) -> polynomials.Polynomial:
    """The same with coefficients that nobody reads."""
    return polynomials.Polynomial(len(polynomial.variables), polynomial.terms)


def without_signs(surface: Polynomial) -> int:
    """Signs for what must not switch.

    Raises:
        BeyondReachError: always.
    """
    raise BeyondReachError("formulas that switch")


def scaled(terms: Mapping[Exponents, fmpq], factor: fmpq) -> RationalTerms:
    """A polynomial in the variables divided by a factor."""
    return {e: c * factor ** sum(e) for e, c in terms.items()}


def surfaces_of(system: SwitchedSystem, formula: PiecewiseExpression) -> tuple[Polynomial, ...]:
    """The surfaces on which a formula of the displacement switches.

    Raises:
        ExpressionError: for a formula that is no polynomial on some piece.
        BeyondReachError: for too many surfaces.
    """
    values = system.named()
    surfaces: dict[Polynomial, None] = {}
    for summand in formula.summands:
        waiting: list[dict[Polynomial, int]] = [{}]
        while waiting:
            signs = waiting.pop()
            try:
                summand.polynomial(values, signs_by_factors(signs))
            except UnknownSign as unknown:
                surfaces[unknown.surface] = None
                waiting += [{**signs, unknown.surface: sign} for sign in (-1, 1)]
            if len(surfaces) > MAX_SURFACES or len(waiting) > MAX_PATTERNS:
                raise BeyondReachError(f"over {MAX_SURFACES} surfaces on which V switches")
    return tuple(surface for surface in surfaces if surface.degree)


def patterns(surfaces: Sequence[Polynomial], radius: Number | None) -> Iterator[Pattern]:
    """All patterns of signs whose cells are not proved to be empty in the open cube; None stands for the space."""
    affine = [surface.degree == 1 for surface in surfaces]
    sides = _signs_in_floats(surfaces, radius)
    waiting: list[Pattern] = [()]
    while waiting:
        signs = waiting.pop()
        if len(signs) == len(surfaces):
            yield signs
            continue
        for sign in (-1, 1):
            longer = (*signs, sign)
            indices = [k for k in range(len(longer)) if affine[k]]
            is_sampled = bool(np.all(sides[:, indices] == [longer[k] for k in indices], axis=1).any())
            if is_sampled or not affine[len(signs)] or not is_empty([surfaces[k] * longer[k] for k in indices], radius):
                waiting.append(longer)


def _signs_in_floats(surfaces: Sequence[Polynomial], radius: Number | None) -> Floats:
    """Pattern at points of the cube, in floats: where a pattern is seen, no proof of its emptiness is looked for."""
    if not surfaces:
        return np.zeros((1, 0))
    count = len(surfaces[0].variables)
    cloud = np.random.default_rng(0).uniform(-1, 1, (SAMPLES, count)) * float(radius or 1)
    return np.column_stack([np.sign(float_values(surface.terms, cloud)) for surface in surfaces])


def is_empty(forms: Sequence[Polynomial], radius: Number | None) -> bool:
    """Whether affine forms are positive together nowhere in the open cube, or in the space, where there is none.

    Then a mixture of them and of those of the sides is not positive (Gordan).
    """
    mixture = least_mixture(forms, radius) if forms else None
    return mixture is not None and mixture.value.sign() >= 0


def least_mixture(forms: Sequence[Polynomial], radius: Number | None) -> Mixture | None:
    """The mixture of affine forms, and of those of the sides of a cube, that is constant and least.

    Its weights are of the forms first; its value is minus the constant.
    """
    field, count = forms[0].field, len(forms[0].variables)
    columns = [(*map(form.slope, range(count)), field.one) for form in forms]
    prices = [-form.at_origin for form in forms]
    if radius is not None:
        for k, side in product(range(count), (1, -1)):
            columns.append((*(field(side if i == k else 0) for i in range(count)), field.one))
            prices.append(-radius)
    return best_mixture(columns, (*(field.zero for _ in range(count)), field.one), prices)


@dataclass(frozen=True)
class StatedCells:
    """What a theorem is told of the cells.

    Attributes:
        within: half the side of the cube; None for the whole space.
        surfaces: of the system, and further ones, each once up to a factor.
        empty: patterns of signs that no point inside the cube has, as texts, with the evidence.
        cells: of the cube, or of the whole space.
    """

    within: str | None
    surfaces: tuple[Polynomial, ...]
    empty: dict[str, Record]
    cells: SignCells

    @property
    def record(self) -> Record:
        """As a certificate holds it."""
        return {
            "within": self.within,
            "surfaces": list(map(polynomial_in_names, self.surfaces)),
            "empty": list(self.empty),
        }

    @property
    def proofs(self) -> Record:
        """The evidence that patterns are empty, by the names of the claims."""
        return {f"empty {signs}": evidence for signs, evidence in self.empty.items()}


def stated_cells(
    system: SwitchedSystem, radius: Number | None, more: Iterable[Polynomial] = (), *, irrational: bool = False
) -> StatedCells:
    """The cells of a system, with the surfaces on which a switching expression is zero and does not change its sign.

    Args:
        system: in any number of states.
        radius: half the side of the cube; None for the whole space.
        more: further surfaces, of functions; what is a multiple of another one is left out.
        irrational: whether fields and surfaces may have irrational coefficients.

    Raises:
        BeyondReachError: for other irrational numbers, and for too many surfaces or cells.
    """
    unrefined = build_cells(system, radius, irrational=irrational)
    forms = {monic(surface) for surface in unrefined.surfaces}
    new = {monic(surface): surface for surface in (*more, *even_factors(unrefined.asked))}
    further = [surface for form, surface in new.items() if form not in forms]
    cells = build_cells(system, radius, further, irrational=irrational)
    within = None if radius is None else str(radius)
    return StatedCells(within, cells.surfaces, dict(_empty_patterns(cells, radius)), cells)


def even_factors(expressions: Iterable[Polynomial]) -> list[Polynomial]:
    """Factors of expressions, not constant, where these keep their signs: with even powers, and definite forms."""
    factored = filter(None, map(factorize, expressions))
    powers = {power for _, factors in factored for power in factors}
    return sorted({factor for factor, power in powers if power % 2 == 0 or not switching_factors(factor)[1]}, key=str)


def monic(polynomial: Polynomial) -> Polynomial:
    """The multiple whose leading coefficient is one."""
    return polynomial * _leading(polynomial).inverse()


def _leading(polynomial: Polynomial) -> Number:
    return polynomial.terms[max(polynomial.terms)]


def _empty_patterns(cells: SignCells, radius: Number | None) -> Iterator[tuple[str, Record]]:
    """Patterns, walked as the checker walks them: of those that have no cell the shortest beginnings, and why."""
    occurring = {cell.signs[:size] for cell in cells.cells for size in range(len(cells.surfaces) + 1)}
    contradictions: list[dict[int, int]] = []
    for beginning in sorted(occurring, key=len):
        for sign in (-1, 1):
            longer = (*beginning, sign)
            if len(longer) <= len(cells.surfaces) and longer not in occurring and not _is_known(longer, contradictions):
                weights = _contradiction(cells, longer, radius)
                contradictions.append({j: longer[j] for j in weights})
                last = max(weights)
                mixture = {
                    f"s{j}": written_number(weight / weights[last]) for j, weight in weights.items() if j != last
                }
                yield pattern(contradictions[-1].get(j) for j in range(len(cells.surfaces))), {"mixture": [mixture]}


def _is_known(signs: Pattern, contradictions: Sequence[dict[int, int]]) -> bool:
    """Whether signs that were found to contradict each other occur in the pattern."""
    return any(
        all(j < len(signs) and signs[j] == s for j, s in contradiction.items()) for contradiction in contradictions
    )


def _contradiction(cells: SignCells, signs: Pattern, radius: Number | None) -> dict[int, Number]:
    """Weights with which some affine surfaces with their signs have no positive value in the cube, or the space."""
    affine = [j for j in range(len(signs)) if cells.surfaces[j].degree == 1]
    forms = [cells.surfaces[j] * signs[j] for j in affine]
    mixture = least_mixture(forms, radius)
    weights = {} if mixture is None else mixture.weights
    return {j: weights[i] for i, j in enumerate(affine) if weights.get(i)}


LARGEST = 3  # signs that contradict each other
TRIALS = 6  # contradictions that are tried, for one pattern


def started(system: SwitchedSystem, search: Search | None = None, *, irrational: bool = False) -> tuple[System, Search]:
    """The subject of a certificate, and a search.

    Args:
        system: to be judged.
        search: with what was shown before.
        irrational: whether it may have irrational numbers.

    Raises:
        NotShownError: for a system that no certificate can name.
        BeyondReachError: for irrational numbers, where these are not asked for.
    """
    try:
        subject = read_subject(about(system))
    except (NoCertificateError, RejectedError) as error:
        raise NotShownError(str(error)) from None
    if subject.numbers and not irrational:
        raise BeyondReachError("numbers with roots")
    return subject, search or Search()


def build_inclusion(stated: StatedCells, subject: System, search: Search) -> Inclusion:
    """The cells with their fields as the checker builds them.

    Raises:
        NotShownError: where it refuses to.
    """
    try:
        return Inclusion(subject, stated.record, (), search)
    except RejectedError as error:
        raise NotShownError(f"required {error}") from None


def sharpened(stated: StatedCells, subject: System, search: Search) -> StatedCells:
    """The same cells with further patterns that are shown to be empty.

    Args:
        stated: of a cube.
        subject: the system.
        search: keeps the proofs.
    """
    if all(surface.degree == 1 for surface in stated.surfaces):
        return stated
    cells = stated
    inclusion = build_inclusion(stated, subject, search)
    signs = _sampled_signs(inclusion.surfaces)
    occurring = set(map(tuple, signs.tolist()))
    for cell in inclusion.cells:
        is_known = any(_holds(cell.signs, mark) for mark in cells.empty)
        if cell.signs in occurring or is_known:
            continue
        for mark in _contradictions(cell.signs, signs, inclusion.surfaces):
            if _is_shown(stated, mark, subject, search):
                cells = replace(cells, empty={**cells.empty, mark: search.found[f"empty {mark}"][1]})
                break
    return cells


def fields_seen(stated: StatedCells, subject: System) -> set[Field]:
    """The fields about the point of the cells in which samples lie: on no larger cube are there fewer."""
    inclusion = build_inclusion(stated, subject, Search())
    occurring = set(map(tuple, _sampled_signs(inclusion.surfaces).tolist()))
    return {field for cell in inclusion.around() if cell.signs in occurring for _, field in cell.fields}


def _sampled_signs(surfaces: Surfaces) -> Floats:
    """The signs of all surfaces at random points, one row for each point."""
    points = np.concatenate([sample_points(surfaces.domain.system.count, bounded=True, seed=k) for k in range(20)])
    signs = [np.sign(float_values(surface.terms, points)) for surface in surfaces.listed]
    return np.array(signs).reshape(len(signs), len(points)).T


def _holds(signs: Pattern, mark: str) -> bool:
    """Whether a pattern has the signs of a text."""
    return all(m in (".", "-+"[s > 0]) for m, s in zip(mark, signs, strict=True))


def _contradictions(signs: Pattern, sampled: Floats, surfaces: Surfaces) -> Iterator[str]:
    """A few of its signs, one of a curved surface among them, that no sample has together; the smallest first."""
    curved = {j for j, surface in enumerate(surfaces.listed) if surface.degree > 1}
    trials = TRIALS
    for size in range(1, LARGEST + 1):
        for chosen in combinations(range(len(signs)), size):
            wanted = [signs[j] for j in chosen]
            if trials and curved.intersection(chosen) and not (sampled[:, chosen] == wanted).all(axis=1).any():
                trials -= 1
                yield pattern(s if j in chosen else None for j, s in enumerate(signs))


def _is_shown(stated: StatedCells, mark: str, subject: System, search: Search) -> bool:
    try:
        Surfaces(Domain(subject, stated.within), stated.record["surfaces"], [mark], search)
    except (NotShownError, RejectedError):
        return False
    return True


# ---- denominators: proved positive on the checked cube before anything is decided there ----------
#
# The field times them has the same paths there, at other speeds.  For what is said of the whole space they must be
# positive there.
#
# One may be zero at the point alone.  Then ``|f_k| < C d`` is proved too for every right-hand side ``f_k/d``: where it
# is not bounded beside the point, nothing says how solutions go on from there.


def require_denominators(system: SwitchedSystem) -> None:
    """Refuse denominators that are not proved positive on the checked cube, in two states a square.

    Raises:
        SceneError: for such a denominator, and for right-hand sides that are not proved to be bounded beside the point.
    """
    where = "square" if system.is_planar else "cube"
    for formula in system.rewriting.denominators:
        if not _is_positive(system, formula, system.check.radius):
            expected = f"a denominator that is proved not to vanish on the checked {where} (a smaller check.radius?)"
            raise SceneError(system.origin, "system.rhs", expected, system.rewriting.stated_text(formula))
    stated = system if system.by_roots is None else system.by_roots.unscaled
    if system.vanishing and not all(_is_bounded(stated, side) for member in stated.members for side in member.rhs):
        expected = "right-hand sides that are proved bounded beside the point"
        denominator = system.rewriting.stated_text(system.vanishing[0])
        received = StatedFact(f"{denominator} in a denominator, which is zero there")
        raise SceneError(system.origin, "system.rhs", expected, received)


def _is_bounded(system: SwitchedSystem, side: PiecewiseExpression) -> bool:
    """Whether a right-hand side over the common denominator is bounded on the checked cube; floats propose by what."""
    for scale in () if system.rewriting.scale is None else system.between_norms(system.rewriting.scale):
        largest = _largest_ratio(system, side, scale)
        if not np.isfinite(largest):
            return False
        above = multiplied(number(2 * (1 + int(largest))), scale.tree)
        bounds = (parse_piecewise(written(plus(above, tree)), system.states) for tree in (side.tree, minus(side.tree)))
        if not all(_is_positive(system, bound, system.check.radius) for bound in bounds):
            return False
    return True


def _largest_ratio(system: SwitchedSystem, top: PiecewiseExpression, bottom: PiecewiseExpression) -> float:
    """The largest size of a quotient at samples of the checked cube; not a number where none has a value."""
    points = np.array(system.check.place) + system.check.half_width * sample_points(len(system.states), bounded=True)
    ratios = []
    for point in points.tolist():
        named = dict(zip(system.states, point, strict=True))
        below = float_value(bottom.tree, named, bottom.text)
        if below > 0:
            ratios.append(abs(float_value(top.tree, named, top.text)) / below)
    return max(ratios, default=float("nan"))


def are_positive_everywhere(system: SwitchedSystem) -> bool:
    """Whether the denominators are proved positive in the whole space."""
    return all(_is_positive(system, formula, None) for formula in system.rewriting.denominators)


def _is_positive_on_square(system: SwitchedSystem, formula: PiecewiseExpression, *, except_origin: bool) -> bool:
    values = system.named(system.displaced(PLANE))

    def evaluate(sign_of: SignOf) -> Polynomial:
        return formula.polynomial(values, sign_of)

    try:
        pieces = list(smooth_pieces(square_regions(system.check.radius), evaluate))
    except (TooManyCells, ExpressionError):
        return False
    proved = (prove(Sense.POSITIVE, piece, region, except_origin=except_origin) for region, piece in pieces)
    return all(isinstance(outcome, Proof) for outcome in proved)


def _is_positive(system: SwitchedSystem, formula: PiecewiseExpression, radius: Number | None) -> bool:
    """On the cube of a half-width, or in the whole space; but at the checked point where it is zero there."""
    vanishes = system.is_zero_at_point(formula)
    ends = system.between_norms(formula)
    return all(_is_positive_formula(system, end, radius, vanishes=vanishes) for end in ends)


def _is_positive_formula(
    system: SwitchedSystem, formula: PiecewiseExpression, radius: Number | None, *, vanishes: bool
) -> bool:
    states, count = system.displaced(system.states), len(system.states)
    if system.is_planar and radius is not None:
        return _is_positive_on_square(system, formula, except_origin=vanishes)
    as_system = SwitchedSystem(system.name, system.field, system.states, (formula,), system.check, system.source)
    surfaces = tuple(s for s in as_system.surfaces(states) if s.degree)
    bounds = () if radius is None else tuple({unit(count, k): fmpq(1)} for k in range(count))
    try:
        rho = fmpq(1) if radius is None else rational(radius)
        for signs in patterns(surfaces, radius):
            (piece,) = as_system.velocity(signs_by_factors(dict(zip(surfaces, signs, strict=True))), states)
            start = piece.at_origin
            if start.as_rational() is None and start.sign() > 0:  # as a norm is that is irrational at the point
                piece *= 1 / start
            guards = tuple(scaled(rational_terms(s * e), rho) for s, e in zip(surfaces, signs, strict=True))
            condition = Condition(scaled(rational_terms(piece), rho), {}, guards, bounds, count, at_origin=not vanishes)
            if prove_positive(condition) is None:
                return False
    except BeyondReachError:
        return False
    return True
