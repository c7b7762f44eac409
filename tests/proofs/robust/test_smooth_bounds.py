"""Equilibria of every array of a box under rules without cells, against arrays drawn from it and solved in floats."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import root

from nonsmooth.analysis.fields.contact_model import ContactModel, with_friction_sets
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.answers.robust import robust_facts
from nonsmooth.proofs.findings.verdicts import Certainty
from nonsmooth.proofs.robust.decide import Robust, SmoothProof, decide_robust
from nonsmooth.proofs.robust.smooth_rules import SmoothDisc, equilibrium_box
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.mechanics.unknown_loads import UnknownLoads
from tests.outlined import on, polygon_of
from tests.thorough import few, keep, thorough

Floats: TypeAlias = NDArray[np.float64]

SLACK = 1e-6  # of the wheels' distance: a zero of a field of numerical minimizers


def small_box(scene: Scene) -> Tolerance:
    def share(top: int, bottom: int) -> object:
        return scene.field(Fraction(top, bottom))

    return Tolerance(share(1, 1000), Fraction(1, 1800), share(1, 500), share(1, 100), share(1, 100), share(0, 1))  # type: ignore[arg-type]


def drawn(scene: Scene, box: Tolerance, rng: np.random.Generator, *, corner: bool) -> ContactModel:
    """One array of the box, a corner of it or one inside."""

    def shift(size: tuple[int, ...]) -> Floats:
        return rng.choice([-1.0, 1.0], size) if corner else rng.uniform(-1, 1, size)

    n = len(scene.wheels)
    places = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
    places = places + float(box.position) * shift((n, 2))
    directions = [[float(x) for x in wheel.unit_direction] for wheel in scene.wheels]
    angles = np.array([np.arctan2(b, a) for a, b in directions]) + np.pi * float(box.heading) * shift((n,))
    speeds = np.array([float(wheel.speed) for wheel in scene.wheels]) * (1 + float(box.speed) * shift((n,)))
    roll = np.array([float(wheel.friction.roll) for wheel in scene.wheels]) * (1 + float(box.mu_roll) * shift((n,)))
    side = np.array([float(wheel.friction.side) for wheel in scene.wheels]) * (1 + float(box.mu_side) * shift((n,)))
    rims = np.column_stack([np.cos(angles), np.sin(angles)])
    if scene.contact.rule == "ellipse":
        return ContactModel.build(places, rims, speeds, np.column_stack([roll, side]))
    rolls = [(wheel.friction.rule or scene.contact.rule) == "roller" for wheel in scene.wheels]
    across, cuts = np.where(rolls, roll, side), np.where(rolls, np.minimum(side / roll, 1.0), 1.0)
    model = ContactModel.build(places, rims, speeds, np.column_stack([roll, across]))
    sets = [FrictionSet(*axes) for axes in zip(roll, across, cuts, strict=True)]
    return with_friction_sets(model, sets)


def velocity(model: ContactModel, c: Floats) -> Floats:
    vx, vy, omega = EllipseMinimizer().minimize(model, loads_at(model, c[None])).twists[0]
    return np.array([vx - omega * c[1], vy + omega * c[0]])


def mixed(name: str) -> Scene:
    """A built-in array in which every second wheel has rollers."""
    scene = load_scene(name, rule="ellipse")
    kinds = ("ellipse", "roller")
    wheels = [
        replace(wheel, friction=replace(wheel.friction, rule=kinds[k % 2])) for k, wheel in enumerate(scene.wheels)
    ]
    return replace(scene, wheels=tuple(wheels), contact=replace(scene.contact, rule="mixed"))


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("name", keep(2, ["four-wheel", "elliptic", "ring-6", "grid-4x4"]))
@pytest.mark.parametrize("count", keep(1, [4, 12]))
def test_every_array_has_its_equilibrium_in_the_disc_and_it_attracts(name: str, rule: str, count: int) -> None:
    assert_each_attracts(standing(load_scene(name, rule=rule)).recentred(), count)


@pytest.mark.parametrize("name", keep(1, ["four-wheel", "ring-6"]))
def test_every_array_of_mixed_wheels_has_its_equilibrium_in_the_disc_and_it_attracts(name: str) -> None:
    scene = mixed(name).recentred()
    assert_each_attracts(scene, 6, small_box(scene).times(Fraction(1, 10)))


@thorough  # of wheels of one kind: test_what_is_said; mixed ones: the test above
def test_tolerances_of_mixed_wheels_are_followed() -> None:
    scene = mixed("four-wheel")
    found = SmoothProof(scene.recentred()).all_that_is_shown(small_box(scene))
    assert found is not None
    assert found.verdict is Certainty.CERTIFIED
    assert found.start is not None


def assert_each_attracts(scene: Scene, count: int, tolerances: Tolerance | None = None) -> None:
    """Every array that is drawn rests in the disc that is proved, and near it the body comes to that place."""
    box = tolerances or small_box(scene)
    found = equilibrium_box(scene, box)
    assert found is not None
    reach, rng = float(found.squared) ** 0.5, np.random.default_rng(2)
    for k in range(count):
        model = drawn(scene, box, rng, corner=k % 2 == 0)
        solved = root(lambda c, model=model: velocity(model, c), np.zeros(2), tol=1e-10)
        place = solved.x
        assert np.hypot(*velocity(model, place)) < 1e-5
        assert np.hypot(*place) <= reach + SLACK
        step = 1e-4
        columns = [velocity(model, place + step * e) - velocity(model, place - step * e) for e in np.eye(2)]
        assert np.linalg.eigvals(np.column_stack(columns) / (2 * step)).real.max() < 0
        omega = EllipseMinimizer().minimize(model, loads_at(model, place[None])).twists[0, 2]
        assert abs(omega) <= float(found.drift) + 1e-5


@thorough  # the small one: test_every_array_has_its_equilibrium_in_the_disc_and_it_attracts
def test_the_bound_is_not_far_from_what_arrays_do() -> None:
    """To first order it is the sum of the sizes of all shifts: one corner of the box comes near it."""
    scene = load_scene("four-wheel", rule="ellipse")
    box = replace(small_box(scene).times(Fraction(1, 10)), position=scene.field(0), heading=Fraction(0))
    found = equilibrium_box(scene, box)
    assert found is not None
    rng, farthest = np.random.default_rng(4), 0.0
    for _ in range(60):
        model = drawn(scene, box, rng, corner=True)
        farthest = max(farthest, float(np.hypot(*root(lambda c, model=model: velocity(model, c), np.zeros(2)).x)))
    assert 0.4 * float(found.squared) ** 0.5 < farthest <= float(found.squared) ** 0.5 + SLACK


@pytest.mark.parametrize("radius", keep(1, ["1/10", None]))
def test_what_is_said(radius: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a small square without dividing quadrangles and rings, which is quick; and on the whole one."""
    if radius is not None:
        monkeypatch.setattr(SmoothDisc, "depth", 0)
        monkeypatch.setattr(SmoothDisc, "halvings", 0)
    scene = load_scene("four-wheel", rule="ellipse", radius=radius)
    found = decide_robust(replace(scene, tolerances=small_box(scene)))
    assert found is not None
    assert found.verdict is Certainty.CERTIFIED
    # beside the equilibrium, where bodies from how far end, and after how long
    assert found.start is not None
    assert found.within is not None
    assert found.radius is not None
    assert found.equilibrium is not None
    assert found.radius < found.start
    assert found.within > 0
    assert found.factor is not None
    assert found.factor >= 1
    assert found.binding in ("mu_roll", "mu_side", "position", "heading")


@pytest.mark.parametrize("name", keep(1, ["conveyor-3", "outward", "spiral-30"]))
def test_what_is_not_followed_is_undecided(name: str) -> None:
    scene = load_scene(name, rule="roller")
    found = decide_robust(replace(scene, tolerances=small_box(scene)))
    assert found is not None
    assert (found.verdict, found.factor) == (Certainty.UNDECIDED, Fraction(0))


def test_loads_that_are_not_known_are_not_followed() -> None:
    scene = load_scene("four-wheel", rule="ellipse")
    unknown = replace(scene, contact=replace(scene.contact, loads=UnknownLoads()), tolerances=small_box(scene))
    found = decide_robust(unknown)
    assert found is not None
    assert found.reason == "the loads are not known"


def test_a_body_keeps_its_wheels() -> None:
    """A carton whose nearest wheel is at its edge: the disc must stay within the margin."""
    scene = standing(load_scene("carton-on-6x6", rule="ellipse"))
    near = decide_robust(replace(scene, tolerances=small_box(scene)))
    assert near is not None
    assert near.verdict is Certainty.CERTIFIED
    assert near.radius is not None
    assert near.radius < Fraction(1, 5)
    assert near.factor is not None
    assert near.radius * near.factor < Fraction(1, 2)


def test_the_statement_about_a_body_that_turns_says_for_which_wheels() -> None:
    bare = load_scene("off-center", rule="ellipse")
    outlined = on(bare, polygon_of(bare, [(-9, -9), (9, -9), (9, 9), (-9, 9)]))
    kept = "while they are turned so little that the same wheels carry them"
    for scene, drift, said in ((bare, 1, False), (outlined, 1, True), (outlined, 0, False)):
        found = Robust(Certainty.CERTIFIED, equilibrium=Fraction(1, 10), drift=Fraction(drift))
        words = " ".join(fact.words for fact in robust_facts(scene, found))
        assert (kept in words) == said
