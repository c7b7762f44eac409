"""Translation verdicts of arrays with exact coincidences, against paths that know nothing of the fan of cones."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.answers.answer import Position
from nonsmooth.proofs.answers.contradictions import reconciled
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.findings.verdicts import Theorem4, Translation
from nonsmooth.proofs.theorem4 import check_cells, check_theorem4
from tests.conftest import Arrays
from tests.oracles.agreement import contradiction
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.nearest_paths import End, Wheel, observe
from tests.oracles.tied_arrays import FOUND, found_by_search, tied_array, untied_array
from tests.oracles.tied_scenes import CENTRE, LEAVES_FROM_1E_9, LEAVES_LIKE_A_ROOT, scene_of
from tests.thorough import thorough

TIED, UNTIED = 300, 100
BLOCKS, UNTIED_BLOCKS = 30, 10


def compare(arrays: Arrays, wheels: list[Wheel], seed: int) -> Translation:
    result = decide_translation(build_nearest_partition(scene_of(arrays, wheels)))
    assert evidence_holds(result)
    found = contradiction(result, observe(wheels, seed=seed))
    assert not found, f"seed {seed}: {found}; {wheels}"
    return result.verdict


# ---- arrays that were certified asymptotically stable ------------------------------------------


@pytest.mark.parametrize("wheels", [LEAVES_LIKE_A_ROOT, LEAVES_FROM_1E_9])
def test_a_velocity_along_a_ray_that_omega_bends_outward_lets_full_turns_diverge(
    arrays: Arrays, wheels: list[Wheel]
) -> None:
    assert observe(wheels, seed=0) == {End.LEAVES}
    result = check_theorem4(scene_of(arrays, wheels))
    assert result.translation.verdict is Translation.UNSTABLE
    assert result.verdict is Theorem4.FAILS
    assert result.check()


@pytest.mark.parametrize("wheels", [LEAVES_LIKE_A_ROOT, LEAVES_FROM_1E_9])
def test_a_verdict_that_the_own_paths_contradict_is_undecided(arrays: Arrays, wheels: list[Wheel]) -> None:
    result = check_cells(scene_of(arrays, wheels))
    forged = replace(result.translation, verdict=Translation.ASYMPTOTICALLY_STABLE)
    left, answered = reconciled(result.with_results(translation=forged))
    between = {one.between: one.sides for one in left.contradictions}
    said, seen = between["position and a path"]
    assert said.startswith("position comes home")
    assert seen.startswith("the path from")
    assert left.results["translation"].verdict is Translation.UNDECIDED
    assert left.verdict is Theorem4.UNDECIDED
    assert answered.answers[0].verdict is Position.UNDECIDED


def test_half_planes_whose_velocity_lies_along_their_line_have_gain_one(arrays: Arrays) -> None:
    assert observe(CENTRE, seed=0) == {End.CYCLES}
    result = decide_translation(build_nearest_partition(scene_of(arrays, CENTRE)))
    assert result.verdict is Translation.UNDECIDED
    assert result.fan is not None
    assert set(result.fan.gains.values()) == {1}


def test_the_oracle_follows_half_a_turn_about_the_point_itself() -> None:
    """In a half-plane with v = 0 the exit lies half a turn away, where the parameter of the arc is infinite."""
    wheels, _ = tied_array(1_031_836)
    assert observe(wheels, seed=1_031_836, starts=6) == {End.ARRIVES}


@thorough  # the others follow arrays of the file
def test_the_file_lists_the_arrays_that_a_search_finds() -> None:
    assert np.loadtxt(FOUND, dtype=int, delimiter=",").tolist() == found_by_search()


# ---- many --------------------------------------------------------------------------------------


@pytest.mark.parametrize("block", range(BLOCKS))
def test_verdicts_of_tied_arrays_agree_with_paths(arrays: Arrays, block: int) -> None:
    size = TIED // BLOCKS
    for seed in range(size * block, size * (block + 1)):
        wheels, _ = tied_array(seed)
        compare(arrays, wheels, seed)


@pytest.mark.parametrize("block", range(UNTIED_BLOCKS))
def test_verdicts_of_untied_arrays_agree_with_paths_and_are_decided(arrays: Arrays, block: int) -> None:
    size = UNTIED // UNTIED_BLOCKS
    seeds = range(size * block, size * (block + 1))
    verdicts = Counter(compare(arrays, untied_array(seed), seed) for seed in seeds)
    assert verdicts[Translation.UNDECIDED] == 0
