"""The answers with one wheel failed, against arrays that are written down without it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.proofs.answers.failures import NO_DRIVE, NO_TABLE, Failure, FailureKind, failures_of, worst_failure
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import few

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


def test_no_law_is_promised_that_may_need_the_stopped_drive() -> None:
    for failure in failures_of(load_scene("ring-6")):
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


def test_the_worst_is_the_one_with_the_worst_position_first() -> None:
    one = failures_of(load_scene("four-wheel"))[0]
    leaves = replace(one, wheel=2, position=ns.Position.LEAVES, heading=ns.Heading.KEEPS)
    drifts = replace(one, wheel=3, position=ns.Position.COMES_HOME, heading=ns.Heading.DRIFTS)
    tips = replace(one, wheel=4, position=ns.Position.TIPS)
    assert worst_failure((leaves, drifts)) is leaves
    assert worst_failure((leaves, tips, drifts)) is tips
    assert worst_failure((drifts, replace(drifts, wheel=5))) is drifts
