"""Programmable velocity fields Psi: where rims point, and how fast their surfaces run.

Wheel ``i`` at ``p_i`` points along ``D_i = Psi(p_i)``.  Its surface speed is 1 (``unit``), ``|Psi(p_i)|``
(``magnitude``) or a constant.  A heading that a wheel names itself is such a field as well: ``inward``,
``outward``, or the same direction everywhere.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Annotated, Literal, NamedTuple, Protocol, TypeAlias

from pydantic import Field, PlainValidator, ValidationInfo

from nonsmooth.symbolic.files.scene_values import (
    Angle,
    AngleField,
    Exact,
    ExactField,
    Numbers,
    PlaneFormula,
    TomlTable,
    read_angle,
    read_exact,
    read_pair,
    unit_of_angles,
)
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.numbers.plane import Vector

Psi: TypeAlias = Callable[[Vector], Vector]
Speed: TypeAlias = Literal["unit", "magnitude"] | Exact

_ONE = Fraction(1)


def read_speed(value: object) -> Speed:
    """``unit``, ``magnitude`` or a constant speed (length/time).

    Raises:
        ValueError: for anything else.
    """
    match value:
        case "unit":
            return "unit"
        case "magnitude":
            return "magnitude"
    try:
        return read_exact(value)
    except ValueError:
        raise ValueError('required "unit", "magnitude" or a number') from None


class VelocityField(Protocol):
    """Anything that names a direction for every position."""

    def psi(self, numbers: Numbers, key: str) -> Psi:
        """The map ``p -> Psi(p)`` in the scene's number field; ``key`` names it in errors."""


class FieldTable(TomlTable):
    """Keys that every ``[field]`` has."""

    speed: Annotated[Speed, PlainValidator(read_speed)] = "unit"


class Radial(FieldTable):
    """Inward: ``Psi = (-x, -y)``."""

    kind: Literal["radial"] = "radial"

    def psi(self, numbers: Numbers, key: str) -> Psi:
        """See :class:`VelocityField`."""
        return lambda p: (-p[0], -p[1])


class Elliptic(FieldTable):
    """``Psi = (-a x, -b y)``."""

    kind: Literal["elliptic"] = "elliptic"
    a: ExactField = _ONE
    b: ExactField = _ONE

    def psi(self, numbers: Numbers, key: str) -> Psi:
        """See :class:`VelocityField`."""
        a, b = numbers(self.a, f"{key}.a"), numbers(self.b, f"{key}.b")
        return lambda p: (-(a * p[0]), -(b * p[1]))


class Saddle(FieldTable):
    """``Psi = (-a x, +b y)``."""

    kind: Literal["saddle"] = "saddle"
    a: ExactField = _ONE
    b: ExactField = _ONE

    def psi(self, numbers: Numbers, key: str) -> Psi:
        """See :class:`VelocityField`."""
        a, b = numbers(self.a, f"{key}.a"), numbers(self.b, f"{key}.b")
        return lambda p: (-(a * p[0]), b * p[1])


class Squeeze(FieldTable):
    """``Psi = (-sgn x, 0)``: towards the y axis."""

    kind: Literal["squeeze"] = "squeeze"

    def psi(self, numbers: Numbers, key: str) -> Psi:
        """See :class:`VelocityField`."""
        field = numbers.field
        return lambda p: (field.rational(-p[0].sign()), field.zero)


class Spiral(FieldTable):
    """Inward, turned counterclockwise by the angle: ``Psi = -R(angle) p``."""

    kind: Literal["spiral"] = "spiral"
    angle: AngleField

    def psi(self, numbers: Numbers, key: str) -> Psi:
        """See :class:`VelocityField`."""
        c, s = numbers.direction(self.angle)
        return lambda p: (s * p[1] - c * p[0], -(s * p[0]) - c * p[1])


class Formulas(FieldTable):
    """``Psi = (x(x, y), y(x, y))`` by two formulas."""

    kind: Literal["expression"] = "expression"
    x: PlaneFormula
    y: PlaneFormula

    def psi(self, numbers: Numbers, key: str) -> Psi:
        """See :class:`VelocityField`."""

        def value(position: Vector) -> Vector:
            at = {"x": position[0], "y": position[1]}
            return numbers.formula(self.x, f"{key}.x", at), numbers.formula(self.y, f"{key}.y", at)

        return value


class Outward(TomlTable):
    """``Psi = (x, y)``."""

    def psi(self, numbers: Numbers, key: str) -> Psi:
        """See :class:`VelocityField`."""
        return lambda p: p


class Uniform(NamedTuple):
    """One direction everywhere: an angle from the x axis, or a vector of any length."""

    direction: Angle | tuple[Exact, Exact]

    def psi(self, numbers: Numbers, key: str) -> Psi:
        """See :class:`VelocityField`."""
        if isinstance(self.direction, Angle):
            vector = numbers.direction(self.direction)
        else:
            vector = numbers(self.direction[0], key), numbers(self.direction[1], key)
        return lambda p: vector


AnyField = Annotated[Radial | Elliptic | Saddle | Squeeze | Spiral | Formulas, Field(discriminator="kind")]
Heading: TypeAlias = Radial | Outward | Uniform

LINEAR_KINDS = ("radial", "elliptic", "saddle", "spiral")  # Psi(p) = A p
INWARD = Radial()
OUTWARD = Outward()


def read_heading(value: object, unit: AngleUnit | None = None) -> Heading:
    """``inward``, ``outward``, an angle, or a direction [a, b].

    Args:
        value: what the file holds.
        unit: of an angle that names none; see :func:`nonsmooth.symbolic.files.scene_values.read_angle`.

    Raises:
        ValueError: for anything else.
    """
    match value:
        case "inward":
            return INWARD
        case "outward":
            return OUTWARD
        case list():
            return Uniform(read_pair(value))
    try:
        return Uniform(read_angle(value, unit))
    except ValueError:
        expected = '"inward", "outward", an angle such as 45, "45 deg", "0.8 rad" or "pi/4", or a direction [a, b]'
        raise ValueError(f"required {expected}") from None


def _heading(value: object, info: ValidationInfo) -> Heading:
    return read_heading(value, unit_of_angles(info))


HeadingField = Annotated[Heading, PlainValidator(_heading)]
