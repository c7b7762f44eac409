"""How numbers are written, in one place; every other module chooses from here.

| what | for | how |
| --- | --- | --- |
| :func:`real_text` | JSON, whatever must lose nothing | exact, or an enclosure where that is endless |
| :func:`brief_text` | sentences, tables of a report | exact up to SHORT characters, else ``~`` and ten digits |
| :func:`short_text` | lines and columns of the terminal | exact up to TERSE characters, else ``~`` and six digits |
| :func:`plain_decimal` | both in scenes with units | a decimal, exact up to PLAIN characters, else six digits |
| :func:`decimal_text` | an exact number as a decimal, whatever its size | significant digits, rounded to nearest |
| :func:`lower_text`, :func:`upper_text` | a bound that must stay true | significant digits, never above, never below |
| :func:`float_text`, :func:`place_text` | what is sampled, drawn or integrated | six significant digits unless told |
| :func:`measured_text` | errors, times and settings of measurements | two digits, counts as they are |
| :func:`power_text` | a power of ten | ``1e-9`` |
| :func:`percent_text` | a share | four significant digits |

Formulas are written by :mod:`nonsmooth.symbolic.formulas.surfaces`, numbers of a report by
:mod:`nonsmooth.reports.output.document`; both take their decimals from here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import pairwise
from typing import Any, SupportsFloat, TypeAlias

from flint import arb, ctx

from nonsmooth.symbolic.numbers.coefficients import as_fraction, rational_ball
from nonsmooth.symbolic.numbers.enclosures import EXACT_ROOTS, MOST_BITS, PRECISION
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.rounded import Rounded

DIGITS = 10  # significant digits of a rounded exact number
FLOAT_DIGITS = 6  # of a sampled one
SHORT = 44  # characters of exact text that fit a sentence or a table
TERSE = 24  # characters of exact text that fit a line of the terminal
PLAIN = 12  # characters of an exact decimal of a scene with units
BALL_DIGITS = 20  # digits of an enclosure

Real: TypeAlias = Number | Lazy | arb


# ---- exact numbers -------------------------------------------------------------------------------


def settled(value: Real) -> Number | arb:
    """The field element where it is at hand or short work, a ball otherwise."""
    if isinstance(value, Lazy):
        return value.exact() if len(value.field.radicands) <= EXACT_ROOTS else value.ball
    return value


def real_text(value: Real) -> str:
    """Exact text, or an enclosure such as ``[0.123 +/- 4e-21]`` where the exact form is endless or out of reach."""
    fixed = settled(value)
    if isinstance(fixed, Number) and fixed.size_bits > MOST_BITS:
        fixed = fixed.accurate_ball(PRECISION)
    return str(fixed.str(BALL_DIGITS)) if isinstance(fixed, arb) else str(fixed)


def brief_text(value: Real) -> str:
    """Exact text where it fits a sentence, otherwise a decimal value such as ``~1.61803399``."""
    if not isinstance(value, arb) and value.field.writes_decimals:
        return plain_decimal(value)
    text = real_text(value)
    return text if len(text) <= SHORT else f"~{decimal_text(value)}"


def short_text(value: Any) -> str:
    """A number exactly where that fits a line of the terminal, else to six digits; a text as it is."""
    if not isinstance(value, Number | Lazy | arb):
        return str(value)
    if not isinstance(value, arb) and value.field.writes_decimals:
        return plain_decimal(value)
    text = real_text(value)
    return text if len(text) <= TERSE else f"~{decimal_text(value, FLOAT_DIGITS)}"


def plain_decimal(value: Number | Lazy) -> str:
    """A decimal: exact where it ends within PLAIN characters, as one that a user entered, else to six digits."""
    fixed = settled(value)
    if isinstance(fixed, Rounded):
        fixed = fixed.exact  # to be written is no decision, which would be counted
    rational = fixed.as_rational() if isinstance(fixed, Number) else None
    if rational is not None:
        with localcontext(prec=PLAIN):
            decimal = Decimal(int(rational.p)) / Decimal(int(rational.q))
        text = f"{decimal:f}".rstrip("0").rstrip(".") if "." in f"{decimal:f}" else f"{decimal:f}"
        if Fraction(text) == as_fraction(rational) and len(text) <= PLAIN:
            return text
    return decimal_text(value, FLOAT_DIGITS)


def decimal_text(value: Real, digits: int = DIGITS) -> str:
    """Decimal value with the given significant digits, also beyond the range of floats."""
    approximation = float(value)
    if approximation and math.isfinite(approximation):
        return float_text(approximation, digits)
    with ctx.workprec(PRECISION):
        ball = value if isinstance(value, arb) else value.ball if isinstance(value, Lazy) else value.ball()
        return str(ball.str(digits, radius=False))


def lower_text(value: Number | Lazy | Fraction, digits: int = DIGITS) -> str:
    """Decimal value of a positive number with the given significant digits, not above it."""
    text = _nearest(value, digits)
    return text if sign(value - Fraction(text)) >= 0 else _neighbour(text, digits, -1)


def upper_text(value: Number | Lazy | Fraction, digits: int = DIGITS) -> str:
    """Decimal value of a positive number with the given significant digits, not below it."""
    text = _nearest(value, digits)
    return text if sign(value - Fraction(text)) <= 0 else _neighbour(text, digits, 1)


def _nearest(value: Number | Lazy | Fraction, digits: int) -> str:
    real = rational_ball(value) if isinstance(value, Fraction) else value
    return decimal_text(real, digits)


def _neighbour(text: str, digits: int, step: int) -> str:
    """The decimal one unit of the last digit away."""
    decimal = Decimal(text)
    return f"{decimal + step * Decimal((0, (1,), decimal.adjusted() - digits + 1)):.{digits}g}"


# ---- floats --------------------------------------------------------------------------------------


def float_text(value: SupportsFloat, digits: int = FLOAT_DIGITS) -> str:
    """The float nearest to a number, with the given significant digits."""
    return f"{float(value):.{digits}g}"


def place_text(values: Iterable[SupportsFloat], digits: int = FLOAT_DIGITS) -> str:
    """Floats of a point, a direction or a state: ``(0.2, 0.4, 0)``."""
    return f"({', '.join(float_text(value, digits) for value in values)})"


def exact_place(values: Iterable[Any]) -> str:
    """The same of exact numbers, short ones as they are: ``(0, 1/4)``."""
    return f"({', '.join(map(short_text, values))})"


def measured_text(value: float | None) -> str:
    """Two digits; counts and zero as they are; a dash for none."""
    if value is None:
        return "-"
    if math.isfinite(value) and value == int(value) and abs(value) < 1e7:
        return str(int(value))
    return f"{value:.1e}"


def power_text(value: float) -> str:
    """A power of ten as people write it: ``1e-9``."""
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def percent_text(share: float) -> str:
    """``12.5 %``."""
    return f"{float_text(100 * share, 4)} %"


# ---- LaTeX ---------------------------------------------------------------------------------------


def decimal_latex(decimal: str) -> str:
    r"""``1.5e-07`` as ``1.5 \cdot 10^{-7}``."""
    mantissa, _, exponent = decimal.partition("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else mantissa


def numbers_text(numbers: tuple[int, ...]) -> str:
    """``1-3, 7, 9-12``: numbers in ascending order, runs of three and more shortened; named wheels one by one."""
    if any(str(number) != f"{number:d}" for number in numbers):
        return ", ".join(map(str, numbers))
    breaks = [k for k, (a, b) in enumerate(pairwise(numbers), 1) if b != a + 1]
    runs = [numbers[start:end] for start, end in pairwise([0, *breaks, len(numbers)])]
    return ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs if run)
