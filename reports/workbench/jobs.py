"""What a worker can do for the page, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

from nonsmooth.reports.workbench.documents import document_of, opened, read_toml
from nonsmooth.reports.workbench.requests import RequestError, read_request
from nonsmooth.reports.workbench.view import view

Announce: TypeAlias = Callable[[str], None]
Job: TypeAlias = Callable[[bytes, Announce], Iterator[dict[str, Any]]]

MAX_TOML = 1 << 20  # characters


def open_text(body: bytes, announce: Announce) -> Iterator[dict[str, Any]]:
    """The document of the text of a scene file, which is tried before it is handed out."""
    del announce
    text = read_request(body, longest=MAX_TOML).get("toml")
    if not isinstance(text, str):
        raise RequestError("toml: required the text of a scene file", "toml")
    document = read_toml(text)
    _ = opened(document)
    yield {"document": document}


def open_scene(body: bytes, announce: Announce) -> Iterator[dict[str, Any]]:
    """The document of a built-in scene, or of the file that the command line named."""
    del announce
    yield {"document": document_of(body.decode())}


JOBS: dict[str, Job] = {"view": view, "open": open_text, "scene": open_scene}
