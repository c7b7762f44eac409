"""Formulas that are linear in exact numbers, as plain text, LaTeX and SymPy.

A :class:`Formula` is ``sum_k number_k * monomial_k``, e.g. ``-sqrt(2)*u_1 - sqrt(2)/2*u_2*y``.  Numbers are written
in the form a reader recognizes (square roots, cosines of rational multiples of pi), straight from the field:
SymPy would turn ``cos(pi/10)`` into nested square roots.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import decimal_latex, decimal_text, plain_decimal
from nonsmooth.symbolic.numbers.printing import Summand, latex_sum, number_summands, plain_sum, signed
from nonsmooth.symbolic.numbers.rounded import Rounded

if TYPE_CHECKING:
    import sympy

LINE_LENGTH = 76  # characters of plain text after which a formula continues on the next line
LINE_BREAK = " \\\\\n&\\quad "  # inside an aligned block

Monomial: TypeAlias = tuple[str, ...]


@dataclass(frozen=True)
class Formula:
    """``sum_k number_k * monomial_k``; a monomial is a tuple of symbol names, () for a constant."""

    terms: tuple[tuple[Number, Monomial], ...]

    def plain(self, longest: int | None = None) -> str:
        """On one line, ``0`` where nothing is left.

        Args:
            longest: round coefficients of more characters to ten digits, and all of a scene with units to six; None
                keeps all exact.
        """
        return plain_sum(self.summands(longest))

    def latex(self, line_break: str = "", longest: int | None = None) -> str:
        """LaTeX; with a ``line_break`` (see LINE_BREAK) long formulas continue on further lines."""
        text, length = "", 0
        for summand in self.summands(longest):
            if line_break and length and length + len(summand.plain) > LINE_LENGTH:
                text, length = text + line_break, 0
            text += signed(summand, summand.latex, first=not text)
            length += len(summand.plain) + 3
        return text or "0"

    def to_sympy(self) -> sympy.Expr:
        """The same formula in SymPy; symbols are real."""
        import sympy

        total = sympy.Integer(0)
        for number, monomial in self.terms:
            total += number.to_sympy() * sympy.Mul(*(sympy.Symbol(name, real=True) for name in monomial))
        return total

    def summands(self, longest: int | None = None) -> list[Summand]:
        """The nonzero summands; a coefficient that is a sum itself stays in parentheses while it is short."""
        parts: list[Summand] = []
        for number, monomial in self.terms:
            coefficients = number_summands(number)
            inner = plain_sum(coefficients)
            if longest is not None and (len(inner) > longest or number.field.writes_decimals):
                coefficients = [_rounded(number)]
            elif len(coefficients) > 1 and monomial and len(inner) <= LINE_LENGTH:
                coefficients = [Summand(False, f"({inner})", rf"\left({latex_sum(coefficients)}\right)")]
            parts += [_times(summand, monomial) for summand in coefficients]
        return parts


def constant(number: Number) -> Formula:
    """A formula without symbols."""
    return Formula(((number, ()),))


def number_latex(number: Number, longest: int | None = None) -> str:
    """LaTeX of a number, rounded where its text has more than ``longest`` characters."""
    return constant(number).latex(longest=longest)


def symbol_latex(name: str) -> str:
    """``u_12`` becomes ``u_{12}``."""
    stem, _, index = name.partition("_")
    return f"{stem}_{{{index}}}" if index else stem


def _rounded(number: Number) -> Summand:
    if isinstance(number, Rounded):
        number = number.exact  # to be written is no decision, which would be counted
    decimal = plain_decimal(abs(number)) if number.field.writes_decimals else decimal_text(abs(number))
    return Summand(number.sign() < 0, decimal, decimal_latex(decimal))


def _times(summand: Summand, monomial: Monomial) -> Summand:
    if not monomial:
        return summand
    plain = [summand.plain] * (summand.plain != "1") + list(monomial)
    latex = [summand.latex] * (summand.plain != "1") + [symbol_latex(name) for name in monomial]
    return Summand(summand.negative, "*".join(plain), " ".join(latex))
