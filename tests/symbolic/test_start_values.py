"""Starts of solutions: formulas against mpmath, rounded once to the nearest float."""

from __future__ import annotations

import math
import re

import pytest
from mpmath import mp

from nonsmooth.symbolic.files.start_values import read_start_angle, read_start_value

DIGITS = 80


@pytest.mark.parametrize("text", ["0.1", "-1e-3", "0", " 2.50 ", "1_000.25", ".5", "-7", "4503599627370497.5", "1e300"])
def test_decimals_are_the_floats_that_python_reads(text: str) -> None:
    assert read_start_value(text) == read_start_angle(text) == float(text)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1/3", lambda: mp.mpf(1) / 3),
        ("sqrt(2)/4", lambda: mp.sqrt(2) / 4),
        ("1 - sqrt(3)/2 + 10**-20", lambda: 1 - mp.sqrt(3) / 2 + mp.mpf(10) ** -20),
        ("cos(pi/5)", lambda: mp.cos(mp.pi / 5)),
    ],
)
def test_formulas_are_rounded_once(text: str, value: object) -> None:
    with mp.workdps(DIGITS):
        assert callable(value)
        expected = float(value())
    assert read_start_value(text) == read_start_angle(text) == expected


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pi/6", lambda: mp.pi / 6),
        ("-2*pi/3", lambda: -2 * mp.pi / 3),
        ("pi", lambda: mp.pi),
        ("pi/4 + 0.1", lambda: mp.pi / 4 + mp.mpf(1) / 10),
        ("pi - 3.14159265358979323846264338327950288", lambda: mp.pi - mp.mpf("3.14159265358979323846264338327950288")),
        ("1e30*pi - pi", lambda: (mp.mpf(10) ** 30 - 1) * mp.pi),
    ],
)
def test_angles_with_pi_are_rounded_once(text: str, value: object) -> None:
    with mp.workdps(DIGITS):
        assert callable(value)
        expected = float(value())
    assert read_start_angle(text) == expected


def test_a_float_near_a_multiple_of_pi_stays_that_float() -> None:
    assert read_start_angle(repr(math.pi / 6 + 1e-13)) == math.pi / 6 + 1e-13


NUMBERS = "numbers such as 1/3 or sqrt(3)/2"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("pi/6", f"{NUMBERS}, with pi only inside sin and cos or in an angle, received 'pi/6'"),
        ("", "a number or a formula such as \"sqrt(2)/2\", received ''"),
        ("x", "a formula of numbers"),
        ("1/0", "a finite number"),
        ("nan", "a finite number, received 'nan'"),
        ("__import__('os').getcwd()", "a formula of numbers"),
    ],
)
def test_what_is_no_start(text: str, words: str) -> None:
    with pytest.raises(ValueError, match=f"^required {re.escape(words)}"):
        read_start_value(text)
