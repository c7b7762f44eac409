"""Scene files with a ``[vehicle]`` table: a vehicle on its own wheels, over ground at rest.

In the vehicle's frame x points forward and y to the left (ROS REP 103).  ``track`` and ``wheel_base`` place two rows of
wheels that head forward; ``[[wheel]]`` adds wheels with headings and friction axes of their own (swerve, mecanum), and
``urdf`` reads them from a robot description.  What is built is the same exact scene as for an array.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, StrictInt, StrictStr

from nonsmooth.symbolic.characteristic_length import default_length
from nonsmooth.symbolic.files.layouts import Own, WheelPlace, WheelTable
from nonsmooth.symbolic.files.scene_document import (
    ContactTable,
    DriveTable,
    FrictionTable,
    Name,
    SceneDocument,
    UnitsTable,
)
from nonsmooth.symbolic.files.scene_file import (
    builtin_vehicles,
    deep_nesting_refused,
    read_document,
    stated_units,
)
from nonsmooth.symbolic.files.scene_parts import build_contact
from nonsmooth.symbolic.files.scene_validation import validate
from nonsmooth.symbolic.files.scene_values import (
    Exact,
    ExactField,
    Numbers,
    OptionalExact,
    PairField,
    TomlTable,
    angle_remarks,
    angles,
    field_of,
)
from nonsmooth.symbolic.files.text_files import path_beside, read_text
from nonsmooth.symbolic.files.urdf import MAX_BYTES, UrdfWheel, read_urdf
from nonsmooth.symbolic.files.velocity_fields import Uniform
from nonsmooth.symbolic.files.wheel_builder import WheelBuilder
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector
from nonsmooth.symbolic.scene import CheckedSquare, Scene, Wheel
from nonsmooth.symbolic.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.support_polygon import default_radius
from nonsmooth.symbolic.vehicles import Vehicle

DEFAULT_RULE = "ellipse"  # rubber on ground, which rolls in no rollers
MOST_ROWS = 500  # wheels of a side
FORWARD = Uniform((Fraction(1), Fraction(0)))
_ZERO, _ONE = Fraction(0), Fraction(1)


class VehicleTable(TomlTable):
    """``[vehicle]``: where the wheels are, the centre of mass, the speeds of both sides, and what was measured.

    ``rows`` wheels stand evenly over ``wheel_base`` on each side, ``track`` apart; a tread is a row of many.  Without
    ``wheel_base`` the wheels come from ``[[wheel]]`` or from ``urdf``, and without speeds each has its own.
    ``measured`` is the effective track of an in-place turn over the track, as somebody measured or ships it.
    """

    track: OptionalExact = None
    wheel_base: OptionalExact = None
    rows: Annotated[StrictInt, Field(ge=2, le=MOST_ROWS)] = 2
    centre_of_mass: PairField = (_ZERO, _ZERO)
    left: ExactField = -_ONE
    right: ExactField = _ONE
    wheel_radius: OptionalExact = None
    urdf: StrictStr | None = None
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


def load_vehicle(source: str | Path, *, rule: str | None = None, allow_outside: bool = False) -> Vehicle:
    """Read a vehicle.

    Args:
        source: path of a scene file, or the name of a built-in vehicle.
        rule: contact rule that replaces the file's.
        allow_outside: read a robot description (``vehicle.urdf``) from outside the scene's folder too.

    Raises:
        SceneError: for whatever cannot be used.
    """
    with deep_nesting_refused(source):
        data, file, path = read_document(source, rule=rule)
        return build_vehicle(data, file, path, allow_outside=allow_outside)


def vehicle_descriptions() -> dict[str, str]:
    """One line about each built-in vehicle, by name."""
    return {name: read_document(name)[0]["description"] for name in builtin_vehicles()}


def build_vehicle(data: dict[str, Any], file: str, path: Path, *, allow_outside: bool = False) -> Vehicle:
    """The vehicle of a document, by the parts that ``read_document`` returns.

    Raises:
        SceneError: for whatever cannot be used.
    """
    if "vehicle" not in data:
        kind = "a plain switched system" if "system" in data else "no such table"
        raise SceneError(file, "vehicle", "a vehicle on its own wheels, [vehicle]", StatedFact(kind))
    document = validate(VehicleDocument, _with_rule(data), file, stated_units(data, file).angle)
    numbers = Numbers(file, field_of(angles(document), angle_remarks(document)))
    layout = _Layout(document, numbers, _described(document, file, path, allow_outside=allow_outside))
    common = SceneDocument.model_construct(units=document.units, friction=document.friction, drive=document.drive)
    wheels = WheelBuilder(common, numbers).build(layout.places())
    return layout.vehicle(_scene(document, numbers, wheels, path))


def _with_rule(data: dict[str, Any]) -> dict[str, Any]:
    """The document with the rule of vehicles where it names none."""
    contact = data.get("contact", {})
    return {**data, "contact": {"rule": DEFAULT_RULE, **contact}} if isinstance(contact, dict) else data


def _described(document: VehicleDocument, file: str, path: Path, *, allow_outside: bool) -> tuple[UrdfWheel, ...]:
    """The wheels of the robot description that the document names."""
    name, key = document.vehicle.urdf, "vehicle.urdf"
    if name is None:
        return ()
    robot = path_beside(path, name, file, key, allow_outside=allow_outside)
    return read_urdf(read_text(robot, MAX_BYTES, file, key, "a file"), file, key)


def _scene(document: VehicleDocument, numbers: Numbers, wheels: tuple[Wheel, ...], path: Path) -> Scene:
    """The wheels as an array, checked at the centre of mass."""
    x, y = (numbers(value, "vehicle.centre_of_mass") for value in document.vehicle.centre_of_mass)
    places = [wheel.position for wheel in wheels]
    check = CheckedSquare(
        (x, y),
        default_radius(places, (x, y)),
        length=default_length(places, (x, y)),
        has_default_length=True,
        has_default_radius=True,
    )
    return Scene(
        name=document.name or path.stem,
        field=numbers.field,
        wheels=wheels,
        contact=build_contact(document.contact, numbers, wheels),
        check=check,
        source=numbers.file,
        units=document.units.labels,
    )


def side_speed(wheels: Iterable[Wheel]) -> Number | None:
    """The one speed of wheels that all head forward and roll on their rims; None where they do not, or there are none.

    A wheel that heads backward at the speed u heads forward at -u.
    """
    speeds = set()
    for wheel in wheels:
        if wheel.direction[1] or wheel.axis is not None:
            return None
        speeds.add(wheel.speed if wheel.direction[0].sign() > 0 else -wheel.speed)
    return speeds.pop() if len(speeds) == 1 else None


class _Layout:
    """The wheels of a vehicle: the rows of both sides, then those of a description, then its own."""

    def __init__(self, document: VehicleDocument, numbers: Numbers, described: tuple[UrdfWheel, ...]) -> None:
        self._document, self._numbers, self._described = document, numbers, described
        table = document.vehicle
        self._track = self._length(table.track, "track")
        self._base = self._length(table.wheel_base, "wheel_base")
        if self._base is not None and self._track is None:
            raise SceneError(numbers.file, "vehicle.track", "a track beside wheel_base", StatedFact("nothing"))
        if self._base is None and not described and not document.wheel:
            required = "track and wheel_base, or wheels of [[wheel]] or of urdf"
            raise SceneError(numbers.file, "vehicle.wheel_base", required, StatedFact("nothing"))

    def places(self) -> Iterator[WheelPlace]:
        """All wheels with what they name themselves."""
        table = self._document.vehicle
        for position in self._rows():
            yield WheelPlace("vehicle", position, Own(heading=FORWARD, speed=self._speed(position)))
        for wheel in self._described:
            x, y = (self._numbers(value, "vehicle.urdf") for value in wheel.position)
            own = Own(heading=Uniform(wheel.heading), speed=table.left if y.sign() > 0 else table.right)
            yield WheelPlace(f"vehicle.urdf {wheel.joint}", (x, y), own)
        for k, own_table in enumerate(self._document.wheel, 1):
            place = own_table.place(self._numbers, f"wheel[{k}]")
            own = place.own if place.own.heading is not None else place.own._replace(heading=FORWARD)
            yield place._replace(own=own if own.speed is not None else own._replace(speed=self._speed(place.position)))

    def vehicle(self, scene: Scene) -> Vehicle:
        """The vehicle on these wheels."""
        table, numbers = self._document.vehicle, self._numbers
        track, base = self._track, self._base
        if self._described:
            xs, ys = zip(*(wheel.position for wheel in scene.wheels), strict=True)
            track, base = track or max(ys) - min(ys), base or max(xs) - min(xs)
        measured = None if table.measured is None else numbers.positive(table.measured, "vehicle.measured")
        return Vehicle(
            scene,
            track=track,
            wheel_base=base,
            left=side_speed(wheel for wheel in scene.wheels if wheel.position[1].sign() > 0),
            right=side_speed(wheel for wheel in scene.wheels if wheel.position[1].sign() <= 0),
            wheel_radius=self._radius(),
            measured=measured,
            source=table.source or "",
        )

    def _rows(self) -> Iterator[Vector]:
        """Front to back, the left wheel of each row first."""
        if self._base is None or self._track is None:
            return
        count = self._document.vehicle.rows
        for k in range(count):
            x = self._base * (Fraction(1, 2) - Fraction(k, count - 1))
            yield x, self._track / 2
            yield x, -self._track / 2

    def _speed(self, position: Vector) -> Exact:
        """That of the side: left where y > 0."""
        table = self._document.vehicle
        return table.left if position[1].sign() > 0 else table.right

    def _length(self, value: Exact | None, name: str) -> Number | None:
        return None if value is None else self._numbers.positive(value, f"vehicle.{name}")

    def _radius(self) -> Number | None:
        stated = self._length(self._document.vehicle.wheel_radius, "wheel_radius")
        found = {wheel.radius for wheel in self._described} - {None}
        if stated is None and len(found) == 1:
            return self._numbers(found.pop() or _ONE, "vehicle.urdf")
        return stated
