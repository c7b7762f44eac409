"""Certificates of the built-in scenes: each is valid, small and quickly checked; what they hold and what is refused."""

from __future__ import annotations

import copy
import json
import time
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from nonsmooth.proofs.certificate import build_certificate, certificate_text, stated_words
from nonsmooth.proofs.checker.files import check_file
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.translation.certified_disc import certified_disc
from nonsmooth.proofs.findings.verdicts import Rotation, Translation
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.theorem4 import check_cells, check_smooth
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.proofs.verified import UnverifiedError
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable, Scene
from tests.array_certificates import check_certificate, claim_disc, evidence, proofs, said, subject
from tests.built_in import checked
from tests.conftest import Arrays, Pair, WheelData
from tests.four_wheel import CORNERS
from tests.oracles.earlier_arrays import earlier_array, refusal_of_version_1
from tests.thorough import few, keep, thorough

Record: TypeAlias = dict[str, Any]

HALF = Fraction(1, 2)
FREE_ROLLERS = ("omni-3", "mecanum-4")  # rule nearest leaves rows without friction out; version 1 did not
BOTH_RULES = list(product(builtin_scenes(), ("nearest", "box")))
NO_WORDS = [(name, "nearest") for name in FREE_ROLLERS]
LARGEST_FILE = 40_000  # bytes; the largest built-in certificate (elliptic, rule box) has about half of it
SLOWEST_CHECK = 10.0  # seconds; the slowest (grid-4x4, rule box) takes about one


@few(2)
@pytest.mark.parametrize(("name", "rule"), keep(22, BOTH_RULES))
def test_each_built_in_scene_has_a_valid_certificate(name: str, rule: str) -> None:
    result = checked(name, rule)
    certificate = build_certificate(result)
    text = certificate_text(certificate)
    assert json.loads(text) == certificate
    assert text.isascii()
    start = time.process_time()
    assert check_certificate(certificate) == ""
    seconds = time.process_time() - start
    cells, roots = len(evidence(certificate)["cells"]), len(subject(certificate)["field"])
    assert earlier_array(certificate) is None if (name, rule) in NO_WORDS else not refusal_of_version_1(certificate)
    print(f"{name}, {rule}: {cells} cells, {roots} generators, {len(text)} bytes, {seconds:.3f} s")
    assert len(text) < LARGEST_FILE
    assert seconds < SLOWEST_CHECK
    assert said(certificate).get("theorem 4", "undecided") == result.verdict


def test_the_words_are_those_of_the_check(arrays: Arrays) -> None:
    for scene in (arrays.four_wheel(), arrays.random(3, 4), arrays.cocircular(2)):
        result = check_cells(scene)
        certificate = build_certificate(result)
        for clause in ("equilibrium", "translation", "rotation", "feedback"):
            assert stated_words(certificate).get(clause, "undecided") == getattr(result, clause).verdict
        assert certificate["notes"]["reasons"]["translation"] == result.translation.reason


def test_a_written_file_verifies(arrays: Arrays, tmp_path: Path) -> None:
    path = tmp_path / "certificate.json"
    path.write_text(certificate_text(build_certificate(check_cells(arrays.ring(5)))), encoding="utf-8")
    status, text = check_file(str(path))
    assert status == 0
    assert text.splitlines() == [
        "valid: all claims hold",
        "array: 5 wheels, rule nearest, at (0, 0), square of half side 1, noted as 'ring-5'",
        "equilibrium: holds",
        "translation: asymptotically stable",
        "rotation: unstable",
        "feedback: stabilizable",
        "theorem 4: holds",
        "disc: abs(c) falls off the point where abs(c)^2 <= about 0.654508",
        "drift: a body that rests at the point turns at rates from -0.726543 to 0.726543, rounded",
        "arrival: from abs(c0)^2 <= about 0.654508 a body is at the point after abs(c0)/(1) at the latest",
        "feedback rate: the law of gain K has V' <= -2 K (2429/5000) V, "
        "V = (1) x^2 + 2 (0) x y + (1) y^2 + (1) theta^2",
    ]


def test_one_wheel_point_or_cell_to_a_line(arrays: Arrays) -> None:
    lines = certificate_text(build_certificate(check_cells(arrays.four_wheel()))).splitlines()
    assert sum(line.startswith('  {"position"') for line in lines) == 4
    assert sum(line.startswith('  {"polygon"') for line in lines) == 8


def test_rule_ellipse_has_no_certificate() -> None:
    with pytest.raises(NoCertificateError, match='"nearest" or "box", received "ellipse"'):
        build_certificate(check_smooth(load_scene("four-wheel-side", rule="ellipse")))


def test_a_verdict_of_which_the_checker_shows_another_is_a_fault(arrays: Arrays) -> None:
    result = check_cells(arrays.four_wheel())
    forged = result.with_results(rotation=replace(result.rotation, verdict=Rotation.NEUTRAL))
    with pytest.raises(UnverifiedError, match=r"evidence of the claim .*'stable, not attractive'"):
        build_certificate(forged)


def test_a_law_by_direction_of_c_is_not_followed(arrays: Arrays) -> None:
    """Under rule box the checker follows three twists that serve at c*; otherwise the clause claims nothing."""
    result = check_cells(load_scene("four-wheel", rule="box"))
    assert isinstance(result.feedback, DrivenFeedback)
    assert len(result.feedback.cones) > 1
    certificate = build_certificate(result)
    assert "feedback" not in {**said(certificate), **proofs(certificate)}


def test_cells_that_a_lemma_left_out_are_built() -> None:
    result = check_cells(load_scene("ring-6", rule="box"))
    assert not result.partition.complete
    certificate = build_certificate(result)
    assert len(evidence(certificate)["cells"]) > len(result.partition.cells)


def test_a_load_table_is_certified(arrays: Arrays) -> None:
    scene = arrays.four_wheel(radius=Fraction(1, 4))
    quarter, zero = scene.field(Fraction(1, 4)), scene.field.zero
    table = LoadTable(tuple((quarter, w.position[0] / 4, w.position[1] / 4) for w in scene.wheels))
    moved = replace(scene.check, equilibrium=(scene.field(Fraction(1, 8)), zero))
    scene = replace(scene, contact=Contact("box", table), check=moved)
    certificate = build_certificate(check_cells(scene))
    assert subject(certificate)["loads"][0] == ["1/4", "1/4", "1/4"]
    for forged in (["1/4", "1/4", "1/5"], ["1/4", "1/4", "2"], ["-1/4", "1/4", "1/4"]):
        other = copy.deepcopy(certificate)
        subject(other)["loads"][0] = forged
        assert check_certificate(other)
    evidence(certificate)["cells"][0]["wheels"] = [1, 2, 3, 4]
    assert check_certificate(certificate)


# ---- what the clauses need ---------------------------------------------------------------


def test_a_point_that_is_no_equilibrium_has_a_separator(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    there = (scene.field(Fraction(1, 5)), scene.field(Fraction(1, 10)))
    certificate = build_certificate(check_cells(replace(scene, check=replace(scene.check, equilibrium=there))))
    assert said(certificate)["theorem 4"] == "hypotheses not met"
    assert not {"lowest", "highest"} & set(proofs(certificate))
    proofs(certificate)["separator"] = ["0", "0"]
    assert check_certificate(certificate)


def spiral_of_ties(arrays: Arrays) -> Scene:
    """Equal friction and turned rims: several motions tie in cones that are crossed."""
    return arrays.four_wheel((1, 1), turn=(Fraction(4, 5), Fraction(3, 5)))


UNSTABLE_TURNS: dict[str, tuple[int, int]] = {"escape": (1, 1), "slide": (1, -1)}


@pytest.mark.parametrize("kind", UNSTABLE_TURNS)
def test_outward_and_saddle_arrays_are_certified_unstable(arrays: Arrays, kind: str) -> None:
    x, y = UNSTABLE_TURNS[kind]
    certificate = build_certificate(check_cells(arrays.pushed(x, y)))
    assert (said(certificate)["translation"], evidence(certificate)["disc"]) == ("unstable", None)
    assert said(certificate)["theorem 4"] == "fails"


def elliptic(arrays: Arrays, stretch: int, friction: Pair = (1, HALF)) -> Scene:
    """Rational points of the circle, rims along ``(-x, -stretch y)``: |c|^2 may grow, and still the body arrives."""
    points = [arrays.circle_point(t) for t in (HALF, Fraction(2), -HALF, Fraction(-2))]
    both = [p for x, y in points for p in ((x, y), (-x, -y))]
    wheels: list[WheelData] = [
        w._replace(direction=(-w.position[0], -stretch * w.position[1])) for w in arrays.inward(sorted(set(both)))
    ]
    return arrays.scene(wheels, friction)


@pytest.mark.parametrize("stretch", [2, 3, 5, 8])
def test_what_the_fan_decides_is_certified(arrays: Arrays, stretch: int) -> None:
    """``|c|^2`` grows somewhere at the point, so the checker walks the fan itself: no disc, but a verdict."""
    for friction in ((1, HALF), (HALF, Fraction(1))):
        result = check_cells(elliptic(arrays, stretch, friction))
        certificate = build_certificate(result)
        assert said(certificate)["translation"] == result.translation.verdict
        assert (evidence(certificate)["disc"] is None) == (result.translation.region_radius is None)


def test_ties_are_certified(arrays: Arrays) -> None:
    for scene in (arrays.four_wheel((1, 1)), spiral_of_ties(arrays)):
        certificate = build_certificate(check_cells(scene))
        assert any(len(cell["twists"]) == 2 for cell in evidence(certificate)["cells"])


# ---- the disc ----------------------------------------------------------------------------


FORGED_BARRIERS: list[Any] = [["0", "0", "0"], ["1", "0", "-1"], ["1000", "1000", "0"]]


@pytest.fixture(params=keep(1, (45, 58, 79, 92)))
def growing(arrays: Arrays, request: pytest.FixtureRequest) -> CellCheck:
    """An array in whose square V* grows somewhere away from the point; with these seeds there is one."""
    return check_cells(arrays.cocircular(request.param))


@pytest.mark.parametrize("forgeries", keep(1, [1, len(FORGED_BARRIERS)]))
def test_barriers_bound_the_disc(growing: CellCheck, forgeries: int) -> None:
    """The disc is the region, or a little less where V* limits it; a barrier cannot be left out or moved."""
    disc, radius = certified_disc(growing.partition), growing.translation.region_radius
    assert disc.squared_radius is not None
    assert radius is not None
    assert disc.squared_radius <= radius * radius
    assert float(disc.squared_radius) > float(radius) ** 2 * (1 - 2.0**-17)
    certificate = build_certificate(growing)
    for k, (cell, state) in enumerate(disc.barriers):
        for forged in (2 * FORGED_BARRIERS)[k % 3 :][:forgeries]:  # from one barrier to the next another first
            other = copy.deepcopy(certificate)
            proofs(other)[f"barrier {cell} {state}"] = forged
            assert check_certificate(other) == f"the barrier {cell} {state}"
        other = copy.deepcopy(certificate)
        del proofs(other)[f"barrier {cell} {state}"]
        assert check_certificate(other) == f"a proof of barrier {cell} {state}"


def test_a_larger_disc_than_v_allows_is_rejected(growing: CellCheck) -> None:
    radius = growing.translation.region_radius
    assert radius is not None
    certificate = build_certificate(growing)
    claim_disc(certificate, str(Fraction(float(radius) ** 2 * (1 + 2.0**-10))))
    limited = radius < growing.scene.check.radius
    assert ("barrier" if limited else "a disc in the square") in check_certificate(certificate)


@thorough  # the small one: test_each_built_in_scene_has_a_valid_certificate
def test_verdicts_of_random_arrays_are_certified(arrays: Arrays) -> None:
    """All kinds of verdicts occur."""
    found = set[Translation]()
    for seed in range(8):
        for scene in (arrays.random(seed, 3 + seed % 4), arrays.cocircular(seed)):
            result = check_cells(scene)
            assert build_certificate(result)
            found.add(result.translation.verdict)
    assert {Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE} <= found


def test_extreme_scales_are_certified(arrays: Arrays) -> None:
    """Coordinates and speeds far from one: all signs are exact, so no scale is lost."""
    for scale in (Fraction(1, 10**40), Fraction(10**40)):
        wheels = [w._replace(position=(scale * w.position[0], scale * w.position[1])) for w in arrays.inward(CORNERS)]
        assert said(build_certificate(check_cells(arrays.scene(wheels, radius=scale / 2))))["theorem 4"] == "holds"
