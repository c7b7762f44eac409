"""The two kinematics by name; importing nothing else, so that a command line can offer them at once."""

from __future__ import annotations

from enum import StrEnum


class Kinematics(StrEnum):
    """How a spatial twist moves the pose; equal where the centre of mass is at the world origin."""

    LEADING = "leading"
    EXACT = "exact"
