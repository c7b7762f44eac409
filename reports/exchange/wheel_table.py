"""Wheels of a data frame, read cell by cell as those of a CSV file are."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from typing import Any

from nonsmooth.symbolic.files.wheel_csv import parse_wheels
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact

TABLE = "table"  # what messages call it


def wheels_of_table(table: Any) -> list[dict[str, Any]]:
    """The wheels one by one, as tables ``[[wheel]]`` of a scene file.

    Args:
        table: a data frame of pandas or polars, or a mapping from names of columns to their entries.

    Raises:
        SceneError: for a table that is none, columns of different lengths, and whatever cannot be read.
    """
    names = [str(name) for name in (table if isinstance(table, Mapping) else getattr(table, "columns", ()))]
    columns = [list(_entries(table[name], name)) for name in names]
    if not columns or len({len(column) for column in columns}) != 1:
        received = "none" if not columns else f"columns of {', '.join(str(len(column)) for column in columns)}"
        raise SceneError(TABLE, "", "columns of one length, x and y among them", StatedFact(received))
    stream = io.StringIO()
    rows = ([_cell(value) for value in row] for row in zip(*columns, strict=True))
    csv.writer(stream, lineterminator="\n").writerows([names, *rows])
    return parse_wheels(stream.getvalue(), TABLE, "Array.from_table").documents()


def _entries(column: Any, name: str) -> Iterable[Any]:
    if isinstance(column, str) or not isinstance(column, Iterable):
        raise SceneError(TABLE, name, "a list of entries", column)
    return column


def _cell(value: Any) -> str:
    """A cell of a CSV file: empty where nothing is stated; two entries of a direction in brackets."""
    if value is None or value != value or str(value) == "<NA>":  # noqa: PLR0124 - NaN alone is not itself
        return ""
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(str, value))}]"
    return str(value)
