"""The list of checks of which some cases run in ``make bench`` only is about tests that there are."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.thorough import EVERY, thorough

TESTS = Path(__file__).parent


@pytest.mark.parametrize("check", EVERY)
def test_a_listed_check_exists(check: str) -> None:
    file, _, name = check.partition("::")
    assert re.search(rf"^def {re.escape(name)}\(", (TESTS / file).read_text(encoding="utf-8"), re.MULTILINE), check


def test_the_first_case_of_every_check_is_kept() -> None:
    assert min(EVERY.values()) > 1
    assert thorough.name == "thorough"
