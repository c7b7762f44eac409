"""Values of a JSON record: floats for reading, an ``exact`` object beside those that are exact.

In every object, ``exact`` maps a key of the same object to the exact text of its value, nested like the value
(``"worst_rate": -2.0, "exact": {"worst_rate": "-2"}``).  The texts are formulas that scene files accept; where the
exact form of a vertex would be endless, an enclosure ``[0.123 +/- 4e-21]`` stands instead.  Sampled values have none.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, TypeAlias

from flint import arb

from nonsmooth.symbolic.number_text import real_text
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number

Record: TypeAlias = dict[str, Any]


def with_exact(values: Record) -> Record:
    """The values as floats, and their exact texts under ``exact``."""
    exact = {key: exact_texts(value) for key, value in values.items() if value is not None}
    return {**{key: floats(value) for key, value in values.items()}, "exact": exact}


def floats(value: Any) -> Any:
    """Numbers as floats, through nested tuples; None beyond the range of floats (JSON has no infinity)."""
    if value is None:
        return None
    if isinstance(value, Number | Lazy | arb | Fraction | float | int):
        number = float(value)
        return number if math.isfinite(number) else None
    return [floats(entry) for entry in value]


def exact_texts(value: Any) -> Any:
    """The exact texts of numbers, nested like them; None where they are sampled, or there are none."""
    if value is None or isinstance(value, float):
        return None
    if isinstance(value, Fraction):
        return str(value)
    if isinstance(value, Number | Lazy | arb):
        return real_text(value)
    return [exact_texts(entry) for entry in value]
