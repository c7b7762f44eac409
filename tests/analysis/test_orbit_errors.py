"""What is said of periodic orbits in floats: multipliers told apart from one, digits that are right, orbits that repel.

Oracles: closed forms, other integrators, and the definitions of attracting and repelling themselves.
"""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.orbits import search
from nonsmooth.analysis.orbits.orbit import Orbit, OrbitError
from nonsmooth.analysis.orbits.search import find_orbit
from nonsmooth.analysis.trajectories import smooth_path
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.proofs.orbits import orbit_proof
from nonsmooth.reports.simulations.orbits import measured_text
from tests.thorough import few, thorough

PLANE = ["x", "y"]
TO_THE_CIRCLE = ["-y + x*sign(1 - x**2 - y**2)", "x + y*sign(1 - x**2 - y**2)"]
FROM_THE_CIRCLE = ["-y - x*sign(1 - x**2 - y**2)", "x - y*sign(1 - x**2 - y**2)"]


def starts(kept: int, *places: tuple[float, float]) -> list[Any]:
    """Starts of a search, of which `make test` takes so many."""
    return [pytest.param(place, marks=thorough if k >= kept else ()) for k, place in enumerate(places)]


def orbit(rhs: list[str], start: tuple[float, float], until: float = 60.0) -> Orbit:
    return find_orbit(system_field(ns.System(PLANE, rhs).system, start), start, until)


def radial(rate: str) -> list[str]:
    """``r' = rate r, phi' = 1`` with s for ``r^2``."""
    square = rate.replace("s", "(x**2 + y**2)")
    return [f"-y + x*({square})", f"x + y*({square})"]


def test_an_orbit_that_slides_all_the_time_attracts_where_neighbours_come_onto_it() -> None:
    found = orbit(TO_THE_CIRCLE, (0.5, 0.0), 20.0)
    assert found.multipliers.tolist() == [0]
    assert found.stability == "attracting"
    assert abs(found.period - 2 * math.pi) <= found.errors.period < 1e-10
    system = ns.System(PLANE, TO_THE_CIRCLE)
    for radius in (0.9, 1.1):  # r' = +- r: there at |log r|
        path = system.simulate((radius, 0.0), 0.2).trajectory
        assert math.hypot(*path.at(0.15)) == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("start", starts(2, (0.5, 0.0), (1.0, 0.0), (1.5, 0.0)))
def test_an_orbit_that_slides_where_both_sides_push_away_repels(start: tuple[float, float]) -> None:
    found = orbit(FROM_THE_CIRCLE, start, 20.0)
    assert np.isinf(found.multipliers).all()
    assert found.stability == "repelling"
    assert found.path.unique is False
    assert abs(found.period - 2 * math.pi) <= found.errors.period < 1e-10
    for radius in (1 - 1e-6, 1 + 1e-6):
        path = ns.System(PLANE, FROM_THE_CIRCLE).simulate((radius, 0.0), 1.0).trajectory
        assert abs(math.hypot(*path.at(1.0)) - 1) > 1e-6 * math.e * 0.99


def duffing_period(x: float, y: float) -> float:
    """Of ``x'' = x - x^3`` through a point: ``x = a dn(a t/sqrt 2 | m)`` with ``m = 2 (a^2 - 1)/a^2``."""
    with mpmath.workdps(30):
        energy = mpmath.mpf(y) ** 2 / 2 - mpmath.mpf(x) ** 2 / 2 + mpmath.mpf(x) ** 4 / 4
        square = 1 + mpmath.sqrt(1 + 4 * energy)
        return float(2 * mpmath.sqrt(2) * mpmath.ellipk(2 * (square - 1) / square) / mpmath.sqrt(square))


@pytest.mark.parametrize("start", starts(1, (0.5, 0.0), *((0.01 + k * 1e-9, 0.0) for k in range(8)), (1.2, 0.1)))
def test_a_centre_is_undecided_and_its_period_has_the_digits_that_are_right(start: tuple[float, float]) -> None:
    """Also beside the saddle, where the end of a turn is ten thousand times as uncertain as a step."""
    said = ns.System(PLANE, ["y", "x - x**3"]).orbit(start)
    assert "closed orbits around a centre; nonsmooth check may prove" in said.reason
    assert said.words()[2][1].startswith("undecided: ")
    found = orbit(["y", "x - x**3"], start)
    assert found.stability == "undecided"
    assert found.point == pytest.approx(start, abs=1e-12)  # of the family, the orbit that was asked for
    exact = duffing_period(*found.point)
    assert abs(found.period - exact) <= found.errors.period
    text = measured_text(found.period, found.errors.period, 12)
    last = 10.0 ** -len(text.partition(".")[2])
    assert abs(float(text) - exact) <= last
    assert last < 1e-4


@thorough  # undecided: test_a_centre_is_undecided_and_its_period_has_the_digits_that_are_right
@pytest.mark.parametrize("start", starts(1, (0.7, 0.0), (1.1, 0.0)))
def test_an_orbit_that_attracts_from_one_side_only_is_undecided(start: tuple[float, float]) -> None:
    """By the definition: ``r' = r (1 - r^2)^2`` grows on either side of the circle."""
    found = orbit(radial("(1 - s)**2"), start, 40.0)
    assert found.stability == "undecided"
    assert abs(found.multipliers[0] - 1) <= found.errors.multipliers[0] < 0.1
    for radius in (0.95, 1.05):
        turn = solve_ivp(lambda t, r: r * (1 - r**2) ** 2, (0, 2 * math.pi), [radius], rtol=1e-10, atol=1e-12)
        assert turn.y[0, -1] > radius


@few(3)
@pytest.mark.parametrize("digits", [2, 5, 12])
@pytest.mark.parametrize("sense", [1, -1])
def test_multipliers_near_one_are_told_apart_as_far_as_they_are_known(digits: int, sense: int) -> None:
    """``r' = k r (1 - r^2)`` has the multiplier ``exp(-4 pi k)``."""
    k = sense / 10**digits
    found = orbit(radial(f"{sense}/{10**digits}*(1 - s)"), (1.02, 0.0))
    exact = math.exp(-4 * math.pi * k)
    assert abs(found.multipliers[0].real - exact) <= found.errors.multipliers[0]
    possible = {"undecided", "attracting" if sense > 0 else "repelling"}
    assert found.stability in (possible if digits > 2 else possible - {"undecided"})


@thorough  # test_an_orbit_that_slides_where_both_sides_push_away_repels
@pytest.mark.parametrize("start", starts(1, (3.0, 0.0), (1.0, 0.0)))
def test_an_orbit_that_repels_is_found_from_both_sides(start: tuple[float, float]) -> None:
    """Van der Pol's, backwards in time: from inside paths end at rest, from outside they run away in finite time."""
    found = orbit(["-y", "-(1 - x**2)*y + x"], start)
    assert abs(found.period - 6.66328685932313) <= found.errors.period < 1e-7
    assert found.stability == "repelling"
    rates = lambda t, z: [-z[1], z[0] - (1 - z[0] ** 2) * z[1], z[0] ** 2 - 1]  # noqa: E731  # Liouville, beside it
    turn = solve_ivp(rates, (0, -found.period), [*found.point, 0.0], rtol=1e-11, atol=1e-12)
    assert found.multipliers[0].real == pytest.approx(math.exp(-turn.y[2, -1]), rel=1e-6)


def test_a_path_that_runs_away_is_refused_in_words() -> None:
    with pytest.raises(OrbitError, match=r"cannot be followed until t = 60: it runs away") as refused:
        orbit(["1 + x**2", "1"], (0.0, 0.0))
    assert "integrator" not in str(refused.value)


def test_a_path_ends_after_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """An oscillation that would take days: what was reached is right, and the reason is said."""
    monkeypatch.setattr(smooth_path, "MAX_WORK", 720)
    path = ns.System(PLANE, ["y", "-x + 0*sign(x)"]).simulate((1.0, 0.0), 1e9).trajectory
    assert path.end.reason is EndReason.STEPS
    assert 1 < path.end.t < 100
    assert path.end.state == pytest.approx((math.cos(path.end.t), -math.sin(path.end.t)), abs=1e-9)


def test_a_search_ends_after_its_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "EVALUATIONS", 2_000)
    with pytest.raises(OrbitError, match="more than 2000 evaluations of the field"):
        orbit(["y", "-x - y/10"], (1.0, 0.0), 1e9)


def test_a_proof_ends_after_its_work(monkeypatch: pytest.MonkeyPatch) -> None:
    found = orbit(["y", "-x + y/10 - sign(y)/10"], (1.3, 0.0), 12.0)
    monkeypatch.setattr(orbit_proof, "PRODUCTS", 10)
    proof = orbit_proof.prove_orbit(ns.System(PLANE, ["y", "-x + y/10 - sign(y)/10"]).system, found)
    assert proof.attracts is None
    assert "within 10 products" in proof.reason


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [(17.281252089, 5.5e-7, "17.28125"), (0.99994365, 2.5e-5, "0.9999"), (3.2, 0.0, "3.2"), (0.5, math.inf, "0.5")],
)
def test_only_digits_that_are_right_are_written(value: float, error: float, text: str) -> None:
    assert measured_text(value, error, 12) == text
