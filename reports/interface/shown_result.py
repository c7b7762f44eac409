"""Results that a command shows: the same record, rows and files in Python."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nonsmooth.reports.files import PICTURES, output_path, write_whole
from nonsmooth.reports.interface.row_results import Tabular
from nonsmooth.reports.shown import Shown, file_bytes

SHOWN_FORMATS = (".csv", ".json", *PICTURES)


class ShownResult(Tabular):
    """A result with rows in a CSV file, a JSON record and a picture.

    Attributes:
        shown: the result in every form that its command offers.
    """

    shown: Shown

    def to_dict(self) -> dict[str, Any]:
        """The JSON record of the command."""
        return self.shown.record()

    def rows(self) -> list[dict[str, Any]]:
        """One mapping for each row of the command's CSV file."""
        names, *lines = (tuple(line) for line in self.shown.lines())
        return [dict(zip(names, line, strict=True)) for line in lines]

    def save(self, file: str | Path) -> Path:
        """Write it: .csv, .json or a picture (.svg, .png, .pdf).

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
        """
        path = output_path(str(file), SHOWN_FORMATS)
        write_whole(path, file_bytes(self.shown, path.suffix.lower()))
        return path
