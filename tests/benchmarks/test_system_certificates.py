"""Mutants of certificates of plain systems by the thousand: rejected, or still true along paths."""

from __future__ import annotations

import pytest

from tests.proofs.test_system_checker import attack


@pytest.mark.benchmark
def test_ten_thousand_mutants() -> None:
    accepted = attack(10_000, 7)
    print(f"{accepted} of 10,000 mutants accepted, all of them still true")
    assert 0 < accepted < 10_000
