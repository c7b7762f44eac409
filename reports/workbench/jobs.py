"""What a worker can do for the page, by name; every job answers in messages and ends in one of stage ``done``."""

from __future__ import annotations

import base64
import re
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple, TypeAlias

from nonsmooth.analysis.cells.contact_rule import CellRule, all_rules, has_cells
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs import system_certificates
from nonsmooth.proofs.certificate import certificate_text
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.reports.checks.cells import drawn
from nonsmooth.reports.checks.phase_portrait import PhasePortrait
from nonsmooth.reports.output.console import json_text
from nonsmooth.reports.workbench.array_view import array_stages
from nonsmooth.reports.workbench.documents import document_of, opened, read_toml, written
from nonsmooth.reports.workbench.exact_edits import edited
from nonsmooth.reports.workbench.requests import RequestError, read_request
from nonsmooth.reports.workbench.shapes import Announce
from nonsmooth.reports.workbench.system_view import system_stages
from nonsmooth.symbolic.files.documents import builtin_descriptions, builtin_scenes, builtin_systems
from nonsmooth.symbolic.files.scene_file import system_descriptions
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError

Message: TypeAlias = Record
Job: TypeAlias = Callable[[bytes, Announce], Iterator[Message]]

MAX_TOML = 1 << 20  # characters
STAGES: dict[SceneKind, Callable[[Any, Record, Announce], Iterator[Message]]] = {
    SceneKind.ARRAY: array_stages,
    SceneKind.SYSTEM: system_stages,
}
CERTIFICATE_TEXTS = {SceneKind.ARRAY: certificate_text, SceneKind.SYSTEM: system_certificates.certificate_text}
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
    for stage in STAGES[made.kind](made, request, announce):
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


def _table(request: Mapping[str, Any], key: str) -> Record:
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


# ---- files to save -------------------------------------------------------------------------------


class File(NamedTuple):
    """A file to save.

    Attributes:
        suffix: how its name ends.
        type: its media type.
        content: its bytes.
    """

    suffix: str
    type: str
    content: bytes


def exported(document: Mapping[str, Any], kind: object) -> File:
    """The file of a kind.

    Raises:
        RequestError: for a kind that is none, or that this scene has not.
        SceneError: for a scene that cannot be used.
    """
    if not isinstance(kind, str) or kind not in _KINDS:
        raise RequestError(f"kind: required one of {', '.join(_KINDS)}", "kind")
    return _KINDS[kind](document, opened(document))


def _toml(document: Mapping[str, Any], made: Any) -> File:
    del made
    return File(".toml", "application/toml", written(document).encode())


def _report(document: Mapping[str, Any], made: Any) -> File:
    del document
    return File(".html", "text/html; charset=utf-8", made.derive().text(".html").encode())


def _figure(document: Mapping[str, Any], made: Any) -> File:
    """The cells, the array where its rule has none, or the phase portrait."""
    del document
    if made.kind is SceneKind.SYSTEM:
        content = PhasePortrait(made.exact).content(".svg")
    else:
        show = "cells" if has_cells(made.exact) else "array"
        content = drawn(made.exact, ".svg", show)
    return File(".svg", "image/svg+xml", content)


def _json(document: Mapping[str, Any], made: Any) -> File:
    del document
    record = made.check().to_dict()
    return File(".json", "application/json", json_text(record).encode())


def _certificate(document: Mapping[str, Any], made: Any) -> File:
    """The certificate of a verdict, for the stand-alone checker."""
    del document
    try:
        text = CERTIFICATE_TEXTS[made.kind](made.check().certificate())
    except NoCertificateError as error:
        raise RequestError(f"certificate: {error}") from None
    return File(".json", "application/json", text.encode())


_KINDS: dict[str, Callable[[Mapping[str, Any], Any], File]] = {
    "toml": _toml,
    "report": _report,
    "figure": _figure,
    "json": _json,
    "certificate": _certificate,
}


# ---- what there is to choose from ----------------------------------------------------------------


def catalogue() -> Record:
    """Scenes and rules, each with one line about it."""
    kinds = {"array": builtin_descriptions(), "system": system_descriptions()}
    scenes = [
        {"name": name, "summary": summary, "kind": kind}
        for kind, found in kinds.items()
        for name, summary in found.items()
    ]
    rules = [
        {"name": rule.name, "summary": rule.summary, "has_cells": isinstance(rule, CellRule)} for rule in all_rules()
    ]
    return {"scenes": scenes, "rules": rules}


# ---- what is wrong with a request ----------------------------------------------------------------


FAULT = "a fault of the program: the terminal of the workbench shows where"
TOO_LARGE = "required a scene that fits into memory, received a larger one"


def refusal(error: Exception) -> Record:
    """One clear line, and the key that it is about, if it is about one; a fault is written to the log."""
    match error:
        case SceneError():
            return _message(str(error), error.key.replace("[", ".").replace("]", "") or None)
        case RequestError():
            return _message(str(error), error.key)
        case RefusalError() | TrajectoryError() | WorkLimitError():
            return _message(str(error))
        case MemoryError():
            return _message(TOO_LARGE)
        case RecursionError():
            return _message("required fewer nested brackets")
    traceback.print_exception(error, file=sys.stderr)
    return _message(FAULT)


def _message(text: str, key: str | None = None) -> Record:
    return {"stage": "error", "message": one_line(text), "key": key}
