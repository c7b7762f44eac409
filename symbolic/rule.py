"""The contact rules by name; importing nothing else, so that a command line can offer them at once."""

from __future__ import annotations

from enum import StrEnum


class Rule(StrEnum):
    """Which motion follows from the contacts (see the how-to-choose page)."""

    NEAREST = "nearest"
    BOX = "box"
    ELLIPSE = "ellipse"
