"""The search for mixtures: nonnegative multiples of guards that leave an affine polynomial without negative values."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim, Inequality
from nonsmooth.proofs.inequalities.linear_program import best_mixture
from nonsmooth.symbolic.numbers.number_field import NumberField


def search(claim: Claim) -> dict[str, Any] | None:
    """Multipliers for each inequality of a claim about affine polynomials; None where there are none.

    Args:
        claim: any one; where a guard or p is not affine, or functions mu are asked for, nothing is found.
    """
    found = [_multipliers(claim, inequality) for inequality in claim.inequalities]
    return None if None in found else {"mixture": found}


def _multipliers(claim: Claim, inequality: Inequality) -> dict[str, str] | None:
    """The least sum ``-p + sum lambda g`` over the domain as a linear program.

    In ``p = sum_g lambda_g g + sum_k a_k (1 - z_k) + b_k (1 + z_k) + rest`` the rest is made as large as it can be.
    """
    if inequality.pushes or inequality.value.degree > 1:
        return None
    named = {name: own for name, own in inequality.guards.items() if own.degree == 1 and name[0] == "s"}
    field, count = NumberField(), claim.count
    columns = [[field(value) for value in _slopes(own)] for own in named.values()]
    prices = [field(-own.at_origin) for own in named.values()]
    for k in range(count if claim.bounded else 0):
        for side in (1, -1):
            columns.append([field(side * int(i == k)) for i in range(count)])
            prices.append(field(-1))
    target = [field(value) for value in _slopes(inequality.value)]
    if not count or not columns:
        return {} if not any(_slopes(inequality.value)) and _is_enough(claim, inequality.value.at_origin) else None
    try:
        found = best_mixture(columns, target, prices)
    except ValueError:  # unbounded: no point has all these signs
        return None
    if found is None:
        return None
    rest = found.value.as_rational()
    if rest is None or not _is_enough(claim, inequality.value.at_origin + Fraction(int(rest.p), int(rest.q))):
        return None
    names = list(named)
    return {names[k]: str(weight) for k, weight in found.weights.items() if k < len(names)}


def _is_enough(claim: Claim, rest: Fraction) -> bool:
    return rest > 0 or (not claim.strict and not rest)


def _slopes(value: Polynomial) -> Sequence[Fraction]:
    return [value.slope(k) for k in range(value.count)]
