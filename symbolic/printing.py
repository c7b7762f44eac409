"""Numbers as text and as SymPy: sums of square roots and cosines, e.g. ``-1/2 + 3*sqrt(5)/4``.

A base element is rewritten from powers of ``c = 2 cos(2 pi/N)`` to cosines of multiple angles,
``c^k = sum_j binom(k, j) 2 cos(2 pi (k - 2j)/N) / ...``: that is the form a reader recognizes, and the
scene-file parser reads it back.
"""

from __future__ import annotations

from fractions import Fraction
from math import comb
from typing import TYPE_CHECKING

from flint import fmpq

if TYPE_CHECKING:
    import sympy

    from nonsmooth.symbolic.number_field import Coefficient, Number, NumberField

Cosines = dict[Fraction, Fraction]  # turn -> weight of cos(pi * turn); turn 0 is the constant


def cosine_form(field: NumberField, coefficient: Coefficient) -> Cosines:
    """A base element as a rational combination of ``cos(pi * turn)``, ``0 <= turn < 1/2``."""
    if isinstance(coefficient, fmpq):
        return {Fraction(0): _fraction(coefficient)}
    form: Cosines = {}
    for k, q in enumerate(coefficient.coeffs()):
        for j in range(k + 1):  # (2 cos t)^k = sum_j binom(k, j) cos((k - 2 j) t)
            turn, weight = Fraction(2 * abs(k - 2 * j), field.order) % 2, _fraction(q) * comb(k, j)
            turn = min(turn, 2 - turn)
            if turn > Fraction(1, 2):
                turn, weight = 1 - turn, -weight
            if turn == Fraction(1, 3):
                turn, weight = Fraction(0), weight / 2
            if turn != Fraction(1, 2):
                form[turn] = form.get(turn, Fraction(0)) + weight
    return {turn: weight for turn, weight in sorted(form.items()) if weight}


def number_text(number: Number) -> str:
    """Plain text that :mod:`nonsmooth.symbolic.expression` reads back to the same number."""
    text = ""
    for mask in sorted(number.terms):
        root = _radical_text(number, mask)
        for turn, weight in cosine_form(number.field, number.terms[mask]).items():
            factors = [f"cos({_multiple_of_pi(turn)})"] * bool(turn) + [root] * bool(root)
            text += _signed(weight, "*".join(factors), first=not text)
    return text or "0"


def _signed(weight: Fraction, factors: str, *, first: bool) -> str:
    magnitude = abs(weight)
    body = factors or str(magnitude)
    if factors:
        body = factors if magnitude.numerator == 1 else f"{magnitude.numerator}*{factors}"
        body += "" if magnitude.denominator == 1 else f"/{magnitude.denominator}"
    if first:
        return f"-{body}" if weight < 0 else body
    return f" - {body}" if weight < 0 else f" + {body}"


def _multiple_of_pi(turn: Fraction) -> str:
    numerator = "pi" if turn.numerator == 1 else f"{turn.numerator}*pi"
    return numerator if turn.denominator == 1 else f"{numerator}/{turn.denominator}"


def _radical_text(number: Number, mask: int) -> str:
    """``sqrt(6)`` for the product of sqrt(2) and sqrt(3); nested radicands stay factors."""
    if not mask:
        return ""
    rational, nested = 1, []
    for i in range(mask.bit_length()):
        if mask >> i & 1:
            radicand = number.field.radicands[i]
            value = radicand.as_rational()
            if value is None:
                nested.append(f"sqrt({radicand})")
            else:
                rational *= int(value.p)
    return "*".join([f"sqrt({rational})"] * (rational > 1) + nested)


def number_to_sympy(number: Number) -> sympy.Expr:
    """The number as a SymPy expression."""
    import sympy

    total = sympy.Integer(0)
    for mask in sorted(number.terms):
        root = sympy.Integer(1)
        for i in range(mask.bit_length()):
            if mask >> i & 1:
                root *= sympy.sqrt(number.field.radicands[i].to_sympy())
        for turn, weight in cosine_form(number.field, number.terms[mask]).items():
            cosine = sympy.cos(sympy.Rational(turn.numerator, turn.denominator) * sympy.pi)
            total += sympy.Rational(weight.numerator, weight.denominator) * cosine * root
    return total


def _fraction(value: fmpq) -> Fraction:
    return Fraction(int(value.p), int(value.q))
