"""The weights with which the ends that enclose a sine or cosine mix to its value, in floats.

With ``sin v = v - v^3/6 + e v^5/120`` and ``cos v = 1 - v^2/2 + v^4/24 - e v^6/720``
(:mod:`nonsmooth.symbolic.sine_enclosures`) this is e, which lies between 0 and 1.
"""

from __future__ import annotations

from math import cos, sin

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.symbolic.sine_enclosures import Wave

SERIES_BELOW = 0.25  # of v, where the series of e is good to 1e-9 and its factor v^5 below 1e-5
LARGEST = 50.0  # of v: farther out the powers of v, each rounded, hold sin v and cos v to less than 1e-9


def wave_weight(wave: Wave, v: float) -> float:
    """The e of a wave at its argument v; near v = 0 by its series.

    Raises:
        RefusalError: where v is so large that floats do not hold the value that e stands for.
    """
    if not abs(v) <= LARGEST:
        raise RefusalError(f"the argument of a sine is {v:.3g}: beyond {LARGEST:g} floats do not hold its enclosure")
    if abs(v) < SERIES_BELOW:
        first, second = (42, 3024) if wave.kind == "sin" else (56, 5040)
        return 1 - v * v / first + v**4 / second
    if wave.kind == "sin":
        return float((sin(v) - v + v**3 / 6) * 120 / v**5)
    return float((1 - v * v / 2 + v**4 / 24 - cos(v)) * 720 / v**6)
