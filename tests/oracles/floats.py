"""Formulas as numbers in floats, as Python reads them, and small steps: shares nothing with the product."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from types import CodeType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]

NAMES: dict[str, Any] = {
    "__builtins__": {},
    **{"sin": np.sin, "cos": np.cos, "sqrt": np.sqrt, "pi": math.pi},
    **{"tanh": np.tanh, "atan": np.arctan, "exp": np.exp},
    **{"Abs": np.abs, "sign": np.sign, "sgn": np.sign, "Max": np.maximum, "Min": np.minimum},
    "relu": lambda v: np.maximum(v, 0.0),
    "sat": np.clip,
}


@cache
def _compiled(*texts: str) -> CodeType:
    """One formula, or several as a list."""
    joined = texts[0].strip() if len(texts) == 1 else f"[{', '.join(text.strip() for text in texts)}]"
    return compile(joined, "formula", "eval")


def value(text: str, **places: Any) -> Any:
    """A formula of a test, or one that the program has found, at numbers or arrays of them."""
    return eval(_compiled(text), NAMES, places)  # noqa: S307 - texts of tests and of the program alone


def velocity(rhs: Sequence[str], places: Any, states: Sequence[str] = "xyz") -> Floats:
    """The formulas of a right-hand side at places, one row for each state, as the places have."""
    named, zero = dict(zip(states, places, strict=False)), 0.0 * places[0]
    rates = eval(_compiled(*rhs, "0"), NAMES, named)[:-1]  # noqa: S307 - as above
    return np.array([rate + zero for rate in rates])


def spread(
    velocity: Callable[[Floats], Floats], start: float, steps: int, fineness: float, far: float
) -> tuple[float, float]:
    """Largest distance that an Euler polygon from a circle reaches, and the largest at the end, over the radius.

    Args:
        velocity: at places, one per row.
        start: the radius.
        steps: of each polygon.
        fineness: length of a step over the distance.
        far: distance at which a polygon is given up as gone.
    """
    angles = (np.arange(24) + 0.31) * (2 * math.pi / 24)
    points, largest = start * np.column_stack([np.cos(angles), np.sin(angles)]), start
    for _ in range(steps):
        rates = velocity(points)
        speed, size = np.hypot(*rates.T), np.hypot(*points.T)
        moving = (speed > 1e-9 * size) & (size > 1e-9 * start) & (size < far)
        if not moving.any():
            break
        points = points + np.where(moving, fineness * size / np.maximum(speed, 1e-300), 0.0)[:, None] * rates
        largest = max(largest, float(np.hypot(*points.T).max()))
    return largest / start, float(np.hypot(*points.T).max()) / start


def midpoint(rate: Callable[[Any], Any], z: Any, step: Any) -> Any:
    """A step of second order."""
    return z + step * rate(z + step / 2 * rate(z))


def runge_kutta(rate: Callable[[Any], Any], z: Any, step: Any) -> Any:
    """A step of fourth order."""
    a = rate(z)
    b = rate(z + step / 2 * a)
    c = rate(z + step / 2 * b)
    return z + step / 6 * (a + 2 * b + 2 * c + rate(z + step * c))


def sizes_after(field: Callable[..., Any], starts: Floats, step: float, steps: int) -> Floats:
    """Distances from the point of paths from starts (m, n), by Runge and Kutta with equal steps."""

    def rate(places: Floats) -> Floats:
        return np.stack(field(*places), axis=0)

    z = starts.T.copy()
    for _ in range(steps):
        z = runge_kutta(rate, z, step)
    return np.asarray(np.linalg.norm(z, axis=0))
