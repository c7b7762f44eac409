"""Wheels and other parts of a scene from the tables of its document; what they do not name is the scene's."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from nonsmooth.symbolic.files.layouts import INWARD, LINEAR_KINDS, WheelOverrides, WheelPlace
from nonsmooth.symbolic.files.load_values import build_loads
from nonsmooth.symbolic.files.scene_document import ContactTable, SceneDocument
from nonsmooth.symbolic.files.scene_values import Exact, Numbers
from nonsmooth.symbolic.mechanics.body import ContinuousField, chosen
from nonsmooth.symbolic.mechanics.rule import BY_FRICTION_SET, MIXED
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Contact, Friction, Wheel, WheelNumber, default_length
from nonsmooth.symbolic.mechanics.springs import radius_to_check
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import short_text
from nonsmooth.symbolic.numbers.plane import Vector, cross, dot


class WheelBuilder:
    """Builds the wheels of one scene; equal friction is one shared object.

    Attributes:
        rule: the contact rule of the scene, known once its wheels are built.
    """

    def __init__(self, document: SceneDocument, numbers: Numbers) -> None:
        self._numbers, self._document = numbers, document
        self._psi = (document.field or INWARD).psi(numbers, "field")
        self._unit_speed = unit_speed(document, numbers)
        self._field_speed = speed_of_field(document, numbers)
        self.rule = document.contact.rule
        self._frictions: dict[tuple[Exact | None, Exact | None, str | None], Friction] = {}
        self._limits: dict[Exact | None, Number | None] = {}
        self._names: dict[frozenset[str], frozenset[str]] = {}

    def build(self, places: Iterable[WheelPlace]) -> tuple[Wheel, ...]:
        """Wheels numbered from 1.

        Raises:
            SceneError: for fewer than two wheels, two wheels at one place or of one name, no heading or axis, bad
                friction, contact rules that do not mix, and a speed above its limit.
        """
        wheels: list[Wheel] = []
        taken: dict[Vector, int] = {}
        listed = list(places)
        self.rule = self._rule_of(listed)
        self._refuse_equal_names(listed)
        for number, place in enumerate(listed, 1):
            index = WheelNumber(number, place.name) if place.name else number
            first = taken.setdefault(place.position, index)
            if first != index:
                where = StatedFact(f"{_text(place.position)}, the place of wheel {first}")
                raise self._error(f"{place.key}.position", f"another place for wheel {index}", where)
            wheels.append(self._wheel(index, place))
        if len(wheels) < 2:
            raise self._error("wheel", "at least two wheels", StatedFact(f"{len(wheels)}"))
        return tuple(wheels)

    def _refuse_equal_names(self, places: Iterable[WheelPlace]) -> None:
        """Refuse two wheels of one name.

        Raises:
            SceneError: naming both places.
        """
        first: dict[str, str] = {}
        for place in places:
            taken = first.setdefault(place.name, place.key) if place.name else place.key
            if taken != place.key:
                raise self._error(f"{place.key}.name", f"each name once (it is that of {taken})", place.name)

    def _wheel(self, index: int, place: WheelPlace) -> Wheel:
        settings = place.overrides
        if settings.speed is not None:
            speed: Number | None = self._converted(self._numbers(settings.speed, f"{place.key}.speed"))
        else:
            speed = self._field_speed if settings.heading is None else self._unit_speed
        friction = self._friction(index, place)
        limit = self._limit(place)
        direction = self._direction(index, place)
        axis = self._axis(index, place, direction)
        wheel = Wheel(index, place.position, direction, speed, friction, limit, axis, self._named(place))
        if limit is not None:
            self._refuse_above(limit, wheel, place)
        return wheel

    def _rule_of(self, places: Iterable[WheelPlace]) -> str:
        """The one contact rule of all wheels, or that of wheels with different ones.

        Raises:
            SceneError: for a rule that says where an array moves, not which forces a wheel carries, beside another.
        """
        common = self._document.contact.rule
        first: dict[str, str] = {}
        for place in places:
            contact = place.overrides.contact
            first.setdefault(contact or common, "contact.rule" if contact is None else f"{place.key}.contact")
        if len(first) < 2:
            return next(iter(first), common)
        for rule, key in first.items():
            if rule not in BY_FRICTION_SET:
                mixing = " or ".join(f'"{name}"' for name in sorted(BY_FRICTION_SET))
                others = ", ".join(f'"{name}"' for name in first if name != rule)
                expected = f"{mixing} beside wheels of rule {others} (rule {rule} holds for a whole array)"
                raise self._error(key, expected, StatedFact(f'"{rule}"'))
        return MIXED

    def _named(self, place: WheelPlace) -> frozenset[str]:
        """What a wheel states itself; equal sets are one shared object."""
        names = frozenset(
            key for key, value in zip(WheelOverrides._fields, place.overrides, strict=True) if value is not None
        )
        return self._names.setdefault(names, names)

    def _limit(self, place: WheelPlace) -> Number | None:
        """The largest speed of a wheel in lengths per second; equal limits are one shared number."""
        limit = place.overrides.speed_limit
        if limit not in self._limits:
            value = self._document.drive.speed_limit if limit is None else limit
            key = "drive.speed_limit" if limit is None else f"{place.key}.speed_limit"
            self._limits[limit] = None if value is None else self._converted(self._numbers.positive(value, key))
        return self._limits[limit]

    def _refuse_above(self, limit: Number, wheel: Wheel, place: WheelPlace) -> None:
        """Refuse a wheel whose own speed is above its limit.

        Raises:
            SceneError: naming the speed.
        """
        x, y = wheel.direction
        excess = x * x + y * y - limit * limit if wheel.given_speed is None else abs(wheel.given_speed) - limit
        if excess.sign() <= 0:
            return
        of_field = place.overrides.speed is None and place.overrides.heading is None
        key = "field.speed" if of_field else f"{place.key}.speed"
        unit = self._document.units.labels.after_speed
        required = f"at wheel {wheel.index} a speed within its speed_limit {short_text(limit)}{unit}"
        raise self._error(key, required, StatedFact(f"{short_text(wheel.speed)}{unit}"))

    def _direction(self, index: int, place: WheelPlace) -> Vector:
        heading, key = place.overrides.heading, "field"
        if heading is None:
            direction = self._psi(place.position)
        else:
            key = f"{place.key}.heading"
            direction = heading.psi(self._numbers, key)(place.position)
        self._refuse_none(direction, key, index, place, "a heading")
        return direction

    def _axis(self, index: int, place: WheelPlace, direction: Vector) -> Vector | None:
        """The friction axis, on the side of the rim's heading; None where it is the rim."""
        wheel_axis, common = place.overrides.axis, self._document.friction.axis
        key = "friction.axis" if wheel_axis is None else f"{place.key}.axis"
        named = common if wheel_axis is None else wheel_axis
        if named is None:
            return None
        axis = named.psi(self._numbers, key)(place.position)
        self._refuse_none(axis, key, index, place, "an axis")
        if not cross(axis, direction):
            return None
        return (-axis[0], -axis[1]) if dot(axis, direction).sign() < 0 else axis

    def _refuse_none(self, direction: Vector, key: str, index: int, place: WheelPlace, what: str) -> None:
        """Refuse a vector of length zero, as inward is at the origin.

        Raises:
            SceneError: naming wheel and place.
        """
        if not any(direction):
            where = f"wheel {index}, position {_text(place.position)}"
            required = f"a nonzero direction at {where} (or {what} such as [1, 0] of its own)"
            raise self._error(key, required, StatedFact("(0, 0)"))

    def _converted(self, speed: Number) -> Number:
        """A speed of the file in lengths per second; large tables hold many, so nothing is done to most."""
        return speed if self._unit_speed is self._numbers.field.one else speed * self._unit_speed

    def _friction(self, index: int, place: WheelPlace) -> Friction:
        settings = place.overrides
        named = settings.mu_roll, settings.mu_side, settings.contact
        if named not in self._frictions:
            roll = self._coefficient("mu_roll", named[0], index, place)
            side = self._coefficient("mu_side", named[1], index, place)
            if not roll and not side:
                key = "friction" if named[:2] == (None, None) else place.key
                raise self._error(key, "mu_roll or mu_side above 0", StatedFact("0 for both"))
            rule = (settings.contact or self._document.contact.rule) if self.rule == MIXED else ""
            self._frictions[named] = Friction(roll, side, rule)
        return self._frictions[named]

    def _coefficient(self, name: str, wheel_value: Exact | None, index: int, place: WheelPlace) -> Number:
        key = f"friction.{name}" if wheel_value is None else f"{place.key}.{name}"
        value: Exact | None = getattr(self._document.friction, name) if wheel_value is None else wheel_value
        if value is None:
            raise self._error(key, f"a number, since wheel {index} names none", StatedFact("nothing"))
        return self._numbers.at_least_zero(value, key)

    def _error(self, key: str, expected: str, value: object) -> SceneError:
        return SceneError(self._numbers.file, key, expected, value)


def speed_of_field(document: SceneDocument, numbers: Numbers) -> Number | None:
    """What the field of a scene says of speeds, in lengths per second; None for its own magnitude."""
    speed = (document.field or INWARD).speed
    if speed == "magnitude":
        return None
    unit = unit_speed(document, numbers)
    return unit if speed == "unit" else numbers(speed, "field.speed") * unit


def unit_speed(document: SceneDocument, numbers: Numbers) -> Number:
    """The file's unit of speed in lengths per second."""
    factor = document.units.speed_factor
    return numbers.field.one if factor == 1 else numbers.field.rational(factor)


def _text(position: Vector) -> str:
    return f"({short_text(position[0])}, {short_text(position[1])})"


# ---- parts of a scene from the tables of its document --------------------------------------------
#
# The contact rule, the continuous field, the checked square.


def build_contact(table: ContactTable, rule: str, numbers: Numbers, wheels: tuple[Wheel, ...]) -> Contact:
    """The contact rule that the wheels have together, and the loads that a ``[contact]`` table names.

    Raises:
        SceneError: for loads that are stated twice, or cannot be used.
    """
    if table.loads is not None and table.table is not None:
        raise SceneError(numbers.file, "contact.table", "either loads or table", StatedFact("both"))
    stated = table.table if table.loads is None else table.loads
    return Contact(rule, build_loads(stated, numbers, [wheel.position for wheel in wheels]))


def build_continuum(document: SceneDocument, numbers: Numbers, wheels: tuple[Wheel, ...]) -> ContinuousField:
    """The continuous field that the wheels stand for: that of ``[field]``, or towards or away from the origin."""
    field, zero, one = document.field, numbers.field.zero, numbers.field.one
    if field is None:  # inward or outward, as the first wheel is, at its speed
        first = wheels[0]
        outward = dot(first.direction, first.position).sign() > 0
        kind, pull = ("outward", one) if outward else ("radial", -one)
        return ContinuousField(kind, ((pull, zero), (zero, pull)), first.speed, (zero, zero))
    matrix = None
    if field.kind in LINEAR_KINDS:
        psi = field.psi(numbers, "field")
        (a, c), (b, d) = psi((one, zero)), psi((zero, one))
        matrix = ((a, b), (c, d))
    return ContinuousField(field.kind, matrix, speed_of_field(document, numbers), (zero, zero))


def build_check(
    document: SceneDocument, numbers: Numbers, wheels: tuple[Wheel, ...], contact: Contact
) -> CheckedSquare:
    """What ``[check]`` says is checked; the square and the length follow from the wheels where it does not say.

    Raises:
        SceneError: for a radius, a length or an accuracy that is not positive, or a length that is irrational.
    """
    table = document.check
    x, y = (numbers(value, "check.equilibrium") for value in table.equilibrium)
    if table.radius is None:
        radius = chosen(radius_to_check([wheel.position for wheel in wheels], (x, y), contact), document.units.labels)
    else:
        radius = numbers.positive(table.radius, "check.radius")
    if table.length is not None:
        length = _stated_length(table.length, numbers)
    else:
        length = default_length([wheel.position for wheel in wheels], (x, y))
    accuracy = None if table.accuracy is None else numbers.positive(table.accuracy, "check.accuracy")
    return CheckedSquare(
        (x, y),
        radius,
        table.lyapunov,
        length,
        has_default_radius=table.radius is None,
        has_default_length=table.length is None,
        accuracy=accuracy,
    )


def _stated_length(value: Exact, numbers: Numbers) -> Fraction:
    """The length l of ``V = |c|^2 + l^2 theta^2``.

    Raises:
        SceneError: where it is not positive, or irrational.
    """
    number = numbers.positive(value, "check.length")
    rational = number.as_rational()
    if rational is None:
        raise SceneError(numbers.file, "check.length", "a rational number", StatedFact(short_text(number)))
    return as_fraction(rational)
