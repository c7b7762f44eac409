"""Mutants of certificates of plain systems by the thousand: rejected, or still true along paths."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.proofs.kernel import test_roots, test_scalar

ATTACKS: dict[str, Callable[[int, int], int]] = {
    "one state": test_scalar.attack,
    "signed roots": test_roots.attack,
}


@pytest.mark.benchmark
@pytest.mark.parametrize("states", ATTACKS)
def test_ten_thousand_mutants(states: str) -> None:
    accepted = ATTACKS[states](10_000, 7)
    print(f"{states}: {accepted} of 10,000 mutants accepted, all of them still true")
    assert 0 < accepted < 10_000
