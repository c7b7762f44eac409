"""Values of scene files, in two steps: TOML to checked formulas, formulas to numbers of one field.

The field must hold every sine and cosine of the scene, so all angles are collected (:func:`angles`)
before the first number is evaluated (:class:`Numbers`).  Plain decimals skip the formula parser: a
wheel table holds tens of thousands of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Annotated, Any, TypeAlias, TypeVar, get_args

from flint import arb, ctx
from pydantic import BaseModel, ConfigDict, PlainValidator, ValidationError, ValidationInfo
from pydantic.fields import FieldInfo

from nonsmooth.symbolic.formulas.expression import Expression, formula_refused, parse
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.formulas.trees import ExpressionError, decimal_value
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.messages import removed
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, is_meant, requirement, shown
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import ROUNDING, NumberField, choose_angles, turn_of_radians
from nonsmooth.symbolic.numbers.number_text import short_text
from nonsmooth.symbolic.numbers.plane import Vector

PLANE = ("x", "y")  # the variables of a formula in the plane
MAX_NAME = 200  # characters
MAX_ROOTS = 64  # independent square roots in one file: each is proved new against all earlier ones,
MAX_ROOT_WORK = 2_048  # in a time that grows with their number times the degree of the base field
WITH_UNIT = re.compile(r"(.*\S)\s*(deg(?:rees?)?|rad(?:ians?)?|\N{DEGREE SIGN})", re.DOTALL)
_PLAIN_DECIMAL = re.compile(r"[+-]?([0-9]{1,60}(\.[0-9]{0,60})?([eE][+-]?[0-9]{1,3})?|nan|inf(inity)?)", re.I)

Exact: TypeAlias = Expression | Fraction


def read_name(value: object) -> str:
    """A printable line.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_NAME or not value.isprintable():
        raise ValueError(f"required a printable text of 1 to {MAX_NAME} characters")
    return value.strip()


Name = Annotated[str | None, PlainValidator(read_name)]


class TomlTable(BaseModel):
    """One TOML table: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True, defer_build=True)


def tables_in(annotation: Any) -> Iterator[type[TomlTable]]:
    """The tables inside an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, TomlTable):
        yield annotation
    for inner in get_args(annotation):
        yield from tables_in(inner)


def keys_of(table: type[TomlTable]) -> dict[str, FieldInfo]:
    """The keys of a table as a file writes them."""
    return {field.alias or name: field for name, field in table.model_fields.items()}


class AngleReading(Enum):
    """How an angle was read, where a reader must know; the value is what a note says of it."""

    AS_WRITTEN = ""
    WITHOUT_UNIT = "angles without a unit are read in degrees, as long as [units] states none"
    ROUNDED = f"angles in radians within {float(ROUNDING):.0e} of a multiple of pi are taken as that multiple"


@dataclass(frozen=True)
class Angle:
    """The angle ``pi * turn`` (radians)."""

    turn: Fraction
    reading: AngleReading = AngleReading.AS_WRITTEN


def read_exact(value: object) -> Exact:
    """A number as the user wrote it.

    Raises:
        ExpressionError: for anything but an integer, a finite decimal or a formula.
    """
    if isinstance(value, str) and _PLAIN_DECIMAL.fullmatch(value):
        return decimal_value(value)
    return parse(value, ())


def read_angle(value: object, unit: AngleUnit | None = None) -> Angle:
    """A number with or without its unit, or a rational multiple of pi, in radians.

    Args:
        value: such as 225, "45 deg", "0.8 rad" or "pi/6".
        unit: of a number that names none; degrees, with a note, where that is None.

    Raises:
        ExpressionError: for any other value.
    """
    named = WITH_UNIT.fullmatch(value.strip()) if isinstance(value, str) else None
    number = read_exact(value if named is None else named[1])
    constant, multiple = (number, Fraction(0)) if isinstance(number, Fraction) else number.parts_in_pi()
    stated = unit if named is None else unit_named(named[2])
    if multiple:
        return _angle_in_pi(constant, multiple, stated, is_named=named is not None, text=value)
    if stated is AngleUnit.RADIAN:
        return _angle_in_radians(constant, Fraction(0))
    is_assumed = stated is None and constant != 0
    return Angle(constant / 180, AngleReading.WITHOUT_UNIT if is_assumed else AngleReading.AS_WRITTEN)


def unit_named(word: str) -> AngleUnit:
    """The unit that a word of :data:`WITH_UNIT` names: ``deg``, ``degrees``, their sign, ``rad``, ``radians``."""
    return AngleUnit.RADIAN if word.startswith("rad") else AngleUnit.DEGREE


def _angle_in_pi(
    constant: Fraction, multiple: Fraction, stated: AngleUnit | None, *, is_named: bool, text: object
) -> Angle:
    """``constant + multiple pi``: in radians whatever the unit of plain numbers, but never beside the word deg."""
    if stated is AngleUnit.DEGREE and is_named:
        raise ExpressionError(f"required degrees without pi, received {shown(text)}")
    if constant and stated is not AngleUnit.RADIAN:
        raise ExpressionError(f'required a rational multiple of pi such as "pi/3", received {shown(text)}')
    return _angle_in_radians(constant, multiple)


def _angle_in_radians(constant: Fraction, multiple: Fraction) -> Angle:
    turn, is_rounded = turn_of_radians(constant)
    return Angle(turn + multiple, AngleReading.ROUNDED if is_rounded else AngleReading.AS_WRITTEN)


def unit_of_angles(info: ValidationInfo) -> AngleUnit | None:
    """The unit that the scene states for angles, while its tables are validated."""
    return (info.context or {}).get("angle")


def read_pair(value: object) -> tuple[Exact, Exact]:
    """Two numbers [a, b].

    Raises:
        ValueError: for anything but a list of two numbers.
    """
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError("required two numbers [a, b]")
    return read_exact(value[0]), read_exact(value[1])


def read_in_plane(value: object) -> Expression:
    """A formula in x and y.

    Raises:
        ExpressionError: for anything else.
    """
    return parse(value, PLANE)


def _number(value: object) -> Exact:
    return read_exact(value)


def _angle(value: object, info: ValidationInfo) -> Angle:
    return read_angle(value, unit_of_angles(info))


ExactField = Annotated[Exact, PlainValidator(_number)]
OptionalExact = Annotated[Exact | None, PlainValidator(_number)]
AngleField = Annotated[Angle, PlainValidator(_angle)]
PairField = Annotated[tuple[Exact, Exact], PlainValidator(read_pair)]
PlaneFormula = Annotated[Expression, PlainValidator(read_in_plane)]


def angles(value: object) -> Iterator[Fraction]:
    """Every turn ``t`` of an angle ``pi * t`` inside a table, list or formula."""
    for part in _parts(value):
        if isinstance(part, Angle):
            yield part.turn
        else:
            yield from part.turns()


def angle_remarks(value: object) -> Iterator[str]:
    """What a reader must know about how the angles inside a table or list were read."""
    readings = {part.reading for part in _parts(value) if isinstance(part, Angle)}
    return (reading.value for reading in AngleReading if reading in readings and reading.value)


def _parts(value: object) -> Iterator[Angle | Expression | PiecewiseExpression]:
    """Every angle and formula inside a table or list."""
    match value:
        case Expression() | PiecewiseExpression() | Angle():
            yield value
        case list() | tuple():
            for item in value:
                yield from _parts(item)
        case TomlTable():
            for _, item in value:
                yield from _parts(item)


def field_of(turns: Iterable[Fraction], remarks: Iterable[str] = (), *, decimals: bool = False) -> NumberField:
    """The number field of a scene with these angles ``pi * turn``, exact or measured, and remarks on its file."""
    choice = choose_angles(turns)
    field = NumberField(choice.order, choice.measured, remarks)
    field.writes_decimals = decimals
    return field


class Numbers:
    """Evaluates formulas in the one field of a scene; errors name the file and the key."""

    def __init__(self, file: str, field: NumberField) -> None:
        self.file, self.field = file, field
        self._directions: dict[Fraction, Vector] = {}

    def __call__(self, value: Exact, key: str) -> Number:
        """Exact number at a key.

        Raises:
            SceneError: on division by zero, negative square roots and numbers out of bounds.
        """
        if isinstance(value, Fraction):
            return self.field.rational(value)
        return self.formula(value, key, {})

    def formula(self, formula: Expression, key: str, values: Mapping[str, Number]) -> Number:
        """Exact value of a formula of the given variables; raises as above."""
        with formula_refused(self.file, key, formula.text):
            number = formula.value(self.field, values)
        roots = len(self.field.radicands)
        if roots > MAX_ROOTS or roots * self.field.base_degree > MAX_ROOT_WORK:
            raise SceneError(self.file, key, "fewer independent square roots in one scene", StatedFact(f"{roots}"))
        return number

    def positive(self, value: Exact, key: str) -> Number:
        """Exact number that must be positive.

        Raises:
            SceneError: where it is not.
        """
        number = self(value, key)
        if number.sign() <= 0:
            raise SceneError(self.file, key, "a positive number", StatedFact(short_text(number)))
        return number

    def at_least_zero(self, value: Exact, key: str) -> Number:
        """Exact number that must not be negative.

        Raises:
            SceneError: where it is.
        """
        number = self(value, key)
        if number.sign() < 0:
            raise SceneError(self.file, key, "a number of at least 0", StatedFact(short_text(number)))
        return number

    def direction(self, angle: Angle) -> Vector:
        """``(cos, sin)`` of an angle."""
        if angle.turn not in self._directions:
            self._directions[angle.turn] = self.field.cos_pi(angle.turn), self.field.sin_pi(angle.turn)
        return self._directions[angle.turn]


# ---- starts as typed -----------------------------------------------------------------------------
#
# Starts of solutions as typed: formulas of scene files, rounded once to the floats in which solutions are followed.


_PRECISION = 128  # bits of a sum with pi, beyond those that a large rational part needs


def read_start_value(text: str) -> float:
    """A number, or a formula such as ``sqrt(2)/4``.

    Raises:
        ExpressionError: for anything else.
        OverflowError: for numbers beyond floats.
    """
    number = read_exact(text.strip())
    return float(number) if isinstance(number, Fraction) else _value(number)


def read_start_angle(text: str, unit: AngleUnit | None = AngleUnit.RADIAN) -> float:
    """An angle (radian): a number, a formula, one with pi such as ``pi/6``, or ``10 deg``.

    Args:
        text: as typed.
        unit: of a number that names none and holds no pi; None where only 0 needs none.

    Raises:
        ExpressionError: for anything else, and a number without a unit where none is known.
        OverflowError: for numbers beyond floats.
    """
    named = WITH_UNIT.fullmatch(text.strip())
    if named is None and unit is not AngleUnit.RADIAN and "pi" not in text and read_start_value(text):
        if unit is None:
            raise ExpressionError(f"required {_both_units(text.strip())}, received {shown(text)}")
        return read_start_angle(f"{text} deg")
    if named is not None and unit_named(named[2]) is AngleUnit.DEGREE:
        turn = read_angle(text).turn
        return _sum_with_pi(Fraction(0), turn) if turn else 0.0
    number = read_exact(text.strip() if named is None else named[1])
    if isinstance(number, Fraction):
        return float(number)
    try:
        constant, multiple = number.parts_in_pi()
    except ExpressionError:  # such as sqrt(2)
        return _value(number)
    return _sum_with_pi(constant, multiple) if multiple else float(constant)


def _both_units(number: str) -> str:
    """An angle with a unit, in either of them: numbers of the scene's file were taken for degrees."""
    return f"a unit, as {number}deg or {number}rad (angles of the scene's file are read in degrees untold)"


def _value(number: Expression) -> float:
    """The float nearest to a formula; of measured angles as in a scene that holds this formula only."""
    return float(number.value(field_of(number.turns())))


def _sum_with_pi(constant: Fraction, multiple: Fraction) -> float:
    """``a + b pi``, which is never zero for b other than zero."""
    precision = _PRECISION + int(max(abs(constant), abs(multiple))).bit_length()
    while True:
        with ctx.workprec(precision):
            ball = rational_ball(constant)
            ball += rational_ball(multiple) * arb.pi()
        if ball.rel_accuracy_bits() >= _PRECISION // 2 + 1:
            return float(ball.mid())
        precision *= 2


# ---- what is refused -----------------------------------------------------------------------------
#
# Pydantic's findings in the words of a scene file: the key, what it requires, what it received.


QUOTED = re.compile("'([^']+)'")  # a name among those that pydantic expects
Model = TypeVar("Model", bound=TomlTable)


def validate(model: type[Model], data: object, file: str, angle_unit: AngleUnit | None = None) -> Model:
    """The data as a table; ``angle_unit`` is what the scene states for angles.

    Raises:
        SceneError: naming the first offending key; misspelt keys come before missing ones.
    """
    try:
        return model.model_validate(data, context={"angle": angle_unit})
    except ValidationError as error:
        details = error.errors(include_url=False)
        first = next((d for d in details if d["type"] == "extra_forbidden"), details[0])
        key = key_text(first["loc"])
        if first["type"] == "extra_forbidden" and key in removed.TABLES:
            without, kind = f"a scene without it: {removed.TABLES[key]}", "a key" if "." in key else "a table"
            raise SceneError(file, key, without, StatedFact(f"{kind} that was removed")) from None
        raise SceneError(file, _key(first), _expected(model, first), _received(first)) from None


def _key(detail: Any) -> str:
    """The offending key; pydantic's location in a field holds the kind as well."""
    location = detail["loc"]
    if _lacks_kind(detail):
        location = (*location, "kind")
    elif location[0] == "field":
        location = location[:1] + location[2:]
    return key_text(location)


def _received(detail: Any) -> object:
    match detail["type"]:
        case "missing":
            return StatedFact("nothing")
        case "extra_forbidden":
            return StatedFact("an unknown key")
        case _ if _lacks_kind(detail):
            return detail["input"].get("kind", StatedFact("nothing"))
    return detail["input"]


def key_text(location: tuple[int | str, ...]) -> str:
    """``wheel[2].speed``; list items are counted from 1."""
    return "".join(f"[{k + 1}]" if isinstance(k, int) else f".{k}" for k in location).removeprefix(".")


_EXPECTED = {
    "missing": "a value",
    "int_type": "an integer",
    "int_from_float": "an integer",
    "int_parsing": "an integer",
    "string_type": "a text in quotes",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "bool_type": "true or false",
    "tuple_type": "a list of tables, written [[region]]",
    "list_type": "a list of tables, written [[wheel]]",
    "greater_than_equal": "an integer of at least {ge}",
    "less_than_equal": "an integer of at most {le}",
    "enum": "{expected}",
    "literal_error": "{expected}",
    "union_tag_not_found": "a table",  # of a number, which is none
}


def _lacks_kind(detail: Any) -> bool:
    """Whether a table of a field has no ``kind``, or one that there is not."""
    return detail["type"] in ("union_tag_not_found", "union_tag_invalid") and isinstance(detail["input"], Mapping)


def _expected(model: type[TomlTable], detail: Any) -> str:
    """What a pydantic error detail requires, in the words of a scene file."""
    context = detail.get("ctx", {})
    if isinstance(context.get("error"), ValueError):
        return requirement(context["error"])
    if detail["type"] == "extra_forbidden":
        keys = _keys(model, detail["loc"])
        return f"one of the keys {', '.join(keys)}{is_meant(detail['loc'][-1], keys)}"
    if _lacks_kind(detail):
        kinds = (t.model_fields["kind"].default for t in tables_in(model.model_fields["field"].annotation))
        return f"one of {', '.join(kinds)}"
    template = _EXPECTED.get(detail["type"])
    if template is None:
        return str(detail["msg"])
    return template.format(**context) + is_meant(detail["input"], QUOTED.findall(context.get("expected", "")))


def _keys(model: type[TomlTable], location: tuple[int | str, ...]) -> list[str]:
    """Keys of the table that holds the unknown key."""
    if len(location) == 1:
        return list(keys_of(model))
    tables = list(tables_in(keys_of(model)[str(location[0])].annotation))
    tagged = (t for t in tables if "kind" in t.model_fields and t.model_fields["kind"].default == location[1])
    return list(next(tagged, tables[0]).model_fields)
