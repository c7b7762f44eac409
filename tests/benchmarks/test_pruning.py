"""Leaving out what no verdict needs: how much work is left (tests/proofs/test_theorem4.py: nothing else changes)."""

from __future__ import annotations

import pytest

from nonsmooth.proofs.theorem4 import CellCheck, check_cells
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import possible_triples
from tests.benchmarks.conftest import Stopwatch
from tests.built_in import verdicts, whole_check
from tests.conftest import Arrays


@pytest.mark.parametrize("name", builtin_scenes())
def test_built_in_scenes(name: str, stopwatch: Stopwatch) -> None:
    scene = load_scene(name, rule="nearest")
    pruned = check_cells(scene)
    assert pruned.partition.wheels_considered <= len(scene.wheels)
    stopwatch.report(
        f"{name}: {pruned.partition.wheels_considered} of {len(scene.wheels)} wheels, "
        f"{len(pruned.partition.states)} of {pruned.census.possible} row triples own a cell"
    )


@pytest.mark.parametrize("side", [8, 12])
def test_work_left_on_a_grid(arrays: Arrays, stopwatch: Stopwatch, side: int) -> None:
    """The triples are not counted here: C(288, 3) of them would drown every other cost."""
    scene = arrays.grid(side, side)
    pruned = check_cells(scene)
    assert pruned.partition.wheels_considered <= 16
    assert len(pruned.partition.states) == 8
    fast = stopwatch.best(lambda: check_cells(scene))
    stopwatch.report(
        f"{side} x {side}: {pruned.partition.wheels_considered} of {side * side} wheels, "
        f"8 of {possible_triples(side * side)} row triples, {fast * 1e3:.1f} ms"
    )


def test_pruning_pays(arrays: Arrays, stopwatch: Stopwatch) -> None:
    """What is shown of a whole check of 49 wheels (152,096 triples are counted) against that of the pruned one."""
    scene = arrays.grid(7, 7)
    results: list[CellCheck] = []

    def check(prune: bool) -> None:
        results.append(check_cells(scene) if prune else whole_check(scene))
        assert (results[-1].census.singular is None) == prune  # counted when they are shown

    whole = stopwatch.best(lambda: check(prune=False), runs=1)
    pruned = stopwatch.best(lambda: check(prune=True))
    assert verdicts(results[0]) == verdicts(results[1])
    stopwatch.report(
        f"7 x 7: pruned {pruned * 1e3:.1f} ms, whole {whole * 1e3:.0f} ms, ratio {whole / pruned:.0f} (required 10)"
    )
    assert whole >= 10 * pruned
