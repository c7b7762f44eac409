"""The answers with one wheel failed, against arrays that are written down without it."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize
from sympy import Matrix

import nonsmooth as ns
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.answers.failures import NO_DRIVE, NO_TABLE, Failure, FailureKind, failures_of, worst_failure
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing, with_only
from nonsmooth.symbolic.messages.under_way import listening
from tests.thorough import few, keep

CORNERS = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
PLACES = [*CORNERS, (2, 0), (0, 2)]


def array(places: list[tuple[int, int]], rule: str, stopped: int | None = None, **more: Any) -> ns.Array:
    wheels = [ns.Wheel(place, heading="inward", speed=0 if k == stopped else 1) for k, place in enumerate(places, 1)]
    return ns.Array(wheels, mu_roll=1, mu_side="1/2", rule=rule, **more)


def found(failures: tuple[Failure, ...], wheel: int, kind: FailureKind) -> Failure:
    (one,) = [failure for failure in failures if (failure.wheel, failure.kind) == (wheel, kind)]
    return one


@few(1)
@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_failures_answer_as_arrays_written_without_the_wheel(rule: str) -> None:
    failures = failures_of(array(PLACES, rule, radius="1/4").scene)
    assert [(failure.wheel, str(failure.kind)) for failure in failures] == [
        (wheel, kind) for wheel in range(1, 7) for kind in ("stopped", "lifted")
    ]
    for wheel in (1, 6):
        still = array(PLACES, rule, stopped=wheel, radius="1/4").check()
        stopped = found(failures, wheel, FailureKind.STOPPED)
        assert (stopped.position, stopped.heading) == (still.position.verdict, still.heading.verdict)
        without = array([place for k, place in enumerate(PLACES, 1) if k != wheel], rule, radius="1/4").check()
        lifted = found(failures, wheel, FailureKind.LIFTED)
        answers = (without.position.verdict, without.heading.verdict, without.pose.verdict, without.theorem4)
        assert (lifted.position, lifted.heading, lifted.pose, lifted.theorem4) == answers


@pytest.mark.parametrize("name", keep(1, ["four-wheel", "ring-6"]))
def test_no_law_is_promised_that_may_need_the_stopped_drive(name: str) -> None:
    told: list[str] = []
    with listening(told.append):
        failures = failures_of(load_scene(name))
    assert f"3 of {len(failures)} failures, wheel 2 lifted" in told
    for failure in failures:
        if failure.kind is FailureKind.STOPPED:
            assert failure.pose != "can be held"
            assert failure.theorem4 != "holds"
            assert failure.why == NO_DRIVE


def test_a_body_tips_over_the_diagonal_of_three_corners() -> None:
    failures = failures_of(load_scene("four-wheel"))
    lifted = [failure for failure in failures if failure.kind is FailureKind.LIFTED]
    assert {str(failure.position) for failure in lifted} == {"tips"}
    assert worst_failure(failures) is lifted[0]
    assert "tips over it" in lifted[0].why


def test_only_wheels_that_carry_are_asked_about() -> None:
    wheels = {failure.wheel for failure in failures_of(load_scene("carton-on-6x6"))}
    assert wheels == {15, 16, 21, 22}


def test_a_lifted_wheel_leaves_a_square_that_the_others_support() -> None:
    """The square of the scene leaves the support polygon of five wheels; a smaller one is checked."""
    scene = load_scene("ring-6", rule="ellipse", radius="7/10")
    lifted = found(failures_of(scene), 1, FailureKind.LIFTED)
    assert (lifted.position, lifted.why) == ("comes home", "")


def test_loads_by_a_table_say_nothing_about_fewer_wheels() -> None:
    scene = array(PLACES, "box", loads=[[1, 0, 0]] * 6).scene
    lifted = found(failures_of(scene), 5, FailureKind.LIFTED)
    assert (lifted.position, lifted.pose, lifted.why) == ("undecided", "undecided", NO_TABLE)


def test_loads_by_a_table_do_not_matter_where_a_rule_needs_none() -> None:
    scene = array(PLACES, "nearest", radius="1/4").scene
    table = array(PLACES, "nearest", radius="1/4", loads=[[1, 0, 0]] * 6).scene
    assert failures_of(table) == failures_of(scene)


MEASURED = [8, 9, 11, 10, 7, 6]  # of springs of unequal height under PLACES


def least_energy(places: list[tuple[int, int]], heights: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Loads of springs of stiffness one, ``min sum (N_i - e_i)^2/2`` over those that balance, by a general method."""
    moments = np.array([(1.0, *place) for place in places])
    balance = {"type": "eq", "fun": lambda n: n @ moments - [1.0, *centre], "jac": lambda n: moments.T}
    solved = minimize(
        lambda n: ((n - heights) ** 2).sum() / 2,
        np.full(len(places), 1 / len(places)),
        jac=lambda n: n - heights,
        bounds=[(0, None)] * len(places),
        constraints=[balance],
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 400},
    )
    return np.asarray(solved.x)


@pytest.mark.parametrize("failed", range(6))
def test_springs_of_measured_loads_press_without_a_wheel_as_the_least_energy_says(failed: int) -> None:
    scene = array(PLACES, "ellipse", loads={"kind": "measured", "values": MEASURED}).scene
    rest = with_only(scene, [wheel for wheel in scene.wheels if wheel.index != failed + 1])
    places = [place for k, place in enumerate(PLACES) if k != failed]
    heights = np.array([value for k, value in enumerate(MEASURED) if k != failed]) / sum(MEASURED)
    centres = np.random.default_rng(failed).dirichlet(np.full(5, 0.5), 20) @ np.array(places, float)
    found = loads_at(contact_model(rest), centres)
    assert (found == 0).any()  # some wheels lift off
    for centre, loads in zip(centres, found, strict=True):
        np.testing.assert_allclose(loads, least_energy(places, heights, centre), atol=1e-6)


@pytest.mark.parametrize(("rule", "wheels"), keep(1, [("box", (5, 6)), ("ellipse", (6,)), ("ellipse", (5, 6))]))
def test_measured_loads_say_what_the_others_carry_without_a_wheel(
    rule: str, wheels: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against arrays written without it, with a table of the loads of springs on the others."""
    scene = array(PLACES, rule, radius="1/4", loads={"kind": "measured", "values": MEASURED}).scene
    looked_at = replace(scene, wheels=tuple(wheel for wheel in scene.wheels if wheel.index in wheels))
    # No other wheel fails, which would take long.
    monkeypatch.setattr(f"{failures_of.__module__}.standing", lambda own: looked_at if own is scene else standing(own))
    failures = failures_of(scene)
    for wheel in wheels:
        places = [place for k, place in enumerate(PLACES, 1) if k != wheel]
        shares = [Fraction(value, sum(MEASURED)) for k, value in enumerate(MEASURED, 1) if k != wheel]
        without = array(places, rule, radius="1/4", loads=table_without(places, shares)).check()
        lifted = found(failures, wheel, FailureKind.LIFTED)
        assert lifted.why != NO_TABLE
        answers = (without.position.verdict, without.heading.verdict, without.pose.verdict, without.theorem4)
        assert (lifted.position, lifted.heading, lifted.pose, lifted.theorem4) == answers


def table_without(places: list[tuple[int, int]], shares: list[Fraction]) -> list[list[Fraction]]:
    """Rows of ``N = e + M G^-1 ((1, c) - M^T e)``, by Cramer's rule."""
    moments = [(Fraction(1), Fraction(x), Fraction(y)) for x, y in places]
    gram = Matrix([[sum(m[i] * m[j] for m in moments) for j in range(3)] for i in range(3)])
    weight = [sum(share * m[k] for share, m in zip(shares, moments, strict=True)) for k in range(3)]
    rows = []
    for moment, share in zip(moments, shares, strict=True):
        form = [Fraction(int(x.p), int(x.q)) for x in gram.solve(Matrix(moment))]
        constant = share - sum(f * w for f, w in zip(form, weight, strict=True))
        rows.append([form[0] + constant, form[1], form[2]])
    return rows


def test_the_height_of_a_wheel_that_was_not_pressed_is_not_known() -> None:
    scene = array(PLACES, "box", radius="1/4", loads={"kind": "measured", "values": [8, 9, 11, 10, 0, 6]}).scene
    assert found(failures_of(scene), 6, FailureKind.LIFTED).why == NO_TABLE


def test_the_worst_is_the_one_with_the_worst_position_first() -> None:
    one = failures_of(load_scene("four-wheel"))[0]
    leaves = replace(one, wheel=2, position=ns.Position.LEAVES, heading=ns.Heading.KEEPS)
    drifts = replace(one, wheel=3, position=ns.Position.COMES_HOME, heading=ns.Heading.DRIFTS)
    tips = replace(one, wheel=4, position=ns.Position.TIPS)
    assert worst_failure((leaves, drifts)) is leaves
    assert worst_failure((leaves, tips, drifts)) is tips
    assert worst_failure((drifts, replace(drifts, wheel=5))) is drifts
