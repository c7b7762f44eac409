"""Rounded numbers: their boxes against mpmath at other members, and which signs count as decided by rounding."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import pytest
from flint import arb
from mpmath import mp

from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.rational_directions import CLOSENESS
from nonsmooth.symbolic.numbers.rounded import Rounded, either_way

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
