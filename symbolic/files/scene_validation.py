"""Pydantic's findings in the words of a scene file: the key, what it requires, what it received."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from typing import Any, TypeVar

from pydantic import ValidationError

from nonsmooth.symbolic.files.scene_values import TomlTable, keys_of, tables_in
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Wheel
from nonsmooth.symbolic.mechanics.units import AngleUnit, LengthUnit, Units
from nonsmooth.symbolic.messages import removed
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, is_meant, requirement

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
    if detail["type"] in _NO_KIND:
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
        case kind if kind in _NO_KIND:
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
}
_NO_KIND = ("union_tag_not_found", "union_tag_invalid")


def _expected(model: type[TomlTable], detail: Any) -> str:
    """What a pydantic error detail requires, in the words of a scene file."""
    context = detail.get("ctx", {})
    if isinstance(context.get("error"), ValueError):
        return requirement(context["error"])
    if detail["type"] == "extra_forbidden":
        keys = _keys(model, detail["loc"])
        return f"one of the keys {', '.join(keys)}{is_meant(detail['loc'][-1], keys)}"
    if detail["type"] in _NO_KIND:
        kinds = (t.model_fields["kind"].default for t in tables_in(model.model_fields["field"].annotation))
        return f"one of {', '.join(kinds)}"
    known = _EXPECTED.get(detail["type"])
    if known is None:
        return str(detail["msg"])
    return known.format(**context) + is_meant(detail["input"], QUOTED.findall(context.get("expected", "")))


def _keys(model: type[TomlTable], location: tuple[int | str, ...]) -> list[str]:
    """Keys of the table that holds the unknown key."""
    if len(location) == 1:
        return list(keys_of(model))
    tables = list(tables_in(keys_of(model)[str(location[0])].annotation))
    tagged = (t for t in tables if "kind" in t.model_fields and t.model_fields["kind"].default == location[1])
    return list(next(tagged, tables[0]).model_fields)


# ---- hints at units ------------------------------------------------------------------------------
#
# Hints at units: sizes and speeds a thousand times off are mostly a table in millimetres beside one in metres.


SIZES = 1 / 500, 50.0  # metres that an array may measure without a hint
SPEEDS = 1 / 2000, 50.0  # m/s of the fastest wheel
BODIES = 0.01, 100.0  # of the size of an array that a body may have
SQUARES = 1 / 2000, 20.0  # of the size of an array that the half-width of the checked square may have
AWAY = 20.0  # sizes of an array that the checked point may be away from its first wheel
MEANT = {LengthUnit.METRE: LengthUnit.MILLIMETRE, LengthUnit.MILLIMETRE: LengthUnit.METRE}


def unit_hints(wheels: Sequence[Wheel], body: Body | None, check: CheckedSquare, units: Units) -> Iterator[str]:
    """What looks as if it were stated in another unit; nothing where the scene states none."""
    metres = units.metres
    if metres is None:
        return
    size = max(_extent([float(wheel.position[k]) for wheel in wheels]) for k in (0, 1))
    fastest = max(abs(float(wheel.speed)) for wheel in wheels)
    meant = MEANT.get(LengthUnit(units.length))
    ask = "" if meant is None else f': is length = "{meant}" meant?'
    if not SIZES[0] <= size * float(metres) <= SIZES[1]:
        yield f"[units]: the wheels lie within {size:.4g} {units.length}{ask}"
    elif fastest and not SPEEDS[0] <= fastest * float(metres) <= SPEEDS[1]:
        yield f"[units]: the fastest wheel runs at {fastest:.4g} {units.speed}: is another units.speed meant?"
    if body is not None and not BODIES[0] * size <= body_size(body) <= BODIES[1] * size:
        wide, apart = f"{body_size(body):.4g} {units.length}", f"{size:.4g} {units.length}"
        yield f"[body]: it is {wide} wide, and the wheels lie within {apart}: are both in {units.length}?"
    yield from _of_check(wheels, check, size, units)


def angle_hints(turns: Iterable[Fraction], unit: AngleUnit | None) -> Iterator[str]:
    """Angles of more than a full turn where radians are stated: mostly degrees; ``turns`` are angles over pi."""
    largest = max(map(abs, turns), default=Fraction(0))
    if unit is AngleUnit.RADIAN and largest > 2:
        said = f"an angle is {float(largest) * math.pi:.4g} rad, more than a full turn"
        yield f'[units]: {said}: is angle = "{AngleUnit.DEGREE}" meant?'


def _of_check(wheels: Sequence[Wheel], check: CheckedSquare, size: float, units: Units) -> Iterator[str]:
    """A checked point far from all wheels, or a checked square that is far larger or smaller than the array."""
    length, first = units.length, wheels[0]
    away = max(abs(float(check.equilibrium[k]) - float(first.position[k])) for k in (0, 1))
    radius, wheels_lie = float(check.radius), f"the wheels lie within {size:.4g} {length}"
    if away > AWAY * size:
        place = f"{away:.6g} {length} away from wheel {first.index}"
        yield f"[check]: equilibrium is {place}, and {wheels_lie}: are both in {length}?"
    elif not SQUARES[0] * size <= radius <= SQUARES[1] * size:
        yield f"[check]: radius is {radius:.6g} {length}, and {wheels_lie}: are both in {length}?"


def body_size(body: Body) -> float:
    """The larger side of the box around a body, or its diameter."""
    if isinstance(body.outline, Disc):
        return 2 * float(body.outline.radius)
    return max(_extent([float(corner[k]) for corner in body.vertices]) for k in (0, 1))


def _extent(values: Sequence[float]) -> float:
    return max(values) - min(values)
