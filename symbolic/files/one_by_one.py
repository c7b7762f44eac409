"""Wheels of a ring, a grid or a table as tables of a scene file, one by one, so that each can be changed on its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nonsmooth.symbolic.scene import Scene, Wheel

LAYOUTS = ("wheel", "ring", "grid", "wheels", "field")  # tables that the list of wheels replaces


def one_by_one(document: Mapping[str, Any], scene: Scene) -> dict[str, Any]:
    """A document of the same array with a list of wheels, exact, in place of what laid them out."""
    kept = {key: value for key, value in document.items() if key not in LAYOUTS}
    return {**kept, "wheel": [wheel_entry(wheel) for wheel in scene.wheels]}


def wheel_entry(wheel: Wheel) -> dict[str, Any]:
    """One wheel as a table of a scene file."""
    entry: dict[str, Any] = {
        "position": [str(number) for number in wheel.position],
        "heading": [str(number) for number in wheel.direction],
        "speed": str(wheel.speed),
        "mu_roll": str(wheel.friction.roll),
        "mu_side": str(wheel.friction.side),
    }
    if wheel.speed_limit is not None:
        entry["speed_limit"] = str(wheel.speed_limit)
    if wheel.axis is not None:
        entry["axis"] = [str(number) for number in wheel.axis]
    return entry
