"""A table of wheels, as CSV or as a data frame: ``x,y`` and, where wanted, other names in ``COLUMNS``, in any order.

The first column of ``NAMES`` holds what the wheels are called wherever something is said of them.
Cells are separated by commas, semicolons or tabs; lines that begin with ``#`` are comments; other columns are not read,
and a note says so.  Empty cells name nothing.  Equal cells are read once, and plain decimals never reach the formula
parser, so ten thousand wheels take a fraction of a second.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from typing import Any, NamedTuple

from nonsmooth.symbolic.files.layouts import MAX_WHEELS, Heading, WheelOverrides, WheelPlace, read_heading, read_name
from nonsmooth.symbolic.files.scene_values import Exact, Numbers, angles, read_exact
from nonsmooth.symbolic.mechanics.rule import read_rule
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, is_meant, requirement

COLUMNS = ("x", "y", "heading", "speed", "mu_roll", "mu_side", "speed_limit", "axis", "contact")
NAMES = ("name", "wheel", "roller", "motor", "label", "number", "id", "nr", "no")
WORDS = (NAMES[0], "contact")  # columns without numbers
DIRECTIONS = ("heading", "axis")
SEPARATORS = (",", ";", "\t")
MOST_SHOWN = 4  # columns that a note lists
MAX_COLUMNS = 200
MAX_NAME = 30  # characters of a column's name that a message shows
_LIKE_HEADING = re.compile(  # what others call a heading, also with a unit behind it, as angle_deg or angle [deg]
    r"(angle|azimuth|dir|direction|orientation|phi|psi|richtung|rot|rotation|theta|winkel|yaw)([^a-z].*)?", re.I
)
_DECIMAL_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+([eE][+-]?[0-9]+)?")


class _Row(NamedTuple):
    line: int
    x: Exact
    y: Exact
    overrides: WheelOverrides
    name: str
    texts: dict[str, str]  # the cells that are not blank, by their columns


class WheelRows(NamedTuple):
    """The wheels of a table, in the order of its lines."""

    name: str
    rows: list[_Row]
    cells: list[object]  # every different value, for the angles
    ignored: tuple[str, ...] = ()  # names of columns that are not read

    def turns(self) -> Iterator[Fraction]:
        """See :class:`nonsmooth.symbolic.files.layouts.Layout`."""
        return angles(self.cells)

    def places(self, numbers: Numbers) -> Iterator[WheelPlace]:
        """See :class:`nonsmooth.symbolic.files.layouts.Layout`."""
        for row in self.rows:
            key = f"{self.name}:{row.line}"
            yield WheelPlace(key, (numbers(row.x, f"{key}.x"), numbers(row.y, f"{key}.y")), row.overrides, row.name)

    def documents(self) -> list[dict[str, Any]]:
        """The wheels one by one, as tables ``[[wheel]]`` of a scene file: numbers and angles as they are."""
        tables = []
        for row in self.rows:
            texts = dict(row.texts)
            position = [_written(texts.pop("x")), _written(texts.pop("y"))]
            settings = {column: text if column in WORDS else _written(text) for column, text in texts.items()}
            tables.append({"position": position, **settings})
        return tables

    @property
    def remarks(self) -> tuple[str, ...]:
        """What of the table was not read."""
        if not self.ignored:
            return ()
        more = [f"{len(self.ignored) - MOST_SHOWN} more"] * (len(self.ignored) > MOST_SHOWN)
        return (f"columns of the table of wheels that are not read: {', '.join([*self.ignored[:MOST_SHOWN], *more])}",)


class _Cells:
    """Reads cells; equal texts of a column become one value."""

    def __init__(self, file: str, name: str, columns: list[str | None], separator: str, unit: AngleUnit | None) -> None:
        self.file, self.name, self.columns, self.separator, self.unit = file, name, columns, separator, unit
        self.known: dict[str, dict[str, Any]] = {column: {} for column in columns if column is not None}

    def row(self, line: int, cells: list[str]) -> _Row:
        """One wheel.

        Raises:
            SceneError: naming the line and the column.
        """
        if len(cells) != len(self.columns):
            raise self.error(line, "", self._wanted_cells(len(cells)), StatedFact(f"{len(cells)}"))
        values = {c: self.value(line, c, t.strip()) for c, t in zip(self.columns, cells, strict=True) if t and c}
        for column in ("x", "y"):
            if values.get(column) is None:
                raise self.error(line, column, "a number", StatedFact("an empty cell"))
        x, y = values.pop("x"), values.pop("y")
        name = values.pop(NAMES[0], None) or ""
        texts = {c: t.strip() for c, t in zip(self.columns, cells, strict=True) if c and t.strip()}
        return _Row(line, x, y, WheelOverrides(**values), name, texts)

    def value(self, line: int, column: str, text: str) -> Any:
        """Value of a cell, None where it is blank."""
        values = self.known[column]
        if text not in values:
            try:
                values[text] = self._read(column, text) if text else None
            except ValueError as error:
                raise self.error(line, column, requirement(error), text) from None
        return values[text]

    def _read(self, column: str, text: str) -> Heading | Exact | str:
        """A number, a contact rule, or a heading as in a scene file; a direction is one quoted cell, "[a, b]"."""
        if column == "contact":
            return read_rule(text)
        if column == NAMES[0]:
            return read_name(text)
        if _DECIMAL_COMMA.fullmatch(text):
            raise ValueError("required a decimal point instead of a comma")
        if column not in DIRECTIONS:
            return read_exact(text)
        entries = _entries(text)
        return read_heading(text, self.unit) if entries is None else read_heading(entries)

    def _wanted_cells(self, count: int) -> str:
        """What a row must have; decimal commas make more cells where commas separate them."""
        too_many = self.separator == "," and count > len(self.columns)
        return f"{len(self.columns)} cells" + " (decimals with a point, not a comma)" * too_many

    def error(self, line: int, column: str, expected: str, value: object) -> SceneError:
        key = f"{self.name}:{line}.{column}" if column else f"{self.name}:{line}"
        return SceneError(self.file, key, expected, value)


def parse_wheels(text: str, name: str, file: str, unit: AngleUnit | None = None) -> WheelRows:
    """Wheels of a CSV text.

    Args:
        text: of the table.
        name: of the table, for messages.
        file: the scene, for messages.
        unit: of headings that name none.

    Raises:
        SceneError: for a header without x and y, misspelt columns, short rows and cells that are no numbers.
    """
    separator = _separator(text)
    reader = csv.reader(_uncommented(text), strict=True, delimiter=separator)
    try:
        header = next(filter(None, reader), [])
        columns = _columns(header, f"{name}:{max(reader.line_num, 1)}", file)
        cells = _Cells(file, name, columns, separator, unit)
        rows = []
        for line in reader:
            if line:
                rows.append(cells.row(reader.line_num, line))
            if len(rows) > MAX_WHEELS:
                raise SceneError(file, name, f"at most {MAX_WHEELS} wheels", StatedFact("more"))
    except csv.Error as error:
        raise SceneError(file, f"{name}:{reader.line_num}", "a CSV table", StatedFact(str(error))) from None
    values = [value for column in cells.known.values() for value in column.values()]
    return WheelRows(name, rows, values, _unread(header, columns))


def _entries(text: str) -> list[str] | None:
    """The entries of a direction, "[a, b]"; None for any other cell."""
    if text.startswith("[") and text.endswith("]"):
        return [part.strip() for part in text[1:-1].split(",")]
    return None


def _written(text: str) -> Any:
    """The value of a scene file for a cell: a number where the cell is one, two entries of a direction, else a text."""
    entries = _entries(text)
    if entries is not None:
        return list(map(_written, entries))
    try:
        value = Decimal(text)
    except InvalidOperation:
        return text
    return value if value.is_finite() else text


def _uncommented(text: str) -> Iterator[str]:
    """The lines of a table; comments are empty, so that lines keep their numbers."""
    return ("\n" if line.lstrip().startswith("#") else line for line in io.StringIO(text, newline=""))


def _separator(text: str) -> str:
    """The first separator by which the header has columns x and y; a comma where none does."""
    header = next((line for line in _uncommented(text) if line.strip()), "")
    for separator in SEPARATORS:
        names = {_plain(cell.strip().strip('"')) for cell in header.split(separator)}
        if {"x", "y"} <= names:
            return separator
    return SEPARATORS[0]


def _plain(cell: str) -> str:
    """A name of a column, whatever its letters' case."""
    return cell.strip().lower()


def _columns(header: list[str], key: str, file: str) -> list[str | None]:
    """The known columns in the order of the header, None for each other one.

    Nothing is shown of a file that is no table of wheels.
    """
    if len(header) > MAX_COLUMNS:
        raise SceneError(file, key, f"at most {MAX_COLUMNS} columns", StatedFact(f"{len(header)}"))
    named = min((NAMES.index(name) for name in map(_plain, header) if name in NAMES), default=None)
    called = None if named is None else NAMES[named]
    columns = [NAMES[0] if name == called else name if name in COLUMNS else None for name in map(_plain, header)]
    for k, column in enumerate(columns):
        if column is not None and column in columns[:k]:
            raise SceneError(file, key, "each column once", column)
    missing = [column for column in COLUMNS if column not in columns]
    required = " and ".join(column for column in ("x", "y") if column in missing)
    if required:
        raise SceneError(file, key, "a header with x and y, without units", StatedFact(f"one without {required}"))
    for name in _unread(header, columns):
        is_heading = "heading" in missing and _LIKE_HEADING.fullmatch(name)
        meant = " (is heading meant?)" if is_heading else is_meant(name, missing)
        if meant:
            raise SceneError(file, key, f"a header out of {','.join(COLUMNS)}{meant}", name)
    return columns


def _unread(header: list[str], columns: list[str | None]) -> tuple[str, ...]:
    """Names of the columns that are not read, as far as they are names."""
    cells = [cell.strip() for cell, column in zip(header, columns, strict=True) if column is None]
    return tuple(cell if _is_name(cell) else "(no name)" for cell in cells if cell)


def _is_name(cell: str) -> bool:
    return len(cell) <= MAX_NAME and cell.isprintable()


# ---- a data frame --------------------------------------------------------------------------------
#
# Wheels of a data frame, read cell by cell as those of a CSV file are.


DATA_FRAME = "table"  # what messages call one


def wheels_of_table(table: Any) -> list[dict[str, Any]]:
    """The wheels one by one, as tables ``[[wheel]]`` of a scene file.

    Args:
        table: a data frame of pandas or polars, or a mapping from names of columns to their entries.

    Raises:
        SceneError: for a table that is none, columns of different lengths, and whatever cannot be read.
    """
    names = [str(name) for name in (table if isinstance(table, Mapping) else getattr(table, "columns", ()))]
    columns = [list(_column_of(table[name], name)) for name in names]
    if not columns or len({len(column) for column in columns}) != 1:
        received = "none" if not columns else f"columns of {', '.join(str(len(column)) for column in columns)}"
        raise SceneError(DATA_FRAME, "", "columns of one length, x and y among them", StatedFact(received))
    stream = io.StringIO()
    rows = ([_cell_of(value) for value in row] for row in zip(*columns, strict=True))
    csv.writer(stream, lineterminator="\n").writerows([names, *rows])
    return parse_wheels(stream.getvalue(), DATA_FRAME, "Array.from_table").documents()


def _column_of(column: Any, name: str) -> Iterable[Any]:
    if isinstance(column, str) or not isinstance(column, Iterable):
        raise SceneError(DATA_FRAME, name, "a list of entries", column)
    return column


def _cell_of(value: Any) -> str:
    """A cell of a CSV file: empty where nothing is stated; two entries of a direction in brackets."""
    if value is None or value != value or str(value) == "<NA>":  # noqa: PLR0124 - NaN alone is not itself
        return ""
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(str, value))}]"
    return str(value)
