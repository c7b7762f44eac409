"""Verdicts for every load, against sampled loads: in floats by the minimizers, and exactly as loads that are known."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.load_sets import Loads, load_set, priced
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import contact_model, contacts_under
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.dissipation import Functional, dissipation
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.clauses.equilibrium.clause import EveryLoadEquilibrium
from nonsmooth.proofs.clauses.every_load.point import EveryLoad, build_slopes
from nonsmooth.proofs.clauses.translation.every_load import EveryLoadTranslation, is_positive_on_hull
from nonsmooth.proofs.findings.verdicts import Equilibrium, Feedback, Rotation, Translation
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import Check
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.measured_loads import carried_table
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from nonsmooth.symbolic.mechanics.unknown_loads import LoadScatter, UnknownLoads
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays, WheelData
from tests.oracles.clause_evidence import evidence_holds
from tests.thorough import few, thorough

Floats: TypeAlias = NDArray[np.float64]

STILL = 1e-6  # velocity of a minimizer at rest, at wheels of speed one
SAME_D = 1e-9  # relative

ANY = UnknownLoads()


def with_loads(scene: Scene, rule: str, loads: UnknownLoads = ANY) -> Scene:
    return replace(scene, contact=Contact(rule, loads))


def scattered(scene: Scene, rule: str, height: str = "1/10", stiffness: str = "0") -> Scene:
    scatter = LoadScatter(scene.field(Fraction(height)), scene.field(Fraction(stiffness)))
    return with_loads(scene, rule, UnknownLoads(scatter))


def checked(scene: Scene) -> Check:
    """The check, with its evidence verified."""
    found = check_theorem4(scene)
    assert found.check()
    return found


def of_points(found: Check) -> tuple[EveryLoadEquilibrium, EveryLoadTranslation]:
    equilibrium, translation = found.results["equilibrium"], found.results["translation"]
    assert isinstance(equilibrium, EveryLoadEquilibrium)
    assert isinstance(translation, EveryLoadTranslation)
    return equilibrium, translation


def under(scene: Scene, load: Loads) -> Scene:
    """The array under one load that is known at the point, carried to others, in a square where it is positive."""
    table = carried_table(load, [wheel.position for wheel in scene.wheels])
    known = replace(scene, contact=Contact(scene.contact.rule, table))
    return replace(known, check=replace(known.check, radius=known.check.radius / 64))


def sampled(scene: Scene, count: int, seed: int) -> Iterator[Loads]:
    """Exact loads of the reached set: corners in random directions, and mixtures with the middle."""
    rng, reached = np.random.default_rng(seed), load_set(scene).reached
    for _ in range(count):
        corner = reached.lowest([scene.field(int(k)) for k in rng.integers(-99, 100, len(scene.wheels))])
        share = Fraction(int(rng.integers(1, 8)), 8)
        yield tuple(share * a + (1 - share) * b for a, b in zip(corner, reached.middle, strict=True))


def admissible_at(scene: Scene, points: Floats, rng: np.random.Generator) -> Floats:
    """Random float loads N >= 0 that balance at points, shape (m, n), by linear programs with random prices."""
    from scipy.optimize import linprog

    moments = np.array([[1.0, *map(float, wheel.position)] for wheel in scene.wheels])
    found = []
    for point in points:
        draws = [
            linprog(rng.normal(size=len(moments)), A_eq=moments.T, b_eq=[1, *point], bounds=(0, None)).x
            for _ in range(2)
        ]
        share = rng.choice([0.0, rng.random()])
        found.append(np.maximum(share * draws[0] + (1 - share) * draws[1], 0))
    return np.array(found)


# ---- rollers that turn freely ----------------------------------------------------------------


@few(1)
@pytest.mark.parametrize("rule", ["box", "ellipse", "roller"])
def test_omniwheels_carry_the_body_about_the_point_under_every_load(rule: str) -> None:
    """No row with friction slips at the spin: near the point no other motion is as good, under any admissible load."""
    scene = with_loads(load_scene("omni-3"), rule)
    found = checked(scene)
    assert (found.equilibrium.verdict, found.translation.verdict) == (Equilibrium.HOLDS, Translation.STABLE)
    assert found.rotation.verdict is Rotation.UNSTABLE
    rng, model = np.random.default_rng(8), contact_model(scene)
    points = rng.uniform(-0.1, 0.1, (30, 2)) * float(scene.check.radius)
    loads = admissible_at(scene, points, rng)
    minima = (BoxHighs() if rule == "box" else EllipseMinimizer()).minimize(model, loads)
    assert np.allclose(minima.twists, [0, 0, -1], atol=STILL)
    assert np.allclose(dissipation(Functional.BOX, model, loads, np.array([0, 0, -1.0])), 0, atol=1e-12)


@few(1)
@pytest.mark.parametrize("rule", ["box", "ellipse", "roller"])
def test_mecanum_wheels_on_a_diagonal_leave_the_motion_open(rule: str) -> None:
    """The spin always is a minimizer; where two opposite wheels carry alone, so are motions along their rollers."""
    found = checked(with_loads(load_scene("mecanum-4"), rule))
    assert (found.equilibrium.verdict, found.translation.verdict) == (Equilibrium.HOLDS, Translation.UNDECIDED)
    model = contact_model(load_scene("mecanum-4", rule=rule))
    diagonal = np.array([0.5, 0.0, 0.5, 0.0])
    for along in (0.0, 0.3):  # wheels 1 and 3 grip along (1, -1): a shift along (1, 1) slips nowhere
        twist = np.array([along, along, 1.0])
        assert np.allclose(dissipation(Functional.BOX, model, diagonal, twist), 0, atol=1e-12)
    springs = checked(scattered(load_scene("mecanum-4"), rule))
    assert springs.translation.verdict is Translation.STABLE


# ---- what is said of built-in scenes ---------------------------------------------------------


@few(1)
@pytest.mark.parametrize(
    ("name", "rule", "equilibrium", "translation", "rotation"),
    [
        ("four-wheel", "ellipse", "holds", "asymptotically stable", "undecided"),
        ("four-wheel", "roller", "holds", "asymptotically stable", "undecided"),
        ("four-wheel", "box", "holds", "stable", "undecided"),
        ("four-wheel-side", "ellipse", "holds", "asymptotically stable", "undecided"),
        ("ring-5", "ellipse", "holds", "asymptotically stable", "stable, not attractive"),
        ("ring-5", "box", "holds", "stable", "stable, not attractive"),
        ("spiral-30", "ellipse", "holds", "asymptotically stable", "unstable"),
        ("outward", "ellipse", "holds", "unstable", "undecided"),
        ("conveyor-3", "ellipse", "holds", "stable", "unstable"),
        ("grid-4x4", "ellipse", "fails", "undecided", "undecided"),
        ("grid-4x4", "box", "fails", "undecided", "undecided"),
        ("elliptic", "roller", "fails", "undecided", "undecided"),
        ("off-center", "box", "fails", "undecided", "undecided"),
        ("saddle", "ellipse", "undecided", "undecided", "undecided"),
    ],
)
def test_any_load(name: str, rule: str, equilibrium: str, translation: str, rotation: str) -> None:
    found = checked(with_loads(load_scene(name), rule))
    verdicts = [found.results[clause].verdict for clause in ("equilibrium", "translation", "rotation", "feedback")]
    assert verdicts[:3] == [equilibrium, translation, rotation]
    expected = {"four-wheel-side": Feedback.NOT_APPLICABLE, "conveyor-3": Feedback.STABILIZABLE}  # three loads balance
    assert verdicts[3] is expected.get(name, Feedback.UNDECIDED)
    assert ("can be held" in answers_of(found)[2].verdict) == (name == "conveyor-3")


@few(2)
@pytest.mark.parametrize("rule", ["ellipse", "roller", "box"])
def test_scattered_springs_keep_the_heading(rule: str) -> None:
    """A pair of opposite wheels never carries alone, so rest is strict, and rotation is settled."""
    found = checked(scattered(load_scene("four-wheel"), rule))
    assert found.results["equilibrium"].verdict is Equilibrium.HOLDS
    assert found.rotation.verdict is Rotation.NEUTRAL


def test_nearest_asks_for_no_loads() -> None:
    scene = load_scene("four-wheel")
    plain, free = checked(scene), checked(with_loads(scene, "nearest"))
    assert [result.verdict for _, result in plain.clauses] == [result.verdict for _, result in free.clauses]
    (clause, _) = free.clauses[0]
    assert any("holds for all of them" in fact.words for fact in free.facts(clause))


# ---- for all loads: samples agree ------------------------------------------------------------


@few(1)
@pytest.mark.parametrize(
    ("name", "rule"),
    [
        *product(["four-wheel", "four-wheel-side", "ring-5", "ring-6", "rectangle"], ["ellipse", "roller"]),
        ("spiral-30", "ellipse"),
    ],
)
def test_bodies_come_nearer_under_every_sampled_load(name: str, rule: str) -> None:
    """In floats, all over the disc, at vertices of the loads and between them: ``c . v < 0``."""
    scene = with_loads(load_scene(name), rule)
    _, translation = of_points(checked(scene))
    assert translation.home_radius is not None
    rng = np.random.default_rng(1)
    angles, reaches = rng.uniform(0, 2 * np.pi, 60), float(translation.home_radius) * rng.uniform(0.05, 1, 60)
    points = reaches[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    minima = EllipseMinimizer().minimize(
        contacts_under(smooth_rule_of(scene), scene), admissible_at(scene, points, rng)
    )
    assert ((points * minima.twists[:, :2]).sum(axis=1) < 0).all()


@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "rectangle"])
def test_the_rate_is_kept_near_the_point(name: str) -> None:
    scene = with_loads(load_scene(name), "ellipse")
    _, translation = of_points(checked(scene))
    assert translation.exponential_rate is not None
    rng = np.random.default_rng(2)
    points = 1e-3 * rng.normal(size=(60, 2))
    minima = EllipseMinimizer().minimize(
        contacts_under(smooth_rule_of(scene), scene), admissible_at(scene, points, rng)
    )
    inward = -(points * minima.twists[:, :2]).sum(axis=1) / (points**2).sum(axis=1)
    assert (inward >= 0.99 * float(translation.exponential_rate)).all()


@few(2)
@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "ring-6", "conveyor-3"])
def test_rest_or_spin_minimizes_d_under_every_sampled_load(name: str) -> None:
    """Rule box, by linear programs in floats."""
    scene = with_loads(load_scene(name), "box")
    equilibrium, _ = of_points(checked(scene))
    twist = equilibrium.point.twist
    assert twist is not None
    loads = admissible_at(scene, np.zeros((40, 2)), np.random.default_rng(3))
    minima, model = BoxHighs().minimize(contact_model(scene), loads), contact_model(scene)
    own = np.array([float(entry) for entry in twist])
    mine = dissipation(Functional.BOX, model, loads, np.tile(own, (len(loads), 1)))
    best = dissipation(Functional.BOX, model, loads, minima.twists)
    assert (mine <= best + SAME_D).all()
    if equilibrium.point.situation is EveryLoad.UNIQUE:
        assert (np.abs(minima.twists - own) < STILL).all()


def random_linear_array(arrays: Arrays, seed: int) -> Scene:
    """Wheels on the axes, rims along a linear field ``diag(-1, +-1)`` of their places, random speeds and friction.

    The friction along each rim is the same multiple of its distance on each axis, so forces balance under every load.
    """
    rng = np.random.default_rng(seed)
    signs = (-1, -1 if rng.random() < 0.6 else 1)
    wheels = []
    for axis in (0, 1):
        share = Fraction(int(rng.integers(1, 5)), 2)
        for side in (1, -1, 1)[: int(rng.integers(2, 4))]:
            reach = side * Fraction(int(rng.integers(1, 5)), 1)
            place = (reach, Fraction(0)) if axis == 0 else (Fraction(0), reach)
            rim = tuple(entry * signs[k] for k, entry in enumerate(place))
            friction = (abs(reach) * share, Fraction(int(rng.integers(1, 9)), 4))
            wheels.append(WheelData(place, (rim[0], rim[1]), Fraction(int(rng.integers(1, 5)), 2), friction))
    return arrays.scene(wheels, radius=Fraction(1, 16))


@few(1)
@pytest.mark.parametrize("height", [None, "1/20"])
@pytest.mark.parametrize("seed", range(20))
def test_linear_fields_against_known_loads(arrays: Arrays, seed: int, height: str | None) -> None:
    """What is said for all loads is said, exactly, for each of a sample that is given as known."""
    plain = random_linear_array(arrays, seed)
    scene = with_loads(plain, "ellipse") if height is None else scattered(plain, "ellipse", height)
    found = checked(scene)
    equilibrium, translation = of_points(found)
    assert equilibrium.verdict is Equilibrium.HOLDS
    if translation.verdict is Translation.UNSTABLE:
        assert translation.load is not None
        assert check_theorem4(under(scene, translation.load)).results["translation"].verdict is Translation.UNSTABLE
        return
    for load in sampled(scene, 4, seed):
        known = check_theorem4(under(scene, load))
        assert known.results["equilibrium"].verdict is Equilibrium.HOLDS
        if translation.verdict is Translation.ASYMPTOTICALLY_STABLE:
            assert known.results["translation"].verdict is Translation.ASYMPTOTICALLY_STABLE


@thorough  # about all random cases, which `make bench` runs
def test_linear_fields_are_decided_both_ways(arrays: Arrays) -> None:
    """The test above is no empty promise."""
    verdicts = [
        of_points(check_theorem4(scattered(random_linear_array(arrays, seed), "ellipse", "1/20")))[1].verdict
        for seed in range(20)
    ]
    assert verdicts.count(Translation.ASYMPTOTICALLY_STABLE) >= 4
    assert verdicts.count(Translation.UNSTABLE) >= 4


# ---- where it fails, a load is the witness ---------------------------------------------------


@few(1)
@pytest.mark.parametrize("name", ["off-center", "elliptic", "grid-4x4"])
@pytest.mark.parametrize("rule", ["ellipse", "box"])
def test_the_witness_fails_as_a_known_load(name: str, rule: str) -> None:
    scene = with_loads(load_scene(name), rule)
    equilibrium, _ = of_points(checked(scene))
    load = equilibrium.point.witness
    if load is None:
        assert (name, rule) == ("elliptic", "box")  # undecided
        return
    assert min(load) > 0
    assert check_theorem4(under(scene.recentred(), load)).results["equilibrium"].verdict is Equilibrium.FAILS


@thorough  # the small one: test_the_witness_fails_as_a_known_load
def test_scattered_springs_have_a_witness_that_springs_reach() -> None:
    scene = scattered(load_scene("grid-4x4"), "ellipse", "1/10", "1/10")
    equilibrium, _ = of_points(checked(scene))
    load = equilibrium.point.witness
    assert load is not None
    reached = load_set(scene.recentred()).reached
    assert all(low <= n <= high for low, n, high in zip(reached.least, load, reached.largest, strict=True))
    assert check_theorem4(under(scene, load)).results["equilibrium"].verdict is Equilibrium.FAILS


@few(1)
@pytest.mark.parametrize("rule", ["box", "ellipse"])
def test_forged_evidence_is_refused(rule: str) -> None:
    scene = with_loads(load_scene("grid-4x4"), rule)
    found = check_theorem4(scene)
    equilibrium, translation = of_points(found)
    middle = load_set(scene.recentred()).reached.middle
    wrong = tuple(load * 2 for load in middle)
    for forged in (replace(equilibrium.point, witness=None), replace(equilibrium.point, witness=wrong)):
        assert not found.with_results(equilibrium=EveryLoadEquilibrium(forged)).check()
    stable = replace(translation, verdict=Translation.STABLE)
    assert not found.with_results(translation=stable).check()


def test_a_forged_unstable_verdict_is_refused() -> None:
    found = check_theorem4(with_loads(load_scene("four-wheel"), "ellipse"))
    _, translation = of_points(found)
    middle = translation.point.loads.reached.middle
    forged = replace(translation, verdict=Translation.UNSTABLE, load=middle, comes_home=False)
    assert not evidence_holds(forged)
    assert not found.with_results(translation=forged).check()


@few(3)
@pytest.mark.parametrize("height", [None, "1/5"])
@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "off-center", "grid-4x4"])
def test_floats_leave_out_no_slope_that_matters(name: str, height: str | None) -> None:
    """The sign of the least slope, against all of them in exact numbers."""
    plain = load_scene(name)
    scene = (with_loads(plain, "box") if height is None else scattered(plain, "box", height)).recentred()
    slopes, loads = build_slopes(scene, scene.field.zero), load_set(scene)
    assert slopes is not None
    shown = range(0, len(slopes.rays), max(1, len(slopes.rays) // 60))
    values, doubt = slopes.float_lowest(loads.bound)
    for k in shown:
        prices = slopes.prices(k)
        exact = priced(prices, loads.bound.lowest(prices))
        assert abs(float(exact) - values[k]) <= doubt[k]
        assert slopes.least_sign(loads.bound) <= exact.sign()


# ---- parts ------------------------------------------------------------------------------------


def test_a_square_that_tips_is_refused_for_every_load() -> None:
    scene = load_scene("four-wheel", radius="11/10")
    with pytest.raises(LoadError, match="tips over"):
        check_theorem4(with_loads(scene, "ellipse"))


@pytest.mark.parametrize("seed", range(40))
def test_forms_on_hulls_against_samples(seed: int) -> None:
    """What is shown to be positive is positive at random mixtures."""
    rng, field = np.random.default_rng(seed), NumberField()
    count = int(rng.integers(1, 6))
    entries = rng.integers(-4, 9, (count, count))
    whole = entries + entries.T + np.diag(rng.integers(0, 12, count))
    shown = is_positive_on_hull([[field(int(entry)) for entry in row] for row in whole])
    weights = rng.dirichlet(np.full(count, 0.5), 2000)
    least = np.einsum("mi,ij,mj->m", weights, whole, weights).min()
    assert not (shown and least <= 0)
    if least > 0.5:
        assert shown
