"""What a worker can do for the page, by name; every job answers in messages and ends in one of stage ``done``."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeAlias

from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.workbench.array_view import array_stages
from nonsmooth.reports.workbench.catalogue import catalogue
from nonsmooth.reports.workbench.documents import document_of, opened, read_toml
from nonsmooth.reports.workbench.exact_edits import edited
from nonsmooth.reports.workbench.exports import exported
from nonsmooth.reports.workbench.requests import RequestError, read_request
from nonsmooth.reports.workbench.system_view import system_stages
from nonsmooth.symbolic.files.scene_file import builtin_scenes, builtin_systems

Announce: TypeAlias = Callable[[str], None]
Message: TypeAlias = dict[str, Any]
Job: TypeAlias = Callable[[bytes, Announce], Iterator[Message]]

MAX_TOML = 1 << 20  # characters
PLAIN = re.compile(r"[^A-Za-z0-9._-]+")  # what a name of a file leaves out


def view(body: bytes, announce: Announce) -> Iterator[Message]:
    """The stages of a view: fast, exact, and what else the request wants.

    Raises:
        RequestError: for a request that lacks something, or has it in another form.
        SceneError: for a scene that cannot be used.
        RefusalError: where the motion is not determined.
    """
    request = read_request(body)
    made = opened(_table(request, "document"))
    stages = (
        array_stages(made, request, announce) if isinstance(made, Array) else system_stages(made, request, announce)
    )
    for stage in stages:
        yield stage
        announce("")


def edit(body: bytes, announce: Announce) -> Iterator[Message]:
    """A document after an exact edit."""
    del announce
    request = read_request(body)
    found = edited(_table(request, "document"), _table(request, "operation"))
    yield {"document": found.document, "wheels": found.wheels}


def export(body: bytes, announce: Announce) -> Iterator[Message]:
    """A file to save, its bytes as text in base 64."""
    del announce
    request = read_request(body)
    document = _table(request, "document")
    file = exported(document, request.get("kind"))
    name = PLAIN.sub("-", str(document.get("name") or "scene")).strip("-.")[:60] or "scene"
    yield {"name": name + file.suffix, "type": file.type, "content": base64.b64encode(file.content).decode()}


def open_text(body: bytes, announce: Announce) -> Iterator[Message]:
    """The document of the text of a scene file, which is tried before it is handed out."""
    del announce
    text = read_request(body, longest=MAX_TOML).get("toml")
    if not isinstance(text, str):
        raise RequestError("toml: required the text of a scene file", "toml")
    document = read_toml(text)
    _ = opened(document)
    yield {"document": document}


def open_scene(body: bytes, announce: Announce) -> Iterator[Message]:
    """The document of a built-in scene."""
    name = body.decode()
    if name not in (*builtin_scenes(), *builtin_systems()):
        raise RequestError("scene: required the name of a built-in array or plain system")
    yield from open_file(body, announce)


def open_file(body: bytes, announce: Announce) -> Iterator[Message]:
    """The document of what the command line named; no request of the page comes here with another name."""
    del announce
    yield {"document": document_of(body.decode())}


def list_scenes(body: bytes, announce: Announce) -> Iterator[Message]:
    """The built-in scenes and the contact rules."""
    del body, announce
    yield catalogue()


def _table(request: Mapping[str, Any], key: str) -> dict[str, Any]:
    found = request.get(key)
    if not isinstance(found, dict):
        raise RequestError(f"{key}: required a table", key)
    return found


JOBS: dict[str, Job] = {
    "view": view,
    "edit": edit,
    "export": export,
    "open": open_text,
    "scene": open_scene,
    "file": open_file,
    "scenes": list_scenes,
}
