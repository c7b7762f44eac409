"""Switching surfaces ``h = 0``: a polynomial h split into the curves on which its sign can change.

Even powers change no sign and definite factors have one, so only odd powers of indefinite factors remain.  Over Q the
factorization is complete (python-flint); a quadratic form becomes its two lines wherever it has any, with a square
root adjoined to the field if needed.  With irrational coefficients that no common factor explains, h stays whole.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.square_roots import NestingError


def factorize(polynomial: Polynomial) -> tuple[Number, list[tuple[Polynomial, int]]] | None:
    """Constant and irreducible factors over Q with exponents; None for zero and for irrational coefficients."""
    rationals = {e: c.as_rational() for e, c in polynomial.terms.items()}
    known = {e: q for e, q in rationals.items() if q is not None}
    if not known or len(known) < len(rationals):
        return None
    field, context = polynomial.field, fmpq_mpoly_ctx.get(polynomial.variables, Ordering.lex)
    constant, factors = context.from_dict(known).factor()
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
    x, y = (Polynomial.variable(factor.field, factor.variables, name) for name in factor.variables)
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
    known = {e: q for e, c in polynomial.terms.items() if (q := c.as_rational()) is not None}
    context = fmpq_mpoly_ctx.get(polynomial.variables, Ordering.lex)
    return context.from_dict(known) if len(known) == len(polynomial.terms) else None
