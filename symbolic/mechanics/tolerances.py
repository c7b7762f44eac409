"""How far the array that is built may be from the scene: a box of parameters.

Every number says by how much a value may differ, up or down, for each wheel on its own.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from fractions import Fraction

from nonsmooth.symbolic.numbers.number import Number


@dataclass(frozen=True)
class Tolerance:
    """A box of parameters around a scene; all entries are at least zero.

    Attributes:
        position: of each coordinate of each wheel (length).
        heading: of each rim direction, as ``pi * turn`` (radian).
        speed: of each surface speed, as a share of it.
        mu_roll: of each coefficient of friction along the axis, as a share of it.
        mu_side: the same across the axis.
        centre_of_mass: of each coordinate of the body's centre of mass in its own frame (length).
    """

    position: Number
    heading: Fraction
    speed: Number
    mu_roll: Number
    mu_side: Number
    centre_of_mass: Number

    @property
    def names(self) -> tuple[str, ...]:
        """The entries that are not zero."""
        return tuple(entry.name for entry in fields(self) if getattr(self, entry.name))

    def times(self, factor: Fraction) -> Tolerance:
        """Every entry times a factor that is not negative."""
        return Tolerance(**{entry.name: getattr(self, entry.name) * factor for entry in fields(self)})

    def without(self, name: str) -> Tolerance:
        """The same with one entry zero."""
        return replace(self, **{name: getattr(self, name) * 0})

    def scaled(self, factor: Fraction) -> Tolerance:
        """In another unit of length: lengths times a factor."""
        return replace(self, position=self.position * factor, centre_of_mass=self.centre_of_mass * factor)
