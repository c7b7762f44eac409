"""One driven wheel, as Python describes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from nonsmooth.reports.output.entries import table


@dataclass(frozen=True)
class Wheel:
    """One driven wheel.

    Attributes:
        position: ``(x, y)`` in the unit of length.
        heading: of the rim: ``"inward"``, ``"outward"``, an angle, or a direction ``(a, b)``; None for its field.
        speed: of the rim (length/second); None for 1, or for the array's field.
        mu_roll: friction along the friction axis; None for the array's.
        mu_side: friction across it; None for the array's.
        speed_limit: the largest speed of its drive (length/second); None for the array's.
        axis: the friction axis, as a heading is written; None for the array's, which is the rim unless it names one.
        contact: its contact rule, ``"ellipse"`` or ``"roller"``, in an array whose wheels differ; None for the array's.
    """

    position: Sequence[Any]
    heading: Any = None
    speed: Any = None
    mu_roll: Any = None
    mu_side: Any = None
    speed_limit: Any = None
    axis: Any = None
    contact: str | None = None

    def table(self) -> dict[str, Any]:
        """The ``[[wheel]]`` table of a scene file."""
        return table(vars(self))
