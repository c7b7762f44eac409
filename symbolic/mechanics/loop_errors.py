"""What a feedback loop does not know in time, or not exactly."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.symbolic.numbers.number import Number


@dataclass(frozen=True)
class LoopErrors:
    """How old the pose is that the law acts on, and how far it may be off; all entries are at least zero.

    Attributes:
        delay: age of the pose (time).
        position: largest distance of the place that the law is given from the true one (length).
        heading: largest difference of the heading that it is given, as ``pi * turn`` (radian).
    """

    delay: Number
    position: Number
    heading: Fraction
