"""Paths of systems with modes against closed forms and another integrator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.trajectories.result import EventKind, TrajectoryError
from tests.thorough import keep

EVENT_ERROR = 1e-9


def switches(result: ns.PathResult) -> list[float]:
    return [float(event.t) for event in result.trajectory.events if event.kind is EventKind.SWITCH]


def test_the_thermostat_has_closed_forms() -> None:
    """T' = (26 - T)/4 from 15 to 21, then (10 - T)/4 down to 19, and again."""
    result = ns.Modes.load("thermostat").simulate((15,), 8.0)
    first, cool, heat = 4 * math.log(11 / 5), 4 * math.log(11 / 9), 4 * math.log(7 / 5)
    assert switches(result) == pytest.approx(np.cumsum([first, cool, heat, cool, heat]).tolist(), abs=EVENT_ERROR)
    left = 8.0 - (first + 2 * (cool + heat))
    assert result.state[-1] == pytest.approx([10 + 11 * math.exp(-left / 4)], abs=EVENT_ERROR)
    assert [row["mode"] for row in result.to_dict()["modes"]] == ["heating", "idle"] * 3
    assert result.trajectory.unique


def test_a_dwell_time_is_kept() -> None:
    """An integrator between +-1 turns at 1 and -1; a dwell of three units lets it run past."""
    modes: list[dict[str, Any]] = [
        {"name": "up", "rhs": ["1"], "leave": {"down": "x - 1"}, "dwell": 3},
        {"name": "down", "rhs": ["-1"], "leave": {"up": "-1 - x"}},
    ]
    result = ns.Modes(["x"], modes).simulate((0,), 12.0)
    assert switches(result) == pytest.approx([3.0, 7.0, 10.0], abs=EVENT_ERROR)
    assert result.state[-1] == pytest.approx([0.0], abs=EVENT_ERROR)


def test_a_guard_that_is_positive_on_entry_is_left_at_once() -> None:
    modes: list[dict[str, Any]] = [
        {"name": "a", "rhs": ["1"], "leave": {"b": "x - 1"}},
        {"name": "b", "rhs": ["1"], "leave": {"c": "x"}},
        {"name": "c", "rhs": ["-1"]},
    ]
    result = ns.Modes(["x"], modes).simulate((0,), 2.0)
    assert switches(result) == pytest.approx([1.0, 1.0], abs=EVENT_ERROR)
    assert result.state[-1] == pytest.approx([0.0], abs=EVENT_ERROR)


def test_a_guard_that_is_zero_on_entry_counts_only_where_it_rises() -> None:
    """Both modes end on x = 0; each begins there and moves away, so that nothing switches at once."""
    modes: list[dict[str, Any]] = [
        {"name": "right", "rhs": ["y", "-1"], "leave": {"left": "-x"}},
        {"name": "left", "rhs": ["y", "1"], "leave": {"right": "x"}},
    ]
    result = ns.Modes(["x", "y"], modes).simulate((0.0, 1.0), 9.0)
    assert switches(result) == pytest.approx([2.0, 4.0, 6.0, 8.0], abs=EVENT_ERROR)


def test_modes_without_hysteresis_that_push_together_are_refused() -> None:
    modes: list[dict[str, Any]] = [
        {"name": "up", "rhs": ["1"], "leave": {"down": "x"}},
        {"name": "down", "rhs": ["-1"], "leave": {"up": "-x"}},
    ]
    with pytest.raises(TrajectoryError, match="without end"):
        ns.Modes(["x"], modes).simulate((-1,), 3.0)


def test_a_mode_may_slide() -> None:
    """x' = -sign(x), y' = 1 slides on x = 0 from t = 1/2 on; at y = 2 the other mode takes x away."""
    modes: list[dict[str, Any]] = [
        {"name": "hold", "rhs": ["-sign(x)", "1"], "leave": {"go": "y - 2"}},
        {"name": "go", "rhs": ["1", "0"]},
    ]
    result = ns.Modes(["x", "y"], modes).simulate((0.5, 0.0), 3.0)
    kinds = [str(event.kind) for event in result.trajectory.events]
    assert kinds == ["slide", "switch"]
    assert result.state[-1] == pytest.approx([1.0, 2.0], abs=EVENT_ERROR)


def reference(matrices: Sequence[np.ndarray], level: float, start: np.ndarray, until: float) -> list[float]:
    """Switches of a relay with hysteresis: the first state rises to a level or falls to its negative."""
    times, t, x, mode = [], 0.0, start, 0
    while t < until:
        sense = 1 if mode == 0 else -1

        def reached(_: float, z: np.ndarray, sense: int = sense) -> float:
            return float(sense * z[0] - level)

        reached.terminal, reached.direction = True, 1  # type: ignore[attr-defined]
        force = np.array([0.0, float(sense)])
        done = solve_ivp(
            lambda _, z, m=matrices[mode], f=force: m @ z + f,
            (t, until),
            x,
            events=reached,
            rtol=1e-12,
            atol=1e-13,
            method="RK45",
            max_step=0.05,
        )
        t, x = float(done.t[-1]), done.y[:, -1]
        if done.status != 1:
            break
        times.append(t)
        mode = 1 - mode
    return times


@pytest.mark.parametrize("seed", keep(5, range(30)))
def test_random_relays_with_hysteresis(seed: int) -> None:
    rng = np.random.default_rng(seed)
    numbers = [[int(v) for v in rng.integers(1, 9, 2)] for _ in range(2)]
    matrices = [np.array([[0.0, 1.0], [-a / 4, -b / 10]]) for a, b in numbers]
    level, start = 0.1, np.array([0.0, float(rng.integers(-5, 6)) / 10])
    rhs = [["y", f"-{a}/4*x - {b}/10*y {sign} 1"] for (a, b), sign in zip(numbers, "+-", strict=True)]
    modes: list[dict[str, Any]] = [
        {"name": "push", "rhs": rhs[0], "leave": {"pull": "x - 1/10"}},
        {"name": "pull", "rhs": rhs[1], "leave": {"push": "-x - 1/10"}},
    ]
    result = ns.Modes(["x", "y"], modes).simulate(start.tolist(), 6.0)
    assert switches(result) == pytest.approx(reference(matrices, level, start, 6.0), abs=1e-7)
