"""Plain systems tied at the equilibrium: no verdict contradicts what the formulas do there as numbers.

The large version with counts is ``tests/benchmarks/test_plain_ties_at_large.py``.
"""

from __future__ import annotations

from fractions import Fraction

import pytest

from nonsmooth.proofs.findings.verdicts import Equilibrium
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.domain import plane_cells
from nonsmooth.proofs.systems.ray_moves import decide_equilibrium
from tests.proofs.conftest import Load
from tests.proofs.plain_agreement import contradictions
from tests.proofs.plain_ties import Oracle, Tie, holds_zero, random_tie
from tests.thorough import few, thorough

ZERO = ("0", "0")


@few(1)
@pytest.mark.parametrize("seed", range(0, 100, 5))
def test_equilibria_of_tied_systems(load: Load, seed: int) -> None:
    for k in range(seed, seed + 5):
        tie = random_tie(k)
        found = decide_equilibrium(plane_cells(load(*tie.rhs)))
        assert found is not Equilibrium.UNDECIDED
        assert (found is Equilibrium.HOLDS) == Oracle(tie).rests_at_origin(), tie


@few(1)
@pytest.mark.parametrize("seed", [*range(1000, 1012)])
def test_verdicts_on_tied_systems(load: Load, seed: int) -> None:
    tie = random_tie(seed)
    result = decide_system(load(*tie.rhs))
    assert result.check()
    assert contradictions(result, Oracle(tie)) == [], tie


# ---- the oracle itself, where the answer is plain ----------------------------------------------------


def test_the_oracle_sees_narrow_cells_and_only_real_ones() -> None:
    between = Tie(ZERO, (("(1)", "(y - x**2)*(y - 2*x**2)", ("1", "0")),))
    assert Oracle(between).rests_at_origin()  # 1 outside, -1 between the parabolas
    isolated = Tie(ZERO, (("(1)", "x**3 - x**2 - y**2", ("1", "0")),))
    assert not Oracle(isolated).rests_at_origin()
    far = Tie(ZERO, (("(1)", "y + x**2 + 1", ("1", "0")),))
    assert not Oracle(far).rests_at_origin()


@thorough  # the small one: test_the_oracle_sees_narrow_cells_and_only_real_ones
def test_the_oracle_finds_equilibria_and_escapes() -> None:
    line = Oracle(Tie(ZERO, (("(-1)", "y", ("0", "1")),)))
    assert line.rests_at(Fraction(1, 64), Fraction(0))
    assert not line.rests_at(Fraction(1, 64), Fraction(1, 64))
    assert line.equilibria_nearby()
    saddle = Oracle(Tie(("x", "-y"), ()))
    assert saddle.escapes_at(Fraction(1, 64), Fraction(0))
    assert not saddle.escapes_at(Fraction(0), Fraction(1, 64))
    assert saddle.spread(1e-5, 0.2, 6000, 2e-3)[0] > 1e3
    assert Oracle(Tie(("-x", "-2*y"), ())).spread(1e-2, 0.2, 3000, 2e-3)[0] < 1.01


@pytest.mark.parametrize(
    ("vectors", "expected"),
    [([(1, 0)], False), ([(1, 0), (-2, 0)], True), ([(1, 0), (-1, 1), (-1, -1)], True), ([(1, 0), (0, 1)], False)],
)
def test_hulls_of_the_oracle(vectors: list[tuple[int, int]], expected: bool) -> None:
    assert holds_zero([(Fraction(a), Fraction(b)) for a, b in vectors]) is expected
