"""Mutants of certificates of plain systems by the thousand: rejected, or still true along paths."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.proofs import (
    test_fan_certificate,
    test_invariance_certificate,
    test_system_checker,
)
from tests.proofs.kernel import test_roots, test_scalar
from tests.proofs.many_states import test_many_certificate

ATTACKS: dict[str, Callable[[int, int], int]] = {
    "one state": test_scalar.attack,
    "two states": test_system_checker.attack,
    "velocities at the point": test_fan_certificate.attack,
    "invariance principle": test_invariance_certificate.attack,
    "signed roots": test_roots.attack,
    "three states": test_many_certificate.attack,
}


@pytest.mark.benchmark
@pytest.mark.parametrize("states", ATTACKS)
def test_ten_thousand_mutants(states: str) -> None:
    accepted = ATTACKS[states](10_000, 7)
    print(f"{states}: {accepted} of 10,000 mutants accepted, all of them still true")
    assert 0 < accepted < 10_000
