"""The stages of the view of a plain system."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from nonsmooth.reports.interface.system import System


def system_stages(system: System, request: dict[str, Any], announce: Callable[[str], None]) -> Iterator[dict[str, Any]]:
    """The phase portrait at once, then the verdict."""
    yield {"stage": "fast", "kind": "system", "system": {"states": list(system.system.states)}}
    announce("stability")
    result = system.check()
    yield {"stage": "exact", "kind": "system", "verdict": result.verdict, "reason": result.reason}
