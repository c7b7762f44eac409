"""The facts of a result as sentences of a report."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from flint import arb

from nonsmooth.proofs.facts import Fact
from nonsmooth.reports.document import Bullets, Inline, number
from nonsmooth.reports.prose import prose
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number


def fact_list(facts: Iterable[Fact]) -> list[Bullets]:
    """The sentences as a list of a report, with numbers as formulas; no list where there are none."""
    told = [fact for fact in facts if fact.words and not fact.explained]
    items = [prose(fact.words, *map(_entry, fact.shown)) for fact in told]
    return [Bullets(tuple(items))] if items else []


def _entry(shown: Any) -> Inline:
    if isinstance(shown, Number):
        return number(shown)
    return brief_text(shown) if isinstance(shown, Lazy | arb) else str(shown)
