"""Further cases of checks that ``make test`` runs on fewer of them, so that it stays short; ``make bench`` runs all.

A check over random arrays (a parameter ``seed`` or ``block``) keeps its first ones, see :mod:`tests.conftest`.
Others name what they keep with :func:`keep`, or mark a whole test with :data:`thorough` where a smaller test of the
same claim stands beside it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

SEEDED = {"seed": 5, "block": 2}  # parameters of random arrays, and how many of each check are kept

thorough = pytest.mark.thorough


def keep(kept: int, cases: Iterable[Any]) -> list[Any]:
    """The cases of a parameter, those after the first ones marked as thorough.

    Args:
        kept: how many are not marked.
        cases: values, or tuples of values for several parameters.
    """
    listed = list(cases)
    further = [pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=thorough) for case in listed[kept:]]
    return [*listed[:kept], *further]


def is_further(item: pytest.Item) -> bool:
    """Whether a test is about a random array beyond the first ones of its check."""
    callspec = getattr(item, "callspec", None)
    indices = {} if callspec is None else callspec.indices
    return any(indices.get(name, 0) >= kept for name, kept in SEEDED.items())
