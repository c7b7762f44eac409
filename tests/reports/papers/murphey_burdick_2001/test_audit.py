"""The paper, audited: each finding by an independent computation, and each refuted when the print is changed."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy

from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.reports.output.document import Inline, Math, Table
from nonsmooth.reports.papers.murphey_burdick_2001 import audit
from nonsmooth.reports.papers.murphey_burdick_2001.audit import (
    RAYS,
    ClaimOutcome,
    CorrectedLaw,
    agrees,
    audit_equations_3_and_4,
    audit_feedback,
    audit_paper,
    audit_theorem_4_displays,
    audit_translation,
    corrected_law,
    lowest_terms,
    missing_factor,
    pair_rate,
    pair_twist,
    rate_is,
    ray_point,
    rests,
    sign_sets,
)
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import (
    EQUATION_3,
    EQUATION_4,
    THEOREM_4_KINEMATICS,
    THEOREM_4_RATE,
    is_paper_array,
)
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.conftest import Arrays
from tests.hulls import hull_holds_zero

SAMPLES = 4000
ROUNDING = 1e-9  # V' and V are of order 1 here; sums of a dozen floats


@pytest.fixture(scope="module")
def roll() -> CellCheck:
    """mu_S < mu_R: eq. (4)."""
    return check_cells(load_scene("four-wheel"))


@pytest.fixture(scope="module")
def side() -> CellCheck:
    """mu_S > mu_R: eq. (3)."""
    return check_cells(load_scene("four-wheel-side"))


@pytest.fixture(scope="module")
def laws(roll: CellCheck) -> list[CorrectedLaw]:
    assert isinstance(roll.feedback, FeedbackResult)
    return [corrected_law(data) for data in roll.feedback.cells]


def test_outcomes() -> None:
    outcomes = {finding.item: finding.outcome for finding in audit_paper()}
    assert outcomes == {
        1: ClaimOutcome.CONFIRMED,
        2: ClaimOutcome.CORRECTED,
        3: ClaimOutcome.STRENGTHENED,
        5: ClaimOutcome.CORRECTED,
        6: ClaimOutcome.CORRECTED,
        4: ClaimOutcome.REFUTED,
        7: ClaimOutcome.REFUTED,
        8: ClaimOutcome.CORRECTED,
        9: ClaimOutcome.REFUTED,
    }


def test_the_audit_belongs_to_the_paper_array_only(arrays: Arrays) -> None:
    assert [name for name in builtin_scenes() if is_paper_array(load_scene(name))] == ["four-wheel", "four-wheel-side"]
    assert is_paper_array(arrays.four_wheel())
    assert not is_paper_array(arrays.four_wheel(turn=(Fraction(3, 5), Fraction(4, 5))))


# ---- 1: equations (3) and (4) --------------------------------------------------------------------


def test_both_equations_agree_with_all_cells(roll: CellCheck, side: CellCheck) -> None:
    comparisons = [agrees(EQUATION_4, cell) for cell in roll.partition.cells]
    comparisons += [agrees(EQUATION_3, cell) for cell in side.partition.cells]
    assert len(comparisons) == 16
    assert all(comparisons)


def test_exchanged_equations_agree_with_no_cell(roll: CellCheck, side: CellCheck) -> None:
    assert not any(agrees(EQUATION_3, cell) for cell in roll.partition.cells)
    assert not any(agrees(EQUATION_4, cell) for cell in side.partition.cells)


def test_a_changed_print_is_refuted(roll: CellCheck, side: CellCheck, monkeypatch: pytest.MonkeyPatch) -> None:
    changed = EQUATION_4.as_mutable()
    changed[2] = -changed[2]
    monkeypatch.setattr(audit, "EQUATION_4", changed)
    finding = audit_equations_3_and_4(roll, side)
    assert finding.outcome is ClaimOutcome.REFUTED
    assert "8" in finding.conclusion


# ---- 2: V' and V* --------------------------------------------------------------------------------


def test_the_displayed_rate_lacks_a_factor() -> None:
    assert missing_factor() == sympy.sqrt(2)


def test_a_rate_that_is_no_multiple_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    changed = EQUATION_3.as_mutable()
    changed[0] = changed[0] * 2
    monkeypatch.setattr(audit, "EQUATION_3", changed)
    with pytest.raises(ValueError, match="constant quotient"):
        missing_factor()


def test_upper_derivatives_in_closed_form(roll: CellCheck, side: CellCheck) -> None:
    assert rate_is(side.partition, larger=False)
    assert rate_is(roll.partition, larger=True)
    assert not rate_is(side.partition, larger=True)
    assert not rate_is(roll.partition, larger=False)
    assert audit_translation(side, roll).outcome is ClaimOutcome.REFUTED  # exchanged


def test_what_jumps_on_axes_and_diagonals(side: CellCheck) -> None:
    for name in RAYS:
        x, y, diagonal = (len(signs) for signs in sign_sets(side.partition, ray_point(side.partition, name)))
        if "=" in name:
            assert (x, y, diagonal) == (1, 1, 2)
        else:
            assert (x, y, diagonal) == ((2, 1, 1) if name.startswith("y") else (1, 2, 1))


def test_axes_are_equilibria_of_equation_3_only(roll: CellCheck, side: CellCheck) -> None:
    assert [name for name in RAYS if rests(side.partition, ray_point(side.partition, name))] == [
        "x > 0", "y > 0", "x < 0", "y < 0",
    ]  # fmt: skip
    assert not any(rests(roll.partition, ray_point(roll.partition, name)) for name in RAYS)


# ---- 5: the feedback law -------------------------------------------------------------------------


def test_the_printed_sign_fails_where_g_is_negative(roll: CellCheck, laws: list[CorrectedLaw]) -> None:
    """``g = sgn(x y (y^2 - x^2))``, coded here once more."""
    failing = []
    for cell in roll.partition.cells:
        x, y = (float(value) for value in cell.polygon.centre)
        if x * y * (y * y - x * x) < 0:
            failing.append(cell.index)
    assert [law.data.cell.index for law in laws if law.lever.sign() < 0] == failing
    assert len(failing) == 4


def test_the_proved_rate_is_the_largest(roll: CellCheck, laws: list[CorrectedLaw]) -> None:
    kappa = roll.partition.scene.field.sqrt(2) / 2
    assert len(laws) == 8
    assert all(law.proves(kappa) for law in laws)
    assert not any(law.proves(kappa * Fraction(1001, 1000)) for law in laws)


@pytest.mark.parametrize("corrected", [True, False])
def test_the_rate_in_samples(laws: list[CorrectedLaw], corrected: bool) -> None:
    """``V' = 2 c . v + 2 theta omega`` by the control vector fields: the bound holds for the corrected law alone."""
    rng = np.random.default_rng(20)
    worst = -np.inf
    for law in laws:
        rays = np.array([[float(x) for x in ray] for ray in law.rays])
        fields = {k: np.array([float(x) for x in g]) for k, g in law.data.state.control_fields.items()}
        for _ in range(SAMPLES // len(laws)):
            c, theta = rng.random(len(rays)) @ rays, rng.normal()
            second = -theta * (law.lever.sign() if corrected else 1)
            first = abs(second) + np.hypot(*c)
            twist = fields[law.data.nearest.index] * first + fields[law.data.second.index] * second
            state = np.array([*c, theta])
            worst = max(worst, float(2 * state @ twist + np.sqrt(2) * state @ state))
    assert (worst <= ROUNDING) == corrected


def test_the_law_needs_rims_at_right_angles() -> None:
    skew = check_cells(load_scene("ring-5")).feedback
    assert isinstance(skew, FeedbackResult)
    with pytest.raises(ValueError, match=r"d_i \. d_j = 0"):
        corrected_law(skew.cells[0])


def test_an_unproved_bound_is_refuted(roll: CellCheck, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CorrectedLaw, "proves", lambda self, kappa: False)
    finding = audit_feedback(roll)
    assert finding.outcome is ClaimOutcome.REFUTED


# ---- 6: Theorem 4's displays ---------------------------------------------------------------------


def test_theorem_4_identities() -> None:
    twist = pair_twist()
    assert all(lowest_terms(entry) == 0 for entry in twist - THEOREM_4_KINEMATICS)
    assert lowest_terms(pair_rate(twist) / THEOREM_4_RATE) == 2


def test_a_changed_display_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    changed = THEOREM_4_KINEMATICS.as_mutable()
    changed[0] = -changed[0]
    monkeypatch.setattr(audit, "THEOREM_4_KINEMATICS", changed)
    assert audit_theorem_4_displays().outcome is ClaimOutcome.REFUTED


# ---- items 4, 7, 8, 9: the functional ------------------------------------------------------------


def test_the_shares_of_the_paper_rule_are_one_minus_twice_the_ratio() -> None:
    """The rule's twists minimize D beyond the strips |x| <= mu or |y| <= mu: 1 - 2 mu_S/mu_R, for ratios up to 1/2."""
    (shown,) = (block for block in audit.audit_largest_weights().computed if isinstance(block, Table))
    for row in shown.rows:
        ratio, cells, share, rest = (entry[0] for entry in row)
        value = Fraction(plain_of(ratio))
        assert Fraction(plain_of(share)) == max(Fraction(0), 1 - 2 * value)
        assert Fraction(plain_of(rest)) == (2 * value**2 if value <= Fraction(1, 2) else 1)
        assert int(plain_of(cells)) == (1 if value >= 1 else 5 if value == Fraction(1, 2) else 13)


def test_the_counterexamples_are_shown_with_their_verdicts() -> None:
    finding = audit.audit_every_array()
    (shown,) = finding.computed
    assert isinstance(shown, Table)
    assert {plain_of(row[0][0]): plain_of(row[1][0]) for row in shown.rows} == {
        "off-center": "hypotheses not met", "outward": "fails", "saddle": "fails",
        "differential-drive": "fails",
    }  # fmt: skip
    assert "4 of these 4" in "".join(map(plain_of, finding.conclusion))


def test_the_counterexamples_are_ones() -> None:
    """Nothing holds the body at the point of one; from near the point of the others a path leaves the square."""
    scene = load_scene("off-center").recentred()
    zero = scene.field.zero
    assert not hull_holds_zero(t.velocity for t in filippov_twists(build_nearest_partition(scene), (zero, zero)))
    for name, start in (("outward", (1e-6, 2e-7, 0)), ("saddle", (0, 1e-6, 0))):
        field = array_field(build_nearest_partition(load_scene(name)), Kinematics.LEADING)
        assert simulate(field, start).end.reason is EndReason.OUTSIDE


def plain_of(inline: Inline) -> str:
    return inline.plain if isinstance(inline, Math) else inline if isinstance(inline, str) else inline.text
