"""The corpus of certificates as files: which there are, and what the checker says of each."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.checker.work import MALFORMED, take_once
from tests.certificates.forgeries import Forgery

Record: TypeAlias = dict[str, Any]

FOLDER = Path(__file__).parent
GOOD, BAD, BAD_ARRAYS = FOLDER / "good", FOLDER / "bad.jsonl", FOLDER / "bad_arrays.jsonl"
PREFIX = "array-"  # of the names of arrays


def text_of(certificate: Record) -> str:
    """As it is written."""
    return json.dumps(certificate, separators=(",", ":")) + "\n"


def good_certificates() -> dict[str, Record]:
    """All good ones of plain systems, by name."""
    return {name: own for name, own in _good().items() if not name.startswith(PREFIX)}


def good_arrays() -> dict[str, Record]:
    """All good ones of arrays, by name."""
    return {name: own for name, own in _good().items() if name.startswith(PREFIX)}


def bad_certificates() -> tuple[Forgery, ...]:
    """All forged ones of plain systems."""
    return _forged(BAD)


def bad_arrays() -> tuple[Forgery, ...]:
    """All forged ones of arrays."""
    return _forged(BAD_ARRAYS)


@cache
def _good() -> dict[str, Record]:
    return {path.stem: json.loads(path.read_text("utf-8")) for path in sorted(GOOD.glob("*.json"))}


@cache
def _forged(file: Path) -> tuple[Forgery, ...]:
    found = []
    for line in file.read_text("utf-8").splitlines():
        own = json.loads(line)
        changes = tuple((path, value) for path, value in own.get("changes", ()))
        text = tuple((piece, times) for piece, times in own.get("text", ()))
        found.append(Forgery(own["kind"], own.get("of", ""), changes, text, own.get("because", "")))
    return tuple(found)


def forged_text(own: Forgery, good: Mapping[str, Record]) -> str:
    """The content of a forged file."""
    return own.content if own.text else text_of(own.document(good[own.of]))


def forged(own: Forgery, good: Mapping[str, Record]) -> str:
    """Why a forged certificate is rejected, or cannot be read; empty where it is accepted."""
    text = forged_text(own, good)
    try:
        data = json.loads(text, parse_float=str, parse_constant=str, object_pairs_hook=take_once)
    except MALFORMED as error:
        return f"unreadable: {type(error).__name__}"
    return refusal(data, len(text.encode("utf-8", "surrogatepass")))
