"""The products of :mod:`nonsmooth.symbolic.numbers.plane` for float arrays of plane vectors, the coordinates last."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.symbolic.numbers import plane

Floats: TypeAlias = NDArray[np.float64]


def turned(vectors: Floats) -> Floats:
    """``J v``: a quarter turn counterclockwise of vectors of shape (..., 2)."""
    return np.stack(plane.turned(_coordinates(vectors)), axis=-1)


def cross(a: Floats, b: Floats) -> Floats:
    """``a_x b_y - a_y b_x`` for vectors of shape (..., 2)."""
    return np.asarray(plane.cross(_coordinates(a), _coordinates(b)))


def _coordinates(vectors: Floats) -> tuple[Floats, Floats]:
    return vectors[..., 0], vectors[..., 1]
