"""Which cases of a check run in ``make bench`` only."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.thorough import is_further, thorough, unlike

TESTS = Path(__file__).parent


@pytest.mark.parametrize(
    ("names", "number", "kept"),
    [
        ("a b c d e", 1, [0]),
        ("a b c d e", 3, [0, 4, 2]),  # far apart
        ("ring-box ring-ellipse grid-box grid-ellipse", 2, [0, 3]),  # another rule and another scene
        ("a b", 5, [0, 1]),
    ],
)
def test_kept_cases_differ(names: str, number: int, kept: list[int]) -> None:
    assert unlike([set(name.split("-")) for name in names.split()], number) == kept


def test_the_first_array_is_kept_under_every_rule() -> None:
    cases: list[Any] = [
        SimpleNamespace(nodeid=f"t.py::test_it[{seed}-{rule}]", callspec=SimpleNamespace(params={"seed": seed}))
        for seed in (3, 1)
        for rule in ("box", "ellipse")
    ]
    first: defaultdict[tuple[str, str], list[Any]] = defaultdict(list)
    assert [is_further(case, first) for case in cases] == [False, False, True, True]


def test_properties_inside_tests_have_all_their_examples() -> None:
    """They carry no mark of Hypothesis, so that ``make bench`` would not run them again."""
    inside = re.compile(r"^ +@examples\(", re.MULTILINE)
    assert [path.name for path in TESTS.rglob("test_*.py") if inside.search(path.read_text(encoding="utf-8"))] == []


def test_the_mark_is_the_one_of_the_makefile() -> None:
    makefile = (TESTS.parent / "Makefile").read_text(encoding="utf-8")
    assert f'-m "not {thorough.name}"' in makefile
    assert f'-m "{thorough.name} or hypothesis" --hypothesis-profile all' in makefile
