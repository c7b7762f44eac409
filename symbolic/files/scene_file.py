"""Scene files: TOML in, one :class:`Scene` with exact numbers in one field out.

Structure is checked by pydantic, numbers by the formula parser, geometry last.  Whatever is wrong ends
in one :class:`SceneError` that names file, key, what was expected and what was received.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal
from difflib import get_close_matches
from fractions import Fraction
from pathlib import Path
from typing import Any

from nonsmooth.symbolic.files.body_table import build_body, build_inertia
from nonsmooth.symbolic.files.layouts import Layout, WheelList
from nonsmooth.symbolic.files.scene_document import (
    SceneDocument,
    StatedUnits,
    UnitsTable,
    build_loop_errors,
    build_tolerance,
)
from nonsmooth.symbolic.files.scene_validation import angle_hints, unit_hints, validate
from nonsmooth.symbolic.files.scene_values import Numbers, angle_remarks, angles, field_of
from nonsmooth.symbolic.files.wheel_builder import WheelBuilder, build_check, build_contact, build_continuum
from nonsmooth.symbolic.files.wheel_csv import WheelRows, parse_wheels
from nonsmooth.symbolic.mechanics.rule import BY_FRICTION_SET, MIXED
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number_field import FirstRemark

__all__ = [
    "SceneError",
    "build_scene",
    "builtin_descriptions",
    "builtin_scenes",
    "builtin_systems",
    "builtin_vehicles",
    "deep_nesting_refused",
    "load_scene",
    "read_document",
    "stated_units",
    "wheel_table",
]

MAX_TOML_BYTES = 1 << 20
MAX_CSV_BYTES = 64 << 20
KEYS_OF_OTHERS = {  # tables of other documents, with the keys that tell them
    "system": {"states", "rhs"},
    "vehicle": {"track", "wheel_base"},
}
_SCENES = Path(__file__).parents[1] / "scenes"
_BUILTIN = (
    "four-wheel",
    "four-wheel-side",
    "rectangle",
    "ring-3",
    "ring-5",
    "ring-6",
    "ring-8",
    "grid-4x4",
    "elliptic",
    "spiral-30",
    "conveyor-3",
    "saddle",
    "outward",
    "off-center",
    "differential-drive",
    "omni-3",
    "mecanum-4",
    "roller-bed",
    "carton-on-6x6",
)
_SYSTEMS = (
    "relay-oscillator",
    "relay-oscillator-damped",
    "flower",
    "escaping-slide",
    "line-of-equilibria",
    "eq-3",
    "eq-4",
    "stick-slip",
    "relay-chain",
)
_VEHICLES = (
    "lynx-wh05",
    "jackal",
    "husky-a200",
    "leo-rover",
    "panther-wh01",
    "rosbot",
    "warthog",
    "mecanum-base",
    "swerve-base",
    "tracked-base",
)


def builtin_scenes() -> tuple[str, ...]:
    """Names of the built-in scenes."""
    return _BUILTIN


def builtin_systems() -> tuple[str, ...]:
    """Names of the built-in plain switched systems (see :mod:`nonsmooth.symbolic.files.system_file`)."""
    return _SYSTEMS


def builtin_vehicles() -> tuple[str, ...]:
    """Names of the built-in vehicles on their own wheels (see :mod:`nonsmooth.symbolic.files.vehicle_file`)."""
    return _VEHICLES


def builtin_descriptions() -> dict[str, str]:
    """One line about each built-in scene, by name."""
    return {name: _read_toml(_SCENES / f"{name}.toml", name)["description"] for name in _BUILTIN}


def read_document(
    source: str | Path,
    *,
    rule: str | None = None,
    radius: str | None = None,
    at: str | None = None,
    accuracy: str | None = None,
) -> tuple[dict[str, Any], str, Path]:
    """The TOML document of a scene with the given replacements, the scene's name for messages, and its file.

    Raises:
        SceneError: for a file that cannot be read, and a point of an array that is not two numbers; a plain system has
            one for each state.
    """
    file = str(source) or "''"
    path = _path(source)
    document = _read_toml(path, file)
    if at and at.count(",") != 1 and "system" not in document:
        raise SceneError(file, "check.equilibrium", "two numbers with a comma between them, such as 240,0", at)
    changes: dict[str, dict[str, object]] = {
        "contact": {"rule": None if rule == MIXED else rule},
        "check": {"radius": radius, "equilibrium": at and at.split(","), "accuracy": accuracy},
    }
    return _overridden(document, changes), file, path


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


@contextmanager
def deep_nesting_refused(source: str | Path) -> Iterator[None]:
    """Refuse a document whose nested brackets exhaust the stack.

    Raises:
        SceneError: in place of Python's error.
    """
    try:
        yield
    except RecursionError:
        raise SceneError(str(source), "", "a document with fewer nested brackets", StatedFact("too many")) from None


def _path(source: str | Path) -> Path:
    """File of a scene: built-in names come before files, so that a stray file changes no result."""
    if isinstance(source, str) and source in _BUILTIN:
        return _SCENES / f"{source}.toml"
    if isinstance(source, str) and source in _SYSTEMS:
        return _SCENES / "systems" / f"{source}.toml"
    if isinstance(source, str) and source in _VEHICLES:
        return _SCENES / "vehicles" / f"{source}.toml"
    return Path(source)


def _read_toml(path: Path, file: str) -> dict[str, Any]:
    text = read_text(path, MAX_TOML_BYTES, file, "", _wanted(file))
    excess = toml_excess(text)
    if excess is not None:
        raise SceneError(file, "", excess[0], StatedFact(excess[1]))
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(file, "", "a TOML document", StatedFact(f"an error: {str(error)[:120]}")) from None
    except (ValueError, ArithmeticError):  # of int and Decimal
        raise SceneError(file, "", "numbers of moderate length", StatedFact("one that is too long")) from None


def _wanted(file: str) -> str:
    """What a missing scene should have been."""
    close = get_close_matches(file[:80], (*_BUILTIN, *_SYSTEMS, *_VEHICLES), 2) or _BUILTIN[:2]
    return f"a scene file or a built-in scene such as {' or '.join(close)}"


def _overridden(data: dict[str, Any], changes: Mapping[str, Mapping[str, object]]) -> dict[str, Any]:
    """The document with the command line's values in their places, to be validated like the file's own."""
    for name, values in changes.items():
        given = {key: value for key, value in values.items() if value is not None}
        section = data.get(name, {})
        if given and isinstance(section, dict):
            data = {**data, name: {**section, **given}}
    return data


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
    check = build_check(document, numbers, built)
    hints = (*unit_hints(built, body, check, document.units.labels), *angle_hints(layout.turns(), document.units.angle))
    numbers.field.remarks += tuple(map(FirstRemark, hints))
    _require_mixed(rule, builder.rule, file)
    if rule not in (None, MIXED) and all("contact" in wheel.named for wheel in built):
        numbers.field.remarks += (f"rule {rule} is for wheels that name none, and all of these name their own",)
    return Scene(
        name=document.name or path.stem,
        field=numbers.field,
        wheels=built,
        contact=build_contact(document.contact, builder.rule, numbers, built),
        check=check,
        source=file,
        continuum=build_continuum(document, numbers, built),
        units=document.units.labels,
        body=body,
        inertia=build_inertia(document.body, document.units.labels.metres, numbers),
        tolerances=None if document.tolerances is None else build_tolerance(document.tolerances, numbers),
        loop_errors=None if document.feedback is None else build_loop_errors(document.feedback, numbers),
    )


def _require_mixed(rule: str | None, found: str, file: str) -> None:
    """Refuse rule ``mixed`` of wheels that have one rule: it is what wheels of different rules make."""
    if rule == MIXED != found:
        mixing = " and ".join(sorted(BY_FRICTION_SET))
        raise SceneError(file, "contact.rule", f"wheels of rules {mixing} for rule {MIXED}", StatedFact(f"all {found}"))


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
        key, found = " and ".join(named) or "wheel", StatedFact(f"{len(named)}" if named else "none")
        raise SceneError(file, key, "one of [[wheel]], [ring], [grid], [wheels]", found)
    if document.wheels is not None:
        return parse_wheels(table(), document.wheels.file, file, document.units.angle)
    return document.ring or document.grid or WheelList(document.wheel or [])


def _turns(document: SceneDocument, layout: Layout) -> Iterator[Fraction]:
    yield from layout.turns()
    for table in (document.friction, document.drive, document.field, document.body, document.contact, document.check):
        yield from angles(table)


def _remarks(document: SceneDocument, layout: Layout) -> Iterator[str]:
    """What a reader must know about how the files were read."""
    table = layout if isinstance(layout, WheelRows) else WheelRows("", [], [])
    if table.rows and document.field is None and all(row.own.heading is None for row in table.rows):
        others = "a column heading, or [field], says otherwise"
        yield FirstRemark(f"{table.name} states no heading: all wheels drive toward (0, 0); {others}")
    yield from table.remarks
    yield from angle_remarks([document, table.cells])


# ---- texts of files ------------------------------------------------------------------------------


OUTSIDE_OPTION = "--allow-outside"


def read_text(path: Path, limit: int, file: str, key: str, wanted: str) -> str:
    """Text of a file.

    Args:
        path: the file.
        limit: its largest size (bytes).
        file: the scene, for messages.
        key: the key that names the file, for messages; empty for the scene itself.
        wanted: what a missing file should have been, for messages.

    Raises:
        SceneError: for a missing, unreadable, oversized or binary file.
    """
    try:
        if not path.is_file():
            raise SceneError(file, key, wanted, StatedFact(_kind(path)))
        with path.open("rb") as stream:
            data = stream.read(limit + 1)
        if len(data) > limit:
            raise SceneError(file, key, f"a file of at most {limit >> 20} MB", StatedFact("more"))
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        found = StatedFact(f"other bytes at position {error.start}")
        raise SceneError(file, key, "a text file in UTF-8", found) from None
    except OSError as error:
        raise SceneError(file, key, "a readable file", StatedFact(error.strerror or "an error")) from None


def path_beside(scene: Path, name: str, file: str, key: str, *, allow_outside: bool) -> Path:
    """The file that a scene names, relative to the scene's folder.

    A scene may come from somebody else: without ``allow_outside`` the file must lie in that folder or below it, links
    resolved, and nothing is looked up elsewhere.

    Raises:
        SceneError: for a file outside the folder.
    """
    path = scene.parent / name
    if allow_outside:
        return path
    try:
        target, folder = path.resolve(), scene.parent.resolve()
    except ValueError:  # a null character: no file has such a name
        return path
    except (OSError, RuntimeError):  # links that lead to each other
        raise SceneError(file, key, "a readable file", StatedFact("a path that leads nowhere")) from None
    if not target.is_relative_to(folder):
        expected = f"a file in the scene's folder or below it (or the option {OUTSIDE_OPTION})"
        raise SceneError(file, key, expected, StatedFact("a path that leads outside"))
    return target


def _kind(path: Path) -> str:
    if path.is_dir():
        return "a directory"
    return "something that is no regular file" if path.exists() else "no such file"


# ---- bounds of TOML ------------------------------------------------------------------------------
#
# The parser of the standard library takes time that grows with the square of the number of parts of a dotted key, and a
# stack that grows with the depth of brackets.  A scene needs three of either.


MAX_PARTS = 16  # of a dotted key
MAX_NESTING = 64  # of brackets

# Strings and comments, each to its end or, where that is missing, to where the parser would give up.  Possessive, so
# that no character is looked at twice.
_OPAQUE = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*+(?:"{3,5})?'
    r"|'''(?:[^']|'(?!''))*+(?:'{3,5})?"
    r'|"(?:[^"\\\n]|\\[^\n])*+"?'
    r"|'[^'\n]*+'?"
    r"|#[^\n]*+",
    re.DOTALL,
)
_STRUCTURE = re.compile(r"[\n=,\[\]{}]")


def toml_excess(text: str) -> tuple[str, str] | None:
    """What a document must keep to and what this one holds; None where it keeps to both bounds."""
    bare = _OPAQUE.sub("", text)
    parts = 1 + max(piece.count(".") for piece in _STRUCTURE.split(bare))
    if parts > MAX_PARTS:
        return f"keys of at most {MAX_PARTS} parts", f"one of {parts}"
    depth = deepest = 0
    for bracket in re.findall(r"[\[\]{}]", bare):
        depth = depth + 1 if bracket in "[{" else max(depth - 1, 0)
        deepest = max(deepest, depth)
    if deepest > MAX_NESTING:
        return f"a document with fewer nested brackets (at most {MAX_NESTING})", f"{deepest}"
    return None
