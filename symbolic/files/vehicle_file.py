"""Scene files with a ``[vehicle]`` table: a vehicle on its own wheels, over ground at rest.

In the vehicle's frame x points forward and y to the left (ROS REP 103).  ``track`` and ``wheel_base`` place two rows of
wheels that head forward; ``[[wheel]]`` adds wheels with headings and friction axes of their own (swerve, mecanum).
What is built is the same exact scene as for an array.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, StrictInt

from nonsmooth.symbolic.files.documents import builtin_vehicles, deep_nesting_refused, read_document
from nonsmooth.symbolic.files.layouts import Uniform, WheelOverrides, WheelPlace, WheelTable
from nonsmooth.symbolic.files.scene_document import ContactTable, DriveTable, FrictionTable, SceneDocument, UnitsTable
from nonsmooth.symbolic.files.scene_file import stated_units
from nonsmooth.symbolic.files.scene_values import (
    ExactField,
    Name,
    Numbers,
    OptionalExact,
    PairField,
    TomlTable,
    angle_remarks,
    angles,
    field_of,
    validate,
)
from nonsmooth.symbolic.files.wheel_builder import WheelBuilder, build_contact
from nonsmooth.symbolic.mechanics.body import default_radius
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Scene, Wheel, default_length
from nonsmooth.symbolic.mechanics.vehicles import Vehicle
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector

DEFAULT_RULE = "ellipse"  # rubber on ground, which rolls in no rollers
MOST_ROWS = 500  # wheels of a side
FORWARD = Uniform((Fraction(1), Fraction(0)))
_ZERO, _ONE = Fraction(0), Fraction(1)


class VehicleTable(TomlTable):
    """``[vehicle]``: where the wheels are, the centre of mass, the speeds of both sides, and what was measured.

    ``rows`` wheels stand evenly over ``wheel_base`` on each side, ``track`` apart; a tread is a row of many.  Without
    ``wheel_base`` the wheels come from ``[[wheel]]``, and without speeds each has its own.
    ``measured`` is the effective track of an in-place turn over the track, as somebody measured or ships it.
    """

    track: OptionalExact = None
    wheel_base: OptionalExact = None
    rows: Annotated[StrictInt, Field(ge=2, le=MOST_ROWS)] = 2
    centre_of_mass: PairField = (_ZERO, _ZERO)
    left: ExactField = -_ONE
    right: ExactField = _ONE
    wheel_radius: OptionalExact = None
    measured: OptionalExact = None
    source: Name = None


class VehicleDocument(TomlTable):
    """A whole scene file of a vehicle."""

    name: Name = None
    description: Name = None
    units: UnitsTable = UnitsTable()
    friction: FrictionTable = FrictionTable()
    drive: DriveTable = DriveTable()
    vehicle: VehicleTable
    wheel: list[WheelTable] = Field(default=[])
    contact: ContactTable = ContactTable(rule=DEFAULT_RULE)


def load_vehicle(source: str | Path, *, rule: str | None = None) -> Vehicle:
    """Read a vehicle.

    Args:
        source: path of a scene file, or the name of a built-in vehicle.
        rule: contact rule that replaces the file's.

    Raises:
        SceneError: for whatever cannot be used.
    """
    with deep_nesting_refused(source):
        return build_vehicle(*read_document(source, rule=rule))


def vehicle_descriptions() -> dict[str, str]:
    """One line about each built-in vehicle, by name."""
    return {name: read_document(name)[0]["description"] for name in builtin_vehicles()}


def build_vehicle(data: dict[str, Any], file: str, path: Path) -> Vehicle:
    """The vehicle of a document, by the parts that ``read_document`` returns.

    Raises:
        SceneError: for whatever cannot be used.
    """
    if "vehicle" not in data:
        kind = "a plain switched system" if "system" in data else "no such table"
        raise SceneError(file, "vehicle", "a vehicle on its own wheels, [vehicle]", StatedFact(kind))
    document = validate(VehicleDocument, _with_rule(data), file, stated_units(data, file).angle)
    table, numbers = document.vehicle, Numbers(file, field_of(angles(document), angle_remarks(document)))

    def positive(key: str) -> Number | None:
        value = getattr(table, key)
        return None if value is None else numbers.positive(value, f"vehicle.{key}")

    track, base, radius, measured = map(positive, ("track", "wheel_base", "wheel_radius", "measured"))
    if base is not None and track is None:
        raise SceneError(file, "vehicle.track", "a track beside wheel_base", StatedFact("nothing"))
    if base is None and not document.wheel:
        required = "track and wheel_base, or wheels of [[wheel]]"
        raise SceneError(file, "vehicle.wheel_base", required, StatedFact("nothing"))
    rows = () if base is None or track is None else _rows(track, base, table.rows)
    common = SceneDocument.model_construct(
        units=document.units, friction=document.friction, drive=document.drive, contact=document.contact
    )
    builder = WheelBuilder(common, numbers)
    wheels = builder.build(_places(document, numbers, rows))
    sides = [wheel.position[1].sign() for wheel in wheels]
    left, right = (
        None if 0 in sides else _side_speed(wheel for wheel, s in zip(wheels, sides, strict=True) if s == side)
        for side in (1, -1)
    )
    scene = _scene(document, builder.rule, numbers, wheels, path)
    return Vehicle(scene, track, base, left, right, radius, measured, table.source or "")


def _with_rule(data: dict[str, Any]) -> dict[str, Any]:
    """The document with the rule of vehicles where it names none."""
    contact = data.get("contact", {})
    return {**data, "contact": {"rule": DEFAULT_RULE, **contact}} if isinstance(contact, dict) else data


def _rows(track: Number, base: Number, count: int) -> Iterator[Vector]:
    """The wheels of both sides, front to back, the left wheel of each row first."""
    for k in range(count):
        x = base * (Fraction(1, 2) - Fraction(k, count - 1))
        yield x, track / 2
        yield x, -track / 2


def _places(document: VehicleDocument, numbers: Numbers, rows: Iterable[Vector]) -> Iterator[WheelPlace]:
    """The rows of both sides, then the vehicle's own wheels: forward at the speed of their side unless they say so.

    Raises:
        SceneError: for a wheel between the sides, at y = 0, without a speed of its own.
    """
    named = (wheel.place(numbers, f"wheel[{k}]") for k, wheel in enumerate(document.wheel, 1))
    speeds = {1: document.vehicle.left, -1: document.vehicle.right}
    for place in (*(WheelPlace("vehicle", position, WheelOverrides()) for position in rows), *named):
        settings = place.overrides._replace(heading=place.overrides.heading or FORWARD)
        if settings.speed is None:
            side = place.position[1].sign()
            if not side:
                required = "the speed of a wheel at y = 0, which is of neither side"
                raise SceneError(numbers.file, f"{place.key}.speed", required, StatedFact("nothing"))
            settings = settings._replace(speed=speeds[side])
        yield place._replace(overrides=settings)


def _side_speed(wheels: Iterable[Wheel]) -> Number | None:
    """The one speed of wheels that all head forward and roll on their rims; None where they do not, or there are none.

    A wheel that heads backward at the speed u heads forward at -u.
    """
    speeds = set()
    for wheel in wheels:
        if wheel.direction[1] or wheel.axis is not None:
            return None
        speeds.add(wheel.speed if wheel.direction[0].sign() > 0 else -wheel.speed)
    return speeds.pop() if len(speeds) == 1 else None


def _scene(document: VehicleDocument, rule: str, numbers: Numbers, wheels: tuple[Wheel, ...], path: Path) -> Scene:
    """The wheels as an array, checked at the centre of mass."""
    x, y = (numbers(value, "vehicle.centre_of_mass") for value in document.vehicle.centre_of_mass)
    places = [wheel.position for wheel in wheels]
    radius, length = default_radius(places, (x, y)), default_length(places, (x, y))
    check = CheckedSquare((x, y), radius, length=length, has_default_length=True, has_default_radius=True)
    contact, units = build_contact(document.contact, rule, numbers, wheels), document.units.labels
    return Scene(document.name or path.stem, numbers.field, wheels, contact, check, source=numbers.file, units=units)
