"""Switching surfaces ``h = 0``: a polynomial h split into the curves on which its sign can change.

Even powers change no sign and definite factors have one, so only odd powers of indefinite factors remain.  Over Q the
factorization is complete (python-flint); a quadratic form becomes its two lines wherever it has any, with a square
root adjoined to the field if needed.  With irrational coefficients that no common factor explains, h stays whole.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, TypeAlias

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import decimal_latex, decimal_text, plain_decimal
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.printing import Summand, latex_sum, number_summands, plain_sum, signed
from nonsmooth.symbolic.numbers.rounded import Rounded
from nonsmooth.symbolic.numbers.square_roots import NestingError

if TYPE_CHECKING:
    import sympy


def factorize(polynomial: Polynomial) -> tuple[Number, list[tuple[Polynomial, int]]] | None:
    """Constant and irreducible factors over Q with exponents; None for zero and for irrational coefficients."""
    rationals = {e: c.as_rational() for e, c in polynomial.terms.items()}
    coefficients = {e: q for e, q in rationals.items() if q is not None}
    if not coefficients or len(coefficients) < len(rationals):
        return None
    field, context = polynomial.field, fmpq_mpoly_ctx.get(polynomial.variables, Ordering.lex)
    constant, factors = context.from_dict(coefficients).factor()
    parts = [
        (replace(polynomial, terms={tuple(map(int, e)): field(fmpq(c)) for e, c in f.to_dict().items()}), int(k))
        for f, k in factors
    ]
    return field(fmpq(constant)), parts


@lru_cache(maxsize=256)
def switching_factors(surface: Polynomial) -> tuple[int, tuple[Polynomial, ...]]:
    """A sign and factors with ``sign(surface) = sign * prod sign(factor)`` wherever the surface is not zero.

    Each factor is scaled so that its leading coefficient is 1: equal curves have equal factors.
    """
    leading = surface.terms[max(surface.terms)]
    total = leading.sign()
    scaled = surface * leading.inverse()
    factored = factorize(scaled)
    parts = factored[1] if factored is not None else [(scaled, 1)]
    total *= 1 if factored is None else factored[0].sign()
    curves: list[Polynomial] = []
    for part, exponent in parts:
        if exponent % 2:
            sign, lines = _lines(part)
            total *= sign
            curves += lines
    return _normalized(total, curves)


def _normalized(total: int, curves: list[Polynomial]) -> tuple[int, tuple[Polynomial, ...]]:
    scaled: list[Polynomial] = []
    for curve in curves:
        leading = curve.terms[max(curve.terms)]
        total *= leading.sign()
        scaled.append(curve * leading.inverse())
    return total, tuple(scaled)


def _lines(factor: Polynomial) -> tuple[int, list[Polynomial]]:
    """A quadratic form as its two lines, or as its sign where it is definite; anything else as it is."""
    if factor.degree != 2 or not factor.is_homogeneous or len(factor.variables) != 2:
        return 1, [factor]
    zero = factor.field.zero
    a, b, c = (factor.terms.get(e, zero) for e in ((2, 0), (1, 1), (0, 2)))
    discriminant = b * b - 4 * a * c
    if discriminant.sign() < 0:
        return a.sign(), []
    x, y = Polynomial.coordinates(factor.field, factor.variables)
    if not a:
        return 1, [y, x * b + y * c]
    try:
        root = discriminant.sqrt()
    except NestingError:
        return 1, [factor]
    if not root:
        return a.sign(), []
    return a.sign(), [x - y * ((-b + root) / (2 * a)), x - y * ((-b - root) / (2 * a))]


def divides(factor: Polynomial, polynomial: Polynomial) -> bool | None:
    """Whether a polynomial over Q is a multiple of a factor over Q; None for irrational coefficients."""
    exact, whole = _over_rationals(factor), _over_rationals(polynomial)
    return None if exact is None or whole is None else not whole % exact


def quotient(polynomial: Polynomial, factor: Polynomial) -> Polynomial | None:
    """A multiple of a factor divided by it; None for what is no multiple, and for irrational coefficients."""
    exact, whole = _over_rationals(factor), _over_rationals(polynomial)
    if exact is None or whole is None or whole % exact:
        return None
    terms = (whole / exact).to_dict().items()
    return replace(polynomial, terms={tuple(map(int, e)): polynomial.field.rational(q) for e, q in terms})


def _over_rationals(polynomial: Polynomial) -> fmpq_mpoly | None:
    """The polynomial over Q; None for irrational coefficients."""
    coefficients = {e: q for e, c in polynomial.terms.items() if (q := c.as_rational()) is not None}
    context = fmpq_mpoly_ctx.get(polynomial.variables, Ordering.lex)
    return context.from_dict(coefficients) if len(coefficients) == len(polynomial.terms) else None


# ---- formulas that are linear in exact numbers, as plain text, LaTeX and SymPy -------------------
#
# A :class:`Formula` is ``sum_k number_k * monomial_k``, e.g. ``-sqrt(2)*u_1 - sqrt(2)/2*u_2*y``.  Numbers are written
# in the form a reader recognizes (square roots, cosines of rational multiples of pi), straight from the field:
# SymPy would turn ``cos(pi/10)`` into nested square roots.


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
