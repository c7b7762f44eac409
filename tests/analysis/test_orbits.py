"""Closed orbits: a trillion turns are as exact as one."""

from __future__ import annotations

from fractions import Fraction

import pytest

from nonsmooth.analysis.cells.fan import Cone
from nonsmooth.analysis.cells.full_turns import Growth, full_turns
from nonsmooth.analysis.cells.polygon import HalfPlane, square
from nonsmooth.analysis.fields.constant_field import ConstantField, piecewise_constant
from nonsmooth.analysis.fields.system_field import constant_system
from nonsmooth.analysis.trajectories import piecewise_constant as paths
from nonsmooth.analysis.trajectories.piecewise_constant import MAX_LEGS
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.slides import signs_of
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.analysis.trajectories.turns import Turns
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.numbers.plane import around
from tests.thorough import keep

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
    field = constant_system(load_system(name), exact=True)
    assert field is not None
    path = simulate(field, (Fraction(1, 10**9), 0, 0), 1)
    assert any("turns are taken at once" in event.note for event in path.events) is at_once
    assert path.end.reason is (EndReason.TIME)
    x, y, _ = path.end.state
    assert abs(x) + abs(y) == (Fraction(1, 10**9) if at_once else 0)
