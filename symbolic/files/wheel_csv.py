"""A CSV table of wheels: ``x,y`` and, where wanted, ``heading,speed,mu_roll,mu_side``.

Empty cells name nothing.  Equal cells are read once, and plain decimals never reach the formula
parser, so ten thousand wheels take a fraction of a second.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any, NamedTuple

from nonsmooth.symbolic.files.layouts import MAX_WHEELS, Own, Place
from nonsmooth.symbolic.files.scene_values import Exact, Numbers, angles, read_exact
from nonsmooth.symbolic.files.velocity_fields import Heading, read_heading
from nonsmooth.symbolic.scene_error import SceneError, StatedFact, requirement


def _heading_cell(text: str) -> Heading:
    """A heading as in a scene file; a direction is one quoted cell, "[a, b]"."""
    if text.startswith("[") and text.endswith("]"):
        return read_heading([part.strip() for part in text[1:-1].split(",")])
    return read_heading(text)


_COLUMNS: dict[str, Callable[[str], Any]] = {
    "x": read_exact,
    "y": read_exact,
    "heading": _heading_cell,
    "speed": read_exact,
    "mu_roll": read_exact,
    "mu_side": read_exact,
}


_COLUMN_NAME = re.compile(r"[A-Za-z][A-Za-z_]{0,19}")


class _Row(NamedTuple):
    line: int
    x: Exact
    y: Exact
    own: Own


class WheelRows(NamedTuple):
    """The wheels of a table, in the order of its lines."""

    name: str
    rows: list[_Row]
    cells: list[object]  # every different value, for the angles

    def turns(self) -> Iterator[Fraction]:
        """See :class:`nonsmooth.symbolic.files.layouts.Layout`."""
        return angles(self.cells)

    def places(self, numbers: Numbers) -> Iterator[Place]:
        """See :class:`nonsmooth.symbolic.files.layouts.Layout`."""
        for row in self.rows:
            key = f"{self.name}:{row.line}"
            yield Place(key, (numbers(row.x, f"{key}.x"), numbers(row.y, f"{key}.y")), row.own)


class _Cells:
    """Reads cells; equal texts of a column become one value."""

    def __init__(self, file: str, name: str, columns: list[str]) -> None:
        self.file, self.name, self.columns = file, name, columns
        self.known: dict[str, dict[str, Any]] = {column: {} for column in columns}

    def row(self, line: int, cells: list[str]) -> _Row:
        """One wheel.

        Raises:
            SceneError: naming the line and the column.
        """
        if len(cells) != len(self.columns):
            raise self.error(line, "", f"{len(self.columns)} cells", StatedFact(f"{len(cells)}"))
        values = {c: self.value(line, c, t.strip()) for c, t in zip(self.columns, cells, strict=True) if t}
        for column in ("x", "y"):
            if values.get(column) is None:
                raise self.error(line, column, "a number", StatedFact("an empty cell"))
        x, y = values.pop("x"), values.pop("y")
        return _Row(line, x, y, Own(**values))

    def value(self, line: int, column: str, text: str) -> Any:
        """Value of a cell, None where it is blank."""
        known = self.known[column]
        if text not in known:
            try:
                known[text] = _COLUMNS[column](text) if text else None
            except ValueError as error:
                raise self.error(line, column, requirement(error), text) from None
        return known[text]

    def error(self, line: int, column: str, expected: str, value: object) -> SceneError:
        key = f"{self.name}:{line}.{column}" if column else f"{self.name}:{line}"
        return SceneError(self.file, key, expected, value)


def parse_wheels(text: str, name: str, file: str) -> WheelRows:
    """Wheels of a CSV text; ``name`` and ``file`` (the scene) are for messages.

    Raises:
        SceneError: for unknown columns, short rows and cells that are no numbers.
    """
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        columns = [column.strip() for column in next(reader, [])]
        _check_columns(columns, name, file)
        cells = _Cells(file, name, columns)
        rows = []
        for line in reader:
            if line:
                rows.append(cells.row(reader.line_num, line))
            if len(rows) > MAX_WHEELS:
                raise SceneError(file, name, f"at most {MAX_WHEELS} wheels", StatedFact("more"))
    except csv.Error as error:
        raise SceneError(file, f"{name}:{reader.line_num}", "a CSV table", StatedFact(str(error))) from None
    return WheelRows(name, rows, [value for known in cells.known.values() for value in known.values()])


def _check_columns(columns: list[str], name: str, file: str) -> None:
    """Refuse a header that is none; of a file that is no table at all, nothing is shown but a name."""
    known = ",".join(_COLUMNS)
    for k, column in enumerate(columns):
        if column not in _COLUMNS:
            found = column if _COLUMN_NAME.fullmatch(column) else StatedFact("a cell that is no name of a column")
            raise SceneError(file, f"{name}:1", f"a header out of {known}", found)
        if column in columns[:k]:
            raise SceneError(file, f"{name}:1", "each column once", column)
    missing = " and ".join(column for column in ("x", "y") if column not in columns)
    if missing:
        raise SceneError(file, f"{name}:1", "a header with x and y", StatedFact(f"one without {missing}"))
