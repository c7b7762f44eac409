"""Float arrays of plane vectors, the coordinates last: the counterpart of :mod:`nonsmooth.symbolic.plane`."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]


def turned(vectors: Floats) -> Floats:
    """``J v``: a quarter turn counterclockwise of vectors of shape (..., 2)."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def cross(a: Floats, b: Floats) -> Floats:
    """``a_x b_y - a_y b_x`` for vectors of shape (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
