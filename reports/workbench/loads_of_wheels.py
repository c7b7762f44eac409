"""Loads of a document that list a value for each wheel: they follow the wheels when these come and go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def with_loads(document: Mapping[str, Any], sources: Sequence[int | None]) -> dict[str, Any]:
    """The document with its loads in the order of its wheels.

    Args:
        document: with the new wheels and the old loads.
        sources: for each new wheel its place among the old ones; None for one that was none of them, which carries
            nothing.
    """
    contact = document.get("contact")
    if not isinstance(contact, Mapping):
        return dict(document)
    changed = {key: _followed(contact[key], sources) for key in ("loads", "table") if key in contact}
    return {**document, "contact": {**contact, **changed}}


def _followed(loads: Any, sources: Sequence[int | None]) -> Any:
    match loads:
        case list():
            return [[0, 0, 0] if source is None else loads[source] for source in sources]
        case {"table": list(rows), **rest}:
            return {**rest, "table": _followed(rows, sources)}
        case {"kind": "measured", "values": list(values), **rest}:
            own = [0 if source is None else values[source] for source in sources]
            return {"kind": "measured", "values": own, **rest}
    return loads
