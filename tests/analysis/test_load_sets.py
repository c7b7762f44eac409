"""Sets of loads against a linear program, and against springs that are pressed one by one."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog

from nonsmooth.analysis.cells.load_sets import AdmissibleLoads, LoadSet, SpringLoads, load_set
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from nonsmooth.symbolic.mechanics.unknown_loads import LoadScatter, UnknownLoads
from tests.conftest import Arrays, WheelData
from tests.springs import pressed
from tests.thorough import few

Floats: TypeAlias = NDArray[np.float64]

ROUNDING = 1e-9


def random_array(arrays: Arrays, rng: np.random.Generator, wheels: int) -> Scene:
    """Wheels at random places of a lattice, some of them around the origin."""
    places = {(1, 1), (-2, 1), (0, -2)}
    while len(places) < wheels:
        x, y = (int(k) for k in rng.integers(-3, 4, 2))
        places.add((x, y))
    return arrays.scene([WheelData(place, (1, 0)) for place in sorted(places)], radius=Fraction(1, 16))


def with_loads(scene: Scene, height: Fraction | None = None, stiffness: Fraction = Fraction(0)) -> Scene:
    """The array with all admissible loads, or with scattered springs."""
    scatter = None if height is None else LoadScatter(scene.field(height), scene.field(stiffness))
    return replace(scene, contact=Contact("ellipse", UnknownLoads(scatter)))


def moments_of(scene: Scene) -> Floats:
    return np.array([[1.0, *map(float, wheel.position)] for wheel in scene.wheels])


def least_price(scene: Scene, prices: Floats) -> float:
    """By HiGHS, from the definition of admissible loads."""
    found = linprog(prices, A_eq=moments_of(scene).T, b_eq=[1, 0, 0], bounds=(0, None), method="highs")
    assert found.status == 0
    return float(found.fun)


def floats(loads: tuple[object, ...]) -> Floats:
    return np.array([float(load) for load in loads])  # type: ignore[arg-type]


@few(1)
@pytest.mark.parametrize("seed", range(12))
def test_vertices_are_admissible_and_reach_the_optima_of_linear_programs(arrays: Arrays, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = with_loads(random_array(arrays, rng, int(rng.integers(3, 9))))
    every = load_set(scene)
    assert every.bound is every.reached
    assert isinstance(every.bound, AdmissibleLoads)
    for vertex in (*every.bound.vertices, every.bound.middle):
        assert all(load >= 0 for load in vertex)
        assert sum(vertex) == 1
        for axis in (0, 1):
            assert not sum(n * w.position[axis] for n, w in zip(vertex, scene.wheels, strict=True))
    assert all(load > 0 for load in every.bound.middle)
    for _ in range(20):
        whole = rng.integers(-9, 10, len(scene.wheels))
        lowest = floats(every.bound.lowest([scene.field(int(k)) for k in whole]))
        assert lowest @ whole == pytest.approx(least_price(scene, whole.astype(float)), abs=ROUNDING)


@pytest.mark.parametrize(
    ("height", "stiffness"), [("1/10", "0"), ("0", "1/10"), ("1/5", "1/20"), ("1", "0"), ("4", "0")]
)
@pytest.mark.parametrize("seed", range(6))
def test_pressed_springs_stay_in_the_bound(arrays: Arrays, seed: int, height: str, stiffness: str) -> None:
    """Whatever the springs of a scatter do, lift-off included, their loads are in the set."""
    rng = np.random.default_rng(seed)
    scene = with_loads(random_array(arrays, rng, int(rng.integers(4, 8))), Fraction(height), Fraction(stiffness))
    found, moments, count = load_set(scene), moments_of(scene), len(scene.wheels)
    prices = [rng.integers(-9, 10, count) for _ in range(10)]
    lowest = [floats(found.bound.lowest([scene.field(int(k)) for k in price])) @ price for price in prices]
    for _ in range(60):
        corner = rng.random() < 0.5
        heights, changes = rng.choice([-1.0, 1.0], (2, count)) if corner else rng.uniform(-1, 1, (2, count))
        stiff = 1 + changes * float(Fraction(stiffness))
        loads = pressed(moments, heights * float(Fraction(height)) / count, stiff)
        assert (loads >= floats(found.bound.least) - ROUNDING).all()
        assert (loads <= floats(found.bound.largest) + ROUNDING).all()
        assert all(loads @ price >= bound - ROUNDING for price, bound in zip(prices, lowest, strict=True))


def is_reached_by_springs(scene: Scene, loads: Floats, height: float, stiffness: float) -> bool:
    """Whether heights and stiffnesses of the scatter give these positive loads, for some pose y of the body.

    ``m_i . y - h_i = N_i/(1 + t_i)`` lies between ``N_i/(1 + s)`` and ``N_i/(1 - s)``: linear in y.
    """
    moments, reach = moments_of(scene), height / len(loads)
    upper, lower = loads / (1 - stiffness) + reach + ROUNDING, loads / (1 + stiffness) - reach - ROUNDING
    rows, limits = np.vstack([moments, -moments]), np.concatenate([upper, -lower])
    found = linprog(np.zeros(3), A_ub=rows, b_ub=limits, bounds=(None, None), method="highs")
    return bool((loads > 0).all() and found.status == 0)


@pytest.mark.parametrize(("height", "stiffness"), [("1/10", "0"), ("0", "1/10"), ("1/5", "1/20"), ("3", "1/2")])
@pytest.mark.parametrize("seed", range(6))
def test_witnesses_are_loads_that_springs_reach(arrays: Arrays, seed: int, height: str, stiffness: str) -> None:
    rng = np.random.default_rng(seed)
    scene = with_loads(random_array(arrays, rng, int(rng.integers(4, 8))), Fraction(height), Fraction(stiffness))
    reached = load_set(scene).reached
    loads = [reached.middle]
    loads += [reached.lowest([scene.field(int(k)) for k in rng.integers(-9, 10, len(scene.wheels))]) for _ in range(8)]
    springs = isinstance(reached, SpringLoads) and bool(reached.generators)
    for load in loads if springs else ():
        assert is_reached_by_springs(scene, floats(load), float(Fraction(height)), float(Fraction(stiffness)))


def test_loads_after_lift_off_leave_the_cut_zonotope(arrays: Arrays) -> None:
    """The zonotope of linear loads, cut at N >= 0, is no bound there: all admissible loads are taken instead."""
    fifth = Fraction(1, 5)
    places = [(2 * fifth, 2 * fifth), (-8 * fifth, 2 * fifth), (-8 * fifth, -8 * fifth), (2 * fifth, -8 * fifth)]
    scene = with_loads(arrays.scene([WheelData(p, (1, 0)) for p in places], radius=fifth), Fraction(1, 10))
    found, moments = load_set(scene), moments_of(scene)
    assert found.remark
    assert isinstance(found.bound, AdmissibleLoads)
    projection = np.eye(4) - moments @ np.linalg.pinv(moments)
    reach = np.abs(projection).sum(axis=1) / 40
    linear = moments @ np.linalg.solve(moments.T @ moments, [1, 0, 0])
    rng = np.random.default_rng(0)
    for _ in range(20):
        loads = pressed(moments, rng.choice([-1.0, 1.0], 4) / 40, np.ones(4))
        assert (np.abs(loads - linear) > reach + ROUNDING).any()
        assert loads.min() > -ROUNDING


def test_small_scatter_lifts_no_wheel(arrays: Arrays) -> None:
    scene = with_loads(arrays.four_wheel(), Fraction(1, 10))
    found = load_set(scene)
    assert (found.bound, found.remark) == (found.reached, "")
    assert [str(n) for n in found.bound.least] == ["9/40"] * 4
    assert [str(n) for n in found.bound.largest] == ["11/40"] * 4


def test_sets_exist_inside_the_support_polygon_only(arrays: Arrays) -> None:
    with pytest.raises(LoadError, match="support polygon"):
        load_set(with_loads(arrays.four_wheel(radius=Fraction(11, 10))))
    line = arrays.scene([WheelData((k, 0), (1, 0)) for k in (-1, 0, 1)])
    with pytest.raises(LoadError, match="collinear"):
        load_set(with_loads(line))


def test_known_loads_are_no_set(arrays: Arrays) -> None:
    with pytest.raises(TypeError, match="unknown loads"):
        load_set(arrays.four_wheel())


def test_many_wheels_are_refused_in_one_line(arrays: Arrays) -> None:
    places = [(x, y) for x in range(-4, 4) for y in range(-4, 4)]
    scene = with_loads(arrays.scene([WheelData(place, (1, 0)) for place in places]))
    with pytest.raises(LoadError, match="at most 50 wheels"):
        load_set(scene)


def test_a_set_is_a_bound_and_what_is_reached(arrays: Arrays) -> None:
    """With stiffnesses the bound is wider than what is surely reached; at both, springs carry everywhere."""
    scene = with_loads(random_array(arrays, np.random.default_rng(3), 6), Fraction(1, 20), Fraction(1, 20))
    found: LoadSet = load_set(scene)
    assert (floats(found.bound.largest) >= floats(found.reached.largest)).all()
