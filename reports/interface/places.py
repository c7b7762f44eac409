"""Where the keywords of an array stand in a scene file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nonsmooth.reports.entries import entry

# Where a keyword of `with_` stands in a scene file.
_PLACES = {
    "name": (),
    "mu_roll": ("friction",),
    "mu_side": ("friction",),
    "axis": ("friction",),
    "speed_limit": ("drive",),
    "rule": ("contact",),
    "loads": ("contact",),
    "at": ("check",),
    "radius": ("check",),
    "length": ("check",),
    "accuracy": ("check",),
    "lyapunov": ("check",),
    "field": (),
    "body": (),
    "tolerance": (),
    "units": (),
}
_KEYS = {"at": "equilibrium"}


def placed(document: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The document with each keyword at its place; None leaves it as it is."""
    changed = dict(document)
    for name, value in given.items():
        if name not in _PLACES:
            raise TypeError(f"required a keyword among {', '.join(_PLACES)}, received {name!r}")
        if value is None:
            continue
        key = _KEYS.get(name, name)
        if not _PLACES[name]:
            changed[key] = entry(value)
            continue
        (section,) = _PLACES[name]
        changed[section] = {**changed.get(section, {}), key: entry(value)}
    return changed
