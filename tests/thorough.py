"""Which cases ``make test`` runs, so that it stays short; ``make bench`` runs the others, which are marked `thorough`.

1. A check over random arrays (a parameter of :data:`SEEDED`) keeps the first one, with all its other parameters.
2. A check of many long cases (:func:`few`) keeps as many as take about half a second together: its first, then those
   that have most in their names that no kept case has, such as another rule and another scene (:func:`unlike`).
3. A test may say itself which of its cases are kept (:func:`keep`, :func:`but`), or be left to ``make bench`` as a
   whole (:data:`thorough`) where a smaller test of the same claim stands beside it, which a comment then names.
4. A property of any input (Hypothesis) is tried on fewer examples (:func:`examples`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings

SEEDED = {"seed": 1, "block": 1}  # parameters of random arrays, and how many of each check are kept

# Profiles of Hypothesis: `make bench` asks for the second. The same examples in every run, and no failure because the
# machine is busy.
SOME, ALL = "some", "all"
SHARE = 4  # all examples over some
settings.register_profile(SOME, derandomize=True, database=None, deadline=None, max_examples=100 // SHARE)
settings.register_profile(ALL, derandomize=True, database=None, deadline=None, max_examples=100)

thorough = pytest.mark.thorough


def few(kept: int) -> pytest.MarkDecorator:
    """Of a check of many long cases: how many ``make test`` keeps, as many as together take about half a second."""
    return pytest.mark.few(kept)


def keep(kept: int, cases: Iterable[Any]) -> list[Any]:
    """The cases of a parameter, those after the first ones marked as thorough.

    Args:
        kept: how many are not marked.
        cases: values, or tuples of values for several parameters.
    """
    listed = list(cases)
    further = [pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=thorough) for case in listed[kept:]]
    return [*listed[:kept], *further]


def but(long: Iterable[Any], cases: Iterable[Any]) -> list[Any]:
    """The cases of a parameter, the long ones marked as thorough: of the same claim others take less time.

    Args:
        long: which ones are marked, each one of the cases.
        cases: values of one parameter.
    """
    listed, left_out = list(cases), list(long)
    if not all(case in listed for case in left_out):
        raise ValueError(f"required cases of the parameter, received {left_out}")
    return [pytest.param(case, marks=thorough) if case in left_out else case for case in listed]


def examples(number: int) -> settings:
    """Settings of a property that ``make bench`` tries on so many examples, and ``make test`` on fewer.

    Only for properties that are tests themselves: pytest does not see those inside a test, nor would ``make bench``.
    """
    return settings(max_examples=max(1, number * settings().max_examples // 100))


def mark_further(items: Iterable[pytest.Item]) -> None:
    """Mark further random arrays, and of the checks with :func:`few` the cases that are not kept."""
    checks: defaultdict[str, list[pytest.Item]] = defaultdict(list)
    first: dict[tuple[str, str], list[Any]] = defaultdict(list)
    for item in items:
        if is_further(item, first):
            item.add_marker(thorough)
        elif item.get_closest_marker("thorough") is None and item.get_closest_marker("few") is not None:
            checks[check_of(item)].append(item)
    for cases in checks.values():
        (number,) = next(cases[0].iter_markers("few")).args
        kept = unlike([words_of(case) for case in cases], number)
        for k in set(range(len(cases))) - set(kept):
            cases[k].add_marker(thorough)


def unlike(cases: list[set[str]], number: int) -> list[int]:
    """The places of cases that differ much: the first, then those with most new words, far from those before.

    Args:
        cases: the words in the name of each.
        number: how many are taken, at most all.
    """
    taken = [0]
    while len(taken) < min(number, len(cases)):
        shown = set[str]().union(*(cases[k] for k in taken))
        others = [k for k in range(len(cases)) if k not in taken]
        taken.append(max(others, key=lambda k: (len(cases[k] - shown), min(abs(k - j) for j in taken))))
    return taken


def words_of(item: pytest.Item) -> set[str]:
    """What a case shows, by its name: ``test_a_claim[ring-5-box]`` shows ring, 5 and box."""
    return set(item.name.partition("[")[2].removesuffix("]").split("-"))


def check_of(item: pytest.Item) -> str:
    """The name of a test without its case."""
    return item.nodeid.partition("[")[0]


def is_further(item: pytest.Item, first: dict[tuple[str, str], list[Any]]) -> bool:
    """Whether a test is about a random array beyond the first ones of its check, whatever its other parameters are.

    Args:
        item: the test.
        first: the values of each parameter of a check that were met before, which grows.
    """
    callspec = getattr(item, "callspec", None)
    params = {} if callspec is None else callspec.params
    for name in SEEDED.keys() & params.keys():
        met = first[check_of(item), name]
        if params[name] not in met:
            met.append(params[name])
        if met.index(params[name]) >= SEEDED[name]:
            return True
    return False
