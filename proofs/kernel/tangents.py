"""Tangents of curves at the origin of the plane: the real lines on which their forms of lowest degree vanish."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from nonsmooth.proofs.inequalities.real_roots import Sturm, trimmed
from nonsmooth.symbolic.formulas.surfaces import factorize, switching_factors
from nonsmooth.symbolic.numbers.polynomial import Polynomial


def lowest_form(polynomial: Polynomial) -> Polynomial:
    """The terms of lowest degree."""
    lowest = min((sum(e) for e in polynomial.terms), default=0)
    return replace(polynomial, terms={e: c for e, c in polynomial.terms.items() if sum(e) == lowest})


def form_lines(form: Polynomial) -> list[Polynomial] | None:
    """The real lines on which a form in (x, y) vanishes; None where one has no name in the field."""
    factored = factorize(form)
    factors = [form] if factored is None else [factor for factor, _ in factored[1]]
    lines: list[Polynomial] = []
    for factor in factors:
        for line in switching_factors(factor)[1]:
            if line.degree == 1:
                lines.append(line)
            elif not _is_definite(line):
                return None
    if factored is None and form.degree > 1 and len(lines) < form.degree:
        return None  # factors of even multiplicity are not seen
    return lines


def _is_definite(form: Polynomial) -> bool:
    """Whether a form without the factors x and y has no real line."""
    zero, top = form.field.zero, form.degree
    along = trimmed([form.terms.get((k, top - k), zero) for k in range(top + 1)])
    if len(along) <= top or not along[0]:
        return False
    chain = Sturm(along)
    backwards = Sturm([c * (-1) ** k for k, c in enumerate(along)])
    return not any(c.count(Fraction(0), None) for c in (chain, backwards))
