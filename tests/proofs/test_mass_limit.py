"""Up to which mass a verdict holds: against the Jacobian of the full dynamics, its paths, and forged evidence."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.bodies.mass_path import simulate_dynamics
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.dynamics.newton_euler import CREEP, MovingLoads, NewtonEuler, RigidBody
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.proofs.answers.answer import at_least
from nonsmooth.proofs.answers.inertia import inertia_answer
from nonsmooth.proofs.clauses.at_point.ellipse import ellipse_point
from nonsmooth.proofs.clauses.at_point.mass import MassLimit
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation, decide_translation_at
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.clause_evidence import evidence_holds
from tests.thorough import few, keep

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


def translation_of(scene: Scene) -> EllipseTranslation:
    own = scene.recentred()
    return decide_translation_at(ellipse_point(own, load_regions(own, own.check.equilibrium)), None)


def limit_of(scene: Scene) -> MassLimit | None:
    return translation_of(scene).mass


def growth(scene: Scene, omega: float, mass: float) -> float:
    """The largest real part of the eigenvalues of the equations that full dynamics integrates, theta left out."""
    own = scene.recentred()
    model = contact_model(own)
    state = np.array([0.0, 0.0, 0.0, 0.0, 0.0, omega])
    radius = np.sqrt(((model.positions - model.positions.mean(axis=0)) ** 2).sum(axis=1).mean() / 2)
    loads = MovingLoads(model, state[:2])
    equations = NewtonEuler(model, RigidBody(mass, mass * radius**2), loads, CREEP * float(np.abs(model.targets).max()))
    matrix = equations.jacobian(0.0, state)
    kept = [0, 1, 3, 4, 5]
    return float(np.linalg.eigvals(matrix[np.ix_(kept, kept)]).real.max())


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
    found = translation_of(SPIRAL.scene)
    assert found.mass is not None
    assert evidence_holds(found)
    other = replace(found.mass, squared_radius=found.mass.squared_radius * 2)
    assert not evidence_holds(replace(found, mass=other))


@few(2)
@pytest.mark.parametrize(("length", "metres", "speed"), [("m", 1, 1), ("mm", 0.001, 1), ("m", 1, 10)])
def test_answers_say_it_in_speeds(length: str, metres: float, speed: int) -> None:
    faster = SPIRAL.with_(units={"length": length}, field={"kind": "spiral", "angle": "pi/6", "speed": speed})
    limit, answer = limit_of(faster.scene), inertia_answer(faster.scene)
    assert limit is not None
    assert answer is not None
    factor = np.sqrt(float(limit.stable_to) * 9.80665 / metres)
    assert float(answer["stable_to"]) == pytest.approx(factor, rel=1e-3)
    assert answer.verdict == ("stable" if factor > 1 else "unstable")
    assert f"it is stable up to {at_least(answer['stable_to'])} times these speeds" in answer.sentence
