"""Poses and points at which a body may rest, as floats propose them, and where they were met."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.bodies.many_contacts import Mask, Numbers
from nonsmooth.analysis.fields.contact_model import Floats

ALIKE = 1e-5  # of the body's size: places closer together are one


@dataclass(frozen=True)
class EdgeRest:
    """A pose at which a body may rest with one wheel under its edge.

    Attributes:
        pose: ``(x, y, theta)``.
        wheel: place of that wheel in the list of wheels.
        inside: places of the wheels that carry beside it, ascending.
        twist: spatial twist ``(v, omega)`` without the wheel.
        ratio: ``-1`` times that of the motion with the wheel to the motion without.
        loaded: which of ``inside`` are pressed, without the wheel and with it; in the latter case the last entry is
            the wheel's own.
        stuck: which of them seem not to slip, in the same order.
    """

    pose: tuple[float, float, float]
    wheel: int
    inside: tuple[int, ...]
    twist: tuple[float, float, float]
    ratio: float
    loaded: tuple[tuple[bool, ...], tuple[bool, ...]]
    stuck: tuple[tuple[bool, ...], tuple[bool, ...]]

    @property
    def place(self) -> tuple[float, float]:
        """``(x, y)``."""
        return self.pose[:2]


@dataclass(frozen=True)
class SetRest:
    """A point at which a body may rest on one set of wheels: places in the list of wheels, a point and a heading."""

    wheels: tuple[int, ...]
    place: tuple[float, float]
    theta: float


@dataclass(frozen=True)
class MetSets:
    """What was met on the grid.

    Attributes:
        sets: contact sets (k, n).
        pairs: contact sets without a wheel (m, n), of pairs that differ by it; one row for each place.
        wheels: the wheels by which they differ (m,).
        centres: places at which the pairs were met (m, 2).
        reach: half-width of the square of places.
    """

    sets: Mask
    pairs: Mask
    wheels: Numbers
    centres: Floats
    reach: float


def distinct(rests: Iterator[EdgeRest], size: float) -> list[EdgeRest]:
    """Without those that repeat an earlier one: the same wheel and nearly the same pose."""
    kept: list[EdgeRest] = []
    for rest in rests:
        scale = np.array([1.0, 1.0, size])
        alike = (
            one.wheel == rest.wheel and np.abs(np.subtract(one.pose, rest.pose) * scale).max() <= ALIKE * size
            for one in kept
        )
        if not any(alike):
            kept.append(rest)
    return kept
