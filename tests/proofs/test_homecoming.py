"""Bodies that come home and stay: balances of forces, discs under rules without cells, and their mass."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_mat

import nonsmooth as ns
from nonsmooth.analysis.bodies.mass_path import simulate_dynamics
from nonsmooth.analysis.bodies.newton_euler import CREEP, MovingLoads, NewtonEuler, RigidBody
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.proofs.answers.answer import at_least
from nonsmooth.proofs.answers.inertia import inertia_answer
from nonsmooth.proofs.boxes.linearization import linearize
from nonsmooth.proofs.clauses.at_point.ellipse import Situation, are_strict, ellipse_point, held_forces
from nonsmooth.proofs.clauses.at_point.mass import MassLimit, Pencil, mass_limits
from nonsmooth.proofs.clauses.authority import roll_authority
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation, decide_translation_at
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.built_in import ruled
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.ellipse_dissipation import EllipseDissipation, loads_in
from tests.proofs.forces_oracle import solves
from tests.thorough import few, keep

Pair = tuple[Fraction | int, Fraction | int]


@pytest.mark.parametrize("friction", [ROLL, (1, Fraction(1, 10)), SIDE])
def test_four_wheel_closed_form(arrays: Arrays, friction: Pair) -> None:
    """c' = -sqrt2 (mu_R/mu_S)^2 c, no rotation."""
    scene = ruled(arrays.four_wheel(friction), "ellipse")
    (region,) = load_regions(scene)
    linear = linearize(scene, region, scene.field.zero)
    assert linear is not None
    ratio = Fraction(friction[0]) / Fraction(friction[1])
    rate = -scene.field.sqrt(2) * ratio * ratio
    zero = scene.field.zero
    assert linear.translation == ((rate, zero), (zero, rate))
    assert linear.rotation_map == (zero, zero)
    assert linear.spectral_abscissa == rate
    assert solves(linear)


def test_a_wheel_out_of_balance_is_refuted(arrays: Arrays) -> None:
    scene = ruled(arrays.four_wheel(), "ellipse")
    wheels = (replace(scene.wheels[0], given_speed=scene.field(-1)), *scene.wheels[1:])
    scene = replace(scene, wheels=wheels)
    (region,) = load_regions(scene)
    assert held_forces(scene, region, scene.field.zero) == ()
    assert ellipse_point(scene, (region,)).equilibrium is Equilibrium.FAILS


def test_wheels_that_stick_hold_the_body_at_rest(arrays: Arrays) -> None:
    """Two driven, two braking wheels: the brakes answer any small imbalance."""
    scene = ruled(arrays.four_wheel(), "ellipse")
    zero = scene.field.zero
    wheels = tuple(replace(w, given_speed=zero) if w.index % 2 == 0 else w for w in scene.wheels)
    scene = replace(scene, wheels=wheels)
    (region,) = load_regions(scene)
    assert are_strict(held_forces(scene, region, zero))
    point = ellipse_point(scene, (region,))
    assert (point.situation, point.translation) == (Situation.STICKING, Translation.STABLE)
    lost, rng = EllipseDissipation(scene, loads_in(region, (zero, zero))), np.random.default_rng(0)
    assert all(lost(rng.normal(size=3) * 1e-3) > lost(np.zeros(3)) for _ in range(200))


def test_torque_authority_is_the_rank_of_the_roll_rows(arrays: Arrays) -> None:
    scene = ruled(arrays.four_wheel(), "ellipse")
    inward = roll_authority(scene)
    zero, one = scene.field.zero, scene.field.one
    assert (inward.rank, inward.missing) == (2, ((zero, zero, one),))
    tangential = arrays.four_wheel(turn=(0, 1))
    assert roll_authority(tangential).rank == 3
    parallel = arrays.scene([w._replace(direction=(1, 0)) for w in arrays.inward([(1, 0), (-1, 0), (2, 0)])])
    assert roll_authority(parallel).rank == 1


def test_rims_on_one_line_through_the_point_leave_two_twists_missing(arrays: Arrays) -> None:
    """Their row has no moment: the missing twists are the motion across it and the rotation."""
    scene = arrays.scene(arrays.inward([(1, Fraction(3, 2)), (-1, Fraction(-3, 2))]), ROLL)
    authority = roll_authority(scene)
    assert authority.rank == 1
    assert np.linalg.matrix_rank(np.array([[float(x) for x in twist] for twist in authority.missing])) == 2
    assert check_theorem4(scene).check()


@pytest.mark.parametrize("seed", range(20))
def test_torque_authority_against_numerical_rank(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    rows = []
    for wheel in scene.wheels:
        d, p = ([float(x) for x in v] for v in (wheel.direction, wheel.position))
        rows.append([*d, d[1] * p[0] - d[0] * p[1]])
    authority = roll_authority(scene)
    assert authority.rank == np.linalg.matrix_rank(np.array(rows))


def many_wheels(arrays: Arrays, rows: int) -> Scene:
    """A grid under the rims (-x, -2 y), with side friction that differs from wheel to wheel."""
    scene = arrays.grid(rows, rows)
    wheels = [
        replace(
            wheel,
            direction=(wheel.direction[0], wheel.direction[1] * 2),
            friction=replace(wheel.friction, side=scene.field(1 + k % 3) / 4),
        )
        for k, wheel in enumerate(scene.wheels)
    ]
    return replace(scene, wheels=tuple(wheels))


@pytest.mark.parametrize("rows", [4, 10])
def test_many_square_roots_leave_the_linearization_exact(arrays: Arrays, rows: int) -> None:
    """An exact inverse of det H would have up to 2^r terms over r square roots: quotients are put off."""
    scene = ruled(many_wheels(arrays, rows), "ellipse")
    linear = linearize(scene, load_regions(scene)[0], scene.field.zero)
    assert linear is not None
    assert solves(linear)
    assert not solves(replace(linear, columns=(linear.columns[1], linear.columns[0])))
    hessian, slope = (np.array([[float(x) for x in row] for row in part]) for part in (linear.hessian, linear.slope))
    motion = -np.linalg.solve(hessian, slope.T)
    columns = np.array([[float(x) for x in column] for column in linear.columns])
    assert np.abs(columns.T - motion).max() < 1e-12
    rates = np.linalg.eigvals(motion[:2])
    assert float(linear.spectral_abscissa) == pytest.approx(rates.real.max(), rel=1e-12)
    turned = -motion[2] @ np.linalg.inv(motion[:2])
    assert [float(x) for x in linear.rotation_map] == pytest.approx(turned, abs=1e-12)
    assert np.abs(turned).max() > 1e-3


# ---- Discs of starts that come home under rules without cells, against minimizers of D all over them.

INWARD = ("four-wheel", "four-wheel-side", "ring-5", "ring-6", "grid-4x4")
POINTS = 200


def translation_of(scene: Scene) -> EllipseTranslation:
    translation = check_theorem4(scene, beside=False).results["translation"]
    assert isinstance(translation, EllipseTranslation)
    assert evidence_holds(translation)
    return translation


def largest_product(scene: Scene, radius: float, seed: int = 5) -> float:
    """The largest ``c . v/|c|`` over random points of a disc, most of them near its border or its centre."""
    centred, rng = scene.recentred(), np.random.default_rng(seed)
    angles = rng.uniform(0, 2 * np.pi, POINTS)
    reaches = radius * rng.choice([0.02, 0.3, 0.9, 1.0], POINTS) * rng.uniform(0.9, 1.0, POINTS)
    points = reaches[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    twists = minima_under(smooth_rule_of(centred), centred, points).twists
    return float(((points * twists[:, :2]).sum(axis=1) / reaches).max())


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("name", INWARD)
def test_the_distance_falls_all_over_the_disc(name: str, rule: str) -> None:
    scene = load_scene(name, rule=rule)
    translation = translation_of(scene)
    assert translation.home_radius is not None
    assert translation.home_radius == scene.check.radius
    assert largest_product(scene, float(translation.home_radius)) < 0


def test_a_spin_at_the_point_does_not_matter() -> None:
    scene = load_scene("spiral-30", rule="ellipse")
    translation = translation_of(scene)
    assert translation.home_radius is not None
    assert largest_product(scene, float(translation.home_radius)) < 0


@few(4)
@pytest.mark.parametrize("name", builtin_scenes())
def test_no_disc_is_claimed_where_the_distance_may_grow(name: str) -> None:
    """Every built-in scene: where a minimizer moves outward, no disc reaches there; a body that is carried stays."""
    scene = load_scene(name, rule="ellipse")
    translation = check_theorem4(scene, beside=False).results["translation"]
    if not isinstance(translation, EllipseTranslation) or translation.home_radius is not None:
        assert translation.verdict is Translation.ASYMPTOTICALLY_STABLE
    elif translation.point.situation is Situation.CARRIED:
        assert translation.region_radius is None or abs(largest_product(scene, float(translation.region_radius))) < 1e-9
    else:
        assert translation.region_radius is None


@pytest.mark.parametrize(("name", "radius"), keep(1, [("ring-6", Fraction(3, 5)), ("grid-4x4", Fraction(5, 4))]))
def test_the_disc_ends_where_a_spring_lifts_off(name: str, radius: Fraction) -> None:
    """Beyond, the loads have another form: the disc is no larger than the part of the square that holds the point."""
    base = load_scene(name, rule="ellipse")
    wide = replace(base, check=replace(base.check, radius=base.field(radius)))
    translation = translation_of(wide)
    assert translation.home_radius is not None
    assert 0 < translation.home_radius < wide.check.radius
    assert largest_product(wide, float(translation.home_radius)) < 0


def test_another_disc_is_refused() -> None:
    translation = translation_of(load_scene("four-wheel", rule="ellipse"))
    assert translation.home_radius is not None
    assert not evidence_holds(replace(translation, region_radius=translation.home_radius * 2))
    saddle = translation_of(load_scene("elliptic", rule="ellipse"))
    assert saddle.home_radius is None
    assert not evidence_holds(replace(saddle, region_radius=saddle.point.scene.check.radius))


# ---- Up to which mass a verdict holds: against the Jacobian of the full dynamics, its paths, and forged evidence.

SPIRAL = ns.Array.ring(
    4,
    radius="sqrt(2)",
    phase="pi/4",
    mu_roll=1,
    mu_side="1/2",
    check_radius="1/2",
    rule="ellipse",
    length=1,
    field={"kind": "spiral", "angle": "pi/6"},
)
BESIDE = 1e-3  # relative distance from the limits at which the eigenvalues are looked at
FIVE_OF_EACH = (0, 1, 3, 4, 5, 2, 14, 28, 31, 32)  # arrays that lose their stability with mass, and that keep it


def translation_at(scene: Scene) -> EllipseTranslation:
    recentred = scene.recentred()
    return decide_translation_at(ellipse_point(recentred, load_regions(recentred, recentred.check.equilibrium)), None)


def limit_of(scene: Scene) -> MassLimit | None:
    return translation_at(scene).mass


def growth(scene: Scene, omega: float, mass: float) -> float:
    """The largest real part of the eigenvalues of the equations that full dynamics integrates, theta left out."""
    recentred = scene.recentred()
    model = contact_model(recentred)
    state = np.array([0.0, 0.0, 0.0, 0.0, 0.0, omega])
    radius = np.sqrt(((model.positions - model.positions.mean(axis=0)) ** 2).sum(axis=1).mean() / 2)
    loads = MovingLoads(model, state[:2])
    equations = NewtonEuler(model, RigidBody(mass, mass * radius**2), loads, CREEP * float(np.abs(model.targets).max()))
    matrix = equations.jacobian(0.0, state)
    states = [0, 1, 3, 4, 5]
    return float(np.linalg.eigvals(matrix[np.ix_(states, states)]).real.max())


def test_the_spiral_loses_stability_where_the_jacobian_says() -> None:
    scene = SPIRAL.scene
    limit = limit_of(scene)
    assert limit is not None
    assert limit.unstable_at is not None
    omega = float(limit.linearization.omega)
    assert growth(scene, omega, float(limit.stable_to) * (1 - BESIDE)) < 0
    assert growth(scene, omega, float(limit.unstable_at) * (1 + BESIDE)) > 0


def leaning_ring(seed: int) -> ns.Array:
    """Rims that lean away from the way inward, all alike: the body spins, and inertia may feed the forces around."""
    draw = random.Random(seed)
    lean = f"{draw.choice((0, 15, 30, 40, 50, 60))} deg"
    friction = Fraction(draw.randrange(2, 25), 10)
    radius = Fraction(draw.randrange(5, 30), 10)
    field = {"kind": "spiral", "angle": lean, "speed": Fraction(draw.randrange(2, 30), 10)}
    return ns.Array.ring(draw.randrange(3, 7), radius=radius, mu_roll=1, mu_side=friction, rule="ellipse", field=field)


def random_limits(seeds: Iterable[int]) -> list[tuple[Scene, MassLimit]]:
    scenes = [leaning_ring(seed).scene for seed in seeds]
    return [(scene, limit) for scene in scenes if (limit := limit_of(scene)) is not None]


@pytest.mark.parametrize("seeds", keep(1, [FIVE_OF_EACH, range(40)]), ids=["five of each", "all"])
def test_limits_of_random_arrays_are_those_of_the_jacobian(seeds: Iterable[int]) -> None:
    found = random_limits(seeds)
    lost = [(scene, limit) for scene, limit in found if limit.unstable_at is not None]
    kept = [(scene, limit) for scene, limit in found if limit.unstable_at is None]
    assert len(lost) >= 5
    assert len(kept) >= 5
    for scene, limit in lost:
        omega = float(limit.linearization.omega)
        for share in (1e-3, 0.03, 0.3, 1 - BESIDE):
            assert growth(scene, omega, float(limit.stable_to) * share) < 0
        assert growth(scene, omega, float(limit.unstable_at or 0) * (1 + BESIDE)) > 0
    for scene, limit in kept:
        omega = float(limit.linearization.omega)
        for power in range(-4, 4):
            assert growth(scene, omega, 10.0**power) < 0


@pytest.mark.parametrize(("share", "grows"), [(0.7, False), (1.3, True)])
def test_paths_beside_the_limit(share: float, grows: bool) -> None:
    """The spiral from its spin, a little beside the point."""
    scene = SPIRAL.scene
    limit = limit_of(scene)
    assert limit is not None
    mass = share * float(limit.stable_to)
    body = RigidBody(mass, mass * float(limit.squared_radius))
    spin = (0.0, 0.0, float(limit.linearization.omega))
    path = simulate_dynamics(contact_model(scene), body, (1e-3, 0.0, 0.0), 60.0, spin)
    late = [np.hypot(*path.state(t)[:2]) for t in np.linspace(50.0, 60.0, 50)]
    early = [np.hypot(*path.state(t)[:2]) for t in np.linspace(0.0, 10.0, 50)]
    assert (max(late) > max(early)) == grows


def test_masses_are_looked_at_equally_far_in_every_unit_of_length() -> None:
    """Moments, which are a thousand times as large in millimetres, do not say how far."""

    def limits(unit: int) -> tuple[Fraction, Fraction | None]:
        damping = arb_mat([[arb(1) / unit, 0, 0], [0, arb(1) / unit, 0], [0, 0, unit]])
        stiffness = arb_mat([[arb(1) / unit, 0], [0, arb(1) / unit], [arb(3) / 10, 0]])
        found = mass_limits(Pencil(damping, stiffness, arb_mat([[1, 0, 0], [0, 1, 0], [0, 0, unit**2]])))
        assert found is not None
        return found

    assert limits(1) == (Fraction(10**6), None)
    assert limits(1000) == (Fraction(10**3), None)


def test_speeds_count_as_the_root_of_the_mass() -> None:
    array = SPIRAL
    faster = array.with_(field={"kind": "spiral", "angle": "pi/6", "speed": 2})
    slow, fast = limit_of(array.scene), limit_of(faster.scene)
    assert slow is not None
    assert fast is not None
    assert fast.stable_to == pytest.approx(slow.stable_to / 4, rel=1e-3)


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_built_in_arrays_are_stable_at_any_mass_but_the_spiral(rule: str) -> None:
    limits = {name: limit_of(load_scene(name, rule=rule)) for name in ("four-wheel", "ring-5", "elliptic", "spiral-30")}
    lost = {name for name, limit in limits.items() if limit is not None and limit.unstable_at is not None}
    assert lost == ({"spiral-30"} if rule == "ellipse" else set())


def test_forged_limits_are_refused() -> None:
    limit = limit_of(SPIRAL.scene)
    assert limit is not None
    assert limit.unstable_at is not None
    assert evidence_holds(limit)
    forged: list[dict[str, Any]] = [
        {"stable_to": limit.unstable_at},
        {"unstable_at": limit.stable_to},
        {"unstable_at": None, "stable_to": limit.stable_to * 2},
        {"stable_to": Fraction(0)},
        {"stable_to": -limit.stable_to},
    ]
    for change in forged:
        assert not evidence_holds(replace(limit, **change))


def test_limits_of_another_array_are_refused() -> None:
    """The same numbers, with another radius: true by chance, as the spin decouples, and not of this array."""
    translation = translation_at(SPIRAL.scene)
    assert translation.mass is not None
    assert evidence_holds(translation)
    other = replace(translation.mass, squared_radius=translation.mass.squared_radius * 2)
    assert not evidence_holds(replace(translation, mass=other))


@pytest.mark.parametrize(("length", "metres", "speed"), keep(1, [("mm", 0.001, 1), ("m", 1, 1), ("m", 1, 10)]))
def test_answers_say_it_in_speeds(length: str, metres: float, speed: int) -> None:
    faster = SPIRAL.with_(units={"length": length}, field={"kind": "spiral", "angle": "pi/6", "speed": speed})
    limit, answer = limit_of(faster.scene), inertia_answer(faster.scene)
    assert limit is not None
    assert answer is not None
    factor = np.sqrt(float(limit.stable_to) * 9.80665 / metres)
    assert float(answer["stable_to"]) == pytest.approx(factor, rel=1e-3)
    assert answer.verdict == ("stable" if factor > 1 else "unstable")
    assert f"it is stable up to {at_least(answer['stable_to'])} times these speeds" in answer.sentence
