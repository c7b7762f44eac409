"""Verdicts about wheels with friction axes: against plain wheels, differences of the minimizer, and the checker."""

from __future__ import annotations

import copy
import json
from fractions import Fraction
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

import nonsmooth as ns
from nonsmooth.analysis.cells.contact_rule import rule_of, smooth_rule_of
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.certified_scene import find_difference
from nonsmooth.proofs.clauses.at_point.ellipse import Situation
from nonsmooth.proofs.clauses.authority import roll_authority
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.findings.verdicts import Equilibrium, Feedback, Translation
from nonsmooth.proofs.theorem4 import check_cells, check_smooth, check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.free_rollers import with_rims_along_axes
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from tests.array_certificates import check_certificate, evidence, said, subject
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.earlier_arrays import refusal_of_version_1
from tests.proofs.forces_oracle import verifies
from tests.thorough import few, thorough

Floats: TypeAlias = NDArray[np.float64]

RULES = ("nearest", "box", "ellipse", "roller")
SMOOTH = ("ellipse", "roller")
SEEDS = range(6)
STEP = 1e-5  # of central differences (length)


def turning(seed: int, rule: str, side: str = "2/5") -> Scene:
    """Four wheels that a quarter turn maps into each other: whatever their axes, the centre is an equilibrium."""
    rng = np.random.default_rng(seed)
    x, y = (Fraction(int(v), 8) for v in rng.integers(3, 9, 2))
    (a, b), (c, d) = ([int(v) for v in pair] for pair in rng.integers(-4, 5, (2, 2)))
    heading, axis, wheels = (a or 1, b), (c, d or 1), []
    for _ in range(4):
        wheels.append(ns.Wheel((x, y), heading=heading, speed=1, axis=axis))
        x, y, heading, axis = -y, x, (-heading[1], heading[0]), (-axis[1], axis[0])
    return ns.Array(wheels, mu_roll=1, mu_side=side, rule=rule, radius="1/4").scene


@few(1)
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_evidence_of_every_clause_verifies(seed: int, rule: str) -> None:
    result = check_theorem4(turning(seed, rule))
    assert result.check()  # this decides again too
    assert result.equilibrium.verdict is not Equilibrium.FAILS
    if any(wheel.axis is not None for wheel in result.scene.wheels):
        assert result.feedback.verdict is Feedback.UNDECIDED


@few(2)
@pytest.mark.parametrize("rule", SMOOTH)
@pytest.mark.parametrize("seed", range(24))
def test_linearization_by_differences_of_the_minimizer(seed: int, rule: str) -> None:
    result = check_smooth(turning(seed, rule))
    point = result.equilibrium.point
    assert evidence_holds(point)
    assert verifies(point)
    linear = point.linearization
    if linear is None:
        return
    about = STEP * np.array([[1, 0], [-1, 0], [0, 1], [0, -1.0]])
    twists = minima_under(smooth_rule_of(result.scene), result.scene, about).twists
    rates = twists[:, :2] + twists[:, 2:] * np.column_stack([-about[:, 1], about[:, 0]])
    found = np.column_stack([rates[0] - rates[1], rates[2] - rates[3]]) / (2 * STEP)
    exact = np.array([[float(entry) for entry in row] for row in linear.translation])
    assert found == pytest.approx(exact, abs=1e-4 * max(1.0, np.abs(exact).max()))
    unstable = np.linalg.eigvals(found).real.max()
    if abs(unstable) > 1e-3:
        stable = result.translation.verdict is Translation.ASYMPTOTICALLY_STABLE
        assert stable == (unstable < 0)


@thorough  # about all random cases, which `make bench` runs
def test_some_of_these_are_smooth() -> None:
    points = [check_smooth(turning(seed, "ellipse")).equilibrium.point for seed in range(12)]
    assert sum(point.situation is Situation.SMOOTH for point in points) > 3


@few(2)
@pytest.mark.parametrize("rule", RULES)
def test_free_rollers_get_the_verdicts_of_rims_along_their_axes(rule: str) -> None:
    scene = load_scene("mecanum-4", rule=rule)
    plain = with_rims_along_axes(scene)
    assert plain is not None
    own, other = check_theorem4(scene), check_theorem4(plain)
    assert own.check()
    assert [found.verdict for _, found in own.clauses] == [found.verdict for _, found in other.clauses]
    assert own.verdict == other.verdict


@pytest.mark.parametrize("rule", ["box", "ellipse", "roller"])
def test_the_speeds_of_a_law_for_mecanum_wheels_are_the_textbooks(rule: str) -> None:
    scene = load_scene("mecanum-4", rule=rule)
    feedback = check_theorem4(scene).feedback
    assert isinstance(feedback, DrivenFeedback)
    assert feedback.verdict is Feedback.STABILIZABLE
    own = in_own_length(scene)
    reach = 3 / float(scene.check.length)
    for imposed in feedback.cones[0].twists:
        vx, vy, omega = (float(x) for x in imposed.twist)
        signs = [(-1, -1), (1, -1), (-1, 1), (1, 1)]
        textbook = [vx + a * vy + b * reach * omega for a, b in signs]
        assert rim_speeds(own, imposed) == pytest.approx(textbook)


@few(2)
@pytest.mark.parametrize("rule", RULES)
def test_an_axis_along_the_rim_changes_no_byte(rule: str) -> None:
    places = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    plain, named = (
        ns.Array(
            [ns.Wheel(p, heading="inward", axis=axis) for p in places],
            mu_roll=1,
            mu_side="1/2",
            rule=rule,
            radius="1/2",
        )
        .check()
        .to_dict()
        for axis in (None, "outward")
    )
    for record in (plain, named):
        record.pop("seconds")
    assert json.dumps(plain) == json.dumps(named)


@few(2)
@pytest.mark.parametrize("rule", ["nearest", "box"])
@pytest.mark.parametrize("seed", SEEDS)
def test_certificates_name_the_axes_and_the_checker_follows_them(seed: int, rule: str) -> None:
    scene = turning(seed, rule)
    certificate = build_certificate(check_cells(scene))
    assert check_certificate(certificate) == ""
    assert find_difference(certificate, scene) == ""
    named = [("axis" in wheel) for wheel in subject(certificate)["wheels"]]
    assert named == [wheel.axis is not None for wheel in scene.wheels]
    assert refusal_of_version_1(certificate) == ""
    if scene.wheels[0].axis is None:
        return
    forged = copy.deepcopy(certificate)
    for wheel in subject(forged)["wheels"]:
        del wheel["axis"]
    assert find_difference(forged, scene) == "axis of wheel 1"
    assert check_certificate(forged) != ""


def test_the_checker_takes_the_law_of_free_rollers() -> None:
    certificate = build_certificate(check_cells(load_scene("mecanum-4", rule="box")))
    assert check_certificate(certificate) == ""
    assert said(certificate)["feedback"] == "stabilizable"
    rubbing = copy.deepcopy(certificate)
    subject(rubbing)["wheels"][0]["friction"][1] = "1/1000"
    assert check_certificate(rubbing) != ""
    across = copy.deepcopy(certificate)
    subject(across)["wheels"][0]["direction"] = subject(across)["wheels"][1]["axis"]
    assert check_certificate(across) != ""


def test_free_rollers_under_rule_nearest_are_followed() -> None:
    certificate = build_certificate(check_cells(load_scene("mecanum-4")))
    assert check_certificate(certificate) == ""
    assert {len(cell["wheels"]) for cell in evidence(certificate)["cells"]} == {3}
    assert "feedback" not in said(certificate)


@few(3)
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("name", ["omni-3", "mecanum-4", "roller-bed", "carton-on-6x6"])
def test_the_scenes_give_what_an_engineer_expects(name: str, rule: str) -> None:
    result = check_theorem4(load_scene(name, rule=rule))
    assert result.check()
    if name == "roller-bed":  # it conveys
        assert result.equilibrium.verdict is Equilibrium.FAILS
        return
    assert result.equilibrium.verdict is Equilibrium.HOLDS
    assert result.translation.verdict in (Translation.STABLE, Translation.ASYMPTOTICALLY_STABLE)
    if name != "carton-on-6x6" and rule != "nearest":  # any pose can be driven to
        assert result.feedback.verdict is Feedback.STABILIZABLE
    assert rule_of(result.scene).name == rule


def test_authority_is_about_what_drives_push() -> None:
    assert roll_authority(load_scene("mecanum-4")).rank == 3
    scene = load_scene("roller-bed")
    bed = roll_authority(scene)
    assert (bed.rank, [[str(x) for x in twist] for twist in bed.missing]) == (2, [["0", "1", "0"]])
    wheels = [ns.Wheel(p, heading=(1, 0), axis=(0, 1)) for p in ((1, 0), (0, 1))]
    idle = ns.Array([*wheels, ns.Wheel((-1, -1), heading=(1, 1))], mu_roll=1, mu_side=0).scene
    assert roll_authority(idle).basis == (3,)


def test_a_slip_across_the_axis_alone_leaves_a_roller_s_force_open() -> None:
    """Two rollers that run against each other: what the force along their axes is at rest is not determined."""
    wheels = [ns.Wheel((x, y), heading=(-x, 0), axis=(0, 1)) for x in (1, -1) for y in (1, -1)]
    scene = ns.Array(wheels, mu_roll=1, mu_side="1/4", rule="roller", radius="1/4").scene
    result = check_smooth(scene)
    assert result.check()
    found = result.equilibrium.point
    assert found.balance.stuck is None
    assert found.situation is Situation.OPEN
