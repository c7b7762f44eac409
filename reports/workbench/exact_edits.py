"""Edits of wheels that keep every number exact: add, delete, copy, mirror, rotate, snap, and writing layouts out.

A new number is first written as a formula of exact texts (``(1/2)*cos(pi/12) - (1)*sin(pi/12)``); the array of the
formulas then has a number field that holds it, and gives its short form.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.workbench.documents import (
    LAYOUTS,
    MAX_FORMULA,
    Document,
    canonical,
    expanded,
    opened,
    short_entry,
)
from nonsmooth.reports.workbench.requests import RequestError
from nonsmooth.symbolic.files.scene_file import unit_of_speed
from nonsmooth.symbolic.files.scene_values import Numbers, read_angle, read_exact
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.coefficients import as_fraction

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.scene import Wheel

Pair: TypeAlias = tuple[str, str]
Linear: TypeAlias = Callable[[Pair], Pair]  # of texts, about the origin

MAX_DENOMINATOR = 360  # of an angle over pi, as formulas allow
NEAR = ("inward", "outward")


class Edited(NamedTuple):
    """A document after an edit.

    Attributes:
        document: the scene.
        wheels: numbers of the wheels to select.
    """

    document: Document
    wheels: list[int]


def edited(document: Mapping[str, Any], operation: Mapping[str, Any]) -> Edited:
    """The document after an operation.

    Raises:
        RequestError: for an operation that cannot be used.
        SceneError: for a scene that cannot be used, before or after.
    """
    kind = operation.get("kind")
    if not isinstance(kind, str) or kind not in _OPERATIONS:
        raise RequestError(f"operation.kind: required one of {', '.join(_OPERATIONS)}", "operation.kind")
    made = opened(document)
    scene = made.exact
    if scene.kind is not SceneKind.ARRAY:
        raise RequestError("operation: required an array of wheels, received a plain system", "operation")
    plain = expanded(document, made)
    found = _OPERATIONS[kind](_Edit(plain, scene, operation))
    document = dict(canonical(found.document))
    _ = opened(document)  # refused as a scene file would be
    return Edited(document, found.wheels)


class _Edit(NamedTuple):
    """What an operation works on.

    Attributes:
        document: with its wheels one by one.
        scene: the same array.
        operation: its keys.
    """

    document: Document
    scene: Scene
    operation: Mapping[str, Any]

    @property
    def tables(self) -> list[Document]:
        return list(self.document["wheel"])

    def chosen(self) -> list[int]:
        """Numbers of the wheels that are meant, all unless some are named."""
        count, given = len(self.tables), self.operation.get("wheels") or []
        if not isinstance(given, list) or not all(_is_whole(n) and 1 <= n <= count for n in given):
            raise RequestError(f"operation.wheels: required numbers from 1 to {count}", "operation.wheels")
        return sorted(set(given)) or list(range(1, count + 1))

    def pair(self, key: str) -> Pair:
        """Two numbers of the operation, as texts that are formulas."""
        given = self.operation.get(key)
        if not isinstance(given, list) or len(given) != 2:
            raise RequestError(f"operation.{key}: required two numbers [x, y]", f"operation.{key}")
        return _formula(given[0], key), _formula(given[1], key)

    def with_tables(self, tables: Sequence[Document], sources: Sequence[int | None]) -> Document:
        """The document with these wheels; loads follow the wheels they come from."""
        return with_loads({**self.document, "wheel": list(tables)}, sources)

    def wheel(self, number: int) -> Wheel:
        """The exact wheel of a number."""
        return self.scene.wheels[number - 1]

    def speed(self, wheel: Wheel) -> Any:
        """The speed of a wheel as this document states it, in its own unit."""
        return short_entry(wheel.speed / unit_of_speed(self.document, self.scene))


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _formula(value: object, key: str) -> str:
    """A number of the operation as a text.

    Raises:
        RequestError: for anything that is no number.
    """
    try:
        read_exact(value)
    except ValueError as error:
        raise RequestError(f"operation.{key}: {error}", f"operation.{key}") from None
    return str(value)


# ---- the operations ------------------------------------------------------------------------------


def _expand(edit: _Edit) -> Edited:
    """Every wheel with its position, heading and speed as exact numbers, and without a field that gives them."""
    tables = [
        {**table, "heading": table.get("heading", _entries(wheel.direction)), "speed": edit.speed(wheel)}
        for table, wheel in zip(edit.tables, edit.scene.wheels, strict=True)
    ]
    kept = {key: value for key, value in edit.document.items() if key not in (*LAYOUTS, "field", "wheel")}
    return Edited({**kept, "wheel": tables}, [])


def _add(edit: _Edit) -> Edited:
    """A wheel at a place; it takes what it does not name from the scene."""
    _ = edit.pair("position")
    table: Document = {"position": edit.operation["position"]}
    if "field" not in edit.document:
        table |= {"heading": "inward", "speed": 1}
    friction, last = edit.document.get("friction", {}), edit.scene.wheels[-1].friction
    for key, value in (("mu_roll", last.roll), ("mu_side", last.side)):
        if key not in friction:
            table[key] = short_entry(value)
    tables = [*edit.tables, table]
    return Edited(edit.with_tables(tables, [*range(len(tables) - 1), None]), [len(tables)])


def _delete(edit: _Edit) -> Edited:
    gone = set(edit.chosen())
    kept = [k for k in range(len(edit.tables)) if k + 1 not in gone]
    if not edit.operation.get("wheels") or len(kept) < 2:
        raise RequestError("operation.wheels: required at least two wheels that stay", "operation.wheels")
    return Edited(edit.with_tables([edit.tables[k] for k in kept], kept), [])


def _copy(edit: _Edit) -> Edited:
    """The same wheels once more, displaced."""
    dx, dy = edit.pair("offset")
    chosen = edit.chosen()
    copies = []
    for number in chosen:
        x, y = _texts(edit.wheel(number).position)
        copies.append({**edit.tables[number - 1], "position": [f"({x}) + ({dx})", f"({y}) + ({dy})"]})
    return _extended(edit, copies)


def _mirror(edit: _Edit) -> Edited:
    """Reflected in the line through the checked point along an axis; in place, or as further wheels."""
    axis = edit.operation.get("axis")
    if axis not in ("x", "y"):
        raise RequestError('operation.axis: required "x" or "y"', "operation.axis")

    def reflected(vector: Pair) -> Pair:
        x, y = vector
        return (x, f"-({y})") if axis == "x" else (f"-({x})", y)

    return _mapped(edit, reflected, copies=bool(edit.operation.get("copy")))


def _rotate(edit: _Edit) -> Edited:
    """Turned about the checked point by an exact angle, counterclockwise."""
    try:
        turn = read_angle(edit.operation.get("angle")).turn
    except ValueError as error:
        raise RequestError(f"operation.angle: {error}", "operation.angle") from None
    if turn.denominator > MAX_DENOMINATOR:
        expected = f"a multiple of pi with a denominator up to {MAX_DENOMINATOR}"
        raise RequestError(f"operation.angle: required {expected}, received pi*{turn}", "operation.angle")
    angle = f"{turn.numerator % (2 * turn.denominator)}*pi/{turn.denominator}"

    def turned(vector: Pair) -> Pair:
        x, y = vector
        return f"({x})*cos({angle}) - ({y})*sin({angle})", f"({x})*sin({angle}) + ({y})*cos({angle})"

    return _mapped(edit, turned, copies=False)


def _snap(edit: _Edit) -> Edited:
    """Positions to the nearest multiples of a step."""
    given = read_exact(_formula(edit.operation.get("step"), "step"))
    found = Numbers("operation", edit.scene.field).positive(given, "step").as_rational()
    if found is None:
        raise RequestError("operation.step: required a rational number", "operation.step")
    step = as_fraction(found)
    tables = edit.tables
    for number in edit.chosen():
        place = [_rational(step * round(Fraction(float(value)) / step)) for value in edit.wheel(number).position]
        tables[number - 1] = {**tables[number - 1], "position": place}
    return Edited(edit.with_tables(tables, range(len(tables))), edit.chosen())


_OPERATIONS: dict[str, Callable[[_Edit], Edited]] = {
    "expand": _expand,
    "add": _add,
    "delete": _delete,
    "copy": _copy,
    "mirror": _mirror,
    "rotate": _rotate,
    "snap": _snap,
}


# ---- exact texts ---------------------------------------------------------------------------------


def _mapped(edit: _Edit, linear: Linear, *, copies: bool) -> Edited:
    """The chosen wheels under a linear map about the checked point: places, rims and friction axes."""
    centre = _texts(edit.scene.check.equilibrium)
    tables, made = edit.tables, []
    for number in edit.chosen():
        wheel, stated = edit.wheel(number), tables[number - 1]
        table = {**stated, "position": _about(centre, linear, _texts(wheel.position))}
        if not (stated.get("heading") in NEAR and centre == ("0", "0")):
            table["heading"] = list(linear(_texts(wheel.direction)))
        if "axis" in stated or "axis" in edit.document.get("friction", {}):
            table["axis"] = list(linear(_texts(wheel.axis or wheel.direction)))
        if wheel.given_speed is None or "speed" not in stated:
            table["speed"] = edit.speed(wheel)
        made.append(table)
    if copies:
        return _extended(edit, made)
    for number, table in zip(edit.chosen(), made, strict=True):
        tables[number - 1] = table
    return _shortened(edit, tables, list(range(len(tables))), edit.chosen())


def _about(centre: Pair, linear: Linear, place: Pair) -> list[str]:
    """A place under a linear map about a centre, as formulas."""
    if centre == ("0", "0"):
        return list(linear(place))
    (x, y), (a, b) = place, centre
    moved = linear((f"({x}) - ({a})", f"({y}) - ({b})"))
    return [f"({moved[0]}) + ({a})", f"({moved[1]}) + ({b})"]


def _extended(edit: _Edit, copies: list[Document]) -> Edited:
    tables = [*edit.tables, *copies]
    sources = [*range(len(edit.tables)), *[None] * len(copies)]
    return _shortened(edit, tables, sources, list(range(len(edit.tables) + 1, len(tables) + 1)))


def _shortened(edit: _Edit, tables: list[Document], sources: list[int | None], made: list[int]) -> Edited:
    """The formulas of the wheels that were made, evaluated and written shortly."""
    document = edit.with_tables(tables, sources)
    wheels = Array.of_document(document).scene.wheels
    for number in made:
        wheel, table = wheels[number - 1], dict(tables[number - 1])
        table["position"] = _entries(wheel.position)
        if isinstance(table.get("heading"), list):
            table["heading"] = _entries(wheel.direction)
        if wheel.axis is not None and isinstance(table.get("axis"), list):
            table["axis"] = _entries(wheel.axis)
        tables[number - 1] = table
    return Edited(edit.with_tables(tables, sources), made)


def _texts(vector: tuple[Any, Any]) -> Pair:
    return str(vector[0]), str(vector[1])


def _entries(vector: tuple[Any, Any]) -> list[Any]:
    entries = [short_entry(value) for value in vector]
    if any(isinstance(entry, str) and len(entry) > MAX_FORMULA for entry in entries):
        raise RequestError(f"operation: required results whose formulas have at most {MAX_FORMULA} characters")
    return entries


def _rational(value: Fraction) -> Any:
    return int(value) if value.denominator == 1 else str(value)


# ---- loads that follow the wheels ----------------------------------------------------------------


def with_loads(document: Mapping[str, Any], sources: Sequence[int | None]) -> dict[str, Any]:
    """The document with its loads in the order of its wheels.

    Args:
        document: with the new wheels and the old loads.
        sources: for each new wheel its place among the old ones; None for one that was none of them, which carries
            nothing.
    """
    contact = document.get("contact")
    if not isinstance(contact, Mapping):
        return dict(document)
    changed = {key: _followed(contact[key], sources) for key in ("loads", "table") if key in contact}
    return {**document, "contact": {**contact, **changed}}


def _followed(loads: Any, sources: Sequence[int | None]) -> Any:
    match loads:
        case list():
            return [[0, 0, 0] if source is None else loads[source] for source in sources]
        case {"table": list(rows), **rest}:
            return {**rest, "table": _followed(rows, sources)}
        case {"kind": "measured", "values": list(values), **rest}:
            values_left = [0 if source is None else values[source] for source in sources]
            return {"kind": "measured", "values": values_left, **rest}
    return loads
