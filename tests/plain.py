"""Plain systems of formulas, as a file of them would be read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


def built(
    rhs: Sequence[Any], parameters: Mapping[str, Any] | None = None, states: Sequence[str] = "xyz", **check: Any
) -> SwitchedSystem:
    """A system.

    Args:
        rhs: a formula for each state, or such a list for each side that may act.
        parameters: numbers and intervals by their names.
        states: the names of the states; of more than there are formulas the first ones are taken.
        check: what stands under ``[check]``.
    """
    count = len(rhs) if isinstance(rhs[0], str) else len(rhs[0])
    system: dict[str, Any] = {"states": list(states[:count]), "rhs": list(rhs)}
    if parameters:
        system["parameters"] = dict(parameters)
    return build_system({"system": system, "check": check}, "t", Path("t.toml"))
