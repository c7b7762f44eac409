"""A toy stepper: the implicit midpoint rule with steps of one size."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nonsmooth.analysis.trajectories.follow import DenseStep, Interpolant, Rate
from nonsmooth.symbolic.numbers.plane_arrays import Floats


class ImplicitMidpoint:
    """``x + h k`` with ``k = f(t + h/2, x + h k/2)``, by fixed-point iteration; straight lines between steps.

    It keeps quadratic invariants, such as the energy of an oscillator, whatever the step.
    """

    def __init__(self, size: float) -> None:
        self._size = size

    def steps(self, rate: Rate, t: float, x: Floats, until: float) -> Iterator[DenseStep]:
        """Steps up to the last time."""
        while t < until:
            h = min(self._size, until - t)
            slope = rate(t, x)
            for _ in range(100):
                following = rate(t + h / 2, x + h / 2 * slope)
                if np.array_equal(following, slope):
                    break
                slope = following
            yield DenseStep((t, x), (t + h, x + h * slope), lambda line=(t, x, slope): _line(*line))  # type: ignore[misc]
            t, x = t + h, x + h * slope


def _line(start: float, x: Floats, slope: Floats) -> Interpolant:
    return lambda t: (x + np.multiply.outer(t - start, slope)).T
