"""Scene files: TOML in, one :class:`Scene` with exact numbers in one field out.

Structure is checked by pydantic, numbers by the formula parser, geometry last.  Whatever is wrong ends
in one :class:`SceneError` that names file, key, what was expected and what was received.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.symbolic.files.documents import (
    builtin_systems,
    deep_nesting_refused,
    path_beside,
    read_document,
    read_text,
)
from nonsmooth.symbolic.files.layouts import Layout, WheelList
from nonsmooth.symbolic.files.scene_document import (
    SceneDocument,
    StatedUnits,
    UnitsTable,
    build_body,
    build_inertia,
    build_loop_errors,
    build_tolerance,
)
from nonsmooth.symbolic.files.scene_values import Angle, Numbers, angle_remarks, angles, field_of, validate
from nonsmooth.symbolic.files.wheel_builder import WheelBuilder, build_check, build_contact, build_continuum
from nonsmooth.symbolic.files.wheel_csv import WheelRows, parse_wheels
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.rule import BY_FRICTION_SET, MIXED
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Scene, Wheel
from nonsmooth.symbolic.mechanics.units import AngleUnit, LengthUnit, Units
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number_field import FirstRemark
from nonsmooth.symbolic.numbers.number_text import numbers_text

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.scene import Scene
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


MAX_CSV_BYTES = 64 << 20
KEYS_OF_OTHERS = {  # tables of other documents, with the keys that tell them
    "system": {"states", "rhs"},
    "vehicle": {"track", "wheel_base"},
}


def load_scene(
    source: str | Path,
    *,
    rule: str | None = None,
    radius: str | None = None,
    at: str | None = None,
    accuracy: str | None = None,
    allow_outside: bool = False,
) -> Scene:
    """Read a scene.

    Args:
        source: path of a scene file, or the name of a built-in scene.
        rule: contact rule that replaces the file's: nearest, box, ellipse or roller.
        radius: half-width of the checked square (length) that replaces the file's, as text.
        at: equilibrium ``x,y`` that replaces the file's, as text.
        accuracy: how near a body must come (length), which replaces the file's, as text.
        allow_outside: read a table of wheels (``wheels.file``) from outside the scene's folder too.

    Raises:
        SceneError: for whatever cannot be used.
    """
    with deep_nesting_refused(source):
        document = read_document(source, rule=rule, radius=radius, at=at, accuracy=accuracy)
        return build_scene(*document, rule=rule, allow_outside=allow_outside)


def wheel_table(data: Mapping[str, Any], file: str, path: Path, *, allow_outside: bool = False) -> str | None:
    """The text of the table of wheels that a document names; None where it names none.

    It is read from outside the scene's folder only with ``allow_outside``.

    Raises:
        SceneError: for a table that cannot be read.
    """
    named = data.get("wheels")
    name = named.get("file") if isinstance(named, Mapping) else None
    if not isinstance(name, str):
        return None
    key = f"wheels.file {name}"
    table = path_beside(path, name, file, key, allow_outside=allow_outside)
    return read_text(table, MAX_CSV_BYTES, file, key, "a file")


def build_scene(
    data: dict[str, Any],
    file: str,
    path: Path,
    *,
    rule: str | None = None,
    allow_outside: bool = False,
    wheels: str | None = None,
) -> Scene:
    """The scene of a document, by the parts that :func:`read_document` returns.

    A table of wheels is read from outside the scene's folder only with ``allow_outside``; ``wheels`` is its text where
    that was read before.  That a ``rule`` was put into the document is remarked where no wheel takes it.

    Raises:
        SceneError: for whatever cannot be used.
    """
    _require_array(data, file)
    document = _document(data, file)
    layout = _layout(document, file, lambda: wheels or wheel_table(data, file, path, allow_outside=allow_outside) or "")
    has_units = document.units.length is not None
    numbers = Numbers(file, field_of(_turns(document, layout), _remarks(document, layout), decimals=has_units))
    builder = WheelBuilder(document, numbers)
    built = builder.build(layout.places(numbers))
    body = None if document.body is None else build_body(document.body, numbers)
    contact = build_contact(document.contact, builder.rule, numbers, built)
    check = build_check(document, numbers, built, contact)
    units = document.units
    hints = (
        *unit_hints(built, body, check, units.labels),
        *speed_hints(document, built),
        *angle_hints(layout.turns(), units.angle),
    )
    numbers.field.remarks += tuple(map(FirstRemark, hints))
    _require_mixed(rule, builder.rule, file)
    if rule not in (None, MIXED) and all("contact" in wheel.named for wheel in built):
        numbers.field.remarks += (f"rule {rule} is for wheels that name none, and all of these name their own",)
    return Scene(
        name=document.name or path.stem,
        field=numbers.field,
        wheels=built,
        contact=contact,
        check=check,
        source=file,
        continuum=build_continuum(document, numbers, built),
        units=units.labels,
        body=body,
        inertia=build_inertia(document.body, units.labels.metres, numbers),
        tolerances=None if document.tolerances is None else build_tolerance(document.tolerances, numbers),
        loop_errors=None if document.feedback is None else build_loop_errors(document.feedback, numbers),
    )


def _require_mixed(rule: str | None, wheel_rule: str, file: str) -> None:
    """Refuse rule ``mixed`` of wheels that have one rule: it is what wheels of different rules make."""
    if rule == MIXED != wheel_rule:
        mixing = " and ".join(sorted(BY_FRICTION_SET))
        raise SceneError(
            file, "contact.rule", f"wheels of rules {mixing} for rule {MIXED}", StatedFact(f"all {wheel_rule}")
        )


def _require_array(data: Mapping[str, Any], file: str) -> None:
    """Refuse documents of other kinds, also where their keys stand outside of their table."""
    if "system" in data:
        raise SceneError(file, "system", "an array of wheels", StatedFact("a plain switched system"))
    if "vehicle" in data:
        expected = "an array of wheels (the command vehicle reads vehicles)"
        raise SceneError(file, "vehicle", expected, StatedFact("a vehicle on its own wheels"))
    for table, keys in KEYS_OF_OTHERS.items():
        for key in keys & data.keys():
            raise SceneError(file, key, f"this key in the table [{table}]", StatedFact("it outside of every table"))


def _document(data: dict[str, Any], file: str) -> SceneDocument:
    """The validated tables; the units come first, since they say how angles are read."""
    return validate(SceneDocument, data, file, stated_units(data, file).angle)


def stated_units(data: dict[str, Any], file: str) -> UnitsTable:
    """The ``[units]`` of a document, which is read before its other tables.

    Raises:
        SceneError: for a unit of speed without one of length.
    """
    stated = {key: value for key, value in data.items() if key == "units"}
    units = validate(StatedUnits, stated, file).units
    if units.speed is not None and units.length is None:
        raise SceneError(file, "units.length", f"a unit of length beside speed = {units.speed}", StatedFact("nothing"))
    return units


def _layout(document: SceneDocument, file: str, table: Callable[[], str]) -> Layout:
    """The one layout of the document; ``table`` reads the text of its table of wheels.

    Raises:
        SceneError: for none or several.
    """
    names = ("wheel", "ring", "grid", "wheels")
    named = [name for name in names if getattr(document, name) is not None]
    if len(named) != 1:
        key, received = " and ".join(named) or "wheel", StatedFact(f"{len(named)}" if named else "none")
        raise SceneError(file, key, "one of [[wheel]], [ring], [grid], [wheels]", received)
    if document.wheels is not None:
        return parse_wheels(table(), document.wheels.file, file, document.units.angle)
    return document.ring or document.grid or WheelList(document.wheel or [])


def _turns(document: SceneDocument, layout: Layout) -> Iterator[Fraction]:
    yield from layout.turns()
    for table in (document.friction, document.drive, document.field, document.body, document.contact, document.check):
        yield from angles(table)
    for bounds in (document.feedback, document.tolerances):  # an angle in them bounds others: it has no direction
        yield from angles([entry for _, entry in bounds or () if not isinstance(entry, Angle)])


def _remarks(document: SceneDocument, layout: Layout) -> Iterator[str]:
    """What a reader must know about how the files were read."""
    table = layout if isinstance(layout, WheelRows) else WheelRows("", [], [])
    if table.rows and document.field is None and all(row.overrides.heading is None for row in table.rows):
        others = "a column heading, or [field], says otherwise"
        yield FirstRemark(f"{table.name} states no heading: all wheels drive toward (0, 0); {others}")
    yield from table.remarks
    yield from angle_remarks([document, table.cells])


# ---- hints at units ------------------------------------------------------------------------------
#
# Sizes and speeds a thousand times off are mostly a table in millimetres beside one in metres.


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


def speed_hints(document: SceneDocument, wheels: Sequence[Wheel]) -> Iterator[str]:
    """Wheels of a scene with units that run at one unit of speed, because nothing says how fast: all times follow."""
    of_field = document.field is not None and "speed" in document.field.model_fields_set  # of wheels without headings
    silent = [
        wheel for wheel in wheels if "speed" not in wheel.named and not (of_field and "heading" not in wheel.named)
    ]
    if document.units.length is None or not silent:
        return
    numbers = numbers_text(tuple(wheel.index for wheel in silent))
    who = "no wheel states a speed" if len(silent) == len(wheels) else f"no speed is stated of wheels {numbers}"
    fields = (
        " ([field] speed is that of wheels without a heading)" if of_field else " (speed of a wheel is a key or column)"
    )
    yield f"[units]: {who}: they run at {float(silent[0].speed):.4g} {document.units.labels.speed}{fields}"


def angle_hints(turns: Iterable[Fraction], unit: AngleUnit | None) -> Iterator[str]:
    """Angles of more than a full turn where radians are stated: mostly degrees; ``turns`` are angles over pi."""
    if unit is AngleUnit.RADIAN and (largest := max(map(abs, turns), default=Fraction(0))) > 2:
        words = f"an angle is {float(largest) * math.pi:.4g} rad, more than a full turn"
        yield f'[units]: {words}: is angle = "{AngleUnit.DEGREE}" meant?'


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


# ---- wheels one by one ---------------------------------------------------------------------------
#
# Wheels of a ring, a grid or a table as tables of a scene file, one by one, so that each can be changed on its own.
#
# What the scene says of all wheels (``friction``, ``drive``) stays where it is: a wheel states what it stated before,
# its place, heading and speed, and its friction axis.


LAYOUTS = ("wheel", "ring", "grid", "wheels", "field")  # tables that the list of wheels replaces


def one_by_one(document: Mapping[str, Any], scene: Scene) -> dict[str, Any]:
    """A document of the same array with a list of wheels, exact, in place of what laid them out."""
    rest = {key: value for key, value in document.items() if key not in LAYOUTS}
    unit = unit_of_speed(document, scene)
    return {**rest, "wheel": [wheel_entry(wheel, scene, unit) for wheel in scene.wheels]}


def unit_of_speed(document: Mapping[str, Any], scene: Scene) -> Fraction:
    """How many lengths per second the unit of speed is in which a document of a scene states speeds."""
    return stated_units(dict(document), scene.source).speed_factor


def wheel_entry(wheel: Wheel, scene: Scene, unit: Fraction) -> dict[str, Any]:
    """One wheel as a table of a scene file.

    Args:
        wheel: of a scene that was read from a file.
        scene: this scene.
        unit: of speed, in lengths per second.
    """
    entry: dict[str, Any] = {
        "position": [str(number) for number in wheel.position],
        "heading": [str(number) for number in wheel.direction],
        "speed": str(wheel.speed / unit),
    }
    if str(wheel.index) != f"{wheel.index:d}":
        entry = {"name": str(wheel.index), **entry}
    if "mu_roll" in wheel.named:
        entry["mu_roll"] = str(wheel.friction.roll)
    if "mu_side" in wheel.named:
        entry["mu_side"] = str(wheel.friction.side)
    if "speed_limit" in wheel.named and wheel.speed_limit is not None:
        entry["speed_limit"] = str(wheel.speed_limit / unit)
    if "contact" in wheel.named:
        entry["contact"] = scene.rule_of_wheel(wheel)
    if wheel.axis is not None:
        entry["axis"] = [str(number) for number in wheel.axis]
    return entry


# ---- scenes of either kind -----------------------------------------------------------------------
#
# Scene files of either kind: a wheel array, or with a ``[system]`` table a plain switched system.


def load_any(
    source: str | Path,
    *,
    rule: str | None = None,
    radius: str | None = None,
    at: str | None = None,
    accuracy: str | None = None,
    allow_outside: bool = False,
    exact: bool = False,
) -> Scene | SwitchedSystem:
    """Read a wheel array or a plain switched system, whichever the file holds.

    Args:
        source: a scene file or the name of a built-in one.
        rule: contact rule in place of the file's; refused for a system.
        radius: half-width of the checked square in place of the file's, in its unit of length.
        at: the checked point in place of the file's.
        accuracy: how near is near enough, in place of the file's (length).
        allow_outside: a scene may name tables outside its own folder.
        exact: numbers of a scene with units are written in exact forms, as those of all other scenes are.

    Raises:
        SceneError: for whatever cannot be used.
    """
    with deep_nesting_refused(source):
        data, file, path = read_document(source, rule=rule, radius=radius, at=at, accuracy=accuracy)
        if "system" not in data:
            scene = build_scene(data, file, path, rule=rule, allow_outside=allow_outside)
            scene.field.writes_decimals &= not exact
            return scene
        if rule is not None:
            raise SceneError(file, "contact.rule", "no contact rule for a plain switched system", str(rule))
        if accuracy is not None:
            raise SceneError(file, "check.accuracy", "no accuracy for a plain switched system", accuracy)
        from nonsmooth.symbolic.files.system_builder import build_system  # an array does without

        return build_system(data, file, path)


def load_system(source: str | Path, *, radius: str | None = None, at: str | None = None) -> SwitchedSystem:
    """Read a plain switched system.

    Args:
        source: path of a scene file, or the name of a built-in system.
        radius: half-width of the checked cube that replaces the file's, as text.
        at: equilibrium ``x,y`` that replaces the file's, as text.

    Raises:
        SceneError: for whatever cannot be used.
    """
    from nonsmooth.symbolic.files.system_builder import build_system

    with deep_nesting_refused(source):
        data, file, path = read_document(source, radius=radius, at=at)
        if "system" not in data:
            raise SceneError(file, "system", "a plain switched system, [system]", StatedFact("nothing"))
        return build_system(data, file, path)


def system_descriptions() -> dict[str, str]:
    """One line about each built-in system, by name."""
    return {name: read_document(name)[0]["description"] for name in builtin_systems()}
