"""Periodic orbits and their Floquet multipliers, against closed forms, published digits and differences of paths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.orbits.orbit import Orbit, OrbitError
from nonsmooth.analysis.orbits.search import find_orbit, shoot, single_turn
from nonsmooth.symbolic.files.system_file import load_system
from tests.oracles.piecewise_affine import DIGITS, Motion, arrival, matrix
from tests.thorough import few, keep


def orbit(states: Sequence[str], rhs: Sequence[str], start: Sequence[float], until: float = 100.0) -> Orbit:
    system = ns.System(states, rhs).system
    return find_orbit(system_field(system, start), start, until)


@cache
def van_der_pol() -> Orbit:
    """With mu = 1."""
    return orbit(["x", "y"], ["y", "(1 - x**2)*y - x"], (0.5, 0.0), 60.0)


def test_van_der_pol_has_its_published_period() -> None:
    """mu = 1: T = 6.6632868593231301896996820305 (many sources; Viswanath, SIAM J. Sci. Comput. 23, 2001)."""
    found = van_der_pol()
    assert found.period == pytest.approx(6.66328685932313, abs=1e-11)
    # Liouville: the multiplier is exp of the integral of the divergence 1 - x^2, by another integrator
    start = [*found.point, 0.0]
    rates = lambda t, z: [z[1], (1 - z[0] ** 2) * z[1] - z[0], 1 - z[0] ** 2]  # noqa: E731
    along = solve_ivp(rates, (0, found.period), start, rtol=1e-11, atol=1e-12)
    assert found.multipliers[0].real == pytest.approx(math.exp(along.y[2, -1]), rel=1e-7)
    assert found.stability == "attracting"


@pytest.mark.parametrize("damping", [0.1, 0.2])
def test_dry_friction_against_anti_damping_repels_beyond_a_closed_form(damping: float) -> None:
    """x'' = -x + d x' - d sgn(x'): half turns are linear, so the amplitude and the multiplier are closed forms.

    From (a, 0) a half turn with y < 0 ends at ``-(a - d) g - d``, ``g = exp(pi d/(2 w))``, ``w^2 = 1 - d^2/4``: the
    centre of that half plane is d.
    """
    found = orbit(["x", "y"], ["y", f"-x + {damping}*y - {damping}*sign(y)"], (2.5, 0.0), 12.0)
    w = math.sqrt(1 - damping**2 / 4)
    g = math.exp(math.pi * damping / (2 * w))
    amplitude = damping * (g + 1) / (g - 1)
    assert max(x for x, _ in found.path.states) == pytest.approx(amplitude, abs=1e-3)
    crossing = next(leg.last for leg in found.legs if leg.met)
    assert abs(crossing[0]) == pytest.approx(amplitude, abs=1e-11)
    assert found.period == pytest.approx(2 * math.pi / w, abs=1e-10)
    assert found.multipliers[0].real == pytest.approx(g * g, rel=1e-9)
    assert found.stability == "repelling"


def test_relay_feedback_of_third_order_has_astroms_period_and_multipliers() -> None:
    """x' = A x - b sgn(c x): a symmetric orbit of half period h has ``x(0) = (1 + E)^-1 int_0^h exp(A s) b ds`` with
    E = exp(A h) and c x(0) = 0; its half map has the derivative ``(1 - v c/(c v)) E``, v the velocity on arrival
    (Astrom 1995, "Oscillations in systems with relay feedback").
    """
    found = orbit(["x", "y", "z"], ["-x - sign(z)", "x - y", "y - z"], (0.5, 0.1, 0.2))
    a = np.array([[-1.0, 0, 0], [1, -1, 0], [0, 1, -1]])
    with mpmath.workdps(DIGITS):
        plant, push = matrix(a.tolist()), mpmath.matrix([1, 0, 0])

        def begin(h: Any) -> Any:
            grown = mpmath.expm(plant * h)
            integral = mpmath.inverse(plant) * (grown - mpmath.eye(3)) * push
            return mpmath.inverse(mpmath.eye(3) + grown) * integral

        half = mpmath.findroot(lambda h: begin(h)[2], mpmath.mpf(found.period) / 2)
        grown = mpmath.expm(plant * half)
        end = -begin(half)
        velocity = plant * end - push
        derivative = grown - velocity * (mpmath.matrix([[0, 0, 1]]) * grown) / velocity[2]
        sizes = sorted((abs(m) for m in mpmath.eig(derivative)[0]), key=float, reverse=True)
    assert found.period == pytest.approx(float(2 * half), abs=1e-11)
    assert np.abs(found.multipliers) == pytest.approx([float(m) ** 2 for m in sizes[:2]], abs=1e-9)


def test_stick_slip_on_a_belt_is_a_closed_form() -> None:
    """The built-in scene, with x from the spring's own length, 5/6 from the scene's: the slip from (1, 1/2) is a linear
    focus, and sticking lasts until x = 1 at speed 1/2.
    """
    found = find_orbit(system_field(load_system("stick-slip"), (2.0, 0.0)), (2.0, 0.0), 100.0)
    with mpmath.workdps(DIGITS):
        third = mpmath.mpf(1) / 3
        # v' = -x + 1 - (1/2 - v)/3
        slip = Motion([[0, 1], [-1, third]], [0, 1 - third / 2])
        time, back = arrival(slip, mpmath.matrix([1, mpmath.mpf(1) / 2]), (0, 1), mpmath.mpf(1) / 2, 5)
        period = time + (1 - back[0]) * 2
    assert found.period == pytest.approx(float(period), abs=1e-10)
    assert abs(found.multipliers[0]) < 1e-11
    assert [bool(leg.motion.face.keep) for leg in found.legs] == [False, True, False]


@pytest.mark.parametrize("turns", [2, 3])
def test_an_orbit_gone_through_several_times_has_the_period_of_one_turn(turns: int) -> None:
    """A path that ends exactly on the orbit may return closer after two turns, by rounding alone."""
    found = van_der_pol()
    again = shoot(found.field, found.point, turns * found.period)
    assert again.period == pytest.approx(turns * found.period, rel=1e-9)
    assert single_turn(again).period == pytest.approx(found.period, rel=1e-9)
    assert single_turn(found) is found


def returned(system: ns.System, x: np.ndarray, along: np.ndarray, point: np.ndarray, period: float) -> np.ndarray:
    """Where a path comes back to the plane through a point, by hysteresis-free events of the simulator alone."""
    path = system.simulate(x.tolist(), 1.2 * period).trajectory
    low, high = 0.8 * period, 1.2 * period
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if along @ (np.array(path.at(middle)) - point) < 0 else (low, middle)
    return np.array(path.at(low))


@few(1)
@pytest.mark.parametrize(
    ("states", "rhs", "start"),
    [
        (["x", "y", "z"], ["y", "z", "-2*y - 2*z - sign(x)"], (0.5, 0.0, 0.0)),
        (["x", "y"], ["y + x/10 - x*Abs(x)/5", "-x + sign(x)/5"], (1.0, 0.0)),
        (["x", "v", "z"], ["v", "-x - sign(v - 1/2)*(1 - Abs(v - 1/2)/3) + z/5", "x - z"], (1.5, 0.0, 0.0)),
    ],
    ids=["relay of third order", "jump across a line", "stick-slip with a lag"],
)
def test_multipliers_are_slopes_of_the_return_map(states: list[str], rhs: list[str], start: tuple[float, ...]) -> None:
    """By central differences of paths from starts beside the orbit, across the flow."""
    system, found = ns.System(states, rhs), orbit(states, rhs, start)
    along = found.legs[0].motion(0.0, found.point)
    basis = np.linalg.qr(np.column_stack([along, np.eye(len(start))]))[0][:, 1:]
    step = 1e-5
    columns = []
    for direction in basis.T:
        ends = [returned(system, found.point + s * step * direction, along, found.point, found.period) for s in (1, -1)]
        columns.append(basis.T @ (ends[0] - ends[1]) / (2 * step))
    slopes = np.linalg.eigvals(np.column_stack(columns))
    assert sorted(np.abs(slopes)) == pytest.approx(sorted(np.abs(found.multipliers)), abs=2e-5)


def test_a_closed_square_is_not_told_apart_from_one_that_attracts_or_repels() -> None:
    found = orbit(["x", "y"], ["sign(y)", "-sign(x)"], (0.5, 0.3), 20.0)
    assert found.period == pytest.approx(4 * 0.8, abs=1e-12)
    assert found.stability == "undecided"


def test_where_there_is_no_orbit_it_says_why() -> None:
    with pytest.raises(OrbitError, match="comes to rest"):
        orbit(["x", "y"], ["sign(y)", "-sign(x) - sign(y)/2"], (0.2, 0.3))
    with pytest.raises(OrbitError, match="no return"):
        orbit(["x", "y"], ["1", "sign(y)"], (0.2, 0.3))
    growing = r"^Newton's method comes to an equilibrium.*turns of the path still grow"
    with pytest.raises(OrbitError, match=growing):
        orbit(["x", "y"], ["y", "-x + y/50 - sign(y - 1)/10 - 1/10"], (0.1, 0.0), 40.0)


@pytest.mark.parametrize("start", keep(1, [[0.5, 0.2], [1.0, 0.3]]))
def test_newtons_method_that_goes_on_to_ever_longer_turns_finds_no_return(start: list[float]) -> None:
    with pytest.raises(OrbitError, match="no return"):
        orbit(["x", "y"], ["y + 3/20*x - sign(x)/10", "-3/2*x - 3/20*y - y*Abs(x)*3/40"], start, 60.0)
