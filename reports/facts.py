"""The facts of a result, written down: as a JSON record, as lines for a terminal, as sentences of a report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from flint import arb

from nonsmooth.proofs.facts import Fact, Quantity
from nonsmooth.reports.document import Bullets, Inline, number
from nonsmooth.reports.exact_record import Record, exact_texts, floats
from nonsmooth.reports.prose import prose
from nonsmooth.symbolic.number_text import brief_text, short_text
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number


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


def fact_list(facts: Iterable[Fact]) -> list[Bullets]:
    """The sentences as a list of a report, with numbers as formulas; no list where there are none."""
    told = [fact for fact in facts if fact.words and not fact.explained]
    items = [prose(fact.words, *map(_entry, fact.shown)) for fact in told]
    return [Bullets(tuple(items))] if items else []


def _entry(shown: Any) -> Inline:
    if isinstance(shown, Number):
        return number(shown)
    return brief_text(shown) if isinstance(shown, Lazy | arb) else str(shown)
