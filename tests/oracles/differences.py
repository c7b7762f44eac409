"""Switching functions whose gradients are central differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nonsmooth.analysis.fields.switched_field import Surface
from nonsmooth.symbolic.numbers.plane_arrays import Floats

# Relative step of central differences: the cube root of the rounding error, where both errors are 1e-11.
STEP = 6e-6


def smooth_surface(name: str, value: Callable[[Floats], float]) -> Surface:
    """A switching function without a given gradient: central differences."""

    def gradient(x: Floats) -> Floats:
        steps = STEP * np.maximum(1.0, np.abs(x))
        moves = np.diag(steps)
        return np.array([(value(x + m) - value(x - m)) / (2 * s) for m, s in zip(moves, steps, strict=True)])

    return Surface(name, value, gradient)
