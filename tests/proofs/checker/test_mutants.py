"""Mutants of certificates: rejected in one line, or true."""

from __future__ import annotations

import pytest

from nonsmooth.proofs.checker.statements import THEOREMS
from tests.certificates.cases import cases
from tests.certificates.corpus import good_certificates, text_of
from tests.proofs.checker.mutants import Record, false_mutants, false_theorems
from tests.thorough import thorough

SMALL = 5_000  # bytes
FEW, MANY = 200, 10_000


def originals(theorem: str) -> list[Record]:
    """Small good certificates by a theorem."""
    good = good_certificates().values()
    return [own for own in good if own["evidence"][0]["theorem"] == theorem and len(text_of(own)) < SMALL]


@pytest.mark.parametrize("theorem", sorted(THEOREMS))
def test_mutants(theorem: str) -> None:
    """Some of each theorem."""
    false, _ = false_mutants(originals(theorem), FEW, seed=1)
    assert not false


@thorough  # the test above tries fewer
@pytest.mark.parametrize("theorem", sorted(THEOREMS))
def test_many_mutants(theorem: str) -> None:
    """Many of each theorem; some are accepted, and true."""
    false, accepted = false_mutants(originals(theorem), MANY, seed=2)
    assert not false
    assert accepted


@pytest.mark.parametrize("theorem", sorted(THEOREMS))
def test_mutants_with_evidence(theorem: str) -> None:
    """Subjects and hypotheses are changed, and the forger searches evidence for them."""
    flat = [case for case in cases() if case.theorem == theorem and len(case.subject["states"]) < 3]
    false, accepted = false_theorems(flat, 60, seed=3)
    assert not false
    assert accepted
