"""The cells of a system in many states: the patterns of signs of its switching surfaces that the checked cube has.

A pattern of affine surfaces is left out only where its open cell is proved to be empty in the cube (an exact linear
program).  Curved surfaces are taken with both signs: a pattern too many adds an inequality, and never a wrong verdict,
because F is then the hull of more velocities.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from nonsmooth.proofs.inequalities.linear_program import Mixture, best_mixture
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Exponents, Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.switched_system import MAX_PATTERNS, SwitchedSystem, UnknownSign, signs_by_factors

MAX_SURFACES = 24
MAX_CELLS = 160
SAMPLES = 3_000
MAX_MAGNITUDE = 40  # bits before or after the point: sixteenth powers of such numbers are floats

Pattern: TypeAlias = tuple[int, ...]
RationalTerms: TypeAlias = dict[Exponents, fmpq]


class BeyondReachError(ValueError):
    """A system or a V that is not decided here, with the reason for people."""


class IrrationalError(BeyondReachError):
    """The same for numbers with roots."""


@dataclass(frozen=True)
class SignCell:
    """An open cell of the cube.

    Attributes:
        signs: of every surface.
        velocities: one for each right-hand side, in the displacement.
    """

    signs: Pattern
    velocities: tuple[tuple[RationalTerms, ...], ...]


@dataclass(frozen=True)
class SignCells:
    """The cells of a cube about the checked point.

    Attributes:
        states: names of the states; every polynomial is in the displacement.
        surfaces: the switching surfaces of the system, and of a V.
        cells: the patterns of signs that the cube has, with the fields.
        radius: half the side of the cube.
        beyond: whether the fields are those of the system outside the cube too; denominators are positive inside only.
    """

    states: tuple[str, ...]
    surfaces: tuple[Polynomial, ...]
    cells: tuple[SignCell, ...]
    radius: fmpq
    beyond: bool

    @property
    def are_cones(self) -> bool:
        """Whether every surface is a hyperplane through the point."""
        return all(s.degree == 1 and s.is_homogeneous for s in self.surfaces)


def build_cells(system: SwitchedSystem, radius: Number, more: Iterable[Polynomial] = ()) -> SignCells:
    """The cells of a cube.

    Args:
        system: in any number of states.
        radius: half the side of the cube.
        more: further surfaces, of a V.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
        SceneError: for formulas that cannot be used.
    """
    states = system.displaced(system.states)
    surfaces = tuple(dict.fromkeys(s for s in (*system.surfaces(states), *more) if s.degree))
    if len(surfaces) > MAX_SURFACES:
        raise BeyondReachError(f"over {MAX_SURFACES} switching surfaces")
    found: list[SignCell] = []
    for signs in patterns(surfaces, radius):
        if len(found) == MAX_CELLS:
            raise BeyondReachError(f"over {MAX_CELLS} cells")
        sign_of = signs_by_factors(dict(zip(surfaces, signs, strict=True)))
        fields = (member.velocity(sign_of, states) for member in system.members)
        velocities = tuple(tuple(rational_terms(part) for part in field) for field in fields)
        found.append(SignCell(signs, velocities))
    return SignCells(system.states, surfaces, tuple(found), rational(radius), not system.denominators)


def adjoining(cells: SignCells) -> list[SignCell]:
    """The cells whose closures may hold the point."""
    zero = (0,) * len(cells.states)
    at_point = [surface.terms[zero].sign() if zero in surface.terms else 0 for surface in cells.surfaces]
    return [cell for cell in cells.cells if all(s * v >= 0 for s, v in zip(cell.signs, at_point, strict=True))]


def rational(number: Number) -> fmpq:
    """A number as a fraction.

    Raises:
        BeyondReachError: for an irrational one, and for one so large or small that its powers are no floats.
    """
    found = number.as_rational()
    if found is None:
        raise IrrationalError("numbers with roots in more than two states")
    if found and abs(int(found.p).bit_length() - int(found.q).bit_length()) > MAX_MAGNITUDE:
        raise BeyondReachError(f"numbers beyond 2**{MAX_MAGNITUDE} or below 2**-{MAX_MAGNITUDE}")
    return found


def rational_terms(polynomial: Polynomial) -> RationalTerms:
    """A polynomial with rational coefficients.

    Raises:
        BeyondReachError: for irrational ones.
    """
    return {exponents: rational(value) for exponents, value in polynomial.terms.items()}


def scaled(terms: Mapping[Exponents, fmpq], factor: fmpq) -> RationalTerms:
    """A polynomial in the variables divided by a factor."""
    return {e: c * factor ** sum(e) for e, c in terms.items()}


def surfaces_of(system: SwitchedSystem, formula: PiecewiseExpression) -> tuple[Polynomial, ...]:
    """The surfaces on which a formula of the displacement switches.

    Raises:
        ExpressionError: for a formula that is no polynomial on some piece.
        BeyondReachError: for too many surfaces.
    """
    values = dict(zip(system.states, system.coordinates(), strict=True))
    found: dict[Polynomial, None] = {}
    waiting: list[dict[Polynomial, int]] = [{}]
    while waiting:
        signs = waiting.pop()
        try:
            formula.polynomial(values, signs_by_factors(signs))
        except UnknownSign as unknown:
            found[unknown.surface] = None
            waiting += [{**signs, unknown.surface: sign} for sign in (-1, 1)]
        if len(found) > MAX_SURFACES or len(waiting) > MAX_PATTERNS:
            raise BeyondReachError(f"over {MAX_SURFACES} surfaces on which V switches")
    return tuple(surface for surface in found if surface.degree)


def patterns(surfaces: Sequence[Polynomial], radius: Number) -> Iterator[Pattern]:
    """All patterns of signs whose cells are not proved to be empty in the open cube."""
    affine = [surface.degree == 1 for surface in surfaces]
    sides = _sampled_signs(surfaces, radius)
    waiting: list[Pattern] = [()]
    while waiting:
        signs = waiting.pop()
        if len(signs) == len(surfaces):
            yield signs
            continue
        for sign in (-1, 1):
            longer = (*signs, sign)
            known = [k for k in range(len(longer)) if affine[k]]
            seen = bool(np.all(sides[:, known] == [longer[k] for k in known], axis=1).any())
            if seen or not affine[len(signs)] or not is_empty([surfaces[k] * longer[k] for k in known], radius):
                waiting.append(longer)


def _sampled_signs(surfaces: Sequence[Polynomial], radius: Number) -> NDArray[np.float64]:
    """Pattern at points of the cube, in floats: where a pattern is seen, no proof of its emptiness is looked for."""
    if not surfaces:
        return np.zeros((1, 0))
    count = len(surfaces[0].variables)
    cloud = np.random.default_rng(0).uniform(-1, 1, (SAMPLES, count)) * float(radius)
    columns = []
    for surface in surfaces:
        value = np.zeros(SAMPLES)
        for exponents, coefficient in surface.terms.items():
            value += float(coefficient) * np.prod(cloud**exponents, axis=1)
        columns.append(np.sign(value))
    return np.column_stack(columns)


def is_empty(forms: Sequence[Polynomial], radius: Number) -> bool:
    """Whether affine forms are positive together nowhere in the open cube: a mixture is not positive (Gordan)."""
    found = least_mixture(forms, radius) if forms else None
    return found is not None and found.value.sign() >= 0


def least_mixture(forms: Sequence[Polynomial], radius: Number) -> Mixture | None:
    """The mixture of affine forms, and of those of the sides of the cube, that is constant and least.

    Its weights are of the forms first; its value is minus the constant.
    """
    field, count = forms[0].field, len(forms[0].variables)
    units = [tuple(int(i == k) for i in range(count)) for k in range(count)]
    zero = (0,) * count
    columns = [(*(form.terms.get(unit, field.zero) for unit in units), field.one) for form in forms]
    prices = [-form.terms.get(zero, field.zero) for form in forms]
    for k in range(count):
        for side in (1, -1):
            columns.append((*(field(side if i == k else 0) for i in range(count)), field.one))
            prices.append(-radius)
    return best_mixture(columns, (*(field.zero for _ in range(count)), field.one), prices)
