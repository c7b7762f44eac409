"""Certificates of arrays: numbers as JSON, the built-in scenes, bounds beside verdicts, independent checks."""

from __future__ import annotations

import copy
import json
import math
import time
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from random import Random
from typing import Any, TypeAlias

import pytest

from nonsmooth.analysis.cells.fan import Growth
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.certificate import build_certificate, certificate_text, stated_words
from nonsmooth.proofs.checker.files import check_file
from nonsmooth.proofs.checker.plane import Form
from nonsmooth.proofs.checker.tower import Field
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation, ellipse_point
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.translation import fan_stability as fans
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, Move, decide_fan
from nonsmooth.proofs.clauses.translation.on_cells import certified_disc
from nonsmooth.proofs.findings import Rotation, Translation, encode, homogeneous
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.proofs.theorem4 import CellCheck, check_cells, check_smooth
from nonsmooth.proofs.verified import UnverifiedError
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable, Scene
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.array_certificates import check_certificate, claim_disc, evidence, proofs, said, subject
from tests.built_in import checked
from tests.conftest import Arrays, Pair, WheelData
from tests.four_wheel import CORNERS
from tests.oracles.array_bounds import assert_bounds_hold
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.rebuilt_arrays import assert_still_true
from tests.proofs.forces_oracle import verifies
from tests.proofs.forged import with_results
from tests.thorough import few, keep, thorough

# ---- Certificates of the built-in scenes: each is valid, small and quickly checked; what they hold and what is
# refused.

Record: TypeAlias = dict[str, Any]

HALF = Fraction(1, 2)
BOTH_RULES = list(product(builtin_scenes(), ("nearest", "box")))
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
    assert_still_true(certificate)
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
        "arrival: from abs(c0)^2 <= about 0.654508 a body is at the point after abs(c0)/1 at the latest",
        "feedback rate: the law of gain K has V' <= -2 K (2429/5000) V, V = x^2 + y^2 + theta^2",
    ]


STAR = """
friction = { mu_roll = "3/4", mu_side = "1/4" }
wheel = [
  { position = ["-1/10", "-1"], heading = "pi/6", speed = 2 },
  { position = ["13/20", "-3/4"], heading = "inward", speed = 2 },
  { position = [1, "-1/10"], heading = [-1, 0] },
  { position = ["3/4", "13/20"], heading = [-4, -3], mu_side = "1/5" },
  { position = ["1/10", 1], heading = "inward", speed = "1/2" },
  { position = ["-13/20", "3/4"], heading = ["7/10", "-7/10"], speed = 2 },
  { position = [-1, "1/10"], heading = "inward", mu_side = "1/5" },
  { position = ["-3/4", "-13/20"], heading = [3, -1] },
]
check = { radius = "1/8" }
"""


def test_an_ellipse_crosses_the_line_of_a_side_beyond_that_side(tmp_path: Path) -> None:
    path = tmp_path / "star.toml"
    path.write_text(STAR, encoding="utf-8")
    certificate = build_certificate(check_cells(load_scene(path)))
    swing = said(certificate)["swing"]
    assert Fraction(swing["squared_radius"]) == Fraction(7405, 10**6) ** 2  # of the disc that is printed
    assert check_certificate(certificate) == ""
    assert evidence(certificate)["ellipse"].pop("sides")
    assert "an ellipse inside the cells at the point" in check_certificate(certificate)
    wider = {**evidence(certificate)["ellipse"], "sides": True, "level": "1/10000", "squared_swing": "1"}
    evidence(certificate)["ellipse"] = wider
    assert "an ellipse inside the cells at the point" in check_certificate(certificate)


def test_an_ellipse_stays_left_of_a_side() -> None:
    field, random = Field([]), Random(5)
    cases: set[tuple[Fraction | None, int]] = set()
    while len(cases) < 9:  # the nearest point within the side or at either end, and each answer
        p, s, q = random.randint(1, 4), random.randint(1, 4), random.randint(-1, 1)
        a, b = ((random.randint(-4, 4), random.randint(-4, 4), random.randint(1, 2)) for _ in range(2))
        turn, level = a[0] * b[1] - a[1] * b[0], Fraction(random.randint(1, 12), 2)
        if turn <= 0 or p * s <= q * q:
            continue
        ends = [(Fraction(x, w), Fraction(y, w)) for x, y, w in (a, b)]
        step = ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]
        slope = step[0] * (p * ends[0][0] + q * ends[0][1]) + step[1] * (q * ends[0][0] + s * ends[0][1])
        share = min(
            max(-slope / (p * step[0] ** 2 + 2 * q * step[0] * step[1] + s * step[1] ** 2), Fraction(0)), Fraction(1)
        )
        x, y = (start + share * along for start, along in zip(ends[0], step, strict=True))
        least = p * x * x + 2 * q * x * y + s * y * y
        form = Form(*(field.rational(n) for n in (p, q, s)))
        corners = [tuple(field.rational(n) for n in end) for end in (a, b)]
        (side,) = form.margins(field.rational(level), [(corners[0], corners[1])], whole=False)
        assert side == (least > level) - (least < level)
        cases.add((share if share in (0, 1) else None, side))


def test_one_wheel_point_or_cell_to_a_line(arrays: Arrays) -> None:
    lines = certificate_text(build_certificate(check_cells(arrays.four_wheel()))).splitlines()
    assert sum(line.startswith('  {"position"') for line in lines) == 4
    assert sum(line.startswith('  {"polygon"') for line in lines) == 8


def test_rule_ellipse_has_no_certificate() -> None:
    with pytest.raises(NoCertificateError, match='"nearest" or "box", received "ellipse"'):
        build_certificate(check_smooth(load_scene("four-wheel-side", rule="ellipse")))


def test_a_verdict_of_which_the_checker_shows_another_is_a_fault(arrays: Arrays) -> None:
    result = check_cells(arrays.four_wheel())
    forged = with_results(result, rotation=replace(result.rotation, verdict=Rotation.NEUTRAL))
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
    verdicts = set[Translation]()
    for seed in range(8):
        for scene in (arrays.random(seed, 3 + seed % 4), arrays.cocircular(seed)):
            result = check_cells(scene)
            assert build_certificate(result)
            verdicts.add(result.translation.verdict)
    assert {Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE} <= verdicts


def test_extreme_scales_are_certified(arrays: Arrays) -> None:
    """Coordinates and speeds far from one: all signs are exact, so no scale is lost."""
    for scale in (Fraction(1, 10**40), Fraction(10**40)):
        wheels = [w._replace(position=(scale * w.position[0], scale * w.position[1])) for w in arrays.inward(CORNERS)]
        assert said(build_certificate(check_cells(arrays.scene(wheels, radius=scale / 2))))["theorem 4"] == "holds"


# ---- Numbers as JSON: only the generators that occur, isolated roots, and points over many square roots.


def encoded(field: NumberField, *numbers: Number) -> tuple[list[Any], list[Any]]:
    document = encode({"field": field, "numbers": list(numbers)})
    return document["field"], document["numbers"]


def test_rationals_are_text_and_need_no_generators() -> None:
    field = NumberField()
    field.sqrt(2)
    assert encoded(field, field(0), field(-HALF), field(3)) == ([], ["0", "-1/2", "3"])


def test_only_generators_that_occur_are_listed() -> None:
    field = NumberField()
    root, _, other = (field.sqrt(k) for k in (2, 3, 5))
    generators, numbers = encoded(field, root * other / 3 - 1)
    assert generators == [
        {"polynomial": ["-2", "0", "1"], "above": "0"},
        {"polynomial": ["-5", "0", "1"], "above": "0"},
    ]
    assert numbers == [[["-1"], ["1/3", 0, 1]]]


def test_a_nested_root_brings_the_roots_inside_it() -> None:
    field = NumberField()
    field.sqrt(7)
    nested = (field.sqrt(2) + 3).sqrt()
    generators, numbers = encoded(field, nested)
    assert [g["polynomial"] for g in generators] == [["-2", "0", "1"], [[["-3"], ["-1", 0]], "0", "1"]]
    assert numbers == [[["1", 1]]]


@pytest.mark.parametrize("order", [5, 7, 8, 9, 11, 20, 28, 36, 52])
def test_the_base_generator_is_the_largest_root_of_its_polynomial(order: int) -> None:
    field = NumberField(order)
    generators, numbers = encoded(field, field.two_cos(1), field.two_cos(2) / 3)
    assert len(generators) == 1
    assert all(isinstance(c, str) for c in generators[0]["polynomial"])
    read = Field(generators)  # the checker accepts it as a polynomial with one root above the bound
    low, high = read.root(0, 60)
    value = 2 * math.cos(2 * math.pi / order) * 2**60
    assert low - 2**12 <= value <= high + 2**12
    assert numbers[0] == [["1", 0]]


def test_the_checker_reads_the_same_numbers() -> None:
    field = NumberField(7)
    numbers = [field.two_cos(1) * field.sqrt(3) - HALF, (field.sqrt(3) + field.two_cos(2) + 4).sqrt() / 5]
    numbers += [a * b - c for a in numbers for b in numbers for c in numbers]
    generators, texts = encoded(field, *numbers)
    read = Field(generators)
    for number, text in zip(numbers, texts, strict=True):
        assert read.parse(text).sign() == number.sign()
        assert not (read.parse(text) * read.parse(text) - read.parse(encode_again(field, number, generators))).sign()


def encode_again(field: NumberField, number: Number, generators: list[Any]) -> Any:
    """The square of a number, computed by the workbench."""
    everything = [field.two_cos(1), *(Number(field, {1 << i: field.one.terms[0]}) for i in range(len(field.radicands)))]
    document = encode({"field": field, "all": everything, "square": number * number})
    assert document["field"] == generators
    return document["square"]


def test_what_is_no_number_text_or_container_is_refused() -> None:
    with pytest.raises(TypeError, match="float"):
        encode({"field": NumberField(), "value": 0.5})


def test_homogeneous_points() -> None:
    field = NumberField()
    roots = [field.sqrt(k) for k in (2, 3, 5)]
    assert homogeneous((field(1), field(HALF))) == (field(1), field(HALF), field(1))
    x = Lazy.of(roots[0]) / Lazy.of(roots[1] - roots[2])
    y = Lazy.of(roots[2]) / Lazy.of(roots[1] - roots[2])
    for values in ((x, y), (x, field(HALF)), (x, 1 / y), (x, x * y)):
        *above, below = homogeneous(values)
        assert below.sign() > 0
        assert all(value == Lazy.of(top) / Lazy.of(below) for value, top in zip(values, above, strict=True))


# ---- What certificates of arrays state beside verdicts: drift, the way home by another V, rotation, the rate of the
# law.
#
# The oracle follows bodies by small steps, and shares no theorem with the checker
# (:mod:`tests.oracles.array_bounds`).

SEEDS = [13, 16, 63]  # arrays that attract although |c|^2 grows; the law of the last is by another P


def number(data: Any) -> Fraction:
    return Fraction(data)


FOUND: dict[int, tuple[Any, Record]] = {}


def of_seed(arrays: Arrays, seed: int) -> tuple[Any, Record]:
    """The check of an array and its certificate, once in a process."""
    if seed not in FOUND:
        result = check_cells(arrays.cocircular(seed))
        FOUND[seed] = result, build_certificate(result)
    return FOUND[seed]


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_bodies_come_home_as_is_stated(arrays: Arrays, seed: int) -> None:
    result, certificate = of_seed(arrays, seed)
    claims = said(certificate)
    assert {"drift", "swing", "arrival", "feedback rate"} <= set(claims)
    printed = result.translation
    assert Fraction(claims["arrival"]["rate"]) >= 1 / Fraction(printed.arrival_per_distance)
    assert float(Fraction(claims["swing"]["squared_swing"])) <= float(printed.swing_radius) ** 2
    assert float(Fraction(claims["swing"]["squared_radius"])) >= float(printed.home_radius) ** 2 * (1 - 2e-6)
    partition = build_nearest_partition(arrays.cocircular(seed).recentred())
    assert_bounds_hold(certificate["statement"]["claims"], partition, number)


def put(certificate: Record, path: tuple[Any, ...], data: Any) -> Record:
    """The certificate with other data in its hypotheses; it claims what these say."""
    forged = copy.deepcopy(certificate)
    holder: Any = evidence(forged)
    for key in path[:-1]:
        holder = holder[key]
    holder[path[-1]] = data
    hypotheses, claims = (
        evidence(forged),
        [c for c in forged["statement"]["claims"] if not set(c) & {"swing", "arrival"}],
    )
    ellipse = hypotheses["ellipse"]
    start = {"squared_radius": ellipse["squared_radius"]}
    claims.append({"swing": {**start, "squared_swing": ellipse["squared_swing"]}})
    claims.append({"arrival": {**start, "rate": ellipse["arrival"]["rate"]}})
    law = {key: hypotheses["law"].get(key) for key in ("form", "weight", "kappa", "squared_reach")}
    forged["statement"]["claims"] = [c for c in claims if "feedback rate" not in c] + [{"feedback rate": law}]
    return forged


FORGED: dict[str, tuple[tuple[Any, ...], Any, str]] = {
    "a larger start": (("ellipse", "squared_radius"), "1", "an ellipse that holds the disc of starts"),
    "no start": (("ellipse", "squared_radius"), "0", "a positive quadratic form"),
    "a smaller swing": (("ellipse", "squared_swing"), "1/16", "an ellipse in the disc that bodies stay in"),
    "a negative swing": (("ellipse", "squared_swing"), "-1", "a positive quadratic form"),
    "an ellipse beyond the cells": (("ellipse", "level"), "1", "an ellipse"),
    "no bend": (("ellipse", "bend"), "0", "a bound of what the rotation adds to V"),
    "a negative bend": (("ellipse", "bend"), "-1", "a bound of what the rotation adds to V"),
    "an indefinite form": (("ellipse", "form"), ["1", "2", "1"], "a positive quadratic form"),
    "a round form": (("ellipse", "form"), ["1", "0", "1"], ""),
    "a faster arrival": (("ellipse", "arrival", "rate"), "2", "a rate at which bodies arrive"),
    "a negative arrival": (("ellipse", "arrival", "rate"), "-1", "a rate at which bodies arrive"),
    "no speeds": (("ellipse", "arrival", "speeds"), [], "positive speeds"),
    "faster speeds": (("ellipse", "arrival", "speeds"), ["9"] * 16, "a speed at which V falls"),
    "rising speeds": (("ellipse", "arrival", "speeds"), ["1/9", "1/8"], "positive speeds"),
    "many speeds": (("ellipse", "arrival", "speeds"), ["1/9"] * 65, "a list of at most 64 items"),
    "no bend on the way": (("ellipse", "arrival", "bend"), "0", "a bound of what the rotation adds to V"),
    "a low level": (("ellipse", "arrival", "level"), "1/1000", "a level that holds the disc of starts"),
    "a turn where it spins": (("ellipse", "turn"), "1000", "a body that arrives, and rests"),
    "a faster law": (("law", "kappa"), "2", "a rate at which the law lets V fall"),
    "no rate": (("law", "kappa"), "0", "a positive weight and rate"),
    "a light heading": (("law", "weight"), "1/1000000000", "a"),
    "a law of another V": (("law", "form"), ["1", "9/10", "1"], "a distance within which the rate holds"),
    "a wider drift": (("drift",), ["-100", "100", "1"], "rate at rest"),
    "a drift turned round": (("drift",), ["1", "-1", "-1"], "a drift over a positive denominator"),
    "a turn about a disc": (("turn",), "1000", "a disc of starts"),
}


@few(10)  # each of these conditions refuses alone in the corpus, tests/certificates/array_conditions.py
@pytest.mark.parametrize("name", FORGED)
def test_forged_bounds_are_rejected(arrays: Arrays, name: str) -> None:
    path, data, why = FORGED[name]
    _, certificate = of_seed(arrays, 13)
    refused = check_certificate(put(certificate, path, data))
    assert refused
    assert why in refused


def test_a_distance_of_the_law_is_load_bearing(arrays: Arrays) -> None:
    """Where P is no multiple of the unit matrix, the rotation turns V."""
    _, certificate = of_seed(arrays, 63)
    reach = Fraction(evidence(certificate)["law"]["squared_reach"])
    for key, data in (("squared_reach", str(4 * reach)), ("slack", "0"), ("least", "1"), ("squared_reach", "0")):
        assert "a distance at which the rotation adds little" in check_certificate(put(certificate, ("law", key), data))
    assert "a distance within which" in check_certificate(put(certificate, ("law", "squared_reach"), None))


def test_a_body_that_is_not_turned_anywhere() -> None:
    """Rule box on an array of outward rims: no cell of the square turns the body."""
    certificate = build_certificate(checked("outward", "box"))
    claims = said(certificate)
    assert claims["turning"] == {"squared_radius": evidence(certificate)["disc"], "per_distance": "0"}
    assert claims["drift"] == ["0", "0", "1"]
    for factor in ("-1", "1"):
        forged = copy.deepcopy(certificate)
        evidence(forged)["turn"] = factor
        for claim in forged["statement"]["claims"]:
            if "turning" in claim:
                claim["turning"]["per_distance"] = factor
        assert bool(check_certificate(forged)) == (factor == "-1")


# ---- What fans, rays and motions at the point say, held against the stand-alone checker, definitions, and forces.

FANS = ("conveyor-3", "saddle", "outward", "spiral-30", "four-wheel")
POINTS = ("spiral-30", "outward", "ring-5", "conveyor-3", "four-wheel")


def forged_fans(result: FanResult) -> Iterator[FanResult]:
    for verdict in set(Translation) - {result.verdict}:
        yield replace(result, verdict=verdict)
    for k, entry in enumerate(result.evidence):
        if entry.move is Move.TIE:  # what is undecided claims nothing
            continue
        before, after = result.evidence[:k], result.evidence[k + 1 :]
        x, y = entry.ray
        yield replace(result, evidence=(*before, replace(entry, ray=(-x, -y)), *after))
        if entry.move in (Move.SLIDE, Move.REST) and len(entry.twists) == 2:
            yield replace(result, evidence=(*before, replace(entry, value=entry.value - 1), *after))
    for k, turn in enumerate(result.turns):
        rest = (*result.turns[:k], *result.turns[k + 1 :])
        yield replace(result, turns=rest)
        yield replace(result, turns=(*rest, replace(turn, order=turn.order * 2)))
        for growth in set(Growth) - {turn.growth}:
            yield replace(result, turns=(*rest, replace(turn, growth=growth)))
        if turn.gain is not None:
            yield replace(result, turns=(*rest, replace(turn, gain=turn.gain * 2)))


@pytest.mark.parametrize("name", FANS)
def test_the_verdict_of_a_fan_is_verified_without_deciding_again(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the stand-alone checker."""
    found = decide_fan(check_cells(load_scene(name)).partition)

    def forbidden(*_: object) -> None:
        raise AssertionError("decided again")

    for decider in ("decide_cones", "slide_speed", "full_turns", "_escapes", "_slides"):
        monkeypatch.setattr(fans, decider, forbidden)
    assert evidence_holds(found)
    assert not [
        forged for forged in forged_fans(found) if forged.verdict is not found.verdict and evidence_holds(forged)
    ]


def test_a_fan_of_a_plain_system_with_turns() -> None:
    result = decide_system(load_system("relay-oscillator"))
    fan = PlanePoint(result.scene).fan
    assert fan is not None
    assert fan.fan.turns
    assert evidence_holds(fan.fan)
    forged = [other for other in forged_fans(fan.fan) if other.verdict is not fan.fan.verdict]
    assert not [other for other in forged if evidence_holds(other)]


def point_of(name: str) -> EllipsePoint:
    scene = load_scene(name, rule="ellipse").recentred()
    return ellipse_point(scene, load_regions(scene, scene.check.equilibrium))


@pytest.mark.parametrize("name", POINTS)
def test_the_motion_at_the_point_verifies_by_forces_and_moments(name: str) -> None:
    point = point_of(name)
    assert evidence_holds(point)
    assert verifies(point)
    if point.twist is None:
        return
    zero, one = point.scene.field.zero, point.scene.field.one
    forged = [replace(point, twist=Twist(zero, zero, point.twist.omega + one))]
    forged += [replace(point, twist=Twist(one, zero, zero)), replace(point, twist=None)]
    others = [Situation.CARRIED, Situation.STICKING]
    others += [Situation.HELD] * (point.situation is not Situation.CARRIED)  # wheels that do not slip are held
    forged += [replace(point, situation=s) for s in others if s is not point.situation]
    assert not [k for k, other in enumerate(forged) if evidence_holds(other) or verifies(other)]
