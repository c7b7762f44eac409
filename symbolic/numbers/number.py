"""Real number fields and their elements: exact arithmetic, certified signs.

An element is a sparse sum ``sum_S c_S prod_{i in S} sqrt(g_i)`` with ``c_S`` in the base field (see
:mod:`nonsmooth.symbolic.numbers.number_field`); the products are linearly independent, so it is zero iff it has no
terms. Signs are decided by a float filter with a rigorous rounding bound, then by balls (python-flint) at rising
precision; because zero is excluded beforehand this ends.  Division by a sum of r independent roots may need 2^r
terms: the one operation to avoid in inner loops.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from flint import arb, ctx, fmpq, fmpq_poly, fmpz, fmpz_poly

from nonsmooth.symbolic.numbers.coefficients import (
    UNIT_BITS,
    Coefficient,
    Rational,
    as_fmpq,
    as_fraction,
    base_inverse,
    bits,
    fmpq_to_float,
    height,
    is_rational,
    product_units,
)
from nonsmooth.symbolic.numbers.exact_real import ExactReal
from nonsmooth.symbolic.numbers.printing import latex_sum, number_summands, number_to_sympy, plain_sum
from nonsmooth.symbolic.numbers.work_limit import WorkMeter

if TYPE_CHECKING:
    import sympy

_FLOAT_BITS = 53
_FILTER_BITS = 40  # float filter: sums of < 2^10 terms lose < 13 bits of 53, so 40 bits are safe
TINY, HUGE = 2.0**-900, 2.0**900  # outside this range floats may under- or overflow: use balls
_FIRST_PRECISION = 128
_RATIONAL = (int, fmpq, fmpz, Fraction)  # as a tuple: the union `int | fmpq` would be made anew at every call


def sign(value: Any) -> int:
    """Sign -1, 0 or 1 of a field element (exact), fraction or float."""
    return value.sign() if hasattr(value, "sign") else (value > 0) - (value < 0)


class Number(ExactReal):
    """Immutable element of a :class:`Tower`; +, -, *, /, ** int, comparisons and hash are exact."""

    __slots__ = ("_float", "_hash", "_sign", "field", "terms")

    def __init__(self, field: Tower, terms: dict[int, Coefficient]) -> None:
        self.field = field
        self.terms = terms
        self._sign: int | None = None
        self._hash: int | None = None
        self._float: float | None = None

    # ---- ring operations -----------------------------------------------------------------

    def _operand(self, value: Any) -> Number | None:
        if type(value) in (int, fmpq):  # by far the most
            return self.field.rational(value)
        if isinstance(value, Number):
            if value.field is not self.field:
                raise ValueError("required numbers of one field, received two fields")
            return value
        if isinstance(value, _RATIONAL):
            return self.field.rational(fmpq(value) if isinstance(value, fmpz) else value)
        return None

    def __add__(self, value: Any) -> Number:
        other = value if type(value) is Number and value.field is self.field else self._operand(value)
        if other is None:
            return NotImplemented
        self_terms, others = self.terms, other.terms
        if len(self_terms) == 1 == len(others) and 0 in self_terms and 0 in others:  # by far the most
            total = self_terms[0] + others[0]
            return Number(self.field, {0: total} if total else {})
        if not others:
            return self
        terms = self_terms.copy()
        for mask, c in others.items():
            total = terms[mask] + c if mask in terms else c
            if total:
                terms[mask] = total
            else:
                del terms[mask]
        return Number(self.field, terms)

    def __sub__(self, value: Any) -> Number:
        other = value if type(value) is Number and value.field is self.field else self._operand(value)
        if other is None:
            return NotImplemented
        self_terms, others = self.terms, other.terms
        if len(self_terms) == 1 == len(others) and 0 in self_terms and 0 in others:  # by far the most
            total = self_terms[0] - others[0]
            return Number(self.field, {0: total} if total else {})
        if not others:
            return self
        terms = self_terms.copy()
        for mask, c in others.items():
            total = terms[mask] - c if mask in terms else -c
            if total:
                terms[mask] = total
            else:
                del terms[mask]
        return Number(self.field, terms)

    def __neg__(self) -> Number:
        if len(self.terms) == 1:  # by far the most; a comprehension is a call
            (mask,) = self.terms
            return Number(self.field, {mask: -self.terms[mask]})
        return Number(self.field, {mask: -c for mask, c in self.terms.items()})

    def __mul__(self, value: Any) -> Number:
        if type(value) is Number and value.field is self.field:
            other: Number | None = value
        elif type(value) in (int, fmpq) and self.field.modulus is None:
            return self._multiple(fmpq(value))
        else:
            other = self._operand(value)
        if other is None:
            return NotImplemented
        field, self_terms, others = self.field, self.terms, other.terms
        if not self_terms or not others:
            return field.zero
        modulus = field.modulus
        if modulus is None and len(self_terms) == 1 == len(others):
            if 0 in self_terms and 0 in others:  # by far the most
                if field.meter is not None:
                    field.meter.spend(1 + (self_terms[0].height_bits() + others[0].height_bits()) // UNIT_BITS)
                return Number(field, {0: self_terms[0] * others[0]})
            (s,), (t,) = self_terms, others
            common = field.rational_radicand(s & t) if s & t else 1
            if common is not None:  # a rational number times different roots: nothing to collect
                if field.meter is not None:
                    field.meter.spend(1 + (self_terms[s].height_bits() + others[t].height_bits()) // UNIT_BITS)
                product = self_terms[s] * others[t]
                return Number(field, {s ^ t: product * common if s & t else product})
        elif modulus is None and is_rational(self_terms):
            return other._multiple(self_terms[0])
        elif modulus is None and is_rational(others):
            return self._multiple(others[0])
        if field.meter is not None:
            field.meter.spend(product_units(self.terms, other.terms, self.field.base_degree))
        terms: dict[int, Coefficient] = {}
        nested: Number = field.zero
        for s, a in self.terms.items():
            for t, b in other.terms.items():
                product = a * b if modulus is None else (a * b) % modulus
                mask, shared = s ^ t, s & t
                if shared:
                    factor = field.radicand_product(shared).terms
                    if len(factor) > 1 or 0 not in factor:
                        monomial = Number(field, {mask: product})
                        nested = nested + monomial * field.radicand_product(shared)
                        continue
                    product = product * factor[0] if modulus is None else (product * factor[0]) % modulus
                terms[mask] = terms[mask] + product if mask in terms else product
        result = field.collected(terms)
        return result + nested if nested.terms else result

    __radd__, __rmul__ = __add__, __mul__

    def _multiple(self, factor: fmpq) -> Number:
        """The product over the rationals by one of them: nothing to collect."""
        field, self_terms = self.field, self.terms
        if not self_terms or not factor:
            return field.zero
        if field.meter is not None:
            field.meter.spend(product_units(self_terms, {0: factor}, field.base_degree))
        if len(self_terms) == 1:  # by far the most; a comprehension is a call
            (mask,) = self_terms
            return Number(field, {mask: self_terms[mask] * factor})
        return Number(field, {mask: c * factor for mask, c in self_terms.items()})

    def __pow__(self, exponent: int) -> Number:
        return super().__pow__(exponent) if exponent >= 0 else self.inverse() ** -exponent

    def inverse(self) -> Number:
        """Multiplicative inverse, by conjugating the highest square root away.

        Raises:
            ZeroDivisionError: for zero.
        """
        if not self.terms:
            raise ZeroDivisionError("division by zero in the number field")
        field = self.field
        if len(self.terms) == 1:
            ((mask, c),) = self.terms.items()
            if not mask:
                if field.meter is not None:
                    field.meter.spend(field.base_degree * product_units(self.terms, self.terms, field.base_degree))
                return Number(field, {0: base_inverse(c, field.modulus)})
            root = Number(field, {mask: field.coefficient(fmpq(1))})
            return root * (Number(field, {0: c}) * field.radicand_product(mask)).inverse()
        top = 1 << (max(self.terms).bit_length() - 1)
        conjugate = Number(field, {mask: -c if mask & top else c for mask, c in self.terms.items()})
        return conjugate * (self * conjugate).inverse()

    def __truediv__(self, value: Any) -> Number:
        other = self._operand(value)
        if other is None:
            return NotImplemented
        field = self.field
        if field.modulus is None and len(self.terms) == 1 == len(other.terms):
            ((s, a),), ((t, b),) = self.terms.items(), other.terms.items()
            radicand = field.rational_radicand(t & ~s)  # of the roots that the divisor alone has
            if radicand is not None:
                if field.meter is not None:  # what the inverse and the product would cost
                    field.meter.spend(2 + (a.height_bits() + 3 * b.height_bits()) // UNIT_BITS)
                return Number(field, {s ^ t: a / (b * radicand) if t & ~s else a / b})
        return self * other.inverse()

    def __rtruediv__(self, value: Any) -> Number:
        return self.inverse() * value

    # ---- order ---------------------------------------------------------------------------

    def sign(self) -> int:
        """Certified sign: -1, 0 or 1."""
        if self._sign is None:
            self._sign = self._decide_sign()
        return self._sign

    def _compare(self, value: Any) -> int | None:
        other = value if type(value) is Number and value.field is self.field else self._operand(value)
        if other is None:
            return None
        if self.field.modulus is None and is_rational(self.terms) and is_rational(other.terms):
            a, b = self.terms[0], other.terms[0]
            return (a > b) - (a < b)
        return 0 if other is self else (self - other).sign()

    def _decide_sign(self) -> int:
        if not self.terms:
            return 0
        if self.field.modulus is None and len(self.terms) == 1:
            return 1 if next(iter(self.terms.values())) > 0 else -1
        value, magnitude = self._float_filter()
        if TINY < magnitude < HUGE and abs(value) > magnitude * 2.0**-_FILTER_BITS:
            return 1 if value > 0 else -1
        precision = _FIRST_PRECISION
        while True:  # ends: the terms are independent, so the value is not zero
            with ctx.workprec(precision):
                ball = self.ball()
            if ball > 0:
                return 1
            if ball < 0:
                return -1
            precision *= 2

    def _float_filter(self) -> tuple[float, float]:
        """Float value and the sum of absolute terms that bounds its rounding error."""
        field = self.field
        total = magnitude = 0.0
        for mask, c in self.terms.items():
            root = field.float_product(mask)
            if field.modulus is None:
                term = fmpq_to_float(c) * root
                total += term
                magnitude += abs(term)
            else:
                power = root
                for q in c.coeffs():
                    term = fmpq_to_float(q) * power
                    total += term
                    magnitude += abs(term)
                    power *= field.base_float
        return total, magnitude

    def ball(self) -> arb:
        """Enclosure of the value at the working precision of ``flint.ctx``."""
        field = self.field
        if field.modulus is None and len(self.terms) == 1 and 0 in self.terms:  # by far the most
            return arb(self.terms[0])
        total = arb(0)
        for mask, c in self.terms.items():
            if field.modulus is None:
                term = arb(c)
            else:
                term, base = arb(0), field.base_ball()
                for q in reversed(c.coeffs()):
                    term = term * base + arb(q)
            for i in bits(mask):
                term *= field.root_ball(i)
            total += term
        return total

    def __float__(self) -> float:
        if self._float is None:
            self._float = self._rounded()
        return self._float

    def _rounded(self) -> float:
        """The nearest float, or one next to it."""
        if not self.terms:
            return 0.0
        if self.field.modulus is None and len(self.terms) == 1:
            ((mask, c),) = self.terms.items()
            value = fmpq_to_float(c) * (self.field.float_product(mask) if mask else 1.0)
            if not mask or TINY < abs(value) < HUGE:
                return value  # one product of correctly rounded factors: no cancellation
        return float(self.accurate_ball(_FLOAT_BITS).mid())

    def accurate_ball(self, bits: int) -> arb:
        """Enclosure of a nonzero value with more correct bits than these."""
        precision = max(_FIRST_PRECISION, 2 * bits)
        while True:
            with ctx.workprec(precision):
                ball = self.ball()
            if ball.rel_accuracy_bits() > bits:
                return ball
            precision *= 2

    @property
    def size_bits(self) -> int:
        """Bits of the longest integers of all coefficients together."""
        return sum(height(c) for c in self.terms.values())

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __eq__(self, value: object) -> bool:
        other = self._operand(value)
        return NotImplemented if other is None else self.terms == other.terms

    def __hash__(self) -> int:
        if self._hash is None:
            rational = self.as_rational()
            if rational is not None:  # equal to a Fraction, so hashed like one
                self._hash = hash(as_fraction(rational))
            else:
                self._hash = hash(frozenset((mask, str(c)) for mask, c in self.terms.items()))
        return self._hash

    # ---- conversion ----------------------------------------------------------------------

    def as_rational(self) -> fmpq | None:
        """The value as a rational number, or None where it is irrational."""
        if not self.terms:
            return fmpq(0)
        if len(self.terms) > 1 or 0 not in self.terms:
            return None
        c = self.terms[0]
        if self.field.modulus is None:
            return c
        return c.coeffs()[0] if c.degree() == 0 else None

    def sqrt(self) -> Number:
        """Non-negative square root in the (possibly grown) field."""
        return self.field.sqrt(self)

    def __str__(self) -> str:
        return plain_sum(number_summands(self))

    def latex(self) -> str:
        """As a formula, without dollar signs."""
        return latex_sum(number_summands(self))

    def _repr_latex_(self) -> str:
        return f"${self.latex()}$"

    def __repr__(self) -> str:
        return f"Number({self})"

    def to_sympy(self) -> sympy.Expr:
        """The same number as a SymPy expression (square roots and cosines)."""
        return number_to_sympy(self)


class Tower(ABC):
    """A tower ``Q(2 cos(2 pi/N)) (sqrt g_1) ... (sqrt g_r)`` of real fields: what the arithmetic of its elements needs.

    Which square roots it holds, and which are adjoined, a subclass says (``NumberField``).

    Args:
        order: N of the base ``Q(2 cos(2 pi/N))``; 1 gives the rationals.
        measured: turns t of angles ``pi t`` that stand for rational directions
            (:mod:`nonsmooth.symbolic.numbers.number_field`).

    Attributes:
        writes_decimals: whether people read its numbers as decimals, as those of scenes with units; JSON holds them
            exactly in any case.
    """

    writes_decimals = False

    def __init__(self, order: int, measured: Iterable[Fraction]) -> None:
        self.order = order
        self.measured = tuple(measured)
        minimal = fmpz_poly.cos_minpoly(order)
        self.base_degree = minimal.degree()
        self.modulus: fmpq_poly | None = fmpq_poly(minimal) if self.base_degree > 1 else None
        self.base_float = 2 * math.cos(2 * math.pi / order)
        self.radicands: list[Number] = []
        self.root_floats: list[float] = []
        self.square_roots: dict[Number, Number] = {}
        self._radicand_products: dict[int, Number] = {}
        self._rational_radicands: dict[int, fmpq | None] = {}
        self._float_products: dict[int, float] = {}
        self._root_balls: dict[tuple[int, int], arb] = {}
        self.meter: WorkMeter | None = None  # counts products while a limit is set
        self.rounded_signs = 0  # how many decisions were those of a rounded number alone
        self.zero = Number(self, {})
        self.one = self.rational(1)

    @abstractmethod
    def sqrt(self, value: Number | Rational) -> Number:
        """Non-negative square root; raises ValueError of a negative number."""

    def rational(self, value: Rational) -> Number:
        """Embed a rational number."""
        number = as_fmpq(value)
        return Number(self, {0: self.coefficient(number)} if number else {})

    def __call__(self, value: Number | Rational) -> Number:
        """Element of this field from a rational, or the element itself."""
        if isinstance(value, Number):
            if value.field is not self:
                raise ValueError("required a number of this field, received one of another field")
            return value
        return self.rational(value)

    def coefficient(self, value: fmpq) -> Coefficient:
        """A rational as an element of the base field."""
        return value if self.modulus is None else fmpq_poly([value])

    def two_cos(self, multiple: int) -> Number:
        """``2 cos(2 pi k/N)`` as a polynomial in the base generator (Chebyshev, ``2 T_k(c/2)``)."""
        k = multiple % self.order
        polynomial = fmpq_poly(fmpz_poly.chebyshev_t(min(k, self.order - k)))
        scaled = polynomial(fmpq_poly([0, fmpq(1, 2)])) * 2
        if self.modulus is None:  # N in {1, 2, 3, 4, 6}: the base generator is an integer
            return self.rational(scaled(fmpq(round(self.base_float))))
        return self.collected({0: scaled % self.modulus})

    def adjoin(self, radicand: Number) -> Number:
        """Add the generator ``sqrt(radicand)``; the caller has proved it is not in the field yet."""
        self.radicands.append(radicand)
        self.root_floats.append(math.sqrt(float(radicand)) if -HUGE < float(radicand) < HUGE else math.inf)
        return Number(self, {1 << (len(self.radicands) - 1): self.coefficient(fmpq(1))})

    def collected(self, terms: Mapping[int, Coefficient]) -> Number:
        """The element with these terms; zero coefficients are dropped."""
        return Number(self, {mask: c for mask, c in terms.items() if c})

    def combination(self, factors: Iterable[fmpq], numbers: Iterable[Number]) -> Number:
        """``sum_k q_k x_k`` of elements by rational numbers: terms are collected once."""
        terms: dict[int, Coefficient] = {}
        products = 0
        for factor, number in zip(factors, numbers, strict=True):
            products += len(number.terms)
            for mask, c in number.terms.items():
                terms[mask] = terms[mask] + factor * c if mask in terms else factor * c
        if self.meter is not None:
            longest = max(map(height, terms.values()), default=0)
            self.meter.spend(products * self.base_degree * (1 + longest // UNIT_BITS))
        return self.collected(terms)

    def radicand_product(self, mask: int) -> Number:
        """``prod_{i in mask} g_i``."""
        if mask not in self._radicand_products:
            product = self.one
            for i in bits(mask):
                product = product * self.radicands[i]
            self._radicand_products[mask] = product
        return self._radicand_products[mask]

    def rational_radicand(self, mask: int) -> fmpq | None:
        """``prod_{i in mask} g_i`` over the rationals; None where it is irrational."""
        if mask not in self._rational_radicands:
            self._rational_radicands[mask] = self.radicand_product(mask).as_rational()
        return self._rational_radicands[mask]

    def float_product(self, mask: int) -> float:
        """``prod_{i in mask} sqrt(g_i)`` in floats."""
        if mask not in self._float_products:
            self._float_products[mask] = math.prod((self.root_floats[i] for i in bits(mask)), start=1.0)
        return self._float_products[mask]

    def root_ball(self, index: int) -> arb:
        """Enclosure of a generator at the working precision of ``flint.ctx``."""
        key = (index, ctx.prec)
        if key not in self._root_balls:
            self._root_balls[key] = self.radicands[index].ball().sqrt()
        return self._root_balls[key]

    def base_ball(self) -> arb:
        """Enclosure of ``2 cos(2 pi/N)`` at the working precision of ``flint.ctx``."""
        key = (-1, ctx.prec)
        if key not in self._root_balls:
            self._root_balls[key] = 2 * arb.cos_pi_fmpq(fmpq(2, self.order))
        return self._root_balls[key]
