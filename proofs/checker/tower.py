"""Exact irrational numbers of a certificate: sums of products of roots, with signs that are shown by enclosures.

The numbers of a subject lie in a tower of fields over the rationals.  Each *generator* is the only root above a bound
of a monic polynomial, whose coefficients are numbers in the generators before it; a *number* is a sum of products of
generators with rational coefficients.  A number without terms is zero; the sign of any other one is shown by an
enclosure that does not hold zero, or the certificate is rejected.  Written as JSON a number is a rational as text,
``"-1/2"``, or a list of ``[rational, generator, generator, ...]`` to be multiplied and added up.

*Why nothing is asked of the polynomials but their one root.*  Sums and products are those of polynomials in the
generators, reduced by the equations that the stated roots fulfil; so whatever is equal here is equal for these roots.
Where a polynomial is reducible, other sums may be zero too: they have terms, and no enclosure shows a sign of them.
Hence ``0 < a``, ``a == b`` and whether ``a`` is zero are what they say of the stated roots, or a certificate is
rejected.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, product
from typing import Any, TypeAlias

from .polynomials import clear_column
from .work import BUDGET, RejectedError, items, limit, longest, rational, require, take, whole

MAX_GENERATORS = 400
MAX_DEGREE = 400
MAX_FACTORS = 64  # of one product of generators
MAX_DIMENSION = 32  # of a field in which there are quotients
PRECISIONS = (96, 384, 1536)  # bits with which a sign is looked for, one after the other
WORD = 30  # bits
STEPS, WORD_PRODUCTS = 4, 256  # steps of the interpreter, and products of two words, that are one unit of work

Monomial: TypeAlias = tuple[int, ...]  # a product of generators, by their numbers in ascending order
Vector: TypeAlias = tuple["Number", ...]
Real: TypeAlias = "Number | Fraction | int"


def charge(steps: int, word_products: int = 0) -> None:
    """Charge work before it is done."""
    BUDGET.spend(1 + steps // STEPS + word_products // WORD_PRODUCTS)


@dataclass(frozen=True)
class Generator:
    """The only root above a bound of a monic polynomial, whose lower coefficients are given, lowest first."""

    lower: Vector
    above: Fraction

    @property
    def degree(self) -> int:
        """Of the polynomial."""
        return len(self.lower)


class Field:
    """The rationals with generators, each a root of a polynomial over the rationals and those before it."""

    def __init__(self, data: Any) -> None:
        self.generators: list[Generator] = []
        self._reduced: dict[Monomial, Number] = {}
        self._roots: dict[tuple[int, int], tuple[int, int]] = {}
        for entry in items(data, most=MAX_GENERATORS):
            self.generators.append(self._generator(entry))

    def _generator(self, entry: Any) -> Generator:
        """The claim: the polynomial is monic, with whole coefficients, and has exactly one root above the bound b >= 0.

        All coefficients of ``p(b + x)`` but the constant one are at least zero, and that is negative: so p increases
        for x > 0 from a negative value.
        """
        polynomial, above = take(entry, "polynomial above")
        listed = items(polynomial, most=MAX_DEGREE)
        require(len(listed) > 2, "field: polynomials of degree two at least")
        coefficients, bound = self.vector(listed, len(listed)), self.parse(above)
        shifted = list(coefficients)
        for i in range(len(shifted)):
            for j in reversed(range(i, len(shifted) - 1)):
                shifted[j] = shifted[j] + shifted[j + 1] * bound
        first, *others = signs([*shifted, bound])
        monic = listed[-1] == "1" and all(c.bottom == 1 for c in coefficients)
        require(monic and first < 0 <= min(others), "field: polynomials with one root")
        return Generator(coefficients[:-1], rational(above))

    def rational(self, value: Fraction | int) -> Number:
        """A rational number."""
        return Number(self, {(): value.numerator}, value.denominator)

    def parse(self, data: Any) -> Number:
        """A number: a rational as text, or a list of ``[rational, generator, generator, ...]`` to be multiplied."""
        entries = [[data]] if type(data) is str else items(data)
        require(entries, "a number, not an empty list")
        terms: dict[Monomial, Fraction] = {}
        for entry in entries:
            require(entry, "a product, not an empty list")
            text, *factors = items(entry)
            monomial, coefficient = self._monomial(factors), rational(text)
            before = terms.get(monomial, Fraction(0))
            charge(1, (before.denominator.bit_length() // WORD) ** 2)
            terms[monomial] = before + coefficient
        words = sum(c.denominator.bit_length() // WORD for c in terms.values())  # as many as the common one may have
        charge(len(terms), (len(terms) + words) * words)
        bottom = math.lcm(*(c.denominator for c in terms.values()))
        return Number(self, {m: c.numerator * (bottom // c.denominator) for m, c in terms.items()}, bottom)

    def _monomial(self, factors: Sequence[Any]) -> Monomial:
        """A product of generators, each to a power below its degree."""
        numbers = [whole(k, len(self.generators) - 1) for k in items(factors, most=MAX_FACTORS)]
        require(all(numbers.count(k) < self.generators[k].degree for k in numbers), "powers below the degree")
        return tuple(sorted(numbers))

    def coefficient(self, data: Any) -> Fraction | Number:
        """A number as a coefficient of polynomials: a fraction where it is written as one."""
        return rational(data) if type(data) is str else self.parse(data)

    def generator(self, k: int) -> Number:
        """The k-th generator itself."""
        return Number(self, {(k,): 1})

    def vector(self, data: Any, count: int) -> Vector:
        """A list of so many numbers."""
        return tuple(self.parse(entry) for entry in items(data, count))

    def basis(self) -> list[Monomial]:
        """All products of generators with powers below their degrees."""
        limit(math.prod(g.degree for g in self.generators) <= MAX_DIMENSION, "quotients in small fields")
        monomials: list[Monomial] = [()]
        for k, generator in enumerate(self.generators):
            monomials = [(*before, *[k] * power) for before in monomials for power in range(generator.degree)]
        return monomials

    def reduced(self, monomial: Monomial) -> Number:
        """A product of generators, by products with powers below their degrees."""
        if monomial not in self._reduced:
            charge(len(monomial) ** 2 + 1)
            self._reduced[monomial] = self._reduce(monomial)
        return self._reduced[monomial]

    def _reduce(self, monomial: Monomial) -> Number:
        for k in sorted(set(monomial)):
            generator, power = self.generators[k], monomial.count(k)
            if power >= generator.degree:  # x^degree = -(lower terms)
                others = [factor for factor in monomial if factor != k]
                total = self.rational(0)
                for j, coefficient in enumerate(generator.lower):
                    rest = tuple(sorted(others + [k] * (power - generator.degree + j)))
                    total = total - self.reduced(rest) * coefficient
                return total
        return Number(self, {monomial: 1})

    def root(self, k: int, bits: int) -> tuple[int, int]:
        """Enclosure of a generator, which is positive, in units of 2^-bits, by bisection."""
        if (k, bits) not in self._roots:
            self._roots[k, bits] = self._bisect(self.generators[k], bits)
        return self._roots[k, bits]

    def _bisect(self, generator: Generator, bits: int) -> tuple[int, int]:
        low, step = math.floor(generator.above * 2**bits), 1 << bits
        # whole coefficients, as numbers of Python where they are rational
        lower = [c if c.terms.keys() - {()} else c.terms.get((), 0) for c in generator.lower]
        while is_below_root(lower, low + step, bits):
            step *= 2
        while step:
            if is_below_root(lower, low + step, bits):
                low += step
            step //= 2
        return low, low + 1


def is_below_root(lower: Sequence[Number | int], place: int, bits: int) -> bool:
    """Whether the polynomial is at most zero at ``place 2^-bits``; by Horner's scheme, scaled to whole numbers."""
    value: Number | int = 1
    for j, coefficient in enumerate(reversed(lower), 1):
        charge(64, ((longest((value, coefficient)) + place.bit_length() + bits * j) // WORD) ** 2)
        value = value * place + coefficient * (1 << bits * j)
    return value <= 0


class Number:
    """An exact number: whole multiples of products of generators, over one positive denominator."""

    def __init__(self, field: Field, terms: dict[Monomial, int], bottom: int = 1) -> None:
        words = (bottom.bit_length() + sum(map(int.bit_length, terms.values()))) // WORD
        # what making any number takes, and the greatest common divisor of its parts: many words at a time
        charge(8 + 2 * len(terms), words * words // (len(terms) + 1))
        self.field, self.bottom = field, bottom
        self.terms = {monomial: c for monomial, c in terms.items() if c}
        shared = 1 if bottom == 1 else math.gcd(bottom, *terms.values())
        if shared > 1:
            self.bottom = bottom // shared
            self.terms = {monomial: c // shared for monomial, c in self.terms.items()}
        self.words = 1 + words
        self._sign: int | None = None

    @property
    def bits(self) -> int:
        """About how long it is."""
        return self.words * WORD

    def _operand(self, value: Real) -> Number:
        return value if isinstance(value, Number) else self.field.rational(value)

    def __add__(self, value: Real) -> Number:
        return self._plus(value, 1)

    def _plus(self, value: Real, sign: int) -> Number:
        """The sum, or with the sign -1 the difference."""
        other = self._operand(value)
        charge(len(self.terms) + len(other.terms), self.words + other.words)
        if not other.terms:
            return self
        terms: dict[Monomial, int] = {}
        for number, factor in ((self, other.bottom), (other, sign * self.bottom)):
            for monomial, c in number.terms.items():
                terms[monomial] = terms.get(monomial, 0) + c * factor
        return Number(self.field, terms, self.bottom * other.bottom)

    def __neg__(self) -> Number:
        return Number(self.field, {monomial: -c for monomial, c in self.terms.items()}, self.bottom)

    def __sub__(self, value: Real) -> Number:
        return self._plus(value, -1)

    def __rsub__(self, other: Real) -> Number:
        return -self + other

    def __mul__(self, value: Real) -> Number:
        other = self._operand(value)
        charge(len(self.terms) * len(other.terms), self.words * other.words)
        for number, factor in ((self, other), (other, self)):
            if factor.terms.keys() <= {()}:
                scale = factor.terms.get((), 0)
                scaled = {monomial: c * scale for monomial, c in number.terms.items()}
                return Number(self.field, scaled, self.bottom * other.bottom)
        terms: dict[Monomial, int] = {}
        for (left, a), (right, b) in product(self.terms.items(), other.terms.items()):
            reduced = self.field.reduced(tuple(sorted(left + right)))
            words = (a.bit_length() + b.bit_length()) // WORD
            charge(len(left + right) + len(reduced.terms), words * reduced.words)
            for monomial, c in reduced.terms.items():
                terms[monomial] = terms.get(monomial, 0) + a * b * c
        return Number(self.field, terms, self.bottom * other.bottom)

    __radd__, __rmul__ = __add__, __mul__

    def inverse(self) -> Number:
        """The number u with ``u a = 1``, by linear equations for its coefficients.

        Raises:
            RejectedError: where there is none, as for zero, and in large fields.
        """
        basis = self.field.basis()
        size = len(basis)
        charge(size**3, size**5 * self.words**2)  # entries of the elimination grow with the size
        images = [self * Number(self.field, {monomial: 1}) for monomial in basis]
        rows = [[*(Fraction(image.terms.get(monomial, 0), image.bottom) for image in images)] for monomial in basis]
        rows = [[*row, Fraction(monomial == ())] for row, monomial in zip(rows, basis, strict=True)]
        for k in range(size):
            pivot = next((i for i in range(k, size) if rows[i][k]), k)
            require(rows[pivot][k], "divisors that are not zero")
            clear_column(rows, k, pivot, k)
        bottom = math.lcm(*(row[-1].denominator for row in rows))
        return Number(self.field, {m: int(row[-1] * bottom) for m, row in zip(basis, rows, strict=True)}, bottom)

    def __truediv__(self, value: Real) -> Number:
        return self * (value.inverse() if isinstance(value, Number) else 1 / Fraction(value))

    def __rtruediv__(self, value: Real) -> Number:
        return self.inverse() * value

    def __float__(self) -> float:
        return float(self.rounded)

    @property
    def rounded(self) -> Fraction:
        """A rational number near it, of its sign where that is shown."""
        for bits in PRECISIONS:
            low, high = self._interval(bits)
            if low > 0 or high < 0:
                break
        return Fraction(low + high, self.bottom << bits + 1)

    def __pow__(self, exponent: int) -> Number:
        return math.prod([self] * exponent, start=self.field.rational(1))

    def __abs__(self) -> Number:
        return -self if self.sign() < 0 else self

    def __bool__(self) -> bool:
        return self.sign() != 0

    def __eq__(self, other: object) -> bool:
        return not self - other if isinstance(other, Number | Fraction | int) else NotImplemented

    def __hash__(self) -> int:
        if self.terms.keys() <= {()}:
            return hash(Fraction(self.terms.get((), 0), self.bottom))
        return hash((frozenset(self.terms.items()), self.bottom))

    def __lt__(self, other: Real) -> bool:
        return (self - other).sign() < 0

    def __le__(self, other: Real) -> bool:
        return (self - other).sign() <= 0

    def __gt__(self, other: Real) -> bool:
        return (self - other).sign() > 0

    def __ge__(self, other: Real) -> bool:
        return (self - other).sign() >= 0

    def sign(self) -> int:
        """Certified sign -1, 0 or 1: zero if no terms are left, else shown by an interval, else rejected."""
        if self._sign is None:
            self._sign = self._certified_sign()
        return self._sign

    def _certified_sign(self) -> int:
        if not self.terms:
            return 0
        if self.terms.keys() == {()}:
            return 1 if self.terms[()] > 0 else -1
        for bits in PRECISIONS:
            low, high = self._interval(bits)
            if low > 0 or high < 0:
                return 1 if low > 0 else -1
        raise RejectedError(f"a sign that {PRECISIONS[-1]} bits show")

    def enclosure(self, bits: int) -> tuple[int, int]:
        """Bounds in units of 2^-bits."""
        low, high = self._interval(bits)
        return low // self.bottom, -(-high // self.bottom)

    def _interval(self, bits: int) -> tuple[int, int]:
        """Bounds of the numerator in units of 2^-bits."""
        low = high = 0
        for monomial, c in self.terms.items():
            charge(len(monomial) + 1, (len(monomial) + 1) * (bits // WORD) ** 2 + (bits // WORD) * self.words)
            lower = upper = 1 << bits
            for k in monomial:
                a, b = self.field.root(k, bits)
                lower, upper = lower * a >> bits, (upper * b >> bits) + 1
            low += min(c * lower, c * upper)
            high += max(c * lower, c * upper)
        return low, high


# ---- signs, sums and products --------------------------------------------------------------------


def signs(numbers: Iterable[Number]) -> list[int]:
    """Certified signs."""
    return [number.sign() for number in numbers]


def is_zero(vector: Iterable[Number]) -> bool:
    """Whether all entries are zero."""
    return not any(signs(vector))


def total(numbers: Sequence[Number]) -> Number:
    """The sum of at least one number."""
    first, *others = numbers
    return sum(others, start=first)


def dot(a: Sequence[Number], b: Sequence[Number]) -> Number:
    """The sum of products, up to the shorter's length."""
    return total([x * y for x, y in zip(a, b, strict=False)])


def cross(a: Sequence[Number], b: Sequence[Number]) -> Number:
    """The planar cross product."""
    return a[0] * b[1] - a[1] * b[0]


def normal_to(a: Vector, b: Vector) -> Vector:
    """The cross product in space: at right angles to both."""
    return cross(a[1:], b[1:]), a[2] * b[0] - a[0] * b[2], cross(a, b)


def negative(a: Vector) -> Vector:
    """The opposite vector."""
    return tuple(-x for x in a)


def has_rank_three(vectors: Sequence[Vector]) -> bool:
    """Whether vectors in space (their first three entries) span it."""
    spans = (normal_to(a, b) for a, b in combinations(vectors, 2))
    normal = next((n for n in spans if not is_zero(n)), None)
    return normal is not None and any(dot(normal, row[:3]).sign() for row in vectors)
