"""``[tolerance]`` of a scene file: how far the array that is built may be from the scene."""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.symbolic.files.scene_values import Angle, AngleField, Exact, ExactField, Numbers, TomlTable
from nonsmooth.symbolic.number_text import short_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.tolerances import Tolerance

QUARTER = Fraction(1, 2)  # of pi: a rim that may turn farther has no direction


class ToleranceTable(TomlTable):
    """``[tolerance]``: lengths in the scene's unit, ``heading`` an angle, the others shares of the scene's values."""

    position: ExactField = Fraction(0)
    heading: AngleField = Angle(Fraction(0))
    speed: ExactField = Fraction(0)
    mu_roll: ExactField = Fraction(0)
    mu_side: ExactField = Fraction(0)
    centre_of_mass: ExactField = Fraction(0)


def build_tolerance(table: ToleranceTable, numbers: Numbers) -> Tolerance:
    """The box of a scene.

    Raises:
        SceneError: for negative entries, shares of one and more, a quarter turn and more, and a box of one point.
    """
    turn = table.heading.turn
    if not 0 <= turn < QUARTER:
        received = StatedFact(f"{float(turn * 180):g} deg")
        raise SceneError(numbers.file, "tolerance.heading", "an angle of at least 0, below a quarter turn", received)
    found = Tolerance(
        position=_size(table.position, "position", numbers),
        heading=turn,
        speed=_share(table.speed, "speed", numbers),
        mu_roll=_share(table.mu_roll, "mu_roll", numbers),
        mu_side=_share(table.mu_side, "mu_side", numbers),
        centre_of_mass=_size(table.centre_of_mass, "centre_of_mass", numbers),
    )
    if not found.names:
        raise SceneError(numbers.file, "tolerance", "an entry that is not zero", StatedFact("none"))
    return found


def _size(value: Exact, name: str, numbers: Numbers) -> Number:
    number = numbers(value, f"tolerance.{name}")
    if number.sign() < 0:
        received = StatedFact(short_text(number))
        raise SceneError(numbers.file, f"tolerance.{name}", "a number of at least 0", received)
    return number


def _share(value: Exact, name: str, numbers: Numbers) -> Number:
    number = _size(value, name, numbers)
    if (number - 1).sign() >= 0:
        received = StatedFact(short_text(number))
        raise SceneError(numbers.file, f"tolerance.{name}", "a share of at least 0 and below 1", received)
    return number
