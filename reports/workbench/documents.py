"""Documents: scenes as the page holds them, tables of JSON with the tables and keys of a scene file.

A number is a JSON number where a float holds it exactly, else a text, so that no digit is lost on the way through the
page.  No document names a file: a table of wheels is written out, wheel by wheel, with exact texts.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.reports.output.entries import as_json, toml_text
from nonsmooth.reports.workbench.requests import RequestError
from nonsmooth.symbolic.files.documents import read_document, toml_excess
from nonsmooth.symbolic.files.scene_file import wheel_table
from nonsmooth.symbolic.files.wheel_csv import parse_wheels

if TYPE_CHECKING:
    from nonsmooth.reports.interface.array import Array
    from nonsmooth.reports.interface.scene import PythonScene
    from nonsmooth.reports.interface.system import System

Document: TypeAlias = dict[str, Any]

MAX_WHEELS = 400  # a page of more is no longer a picture, and no check of it ends within a blink
MAX_FORMULA = 400  # characters, as scene files allow
LARGEST_INTEGER = 2**53  # up to which a browser counts
LAYOUTS = ("ring", "grid", "wheels")  # what a list of wheels replaces


def opened(document: Mapping[str, Any]) -> Array | System:
    """The array or plain system of a document.

    Raises:
        RequestError: for a document of another kind, one that names a file, and one of too many wheels.
        SceneError: for whatever cannot be used.
    """
    from nonsmooth.reports.interface.array import Array
    from nonsmooth.reports.interface.system import System

    _require_moderate(document)
    if "system" in document:
        return System.of_document(document)
    return Array.of_document(document)


def _require_moderate(document: Mapping[str, Any]) -> None:
    """Refuse what would open a file, and arrays that are too large, before anything is computed."""
    if "vehicle" in document:
        raise RequestError("vehicle: required an array of wheels or a plain system, received a vehicle", "vehicle")
    if "wheels" in document:
        raise RequestError("wheels: required wheels one by one, received the name of a file", "wheels")
    for key, count in _counts(document):
        if count > MAX_WHEELS:
            raise RequestError(f"{key}: required at most {MAX_WHEELS} wheels, received {count}", key)


def _counts(document: Mapping[str, Any]) -> list[tuple[str, int]]:
    """How many wheels each layout of the document has, as far as that is a number."""
    ring, grid, wheels = (document.get(name) for name in ("ring", "grid", "wheel"))
    counts = [("wheel", len(wheels))] if isinstance(wheels, list) else []
    if isinstance(ring, Mapping) and isinstance(ring.get("count"), int):
        counts.append(("ring", ring["count"]))
    if isinstance(grid, Mapping):
        rows, columns = grid.get("rows"), grid.get("columns")
        if isinstance(rows, int) and isinstance(columns, int):
            counts.append(("grid", rows * columns))
    return counts


# ---- as JSON and as TOML -------------------------------------------------------------------------


def canonical(value: Any) -> Any:
    """The value as a document holds it: integers, floats without a digit lost, texts, lists and tables.

    Raises:
        RequestError: for a value that no scene has, such as a date.
    """
    match value:
        case bool() | str():
            return value
        case int():
            return value if abs(value) <= LARGEST_INTEGER else str(value)
        case Decimal() | float():
            return _number(value if isinstance(value, Decimal) else Decimal(repr(value)))
        case list() | tuple():
            return [canonical(part) for part in value]
        case Mapping():
            return {str(key): canonical(part) for key, part in value.items()}
    raise RequestError(f"required numbers, texts, lists and tables, received {type(value).__name__}")


def _number(value: Decimal) -> Any:
    if not value.is_finite() or abs(value.adjusted()) > 300:
        return str(value)
    if value == value.to_integral_value() and abs(value) <= LARGEST_INTEGER:
        return int(value)
    return as_json(value)


def written(document: Mapping[str, Any]) -> str:
    """The document as a scene file; what this wrote, read again, is written byte for byte alike."""
    return toml_text(canonical(document))


def read_toml(text: str) -> Document:
    """The document of the text of a scene file.

    Raises:
        RequestError: for a text that is no TOML.
    """
    excess = toml_excess(text)
    if excess is not None:
        raise RequestError(f"file: required {excess[0]}, received {excess[1]}")
    try:
        return dict(canonical(tomllib.loads(text, parse_float=Decimal)))
    except tomllib.TOMLDecodeError as error:
        raise RequestError(f"file: required a TOML document, received an error: {str(error)[:120]}") from None
    except RequestError:
        raise
    except (ValueError, ArithmeticError):
        raise RequestError("file: required numbers of moderate length") from None
    except RecursionError:
        raise RequestError("file: required fewer nested brackets") from None


# ---- built-in scenes and files of the command line -----------------------------------------------


def document_of(source: str | Path) -> Document:
    """The document of a built-in scene, or of a file that the command line names; its wheels one by one.

    Raises:
        SceneError: for whatever cannot be used.
        RequestError: for a vehicle, and for too many wheels.
    """
    from nonsmooth.reports.interface.array import Array

    tables, _, path = read_document(source)
    named = {"name": path.stem, **tables}
    if "system" in named or "vehicle" in named:
        _ = opened(named)
        return dict(canonical(named))
    return expanded(named, Array.of_document(named, path.parent))


def expanded(document: Mapping[str, Any], made: PythonScene) -> Document:
    """The document of a scene, with the wheels of an array one by one: the same scene exactly.

    Numbers and angles of a table of wheels stay as they are.

    Raises:
        RequestError: for too many wheels.
    """
    if not any(layout in document for layout in LAYOUTS):
        return dict(canonical(document))
    scene = made.exact
    wheels = scene.wheels
    if len(wheels) > MAX_WHEELS:
        raise RequestError(f"required at most {MAX_WHEELS} wheels, received {len(wheels)}")
    table = wheel_table(document, *made.origin)
    if table is None:
        tables: list[Document] = [{"position": _pair(wheel.position)} for wheel in wheels]
    else:
        tables = parse_wheels(table, "wheels", "").documents()
    out: Document = {}
    for key, value in document.items():
        out.update({"wheel": tables} if key in LAYOUTS else {key: value})
    return dict(canonical(out))


def _pair(vector: tuple[Any, Any]) -> list[Any]:
    return [short_entry(value) for value in vector]


def short_entry(number: Any) -> Any:
    """An exact number as a document holds it: an integer where it is one, else its exact text."""
    rational = number.as_rational()
    return int(rational) if rational is not None and rational.q == 1 else str(number)
