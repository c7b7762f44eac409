"""A point that shows why a clause says no more than it does."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.partitions.polygon import Point
from nonsmooth.symbolic.numbers.number import Number


@dataclass(frozen=True)
class Witness:
    """A point and the exact value that refutes or limits a claim there."""

    point: Point
    value: Number
    meaning: str
