"""Certificates and feedback about all arrays within tolerances, against arrays of the box."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np
import pytest

from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.certificate import build_certificate, certificate_text, find_difference
from nonsmooth.proofs.checker.files import check_file
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.robust.decide import decide_robust
from nonsmooth.proofs.robust.feedback import decide_robust_loop
from nonsmooth.proofs.theorem4 import check_cells, check_smooth
from nonsmooth.reports.commands.verify import verify
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from tests.array_certificates import check_certificate, said, say, subject
from tests.built_in import checked
from tests.oracles.floats import Floats
from tests.oracles.rebuilt_arrays import Decoder, assert_still_true, rebuilt
from tests.oracles.wheels_in_floats import places_of, rims_of
from tests.proofs.robust.drawn_arrays import drawn_model, small_box
from tests.proofs.robust.test_nearest_bounds import TABLE, drawn, table, velocities, with_box
from tests.proofs.robust.test_smooth_discs import box_of
from tests.thorough import few, keep, thorough

# ---- Certificates about all arrays within tolerances: accepted, true for arrays of the box, and rejected where
# forged.

Record: TypeAlias = dict[str, Any]


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    return table(tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def certificate(scene: Scene) -> Record:
    return build_certificate(check_cells(scene))


@thorough  # the small one: test_arrays_of_the_box_obey_the_certificate
def test_the_bound_is_nearly_the_one_of_the_check(scene: Scene, certificate: Record, tmp_path: Path) -> None:
    found = decide_robust(scene)
    assert found is not None
    assert found.radius is not None
    radius = Fraction(said(certificate)["tolerances"]["radius"])
    assert found.radius < radius < found.radius * Fraction(102, 100)
    file = tmp_path / "certificate.json"
    file.write_text(certificate_text(certificate), encoding="utf-8")
    status, text = check_file(str(file))
    assert status == 0
    assert "within the tolerances: bodies from within 0.05 end within 0.003385" in text


@few(1)
@pytest.mark.parametrize("name", ["rectangle", "ring-5", "ring-6"])
def test_irrational_places_are_followed(name: str, tmp_path: Path) -> None:
    certificate = build_certificate(check_cells(with_box(name, tmp_path)))
    assert check_certificate(certificate) == ""
    assert "tolerances" in said(certificate)
    assert_still_true(certificate)
    assert_arrays_obey(certificate, 1_000)


def array_of(certificate: Record) -> Scene:
    """The array of a certificate, with its tolerances, seen from the checked point."""
    decode, about = Decoder(certificate), subject(certificate)
    sizes: dict[str, Any] = {name: decode.number(size) for name, size in about["tolerances"].items()}
    box = Tolerance(centre_of_mass=decode.field.zero, **sizes)
    return replace(rebuilt(certificate, decode).recentred(), tolerances=box)


def assert_arrays_obey(certificate: Record, count: int) -> None:
    """Half of the arrays are corners of the box; most of the points outside the disc are close to it."""
    inner, outer, rate = (float(Fraction(said(certificate)["tolerances"][key])) for key in ("radius", "start", "rate"))
    rng = np.random.default_rng(11)
    sizes = inner + (outer - inner) * rng.random(count) ** 3
    angles = rng.uniform(0, 2 * np.pi, len(sizes))
    points = sizes[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    moved = velocities(drawn(array_of(certificate), len(sizes), 12), points)
    assert ((points * moved).sum(axis=1) <= -rate * sizes * (1 - 1e-9)).all()


def test_arrays_of_the_box_obey_the_certificate(certificate: Record) -> None:
    """Ten thousand arrays."""
    assert_arrays_obey(certificate, 10_000)


def claim_other(certificate: Record, key: str, value: Any) -> None:
    """Another tolerance, or another bound, which is claimed too."""
    bounds, sizes = certificate["evidence"][-1]["hypotheses"], subject(certificate)["tolerances"]
    (bounds if key in bounds else sizes)[key] = value
    say(certificate, tolerances=dict(bounds))


def scaled(key: str, factor: Fraction) -> Callable[[Record], None]:
    def forge(certificate: Record) -> None:
        tolerances = {**subject(certificate)["tolerances"], **said(certificate)["tolerances"]}
        claim_other(certificate, key, str(Fraction(tolerances[key]) * factor))

    return forge


def put(key: str, value: Any) -> Callable[[Record], None]:
    return lambda certificate: claim_other(certificate, key, value)


FORGED: dict[str, tuple[Callable[[Record], None], str]] = {
    "a smaller disc": (scaled("radius", Fraction(9, 10)), "a rate outside the disc"),
    "a faster rate": (scaled("rate", Fraction(2)), "a rate outside the disc"),
    "no rate": (put("rate", "0"), "bounds within the square"),
    "starts outside the square": (scaled("start", Fraction(101, 100)), "bounds within the square"),
    "no room": (put("radius", "1/20"), "bounds within the square"),
    "larger position": (scaled("position", Fraction(3, 2)), "a rate outside the disc"),
    "larger heading": (scaled("heading", Fraction(4)), "a rate outside the disc"),
    "larger speed": (scaled("speed", Fraction(10)), "a rate outside the disc"),
    "rows that change places": (scaled("mu_side", Fraction(4)), "a rate outside the disc"),
    "negative": (put("position", "-1/1000"), "bounds within the square"),
    "a share above one": (put("mu_roll", "2"), "bounds within the square"),
    "a quarter turn": (put("heading", "1/2"), "bounds within the square"),
    "words": (put("rate", "fast"), "rational numbers as texts"),
    "a number": (put("rate", 1), "at most 200 characters"),
    "many digits": (put("rate", "0" * 300 + "1"), "at most 200 characters"),
}


@pytest.mark.parametrize("name", FORGED)
def test_forged_claims_are_rejected(certificate: Record, name: str) -> None:
    forge, claim = FORGED[name]
    forged = copy.deepcopy(certificate)
    forge(forged)
    assert claim in check_certificate(forged)


def test_missing_and_spare_keys_are_rejected(certificate: Record) -> None:
    hypotheses = certificate["evidence"][1]["hypotheses"]
    others: list[Any] = [{"rate": "1"}, {**hypotheses, "more": "1"}, None, []]
    for bounds in others:
        forged = copy.deepcopy(certificate)
        forged["evidence"][1]["hypotheses"] = bounds
        assert check_certificate(forged) == "an object with the keys radius start rate"
    forged = copy.deepcopy(certificate)
    del subject(forged)["tolerances"]["speed"]
    assert check_certificate(forged) == "an object with the keys position heading speed mu_roll mu_side"
    del subject(forged)["tolerances"]
    assert check_certificate(forged) == "tolerances, under rule nearest"
    forged["evidence"].pop()
    assert check_certificate(forged).startswith("evidence of the claim")


@pytest.mark.parametrize("count", [0, 1])
def test_wheels_that_fix_no_motion_are_rejected(certificate: Record, count: int) -> None:
    """No pair of wheels carries the body anywhere, so nothing is false of a pair, and nothing is true of the body."""
    forged = bounds_only(certificate)
    del subject(forged)["wheels"][count:]
    assert check_certificate(forged) == "two wheels at least, which fix the motion"


def test_other_wheels_are_rejected(certificate: Record) -> None:
    """With more friction across the rims and cells to match, the claim would be false; so would it with slow wheels."""
    forged = copy.deepcopy(certificate)
    subject(forged)["wheels"][0]["friction"] = ["1", "99/100"]
    assert check_certificate(forged) == "a rate outside the disc"


def test_another_scene_and_other_tolerances_are_told_apart(scene: Scene, certificate: Record, tmp_path: Path) -> None:
    assert find_difference(certificate, scene) == ""
    other = tmp_path / "other.toml"
    other.write_text(TABLE.replace('position = "1/1000"', 'position = "1/2000"'), encoding="utf-8")
    assert find_difference(certificate, load_scene(other)) == "tolerance"
    other.write_text(TABLE.partition("[tolerance]")[0], encoding="utf-8")
    assert find_difference(certificate, load_scene(other)) == "tolerance"


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("", ""),
        ('centre_of_mass = "1/500"\n', "how far the centre of mass is from its nominal place"),
        ('[drive]\nspeed_limit = "3/20"\n', "the limits of speeds"),
        ("[feedback]\ndelay = 1\n", "how late and wrong the pose is"),
    ],
)
def test_what_the_claims_about_a_scene_do_without_is_named(
    more: str, words: str, certificate: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The disc is that of the true centre of mass, and the rate that of the law alone."""
    file, scene = tmp_path / "certificate.json", tmp_path / "scene.toml"
    file.write_text(certificate_text(certificate), encoding="utf-8")
    scene.write_text(TABLE + more, encoding="utf-8")
    assert verify(str(file), str(scene)) == 0
    *_, named, about = capsys.readouterr().out.splitlines()
    assert about.endswith("the same wheels, rule, point and square")
    assert named.startswith(f"left out, not shown here: {words}" if words else "within the tolerances")


ARRAYS = 1_000  # of a box, which are drawn for a mutant


def bounds_only(certificate: Record) -> Record:
    """Nothing of Theorem 4: the tolerances are a theorem of their own."""
    record = copy.deepcopy(certificate)
    record["evidence"] = [entry for entry in record["evidence"] if entry["theorem"] == "tolerances"]
    record["statement"]["claims"] = [claim for claim in record["statement"]["claims"] if "tolerances" in claim]
    return record


# ---- Feedback of arrays drawn from a box, under the law of the scene: minimizers by a linear program.

NAMES = ("ring-5", "spiral-30", "saddle", "conveyor-3")


def case(name: str, factor: Fraction = Fraction(1)) -> tuple[Scene, Tolerance, DrivenFeedback]:
    scene = load_scene(name, rule="box")
    box = small_box(scene).times(factor)
    return replace(scene, tolerances=box), box, cast("DrivenFeedback", checked(name, "box").results["feedback"])


def commanded(scene: Scene, twist: Floats) -> Floats:
    """The rims' speeds of the scene for a twist, at the places of its wheels."""
    centred = scene.recentred()
    places = places_of(centred)
    rims = rims_of(centred)
    at = twist[:2] + twist[2] * np.column_stack([-places[:, 1], places[:, 0]])
    return np.asarray((rims * at).sum(axis=1))


@few(1)
@pytest.mark.parametrize("name", NAMES)
def test_no_array_of_the_box_is_slower(name: str) -> None:
    """``V' <= -2 k kappa V`` at random poses close to the point, for arrays that are corners of the box and others."""
    scene, box, feedback = case(name)
    loop = decide_robust_loop(scene, feedback)
    assert loop is not None
    assert loop.rate is not None
    assert feedback.kappa is not None
    assert loop.rate < feedback.kappa
    length, rng = float(scene.check.length), np.random.default_rng(7)
    twists = np.array([[float(x) for x in twist] for twist in feedback.cones[0].vectors])
    for k in range(60):
        g = rng.normal(size=3)
        products = twists @ g
        m = int(np.argmax(np.abs(products)))
        command = -products[m] * np.array([*twists[m][:2], twists[m][2] / length])
        model = drawn_model(scene.recentred(), box, rng, corner=k % 2 == 0, speeds=commanded(scene, command))
        near = 1e-9 * g[None, :2]
        moved = BoxHighs().minimize(model, loads_at(model, near)).twists[0] * np.array([1, 1, length])
        assert g @ moved <= -float(loop.rate) * (g @ g) + 1e-7


def test_without_tolerances_the_rate_is_that_of_the_law() -> None:
    scene, _, feedback = case("saddle", Fraction(0))
    loop = decide_robust_loop(scene, feedback)
    assert loop is not None
    assert loop.rate is not None
    assert feedback.kappa is not None
    assert float(loop.rate) == pytest.approx(float(feedback.kappa), rel=1e-5)
    assert loop.rate <= feedback.kappa


def test_what_is_not_followed_is_said() -> None:
    for name, rule, reason in (
        ("four-wheel", "box", "balance exactly"),
        ("four-wheel", "nearest", "another pair may carry"),
    ):
        scene = load_scene(name, rule=rule)
        feedback = checked(name, rule).results["feedback"]
        loop = decide_robust_loop(replace(scene, tolerances=small_box(scene)), cast("DrivenFeedback", feedback))
        assert loop is not None
        assert loop.rate is None
        assert reason in loop.reason
    scene, _, feedback = case("saddle", Fraction(60))
    loop = decide_robust_loop(scene, feedback)
    assert loop is not None
    assert loop.rate is None


# ---- rules with friction sets --------------------------------------------------------------------


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize(
    ("name", "count"), keep(1, [("four-wheel", 10), ("four-wheel", 40), ("saddle", 40), ("spiral-30", 40)])
)
def test_no_array_of_the_box_is_slower_under_rules_with_friction_sets(name: str, count: int, rule: str) -> None:
    """The speeds are those that the law states; minimizers in floats, for corners of the box and others."""
    scene = load_scene(name, rule=rule)
    feedback = cast("DrivenFeedback", check_smooth(scene).results["feedback"])
    box = box_of(scene, Fraction(1, 100))
    loop = decide_robust_loop(replace(scene, tolerances=box), feedback)
    assert loop is not None
    assert loop.rate is not None
    assert feedback.certified_kappa is not None
    assert 0 < loop.rate < feedback.certified_kappa
    rescaled = in_own_length(replace(scene, tolerances=box).recentred())
    cone, rng = feedback.cones[0], np.random.default_rng(9)
    twists = np.array([[float(x) for x in twist] for twist in cone.vectors])
    speeds = [np.array(rim_speeds(rescaled, imposed)) for imposed in cone.twists]
    assert rescaled.tolerances is not None
    for k in range(count):
        g = rng.normal(size=3)
        products = twists @ g
        m = int(np.argmax(np.abs(products)))
        model = drawn_model(
            rescaled.recentred(), rescaled.tolerances, rng, corner=k % 2 == 0, speeds=-products[m] * speeds[m]
        )
        moved = EllipseMinimizer().minimize(model, loads_at(model, 1e-9 * g[None, :2])).twists[0]
        assert g @ moved <= -float(loop.rate) * (g @ g) + 1e-6


def test_large_tolerances_leave_the_law_undecided() -> None:
    scene = load_scene("ring-5", rule="ellipse")
    feedback = cast("DrivenFeedback", check_smooth(scene).results["feedback"])
    loop = decide_robust_loop(replace(scene, tolerances=box_of(scene, Fraction(3))), feedback)
    assert loop is not None
    assert loop.rate is None
    assert "slip away" in loop.reason
