"""The facts of a result, written down: as a JSON record and as lines for a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from nonsmooth.proofs.facts import Fact, Quantity
from nonsmooth.reports.exact_record import Record, exact_texts, floats
from nonsmooth.symbolic.number_text import short_text


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
