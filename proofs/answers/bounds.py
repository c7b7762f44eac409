"""Numbers of an answer as a reader of a data sheet wants them: four digits, rounded to the safe side."""

from __future__ import annotations

from fractions import Fraction
from typing import TypeAlias

from flint import arb

from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import lower_text, upper_text

DIGITS = 4
LN_2 = Fraction(693_147_180_560, 10**12)  # just above the natural logarithm of 2

Positive: TypeAlias = Number | Lazy | Fraction | arb


def at_least(value: Positive) -> str:
    """A decimal that is not above the number."""
    return lower_text(_comparable(value), DIGITS)


def at_most(value: Positive) -> str:
    """A decimal that is not below the number."""
    if isinstance(value, arb):
        return upper_text(-rational_below(-value), DIGITS)
    return upper_text(value, DIGITS)


def half_life(rate: Positive) -> str:
    """``ln 2/rate``: the time in which ``exp(-rate t)`` halves, rounded up."""
    return at_most(LN_2 / _comparable(rate))


def _comparable(value: Positive) -> Number | Lazy | Fraction:
    return rational_below(value) if isinstance(value, arb) else value


# ---- units ---------------------------------------------------------------------------------------

HALF_TURN = 180, Fraction(355, 113), Fraction(3_141_592_653, 10**9)  # degrees; just above pi, just below


def angle_at_least(value: Positive, units: Units) -> str:
    """An angle (radian) or a rate of one in the unit of the scene, not above it: ``5.13 deg``."""
    degrees, above, _ = HALF_TURN
    shown = _comparable(value) * (degrees / above) if units.in_degrees else value
    return f"{at_least(shown)} {units.angle}"


def angle_at_most(value: Positive, units: Units) -> str:
    """An angle (radian) or a rate of one in the unit of the scene, not below it."""
    degrees, _, below = HALF_TURN
    shown: Positive = value
    if units.in_degrees:
        shown = (-rational_below(-value) if isinstance(value, arb) else value) * (degrees / below)
    return f"{at_most(shown)} {units.angle}"


def of_length(scene: Scene) -> str:
    """A space and the unit of length; empty where the scene names none."""
    unit = scene.units.length
    return f" {unit}" if unit else ""
