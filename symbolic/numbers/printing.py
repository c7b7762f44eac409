"""Numbers as plain text, LaTeX and SymPy: sums of square roots and cosines, e.g. ``-1/2 + 3*sqrt(5)/4``.

A base element is rewritten from powers of ``2 cos t``, ``t = 2 pi/N``, to cosines of multiple angles,
``(2 cos t)^k = sum_j binom(k, j) cos((k - 2 j) t)``, ``j = 0, ..., k``: that is the form a reader recognizes, and the
scene-file parser reads it back.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple, Protocol

from flint import fmpq

from nonsmooth.symbolic.numbers.coefficients import Coefficient, Terms, as_fraction, bits

if TYPE_CHECKING:
    import sympy

Cosines = dict[Fraction, Fraction]  # turn -> weight of cos(pi * turn); turn 0 is the constant


class SumOfRoots(Protocol):
    """What is printed of a number: its terms, and the radicands and the base of its field."""

    terms: Terms

    @property
    def field(self) -> RootField:
        """The field that the number is of."""

    def as_rational(self) -> fmpq | None:
        """The value, where it is rational."""


class RootField(Protocol):
    """What printing asks of a number field: the order of its base, and what it takes square roots of."""

    order: int

    @property
    def radicands(self) -> Sequence[SumOfRoots]:
        """One for each square root that was adjoined."""


def cosine_form(field: RootField, coefficient: Coefficient) -> Cosines:
    """A base element as a rational combination of ``cos(pi * turn)``, ``0 <= turn < 1/2``."""
    if isinstance(coefficient, fmpq):
        return {Fraction(0): as_fraction(coefficient)}
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
    """Weights w with ``sum_k q_k (2 cos t)^k = sum_m w_m cos(m t)``."""
    weights = [0] * len(coefficient)
    for k, top in enumerate(int(c) for c in coefficient.numer().coeffs()):
        for j in range(k + 1):
            weights[abs(k - 2 * j)] += top * math.comb(k, j)
    return [Fraction(weight, int(coefficient.denom())) for weight in weights]


class Summand(NamedTuple):
    """One signed summand in both notations, its sign kept apart."""

    negative: bool
    plain: str
    latex: str


def signed(summand: Summand, text: str, *, first: bool) -> str:
    """A notation of a summand with its sign, as it stands at the beginning of a sum or within it."""
    if first:
        return f"-{text}" if summand.negative else text
    return f" - {text}" if summand.negative else f" + {text}"


def plain_sum(summands: Iterable[Summand]) -> str:
    """Summands on one line, ``0`` where there are none."""
    return "".join(signed(s, s.plain, first=not k) for k, s in enumerate(summands)) or "0"


def latex_sum(summands: Iterable[Summand]) -> str:
    """Summands in LaTeX, ``0`` where there are none."""
    return "".join(signed(s, s.latex, first=not k) for k, s in enumerate(summands)) or "0"


def number_summands(number: SumOfRoots) -> list[Summand]:
    """The number as signed products of a rational, at most one cosine, and square roots.

    Their plain sum is text that :mod:`nonsmooth.symbolic.formulas.expression` reads back to the same number.
    """
    parts: list[Summand] = []
    for mask in _ordered_masks(number):
        plain_roots, latex_roots = _roots(number, mask)
        for turn, weight in cosine_form(number.field, number.terms[mask]).items():
            plain = [f"cos({_angle(turn, 'pi', '*')})"] * bool(turn) + plain_roots
            latex = [rf"\cos({_angle(turn, chr(92) + 'pi ', '')})"] * bool(turn) + latex_roots
            parts.append(_product(weight, plain, latex))
    return parts


def _ordered_masks(number: SumOfRoots) -> list[int]:
    """Terms by their radicals, smallest first: the text does not depend on the order in which roots were adjoined."""
    return sorted(number.terms, key=lambda mask: _radical_key(number, mask))


def _radical_key(number: SumOfRoots, mask: int) -> tuple[list[str], int]:
    radicands = [number.field.radicands[i] for i in bits(mask)]
    values = [radicand.as_rational() for radicand in radicands]
    nested = sorted(str(radicand) for radicand, value in zip(radicands, values, strict=True) if value is None)
    return nested, math.prod(int(value.p) for value in values if value is not None)


def _product(weight: Fraction, plain: Sequence[str], latex: Sequence[str]) -> Summand:
    """``weight * factors`` with the denominator under the whole product."""
    top, bottom = abs(weight.numerator), weight.denominator
    number = [str(top)] * (top != 1 or not plain)
    plain_top, latex_top = "*".join([*number, *plain]), " ".join([*number, *latex])
    if bottom == 1:
        return Summand(weight < 0, plain_top, latex_top)
    return Summand(weight < 0, f"{plain_top}/{bottom}", rf"\frac{{{latex_top}}}{{{bottom}}}")


def _angle(turn: Fraction, pi: str, times: str) -> str:
    top = pi if turn.numerator == 1 else f"{turn.numerator}{times}{pi}"
    return top.strip() if turn.denominator == 1 else f"{top.strip()}/{turn.denominator}"


def _roots(number: SumOfRoots, mask: int) -> tuple[list[str], list[str]]:
    """The square roots of one term: rational radicands share one root, nested ones stay factors."""
    rational, nested = 1, list[list[Summand]]()
    for i in bits(mask):
        radicand = number.field.radicands[i]
        value = radicand.as_rational()
        if value is None:
            nested.append(number_summands(radicand))
        else:
            rational *= int(value.p)
    plain = [f"sqrt({rational})"] * (rational > 1) + [f"sqrt({plain_sum(g)})" for g in nested]
    latex = [rf"\sqrt{{{rational}}}"] * (rational > 1) + [rf"\sqrt{{{latex_sum(g)}}}" for g in nested]
    return plain, latex


def number_to_sympy(number: SumOfRoots) -> sympy.Expr:
    """The number as a SymPy expression."""
    import sympy

    total = sympy.Integer(0)
    for mask in sorted(number.terms):
        root = sympy.Integer(1)
        for i in bits(mask):
            root *= sympy.sqrt(number_to_sympy(number.field.radicands[i]))
        for turn, weight in cosine_form(number.field, number.terms[mask]).items():
            cosine = sympy.cos(sympy.Rational(turn.numerator, turn.denominator) * sympy.pi)
            total += sympy.Rational(weight.numerator, weight.denominator) * cosine * root
    return total
