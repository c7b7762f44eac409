"""Theorem 4 under the rules ``box`` and ``ellipse``: verdicts, evidence and what pruning may leave out."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import pytest

from nonsmooth.analysis.fields.closed_loop import Law, relative_rates, sample_closed_loop
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.fields.filippov import cell_derivatives
from nonsmooth.analysis.fields.sampling import sample_ellipse_derivative
from nonsmooth.analysis.minimizers.dissipation import Functional
from nonsmooth.analysis.partitions.box import build_box_partition
from nonsmooth.analysis.partitions.partition import RefusalError
from nonsmooth.proofs.clauses.sampled_feedback import SampledFeedback
from nonsmooth.proofs.clauses.translation import rest_area
from nonsmooth.proofs.theorem4 import check_cells, check_theorem4
from nonsmooth.proofs.theorem4_result import CellCheck, EllipseCheck
from nonsmooth.proofs.verdicts import Equilibrium, Feedback, Rotation, Theorem4, Translation
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.rule import Rule
from nonsmooth.symbolic.scene import Scene

if TYPE_CHECKING:
    from tests.conftest import Arrays

EVIDENT = ["four-wheel", "rectangle", "ring-5", "grid-4x4", "elliptic", "spiral-30", "conveyor-3", "saddle", "outward"]


def ruled(scene: Scene, rule: Rule) -> Scene:
    return replace(scene, contact=replace(scene.contact, rule=rule))


def without_feedback(scene: Scene) -> Scene:
    """Side friction first, so that no closed loop is sampled."""
    return replace(
        scene,
        wheels=tuple(replace(w, friction=replace(w.friction, side=w.friction.roll * 2)) for w in scene.wheels),
    )


@pytest.mark.parametrize("name", EVIDENT)
@pytest.mark.parametrize("rule", [Rule.BOX, Rule.ELLIPSE])
def test_evidence_verifies(name: str, rule: Rule) -> None:
    result = check_theorem4(load_scene(name, rule=str(rule)))
    assert result.check()
    assert isinstance(result, CellCheck if rule is Rule.BOX else EllipseCheck)


def test_four_wheel_under_box_rests_in_a_diamond() -> None:
    result = check_cells(load_scene("four-wheel", rule="box"))
    assert result.verdict is Theorem4.FAILS
    assert result.translation.verdict is Translation.STABLE
    assert result.translation.worst_rate == 0
    assert rest_area(result.partition) == Fraction(1, 2)
    assert result.rotation.verdict is Rotation.NEUTRAL
    assert result.feedback.verdict is Feedback.UNDECIDED
    assert any("lemma" in s.why for s in result.skipped)


@pytest.mark.parametrize("name", ["four-wheel", "ring-6", "ring-3", "four-wheel-side", "off-center"])
def test_pruning_changes_no_verdict(name: str) -> None:
    scene = without_feedback(load_scene(name, rule="box"))
    pruned, full = check_cells(scene), check_cells(scene, prune=False)
    for clause in ("equilibrium", "translation", "rotation", "feedback"):
        assert getattr(pruned, clause).verdict is getattr(full, clause).verdict
    assert pruned.verdict is full.verdict
    assert full.partition.complete
    assert full.partition.tiles
    assert full.check()


@pytest.mark.parametrize("friction", [(1, Fraction(1, 5)), (1, Fraction(1, 10))])
def test_the_rotation_bound_of_rule_box_holds_on_every_cell(arrays: Arrays, friction: tuple[int, Fraction]) -> None:
    """V* <= -kappa |c| and |omega| <= bound kappa/2 wherever the body moves."""
    scene = ruled(arrays.four_wheel(friction), Rule.BOX)
    result = check_cells(scene, prune=False)
    bound = result.rotation.rotation_per_distance
    assert bound is not None
    rng = np.random.default_rng(0)
    for derivative in cell_derivatives(build_box_partition(scene)):
        if any(derivative.twist):
            for _ in range(20):
                x, y = arrays.interior_point(derivative.cell.polygon, rng)
                rate = 2 * float(x * derivative.twist.vx + y * derivative.twist.vy) / np.hypot(float(x), float(y))
                assert 2 * abs(float(derivative.twist.omega)) <= float(bound) * -rate + 1e-12


@pytest.mark.parametrize("ratio", [Fraction(1, 2), Fraction(1, 10), 2])
def test_four_wheel_under_ellipse_is_exponentially_stable(arrays: Arrays, ratio: Fraction) -> None:
    result = check_theorem4(ruled(arrays.four_wheel((1, ratio)), Rule.ELLIPSE))
    assert isinstance(result, EllipseCheck)
    assert result.translation.verdict is Translation.ASYMPTOTICALLY_STABLE
    linear = result.translation.point.linearization
    assert linear is not None
    assert linear.spectral_abscissa == -result.scene.field.sqrt(2) / (Fraction(ratio) * ratio)
    assert result.rotation.verdict is Rotation.NEUTRAL
    assert result.translation.worst_rate == 0


@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "rectangle", "spiral-30"])
def test_sampled_rates_agree_with_the_verdict(name: str) -> None:
    """Exponentially stable points of these arrays also decrease |c|^2 on the whole square."""
    scene = load_scene(name, rule="ellipse").recentred()
    assert sample_ellipse_derivative(scene, 400).largest < 1e-9


def test_spinning_and_carried_bodies_are_unstable_in_theta() -> None:
    for name, rate in (("spiral-30", "-4*sqrt(2)/7"), ("conveyor-3", "-1")):
        result = check_theorem4(load_scene(name, rule="ellipse"))
        assert result.equilibrium.verdict is Equilibrium.HOLDS
        assert result.rotation.verdict is Rotation.UNSTABLE
        assert result.rotation.drift is not None
        assert [str(w) for w in result.rotation.drift.interval] == [rate, rate]


@pytest.mark.parametrize("rule", [Rule.BOX, Rule.ELLIPSE])
def test_a_body_that_would_tip_is_refused(arrays: Arrays, rule: Rule) -> None:
    with pytest.raises(RefusalError, match="support polygon"):
        check_theorem4(ruled(arrays.four_wheel(radius=2), rule))


# ---- feedback: sampled, never proved -------------------------------------------------------------


def test_tangential_rims_track_a_wanted_motion(arrays: Arrays) -> None:
    """Full torque authority: twist tracking decreases V at the rate -2k on every sample (all wheels roll)."""
    scene = ruled(arrays.four_wheel(turn=(0, 1)), Rule.ELLIPSE)
    model = contact_model(scene)
    states = np.random.default_rng(0).uniform(-0.3, 0.3, (40, 3))
    rates = relative_rates(model, Functional.ELLIPSE, Law.TRACKING, states)
    assert rates.max() < 0
    result = check_theorem4(scene)
    assert result.authority.rank == 3
    assert result.feedback.verdict is Feedback.UNDECIDED
    assert "not proved" in result.feedback.reason


def test_inward_rims_have_no_torque_about_the_equilibrium(arrays: Arrays) -> None:
    scene = ruled(arrays.four_wheel(), Rule.ELLIPSE)
    result = check_theorem4(scene)
    assert [[str(x) for x in twist] for twist in result.authority.missing] == [["0", "0", "1"]]
    feedback = result.feedback
    assert isinstance(feedback, SampledFeedback)
    assert feedback.verdict is Feedback.UNDECIDED
    assert feedback.witness is not None
    turned = np.array([[*(float(x) for x in feedback.witness.point), float(feedback.witness.value)]])
    model = contact_model(scene)
    for functional in Functional:
        assert abs(relative_rates(model, functional, Law.TRACKING, turned)[0]) < 1e-9


@pytest.mark.parametrize("functional", list(Functional))
@pytest.mark.parametrize("law", list(Law))
def test_worst_states_can_be_re_evaluated(arrays: Arrays, functional: Functional, law: Law) -> None:
    model = contact_model(arrays.four_wheel((1, Fraction(1, 5))))
    sample = sample_closed_loop(model, functional, law, 0.3, 20)
    again = relative_rates(model, functional, law, np.array([sample.worst_state]))[0]
    assert again == pytest.approx(sample.worst_rate, abs=1e-9)
    assert sample.fails == (sample.worst_rate >= -1e-4)
