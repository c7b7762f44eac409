"""Rule ``nearest`` with rows without friction: what the clauses say where no pair of wheels decides the motion."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.cellwise_field import feedback_field
from nonsmooth.analysis.fields.feedback_laws import cascade_law, corrected_law, printed_law, tangential_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.findings.verdicts import Equilibrium, Feedback, Theorem4
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.array_certificates import check_certificate, evidence, said
from tests.conftest import Arrays, Pair, WheelData

POSITIONS: list[Pair] = [(1, 0), (-1, 1), (-1, -1)]
RIMS: list[Pair] = [(0, 1), (Fraction(3, 5), Fraction(4, 5)), (1, 0)]


def omniwheels(arrays: Arrays, vx: int = 0, omega: int = 1) -> Scene:
    """Three free rollers driven for the motion ``(vx, 0, omega)``: ``u = d . (v + omega J p)``."""
    wheels = []
    for (x, y), (a, b) in zip(POSITIONS, RIMS, strict=True):
        speed = a * vx + omega * (b * x - a * y)
        wheels.append(WheelData((x, y), (a, b), speed))
    return arrays.scene(wheels, friction=(1, 0), radius=Fraction(1, 10))


def test_an_imposed_translation_is_no_equilibrium(arrays: Arrays) -> None:
    result = check_cells(omniwheels(arrays, vx=1, omega=0))
    assert result.check()
    assert result.equilibrium.verdict is Equilibrium.FAILS
    assert result.verdict is Theorem4.HYPOTHESES_NOT_MET


def test_an_imposed_spin_is_one_and_the_feedback_clause_stays_open(arrays: Arrays) -> None:
    result = check_cells(omniwheels(arrays))
    assert result.check()
    assert result.equilibrium.verdict is Equilibrium.HOLDS
    assert result.feedback.verdict is Feedback.UNDECIDED
    assert "rows without friction are left out, so cell 1 holds R1 R2 R3" in result.feedback.reason
    assert result.feedback.law is None
    assert result.verdict is Theorem4.UNDECIDED


def test_three_wheels_with_a_row_each_are_certified(arrays: Arrays) -> None:
    certificate = build_certificate(check_cells(omniwheels(arrays)))
    assert evidence(certificate)["cells"][0]["wheels"] == [1, 2, 3]
    assert said(certificate)["equilibrium"] is True
    assert "feedback" not in said(certificate)
    evidence(certificate)["cells"][0]["wheels"] = [1, 2]
    assert check_certificate(certificate) == "cell 0: wheels that leave no motion free"


def half_free(arrays: Arrays, seed: int) -> Scene:
    """Five wheels of which some roll freely one way; the last one is far from the others."""
    rng = np.random.default_rng(seed)
    rims = ((3, 4), (4, -3), (5, 12), (-12, 5), (0, 1))
    kinds = ((1, 0), (0, 1), (1, 1), (1, Fraction(1, 2)))
    wheels = []
    for k in range(5):
        x, y = (int(entry) for entry in rng.integers(-5, 6, 2))
        wheels.append(WheelData((x + 20 * (k == 4), y), rims[rng.integers(5)], 1, kinds[rng.integers(4)]))
    return arrays.scene(wheels, radius=Fraction(2))


def test_random_wheels_of_which_some_roll_freely_are_certified(arrays: Arrays) -> None:
    """Rows are taken from up to three wheels, and the checker derives which by code of its own."""
    taken, refused = list[int](), 0
    for seed in range(12):
        try:
            certificate = build_certificate(check_cells(half_free(arrays, seed)))
        except RefusalError:  # the motion is not determined
            refused += 1
            continue
        cells = evidence(certificate)["cells"]
        taken += [len(cell["wheels"]) for cell in cells]
        cells[0]["wheels"] = cells[0]["wheels"][::-1]
        assert check_certificate(certificate)
    print(f"{len(taken)} cells, {refused} arrays are not determined")
    assert {2, 3} == set(taken)
    assert refused < 6


@pytest.mark.parametrize(
    "law", [corrected_law(1), printed_law(1), cascade_law(1, {1: 1, 2: 1, 3: 1}), tangential_law(1, 1)]
)
def test_laws_of_pairs_refuse_such_cells(arrays: Arrays, law: object) -> None:
    partition = build_nearest_partition(omniwheels(arrays))
    with pytest.raises(ValueError, match="required both rows of one wheel and one of another"):
        feedback_field(partition, law, Kinematics.EXACT)  # type: ignore[arg-type]


def test_too_few_rows_are_refused_in_one_line(arrays: Arrays) -> None:
    """Inward rims of free rollers leave the rotation free."""
    wheels = [WheelData(p, (-p[0], -p[1])) for p in POSITIONS]
    with pytest.raises(RefusalError, match="received 2: the motion is not determined"):
        check_cells(arrays.scene(wheels, friction=(1, 0), radius=Fraction(1, 10)))


def test_a_free_side_row_far_away_changes_nothing(arrays: Arrays) -> None:
    """Whose rows are never reached, a wheel without friction has no say: verdicts and cells stay."""
    scene = arrays.four_wheel()
    far = WheelData((9, 9), (1, 0), 1, (1, 0))
    extended = arrays.scene(
        [*(WheelData((x, y), (-x, -y)) for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))), far],
        friction=(1, Fraction(1, 2)),
    )
    before, after = check_cells(scene), check_cells(extended)
    assert [found.verdict for _, found in before.clauses] == [found.verdict for _, found in after.clauses]
    assert len(before.partition.cells) == len(after.partition.cells)
    assert said(build_certificate(after))["theorem 4"] == "holds"
