"""Mutants of certificates of plain systems by the thousand: rejected, or still true along paths."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.proofs import test_invariance_certificate, test_scalar_certificate, test_system_checker
from tests.proofs.many_states import test_many_certificate

ATTACKS: dict[str, tuple[Callable[[int, int], int], int]] = {
    "one state": (test_scalar_certificate.attack, 10_000),
    "two states": (test_system_checker.attack, 10_000),
    "invariance principle": (test_invariance_certificate.attack, 1_000),  # what is rejected there takes seconds
    "three states": (test_many_certificate.attack, 10_000),
}


@pytest.mark.benchmark
@pytest.mark.parametrize("states", ATTACKS)
def test_mutants_by_the_thousand(states: str) -> None:
    attack, count = ATTACKS[states]
    accepted = attack(count, 7)
    print(f"{states}: {accepted} of {count} mutants accepted, all of them still true")
    assert 0 < accepted < count
