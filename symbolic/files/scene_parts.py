"""Parts of a scene from the tables of its document: the contact rule, the continuous field, the checked square."""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.symbolic.files.load_values import build_loads
from nonsmooth.symbolic.files.scene_document import ContactTable, SceneDocument
from nonsmooth.symbolic.files.scene_values import Exact, Numbers
from nonsmooth.symbolic.files.velocity_fields import LINEAR_KINDS
from nonsmooth.symbolic.files.wheel_builder import speed_of_field
from nonsmooth.symbolic.mechanics.characteristic_length import default_length
from nonsmooth.symbolic.mechanics.continuum import ContinuousField
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Contact, Wheel
from nonsmooth.symbolic.mechanics.support_polygon import chosen, default_radius
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number_text import short_text
from nonsmooth.symbolic.numbers.plane import dot


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


def build_check(document: SceneDocument, numbers: Numbers, wheels: tuple[Wheel, ...]) -> CheckedSquare:
    """What ``[check]`` says is checked; the square and the length follow from the wheels where it does not say.

    Raises:
        SceneError: for a radius, a length or an accuracy that is not positive, or a length that is irrational.
    """
    table = document.check
    x, y = (numbers(value, "check.equilibrium") for value in table.equilibrium)
    if table.radius is None:
        radius = chosen(default_radius([wheel.position for wheel in wheels], (x, y)), document.units.labels)
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
    return Fraction(int(rational.p), int(rational.q))
