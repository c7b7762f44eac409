"""What the checker accepts about translation, against paths that share no theory with it.

The workbench's own decision of an array that is built anew rests on the checker's theorems: an error in these would
pass.  Here the array of each certificate is read back from its own data and followed by the definitions; so are the
arrays of mutants (tests/proofs/attacks.py).
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

import pytest

from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.theorem4 import check_cells
from tests.array_certificates import check_certificate, said, subject
from tests.conftest import Arrays
from tests.oracles.nearest_paths import End, Wheel, observe
from tests.oracles.tied_arrays import tied_array
from tests.oracles.tied_scenes import scene_of

Record: TypeAlias = dict[str, Any]

BLOCKS = 30
FORBIDDEN: dict[str | None, set[End]] = {
    "asymptotically stable": {End.LEAVES, End.RESTS, End.CYCLES},
    "stable": {End.LEAVES},
    None: set(),
}


def wheels_of(certificate: Record) -> list[Wheel]:
    """The wheels as fractions, seen from the checked point."""
    x, y = (Fraction(text) for text in subject(certificate)["at"])
    wheels = []
    for wheel in subject(certificate)["wheels"]:
        (px, py), (dx, dy), (roll, side) = (map(Fraction, wheel[key]) for key in ("position", "direction", "friction"))
        wheels.append(Wheel((px - x, py - y), (dx, dy), Fraction(wheel["speed"]), roll, side))
    return wheels


@lru_cache(maxsize=100)
def paths_end(wheels: tuple[Wheel, ...], seed: int) -> set[End]:
    """Most mutants of a certificate leave its array as it is."""
    return observe(wheels, seed=seed)


def assert_paths_agree(certificate: Record, seed: int) -> None:
    word = said(certificate).get("translation")
    ends = paths_end(tuple(wheels_of(certificate)), seed)
    if word == "unstable":
        assert End.LEAVES in ends
    else:
        assert not ends & FORBIDDEN[word], f"seed {seed}: {word}, but paths end {ends}"


@pytest.mark.parametrize("block", range(BLOCKS))
def test_accepted_certificates_of_tied_arrays_agree_with_paths(arrays: Arrays, block: int) -> None:
    wheels, _ = tied_array(block)
    original = build_certificate(check_cells(scene_of(arrays, wheels)))
    assert check_certificate(original) == ""
    assert_paths_agree(original, block)
