"""Periodic orbits: multipliers, turns without number, and how sure their digits are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.cells.fan import Cone, Growth, full_turns
from nonsmooth.analysis.cells.polygon import HalfPlane, square
from nonsmooth.analysis.fields.constant_field import ConstantField, piecewise_constant
from nonsmooth.analysis.fields.system_field import constant_system, system_field
from nonsmooth.analysis.orbits import search
from nonsmooth.analysis.orbits.orbit import Orbit, OrbitError
from nonsmooth.analysis.orbits.search import find_orbit, shoot, single_turn
from nonsmooth.analysis.trajectories import piecewise_constant as paths
from nonsmooth.analysis.trajectories import trajectory
from nonsmooth.analysis.trajectories.closed_forms import Turns, signs_of
from nonsmooth.analysis.trajectories.piecewise_constant import MAX_LEGS
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.orbits import orbit_proof
from nonsmooth.reports.simulations.orbits import measured_text
from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.numbers.plane import around
from tests.oracles.piecewise_affine import DIGITS, Motion, arrival, matrix
from tests.thorough import few, keep, thorough

# ---- Periodic orbits and their Floquet multipliers, against closed forms, published digits and differences of paths.


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


# ---- Closed orbits: a trillion turns are as exact as one -----------------------------------------

START = (Fraction(3, 10), Fraction(1, 5), Fraction(1, 7))
PERIOD = 2  # the orbit is the square |x| + |y| = 1/2, at speed one in x and in y
RATES = (1, Fraction(1, 3), Fraction(-1, 2), 2)  # theta' on the four quadrants


def relay(tilt: Fraction = Fraction(0), *, exact: bool = True) -> ConstantField:
    """``x' = sgn y, y' = -sgn x`` with a heading; ``tilt`` slows x in the first quadrant."""
    quadrants = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    pieces = [
        ([HalfPlane((-a, 0), 0), HalfPlane((0, -b), 0)], (b - (tilt if a > 0 and b > 0 else 0), -a, rate))
        for (a, b), rate in zip(quadrants, RATES, strict=True)
    ]
    return piecewise_constant(square((Fraction(0), Fraction(0)), Fraction(2)), pieces, exact=exact)


@pytest.mark.parametrize(
    ("tilt", "growth"),
    [(Fraction(-1, 10), Growth.DIVERGES), (Fraction(0), Growth.TIE), (Fraction(1, 10), Growth.CONTRACTS)],
)
def test_paths_and_clauses_see_one_full_turn(tilt: Fraction, growth: Growth) -> None:
    """Around the corner of the four quadrants, clockwise: the gain is ``1 - tilt``, in both kinds of numbers."""
    zero, one = Fraction(0), Fraction(1)
    rays = [(one, zero), (zero, one), (-one, zero), (zero, -one)]
    fan = [
        Cone(*rays, (own[0].about((zero, zero)),)) for rays, own in zip(around(rays), relay(tilt).flows, strict=True)
    ]
    for field in (relay(tilt), relay(tilt, exact=False)):
        corner = field.cells.points.index((0, 0))
        turns = Turns(field, signs_of(field))
        found = turns.around(corner, -1)
        assert found is not None
        assert found.gain == (1 - tilt if field.exact else pytest.approx(float(1 - tilt), abs=1e-15))
        assert turns.around(corner, 1) is None
        assert turns.lead_outward(corner) == (growth is Growth.DIVERGES)
    assert [(turn.sense, turn.gain, turn.growth) for turn in full_turns(fan)] == [(-1, 1 - tilt, growth)]


@pytest.mark.parametrize("turns", [1, 3, 10**6, 10**12])
def test_many_turns_are_exact(turns: int) -> None:
    rest = Fraction(7, 11)
    short, long = simulate(relay(), START, rest), simulate(relay(), START, turns * PERIOD + rest)
    rotation = turns * sum(Fraction(rate) for rate in RATES) * Fraction(PERIOD, 4)
    x, y, theta = short.end.state
    assert long.end.state == (x, y, theta + rotation)
    assert long.end.reason is EndReason.TIME
    assert len(long.pieces) < 40


def test_states_within_the_turns_are_exact_too() -> None:
    path = simulate(relay(), START, 10**9)
    for k, part in ((1, Fraction(1, 3)), (77, Fraction(13, 7)), (10**8, Fraction(0)), (4 * 10**8, Fraction(5, 4))):
        x, y, theta = simulate(relay(), START, part).end.state if part else START
        assert path.at(k * PERIOD + part) == (x, y, theta + k * sum(Fraction(r) for r in RATES) * Fraction(PERIOD, 4))
    assert list(path.times) == sorted(path.times)
    assert "turns are taken at once" in "".join(event.note for event in path.events)


@pytest.mark.parametrize("legs", keep(1, [1_000, MAX_LEGS]))
def test_floats_take_turns_at_once_only_where_the_orbit_closes(legs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(paths, "MAX_LEGS", legs)
    start = (0.25, 0.25, 0.0)  # binary fractions: the orbit closes to the last bit
    path = simulate(relay(exact=False), start, 2e6 + 0.125)
    assert path.end.state[:2] == pytest.approx((0.375, 0.125), abs=1e-9)
    nearly = simulate(relay(Fraction(1, 10**13), exact=False), start, 2e9)
    assert nearly.end.reason is EndReason.EVENTS  # 4e8 turns would lose 1e-5 of the distance: not the same orbit
    assert not any("at once" in event.note for event in nearly.events)


@pytest.mark.parametrize(("name", "at_once"), [("relay-oscillator", True), ("relay-oscillator-damped", False)])
def test_numbers_of_a_field_are_compared_exactly(name: str, at_once: bool) -> None:
    """Turns that shrink are no closed orbit, however small: they end at their limit."""
    field = constant_system(load_system(name))
    assert field is not None
    path = simulate(field, (Fraction(1, 10**9), 0, 0), 1)
    assert any("turns are taken at once" in event.note for event in path.events) is at_once
    assert path.end.reason is (EndReason.TIME)
    x, y, _ = path.end.state
    assert abs(x) + abs(y) == (Fraction(1, 10**9) if at_once else 0)


# ---- What is said of periodic orbits in floats: multipliers told apart from one, digits that are right, orbits that
# repel.
#
# Oracles: closed forms, other integrators, and the definitions of attracting and repelling themselves.

PLANE = ["x", "y"]
TO_THE_CIRCLE = ["-y + x*sign(1 - x**2 - y**2)", "x + y*sign(1 - x**2 - y**2)"]
FROM_THE_CIRCLE = ["-y - x*sign(1 - x**2 - y**2)", "x - y*sign(1 - x**2 - y**2)"]


def starts(kept: int, *places: tuple[float, float]) -> list[Any]:
    """Starts of a search, of which `make test` takes so many."""
    return [pytest.param(place, marks=thorough if k >= kept else ()) for k, place in enumerate(places)]


def planar_orbit(rhs: list[str], start: tuple[float, float], until: float = 60.0) -> Orbit:
    return find_orbit(system_field(ns.System(PLANE, rhs).system, start), start, until)


def radial(rate: str) -> list[str]:
    """``r' = rate r, phi' = 1`` with s for ``r^2``."""
    square = rate.replace("s", "(x**2 + y**2)")
    return [f"-y + x*({square})", f"x + y*({square})"]


def test_an_orbit_that_slides_all_the_time_attracts_where_neighbours_come_onto_it() -> None:
    found = planar_orbit(TO_THE_CIRCLE, (0.5, 0.0), 20.0)
    assert found.multipliers.tolist() == [0]
    assert found.stability == "attracting"
    assert abs(found.period - 2 * math.pi) <= found.errors.period < 1e-10
    system = ns.System(PLANE, TO_THE_CIRCLE)
    for radius in (0.9, 1.1):  # r' = +- r: there at |log r|
        path = system.simulate((radius, 0.0), 0.2).trajectory
        assert math.hypot(*path.at(0.15)) == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("start", starts(2, (0.5, 0.0), (1.0, 0.0), (1.5, 0.0)))
def test_an_orbit_that_slides_where_both_sides_push_away_repels(start: tuple[float, float]) -> None:
    found = planar_orbit(FROM_THE_CIRCLE, start, 20.0)
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
    found = planar_orbit(["y", "x - x**3"], start)
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
    found = planar_orbit(radial("(1 - s)**2"), start, 40.0)
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
    found = planar_orbit(radial(f"{sense}/{10**digits}*(1 - s)"), (1.02, 0.0))
    exact = math.exp(-4 * math.pi * k)
    assert abs(found.multipliers[0].real - exact) <= found.errors.multipliers[0]
    possible = {"undecided", "attracting" if sense > 0 else "repelling"}
    assert found.stability in (possible if digits > 2 else possible - {"undecided"})


@thorough  # test_an_orbit_that_slides_where_both_sides_push_away_repels
@pytest.mark.parametrize("start", starts(1, (3.0, 0.0), (1.0, 0.0)))
def test_an_orbit_that_repels_is_found_from_both_sides(start: tuple[float, float]) -> None:
    """Van der Pol's, backwards in time: from inside paths end at rest, from outside they run away in finite time."""
    found = planar_orbit(["-y", "-(1 - x**2)*y + x"], start)
    assert abs(found.period - 6.66328685932313) <= found.errors.period < 1e-7
    assert found.stability == "repelling"
    rates = lambda t, z: [-z[1], z[0] - (1 - z[0] ** 2) * z[1], z[0] ** 2 - 1]  # noqa: E731  # Liouville, beside it
    turn = solve_ivp(rates, (0, -found.period), [*found.point, 0.0], rtol=1e-11, atol=1e-12)
    assert found.multipliers[0].real == pytest.approx(math.exp(-turn.y[2, -1]), rel=1e-6)


def test_a_path_that_runs_away_is_refused_in_words() -> None:
    with pytest.raises(OrbitError, match=r"cannot be followed until t = 60: it runs away") as refused:
        planar_orbit(["1 + x**2", "1"], (0.0, 0.0))
    assert "integrator" not in str(refused.value)


def test_a_path_that_grows_almost_beyond_floats_is_refused_without_a_warning() -> None:
    """Distances along its velocity are products of two large numbers: they overflow before states do."""
    with pytest.raises(OrbitError, match=r"^the path runs away$"):
        planar_orbit(["y", "-2*x + 7/4*y - 2*max(y - 1, 0) - 9/2*max(-y - 7/4, 0)"], (1.25, 2.0), 100.0)


def test_a_path_ends_after_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """An oscillation that would take days: what was reached is right, and the reason is said."""
    monkeypatch.setattr(trajectory, "MAX_WORK", 720)
    path = ns.System(PLANE, ["y", "-x + 0*sign(x)"]).simulate((1.0, 0.0), 1e9).trajectory
    assert path.end.reason is EndReason.STEPS
    assert 1 < path.end.t < 100
    assert path.end.state == pytest.approx((math.cos(path.end.t), -math.sin(path.end.t)), abs=1e-9)


@few(1)
@pytest.mark.parametrize("strength", ["7/4", "6"])
def test_relaxation_oscillations_that_drive_other_states_are_found(strength: str) -> None:
    """Derivatives of turns in three states take many evaluations.  The period is that of SciPy's own integration."""
    rhs = ["y", f"-x + ({strength} - x**2)*y", "-z + 3/4*sign(x)"]
    system = ns.System(["x", "y", "z"], rhs)
    found = system.orbit((2.6, 0.0, 0.5))
    mu = float(Fraction(strength))

    def upward(_: float, state: Sequence[float]) -> float:
        return float(state[0])

    upward.direction = 1  # type: ignore[attr-defined]
    path = solve_ivp(
        lambda _, s: [s[1], -s[0] + (mu - s[0] ** 2) * s[1]],
        (0, 60),
        [2.6, 0.0],
        method="DOP853",
        events=upward,
        rtol=1e-11,
        atol=1e-11,
    )
    assert found.period == pytest.approx(np.diff(path.t_events[0])[-1], rel=1e-7)
    assert found.stability == "attracting"


def test_a_search_ends_after_its_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "EVALUATIONS", 2_000)
    with pytest.raises(OrbitError, match="more than 2000 evaluations of the field"):
        planar_orbit(["y", "-x - y/10"], (1.0, 0.0), 1e9)
    monkeypatch.setattr(search, "EVALUATIONS", 240_000)
    monkeypatch.setattr(search, "SHOOTING", 2_000)
    with pytest.raises(OrbitError, match="no periodic orbit is found within 2000 evaluations of the field"):
        planar_orbit(["y", "-x + (1 - x**2)*y"], (2.0, 0.0), 30.0)


def test_a_proof_ends_after_its_work(monkeypatch: pytest.MonkeyPatch) -> None:
    found = planar_orbit(["y", "-x + y/10 - sign(y)/10"], (1.3, 0.0), 12.0)
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
