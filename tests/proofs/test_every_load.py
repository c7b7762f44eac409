"""Verdicts and laws for every load, against sampled loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of, smooth_rule_of
from nonsmooth.analysis.cells.load_sets import Loads, load_set, priced
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import ContactRows, contact_model, contacts_under
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.minimum import Functional, dissipation
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.clauses.at_point.every_load import EveryLoad, FloatLoads, build_slopes, every_load_point
from nonsmooth.proofs.clauses.equilibrium.clause import EveryLoadEquilibrium
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback, decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, rim_speeds
from nonsmooth.proofs.clauses.feedback.every_load_law import TwistPyramid, wheels_of
from nonsmooth.proofs.clauses.feedback.loop_bounds import limited_speed, ultimate_bound
from nonsmooth.proofs.clauses.translation.at_point import EveryLoadTranslation, is_positive_on_hull
from nonsmooth.proofs.findings import Certainty, Equilibrium, Feedback, Rotation, Translation
from nonsmooth.proofs.theorem4 import Check, check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.load_model import LoadScatter, UnknownLoads
from nonsmooth.symbolic.mechanics.scene import Contact, LoopErrors, Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.mechanics.springs import carried_table
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays, WheelData
from tests.measured_arrays import Kind, measured_array
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.floats import Floats
from tests.proofs.forged import with_results
from tests.thorough import few, thorough

# ---- Verdicts for every load, against sampled loads: in floats by the minimizers, and exactly as loads that are
# known.


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
    loaded = replace(scene, contact=Contact(scene.contact.rule, table))
    return replace(loaded, check=replace(loaded.check, radius=loaded.check.radius / 64))


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
    loads = []
    for point in points:
        draws = [
            linprog(rng.normal(size=len(moments)), A_eq=moments.T, b_eq=[1, *point], bounds=(0, None)).x
            for _ in range(2)
        ]
        share = rng.choice([0.0, rng.random()])
        loads.append(np.maximum(share * draws[0] + (1 - share) * draws[1], 0))
    return np.array(loads)


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


@pytest.mark.usefixtures("without_law")
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


@few(2)
@pytest.mark.parametrize(
    ("name", "rule", "equilibrium", "translation", "rotation"),
    [
        ("saddle", "ellipse", "undecided", "undecided", "undecided"),
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
    ],
)
def test_any_load(name: str, rule: str, equilibrium: str, translation: str, rotation: str) -> None:
    found = checked(with_loads(load_scene(name), rule))
    verdicts = [found.results[clause].verdict for clause in ("equilibrium", "translation", "rotation", "feedback")]
    assert verdicts[:3] == [equilibrium, translation, rotation]
    expected = {"four-wheel-side": Feedback.NOT_APPLICABLE, "conveyor-3": Feedback.STABILIZABLE}  # three loads balance
    assert verdicts[3] is expected.get(name, Feedback.UNDECIDED)
    assert ("can be held" in answers_of(found)[2].verdict) == (name == "conveyor-3")


@pytest.mark.usefixtures("without_law")
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


@pytest.mark.usefixtures("without_law")
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


@pytest.mark.usefixtures("without_law")
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
    motion = np.array([float(entry) for entry in twist])
    mine = dissipation(Functional.BOX, model, loads, np.tile(motion, (len(loads), 1)))
    best = dissipation(Functional.BOX, model, loads, minima.twists)
    assert (mine <= best + SAME_D).all()
    if equilibrium.point.situation is EveryLoad.UNIQUE:
        assert (np.abs(minima.twists - motion) < STILL).all()


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


@pytest.mark.usefixtures("without_law")
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
        check = check_theorem4(under(scene, load))
        assert check.results["equilibrium"].verdict is Equilibrium.HOLDS
        if translation.verdict is Translation.ASYMPTOTICALLY_STABLE:
            assert check.results["translation"].verdict is Translation.ASYMPTOTICALLY_STABLE


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
@pytest.mark.usefixtures("without_law")
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


def test_roots_that_nest_too_deep_do_not_stop_a_refutation(tmp_path: Path) -> None:
    """Six rims of irrational lengths, each with a spin at which it slips least, ended in a NestingError."""
    rims = [(-79, 57), (-66, -63), (74, -46), (12, 83), (59, 71), (-31, 97)]
    places = [("1", "-4/5"), ("9/10", "7/10"), ("-1/10", "1"), ("-1", "2/5"), ("-4/5", "-3/5"), ("1/5", "-1")]
    wheels = "".join(
        f'[[wheel]]\nposition = ["{x}", "{y}"]\nheading = [{a}, {b}]\n'
        for (x, y), (a, b) in zip(places, rims, strict=True)
    )
    file = tmp_path / "irregular.toml"
    file.write_text(f'[friction]\nmu_roll = "3/4"\nmu_side = "1/3"\n{wheels}', encoding="utf-8")
    scene = with_loads(load_scene(file), "ellipse")
    assert every_load_point(scene.recentred()).equilibrium is Equilibrium.FAILS


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
        assert not with_results(found, equilibrium=EveryLoadEquilibrium(forged)).check()
    stable = replace(translation, verdict=Translation.STABLE)
    assert not with_results(found, translation=stable).check()


def test_a_forged_unstable_verdict_is_refused() -> None:
    found = check_theorem4(with_loads(load_scene("four-wheel"), "ellipse"))
    _, translation = of_points(found)
    middle = translation.point.loads.reached.middle
    forged = replace(translation, verdict=Translation.UNSTABLE, load=middle, comes_home=False)
    assert not evidence_holds(forged)
    assert not with_results(found, translation=forged).check()


@few(3)
@pytest.mark.parametrize("height", [None, "1/5"])
@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "off-center", "grid-4x4"])
def test_floats_leave_out_no_slope_that_matters(name: str, height: str | None) -> None:
    """The sign of the least slope, against all of them in exact numbers."""
    plain = load_scene(name)
    scene = (with_loads(plain, "box") if height is None else scattered(plain, "box", height)).recentred()
    slopes, loads = build_slopes(scene, scene.field.zero), load_set(scene)
    assert slopes is not None
    indices = range(0, len(slopes.rays), max(1, len(slopes.rays) // 60))
    values, doubt = slopes.float_lowest(loads.bound)
    for k in indices:
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
    positive = is_positive_on_hull([[field(int(entry)) for entry in row] for row in whole])
    weights = rng.dirichlet(np.full(count, 0.5), 2000)
    least = np.einsum("mi,ij,mj->m", weights, whole, weights).min()
    assert not (positive and least <= 0)
    if least > 0.5:
        assert positive


# ---- Laws for every load, against minimizers of D under sampled loads that share nothing with the proof.

LOADS, POSES = 32, 200
NEAR = 1e-5  # distance from the point, in lengths: loads and slips differ by that
SLACK = 1e-3  # of the rate: motions differ from those at the point, and solvers end with a gap
HEIGHT = 0.3

ANY_LOAD, UNEVEN = "any", "uneven"
SPIRAL = """name = "spiral"
[friction]
mu_roll = 1
mu_side = "1/5"
[ring]
count = 5
[field]
kind = "spiral"
angle = "pi/4"
"""
FRAGILE = measured_array(Kind.COCIRCULAR, 22)


def array(text: str, rule: str, loads: str, folder: Path) -> Scene:
    """A scene from its text, or a built-in one, measured from the point, its loads unknown."""
    file = folder / "array.toml"
    file.write_text(text, encoding="utf-8")
    scene = load_scene(file if "\n" in text else text).recentred()
    zero = scene.field.zero
    unknown = UnknownLoads() if loads == ANY_LOAD else UnknownLoads(LoadScatter(zero + Fraction(3, 10), zero))
    return replace(scene, contact=Contact(rule, unknown))


def sampled_loads(scene: Scene, c: Floats, rng: np.random.Generator) -> Floats:
    """Springs of random heights with the body on them (m, n), or corners of all admissible loads."""
    from scipy.optimize import linprog

    moments = np.array([[1.0, *map(float, wheel.position)] for wheel in scene.wheels])
    wanted, count = np.array([1.0, *c]), len(moments)
    if scene.contact.loads == UnknownLoads():
        prices = rng.normal(size=(LOADS, count))
        return np.array([linprog(p, A_eq=moments.T, b_eq=wanted, bounds=(0, None)).x for p in prices])
    heights = HEIGHT / count * rng.choice([-1.0, 1.0], (LOADS, count))  # in units of 1/k
    poses = np.linalg.solve(moments.T @ moments, (wanted + heights @ moments).T)
    loads: Floats = (moments @ poses).T - heights
    assert loads.min() > 0  # no wheel lifts
    return loads


@dataclass(frozen=True)
class Loop:
    """A law in floats, with l for the unit of length: its twists (3, 3), and what they become under loads (3, m, 3)."""

    twists: Floats
    motions: Floats

    def rates(self, g: Floats) -> Floats:
        """The velocities of g under all loads at gain one, (m, 3)."""
        products = self.twists @ g
        chosen = int(np.argmax(np.abs(products)))
        velocities: Floats = -products[chosen] * self.motions[chosen]
        return velocities

    def worst(self, rng: np.random.Generator) -> float:
        """The largest ``V'/2 / |g|^2`` at random poses."""
        poses = rng.normal(size=(POSES, 3))
        poses /= np.linalg.norm(poses, axis=1, keepdims=True)
        return max(float((self.rates(g) @ g).max()) for g in poses)


def loop_of(scene: Scene, cone: LawCone) -> Loop:
    """The law of a cone under sampled loads near the point."""
    rescaled, rng = in_own_length(scene), np.random.default_rng(5)
    loads, rule = sampled_loads(rescaled, NEAR * rng.normal(size=2), rng), rule_of(rescaled)
    model = contacts_under(rule, rescaled)
    minimizer = EllipseMinimizer() if isinstance(rule, SmoothRule) else BoxHighs()
    motions = []
    for imposed in cone.twists:
        targets = np.zeros(2 * model.wheels)
        targets[0::2] = rim_speeds(rescaled, imposed)
        motions.append(minimizer.minimize(replace(model, targets=targets), loads).twists)
    return Loop(np.array([[float(x) for x in imposed.twist] for imposed in cone.twists]), np.array(motions))


def certified(scene: Scene) -> DrivenFeedback:
    """The law for every load, with its evidence verified."""
    feedback = decide_driven_feedback(scene)
    assert feedback.verdict is Feedback.STABILIZABLE
    assert evidence_holds(feedback)
    assert feedback.scene is scene
    return feedback


@few(1)
@pytest.mark.parametrize(
    ("text", "rule", "loads"),
    [
        (SPIRAL, "ellipse", ANY_LOAD),
        (SPIRAL, "roller", ANY_LOAD),
        (SPIRAL, "box", ANY_LOAD),
        ("ring-5", "ellipse", UNEVEN),
        ("ring-5", "roller", UNEVEN),
        ("ring-5", "box", UNEVEN),
    ],
)
def test_v_falls_at_the_certified_rate_under_sampled_loads(text: str, rule: str, loads: str, tmp_path: Path) -> None:
    scene = array(text, rule, loads, tmp_path)
    feedback = certified(scene)
    assert feedback.certified_kappa is not None
    worst = loop_of(scene, feedback.cones[0]).worst(np.random.default_rng(1))
    assert worst <= -float(feedback.certified_kappa) * (1 - SLACK)


def test_the_law_of_level_springs_fails_where_the_law_for_every_load_works(tmp_path: Path) -> None:
    """Under some heights V rises with the fastest law on level springs; the law for all of them is another one."""
    scene = array(FRAGILE, "ellipse", UNEVEN, tmp_path)
    level = decide_driven_feedback(replace(scene, contact=Contact("ellipse")))
    feedback, rng = certified(scene), np.random.default_rng(1)
    assert level.kappa is not None
    assert feedback.kappa is not None
    assert level.kappa > feedback.kappa
    assert loop_of(scene, level.cones[0]).worst(rng) > 0
    assert loop_of(scene, feedback.cones[0]).worst(rng) < 0


def test_a_law_is_no_law_for_other_loads_or_a_better_rate(tmp_path: Path) -> None:
    scene = array(FRAGILE, "ellipse", UNEVEN, tmp_path)
    feedback = certified(scene)
    law = feedback.every_load
    assert law is not None
    other = replace(scene, contact=Contact("ellipse", UnknownLoads()))
    for slack in (law.slack / 8, Fraction(0), Fraction(1)):
        assert not evidence_holds(replace(feedback, every_load=replace(law, slack=slack)))
    assert not evidence_holds(replace(feedback, every_load=replace(law, scene=in_own_length(other))))


def test_loads_that_balance_in_one_way_only_leave_the_rate(tmp_path: Path) -> None:
    """Three wheels."""
    scene = array("ring-3", "ellipse", ANY_LOAD, tmp_path)
    level = decide_driven_feedback(replace(scene, contact=Contact("ellipse")))
    feedback = certified(scene)
    assert feedback.kappa == level.kappa
    assert feedback.kept > Fraction(99, 100)


def test_what_no_law_holds_on_level_springs_no_law_holds_for_every_load(tmp_path: Path) -> None:
    feedback = decide_driven_feedback(array("differential-drive", "ellipse", UNEVEN, tmp_path))
    assert feedback.verdict is Feedback.NO_CERTIFICATE
    assert feedback.reason.startswith("on level springs, which are among the loads: ")
    assert evidence_holds(feedback)


def test_late_poses_and_ends_of_speeds_take_the_rest_of_the_rate(tmp_path: Path) -> None:
    """A loop just below the largest delay comes home while a random load acts in every step."""
    scene = array(FRAGILE, "ellipse", UNEVEN, tmp_path)
    feedback = certified(scene)
    zero, rng = scene.field.zero, np.random.default_rng(0)
    bound = ultimate_bound(feedback, LoopErrors(zero, zero, Fraction(0)))
    assert bound.verdict is Certainty.CERTIFIED
    assert bound.largest_delay is not None
    loop, lag = loop_of(scene, feedback.cones[0]), 20
    step = float(bound.largest_delay) * 0.9 / lag
    path = [np.array([0.6, -0.3, 0.7])] * (lag + 1)
    for _ in range(4000):
        rates = loop.rates(path[-1 - lag])
        path.append(path[-1] + step * rates[rng.integers(len(rates))])
    sizes = np.linalg.norm(path, axis=1)
    assert sizes.max() < 1.05
    assert sizes[-1] < 0.9
    with_limits = replace(scene, wheels=tuple(replace(wheel, speed_limit=zero + 1) for wheel in scene.wheels))
    free, level = limited_speed(feedback, with_limits), limited_speed(replace(feedback, every_load=None), with_limits)
    assert free is not None
    assert level is not None
    assert free == level * feedback.kept


def test_a_pyramid_holds_what_it_holds() -> None:
    """Wheels at random: a pyramid that does not hold the motion is refused, one with some room about it is not."""
    rng = np.random.default_rng(2)
    rows, targets = np.empty((12, 3)), np.zeros(12)
    rows[::2], rows[1::2] = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    targets[::2] = rng.normal(size=6)
    driven, loads = ContactRows(rows, targets, np.ones(12)), FloatLoads(np.full((1, 6), 1 / 6), np.zeros((0, 6)))
    motion = minimum(driven)
    for away, slack, held in ((0.0, Fraction(1, 100), True), (0.3, Fraction(1, 5), False), (0.3, Fraction(3, 5), True)):
        twists = np.eye(3) * np.linalg.norm(motion)
        twists[0] = motion
        twists[0] = motion + away * np.linalg.norm(motion) * np.array([0, 0, 1.0])
        pyramid = TwistPyramid(twists, 0, slack, max(2 * slack, Fraction(1, 8)))
        assert pyramid.holds_minimizers(driven, loads) == held


def minimum(driven: ContactRows) -> Floats:
    """The minimizer of D for equal loads, by a general method."""
    from scipy.optimize import minimize

    solution = minimize(lambda xi: np.hypot(*driven.slips(xi).T).sum(), np.zeros(3), method="Nelder-Mead", tol=1e-12)
    point: Floats = solution.x
    return point


def test_rows_are_rounded_once() -> None:
    """Rims to the centre have no moment: products of floats leave 1e-16 of it, which no doubt counts."""
    rows = wheels_of(load_scene("ring-5", rule="ellipse")).rows
    assert not rows[::2, 2].any()
    assert np.abs(rows[1::2, 2]) == pytest.approx(1.0)
