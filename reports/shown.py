"""A result in every form that a command offers: JSON, a table of samples, a picture, one line, or a terminal's view."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Protocol

from rich.console import RenderableType

from nonsmooth.reports.console import json_text, write, write_json, write_views
from nonsmooth.reports.files import write_whole


class Shown(Protocol):
    """What a command has found."""

    def record(self) -> dict[str, Any]:
        """JSON with stable keys."""
        ...

    def lines(self) -> Iterable[Iterable[Any]]:
        """The lines of a CSV file, its header first."""
        ...

    def picture(self, suffix: str) -> bytes:
        """The bytes of a picture file."""
        ...

    def summary(self) -> str:
        """One line, shown where a file was written."""
        ...

    def view(self) -> RenderableType:
        """What a terminal shows."""
        ...


def file_bytes(shown: Shown, suffix: str) -> bytes:
    """A result as the bytes of a ``.csv``, ``.json`` or picture file."""
    if suffix == ".json":
        return json_text(shown.record()).encode()
    if suffix != ".csv":
        return shown.picture(suffix)
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows(shown.lines())
    return stream.getvalue().encode()


def show(shown: Shown, path: Path | None, *, json: bool) -> None:
    """Write the file that was asked for; then print JSON, or say what was written, or print the view."""
    if path is not None:
        write_whole(path, file_bytes(shown, path.suffix.lower()))
    if json:
        write_json(shown.record())
    elif path is not None:
        write(f"{path}: {shown.summary()}\n")
    else:
        write_views([shown.view()])
