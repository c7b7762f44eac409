"""Switching functions whose gradients are central differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nonsmooth.analysis.fields.switched_field import Surface, Vector

# Relative step of central differences: the cube root of the rounding error, where both errors are 1e-11.
STEP = 6e-6


def smooth_surface(name: str, value: Callable[[Vector], float]) -> Surface:
    """A switching function without a given gradient: central differences."""

    def gradient(x: Vector) -> Vector:
        steps = STEP * np.maximum(1.0, np.abs(x))
        moves = np.diag(steps)
        return np.array([(value(x + m) - value(x - m)) / (2 * s) for m, s in zip(moves, steps, strict=True)])

    return Surface(name, value, gradient)
