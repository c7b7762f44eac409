"""Wheels with friction axes, and rows without friction."""

from __future__ import annotations

import copy
import json
from fractions import Fraction

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.cells.contact_rule import rule_of, smooth_rule_of
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.constant_field import feedback_field
from nonsmooth.analysis.fields.feedback_laws import cascade_law, corrected_law, printed_law, tangential_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.proofs.certificate import build_certificate, find_difference
from nonsmooth.proofs.clauses.at_point.ellipse import Situation
from nonsmooth.proofs.clauses.authority import roll_authority
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.findings import Equilibrium, Feedback, Theorem4, Translation
from nonsmooth.proofs.theorem4 import check_cells, check_smooth, check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import with_rims_along_axes
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from tests.array_certificates import check_certificate, evidence, said, subject
from tests.conftest import Arrays, Pair, WheelData
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.rebuilt_arrays import assert_still_true
from tests.proofs.forces_oracle import verifies
from tests.thorough import few, thorough

# ---- Verdicts about wheels with friction axes: against plain wheels, differences of the minimizer, and the checker.


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


@pytest.mark.usefixtures("without_law")
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
    matrix = np.column_stack([rates[0] - rates[1], rates[2] - rates[3]]) / (2 * STEP)
    exact = np.array([[float(entry) for entry in row] for row in linear.translation])
    assert matrix == pytest.approx(exact, abs=1e-4 * max(1.0, np.abs(exact).max()))
    unstable = np.linalg.eigvals(matrix).real.max()
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
    result, other = check_theorem4(scene), check_theorem4(plain)
    assert result.check()
    assert [clause.verdict for _, clause in result.clauses] == [clause.verdict for _, clause in other.clauses]
    assert result.verdict == other.verdict


@pytest.mark.parametrize("rule", ["box", "ellipse", "roller"])
def test_the_speeds_of_a_law_for_mecanum_wheels_are_the_textbooks(rule: str) -> None:
    scene = load_scene("mecanum-4", rule=rule)
    feedback = check_theorem4(scene).feedback
    assert isinstance(feedback, DrivenFeedback)
    assert feedback.verdict is Feedback.STABILIZABLE
    rescaled = in_own_length(scene)
    reach = 3 / float(scene.check.length)
    for imposed in feedback.cones[0].twists:
        vx, vy, omega = (float(x) for x in imposed.twist)
        signs = [(-1, -1), (1, -1), (-1, 1), (1, 1)]
        textbook = [vx + a * vy + b * reach * omega for a, b in signs]
        assert rim_speeds(rescaled, imposed) == pytest.approx(textbook)


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
    assert_still_true(certificate)
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


@pytest.mark.usefixtures("without_law")
def test_a_slip_across_the_axis_alone_leaves_a_roller_s_force_open() -> None:
    """Two rollers that run against each other: what the force along their axes is at rest is not determined."""
    wheels = [ns.Wheel((x, y), heading=(-x, 0), axis=(0, 1)) for x in (1, -1) for y in (1, -1)]
    scene = ns.Array(wheels, mu_roll=1, mu_side="1/4", rule="roller", radius="1/4").scene
    result = check_smooth(scene)
    assert result.check()
    point = result.equilibrium.point
    assert point.held == ()
    assert point.situation is Situation.OPEN


# ---- Rule ``nearest`` with rows without friction: what the clauses say where no pair of wheels decides the motion.

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
    assert [clause.verdict for _, clause in before.clauses] == [clause.verdict for _, clause in after.clauses]
    assert len(before.partition.cells) == len(after.partition.cells)
    assert said(build_certificate(after))["theorem 4"] == "holds"
