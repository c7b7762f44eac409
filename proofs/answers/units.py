"""The labels of a scene's units, as they follow a number in an answer."""

from __future__ import annotations

from nonsmooth.symbolic.scene import Scene


def of_length(scene: Scene) -> str:
    """A space and the unit of length; empty where the scene names none."""
    unit = scene.units.length
    return f" {unit}" if unit else ""
