"""Output files: checked before the work, written whole or not at all."""

from __future__ import annotations

import errno
import os
from collections.abc import Collection
from importlib import import_module
from pathlib import Path

from nonsmooth.symbolic.messages import removed

ATTEMPTS = 10  # to find a free name of 128 random bits
PICTURES = (".svg", ".png", ".pdf")  # what Matplotlib writes for us
FILMS = (".gif", ".html")  # the motion of a body; .html is a page with a slider


class OutputError(OSError):
    """An output path that cannot be used; ``str(error)`` is one line."""

    def __init__(self, path: Path, expected: str, received: str) -> None:
        super().__init__(path, expected, received)
        self.path, self.expected, self.received = path, expected, received

    def __str__(self) -> str:
        return f"{self.path}: required {self.expected}, received {self.received}"


def output_path(text: str, suffixes: Collection[str]) -> Path:
    """The path of an output file that can be written, as far as that can be known beforehand.

    Args:
        text: what the user wrote.
        suffixes: the formats on offer, such as ``.md``.

    Raises:
        OutputError: for an unknown suffix, a missing or unwritable folder, and anything but a regular file.
    """
    path = Path(text)
    ending = path.suffix.lower()
    if text.endswith(("/", os.sep)):
        raise OutputError(path, "a file name", f"that of a folder, {text!r}")
    if ending not in suffixes:
        gone = f", which was removed: {removed.ENDINGS[ending]}" if ending in removed.ENDINGS else ""
        received = repr(path.suffix or path.name) + gone
        instead = " (pdflatex makes a .pdf of a .tex)" if ending == ".pdf" and ".tex" in suffixes else ""
        raise OutputError(path, f"a file name that ends in {_either(suffixes)}{instead}", received)
    _require_library(path, ending)
    try:
        target = path.resolve()
        if not target.parent.is_dir():
            raise OutputError(path, "an existing folder", f"{str(target.parent)!r}, which is none")
        if target.exists() and not target.is_file():
            raise OutputError(path, "a regular file", "a folder" if target.is_dir() else "something else")
        if target.exists() and not os.access(target, os.W_OK):
            raise OutputError(path, "a file that can be written", "a write-protected file")
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise OutputError(path, "a folder that can be written", f"{str(target.parent)!r}, which cannot")
    except (OSError, ValueError, RuntimeError) as error:  # names too long, loops of links, null characters
        raise _unusable(path, error) from None
    return path


def write_whole(path: Path, data: bytes) -> None:
    """Write a file so that it is either complete or untouched: a temporary file beside it, then a rename.

    Raises:
        OutputError: where the system refuses; then nothing is left behind.
    """
    target = path.resolve()
    temporary: Path | None = None
    try:
        try:
            temporary, descriptor = _create_beside(target)
            with os.fdopen(descriptor, "wb") as stream:
                if target.exists():
                    os.fchmod(stream.fileno(), target.stat().st_mode & 0o7777)
                stream.write(data)
            temporary.replace(target)
        finally:
            if temporary is not None:
                temporary.unlink(missing_ok=True)
    except OSError as error:
        raise _unusable(path, error) from None


def make_folder(path: Path) -> None:
    """A folder, where there is none yet.

    Raises:
        OutputError: where the system refuses.
    """
    try:
        path.mkdir(exist_ok=True)
    except OSError as error:
        raise OutputError(path, "a folder that can be made", (error.strerror or "an error").lower()) from None


def _create_beside(target: Path) -> tuple[Path, int]:
    """A new file in the target's folder, and its descriptor.

    Others may write to that folder too: the name cannot be guessed, and what stands there already, a link above all, is
    neither followed nor overwritten.
    """
    import secrets

    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
    for _ in range(ATTEMPTS):
        temporary = target.with_name(f".nonsmooth-{secrets.token_hex(16)}.tmp")
        try:
            return temporary, os.open(temporary, flags, 0o666)
        except FileExistsError:
            continue
    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))


def _require_library(path: Path, ending: str) -> None:
    """Refuse .parquet without pyarrow, which is not required."""
    if ending != ".parquet":
        return
    try:
        import_module("pyarrow.parquet")
    except ImportError:
        raise OutputError(path, "the package pyarrow for .parquet (or .csv, .json)", "a Python without it") from None


def _either(names: Collection[str]) -> str:
    """``a, b or c``; a single name alone."""
    *first, last = names
    return f"{', '.join(first)} or {last}" if first else last


def _unusable(path: Path, error: Exception) -> OutputError:
    if isinstance(error, OutputError):
        return error
    reason = (error.strerror if isinstance(error, OSError) else None) or "a path that leads nowhere"
    return OutputError(path, "a file that can be written", reason.lower())
