"""Inequalities that are hard together: one limit of work for all, and nothing but `undecided` comes of it."""

from __future__ import annotations

import pytest

from nonsmooth.analysis.cells.switched_cells import square_regions
from nonsmooth.proofs.inequalities.effort import effort_left, effort_of_its_own, shared_effort
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.prover import Counterexample, Proof, Undecided, prove
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.systems.derivatives import EFFORT
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from tests.plain import built

FIELD = NumberField()
X, Y = (Polynomial.variable(FIELD, ("x", "y"), name) for name in ("x", "y"))
# Positive, but zero along a curve that no cut hits up to a small rest: much work.
HARD = (X**2 * 7 - Y**3 + X * 3 - Y) ** 2 * 10**12 + 1


@pytest.mark.parametrize("frequency", [1_000_000])
def test_an_audit_ends_after_the_work_of_all_its_inequalities(frequency: int) -> None:
    rhs = [f"-sign(x) - sin({frequency}*y)", f"-sign(y) - sin({frequency}*x)"]
    system = built(rhs, radius=1)
    with shared_effort(10**9):
        found = audit(system, "x**2 + y**2")
        spent = 10**9 - effort_left()
    assert spent < 2 * EFFORT
    assert found.verdict is AuditVerdict.UNDECIDED


def test_without_effort_easy_inequalities_are_decided_and_hard_ones_are_left_open() -> None:
    [region, *_] = square_regions(FIELD.one)
    with shared_effort(0):
        assert isinstance(prove(Sense.POSITIVE, X**2 + Y**2 + 1, region), Proof)
        assert isinstance(prove(Sense.POSITIVE, X - Y, region), Counterexample)
        assert isinstance(prove(Sense.POSITIVE, HARD, region), Undecided)


def test_efforts_count_for_those_around_them_but_for_one_of_its_own() -> None:
    [region, *_] = square_regions(FIELD.one)
    with shared_effort(10_000):
        with effort_of_its_own(3_000):
            prove(Sense.POSITIVE, HARD, region)
            assert effort_left() == 0
        assert effort_left() == 10_000
        with shared_effort(1_000):
            prove(Sense.POSITIVE, HARD, region)
            assert effort_left() == 0
        assert 7_000 < effort_left() <= 9_000
