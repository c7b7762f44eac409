"""Polynomials as the checker has them: from those of the program, and as formulas of a certificate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flint import fmpq

from nonsmooth.proofs.checker.polynomials import Exponents, Polynomial
from nonsmooth.symbolic.numbers.coefficients import as_fraction


def as_checked(terms: Mapping[Exponents, fmpq], count: int) -> Polynomial:
    """A polynomial of the checker in a number of variables, by its rational coefficients."""
    return Polynomial(count, {e: as_fraction(c) for e, c in terms.items()})


def terms_of(value: Polynomial) -> dict[Exponents, fmpq]:
    """The terms of a polynomial of the checker with numbers of flint."""
    return {e: fmpq(c.numerator, c.denominator) for e, c in value.terms.items()}


def formula_text(value: Polynomial, names: Sequence[str]) -> str:
    """A polynomial as a formula, such as ``-3/4*x**2*y + 1``."""
    written = []
    for exponents, coefficient in sorted(value.terms.items(), reverse=True):
        powers = [name if k == 1 else f"{name}**{k}" for name, k in zip(names, exponents, strict=True) if k]
        factor = [] if coefficient == 1 and powers else [str(coefficient)]
        written.append("*".join([*factor, *powers]))
    return " + ".join(written) or "0"
