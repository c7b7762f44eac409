"""What is said of bodies with mass: up to which mass, or which speeds, the verdict on (x, y) holds."""

from __future__ import annotations

import math
from fractions import Fraction

from nonsmooth.proofs.clauses.at_point.mass import MassLimit
from nonsmooth.proofs.findings.facts import Fact, Quantity
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.number_text import float_text

GRAVITY = Fraction(981, 100)  # m/s^2


def mass_fact(limit: MassLimit | None, units: Units) -> Fact:
    """The masses per weight, 1/g, between which stability under full dynamics is lost; in words where it is lost."""
    if limit is None:
        return Fact("mass")
    record = {
        "stable_to": Quantity(limit.stable_to),
        "unstable_at": None if limit.unstable_at is None else Quantity(limit.unstable_at),
        "squared_radius": Quantity(limit.squared_radius),
        "speed_factor": speed_factor(limit, units),
    }
    if limit.unstable_at is None:
        words = "with mass too, linearized: whatever the mass, up to 1/g = {}"
        return Fact("mass", record, words, (float_text(limit.stable_to),))
    words = "with mass, linearized: stable up to 1/g = {}, unstable at {} (inertia of a disc as large as the array)"
    return Fact("mass", record, words, (float_text(limit.stable_to), float_text(limit.unstable_at)))


def speed_factor(limit: MassLimit, units: Units) -> float | None:
    """By how much all speeds may grow, at the earth's gravity, until the mass counts; None without a unit of length.

    With speeds s times as large the mass counts ``s^2``-fold.
    """
    metres = units.metres
    return None if metres is None else math.sqrt(limit.stable_to * GRAVITY / metres)


def mass_words(limit: MassLimit | None, units: Units) -> str:
    """For an answer: empty where the mass does not matter or nothing is known."""
    if limit is None or limit.unstable_at is None:
        return ""
    factor = speed_factor(limit, units)
    if factor is None:
        return f"so does a body with mass up to 1/g = {float_text(limit.stable_to)}, and not one a little heavier"
    if factor < 1:
        return f"but with mass and g = 9.81 m/s^2 only at speeds below {factor:.3g} of these"
    return f"with mass and g = 9.81 m/s^2 too, up to {factor:.3g} times these speeds"
