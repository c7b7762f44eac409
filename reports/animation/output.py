"""A film as the bytes of a file: .gif by Matplotlib's writer, .html as a page of its own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.reports.console import RefusedError

if TYPE_CHECKING:
    from nonsmooth.reports.animation.film import Film

FILMS = (".gif", ".html")


def require_film(path: Path | None, *, is_array: bool) -> None:
    """Refuse a film of something that has no wheels.

    Raises:
        RefusedError: naming the file.
    """
    suffix = "" if path is None else path.suffix.lower()
    if suffix in FILMS and not is_array:
        raise RefusedError(f"{path}: required an array of wheels for {suffix}, received a plain switched system")


def film_bytes(film: Film, suffix: str) -> bytes:
    """The film in one of the formats :data:`FILMS`."""
    if suffix == ".html":
        from nonsmooth.reports.animation.page import film_page

        return film_page(film).encode()
    from nonsmooth.reports.animation.movie import gif_bytes

    return gif_bytes(film)
