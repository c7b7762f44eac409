"""The kinds of scenes."""

from __future__ import annotations

from enum import StrEnum


class SceneKind(StrEnum):
    """What a scene is, in words."""

    ARRAY = "an array of wheels"
    SYSTEM = "a plain switched system"
    VEHICLE = "a vehicle"
