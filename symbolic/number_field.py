"""One real number field per scene: exact arithmetic, certified signs.

The field is a tower ``Q(2 cos(2 pi/N)) (sqrt g_1) ... (sqrt g_r)``: a real cyclotomic base for
regular rings, square roots for the lengths of rim directions.  An element is a sparse sum
``sum_S c_S prod_{i in S} sqrt(g_i)`` with ``c_S`` in the base field, so a sum of three square roots
stays three terms however many square roots the scene holds.

Why this and not one primitive element: the degree doubles with every new wheel length, while the
numbers that a contact state needs hold at most three of them.  A generator is adjoined only when it
is proved to be no square yet (:mod:`nonsmooth.symbolic.square_roots`), hence the products of the
generators are linearly independent and a number is zero iff it has no terms.  Signs are decided by a
float filter with a rigorous rounding bound, then by balls (python-flint) at rising precision; because
zero is excluded beforehand this ends.  Division by a sum of r independent roots may need 2^r terms:
the one operation to avoid in inner loops.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeAlias

from flint import arb, ctx, fmpq, fmpq_poly, fmpz, fmpz_poly

if TYPE_CHECKING:
    import sympy

Coefficient: TypeAlias = Any  # fmpq over Q, fmpq_poly reduced by the base modulus otherwise
Rational: TypeAlias = int | Fraction | fmpq

_FLOAT_BITS = 53
_FILTER_BITS = 40  # float filter: sums of < 2^10 terms lose < 13 bits of 53, so 40 bits are safe
_TINY, _HUGE = 2.0**-900, 2.0**900  # outside this range floats may under- or overflow: use balls
_FIRST_PRECISION = 128


class Ordered(Protocol):
    """What the geometry needs of a number: floats, fractions and field elements all qualify."""

    def __add__(self, other: Any, /) -> Any: ...
    def __sub__(self, other: Any, /) -> Any: ...
    def __mul__(self, other: Any, /) -> Any: ...
    def __neg__(self) -> Any: ...
    def __lt__(self, other: Any, /) -> bool: ...


def sign(value: Any) -> int:
    """Sign -1, 0 or 1 of a field element (exact), fraction or float."""
    return value.sign() if hasattr(value, "sign") else (value > 0) - (value < 0)


def as_fmpq(value: Rational) -> fmpq:
    """Convert an int, Fraction or fmpq to fmpq."""
    if isinstance(value, Fraction):
        return fmpq(value.numerator, value.denominator)
    return fmpq(value)


def fmpq_to_float(value: fmpq) -> float:
    """Correctly rounded float of a rational (infinite on overflow)."""
    try:
        return int(value.p) / int(value.q)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


class NumberField:
    """The field ``Q(2 cos(2 pi/N), sqrt g_1, ..., sqrt g_r)``, r growing on demand.

    Args:
        order: N of the base ``Q(2 cos(2 pi/N))``; 1 gives the rationals.
    """

    def __init__(self, order: int = 1) -> None:
        self.order = order
        minimal = fmpz_poly.cos_minpoly(order)
        self.base_degree = minimal.degree()
        self.modulus: fmpq_poly | None = fmpq_poly(minimal) if self.base_degree > 1 else None
        self.radicands: list[Number] = []
        self._radicand_products: dict[int, Number] = {}
        self._root_balls: dict[tuple[int, int], arb] = {}
        self._root_floats: list[float] = []
        self._square_roots: dict[Number, Number] = {}
        self._base_float = 2 * math.cos(2 * math.pi / order)
        self.zero = Number(self, {})
        self.one = self.rational(1)

    def rational(self, value: Rational) -> Number:
        """Embed a rational number."""
        number = as_fmpq(value)
        return Number(self, {0: self._coefficient(number)} if number else {})

    def __call__(self, value: Number | Rational) -> Number:
        """Element of this field from a rational, or the element itself."""
        if isinstance(value, Number):
            if value.field is not self:
                raise ValueError("required a number of this field, received one of another field")
            return value
        return self.rational(value)

    def _coefficient(self, value: fmpq) -> Coefficient:
        return value if self.modulus is None else fmpq_poly([value])

    def two_cos(self, multiple: int) -> Number:
        """``2 cos(2 pi k/N)`` as a polynomial in the base generator (Chebyshev, ``2 T_k(c/2)``)."""
        k = multiple % self.order
        polynomial = fmpq_poly(fmpz_poly.chebyshev_t(min(k, self.order - k)))
        scaled = polynomial(fmpq_poly([0, fmpq(1, 2)])) * 2
        if self.modulus is None:  # N in {1, 2, 3, 4, 6}: the base generator is an integer
            return self.rational(scaled(fmpq(round(self._base_float))))
        return self._reduced({0: scaled % self.modulus})

    def cos_pi(self, turn: Fraction) -> Number:
        """``cos(pi * turn)``: square roots for multiples of pi/12, the base field otherwise.

        Raises:
            ValueError: if the base field does not hold it (see :func:`base_order`).
        """
        if 12 % turn.denominator == 0:
            twelfths = int(turn * 12) % 24
            twelfths = min(twelfths, 24 - twelfths)
            value = self._cos_twelfth(min(twelfths, 12 - twelfths))
            return value if twelfths <= 6 else -value
        multiple = turn * self.order / 2
        if multiple.denominator != 1:
            raise ValueError(f"required an angle of the field of order {self.order}, received pi*{turn}")
        return self.two_cos(multiple.numerator) / 2

    def _cos_twelfth(self, k: int) -> Number:
        """``cos(k pi/12)`` for 0 <= k <= 6."""
        root = self.sqrt
        match k:
            case 1:
                return (root(6) + root(2)) / 4
            case 2:
                return root(3) / 2
            case 3:
                return root(2) / 2
            case 5:
                return (root(6) - root(2)) / 4
            case _:
                return self.rational({0: Fraction(1), 4: Fraction(1, 2), 6: Fraction(0)}[k])

    def sin_pi(self, turn: Fraction) -> Number:
        """``sin(pi * turn) = cos(pi * (1/2 - turn))``."""
        return self.cos_pi(Fraction(1, 2) - turn)

    def sqrt(self, value: Number | Rational) -> Number:
        """Non-negative square root; adjoins a generator when the field does not hold it yet.

        Raises:
            ValueError: if the value is negative.
        """
        number = self(value)
        if number not in self._square_roots:
            from nonsmooth.symbolic.square_roots import square_root

            self._square_roots[number] = square_root(self, number)
        return self._square_roots[number]

    def adjoin(self, radicand: Number) -> Number:
        """Add the generator ``sqrt(radicand)``; the caller has proved it is not in the field yet."""
        self.radicands.append(radicand)
        self._root_floats.append(math.sqrt(float(radicand)) if -_HUGE < float(radicand) < _HUGE else math.inf)
        return Number(self, {1 << (len(self.radicands) - 1): self._coefficient(fmpq(1))})

    # ---- internal helpers of Number ------------------------------------------------------

    def _reduced(self, terms: Mapping[int, Coefficient]) -> Number:
        return Number(self, {mask: c for mask, c in terms.items() if c})

    def radicand_product(self, mask: int) -> Number:
        """``prod_{i in mask} g_i``."""
        if mask not in self._radicand_products:
            product = self.one
            for i in bits(mask):
                product = product * self.radicands[i]
            self._radicand_products[mask] = product
        return self._radicand_products[mask]

    def _root_ball(self, index: int) -> arb:
        key = (index, ctx.prec)
        if key not in self._root_balls:
            self._root_balls[key] = self.radicands[index].ball().sqrt()
        return self._root_balls[key]

    def _base_ball(self) -> arb:
        key = (-1, ctx.prec)
        if key not in self._root_balls:
            self._root_balls[key] = 2 * arb.cos_pi_fmpq(fmpq(2, self.order))
        return self._root_balls[key]


def base_order(turns: Iterable[Fraction]) -> int:
    """Order N of the smallest base that holds cos and sin of every angle ``pi * turn``."""
    order = 1
    for turn in turns:
        for angle in (turn, Fraction(1, 2) - turn):
            if 12 % angle.denominator:
                order = math.lcm(order, 2 * angle.denominator)
    return order


def bits(mask: int) -> list[int]:
    """Indices of the set bits of a mask, ascending."""
    return [i for i in range(mask.bit_length()) if mask >> i & 1]


class Number:
    """Immutable element of a :class:`NumberField`; +, -, *, /, ** int, comparisons and hash are exact."""

    __slots__ = ("_hash", "_sign", "field", "terms")

    def __init__(self, field: NumberField, terms: dict[int, Coefficient]) -> None:
        self.field = field
        self.terms = terms
        self._sign: int | None = None
        self._hash: int | None = None

    # ---- ring operations -----------------------------------------------------------------

    def _other(self, value: Any) -> Number | None:
        if isinstance(value, Number):
            if value.field is not self.field:
                raise ValueError("required numbers of one field, received two fields")
            return value
        if isinstance(value, int | Fraction | fmpq | fmpz):
            return self.field.rational(fmpq(value) if isinstance(value, fmpz) else value)
        return None

    def __add__(self, value: Any) -> Number:
        other = self._other(value)
        if other is None:
            return NotImplemented
        if not other.terms:
            return self
        terms = dict(self.terms)
        for mask, c in other.terms.items():
            total = terms[mask] + c if mask in terms else c
            if total:
                terms[mask] = total
            else:
                del terms[mask]
        return Number(self.field, terms)

    __radd__ = __add__

    def __neg__(self) -> Number:
        return Number(self.field, {mask: -c for mask, c in self.terms.items()})

    def __pos__(self) -> Self:
        return self

    def __sub__(self, value: Any) -> Number:
        other = self._other(value)
        return NotImplemented if other is None else self + (-other)

    def __rsub__(self, value: Any) -> Number:
        return -self + value

    def __mul__(self, value: Any) -> Number:
        other = self._other(value)
        if other is None:
            return NotImplemented
        field, modulus = self.field, self.field.modulus
        if not self.terms or not other.terms:
            return field.zero
        if modulus is None and len(self.terms) == 1 == len(other.terms):
            ((s, a),), ((t, b),) = self.terms.items(), other.terms.items()
            if not s & t:  # a rational factor, or two different roots: nothing to collect
                return Number(field, {s ^ t: a * b})
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
        result = field._reduced(terms)
        return result + nested if nested.terms else result

    __rmul__ = __mul__

    def __pow__(self, exponent: int) -> Number:
        if not isinstance(exponent, int):
            return NotImplemented
        base = self if exponent >= 0 else self.inverse()
        result, power = self.field.one, abs(exponent)
        while power:
            if power & 1:
                result = result * base
            power >>= 1
            base = base * base if power else base
        return result

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
                return Number(field, {0: self._base_inverse(c)})
            root = Number(field, {mask: field._coefficient(fmpq(1))})
            return root * (Number(field, {0: c}) * field.radicand_product(mask)).inverse()
        top = 1 << (max(self.terms).bit_length() - 1)
        conjugate = Number(field, {mask: -c if mask & top else c for mask, c in self.terms.items()})
        return conjugate * (self * conjugate).inverse()

    def _base_inverse(self, coefficient: Coefficient) -> Coefficient:
        modulus = self.field.modulus
        if modulus is None:
            return 1 / coefficient
        divisor, cofactor, _ = coefficient.xgcd(modulus)
        return (cofactor * (1 / divisor.coeffs()[0])) % modulus

    def __truediv__(self, value: Any) -> Number:
        other = self._other(value)
        return NotImplemented if other is None else self * other.inverse()

    def __rtruediv__(self, value: Any) -> Number:
        return self.inverse() * value

    # ---- order ---------------------------------------------------------------------------

    def sign(self) -> int:
        """Certified sign: -1, 0 or 1."""
        if self._sign is None:
            self._sign = self._decide_sign()
        return self._sign

    def _decide_sign(self) -> int:
        if not self.terms:
            return 0
        if self.field.modulus is None and len(self.terms) == 1:
            return 1 if next(iter(self.terms.values())) > 0 else -1
        value, magnitude = self._float_filter()
        if _TINY < magnitude < _HUGE and abs(value) > magnitude * 2.0**-_FILTER_BITS:
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
            root = 1.0
            for i in bits(mask):
                root *= field._root_floats[i]
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
                    power *= field._base_float
        return total, magnitude

    def ball(self) -> arb:
        """Enclosure of the value at the working precision of ``flint.ctx``."""
        field = self.field
        total = arb(0)
        for mask, c in self.terms.items():
            if field.modulus is None:
                term = arb(c)
            else:
                term, base = arb(0), field._base_ball()
                for q in reversed(c.coeffs()):
                    term = term * base + arb(q)
            for i in bits(mask):
                term *= field._root_ball(i)
            total += term
        return total

    def __float__(self) -> float:
        if not self.terms:
            return 0.0
        if self.field.modulus is None and len(self.terms) == 1 and 0 in self.terms:
            return fmpq_to_float(self.terms[0])
        if len(self.terms) == 1:
            value, magnitude = self._float_filter()
            if _TINY < magnitude < _HUGE and self.field.modulus is None:
                return value  # one product of correctly rounded factors: no cancellation
        precision = _FIRST_PRECISION
        while True:
            with ctx.workprec(precision):
                ball = self.ball()
                if ball.rel_accuracy_bits() > _FLOAT_BITS:
                    return float(ball.mid())
            precision *= 2

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __abs__(self) -> Number:
        return -self if self.sign() < 0 else self

    def __eq__(self, value: object) -> bool:
        other = self._other(value)
        return NotImplemented if other is None else self.terms == other.terms

    def __hash__(self) -> int:
        if self._hash is None:
            rational = self.as_rational()
            if rational is not None:  # equal to a Fraction, so hashed like one
                self._hash = hash(Fraction(int(rational.p), int(rational.q)))
            else:
                self._hash = hash(frozenset((mask, str(c)) for mask, c in self.terms.items()))
        return self._hash

    def _compare(self, value: Any) -> int | None:
        other = self._other(value)
        return None if other is None else (self - other).sign()

    def __lt__(self, value: Any) -> bool:
        order = self._compare(value)
        return NotImplemented if order is None else order < 0

    def __le__(self, value: Any) -> bool:
        order = self._compare(value)
        return NotImplemented if order is None else order <= 0

    def __gt__(self, value: Any) -> bool:
        order = self._compare(value)
        return NotImplemented if order is None else order > 0

    def __ge__(self, value: Any) -> bool:
        order = self._compare(value)
        return NotImplemented if order is None else order >= 0

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
        from nonsmooth.symbolic.printing import number_text

        return number_text(self)

    def __repr__(self) -> str:
        return f"Number({self})"

    def to_sympy(self) -> sympy.Expr:
        """The same number as a SymPy expression (square roots and cosines)."""
        from nonsmooth.symbolic.printing import number_to_sympy

        return number_to_sympy(self)
