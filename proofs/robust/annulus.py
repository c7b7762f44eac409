"""Quadrangles with rational corners that cover rings about the origin.

The rays of all quadrangles are multiples of the same rational directions, so that neighbours leave no gap between them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

Place: TypeAlias = tuple[Fraction, Fraction]

INSIDE = 1 - Fraction(1, 2**20)  # of a radius: a ray's direction is longer than one by no more than rounding
OUTSIDE = 1 + Fraction(1, 2**20)


@dataclass(frozen=True)
class AnnulusPiece:
    """A quadrangle that holds the part of a ring ``inner <= |c| <= outer`` in a sector.

    Attributes:
        inner: smaller radius of the ring.
        outer: larger radius of the ring.
        start: first ray of the sector, as a share of a full turn.
        width: of the sector, as a share of a full turn.
    """

    inner: Fraction
    outer: Fraction
    start: Fraction
    width: Fraction

    @property
    def corners(self) -> tuple[Place, ...]:
        """Counterclockwise.

        Raises:
            ArithmeticError: where rounding leaves a part of the ring outside.
        """
        first, last = ray(self.start), ray(self.start + self.width)
        near = self.inner * INSIDE
        far = self.outer * OUTSIDE * Fraction(1 / math.cos(math.pi * float(self.width)))
        if max(_square(first), _square(last)) * INSIDE**2 > 1 or not side_is_outside(far, first, last, self.outer):
            raise ArithmeticError("required a quadrangle that holds its part of the ring")
        return _times(near, first), _times(far, first), _times(far, last), _times(near, last)

    @property
    def parts(self) -> Iterator[AnnulusPiece]:
        """Four parts that cover the same part of the ring."""
        middle, half = (self.inner + self.outer) / 2, self.width / 2
        for inner, outer in ((self.inner, middle), (middle, self.outer)):
            for start in (self.start, self.start + half):
                yield AnnulusPiece(inner, outer, start, half)


def polygon_about(radius: Fraction, count: int) -> tuple[Place, ...]:
    """The corners of a polygon that holds a disc about the origin.

    Raises:
        ArithmeticError: where rounding leaves a part of the disc outside.
    """
    far = radius * OUTSIDE * Fraction(1 / math.cos(math.pi / count))
    rays = [ray(Fraction(k, count)) for k in range(count)]
    if not all(side_is_outside(far, a, b, radius) for a, b in zip(rays, [*rays[1:], rays[0]], strict=True)):
        raise ArithmeticError("required a polygon that holds its disc")
    return tuple(_times(far, direction) for direction in rays)


def ring(inner: Fraction, outer: Fraction, sectors: int) -> Iterator[AnnulusPiece]:
    """Pieces that cover a ring."""
    width = Fraction(1, sectors)
    for k in range(sectors):
        yield AnnulusPiece(inner, outer, k * width, width)


@lru_cache(maxsize=4096)
def ray(share: Fraction) -> Place:
    """A rational direction of length about one, at a share of a full turn."""
    angle = 2 * math.pi * float(share % 1)
    return Fraction(math.cos(angle)), Fraction(math.sin(angle))


def side_is_outside(far: Fraction, first: Place, last: Place, radius: Fraction) -> bool:
    """Whether the side between two points ``far`` along their rays is no nearer than a radius."""
    (a, b), (c, d) = _times(far, first), _times(far, last)
    area = a * d - b * c
    return area > 0 and area * area >= radius * radius * _square((c - a, d - b))


def _times(factor: Fraction, place: Place) -> Place:
    return factor * place[0], factor * place[1]


def _square(place: Place) -> Fraction:
    return place[0] ** 2 + place[1] ** 2
