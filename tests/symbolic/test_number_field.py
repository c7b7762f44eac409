"""Number fields, and numbers that were rounded: axioms, signs and boxes, against 60-digit arithmetic."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import count, islice
from typing import Any

import mpmath
import pytest
from flint import arb, fmpq, fmpz, fmpz_poly
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from nonsmooth.symbolic.numbers import square_roots
from nonsmooth.symbolic.numbers.coefficients import bits
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField, base_order
from nonsmooth.symbolic.numbers.rational_directions import CLOSENESS
from nonsmooth.symbolic.numbers.rounded import Rounded, either_way
from nonsmooth.symbolic.numbers.square_roots import NestingError
from tests.thorough import few, keep

# ---- Number fields: axioms, signs and roots, against 60-digit arithmetic and identities over the integers.

COUNTS = pytest.mark.parametrize("count", keep(1, [8, 60]))  # of examples
DIGITS = 60
# A nonzero element of degree n <= 16 whose conjugates are below B = 10^3 and whose denominator divides
# D = 12^4 is at least D^-n B^(1-n) > 10^-115 in theory; the samples below never come near this gap.
ZERO_AT_60_DIGITS = mpf("1e-45")


@dataclass(frozen=True)
class Sample:
    """An exact number and the same number by mpmath, which shares no code with the field."""

    exact: Number
    value: Any

    def __add__(self, other: Sample) -> Sample:
        with mp.workdps(DIGITS):
            return Sample(self.exact + other.exact, self.value + other.value)

    def __mul__(self, other: Sample) -> Sample:
        with mp.workdps(DIGITS):
            return Sample(self.exact * other.exact, self.value * other.value)


def rationals() -> list[Sample]:
    field = NumberField()
    return [Sample(field.one, mpf(1)), Sample(field(Fraction(2, 3)), mpf(2) / 3)]


def two_roots() -> list[Sample]:
    field = NumberField()
    return [Sample(field.sqrt(2), mp.sqrt(2)), Sample(field.sqrt(3), mp.sqrt(3))]


def nested_root() -> list[Sample]:
    field = NumberField()
    root = field.sqrt(2)
    return [Sample(root, mp.sqrt(2)), Sample(field.sqrt(2 + root), mp.sqrt(2 + mp.sqrt(2)))]


def pentagon() -> list[Sample]:
    field = NumberField(base_order([Fraction(1, 5)]))
    cosine = Sample(field.cos_pi(Fraction(1, 5)), mp.cos(mp.pi / 5))
    return [cosine, Sample(field.sin_pi(Fraction(1, 5)), mp.sin(mp.pi / 5))]


def heptagon() -> list[Sample]:
    field = NumberField(7)
    return [Sample(field.two_cos(1), 2 * mp.cos(2 * mp.pi / 7)), Sample(field.one, mpf(1))]


def pentagon_with_root() -> list[Sample]:
    field = NumberField(20)
    cosine = field.cos_pi(Fraction(2, 5))
    root = Sample(field.sqrt(3 + cosine), mp.sqrt(3 + mp.cos(2 * mp.pi / 5)))
    return [Sample(cosine, mp.cos(2 * mp.pi / 5)), root]


def _at_60_digits(build: Callable[[], list[Sample]]) -> list[Sample]:
    with mp.workdps(DIGITS):
        return build()


FIELDS = {
    build.__name__: _at_60_digits(build)
    for build in (rationals, two_roots, nested_root, pentagon, heptagon, pentagon_with_root)
}
FRACTIONS = st.fractions(min_value=-9, max_value=9, max_denominator=12)
every_field = pytest.mark.parametrize("name", FIELDS)


def elements(name: str) -> st.SearchStrategy[Sample]:
    """``a + b g + c h + d g h`` over the generators g, h of a field."""
    g, h = FIELDS[name]
    field = g.exact.field

    def element(weights: list[Fraction]) -> Sample:
        total = Sample(field.zero, mpf(0))
        for weight, basis in zip(weights, (Sample(field.one, mpf(1)), g, h, g * h), strict=True):
            with mp.workdps(DIGITS):
                total += Sample(field(weight), mpf(weight.numerator) / weight.denominator) * basis
        return total

    return st.lists(FRACTIONS, min_size=4, max_size=4).map(element)


# ---- axioms ----------------------------------------------------------------------------------


@few(2)
@COUNTS
@every_field
def test_ring_axioms(name: str, count: int) -> None:
    @settings(max_examples=count)
    @given(elements(name), elements(name), elements(name))
    def check(x: Sample, y: Sample, z: Sample) -> None:
        a, b, c = x.exact, y.exact, z.exact
        assert a + b == b + a
        assert a * b == b * a
        assert (a + b) + c == a + (b + c)
        assert (a * b) * c == a * (b * c)
        assert a * (b + c) == a * b + a * c
        assert a - a == 0
        assert not a - a
        assert a - b == -(b - a)
        assert a**3 == a * a * a
        assert a * 3 == fmpq(3) * a == a + a + a
        assert a.field.combination([fmpq(2, 3), fmpq(0), fmpq(-5)], [a, b, c]) == a * fmpq(2, 3) - c * 5
        assert hash((a + b) - b) == hash(a)

    check()


@few(2)
@COUNTS
@every_field
def test_inverse(name: str, count: int) -> None:
    @settings(max_examples=count)
    @given(elements(name), elements(name))
    def check(x: Sample, y: Sample) -> None:
        assume(y.exact)
        a, b = x.exact, y.exact
        assert b * b.inverse() == 1
        assert (a / b) * b == a
        assert b**-2 * b**2 == 1
        assert 1 / b == b.inverse()

    check()


@few(2)
@COUNTS
@every_field
def test_values_signs_and_order_agree_with_60_digits(name: str, count: int) -> None:
    @settings(max_examples=count)
    @given(elements(name), elements(name))
    def check(x: Sample, y: Sample) -> None:
        assert float(x.exact) == pytest.approx(float(x.value), rel=1e-15)
        with mp.workdps(DIGITS):
            difference = x.value - y.value
        zero = abs(difference) < ZERO_AT_60_DIGITS
        assert (x.exact == y.exact) is bool(zero)
        assert (x.exact - y.exact).sign() == (0 if zero else int(mp.sign(difference)))
        assert (x.exact < y.exact) is bool(not zero and difference < 0)
        assert (x.exact >= y.exact) is bool(zero or difference > 0)
        assert abs(x.exact) >= 0

    check()


@few(2)
@COUNTS
@every_field
def test_root_of_a_square_needs_no_new_generator(name: str, count: int) -> None:
    field = FIELDS[name][0].exact.field

    @settings(max_examples=count)
    @given(elements(name))
    def check(x: Sample) -> None:
        before = len(field.radicands)
        assert field.sqrt(x.exact * x.exact) == abs(x.exact)
        assert len(field.radicands) == before

    check()


# ---- zero --------------------------------------------------------------------------------------


def test_zero_is_decided_exactly() -> None:
    field = NumberField(base_order([Fraction(1, 5)]))
    root = field.sqrt
    cosine = field.cos_pi(Fraction(1, 5))
    assert root(2) * root(3) - root(6) == 0
    assert root(5) - (4 * cosine - 1) == 0
    assert root(8) - 2 * root(2) == 0
    assert root(Fraction(2, 9)) * 3 == root(2)
    assert root(2 + root(3)) * root(2) - root(3) - 1 == 0
    assert root(5 + 2 * root(6)) == root(2) + root(3)
    assert root(10 - 2 * root(5)) / 4 == field.sin_pi(Fraction(1, 5))


def test_sum_of_all_roots_of_unity_is_zero() -> None:
    for n in (5, 7, 9, 12, 15):
        turns = [Fraction(2 * k, n) for k in range(n)]
        field = NumberField(base_order(turns))
        assert sum((field.cos_pi(t) for t in turns), field.zero) == 0
        assert sum((field.sin_pi(t) for t in turns), field.zero) == 0
        assert all(field.cos_pi(t) ** 2 + field.sin_pi(t) ** 2 == 1 for t in turns)


@pytest.mark.parametrize("denominator", [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 15, 24, 30])
def test_cosines_and_sines(denominator: int) -> None:
    for numerator in range(-2 * denominator, 2 * denominator + 1):
        turn = Fraction(numerator, denominator)
        field = NumberField(base_order([turn]))
        assert float(field.cos_pi(turn)) == pytest.approx(math.cos(math.pi * turn), abs=1e-14)
        assert float(field.sin_pi(turn)) == pytest.approx(math.sin(math.pi * turn), abs=1e-14)


def test_heptagon_satisfies_its_minimal_polynomial() -> None:
    c = NumberField(7).two_cos(1)
    assert c**3 + c**2 - 2 * c - 1 == 0


# ---- near ties ---------------------------------------------------------------------------------


@pytest.mark.parametrize("power", [1, 5, 20, 50, 160, 200, 400])
def test_root_of_a_square_plus_one(power: int) -> None:
    """``0 < sqrt(n^2 + 1) - n < 1/(2n)``: far below what 60 digits see, beyond floats at 10^160."""
    n = 10**power
    root = NumberField().sqrt(n * n + 1)
    assert (root - n).sign() == 1
    assert (n - root).sign() == -1
    assert root - n < Fraction(1, 2 * n)
    assert root - n > Fraction(1, 2 * n + 1)


def test_pell_convergents_alternate_about_root_two() -> None:
    """``p^2 - 2 q^2 = (-1)^k`` decides the sign over the integers; numbers grow past the float range."""
    root = NumberField().sqrt(2)
    p, q = 1, 1
    for k in range(1, 1000):
        assert p * p - 2 * q * q == (-1) ** k
        if k % 7 == 0 or k < 60:
            assert (p - q * root).sign() == (-1) ** k
        p, q = p + 2 * q, p + q


def test_near_tie_of_three_roots() -> None:
    """``sqrt n + sqrt(n + 2) < 2 sqrt(n + 1)`` by about ``n^(-3/2)/4``."""
    field = NumberField()
    for n in (1, 10**6, 10**15, 10**30):
        gap = 2 * field.sqrt(n + 1) - field.sqrt(n) - field.sqrt(n + 2)
        assert gap.sign() == 1
        assert gap * gap < Fraction(1, 15 * n**3)


def test_numbers_outside_the_float_range() -> None:
    field = NumberField()
    huge, tiny = 10**400, Fraction(1, 10**400)
    root = field.sqrt(2)
    assert float(root * huge) == math.inf
    assert float(field(-huge)) == -math.inf
    assert (root * tiny).sign() == 1
    assert (root * tiny - tiny * Fraction(3, 2)).sign() == -1
    assert field.sqrt(huge + 1) > field.sqrt(huge)
    assert (field.sqrt(huge * huge + 1) - root).sign() == 1


def test_signs_where_floats_lose_their_bits() -> None:
    """``7 - 5 sqrt 2 < 0`` scaled to subnormal floats: 7/2^1075 rounds up, 5/2^1075 rounds down."""
    root = NumberField().sqrt(2)
    for power in range(1000, 1100):
        assert ((7 - 5 * root) * Fraction(1, 2**power)).sign() == -1
        assert ((17 - 12 * root) * Fraction(1, 2**power)).sign() == 1


# ---- square roots --------------------------------------------------------------------------------


def test_rational_roots_share_their_primes() -> None:
    field = NumberField()
    for n in range(1, 200):
        assert field.sqrt(n) ** 2 == n
        assert field.sqrt(Fraction(1, n)) == 1 / field.sqrt(n)
    assert len(field.radicands) == sum(all(n % d for d in range(2, n)) for n in range(2, 200))


def test_generator_is_adjoined_only_once_however_it_is_written() -> None:
    field = NumberField()
    nested = field.sqrt(2 + field.sqrt(2))
    before = len(field.radicands)
    assert field.sqrt(8 + 4 * field.sqrt(2)) == 2 * nested
    assert field.sqrt(2 - field.sqrt(2)) == field.sqrt(2) / nested  # (2 + √2)(2 - √2) = 2
    assert field.sqrt(6 + 4 * field.sqrt(2)) == 2 + field.sqrt(2)
    assert len(field.radicands) == before


def test_odd_content_of_a_square_adjoins_nothing() -> None:
    """``(1 + sqrt 3)^2 = 2 (2 + sqrt 3)`` is a square although neither factor is one in Q(sqrt 3)."""
    field = NumberField()
    field.sqrt(3)
    assert field.sqrt(4 + 2 * field.sqrt(3)) == 1 + field.sqrt(3)
    assert [str(g) for g in field.radicands] == ["3"]


def test_root_of_a_negative_number_is_refused() -> None:
    field = NumberField()
    with pytest.raises(ValueError, match="non-negative"):
        field.sqrt(-1)
    with pytest.raises(ValueError, match="non-negative"):
        field.sqrt(1 - field.sqrt(2))


@pytest.mark.parametrize("order", [5, 7, 8, 9, 15, 20, 36, 60, 72])
def test_modulo_a_prime_the_base_generator_is_a_zero_of_its_polynomial(order: int) -> None:
    """``2 cos(2 pi/N)`` itself, not one of a smaller order: the polynomial of no divisor of N vanishes there."""
    primes = (fmpz(k * order + 1) for k in count((1 << 40) // order))
    for p in islice(filter(fmpz.is_prime, primes), 5):
        zero = square_roots._two_cos(order, p)
        vanishing = [n for n in range(1, order + 1) if order % n == 0 and fmpz_poly.cos_minpoly(n)(zero) % p == 0]
        assert vanishing == [order]


def test_few_primes_show_that_nested_roots_are_new(monkeypatch: pytest.MonkeyPatch) -> None:
    """Modulo ``p = 3 mod 4`` the root that is found of a residue is one itself: its other sign tells more."""
    primes = []

    class Counted(square_roots._ResidueMap):
        def __init__(self, field: NumberField, p: fmpz, inner: list[int]) -> None:
            primes.append(p)
            super().__init__(field, p, inner)

    monkeypatch.setattr(square_roots, "_ResidueMap", Counted)
    root = NumberField().rational(2)
    for _ in range(8):
        root = root.sqrt()
    assert len(primes) < 2_000
    assert (root**256).as_rational() == 2


def test_too_deep_nesting_is_refused() -> None:
    def nest(field: NumberField, depth: int) -> Number:
        return field.sqrt(2 + nest(field, depth - 1)) if depth else field.sqrt(3)

    assert nest(NumberField(), 7).sign() == 1
    with pytest.raises(NestingError, match="at most"):
        nest(NumberField(), 20)


# ---- interface -----------------------------------------------------------------------------------


def test_rationals_compare_and_hash_like_fractions() -> None:
    for field in (NumberField(), NumberField(20)):
        half = field(Fraction(1, 2))
        assert half == Fraction(1, 2)
        assert hash(half) == hash(Fraction(1, 2))
        assert half.as_rational() == fmpq(1, 2)
        assert {half: 1}[field.one / 2] == 1
        assert field.sqrt(2).as_rational() is None
        assert field(3) > 2 > field(1)


def test_division_by_zero_is_refused() -> None:
    field = NumberField(7)
    with pytest.raises(ZeroDivisionError):
        field.one / (field.sqrt(2) - field.sqrt(2))


def test_fields_do_not_mix() -> None:
    with pytest.raises(ValueError, match="two fields"):
        NumberField().one + NumberField().one


def test_angle_outside_the_field_is_refused() -> None:
    with pytest.raises(ValueError, match="order 20"):
        NumberField(20).cos_pi(Fraction(1, 7))


def test_bits() -> None:
    assert bits(0b101001) == [0, 3, 5]


# ---- Rounded numbers: their boxes against mpmath at other members, and which signs count as decided by rounding.

DEGREE = Fraction(1, 180)
SEVEN, ELEVEN = 7 * DEGREE, 11 * DEGREE


@pytest.fixture
def field() -> NumberField:
    return NumberField(1, [SEVEN, 1 - SEVEN, ELEVEN, 53 * DEGREE, 67 * DEGREE])


def cosine(turn: Fraction, away: float = 0.0) -> Any:
    """Of an angle within the closeness of the given one, to forty digits: what the box is a box of."""
    return mp.cos(
        mp.pi * turn.numerator / turn.denominator + away * mpmath.mpf(CLOSENESS.numerator) / CLOSENESS.denominator
    )


def holds(box: arb, value: Any) -> bool:
    """Whether a ball holds a number of forty digits."""
    return bool(box.contains(arb(mp.nstr(value, 38))))


@pytest.mark.parametrize("away", [-1.0, -0.3, 0.0, 0.7, 1.0])
def test_the_box_of_a_formula_holds_its_value_at_every_member(field: NumberField, away: float) -> None:
    formulas: list[Callable[[Any, Any], Any]] = [
        lambda a, b: a + b * 3,
        lambda a, b: (a - b) / (a + b),
        lambda a, b: a**5 - 1 / b,
        lambda a, b: abs(b - a) * a,
        lambda a, b: 2 - a * b,
    ]
    with mp.workdps(40):
        a, b = field.cos_pi(SEVEN), field.cos_pi(ELEVEN)
        true_a, true_b = cosine(SEVEN, away), cosine(ELEVEN, -away)
        for formula in formulas:
            found = formula(a, b)
            assert isinstance(found, Rounded)
            assert holds(found.box, formula(true_a, true_b))
            assert float(found.box.rad()) < 1e-12
        assert holds((a + field.sqrt(2)).sqrt().ball(), mp.sqrt(true_a + mp.sqrt(2)))


def test_what_is_the_same_for_all_members_has_no_width(field: NumberField) -> None:
    c, s = field.cos_pi(SEVEN), field.sin_pi(SEVEN)
    for found in (c * c + s * s, c - c, c / c, c * 0, (c + s) * (c - s) - c * c + s * s, field.cos_pi(1 - SEVEN) + c):
        assert type(found) is Number
    assert not field.rounded_signs


def test_an_equality_of_the_rounded_numbers_alone_counts() -> None:
    """The angle of a triangle of sides 3, 4, 5 to sixteen digits is rounded to that triangle itself: an accident."""
    turn = Fraction("53.13010235415598") / 180
    field = NumberField(1, [turn])
    excess = field.cos_pi(turn) - Fraction(3, 5)
    assert isinstance(excess, Rounded)
    assert excess.sign() == 0
    assert field.rounded_signs == 1
    assert not excess
    assert field.rounded_signs == 2
    assert field.cos_pi(turn) == Fraction(3, 5)
    assert field.rounded_signs == 3


def test_a_true_equality_that_rounding_breaks_counts(field: NumberField) -> None:
    """``cos(7) = cos(53) + cos(67)`` (degrees, by addition); of rational directions the sum misses it."""
    difference = field.cos_pi(SEVEN) - field.cos_pi(53 * DEGREE) - field.cos_pi(67 * DEGREE)
    assert abs(float(difference)) < 1e-14
    assert difference.terms
    assert Lazy.of(difference).sign() == difference.exact.sign() != 0  # type: ignore[attr-defined]
    assert field.rounded_signs == 1


def test_certain_signs_do_not_count(field: NumberField) -> None:
    draw = random.Random(1)
    numbers = [field.cos_pi(turn) for turn in (SEVEN, ELEVEN, 53 * DEGREE, 67 * DEGREE)]
    for _ in range(200):
        weights = [draw.randint(-9, 9) for _ in numbers]
        total = sum((w * x for w, x in zip(weights, numbers, strict=True)), field.zero)
        about = math.fsum(w * float(x) for w, x in zip(weights, numbers, strict=True))
        if abs(about) > 1e-9:
            assert total.sign() == math.copysign(1, about)
            assert (total > 0) is (about > 0)
    assert not field.rounded_signs


def test_orders_of_exact_and_rounded_numbers(field: NumberField) -> None:
    c = field.cos_pi(SEVEN)
    assert field.one > c > 0 < c < 1 <= 2 - c
    assert field.one != c != 1
    assert max(field.one, c) == 1
    assert 1 / c > 1
    assert field.one / c - c > 0
    assert {c: 1}[field.cos_pi(SEVEN)] == 1
    assert not field.rounded_signs


def test_late_quotients_are_carried_out_without_a_decision(field: NumberField) -> None:
    c, d = Lazy.of(field.cos_pi(SEVEN)), Lazy.of(field.cos_pi(ELEVEN))
    a, b = cosine(SEVEN), cosine(ELEVEN)
    found = (c / d + d / c) / (c - 2 * d)
    assert float(found) == pytest.approx(float((a / b + b / a) / (a - 2 * b)))
    assert isinstance(found.exact(), Rounded)
    assert not field.rounded_signs
    assert ((c / d) * (d / c) - 1).sign() == 0
    assert not field.rounded_signs


def test_ways_that_do_not_matter_are_not_counted(field: NumberField) -> None:
    tie = field.cos_pi(SEVEN) - field.cos_pi(53 * DEGREE) - field.cos_pi(67 * DEGREE)
    with either_way(field):
        assert tie.sign()
    assert not field.rounded_signs


def test_division_by_zero_and_roots_of_negative_numbers_are_refused(field: NumberField) -> None:
    c = field.cos_pi(SEVEN)
    with pytest.raises(ZeroDivisionError):
        _ = c / (c - c)
    with pytest.raises(ValueError, match="non-negative"):
        (-c).sqrt()
