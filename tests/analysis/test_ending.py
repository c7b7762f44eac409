"""How paths end: against paths whose end is known without following them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nonsmooth.analysis.trajectories.ending import CREEP, REST, EndMotion, ending
from nonsmooth.analysis.trajectories.result import End, EndReason, Piece, State, Trajectory

Pose = tuple[float, float, float]


def path_of(state_at: object, until: float, reason: EndReason = EndReason.TIME) -> Trajectory:
    """A path in one piece, given as a function of time."""

    def state(time: float) -> State:
        return tuple(state_at(time))  # type: ignore[operator]

    times = tuple(np.linspace(0.0, until, 11).tolist())
    piece = Piece(0.0, until, "", (), state, times)
    end = End(until, state(until), reason)
    return Trajectory("exact", "events", times, tuple(map(state, times)), (), end, True, (piece,))


def test_an_arrival_in_finite_time_is_met_to_rounding() -> None:
    arrives = 0.73105857863
    found = ending(path_of(lambda t: (max(arrives - t, 0.0), 0.0, 0.1), 2.0), 1.0, 1.0)
    assert found.motion is EndMotion.AT_REST
    assert found.since == pytest.approx(arrives, abs=1e-7)
    assert (found.speed, found.turning) == (0.0, 0.0)


@pytest.mark.parametrize("rate", [1.0, 3.0])
def test_a_point_that_is_approached_rests_when_its_speed_is_small(rate: float) -> None:
    """``x = exp(-rate t)`` with the unit of speed ``rate``, that at the start: ``exp(-rate t) = REST``."""
    until = 30.0
    found = ending(path_of(lambda t: (math.exp(-rate * t), 0.0, 0.0), until), 1.0, 1.0)
    expected = math.log(1 / REST) / rate
    assert found.motion is EndMotion.AT_REST
    assert found.since == pytest.approx(expected, abs=until / 500)


def test_slow_and_fast_ends_are_told_apart() -> None:
    for speed, motion in ((REST / 2, EndMotion.AT_REST), (2 * REST, EndMotion.CREEPS), (2 * CREEP, EndMotion.MOVING)):
        found = ending(path_of(lambda t, v=speed: (v * t, 0.0, 0.0), 5.0), 1.0, 1.0)
        assert found.motion is motion
        assert found.speed == pytest.approx(speed)


def test_rounding_of_a_body_that_stands_is_rest() -> None:
    found = ending(path_of(lambda t: (0.1 + 1e-15 * math.sin(9 * t), 0.0), 2.0))
    assert (found.motion, found.since) == (EndMotion.AT_REST, 0.0)


def test_turning_in_place_is_no_rest() -> None:
    found = ending(path_of(lambda t: (0.0, 0.0, -0.5 * t), 5.0), 0.1, 1.0)
    assert found.motion is EndMotion.MOVING
    assert found.speed == 0.0
    assert found.turning == pytest.approx(-0.5)


def test_a_body_that_passes_its_end_is_not_at_rest_then() -> None:
    """It comes through the last state at full speed before; rest begins where it stays."""

    def swings(t: float) -> Pose:
        return (math.sin(2 * math.pi * min(t, 1.0)), 0.0, 0.0)

    found = ending(path_of(swings, 3.0), 1.0, 1.0)
    assert found.since == pytest.approx(1.0, abs=1e-4)


def test_states_of_plain_systems_count_alike() -> None:
    found = ending(path_of(lambda t: (3 * t, 4 * t), 1.0))
    assert (found.motion, found.turning) == (EndMotion.MOVING, None)
    assert found.speed == pytest.approx(5.0)
    still = ending(path_of(lambda t: (1.0, 2.0), 1.0))
    assert (still.motion, still.since) == (EndMotion.AT_REST, 0.0)


def test_samples_without_pieces_are_read_between() -> None:
    path = path_of(lambda t: (max(1 - t, 0.0), 0.0, 0.0), 2.0)
    sampled = Trajectory("exact", "hysteresis", path.times, path.states, (), path.end, None)
    assert ending(sampled, 1.0, 1.0).since == pytest.approx(1.0, abs=1e-3)
