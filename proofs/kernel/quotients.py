"""A V that is a quotient ``P/Q`` of forms, for fields that no polynomial V serves.

With ``Q = |x|^2`` and forms P of degree 4, or ``|x|^4`` and degree 6, the claims of the checker about P are affine in
its coefficients.  Where the lowest terms of the field turn about the point without coming nearer, they must leave V as
it is: ``Q P' - P Q' = 0`` along them is a linear system, which is solved exactly.  In its solutions, or in all forms, a
linear program proposes P by samples.  (Ahmadi and El Khadir 2018: ``V = (x^4 + y^4)/(x^2 + y^2)``.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from flint import fmpq_mat

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.polynomials import Polynomial, constant, variable
from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import with_margin
from nonsmooth.proofs.kernel.cells import BeyondReachError, started, stated_cells
from nonsmooth.proofs.kernel.search import (
    Entry,
    Functions,
    NotShownError,
    SampledProofs,
    Search,
    sample_points,
    stability_hypotheses,
)
from nonsmooth.proofs.kernel.written import formula_text, part_of, roundings, vanishing_columns
from nonsmooth.proofs.sums_of_squares.ansatz import monomials_of
from nonsmooth.symbolic.formulas.signed_roots import SignedRoots
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import float_values
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

DEGREES = (4, 6)  # of P
MOST_FORMS = 60  # monomials of P
DENOMINATORS = (1, 4, 16, 64)  # of the coefficients over the largest, tried in turn
WORK = 4_000  # coefficients looked at for one claim
MOST_TRIED = 6  # quotients that no sample refutes: what is shown is shown of the first ones
FACTORS = ("1/4", "1/64")  # of |x|^2 below V + 1


def find_quotient(system: SwitchedSystem, *, everywhere: bool = False, stated: bool = False) -> Entry | None:
    """The entry of a certificate that shows attraction by a quotient; None where none is found.

    Args:
        system: in two states or more, with rational numbers.
        everywhere: whether it must show that all solutions come to the point.
        stated: whether the quotient of the scene is asked, in place of those that are searched.
    """
    if stated and system.check.quotient is None:
        return None
    try:
        subject, _ = started(system)
        whole, cube = (stated_cells(system, radius).record for radius in (None, system.check.radius))
    except (BeyondReachError, NotShownError, SceneError):
        return None
    beyond = not system.rewriting.denominators and system.by_roots is None and not system.rewriting.waves
    quotients = [[part.text for part in system.check.quotient or ()]]
    tried = 0
    for top, bottom in quotients if stated else _quotients(subject, cube):
        common = stability_hypotheses(whole, top, ASYMPTOTICALLY_STABLE) | {"denominator": bottom, "everywhere": True}
        ways = [common, *(common | {"proper": factor} for factor in FACTORS)] if beyond else []
        for hypotheses in ways if everywhere else (*ways, common | {"cells": cube, "everywhere": False}):
            try:
                SampledProofs().entry(subject, "lyapunov", hypotheses)
                tried += 1
                return Search(WORK).entry(subject, "lyapunov", hypotheses)
            except NotShownError:
                if tried == MOST_TRIED:
                    return None
    return None


def quotient_text(hypotheses: Record) -> str:
    """V of a theorem as a formula."""
    top, bottom = one_line(str(hypotheses["function"])), hypotheses.get("denominator")
    logarithm = hypotheses.get("logarithm")
    if logarithm is not None:
        return f"{top} + ln(1 + {one_line(logarithm)})"
    return top if bottom is None else f"({top})/({one_line(bottom)})"


def signed_roots_of(hypotheses: Record, states: Sequence[str]) -> SignedRoots | None:
    """The roots of states that V of a theorem is about; None where it is about the coordinates of the system."""
    listed: dict[str, int] = hypotheses.get("roots") or {}
    return SignedRoots(tuple(states), tuple(listed), tuple(listed.values())) if listed else None


def _quotients(subject: System, cube: Record) -> Iterator[tuple[str, str]]:
    """Numerators and denominators."""
    states = subject.coordinates
    for degree in DEGREES:
        forms = list(monomials_of(len(states), degree))
        if len(forms) > MOST_FORMS:
            return
        bottom = f"({' + '.join(f'{x}**2' for x in states)})"
        power = degree // 2 - 1
        try:
            one = [formula_text(Polynomial(len(states), {exponents: Fraction(1)}), states) for exponents in forms]
            claims = _claims(subject, cube, one, power)
        except RejectedError:
            return
        rows = _rows(claims)
        for basis in (fmpq_mat(np.eye(len(forms), dtype=int).tolist()), kept_forms(claims)):
            for chosen in proposed(rows @ np.array(basis.tolist(), dtype=float)) if basis.ncols() else ():
                top = dict(zip(forms, coefficients_of(basis, chosen), strict=True))
                yield formula_text(Polynomial(len(states), top), states), bottom + (f"**{power}" if power > 1 else "")


def _claims(subject: System, cube: Record, forms: Sequence[str], power: int) -> list[list[Claim]]:
    """The claims about each form over the power of ``|x|^2``, in one order.

    Raises:
        RejectedError: for cells that are not those of the system.
    """
    functions = Functions(subject, {**cube, "empty": []}, forms)
    square = constant(functions.count, 0)
    for k in range(functions.count):
        square += variable(functions.count, k) * variable(functions.count, k)
    functions.bottom = square.power(power)
    return [functions.claims(k) for k in range(len(forms))]


def kept_forms(claims: Sequence[Sequence[Claim]]) -> fmpq_mat:
    """The sums of functions, in columns, that the lowest terms of all fields leave as they are."""
    falling = [[claim for claim in same if claim.name.startswith("cell")] for same in claims]
    falls = [[inequality.value for claim in same for inequality in claim.inequalities] for same in falling]
    lowest = min((sum(e) for values in falls for value in values for e in value.terms), default=0)
    return vanishing_columns([[part_of(value, lowest) for value in values] for values in falls])


def coefficients_of(basis: fmpq_mat, chosen: Sequence[Fraction]) -> list[Fraction]:
    """Those of a sum of the columns of a basis."""
    combination = basis * fmpq_mat([[as_fmpq(c)] for c in chosen])
    return list(map(as_fraction, combination.entries()))


def _rows(claims: Sequence[Sequence[Claim]]) -> Floats:
    """The values of all inequalities at samples, a column for each form; each must be positive."""
    blocks = []
    for same in zip(*claims, strict=True):
        points = sample_points(same[0].count, bounded=True)
        for number in range(len(same[0].inequalities)):
            blocks.append(values_inside(same, number, points))
    return np.vstack(blocks)


def values_inside(
    same: Sequence[Claim], number: int, points: Floats, select: Callable[[Any], Any] = lambda terms: terms
) -> Floats:
    """One inequality of claims that differ in the function alone, where its guards hold, a column for each claim.

    Args:
        same: the claims.
        number: of the inequality in each.
        points: shape (points, states).
        select: which terms of the polynomials are looked at; all unless given.
    """
    inside = np.ones(len(points), dtype=bool)
    for guard in same[0].inequalities[number].guards.values():
        inside &= float_values(guard.terms, points) >= 0
    values = [float_values(select(claim.inequalities[number].value.terms), points[inside]) for claim in same]
    return np.stack(values, axis=1)


def proposed(rows: Floats) -> Iterator[list[Fraction]]:
    """Coefficients for which all rows are positive, in rounded numbers."""
    sizes = np.abs(rows).max(axis=1, keepdims=True)
    rows = rows[sizes[:, 0] > 0] / sizes[sizes[:, 0] > 0]
    if not len(rows):  # nothing changes: none is better than another
        return
    chosen = with_margin(rows, np.ones(rows.shape[1]))
    if chosen is None:
        return
    yield from (
        coefficients
        for coefficients in roundings(chosen, DENOMINATORS)
        if (rows @ np.array(coefficients, dtype=float) > 0).all()
    )
