"""The search for centres in two states (:mod:`nonsmooth.proofs.checker.centres`).

*Inverse factors.*  ``M = 1/Q`` with a polynomial Q: ``f . grad Q = Q div f`` is linear in its coefficients.

*Invariant curves* (Darboux 1878): where ``f . grad q = K q`` with polynomials K, their powers and the exponential of a
polynomial g make M, if ``div f + f . grad g + sum_i c_i K_i = 0``, which is linear too.  Every invariant line divides
``f_1 F(f_2) - f_2 F(f_1)``, with ``F = f . grad`` (Christopher, Llibre, Pereira 2007: on the line f and its derivative
along it are both tangent); so the irreducible factors of this are tried.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from math import gcd
from typing import TypeAlias

from nonsmooth.proofs.checker.cells import Inclusion, Matrix, System, pattern
from nonsmooth.proofs.checker.centres import require_reversed, show_turns
from nonsmooth.proofs.checker.polynomials import Polynomial, constant, lie_derivative
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.bounds import factorized
from nonsmooth.proofs.kernel.cells import StatedCells, build_inclusion, started, stated_cells
from nonsmooth.proofs.kernel.search import Entry, NotShownError, SampledProofs, Search
from nonsmooth.proofs.kernel.written import combined, formula_in_states, powers_between, vanishing_combinations
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

MIRRORS = ((1, 0, 0, -1), (-1, 0, 0, 1), (0, 1, 1, 0), (0, -1, -1, 0))
MOST_DEGREE = 4  # of Q and of g
WORK = 4_000  # coefficients looked at for one claim

Field: TypeAlias = Sequence[Polynomial]
Factors: TypeAlias = list[tuple[Polynomial, Fraction]]  # polynomials with their powers


def show_reversible_of(system: SwitchedSystem) -> Entry:
    """Evidence that the checked point is stable because a reflection reverses time.

    Args:
        system: in two states, with one right-hand side.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers that no certificate names, and for too many surfaces or cells.
    """
    subject, cells, inclusion = _at_point(system)
    mirrors = [mirror for mirror in map(_rows, MIRRORS) if _is_reversed(subject, inclusion, mirror)]
    if not mirrors:
        raise NotShownError("no reflection was found that reverses time")
    mirror = [[str(value) for value in row] for row in mirrors[0]]
    hypotheses = {"cells": cells.record, "mirror": mirror, **_turning(inclusion)}
    return Search(WORK).entry(subject, "reversible", hypotheses)


def show_integral_of(system: SwitchedSystem) -> Entry:
    """Evidence that the checked point is stable because an integral of motion is kept.

    Args:
        system: in two states, with one right-hand side without sines and cosines of states.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers that no certificate names, and for too many surfaces or cells.
    """
    subject, cells, inclusion = _at_point(system)
    if any(subject.waves[0]):
        raise NotShownError("an integrating factor is looked for without sines and cosines")
    turning = _turning(inclusion)
    exponent, factors = _integrating_factor(inclusion)
    radius = inclusion.domain.radius
    written = [[formula_in_states(factor, radius, subject.states), str(power)] for factor, power in factors]
    stated = {"exponent": formula_in_states(exponent, radius, subject.states), "factors": written}
    return Search(WORK).entry(subject, "integral", {"cells": cells.record, **stated, **turning})


def reflection_text(mirror: Sequence[Sequence[str]], states: Sequence[str]) -> str:
    """The image of a place, as in ``(x, -y)``."""
    images = []
    for row in mirror:
        (k,) = (k for k, value in enumerate(row) if value != "0")
        images.append(states[k] if row[k] == "1" else f"-{states[k]}")
    return f"({', '.join(images)})"


def factor_text(hypotheses: Record) -> str:
    """An integrating factor, as in ``(x + 1)**-1 * exp(6*x)``."""
    parts = [
        f"({factor})**({power})" if "/" in power else f"({factor})**{power}" for factor, power in hypotheses["factors"]
    ]
    exponent = hypotheses["exponent"]
    parts += [f"exp({exponent})"] if exponent != "0" else []
    return " * ".join(parts) or "1"


def _at_point(system: SwitchedSystem) -> tuple[System, StatedCells, Inclusion]:
    """The subject of a certificate, and its cells on the checked square."""
    subject, search = started(system, irrational=True)
    if not system.is_planar or len(subject.rhs) > 1 or system.by_roots is not None:
        raise NotShownError("centres are looked for where one field acts on a plane")
    cells = stated_cells(system, system.check.radius, irrational=True)
    return subject, cells, build_inclusion(cells, subject, search)


def _turning(inclusion: Inclusion) -> Record:
    """Weights for each cell, and the sense, with which all fields seem to turn.

    Raises:
        NotShownError: where there are none.
    """
    axes = all(len(surface.terms) == 1 for surface in inclusion.surfaces.listed if not surface.at_origin)
    fields = {pattern(cell.signs): cell.fields[0][1] for cell in inclusion.cells}
    pairs = {name: _weights(field) if axes else (1, 1) for name, field in fields.items()}
    weights = {name: list(map(str, pair)) for name, pair in pairs.items()}
    for sense in (1, -1):
        with suppress(NotShownError):
            show_turns(inclusion, weights, sense, SampledProofs())
            return {"weights": weights, "sense": sense}
    raise NotShownError("no sense in which all solutions turn was found")


def _weights(field: Field) -> tuple[int, int]:
    """The weights of x and y with which x times ``x^p`` in f_2 weighs as much as y times ``y^q`` in f_1.

    Raises:
        NotShownError: where f_1 is zero on one axis, or f_2 on the other: solutions do not turn.
    """
    across = [j + 1 for i, j in field[0].terms if not i]
    along = [i + 1 for i, j in field[1].terms if not j]
    if not across or not along:
        raise NotShownError("solutions do not cross the axes")
    least = min(across), min(along)
    shared = gcd(*least)
    return least[0] // shared, least[1] // shared


def _rows(values: Sequence[int]) -> Matrix:
    a, b, c, d = map(Fraction, values)
    return [[a, b], [c, d]]


def _is_reversed(subject: System, inclusion: Inclusion, mirror: Matrix) -> bool:
    try:
        require_reversed(subject, inclusion, mirror)
    except RejectedError:
        return False
    return True


def _integrating_factor(inclusion: Inclusion) -> tuple[Polynomial, Factors]:
    """The exponent g, and the polynomials q with their powers.

    Raises:
        NotShownError: where none is found.
    """
    fields = [cell.fields[0][1] for cell in inclusion.cells]
    divergences = [field[0].derivative(0) + field[1].derivative(1) for field in fields]
    if not any(divergences):
        return constant(2, 0), []
    if any(type(c) is not Fraction for field in fields for part in field for c in part.terms.values()):
        raise NotShownError("irrational numbers in a field that is not divergence-free")
    inverse = _inverse_factor(fields, divergences)
    if inverse is not None:
        return constant(2, 0), inverse
    curves = list(_invariant_curves(fields[0])) if len(fields) == 1 else []
    monomials = powers_between(2, 1, MOST_DEGREE)
    columns = [[cofactor] for _, cofactor in curves]
    columns += [[lie_derivative(monomial, field) for field in fields] for monomial in monomials]
    for combination in vanishing_combinations([*columns, divergences]):
        if scale := combination[-1]:
            powers = [value / scale for value in combination[: len(curves)]]
            exponent = combined(monomials, [value / scale for value in combination[len(curves) : -1]])
            return exponent, [(curve, power) for (curve, _), power in zip(curves, powers, strict=True) if power]
    raise NotShownError("no integrating factor was found")


def _inverse_factor(fields: Sequence[Field], divergences: Sequence[Polynomial]) -> Factors | None:
    """The irreducible factors of a polynomial Q, not zero at the point, for which ``M = 1/Q``; of least degree."""
    for degree in range(1, MOST_DEGREE + 1):
        monomials = powers_between(2, 0, degree)
        pairs = list(zip(fields, divergences, strict=True))
        columns = [
            [lie_derivative(monomial, field) - monomial * rate for field, rate in pairs] for monomial in monomials
        ]
        for combination in vanishing_combinations(columns):
            if combination[0]:
                factors = factorized(combined(monomials, combination))[1]
                return [(factor.times(1 / factor.at_origin), Fraction(-power)) for factor, power in factors]
    return None


def _invariant_curves(field: Field) -> Iterator[tuple[Polynomial, Polynomial]]:
    """Curves ``q = 0`` that solutions do not cross, not through the point, each with K."""
    bent = field[0] * lie_derivative(field[1], field) - field[1] * lie_derivative(field[0], field)
    for factor, _ in factorized(bent)[1] if bent else []:
        cofactor = lie_derivative(factor, field).divided(factor) if factor.at_origin else None
        if cofactor is not None:
            yield factor.times(1 / factor.at_origin), cofactor
