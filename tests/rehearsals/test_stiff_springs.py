"""A new load model is one class: exact regions, enclosures, floats, clauses and paths take it from there."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from flint import arb

from nonsmooth.analysis.bodies.many_paths import ManyPaths
from nonsmooth.analysis.bodies.mass_path import MassPath
from nonsmooth.analysis.bodies.newton_euler import MovingLoads, RigidBody
from nonsmooth.analysis.bodies.path import BodyPath, smooth_path
from nonsmooth.analysis.cells.contact_rule import CellRule, contact_rule, smooth_rule_of
from nonsmooth.analysis.cells.loads import LoadError, load_regions, value_at
from nonsmooth.analysis.fields.contact_model import contact_model, contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.many_twists import loads_of
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.answers.failures import failures_of
from nonsmooth.proofs.boxes.balanced_forces import load_box
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import with_only
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import moved, scaled
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.oracles.wheels_in_floats import places_of
from tests.rehearsals.stiff_springs import StiffSprings
from tests.springs import least_energy

STIFFNESS = (1, 3, 2, 5, 1, 2)
NAMES = ["four-wheel", "ring-6", "off-center"]
AWAY = np.array([2.0, 3.0])


@cache
def stiff(name: str, rule: str = "ellipse") -> Scene:
    scene = load_scene(name, rule=rule)
    springs = StiffSprings(tuple(scene.field(k) for k in STIFFNESS[: len(scene.wheels)]))
    return replace(scene, contact=replace(scene.contact, loads=springs))


def places(scene: Scene) -> Floats:
    """Places in the hull of the wheels, some near its border, where wheels have lifted off."""
    wheels = places_of(scene)
    return np.random.default_rng(0).dirichlet(np.full(len(wheels), 0.4), 12) @ wheels


def energy_least(scene: Scene, place: Floats, springs: Sequence[int] = STIFFNESS) -> Floats:
    """Loads of springs of equal height."""
    places = places_of(scene)
    return least_energy(places, np.array(springs[: len(places)], float), np.zeros(len(places)), place)


def test_the_model_is_one_short_class() -> None:
    assert len(inspect.getsource(StiffSprings).splitlines()) <= 40


@pytest.mark.parametrize("name", NAMES)
def test_floats_find_the_least_energy(name: str) -> None:
    scene = stiff(name)
    points = places(scene)
    for place, loads in zip(points, loads_at(contact_model(scene), points), strict=True):
        assert loads.min() >= 0
        np.testing.assert_allclose(loads, energy_least(scene, place), atol=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_exact_regions_and_balls_say_the_same(name: str) -> None:
    scene = stiff(name)
    x, y = scene.check.equilibrium
    regions = load_regions(scene)
    centre = next(region for region in regions if region.polygon.contains((x, y)))
    exact = [float(value_at(form, (x, y))) for form in centre.forces]
    np.testing.assert_allclose(loads_at(contact_model(scene), [[float(x), float(y)]])[0], exact, atol=1e-13)
    assert sum((region.polygon.area for region in regions), scene.field.zero) == (2 * scene.check.radius) ** 2
    if all(form[0] or form[1] or form[2] for form in centre.forces):
        box = load_box(scene, arb(0))
        assert box is not None
        for ball, value in zip(box.at((x.ball(), y.ball())), exact, strict=True):
            assert abs(float(ball) - value) < 1e-13


def test_loads_follow_a_body_that_moves_and_scenes_that_are_moved_or_enlarged() -> None:
    scene = stiff("ring-6")
    model, points = contact_model(scene), places(scene)
    moving = MovingLoads(model, points[0])
    for place in points:
        loads, slopes = moving.at(place)
        np.testing.assert_allclose(loads, loads_at(model, place[None])[0], atol=1e-12)
        if (loads[loads > 0] > 1e-3).all():
            nearby = loads_at(model, place[None] * (1 - 1e-7))[0]
            np.testing.assert_allclose(loads - slopes @ place * 1e-7, nearby, atol=1e-12)
    for other, there in (
        (moved(scene, Fraction(2), Fraction(3)), points + AWAY),
        (scaled(scene, Fraction(4)), 4 * points),
    ):
        np.testing.assert_allclose(loads_at(contact_model(other), there), loads_at(model, points), atol=1e-12)


@pytest.mark.parametrize("rule", ["box", "ellipse", "roller"])
def test_clauses_and_paths_take_it(rule: str) -> None:
    scene = stiff("four-wheel", rule)
    result = check_theorem4(scene)
    assert result.check()
    point = np.array([[float(x) for x in scene.check.equilibrium]])
    here = contact_rule(rule)
    if isinstance(here, CellRule):
        twists = here.literal_twists(scene, point)
    else:
        twists = minima_under(smooth_rule_of(scene), scene, point).twists
    assert np.isfinite(twists).all()
    if rule != "box":
        path = smooth_path(smooth_rule_of(scene), scene, (0.2, 0.1, 0.0), 0.5)
        other = smooth_path(smooth_rule_of(scene), load_scene("four-wheel", rule=rule), (0.2, 0.1, 0.0), 0.5)
        assert np.abs(path.array[-1] - other.array[-1]).max() > 1e-4
    with pytest.raises(NoCertificateError, match="springs of stiffness 1, 3, 2, 5"):
        build_certificate(result)


def outlined(stiffness: Sequence[int], rule: str = "ellipse") -> Scene:
    scene = load_scene("carton-on-6x6", rule=rule)
    springs = StiffSprings(tuple(scene.field(stiffness[k % len(stiffness)]) for k in range(len(scene.wheels))))
    return replace(scene, contact=replace(scene.contact, loads=springs))


POSE = (0.3, 0.2, 0.4)


@pytest.mark.parametrize("rule", ["box", "ellipse"])
def test_a_body_with_an_outline_goes_on_equal_stiffness_as_on_equal_springs(rule: str) -> None:
    equal, like = load_scene("carton-on-6x6", rule=rule), outlined([2], rule)
    for scene in (equal, like):
        assert check_theorem4(scene, beside=False).check()
    assert answers(like) == answers(equal)
    if rule == "box":
        assert failures_of(like) == failures_of(equal)
    else:
        ends = [
            BodyPath(contacts_under(smooth_rule_of(scene), scene), scene).follow(POSE, 20.0).end
            for scene in (equal, like)
        ]
        assert ends[1].t == pytest.approx(ends[0].t, abs=1e-9)
        np.testing.assert_allclose(ends[1].state, ends[0].state, atol=1e-9)


def answers(scene: Scene) -> list[tuple[str, str]]:
    return [(answer.name, str(answer.verdict)) for answer in answers_of(check_theorem4(scene, beside=False))]


def test_the_loads_of_many_bodies_have_the_least_energy() -> None:
    scene = outlined(STIFFNESS)
    model = contacts_under(smooth_rule_of(scene), scene)
    chance = np.random.default_rng(3)
    wheels = np.array([chance.choice(len(scene.wheels), 7, replace=False) for _ in range(8)])
    carrying = chance.random(wheels.shape) < 0.8
    weights = np.where(carrying, chance.random(wheels.shape), 0.0)
    centres = (weights[..., None] * model.positions[wheels]).sum(axis=1) / weights.sum(axis=1)[:, None]
    found, balanced = loads_of(model, wheels, carrying, model.positions[wheels] - centres[:, None])
    assert balanced.all()
    assert not found[~carrying].any()
    for row, centre, own, under in zip(found, centres, wheels, carrying, strict=True):
        alone = with_only(scene, [scene.wheels[k] for k in own[under]])
        stiffness = [STIFFNESS[k % len(STIFFNESS)] for k in own[under]]
        np.testing.assert_allclose(row[under], energy_least(alone, centre, stiffness), atol=1e-6)


def test_paths_and_maps_of_a_body_on_unequal_springs_end_alike() -> None:
    scene = outlined((1, 2, 3))
    law = smooth_rule_of(scene)
    end = BodyPath(contacts_under(law, scene), scene).follow(POSE, 20.0).end
    other = load_scene("carton-on-6x6", rule="ellipse")
    assert np.abs(end.state[2] - BodyPath(contacts_under(law, other), other).follow(POSE, 20.0).end.state[2]) > 1e-3
    many = ManyPaths(scene, law).follow(np.array([POSE]))
    np.testing.assert_allclose(many.poses[0], end.state, atol=0.01)


def test_a_dynamic_body_on_equal_stiffness_goes_as_on_equal_springs() -> None:
    paths = []
    for scene in (load_scene("carton-on-6x6", rule="ellipse"), outlined([3])):
        model = contacts_under(smooth_rule_of(scene), scene)
        paths.append(MassPath(model, RigidBody(0.1, 0.1), scene).follow(POSE, 0.5))
    np.testing.assert_allclose(paths[1].states[-1], paths[0].states[-1], atol=1e-9)


def test_no_loads_exist_outside_the_wheels() -> None:
    with pytest.raises(LoadError, match="tips"):
        loads_at(contact_model(stiff("four-wheel")), [[9.0, 0.0]])
