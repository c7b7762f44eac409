"""Entries of a scene file: what Python hands over, read as one holds it, and written as JSON and TOML.

A float means its shortest decimal: ``0.1`` is one tenth.  Fractions, SymPy numbers and texts mean what they say; a text
is a formula such as ``"sqrt(2)/2"`` and is never evaluated as code.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from decimal import Decimal
from fractions import Fraction
from numbers import Integral, Real
from typing import Any, TypeAlias

from nonsmooth.symbolic.numbers.number import Number

Entry: TypeAlias = Any  # a number, a formula, a list of entries, or a table


def entry(value: Any) -> Entry:
    """The value as a scene file would hold it."""
    if value is None or isinstance(value, bool | str | Decimal):
        return value
    if isinstance(value, Mapping):
        return table(value)
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Fraction | Number):
        return str(value)
    if isinstance(value, Real):
        return Decimal(repr(float(value)))
    if getattr(value, "ndim", None) == 0:  # an array of one number, as NumPy and xarray have it
        return entry(value.item())
    if isinstance(value, Iterable):
        return [entry(part) for part in value]
    return str(value)  # a SymPy number prints as a formula


def as_json(value: Entry) -> Entry:
    """An entry as JSON holds it: a decimal as a number where a float holds it exactly, else as a text."""
    match value:
        case Decimal():
            return float(value) if Decimal(repr(float(value))) == value else str(value)
        case list() | tuple():
            return [as_json(part) for part in value]
        case Mapping():
            return {str(key): as_json(part) for key, part in value.items()}
    return value


def table(values: Mapping[str, Any]) -> dict[str, Entry]:
    """A table of entries without those that are None."""
    return {key: entry(value) for key, value in values.items() if value is not None}


# ---- as TOML -------------------------------------------------------------------------------------
#
# A scene document as TOML text: strings, numbers, lists and tables, nothing else.


def toml_text(document: Mapping[str, Any]) -> str:
    """The text that reads as the document again.

    Raises:
        TypeError: for a value that no scene has.
    """
    lines = [f"{key} = {_written(value)}" for key, value in document.items() if not _is_table(value)]
    for key, value in document.items():
        if isinstance(value, Mapping):
            lines += ["", f"[{key}]", *_lines(value)]
        elif _is_table(value):
            for table in value:
                lines += ["", f"[[{key}]]", *_lines(table)]
    return "\n".join(lines).lstrip("\n") + "\n"


def _is_table(value: object) -> bool:
    """Whether it is written under a header of its own."""
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and isinstance(value[0], Mapping))


def _lines(table: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {_written(value)}" for key, value in table.items()]


def _written(value: Any) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case int() | Decimal():
            return str(value)
        case float():
            return repr(value)
        case str():
            return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")  # JSON's escapes, and one more
        case list() | tuple():
            return f"[{', '.join(map(_written, value))}]"
        case Mapping():
            return f"{{ {', '.join(f'{key} = {_written(entry)}' for key, entry in value.items())} }}"
    raise TypeError(f"required a string, a number, a list or a table, received {type(value).__name__}")
