"""A film as the bytes of a file: .gif and .mp4 by Matplotlib's writers, .html as a page of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nonsmooth.reports.animation.film import Film

FILMS = (".gif", ".mp4", ".html")


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
