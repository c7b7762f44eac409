"""What the page can save: the scene as a file, the report, a picture, the record of the check, the certificate."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from nonsmooth.proofs import system_certificates
from nonsmooth.proofs.certificate import certificate_text
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.reports.cells import drawn
from nonsmooth.reports.console import json_text
from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.interface.system import System
from nonsmooth.reports.workbench.documents import opened, written
from nonsmooth.reports.workbench.requests import RequestError


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


def _toml(document: Mapping[str, Any], made: Array | System) -> File:
    del made
    return File(".toml", "application/toml", written(document).encode())


def _report(document: Mapping[str, Any], made: Array | System) -> File:
    del document
    return File(".html", "text/html; charset=utf-8", made.derive().text(".html").encode())


def _figure(document: Mapping[str, Any], made: Array | System) -> File:
    """The cells, the array where its rule has none, or the phase portrait."""
    del document
    if isinstance(made, System):
        from nonsmooth.reports.phase_portrait import PhasePortrait

        return File(".svg", "image/svg+xml", PhasePortrait(made.system).content(".svg"))
    from nonsmooth.analysis.contact_rule import CellRule, rule_of

    show = "cells" if isinstance(rule_of(made.scene), CellRule) else "array"
    return File(".svg", "image/svg+xml", drawn(made.scene, ".svg", show))


def _json(document: Mapping[str, Any], made: Array | System) -> File:
    del document
    record = made.check().to_dict()
    return File(".json", "application/json", json_text(record).encode())


def _certificate(document: Mapping[str, Any], made: Array | System) -> File:
    """The certificate of a verdict, for the stand-alone checker."""
    del document
    written_by = system_certificates.certificate_text if isinstance(made, System) else certificate_text
    try:
        text = written_by(made.check().certificate())
    except NoCertificateError as error:
        raise RequestError(f"certificate: {error}") from None
    return File(".json", "application/json", text.encode())


_KINDS: dict[str, Callable[[Mapping[str, Any], Array | System], File]] = {
    "toml": _toml,
    "report": _report,
    "figure": _figure,
    "json": _json,
    "certificate": _certificate,
}
