"""Ranks of the control vector fields against numerical rank."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.clauses.feedback.by_rows import decide_feedback
from nonsmooth.proofs.clauses.feedback.control_fields import input_ranks
from nonsmooth.proofs.findings.verdicts import Feedback
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE


def test_four_wheel_ranks(arrays: Arrays) -> None:
    """Two inputs per cell with roll rows, one with side rows; together they span all three directions."""
    roll = input_ranks(build_nearest_partition(arrays.four_wheel(ROLL)))
    side = input_ranks(build_nearest_partition(arrays.four_wheel(SIDE)))
    assert set(roll.cells.values()) == {2}
    assert set(side.cells.values()) == {1}
    assert roll.equilibrium == side.equilibrium == 3
    assert len(roll.sides) == 8


@pytest.mark.parametrize("seed", range(15))
def test_ranks_against_floats(arrays: Arrays, seed: int) -> None:
    partition = build_nearest_partition(arrays.cocircular(seed))
    ranks = input_ranks(partition)
    fields = {
        cell.index: [[float(x) for x in f] for state in cell.states for f in state.control_fields.values()]
        for cell in partition.cells
    }
    for index, rank in ranks.cells.items():
        assert rank == np.linalg.matrix_rank(np.array(fields[index]), tol=1e-9)
    for (first, second), rank in ranks.sides.items():
        assert rank == np.linalg.matrix_rank(np.array(fields[first] + fields[second]), tol=1e-9)


def test_one_input_alone_leaves_a_plane_on_which_v_cannot_fall(arrays: Arrays) -> None:
    feedback = decide_feedback(build_nearest_partition(arrays.four_wheel(SIDE)))
    assert feedback.verdict is Feedback.NOT_APPLICABLE
    assert feedback.witness is not None
    assert "plane" in feedback.witness.meaning
    assert any(feedback.witness.point) or feedback.witness.value
