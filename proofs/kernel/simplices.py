"""The search for trees of simplices on whose leaves coefficients show a claim, in the form the checker follows.

Root simplices of the domain go through the cuts of :mod:`nonsmooth.proofs.inequalities.subdivision`.  They are cut
first where affine guards change their sign on an edge, so that no part lies on both sides, and in one variable at
rational zeros.  Affine functions mu on a part are proposed by linear programs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any, TypeAlias

from flint import fmpq, fmpq_poly

from nonsmooth.proofs.checker.polynomials import Polynomial, unit
from nonsmooth.proofs.checker.positivity import Claim, pairs, root_simplices
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.proofs.inequalities.prover import Counterexample
from nonsmooth.proofs.inequalities.subdivision import (
    ConeCut,
    FormsClaim,
    SubCone,
    Violation,
    degree_of,
    raised,
    root_part,
    shown_by,
    shows,
    subdivide,
    value_at,
)
from nonsmooth.proofs.kernel.written import exact, terms_of, written_number
from nonsmooth.symbolic.numbers.polynomial import add_terms, in_generators

Exponents: TypeAlias = tuple[int, ...]
Form: TypeAlias = dict[Exponents, fmpq]
Corner: TypeAlias = tuple[fmpq, ...]


LARGEST_MU = 1e6  # value of a function mu at a corner
MU_DENOMINATORS = (1 << 4, 1 << 12, 1 << 24)  # of these values, tried in turn
SLACK = 2.0**-23  # by which a coefficient that a linear program finds may be negative: exact arithmetic decides


@dataclass(frozen=True)
class Leaf:
    """What shows all inequalities of a claim on a part.

    Attributes:
        on: for each inequality, multiples of guards and zeros to take off; or a guard that is positive nowhere.
        mu: the values of the functions mu at the corners; none where all are zero.
    """

    on: list[str | Record]
    mu: list[list[fmpq]]


def search(claim: Claim, work: int) -> Record | Counterexample[Claim] | None:
    """A tree for every root simplex of a claim.

    Args:
        claim: of functions mu it has at most one where polynomials are zero.
        work: coefficients that may be looked at.

    Returns:
        The evidence, or a point at which the claim is false; None where neither was found with this work.
    """
    if len(claim.inequalities[0].pushes) == 1:
        outcomes = [search(pair, work) for pair in pairs(claim)]
        against = next((outcome for outcome in outcomes if isinstance(outcome, Counterexample)), None)
        return against or (None if None in outcomes else {"pairs": outcomes})
    if claim.inequalities[0].pushes and any(inequality.zeros for inequality in claim.inequalities):
        return None
    roots = [_root(claim, corners) for corners in root_simplices(claim.count, bounded=claim.bounded)]
    sought = FormsClaim(claim.strict, claim.at_origin, border=claim.border)
    result = subdivide(roots, sought, work, lambda part: _leaf(claim, sought, part), _place_to_cut)
    if isinstance(result, Violation):
        return counterexample(claim, [x / result.point[-1] for x in result.point[:-1]])
    return None if result is not None else {"simplices": list(map(_tree, roots))}


def counterexample(claim: Claim, point: Sequence[fmpq]) -> Counterexample[Claim] | None:
    """A rational point as what refutes a claim, if it does: surfaces are positive there, and other guards not negative.

    Inequalities with functions mu are not looked at.
    """
    if not (claim.at_origin or any(point)):
        return None
    for inequality in claim.inequalities:
        guards = {name: value_at(terms_of(guard), point) for name, guard in inequality.guards.items()}
        inside = all(value > 0 if name[0] == "s" else value >= 0 for name, value in guards.items())
        if (
            inequality.pushes
            or not inside
            or any(value_at(terms_of(zero), point) for zero in inequality.zeros.values())
        ):
            continue
        value = value_at(terms_of(inequality.value), point)
        if value < 0 or (claim.strict and not value):
            return Counterexample(claim, tuple(point), value)
    return None


def _root(claim: Claim, corners: Sequence[Sequence[Fraction]]) -> SubCone:
    exact_corners = tuple(tuple(map(exact, corner)) for corner in corners)

    def form(value: Polynomial) -> Form:
        return _form(value, exact_corners)

    values = [[form(polynomial) for polynomial in (i.value, *i.pushes)] for i in claim.inequalities]
    guards = [{name: form(guard) for name, guard in i.guards.items() if name[0] == "s"} for i in claim.inequalities]
    return root_part(exact_corners, values, guards, {n: form(zero) for n, zero in claim.inequalities[0].zeros.items()})


def _form(value: Polynomial, corners: Sequence[Corner]) -> Form:
    """A polynomial as a form of its own degree in barycentric coordinates."""
    degree = value.degree
    terms = {(*e, degree - sum(e)): c for e, c in terms_of(value).items()}
    return in_generators(terms, corners)


def _leaf(claim: Claim, sought: FormsClaim, part: SubCone) -> Leaf | None:
    """What shows all inequalities on a part: without functions mu, or with values that a linear program proposes."""
    outcomes = [shown_by(part, sought, k, inequality.open) for k, inequality in enumerate(claim.inequalities)]
    evidence = [outcome for outcome in outcomes if outcome is not None]
    if len(evidence) == len(outcomes):
        return Leaf(evidence, [])
    inside = [k for k, outcome in enumerate(outcomes) if not isinstance(outcome, str)]
    count = len(part.values[0]) - 1
    for mu in _proposed_mu([part.values[k] for k in inside], part.corners, count) if count else ():
        if all(shows(part, sought, k, _with_mu(part.values[k], mu, part.corners)) for k in inside):
            return Leaf([outcome if isinstance(outcome, str) else {} for outcome in outcomes], mu)
    return None


def _proposed_mu(inside: Sequence[Sequence[Form]], corners: Sequence[Corner], count: int) -> Iterator[list[list[fmpq]]]:
    """Values of mu that make the least coefficient as large as they can, rounded.

    Coefficients that no mu changes are left out; of the others, each is divided by its largest entry.
    """
    rows, least, size = [], [], len(corners)
    for value, *pushes in inside:
        slopes = [_times_coordinate(push, k) for push in pushes for k in range(size)]
        degree = max(degree_of(form) for form in (value, *slopes))
        constant, others = raised(value, degree, corners), [raised(slope, degree, corners) for slope in slopes]
        for e in {e for slope in others for e in slope}:
            here = float(constant.get(e, fmpq(0)))
            row = [float(slope.get(e, fmpq(0))) for slope in others]
            largest = max(abs(here), *map(abs, row))
            rows.append([*(-entry / largest for entry in row), 1.0])
            least.append(here / largest)
    bounds = [(-LARGEST_MU, LARGEST_MU)] * (size * count) + [(None, 1.0)]
    solution = solve_program([0.0] * (size * count) + [-1.0], A_ub=rows, b_ub=least, bounds=bounds) if rows else None
    if solution is None or solution.x is None or solution.x[-1] < -SLACK:
        return
    for denominator in MU_DENOMINATORS:
        values = [fmpq(round(float(x) * denominator), denominator) for x in solution.x[:-1]]
        yield [values[j * size : (j + 1) * size] for j in range(count)]


def _with_mu(forms: Sequence[Form], mu: Sequence[Sequence[fmpq]], corners: Sequence[Corner]) -> Form:
    """The form ``p + sum mu q``."""
    parts = [forms[0]]
    for push, values in zip(forms[1:], mu, strict=True):
        for k, value in enumerate(values):
            if value:
                parts.append({e: c * value for e, c in _times_coordinate(push, k).items()})
    degree = max(map(degree_of, parts))
    total: Form = {}
    for part in parts:
        total = add_terms(total, raised(part, degree, corners))
    return total


def _times_coordinate(form: Form, k: int) -> Form:
    return {(*e[:k], e[k] + 1, *e[k + 1 :]): value for e, value in form.items()}


def _place_to_cut(part: SubCone) -> tuple[int, int, fmpq] | None:
    """Where an affine guard changes its sign on an edge; in one variable, where a polynomial is zero."""
    size = len(part.corners)
    for guards in part.guards:
        for form in guards.values():
            if degree_of(form) != 1:
                continue
            at = [form.get(unit(size, k), fmpq(0)) for k in range(size)]
            for i, j in combinations(range(size), 2):
                if at[i] * at[j] < 0:
                    return i, j, at[i] / (at[i] - at[j])
    share = _rational_root(part) if size == 2 else None
    return None if share is None else (0, 1, share)


def _rational_root(part: SubCone) -> fmpq | None:
    """Where a polynomial vanishes inside an interval, as a share of it: halving alone would never meet that place."""
    forms = [form for values in part.values for form in values[:1]] + [
        form for guards in part.guards for form in guards.values()
    ]
    for form in forms:
        if not (any(value > 0 for value in form.values()) and any(value < 0 for value in form.values())):
            continue
        top = degree_of(form)
        ratio = [form.get((top - k, k), fmpq(0)) for k in range(top + 1)]  # in t_1 / t_0
        if not all(isinstance(coefficient, fmpq) for coefficient in ratio):
            continue
        for factor, _ in fmpq_poly(ratio).numer().factor()[1]:
            if factor.degree() == 1 and (root := fmpq(-int(factor[0]), int(factor[1]))) > 0:
                return root / (1 + root)
    return None


def _tree(part: SubCone) -> Any:
    """The tree below a part, as certificates write it."""
    if isinstance(part.node, ConeCut):
        cut = part.node
        return [cut.first, cut.second, written_number(cut.share), _tree(cut.near), _tree(cut.far)]
    leaf: Record = {}
    if part.node.mu:
        leaf["mu"] = [[str(value) for value in values] for values in part.node.mu]
    if any(part.node.on):
        leaf["on"] = [_written(evidence) for evidence in part.node.on]
    return leaf


def _written(evidence: str | Record) -> str | Record:
    """What shows an inequality on a part: the name of a guard, or multiples."""
    return evidence if isinstance(evidence, str) else {name: written_number(value) for name, value in evidence.items()}
