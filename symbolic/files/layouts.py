"""Where the wheels of an array are: one by one, on a ring, on a grid, or in a CSV table."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Annotated, Literal, NamedTuple, Protocol, TypeAlias

from pydantic import Field, PlainValidator, StrictInt, ValidationInfo

from nonsmooth.symbolic.files.scene_values import (
    Angle,
    AngleField,
    Exact,
    ExactField,
    Numbers,
    OptionalExact,
    PairField,
    PlaneFormula,
    TomlTable,
    angles,
    read_angle,
    read_exact,
    read_pair,
    unit_of_angles,
)
from nonsmooth.symbolic.mechanics.rule import read_rule
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.plane import Vector

_ONE = Fraction(1)


# ---- velocity fields -----------------------------------------------------------------------------
#
# Programmable velocity fields Psi: where rims point, and how fast their surfaces run.
#
# Wheel ``i`` at ``p_i`` points along ``D_i = Psi(p_i)``. Its surface speed is 1 (``unit``), ``|Psi(p_i)|``
# (``magnitude``) or a constant. A heading that a wheel names itself is such a field as well: ``inward``, ``outward``,
# or the same direction everywhere.


Psi: TypeAlias = Callable[[Vector], Vector]
Speed: TypeAlias = Literal["unit", "magnitude"] | Exact


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


# ---- layouts -------------------------------------------------------------------------------------


MAX_WHEELS = 250_000  # about 10 s to load; a larger array would not be checked in a day
MAX_RING = 360  # the degree of the number field grows with the count: up to 358 below this bound
MAX_NAME = 30  # characters of a wheel's name
_NAME = re.compile(rf"\w(?:[\w .:/+#()-]{{0,{MAX_NAME - 2}}}[\w)])?")  # no comma: lists of names are parted by them


def read_name(value: object) -> str:
    """The name of a wheel.

    Raises:
        ValueError: for an empty one, a long one, and characters that lists and formulas use.
    """
    if isinstance(value, int) and not isinstance(value, bool):
        return str(value)
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        characters = "letters, digits, blanks and .:/+#()-_, the first a letter or digit, the last one of these or )"
        raise ValueError(f"required a name of at most {MAX_NAME} {characters}")
    return value


RuleName = Annotated[str, PlainValidator(read_rule)]
WheelName = Annotated[str, PlainValidator(read_name)]


class WheelOverrides(NamedTuple):
    """What a wheel names itself; the scene's field and friction give the rest."""

    heading: Heading | None = None
    speed: Exact | None = None
    mu_roll: Exact | None = None
    mu_side: Exact | None = None
    speed_limit: Exact | None = None
    axis: Heading | None = None
    contact: str | None = None


class WheelPlace(NamedTuple):
    """A wheel whose position is known; ``key`` names it in errors, ``name`` in all that is said of it."""

    key: str
    position: Vector
    overrides: WheelOverrides
    name: str = ""


class Layout(Protocol):
    """Any way to place wheels."""

    def turns(self) -> Iterator[Fraction]:
        """Angles ``pi * turn`` that the number field must hold."""

    def places(self, numbers: Numbers) -> Iterator[WheelPlace]:
        """The wheels in order."""


class WheelTable(TomlTable):
    """One ``[[wheel]]``."""

    position: PairField
    heading: HeadingField | None = None
    speed: OptionalExact = None
    mu_roll: OptionalExact = None
    mu_side: OptionalExact = None
    speed_limit: OptionalExact = None
    axis: HeadingField | None = None
    contact: RuleName | None = None
    name: WheelName = ""

    def place(self, numbers: Numbers, key: str) -> WheelPlace:
        """This wheel at its exact position."""
        x, y = (numbers(value, f"{key}.position") for value in self.position)
        settings = WheelOverrides(
            self.heading, self.speed, self.mu_roll, self.mu_side, self.speed_limit, self.axis, self.contact
        )
        return WheelPlace(key, (x, y), settings, self.name)


class WheelList(NamedTuple):
    """Wheels written one by one."""

    wheels: list[WheelTable]

    def turns(self) -> Iterator[Fraction]:
        """See :class:`Layout`."""
        return angles(self.wheels)

    def places(self, numbers: Numbers) -> Iterator[WheelPlace]:
        """See :class:`Layout`."""
        return (wheel.place(numbers, f"wheel[{k}]") for k, wheel in enumerate(self.wheels, 1))


class Ring(TomlTable):
    """``count`` wheels at ``radius (cos, sin)(phase + 2 pi k/count)``, k = 0, 1, ...; ``[ring]``."""

    count: Annotated[StrictInt, Field(ge=2, le=MAX_RING)]
    radius: ExactField = _ONE
    phase: AngleField = Angle(Fraction(0))

    def turns(self) -> Iterator[Fraction]:
        """See :class:`Layout`."""
        yield from angles(self.radius)
        for k in range(self.count):
            yield self.phase.turn + Fraction(2 * k, self.count)

    def places(self, numbers: Numbers) -> Iterator[WheelPlace]:
        """See :class:`Layout`."""
        radius = numbers.positive(self.radius, "ring.radius")
        for k in range(self.count):
            x, y = numbers.direction(Angle(self.phase.turn + Fraction(2 * k, self.count)))
            yield WheelPlace(f"ring[{k + 1}]", (radius * x, radius * y), WheelOverrides())


class Grid(TomlTable):
    """``rows x columns`` wheels at distance ``pitch``, centred on the origin; ``[grid]``.

    Numbered from the lowest row up, each row from left to right.
    """

    rows: Annotated[StrictInt, Field(ge=1, le=MAX_WHEELS)]
    columns: Annotated[StrictInt, Field(ge=1, le=MAX_WHEELS)]
    pitch: ExactField = _ONE

    def turns(self) -> Iterator[Fraction]:
        """See :class:`Layout`."""
        return angles(self.pitch)

    def places(self, numbers: Numbers) -> Iterator[WheelPlace]:
        """See :class:`Layout`."""
        if not 2 <= self.rows * self.columns <= MAX_WHEELS:
            count = StatedFact(f"{self.rows} x {self.columns}")
            raise SceneError(numbers.file, "grid", f"two to {MAX_WHEELS} wheels", count)
        pitch = numbers.positive(self.pitch, "grid.pitch")
        half_columns, half_rows = Fraction(self.columns - 1, 2), Fraction(self.rows - 1, 2)
        xs = [pitch * (k - half_columns) for k in range(self.columns)]
        ys = [pitch * (k - half_rows) for k in range(self.rows)]
        positions = ((x, y) for y in ys for x in xs)
        return (WheelPlace(f"grid[{k}]", position, WheelOverrides()) for k, position in enumerate(positions, 1))
