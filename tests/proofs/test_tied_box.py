"""Translation verdicts under rule ``box`` at corners of the cells, against paths that do not use the cells."""

from __future__ import annotations

import pytest

from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.findings.verdicts import Translation
from tests.conftest import Arrays
from tests.oracles.agreement import box_contradiction
from tests.oracles.box_paths import observe_box
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.tied_box_arrays import tied_box

TIED, BLOCKS = 50, 25


@pytest.mark.parametrize("block", range(BLOCKS))
def test_verdicts_at_corners_of_cells_agree_with_paths(arrays: Arrays, block: int) -> None:
    size = TIED // BLOCKS
    for seed in range(size * block, size * (block + 1)):
        wheels, at, partition = tied_box(arrays, seed)
        result = decide_translation(partition)
        assert evidence_holds(result)
        found = box_contradiction(result, observe_box(wheels, at))
        assert not found, f"seed {seed}: {found}; at {at}, {wheels}"


def test_a_stable_corner_lets_the_distance_grow_two_hundredfold(arrays: Arrays) -> None:
    """A velocity that leaves its cell at an angle of 0.0047 rad: paths grow as far as the fan bounds, and rest."""
    wheels, at, partition = tied_box(arrays, 1_000_254)
    result = decide_translation(partition)
    assert result.verdict is Translation.STABLE
    assert result.fan is not None
    assert result.fan.squared_overshoot is not None
    assert 200 < float(result.fan.squared_overshoot) ** 0.5 < 220
    assert observe_box(wheels, at).rested == 24
