"""Distances in floats with margins for their rounding: what they rule out needs no exact arithmetic.

What lies beyond a margin is certain; what lies within it is left to exact arithmetic.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.polygon import Point, Polygon
from nonsmooth.symbolic.numbers.number import sign

Place: TypeAlias = Sequence[float]  # x, y

# Relative to the coordinates and distances at hand: in double precision they err by less than 2^-46, so a wheel
# beyond this margin is certainly not among the two nearest, and a wheel within it is kept for the exact test.
CANDIDATE_MARGIN = 2.0**-29
SMALLEST_NORMAL = float(np.finfo(np.float64).tiny)  # below it floats lose their relative accuracy


def float_vertices(region: Polygon) -> list[Place]:
    """The vertices of a region in floats."""
    return [float_point(vertex) for vertex in region.vertices]


def clear_signs(corners: Sequence[Place], near: Place, far: Place) -> list[int]:
    """Signs of ``|c - far| - |c - near|`` at corners where floats are sure, 0 where they are not.

    Beyond the range of floats a difference is nan or its bound is infinite: then nothing is sure.
    """
    size = _size(corners) + _size([near]) + _size([far])
    signs = []
    for corner in corners:
        to_near, to_far = distance(corner, near), distance(corner, far)
        farther = to_far - to_near
        clear = abs(farther) > CANDIDATE_MARGIN * (size + to_far + to_near) + SMALLEST_NORMAL
        signs.append(sign(farther) if clear else 0)
    return signs


def reach_of(corners: Sequence[Place], place: Place) -> float:
    """Distance from a wheel to the farthest vertex, never too small."""
    size = _size(corners) + _size([place])
    return max(distance(corner, place) for corner in corners) + CANDIDATE_MARGIN * size + SMALLEST_NORMAL


def _size(places: Sequence[Place]) -> float:
    """The largest coordinate."""
    return max(abs(value) for place in places for value in place)


def distance(a: Place, b: Place) -> float:
    """``|a - b|``, infinite or nan beyond the range of floats."""
    return math.hypot(a[0] - b[0], a[1] - b[1])


def distances_from(points: NDArray[np.float64], place: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same for many points, shape (n, 2), at once."""
    with np.errstate(over="ignore", invalid="ignore"):
        difference = points - place
        return np.asarray(np.hypot(difference[..., 0], difference[..., 1]))


def float_point(point: Point) -> Place:
    """An exact point in floats, rounded to nearest."""
    return [float(x) for x in point]
