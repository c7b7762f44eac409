"""Units of a scene: labels beside its numbers.

All lengths of a scene are in one unit and its times in seconds, so its speeds are in that unit per second; nothing
that is computed depends on the unit.  Speeds that a file states in another unit of length are converted when it is
read, exactly (1 in = 127/5000 m).
"""

from __future__ import annotations

from enum import StrEnum
from fractions import Fraction
from typing import NamedTuple


class LengthUnit(StrEnum):
    """Unit of length."""

    METRE = "m"
    CENTIMETRE = "cm"
    MILLIMETRE = "mm"
    INCH = "in"

    @property
    def metres(self) -> Fraction:
        """Its length."""
        return _METRES[self]


class SpeedUnit(StrEnum):
    """Unit of speed: a unit of length per second."""

    METRE = "m/s"
    CENTIMETRE = "cm/s"
    MILLIMETRE = "mm/s"
    INCH = "in/s"

    @property
    def length(self) -> LengthUnit:
        """The way of one second."""
        return LengthUnit[self.name]


class AngleUnit(StrEnum):
    """Unit of a number that is an angle."""

    DEGREE = "deg"
    RADIAN = "rad"


_METRES = {
    LengthUnit.METRE: Fraction(1),
    LengthUnit.CENTIMETRE: Fraction(1, 100),
    LengthUnit.MILLIMETRE: Fraction(1, 1000),
    LengthUnit.INCH: Fraction(127, 5000),
}


class Units(NamedTuple):
    """Labels for the numbers of a scene, each empty where the scene states no unit of length.

    Attributes:
        length: of positions, distances and the half-width of the square.
        in_degrees: whether people read its angles in degrees; JSON and tables of data hold radians.
    """

    length: str = ""
    in_degrees: bool = False

    @property
    def angle(self) -> str:
        """Of angles and turns."""
        return "deg" if self.in_degrees else "rad"

    @property
    def metres(self) -> Fraction | None:
        """The unit of length in metres; None where there is none."""
        return LengthUnit(self.length).metres if self.length else None

    @property
    def speed(self) -> str:
        """Of surface speeds and of velocities of the body."""
        return f"{self.length}/s" if self.length else ""

    @property
    def time(self) -> str:
        """Of times."""
        return "s" if self.length else ""

    @property
    def after_length(self) -> str:
        """What stands behind a length in a sentence: a space and the unit, or nothing."""
        return f" {self.length}" if self.length else ""

    @property
    def after_speed(self) -> str:
        """The same behind a speed."""
        return f" {self.speed}" if self.length else ""

    @property
    def after_time(self) -> str:
        """The same behind a time."""
        return f" {self.time}" if self.length else ""

    @property
    def per_time(self) -> str:
        """What stands behind the unit of what is a rate."""
        return f"/{self.time}" if self.length else " per unit of time"
