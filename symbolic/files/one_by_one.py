"""Wheels of a ring, a grid or a table as tables of a scene file, one by one, so that each can be changed on its own.

What the scene says of all wheels (``friction``, ``drive``) stays where it is: a wheel states what it stated before,
its place, heading and speed, and its friction axis.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from nonsmooth.symbolic.files.scene_file import stated_units
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel

LAYOUTS = ("wheel", "ring", "grid", "wheels", "field")  # tables that the list of wheels replaces


def one_by_one(document: Mapping[str, Any], scene: Scene) -> dict[str, Any]:
    """A document of the same array with a list of wheels, exact, in place of what laid them out."""
    kept = {key: value for key, value in document.items() if key not in LAYOUTS}
    unit = unit_of_speed(document, scene)
    return {**kept, "wheel": [wheel_entry(wheel, scene, unit) for wheel in scene.wheels]}


def unit_of_speed(document: Mapping[str, Any], scene: Scene) -> Fraction:
    """How many lengths per second the unit of speed is in which a document of a scene states speeds."""
    return stated_units(dict(document), scene.source).speed_factor


def wheel_entry(wheel: Wheel, scene: Scene, unit: Fraction) -> dict[str, Any]:
    """One wheel as a table of a scene file.

    Args:
        wheel: of a scene that was read from a file.
        scene: this scene.
        unit: of speed, in lengths per second.
    """
    entry: dict[str, Any] = {
        "position": [str(number) for number in wheel.position],
        "heading": [str(number) for number in wheel.direction],
        "speed": str(wheel.speed / unit),
    }
    if str(wheel.index) != f"{wheel.index:d}":
        entry = {"name": str(wheel.index), **entry}
    if "mu_roll" in wheel.named:
        entry["mu_roll"] = str(wheel.friction.roll)
    if "mu_side" in wheel.named:
        entry["mu_side"] = str(wheel.friction.side)
    if "speed_limit" in wheel.named and wheel.speed_limit is not None:
        entry["speed_limit"] = str(wheel.speed_limit / unit)
    if "contact" in wheel.named:
        entry["contact"] = scene.rule_of_wheel(wheel)
    if wheel.axis is not None:
        entry["axis"] = [str(number) for number in wheel.axis]
    return entry
