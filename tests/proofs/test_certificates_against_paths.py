"""What the checker accepts about translation, against paths that share no theory with it.

The other mutation test decides accepted mutants again by the workbench, whose theorems are the checker's own: an error
in these would pass.  Here the array of each accepted certificate is read back from its own data and followed by the
definitions.
"""

from __future__ import annotations

import copy
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pytest

from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.theorem4 import check_cells
from tests.array_certificates import check_certificate, said, say, subject
from tests.oracles.nearest_paths import End, Wheel, observe
from tests.oracles.tied_arrays import tied_array
from tests.oracles.tied_scenes import scene_of

if TYPE_CHECKING:
    from tests.conftest import Arrays

Record: TypeAlias = dict[str, Any]

ARRAYS, BLOCKS, MUTANTS = 30, 30, 12
WORDS = ("asymptotically stable", "stable", "unstable", None)
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


@lru_cache(maxsize=1)
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


def mutants(certificate: Record, rng: np.random.Generator) -> list[Record]:
    """Certificates with another word for the translation, with another conclusion, and with another speed or place."""
    found = []
    for word in WORDS:
        changed = copy.deepcopy(certificate)
        say(changed, translation=word)
        for conclusion in ("holds", "fails", "hypotheses not met", None):
            other = copy.deepcopy(changed)
            say(other, theorem4=conclusion)
            found.append(other)
    for _ in range(MUTANTS):
        changed = copy.deepcopy(certificate)
        wheel = subject(changed)["wheels"][rng.integers(len(subject(changed)["wheels"]))]
        factor = Fraction(int(rng.integers(1, 6)), int(rng.integers(1, 6)))
        kind = rng.choice(["speed", "friction", "position"])
        if kind == "speed":
            wheel["speed"] = str(factor * Fraction(wheel["speed"]))
        else:
            wheel[kind] = [str(factor * Fraction(text)) for text in wheel[kind]]
        found.append(changed)
    return found


@pytest.mark.parametrize("block", range(BLOCKS))
def test_accepted_certificates_of_tied_arrays_agree_with_paths(arrays: Arrays, block: int) -> None:
    size, accepted = ARRAYS // BLOCKS, 0
    rng = np.random.default_rng(block)
    for seed in range(size * block, size * (block + 1)):
        wheels, _ = tied_array(seed)
        original = build_certificate(check_cells(scene_of(arrays, wheels)))
        assert check_certificate(original) == ""
        assert_paths_agree(original, seed)
        for forged in mutants(original, rng):
            if not check_certificate(forged):
                accepted += 1
                assert_paths_agree(forged, seed)
    assert accepted >= size  # at least the originals, among the words
