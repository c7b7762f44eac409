"""Polynomials that all solutions near a point keep, and of these one that is positive: the point is stable.

Where one polynomial field f acts near the point, ``grad I . f = 0`` is linear in the coefficients of I: the integrals
of some degree are a linear space, with the products of integrals of lower degree.  Those without linear terms are
sought whose quadratic form is positive definite, as energies with their Casimir functions are (Arnold 1966), or that
are sums of squares, as energies of springs without a linear part are: V is kept exactly, and positive near the point.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import comb

from nonsmooth.proofs.checker.polynomials import Polynomial, lie_derivative
from nonsmooth.proofs.kernel.cells import started, stated_cells
from nonsmooth.proofs.kernel.first_terms import fields_around
from nonsmooth.proofs.kernel.search import NotShownError
from nonsmooth.proofs.kernel.written import (
    combined,
    formula_in_states,
    powers_between,
    terms_of,
    vanishing_combinations,
)
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, examine
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, build_blocks
from nonsmooth.proofs.sums_of_squares.conic_program import round_parameters, solve_inside
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

MOST_DEGREE = 6
MOST_UNKNOWNS = 250  # coefficients of an integral
DENOMINATORS = (1, 8, 64)  # of the coefficients of integrals in V
SHARES = (Fraction(1), Fraction(1, 8), Fraction(1, 64))  # of the checked cube


def find_kept_function(system: SwitchedSystem) -> ExaminedLyapunov | None:
    """A positive V that solutions keep; None where none is found.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    try:
        subject, search = started(system, None)
        stated = stated_cells(system, system.check.radius)
        around = {tuple(own) for own in fields_around(stated, subject.stated, search)}
    except NotShownError:
        return None
    if len(around) != 1 or system.by_roots is not None:
        return None
    radius = as_fraction(stated.cells.radius)
    for proposal in _positive_integrals(around.pop()):
        text = formula_in_states(proposal, radius, system.states).replace("+ -", "- ")
        formula = parse_piecewise(text, system.states)
        for share in SHARES:
            examined = examine(system, formula, system.check.radius * share, effort=Effort.FULL)
            if examined.decrease is Decrease.WEAK:
                return examined
    return None


def _positive_integrals(field: Sequence[Polynomial]) -> list[Polynomial]:
    """Integrals of least degree with a positive definite quadratic form, or that are positive as they are."""
    count = len(field)
    for degree in range(2, MOST_DEGREE + 1):
        if comb(count + degree, degree) > MOST_UNKNOWNS:
            break
        monomials = powers_between(count, 2, degree)
        kept = list(vanishing_combinations([[lie_derivative(own, field)] for own in monomials]))
        integrals = [combined(monomials, own) for own in kept]
        forms = [Polynomial(count, {e: c for e, c in own.terms.items() if sum(e) == 2}) for own in integrals]
        for parts in (forms, integrals):
            found = _definite(integrals, parts, count)
            if found:
                return found
    return []


def _definite(integrals: Sequence[Polynomial], parts: Sequence[Polynomial], count: int) -> list[Polynomial]:
    """Sums of integrals in which the sum of these parts is positive, as a semidefinite program proposes them."""
    condition = Condition({}, dict(enumerate(map(terms_of, parts))), (), (), count)
    if not condition.support:
        return []
    solved = solve_inside([(condition, build_blocks(condition))], len(parts), bounded=True)
    if solved is None:
        return []
    found = []
    for denominator in DENOMINATORS:
        values = round_parameters(*solved, denominator)
        if values is not None and any(values):
            found.append(combined(integrals, list(map(as_fraction, values))))
    return found
