"""Where the wheels of an array are: one by one, on a ring, on a grid, or in a CSV table."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from typing import Annotated, NamedTuple, Protocol

from pydantic import Field, PlainValidator, StrictInt

from nonsmooth.symbolic.files.scene_values import (
    Angle,
    AngleField,
    Exact,
    ExactField,
    Numbers,
    OptionalExact,
    PairField,
    TomlTable,
    angles,
)
from nonsmooth.symbolic.files.velocity_fields import Heading, HeadingField
from nonsmooth.symbolic.mechanics.rule import read_rule
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.plane import Vector

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
        raise ValueError(f"required a name of at most {MAX_NAME} letters, digits, blanks and .:/+#()-_")
    return value


RuleName = Annotated[str, PlainValidator(read_rule)]
WheelName = Annotated[str, PlainValidator(read_name)]
_ONE = Fraction(1)


class Own(NamedTuple):
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
    own: Own
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
        own = Own(self.heading, self.speed, self.mu_roll, self.mu_side, self.speed_limit, self.axis, self.contact)
        return WheelPlace(key, (x, y), own, self.name)


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
            yield WheelPlace(f"ring[{k + 1}]", (radius * x, radius * y), Own())


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
        return (WheelPlace(f"grid[{k}]", position, Own()) for k, position in enumerate(positions, 1))
