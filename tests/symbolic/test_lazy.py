from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.thorough import examples

FIELD = NumberField()
ROOTS = [FIELD.sqrt(n) for n in (2, 3, 5, 7)]
small = st.integers(-5, 5)


@st.composite
def numbers(draw: st.DrawFn) -> Number:
    total = FIELD.rational(draw(small))
    for root in ROOTS:
        total = total + root * Fraction(draw(small), draw(st.integers(1, 4)))
    return total


@examples(150)
@given(numbers(), numbers(), numbers())
def test_lazy_arithmetic_equals_exact_arithmetic(a: Number, b: Number, c: Number) -> None:
    x, y, z = Lazy.of(a), Lazy.of(b), Lazy.of(c)
    pairs = [(x + y * z, a + b * c), (x - y, a - b), (-x * 3 + 1, -a * 3 + 1), (2 - x, 2 - a)]
    if b:
        pairs.append((x / y + z, a / b + c))
        pairs.append((1 / y, 1 / b))
    for lazy, exact in pairs:
        assert lazy.sign() == exact.sign()
        assert lazy.exact() == exact
        assert float(lazy) == pytest.approx(float(exact), rel=1e-14, abs=1e-300)
        assert lazy == exact


def test_a_true_tie_is_decided_and_a_near_tie_is_no_tie() -> None:
    a, b, c, d = (Lazy.of(root) for root in ROOTS)
    total = (a + b) / (c + d)
    assert (total * (c + d) - a - b).sign() == 0
    tiny = FIELD.rational(Fraction(1, 10**300))
    assert (total * (c + d) - a - b + tiny).sign() == 1
    assert float(total * (c + d) - a - b + tiny) == pytest.approx(1e-300)
    assert ((total - total) == 0) is True


def test_balls_keep_their_precision() -> None:
    """Rounding to the machine's 53 bits anywhere would show here."""
    value = Lazy.of(ROOTS[0])
    for _ in range(20):
        value = -(value * Lazy.of(ROOTS[1])) / ROOTS[1] + 0
    assert value.ball.rel_accuracy_bits() > 200


def test_division_by_zero_is_refused() -> None:
    zero = Lazy.of(ROOTS[0]) - ROOTS[0]
    with pytest.raises(ZeroDivisionError):
        Lazy.of(ROOTS[1]) / zero
