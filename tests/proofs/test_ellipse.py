from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import arb
from scipy.optimize import minimize

from nonsmooth.analysis.cells.loads import LoadError, LoadRegion, load_regions, value_at
from nonsmooth.proofs.boxes.linearization import _root_of_positive
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation, common_twist, ellipse_point
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.built_in import ruled
from tests.conftest import Arrays
from tests.four_wheel import CORNERS
from tests.oracles.clause_evidence import evidence_holds
from tests.proofs.forces_oracle import solves, verifies
from tests.thorough import few, thorough

# Of 30 random arrays those that do not tip and whose minimizer is found exactly; the latter fails for two.
DECIDED = [0, 1, 2, 3, 5, 6, 7, 8, 11, 12, 13, 14, 17, 18, 19, 21, 24, 25, 26, 27, 28, 29]
OPEN = [9, 15]


def point_of(scene: Scene, rule: str = "ellipse") -> EllipsePoint:
    scene = ruled(scene, rule)
    point = ellipse_point(scene, load_regions(scene))
    assert evidence_holds(point)
    assert verifies(point)
    return point


def numerical_twist(scene: Scene, region: LoadRegion, c: tuple[float, float]) -> np.ndarray:
    """Minimizer of the ellipse functional by smoothing and a general-purpose solver."""
    field = scene.field
    where = (field.rational(Fraction(c[0])), field.rational(Fraction(c[1])))
    along, across, weights = [], [], []
    for wheel, form in zip(scene.wheels, region.forces, strict=True):
        d, p = (np.array([float(x) for x in v]) for v in (wheel.unit_direction, wheel.position))
        n, arm = np.array([-d[1], d[0]]), np.array([-p[1], p[0]])
        roll, side = float(wheel.friction.roll), float(wheel.friction.side)
        along.append(roll * np.array([*d, d @ arm, -float(wheel.speed)]))
        across.append(side * np.array([*n, n @ arm, 0.0]))
        weights.append(float(value_at(form, where)))
    first, second, loads = np.array(along), np.array(across), np.array(weights)

    def total(xi: np.ndarray) -> float:
        y = np.append(xi, 1.0)
        return float(loads @ np.sqrt((first @ y) ** 2 + (second @ y) ** 2 + 1e-18))

    result = minimize(
        total, np.zeros(3), method="Nelder-Mead", options={"xatol": 1e-11, "fatol": 1e-15, "maxiter": 20000}
    )
    polished = minimize(
        total, result.x, method="Nelder-Mead", options={"xatol": 1e-12, "fatol": 1e-16, "maxiter": 20000}
    )
    return np.asarray(polished.x)


@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "ring-3", "rectangle", "elliptic", "spiral-30", "outward"])
def test_the_exact_minimizer_and_its_linearization_against_a_solver(name: str) -> None:
    scene = load_scene(name, rule="ellipse").recentred()
    point = point_of(scene)
    assert point.situation is Situation.SMOOTH
    assert point.twist is not None
    assert np.abs(numerical_twist(scene, point.region, (0.0, 0.0)) - [float(x) for x in point.twist]).max() < 1e-6
    assert point.linearization is not None
    small = 2e-3
    for direction in ((small, 0.0), (0.0, small)):
        change = numerical_twist(scene, point.region, direction) - [float(x) for x in point.twist]
        column = point.linearization.columns[0 if direction[0] else 1]
        predicted = small * np.array([float(x) for x in column])
        # the second-order term is of relative size |c| / mu_S, the solver's error about 1e-6
        assert np.abs(change - predicted).max() < 0.05 * np.abs(predicted).max() + 1e-5


def test_spiral_rims_spin_the_body_and_pull_it_home() -> None:
    point = point_of(load_scene("spiral-30", rule="ellipse").recentred())
    assert point.twist is not None
    field = point.scene.field
    assert point.twist.omega == -4 * field.sqrt(2) / 7
    assert point.translation is Translation.ASYMPTOTICALLY_STABLE


def test_a_linearization_of_another_array_is_refused() -> None:
    """It verifies by itself, and would turn the verdict."""
    outward = point_of(load_scene("outward", rule="ellipse").recentred())
    inward = point_of(
        replace(outward.scene, wheels=tuple(replace(w, given_speed=-w.speed) for w in outward.scene.wheels))
    )
    assert inward.linearization is not None
    assert solves(inward.linearization)
    forged = replace(outward, linearization=inward.linearization)
    assert forged.translation is not outward.translation
    assert not evidence_holds(forged)


def test_outward_rims_are_unstable() -> None:
    point = point_of(load_scene("outward", rule="ellipse").recentred())
    assert point.translation is Translation.UNSTABLE
    assert point.linearization is not None
    assert point.linearization.spectral_abscissa == 4 * point.scene.field.sqrt(2)


def test_tangential_rims_carry_the_body() -> None:
    scene = load_scene("conveyor-3", rule="ellipse").recentred()
    point = point_of(scene)
    assert point.situation is Situation.CARRIED
    assert point.twist is not None
    assert [str(x) for x in point.twist] == ["0", "0", "-1"]
    assert (point.equilibrium, point.translation) == (Equilibrium.HOLDS, Translation.STABLE)


def test_a_common_translation_is_no_equilibrium(arrays: Arrays) -> None:
    """Four parallel rims of equal speed: the body moves with them everywhere."""
    scene = arrays.scene([w._replace(direction=(1, 0)) for w in arrays.inward(CORNERS)])
    assert [str(x) for x in common_twist(ruled(scene, "ellipse"), load_regions(scene)[0]) or ()] == ["1", "0", "0"]
    point = point_of(scene)
    assert (point.situation, point.equilibrium) == (Situation.CARRIED, Equilibrium.FAILS)


@thorough  # the small one: test_random_arrays_agree_with_a_solver
def test_an_off_centre_array_is_driven_away() -> None:
    point = point_of(load_scene("off-center", rule="ellipse").recentred())
    assert (point.situation, point.equilibrium) == (Situation.MOVED, Equilibrium.FAILS)
    moved = numerical_twist(point.scene, point.region, (0.0, 0.0))
    assert np.hypot(moved[0], moved[1]) > 0.01


def random_scene(arrays: Arrays, seed: int) -> Scene:
    scene = arrays.cocircular(seed) if seed % 2 else arrays.random(seed, 5)
    return replace(scene, check=replace(scene.check, radius=scene.field(1) / 64)).recentred()


@pytest.mark.parametrize("seed", DECIDED)
def test_random_arrays_agree_with_a_solver(arrays: Arrays, seed: int) -> None:
    """A point said to be driven away moves; a point said to be an equilibrium does not."""
    point = point_of(random_scene(arrays, seed))
    assert point.situation is not Situation.OPEN
    speed = np.hypot(*numerical_twist(point.scene, point.region, (0.0, 0.0))[:2])
    assert (speed < 1e-5) == (point.equilibrium is Equilibrium.HOLDS)


def test_no_other_random_array_is_decided(arrays: Arrays) -> None:
    for seed in OPEN:
        assert point_of(random_scene(arrays, seed)).situation is Situation.OPEN
    for seed in set(range(30)) - {*DECIDED, *OPEN}:
        with pytest.raises(LoadError, match=r"the body tips|inside the support polygon|on one line"):
            load_regions(random_scene(arrays, seed))


def test_wheels_that_stick_hold_the_body(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    zero = scene.field.zero
    wheels = tuple(replace(w, given_speed=zero) if w.index % 2 == 0 else w for w in scene.wheels)
    point = point_of(replace(scene, wheels=wheels))
    assert (point.situation, point.translation) == (Situation.STICKING, Translation.STABLE)


def test_a_double_eigenvalue_among_rounded_numbers_has_a_finite_ball() -> None:
    """A regular ring whose angles are rounded: ``trace^2 = 4 det``, and a ball of what is left of it holds zero."""
    for ball in (arb(0, 2.37e-12), arb(1e-13, 1e-12), arb(4), arb(2, 1e-9)):
        root = _root_of_positive(ball)
        assert root.is_finite()
        for share in (0.0, 0.5, 1.0):
            place = float(ball.mid()) + share * float(ball.rad())
            assert root.contains(arb(place).sqrt())
