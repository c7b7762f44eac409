"""A sweep as a file: a table (.csv, .parquet), a record (.json) or a picture (.svg, .png, .pdf)."""

from __future__ import annotations

import csv
import io
from importlib import import_module
from pathlib import Path

from nonsmooth.reports.console import json_text
from nonsmooth.reports.figures.sweep import sweep_figure
from nonsmooth.reports.files import PICTURES, output_path
from nonsmooth.reports.sweeps.sweep import Sweep
from nonsmooth.reports.sweeps.table import flat_rows, sweep_record

SWEEP_FORMATS = (".csv", ".json", ".parquet", *PICTURES)


def sweep_path(text: str) -> Path:
    """The path of an output file that can be written.

    Raises:
        OutputError: for another ending, a path that cannot be written, and .parquet without its library.
    """
    return output_path(text, SWEEP_FORMATS)


def sweep_bytes(sweep: Sweep, suffix: str) -> bytes:
    """A sweep as the bytes of a file.

    Raises:
        SweepError: for a picture of what cannot be drawn.
    """
    if suffix == ".json":
        return json_text(sweep_record(sweep)).encode()
    if suffix == ".csv":
        return _csv_bytes(sweep)
    if suffix == ".parquet":
        return _parquet_bytes(sweep)
    return sweep_figure(sweep, suffix)


def _csv_bytes(sweep: Sweep) -> bytes:
    rows = flat_rows(sweep)
    first = next(rows)
    stream = io.StringIO()
    writer = csv.DictWriter(stream, list(first), lineterminator="\n")
    writer.writeheader()
    writer.writerow(first)
    writer.writerows(rows)
    return stream.getvalue().encode()


def _parquet_bytes(sweep: Sweep) -> bytes:
    pyarrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    stream = io.BytesIO()
    parquet.write_table(pyarrow.Table.from_pylist(list(flat_rows(sweep))), stream)
    return stream.getvalue()
