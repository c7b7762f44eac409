"""Mutants of certificates: one letter changed at random.  A checker rejects them, or what they say is still true."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias

Record: TypeAlias = dict[str, Any]

DIGITS = "0123456789"
OPERATORS = "+-*"


def changed(part: Any, states: str, source: random.Random) -> Any:
    """Data with one digit, or one operator or state, of its JSON replaced by another; itself where that is no JSON."""
    text, letters = json.dumps(part), OPERATORS + states
    k = source.choice([k for k, letter in enumerate(text) if letter in DIGITS + letters])
    other = source.choice([c for c in (DIGITS if text[k] in DIGITS else letters) if c != text[k]])
    try:
        return json.loads(text[:k] + other + text[k + 1 :])
    except ValueError:
        return part


def mutant(record: Record, keys: Iterable[str], states: str, source: random.Random) -> Record:
    """A certificate with one letter of some of its entries changed."""
    return {**record, **changed({key: record[key] for key in keys}, states, source)}


def attack(
    originals: Sequence[Record],
    mutate: Callable[[Record, random.Random], Record],
    check: Callable[[Record], str],
    assert_true: Callable[[Record, random.Random], None],
    count: int,
    seed: int,
) -> int:
    """How many of many mutants are accepted; each of these is put to the test."""
    source, accepted = random.Random(seed), 0
    for k in range(count):
        forged = mutate(originals[k % len(originals)], source)
        if not check(forged):
            accepted += 1
            assert_true(forged, source)
    return accepted


def is_one_line(refused: str) -> bool:
    """Whether something is refused, in one line."""
    return bool(refused) and "\n" not in refused
