"""The kinds of scenes, and what they have in common."""

from __future__ import annotations

from enum import StrEnum
from typing import Protocol


class SceneKind(StrEnum):
    """What a scene is, in words."""

    ARRAY = "an array of wheels"
    SYSTEM = "a plain switched system"
    VEHICLE = "a vehicle"


class AnyScene(Protocol):
    """An array, a plain system or a vehicle: what is named in messages, and judged by its kind."""

    @property
    def kind(self) -> SceneKind:
        """What it is."""
        ...

    @property
    def name(self) -> str:
        """Of the scene."""
        ...

    @property
    def origin(self) -> str:
        """Where it came from, for messages: its file or built-in name, else its own name."""
        ...
