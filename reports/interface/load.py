"""Reading a scene file or a built-in scene into an array or a plain system."""

from __future__ import annotations

from pathlib import Path

from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.interface.system import System
from nonsmooth.symbolic.files.documents import read_document


def load(source: str | Path) -> Array | System:
    """An array or a plain system from a scene file (TOML) or a built-in name; see ``nonsmooth scenes``.

    Raises:
        SceneError: for whatever cannot be used.
    """
    document, _, path = read_document(source)
    named = {"name": path.stem, **document}
    if "system" in document:
        return System.of_document(named)
    return Array.of_document(named, path.parent)
