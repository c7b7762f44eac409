"""What a command line offers by name; light, so that ``--help`` loads no mathematics."""

from __future__ import annotations

from enum import StrEnum


class LawName(StrEnum):
    """A feedback law of rule ``nearest``; ``certified`` stands for the one that the feedback clause certifies."""

    CERTIFIED = "certified"
    CORRECTED = "corrected"
    PRINTED = "printed"
    GRADIENT = "gradient"
    CASCADE = "cascade"


class PathMethod(StrEnum):
    """How the solution is followed."""

    EVENTS = "events"
    HYSTERESIS = "hysteresis"
    SMOOTHED = "smoothed"
    DYNAMICS = "dynamics"


class Drawing(StrEnum):
    """What a picture of an array shows."""

    CELLS = "cells"
    ARRAY = "array"
    RATES = "rates"


class RegionSearch(StrEnum):
    """How much is done for the region, beyond a level set of the V that decides.

    ``auto`` is ``fast`` for a plain system in two states and more, and ``none`` for everything else.
    """

    AUTO = "auto"
    NONE = "none"
    FAST = "fast"
    BEST = "best"
