"""Key paths of scene files: ``friction.mu_side``, ``wheel.1.heading``, ``wheel.2.position.x``.

A path names one number of a document.  Tables and keys are joined by dots; wheels and all else in lists are counted
from 1 as in messages; a wheel may be called by its name, ``wheel.M2.heading``.  The two numbers of a position or a
direction are its ``x`` and ``y``, those of a row of loads ``c0``, ``cx`` and ``cy``; of a plain system the ends of an
interval are ``low`` and ``high``, and those of the point that is checked have the names of its states.  A key that only
one table has may stand alone: ``mu_side`` is ``friction.mu_side``.  Which numbers there are is read from the tables of
:mod:`nonsmooth.symbolic.files.scene_document`, and from the document where it holds lists.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from fractions import Fraction
from types import UnionType
from typing import Annotated, Any, TypeAlias, Union, get_args, get_origin

from nonsmooth.symbolic.files.layouts import Uniform
from nonsmooth.symbolic.files.scene_document import SceneDocument
from nonsmooth.symbolic.files.scene_values import Angle, TomlTable, keys_of, tables_in
from nonsmooth.symbolic.formulas.expression import Expression
from nonsmooth.symbolic.messages.scene_error import MAX_SHOWN, SceneError

Step: TypeAlias = str | int  # a key, or the place in a list counted from 0
Path: TypeAlias = tuple[Step, ...]

PARAMETERS = ("system", "parameters")  # of a plain system: named alone
POINT = ("check", "equilibrium")
ENDS = ("low", "high")  # of a parameter's interval
COORDINATES = ("x", "y")  # of a position or a direction
LOADS, ROW = ("contact", "loads"), ("c0", "cx", "cy")  # loads of one wheel, row by row
COUNTED = (*LOADS, "values")  # as many numbers as there are wheels
PLACED = (*LOADS, "at")
NEVER_ALONE = ("tolerance",)  # tables whose keys other tables have: they are always named
DIRECTION = "heading"
MATCHES, LIKENESS, LISTED = 3, 0.5, 6  # near matches of an unknown path, how near (difflib), else so many examples


def find_path(text: str, document: Mapping[str, Any], file: str) -> Path:
    """The place in a document that a key path names.

    Args:
        text: such as ``friction.mu_side`` or ``mu_side``.
        document: the tables of a scene file.
        file: the scene, for messages.

    Raises:
        SceneError: for a path that names no number of this scene; the message lists near ones.
    """
    paths = {path_text(path, document): path for path in numeric_paths(document)}
    names = {str(wheel.get("name")): number for number, wheel in enumerate(document.get("wheel", ()), 1)}
    table, _, rest = text.partition(".")
    name, _, key = rest.partition(".")
    if text not in paths and table == "wheel" and name in names:
        text = f"wheel.{names[name]}.{key}"
    if text in paths:
        return paths[text]
    alone = {
        name: ".".join(name.split(".")[2 if path[:2] == PARAMETERS else 1 :])
        for name, path in paths.items()
        if not isinstance(path[1], int) and path[0] not in NEVER_ALONE
    }
    ends = [name for name, key in alone.items() if key == text]
    if len(ends) == 1:
        return paths[ends[0]]
    near = ends or get_close_matches(text[:MAX_SHOWN], [*paths, *alone.values()], MATCHES, LIKENESS)
    near = list(dict.fromkeys(near)) or list(paths)[:LISTED]
    raise SceneError(file, "", f"the key path of a number, such as {' or '.join(near)}", text)


def path_text(path: Path, document: Mapping[str, Any]) -> str:
    """``wheel.2.position.x``.

    Args:
        path: one of :func:`numeric_paths`.
        document: the tables of the scene file.
    """
    words = [str(step + 1 if isinstance(step, int) else step) for step in path]
    last = path[-1]
    if isinstance(last, int):
        names = _entry_names(path[:-1], document)
        words[-1] = names[last] if last < len(names) else words[-1]
    return ".".join(words)


def _entry_names(path: Path, document: Mapping[str, Any]) -> Sequence[str]:
    """What the numbers of a list are called; none where they are counted."""
    if path[: len(PARAMETERS)] == PARAMETERS:
        return ENDS
    if "system" in document:
        return [str(name) for name in document["system"]["states"]]
    if path == COUNTED:
        return []
    return ROW if path[: len(LOADS)] == LOADS and path != PLACED else COORDINATES


def with_value(document: Mapping[str, Any], path: Path, value: object) -> dict[str, Any]:
    """The document with another value at a path; the other entries are shared with the first.

    Args:
        document: the tables of a scene file.
        path: what :func:`find_path` returned.
        value: as a scene file would hold it.
    """
    states = _states_of(document)
    changed: dict[str, Any] = _replaced(document, path, value, [0] * (len(states) or 2))
    return changed


def numeric_paths(document: Mapping[str, Any]) -> Iterator[Path]:
    """Every number of a scene that can be set: those of its tables, whether it states them or not."""
    if "system" in document:
        yield from _of_system(document)
        return
    for name, field in keys_of(SceneDocument).items():
        tables = list(tables_in(field.annotation))
        value = document.get(name)
        if isinstance(value, list):
            for k, entry in enumerate(value):
                yield from _of_table(tables, entry, (name, k))
        elif tables and (value is not None or field.default is not None):
            yield from _of_table(tables, value or {}, (name,))


def _of_system(document: Mapping[str, Any]) -> Iterator[Path]:
    """The parameters of a plain system, and what is checked."""
    system = document["system"] if isinstance(document["system"], Mapping) else {}
    parameters, states = system.get("parameters"), _states_of(document)
    for name, value in (parameters if isinstance(parameters, Mapping) else {}).items():
        yield from _inside(value, (*PARAMETERS, str(name)))
    yield "check", "radius"
    check = document.get("check")
    point = check.get("equilibrium") if isinstance(check, Mapping) else None
    if point is None or (isinstance(point, list) and len(point) == len(states)):
        yield from ((*POINT, k) for k in range(len(states)))


def _states_of(document: Mapping[str, Any]) -> list[Any]:
    """The names of the states of a plain system; none of an array, and of a document without a list of them."""
    system = document.get("system")
    states = system.get("states") if isinstance(system, Mapping) else None
    return states if isinstance(states, list) else []


# ---- which numbers there are ---------------------------------------------------------------------


def _of_table(tables: Sequence[type[TomlTable]], values: object, path: Path) -> Iterator[Path]:
    """The numbers of one table; of several kinds, of the one that it names."""
    if not isinstance(values, Mapping):
        return
    table = _of_kind(tables, values)
    for key, field in table.model_fields.items():
        place, value = (*path, key), values.get(key)
        if isinstance(value, list | Mapping):
            yield from _inside(value, place)
            if key == DIRECTION:  # an angle may stand in place of its two entries
                yield place
        elif _is_pair(field.annotation):
            yield from ((*place, k) for k in (0, 1) if value is not None or field.default is not None)
        elif _holds_number(field.annotation):
            yield place


def _of_kind(tables: Sequence[type[TomlTable]], values: Mapping[str, object]) -> type[TomlTable]:
    """The table whose ``kind`` is the given one."""
    kinds = {table.model_fields["kind"].default: table for table in tables if "kind" in table.model_fields}
    return kinds.get(values.get("kind"), tables[0])


def _inside(value: object, path: Path) -> Iterator[Path]:
    """The numbers inside a list or an inner table that the document states."""
    if isinstance(value, Mapping):
        for key, entry in value.items():
            if key != "kind":
                yield from _inside(entry, (*path, str(key)))
    elif isinstance(value, list):
        for k, entry in enumerate(value):
            yield from _inside(entry, (*path, k))
    else:
        yield path


def _holds_number(annotation: Any) -> bool:
    """Whether a number may stand there: a formula, an angle, a direction by its angle, or an integer."""
    return any(kind in (Fraction, Expression, Angle, Uniform, int) for kind in _kinds(annotation))


def _is_pair(annotation: Any) -> bool:
    """Whether two numbers stand there."""
    return any(get_origin(kind) is tuple and len(get_args(kind)) == 2 for kind in _kinds(annotation))


def _kinds(annotation: Any) -> Iterator[Any]:
    """The annotation itself and, through unions and notes, the kinds of values that it joins."""
    yield annotation
    if get_origin(annotation) in (Annotated, Union, UnionType):
        for inner in get_args(annotation):
            yield from _kinds(inner)


# ---- setting one ---------------------------------------------------------------------------------


def _replaced(value: Any, path: Path, new: object, origin: Sequence[int]) -> Any:
    """The value with another entry; of a place that is not stated, the origin."""
    if not path:
        return new
    step, rest = path[0], path[1:]
    if isinstance(step, int):
        entries = list(value) if value is not None else list(origin)
        entries[step] = _replaced(entries[step], rest, new, origin)
        return entries
    table = dict(value or {})
    table[step] = _replaced(table.get(step), rest, new, origin)
    return table
