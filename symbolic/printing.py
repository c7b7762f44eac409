"""Numbers as text and as SymPy: sums of square roots and cosines, e.g. ``-1/2 + 3*sqrt(5)/4``.

A base element is rewritten from powers of ``c = 2 cos(2 pi/N)`` to cosines of multiple angles,
``c^k = sum_j binom(k, j) 2 cos(2 pi (k - 2j)/N) / ...``: that is the form a reader recognizes, and the
scene-file parser reads it back.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

from flint import fmpq

from nonsmooth.symbolic.numbers.number import bits

if TYPE_CHECKING:
    import sympy

    from nonsmooth.symbolic.numbers.number import Coefficient, Number
    from nonsmooth.symbolic.numbers.number_field import NumberField

Cosines = dict[Fraction, Fraction]  # turn -> weight of cos(pi * turn); turn 0 is the constant


def cosine_form(field: NumberField, coefficient: Coefficient) -> Cosines:
    """A base element as a rational combination of ``cos(pi * turn)``, ``0 <= turn < 1/2``."""
    if isinstance(coefficient, fmpq):
        return {Fraction(0): _fraction(coefficient)}
    form: Cosines = {}
    for multiple, angle_weight in enumerate(_multiple_angles(coefficient)):
        turn, weight = _folded(Fraction(2 * multiple, field.order) % 2, angle_weight)
        if turn != Fraction(1, 2):
            form[turn] = form.get(turn, Fraction(0)) + weight
    return {turn: weight for turn, weight in sorted(form.items()) if weight}


def _folded(turn: Fraction, weight: Fraction) -> tuple[Fraction, Fraction]:
    """The same ``weight * cos(pi * turn)`` with a turn between 0 and 1/2; ``cos(pi/3)`` becomes the constant 1/2."""
    turn = min(turn, 2 - turn)
    if turn > Fraction(1, 2):
        turn, weight = 1 - turn, -weight
    return (Fraction(0), weight / 2) if turn == Fraction(1, 3) else (turn, weight)


def _multiple_angles(coefficient: Coefficient) -> list[Fraction]:
    """Weights w with ``sum_k q_k (2 cos t)^k = sum_m w_m cos(m t)``.

    They follow from ``(2 cos t)^k = sum_j binom(k, j) cos((k - 2 j) t)``.
    """
    weights = [0] * len(coefficient)
    for k, top in enumerate(int(c) for c in coefficient.numer().coeffs()):
        for j in range(k + 1):
            weights[abs(k - 2 * j)] += top * math.comb(k, j)
    return [Fraction(weight, int(coefficient.denom())) for weight in weights]


def number_text(number: Number) -> str:
    """Plain text that :mod:`nonsmooth.symbolic.expression` reads back to the same number."""
    text = ""
    for mask in ordered_masks(number):
        root = _radical_text(number, mask)
        for turn, weight in cosine_form(number.field, number.terms[mask]).items():
            factors = [f"cos({_multiple_of_pi(turn)})"] * bool(turn) + [root] * bool(root)
            text += _signed(weight, "*".join(factors), first=not text)
    return text or "0"


def ordered_masks(number: Number) -> list[int]:
    """Terms by their radicals, smallest first: the text does not depend on the order in which roots were adjoined."""
    return sorted(number.terms, key=lambda mask: _radical_key(number, mask))


def _radical_key(number: Number, mask: int) -> tuple[list[str], int]:
    radicands = [number.field.radicands[i] for i in bits(mask)]
    values = [radicand.as_rational() for radicand in radicands]
    nested = sorted(str(radicand) for radicand, value in zip(radicands, values, strict=True) if value is None)
    return nested, math.prod(int(value.p) for value in values if value is not None)


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
