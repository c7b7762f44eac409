"""A result: what a study has found, said once in four ways, from which every output follows.

| a result says | what follows |
| --- | --- |
| ``facts()``: a record with stable keys | JSON, ``to_dict()`` |
| ``table()``: columns and rows | CSV, Parquet, ``rows()``, a data frame of pandas |
| ``draw(ax)``: a picture on axes | ``plot()``; SVG, PNG and PDF files, where ``figure()`` may lay out more |
| ``blocks()``: text and tables of the document model | the terminal, a notebook |

The object that commands print and save is the object that Python users hold.  To add a format of files, write a
function from a result to bytes and a line of :data:`FORMATS`: every command and every ``save`` offers it.
"""

from __future__ import annotations

import csv
import io
import textwrap
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeAlias

from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.console import json_text, write, write_json, write_views
from nonsmooth.reports.output.files import PICTURES, output_path, write_whole
from nonsmooth.symbolic.messages.notebook import html_table
from nonsmooth.symbolic.messages.scene_error import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from rich.console import RenderableType

    from nonsmooth.reports.output.document import Block


Formats: TypeAlias = Mapping[str, Callable[[Any, str], bytes]]  # from a result, and an ending, to a file


class DataTable(NamedTuple):
    """Rows of numbers and texts under names; None where there is nothing."""

    columns: Sequence[str]
    lines: Iterable[Sequence[Any]]

    @classmethod
    def of_rows(cls, rows: Sequence[Record]) -> DataTable:
        """The table of records that have the same keys, one record at least."""
        return cls(tuple(rows[0]), [tuple(row.values()) for row in rows])


class Result(ABC):
    """What a study has found."""

    formats: ClassVar[Formats]  # by the ending of a file; :data:`FORMATS` unless told

    @abstractmethod
    def facts(self) -> Record:
        """The record of ``--json``, with stable keys."""

    @abstractmethod
    def table(self) -> DataTable:
        """The rows of a ``.csv`` file."""

    def draw(self, ax: Axes) -> None:
        """Draw it on axes.

        Raises:
            TypeError: for what has no picture.
        """
        raise TypeError(f"required a result that can be drawn, received {type(self).__name__}")

    @abstractmethod
    def blocks(self) -> Sequence[Block]:
        """What a terminal and a notebook show."""

    @abstractmethod
    def summary(self) -> str:
        """One line, said where a file was written."""

    def written(self, ending: str) -> str:
        """The line that says what a file with this ending holds."""
        return self.summary()

    @property
    def exit_status(self) -> int:
        """Of a command that shows it."""
        return 0

    def views(self) -> Sequence[RenderableType]:
        """What a terminal shows, with blank lines between: the blocks, unless it has a form of its own."""
        from nonsmooth.reports.output.terminal import blocks_view

        return [blocks_view(self.blocks())]

    def certificate(self) -> Record:
        """The statement of a verdict and its evidence, which the stand-alone checker has read: a check has one.

        Raises:
            NoCertificateError: where there is none, one line that says why.
        """
        from nonsmooth.proofs.kernel.subject import NoCertificateError

        raise NoCertificateError(f"certificate: required a check of one scene, received {type(self).__name__}")

    # ---- what follows ------------------------------------------------------------------------------

    def to_dict(self) -> Record:
        """The JSON record of the command."""
        return self.facts()

    def rows(self) -> list[Record]:
        """One mapping for each row of the command's ``.csv`` file; None where there is no number."""
        names, lines = self.table()
        return [dict(zip(names, line, strict=True)) for line in lines]

    def to_dataframe(self) -> Any:
        """The rows as a pandas DataFrame, where pandas is installed.

        Raises:
            ImportError: where it is not.
        """
        return import_module("pandas").DataFrame(self.rows())

    def dimensions(self) -> Sequence[str]:
        """The columns of the table that say where a row lies: time, start, what varies; the first unless told."""
        return self.table().columns[:1]

    def to_xarray(self) -> Any:
        """The rows as an xarray Dataset over :meth:`dimensions` (extra ``nonsmooth[tables]``).

        Where the rows are not all combinations of their values, each once (starts at random, two rows at the time of a
        jump), there is one dimension, ``row``.

        Raises:
            ImportError: where pandas or xarray are not installed.
        """
        frame, dimensions = self.to_dataframe(), list(self.dimensions())
        is_grid = prod(frame[name].nunique(dropna=False) for name in dimensions) == len(frame)
        if is_grid and not frame.duplicated(dimensions).any():
            return frame.set_index(dimensions).to_xarray()
        return frame.rename_axis("row").to_xarray()

    def figure(self) -> Figure:
        """The picture of a file."""
        from matplotlib.figure import Figure

        figure = Figure(layout="constrained")
        self.draw(figure.add_subplot())
        return figure

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw it on the axes given, or on those of a new figure that a notebook shows."""
        axes = own_axes(ax)
        self.draw(axes)
        return axes

    def content(self, ending: str) -> bytes:
        """It as the bytes of a file."""
        return self.formats[ending](self, ending)

    def save(self, file: str | Path) -> Path:
        """Write it in the format that the file's name ends in, one of ``formats``.

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
        """
        path = output_path(str(file), self.formats)
        self.write_to(path)
        return path

    def write_to(self, path: Path) -> None:
        """Write it to a file that can be written."""
        write_whole(path, self.content(path.suffix.lower()))

    def to_terminal(self) -> None:
        """Print it on a terminal."""
        write_views(self.views())

    def __repr__(self) -> str:
        return f"{type(self).__name__}: {self.summary()}"

    def _repr_html_(self) -> str:
        """Paragraphs and tables; every text is escaped."""
        return "".join(map(_block, self.blocks()))


def own_axes(ax: Axes | None) -> Axes:
    """The axes given, or those of a new figure that a notebook shows.

    Raises:
        ValueError: for what is no axes.
    """
    if ax is not None:
        from matplotlib.axes import Axes

        if not isinstance(ax, Axes):
            raise ValueError(f"ax: required axes of Matplotlib, received {shown(ax)}")
        return ax
    from matplotlib import pyplot as plt

    return plt.figure(layout="constrained").add_subplot()


def show(result: Result, path: Path | None, *, json: bool) -> None:
    """Write the file that was asked for; then print JSON, or say what was written, or print the blocks."""
    if path is not None:
        result.write_to(path)
    if json:
        write_json(result.facts())
    elif path is not None:
        write(f"{path}: {result.written(path.suffix.lower())}\n")
    else:
        result.to_terminal()


# ---- files ---------------------------------------------------------------------------------------


def _csv(result: Result, ending: str) -> bytes:
    stream = io.StringIO()
    names, lines = result.table()
    csv.writer(stream, lineterminator="\n").writerows((names, *lines))
    return stream.getvalue().encode()


def _json(result: Result, ending: str) -> bytes:
    return json_text(result.facts()).encode()


def _parquet(result: Result, ending: str) -> bytes:
    pyarrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    stream = io.BytesIO()
    parquet.write_table(pyarrow.Table.from_pylist(result.rows()), stream)
    return stream.getvalue()


def _picture(result: Result, ending: str) -> bytes:
    from nonsmooth.reports.figures.style import figure_bytes

    return figure_bytes(result.figure, ending)


FORMATS: Formats = {
    ".csv": _csv,
    ".json": _json,
    ".parquet": _parquet,
    **dict.fromkeys(PICTURES, _picture),
}
Result.formats = FORMATS


# ---- how results print ---------------------------------------------------------------------------


WIDTH, LINES = 100, 12


def short_lines(head: str, rows: Iterable[tuple[str, str]]) -> str:
    """A headline and a wrapped line for each name and text; what goes beyond :data:`LINES` is cut."""
    pairs = list(rows)
    wide = max((len(name) for name, _ in pairs), default=0)
    lines = [textwrap.shorten(head, WIDTH, placeholder=" ...")]
    for name, text in pairs:
        start = f"  {name:{wide}}  "
        lines += textwrap.wrap(text, WIDTH, initial_indent=start, subsequent_indent=" " * len(start))
    if len(lines) > LINES:
        lines = [*lines[: LINES - 1], "  ..."]
    return "\n".join(lines)


def counted_words(groups: Iterable[tuple[str, Iterable[str]]]) -> str:
    """``position: 5 comes home, 2 leaves; Theorem 4: 7 holds``: for each name how often each word is said."""
    counts = [(name, Counter(words).most_common()) for name, words in groups]
    return "; ".join(f"{name}: {', '.join(f'{n} {word}' for word, n in count)}" for name, count in counts if count)


# ---- notebooks -----------------------------------------------------------------------------------


def _block(block: Block) -> str:
    from nonsmooth.reports.output.document import Paragraph, Table, plain_text

    match block:
        case Paragraph(text):
            from html import escape  # as in messages/notebook.py

            return f"<p>{escape(plain_text(text))}</p>"
        case Table(header, rows):
            return html_table("", [*map(plain_text, header)], ([*map(plain_text, row)] for row in rows))
    raise TypeError(f"required a paragraph or a table, received {type(block).__name__}")
