"""A film as the bytes of a file: .gif and .mp4 by Matplotlib's writers, .html as a page of its own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.reports.console import RefusedError

if TYPE_CHECKING:
    from nonsmooth.reports.animation.film import Film

FILMS = (".gif", ".mp4", ".html")


def require_film(path: Path | None, *, is_array: bool) -> None:
    """Refuse a film of something that has no wheels, or in a format that cannot be written on this machine.

    Raises:
        RefusedError: naming the file and what is missing.
    """
    suffix = "" if path is None else path.suffix.lower()
    if suffix not in FILMS:
        return
    if not is_array:
        raise RefusedError(f"{path}: required an array of wheels for {suffix}, received a plain switched system")
    from nonsmooth.reports.animation.movie import MissingWriterError, require_writer

    try:
        require_writer(suffix)
    except MissingWriterError as error:
        raise RefusedError(f"{path}: {error}") from None


def film_bytes(film: Film, suffix: str) -> bytes:
    """The film in one of the formats :data:`FILMS`.

    Raises:
        nonsmooth.reports.animation.movie.MissingWriterError: for .mp4 without ffmpeg.
    """
    if suffix == ".html":
        from nonsmooth.reports.animation.page import film_page

        return film_page(film).encode()
    from nonsmooth.reports.animation.movie import movie_bytes

    return movie_bytes(film, suffix)
