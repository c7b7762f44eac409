"""The facts of a result, written down: as a JSON record and as lines for a terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Any

from flint import arb

from nonsmooth.proofs.findings import Fact, Quantity, Record
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import real_text, short_text


def fact_record(facts: Iterable[Fact]) -> Record:
    """A JSON object of all facts that have a key."""
    return as_record({fact.key: fact.value for fact in facts if fact.key})


def as_record(values: Mapping[str, Any]) -> Record:
    """A mapping as JSON: quantities as floats, and under ``exact`` the texts of those that are exact."""
    record: Record = {}
    exact: Record = {}
    has_quantities = False
    for key, value in values.items():
        if isinstance(value, Quantity):
            has_quantities = True
            record[key] = floats(value.value)
            texts = exact_texts(value.value)
            if texts is not None:
                exact[key] = texts
        else:
            record[key] = _as_json(value)
    return {**record, "exact": exact} if has_quantities else record


def _as_json(value: Any) -> Any:
    if isinstance(value, Mapping):
        return as_record(value)
    if isinstance(value, tuple):
        return fact_record(value)
    if isinstance(value, list):
        return [_as_json(entry) for entry in value]
    return value


def fact_lines(facts: Iterable[Fact]) -> list[str]:
    """The sentences, with short numbers exact and long ones as decimals."""
    return [_line(fact) for fact in facts if fact.words]


def fact_rows(facts: Iterable[Fact]) -> list[tuple[str, str]]:
    """Names and sentences of the facts that have a row of their own, nested ones in their place."""
    rows: list[tuple[str, str]] = []
    for fact in facts:
        if fact.row:
            rows.append((fact.row, _line(fact)))
        if isinstance(fact.value, tuple):
            rows += fact_rows(fact.value)
    return rows


def _line(fact: Fact) -> str:
    return fact.words.format(*map(short_text, fact.shown)) if fact.shown else fact.words


# ---- values of a record --------------------------------------------------------------------------
#
# In every object, ``exact`` maps a key of the same object to the exact text of its value, nested like the value
# (``"worst_rate": -2.0, "exact": {"worst_rate": "-2"}``).  The texts are formulas that scene files accept; where the
# exact form of a vertex would be endless, an enclosure ``[0.123 +/- 4e-21]`` stands instead.  Sampled values have none.


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
    texts = [exact_texts(entry) for entry in value]
    return None if texts and not any(texts) else texts
