"""The certified feedback law of a check, as a script or a notebook holds it."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.reports.files import output_path, write_whole
from nonsmooth.reports.law_program import law_program
from nonsmooth.reports.law_table import LawTable, law_table
from nonsmooth.reports.result import Tabular
from nonsmooth.reports.short_text import short_lines
from nonsmooth.symbolic.notebook import html_table
from nonsmooth.symbolic.number_text import short_text

if TYPE_CHECKING:
    from nonsmooth.proofs.theorem4_result import Check

LAW_FORMATS = (".py", ".csv")


@dataclass(frozen=True, repr=False)
class LawResult(Tabular):
    """A feedback law: in which region which wheel runs at which speed.

    Attributes:
        table: the law; poses are measured from the checked point.
        at: the checked point, in words.
    """

    table: LawTable
    at: str

    def rows(self) -> list[dict[str, str]]:
        """One row for each region and wheel (and imposed twist): where, and the speed as a formula."""
        return self.table.rows()

    def program(self) -> str:
        """A Python file of the standard library with a function ``speeds(x, y, theta, k=1.0)``."""
        return law_program(self.table, self.at)

    def save(self, file: str | Path) -> Path:
        """Write it: .py a program, .csv the table of regions and speeds.

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
        """
        path = output_path(str(file), LAW_FORMATS)
        text = self.program() if path.suffix.lower() == ".py" else _csv_text(self.rows())
        write_whole(path, text.encode())
        return path

    def __repr__(self) -> str:
        head = f"law of {self.table.scene.name}, rule {self.table.scene.contact.rule}, measured from {self.at}"
        said = [(f"{row['region']}, wheel {row['wheel']}", row["speed"]) for row in self.rows()]
        return short_lines(head, [("terms", str(self.table.kind)), *said])

    def _repr_html_(self) -> str:
        rows = self.rows()
        return html_table(str(self.table.kind), tuple(rows[0]), [tuple(row.values()) for row in rows])


def certified_law_of(check: Check) -> LawResult:
    """The law that the feedback clause certifies.

    Raises:
        NoLawError: where it certifies none.
    """
    x, y = (short_text(value) for value in check.scene.check.equilibrium)
    return LawResult(law_table(check), f"({x}, {y})")


def _csv_text(rows: list[dict[str, str]]) -> str:
    stream = io.StringIO()
    writer: csv.DictWriter[str] = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()
