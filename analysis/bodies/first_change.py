"""When, within a step of an integrator, one of some signals of a path first changes its sign."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.analysis.bodies.body_stretch import DenseStep
from nonsmooth.analysis.fields.contact_model import Floats

LOOKS = 8  # places within a step where signals are looked at
RELATIVE_ULPS = 4 * float(np.finfo(float).eps)  # the smallest that SciPy takes

Signals: TypeAlias = Callable[[Floats], Floats]  # of states (m, d), shape (m, k), positive while all goes on


def first_change(signals: Signals, part: DenseStep, *, first: bool) -> tuple[float, int, int] | None:
    """The first time in a step at which a signal is negative, which signal, and how many there are.

    Args:
        signals: by the states.
        part: the step.
        first: whether a stretch begins with it, where signals that begin at zero may have either sign by rounding.
    """
    marks = np.linspace(part.start, part.end, LOOKS + 1)
    values = signals(part.state(marks).T)
    negative = values < 0
    negative[1:] &= (values[:-1] > 0) | (np.arange(LOOKS)[:, None] > 0) | (not first)
    for k in np.flatnonzero(negative[1:].any(axis=1)):
        crossed = np.flatnonzero(negative[k + 1])
        times = [_root(signals, part.state, marks[k], marks[k + 1], int(signal)) for signal in crossed]
        earliest = int(np.argmin(times))
        return times[earliest], int(crossed[earliest]), values.shape[1]
    return None


def sign_change(value: Callable[[float], float], low: float, high: float) -> float:
    """When a function that is positive at first changes its sign between two times, down to rounding.

    Many states at once and one alone may be rounded differently, so that a change that was seen among many may be none
    here: then it is the later time.  Where the function is not positive to begin with, it is the earlier one.

    Args:
        value: the function.
        low: the earlier time.
        high: the later time.
    """
    from scipy.optimize import brentq

    if value(low) <= 0:
        return low
    if value(high) >= 0:
        return high
    return float(brentq(value, low, high, xtol=float(np.spacing(high)), rtol=RELATIVE_ULPS))


def _root(signals: Signals, state: Any, low: float, high: float, signal: int) -> float:
    """When a signal changes its sign, down to rounding: the later side, where it has changed."""

    def value(time: float) -> float:
        return float(signals(state(time)[None])[0, signal])

    near, step = sign_change(value, low, high), float(np.spacing(high))
    while near < high and value(near) >= 0:
        near, step = min(near + step, high), 2 * step
    return near
