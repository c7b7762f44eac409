"""Events of sliding of codimension two against references in closed form or in 40 digits."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog

from nonsmooth.analysis.fields.convex_weights import basic_weights, central_weights
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.follow import find_root
from nonsmooth.analysis.trajectories.result import EventKind, Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.system_file import load_system
from tests.analysis.stick_slip import random_stick_slip, reference_events
from tests.thorough import few, keep

EVENT_ERROR = 1e-9
UNTIL = 2.5, 5.0


def follow(tmp_path: Path, states: str, rhs: list[str], start: list[float], until: float) -> Trajectory:
    file = tmp_path / "my.toml"
    file.write_text(f"[system]\nstates = {list(states)}\nrhs = {rhs}\n", encoding="utf-8")
    return simulate(system_field(load_system(file), start), start, until)


def event_times(path: Trajectory) -> list[float]:
    return [float(event.t) for event in path.events if event.t > 0 and event.kind is not EventKind.NONUNIQUE]


def test_leaving_a_line_of_two_surfaces(tmp_path: Path) -> None:
    """y' = -sign(y) + z with z = t: slides on x = y = 0 until z = 1 exactly, then y = (t - 1)^2/2."""
    path = follow(tmp_path, "xyz", ["-2*sign(x)", "-sign(y) + z", "1"], [0.1, 0.1, 0.0], 3.0)
    assert event_times(path) == pytest.approx([0.05, 1 - math.sqrt(0.8), 1.0], abs=1e-11)
    assert path.end.state == pytest.approx((0.0, 2.0, 3.0), abs=1e-11)
    assert path.unique


@pytest.mark.parametrize("rate", [1.0, 1e-2, 1e-4])
def test_slow_exits(tmp_path: Path, rate: float) -> None:
    """The same with z' = rate: from z = 1 - rate it slides for one unit of time."""
    rhs = ["-2*sign(x)", "-sign(y) + z", f"{rate:.4f}"]
    path = follow(tmp_path, "xyz", rhs, [0.0, 0.0, 1.0 - rate], 2.0)
    assert event_times(path) == pytest.approx([1.0], abs=EVENT_ERROR)


def test_an_exit_and_a_return_between_two_steps(tmp_path: Path) -> None:
    """z is a polynomial of the time, so that one step may cover it all: z - 1 = -(t - 1)(t - 2)(t - 3)(t - 4)/20.

    y leaves at t = 1 with y' = z - 1, and is back where the integral of that polynomial from 1 on is zero.
    """
    parts = ["(t - 2)*(t - 3)*(t - 4)", "(t - 1)*(t - 3)*(t - 4)", "(t - 1)*(t - 2)*(t - 4)", "(t - 1)*(t - 2)*(t - 3)"]
    rhs = ["-2*sign(x)", "-sign(y) + z", f"-({' + '.join(parts)})/20", "1"]
    path = follow(tmp_path, "xyzt", rhs, [0.0, 0.0, 1 - 24 / 20, 0.0], 5.0)
    gone = np.polynomial.Polynomial.fromroots([1, 2, 3, 4]).integ(lbnd=1)
    roots = np.asarray(gone.roots(), dtype=complex)
    back = min(float(r.real) for r in roots if abs(r.imag) < 1e-9 and r.real > 1 + 1e-3)
    assert event_times(path) == pytest.approx([1.0, back], abs=EVENT_ERROR)


@few(1)
@pytest.mark.parametrize("until", keep(1, UNTIL))
@pytest.mark.parametrize("seed", range(40))
def test_two_masses_on_a_belt(tmp_path: Path, seed: int, until: float) -> None:
    system, start = random_stick_slip(seed)
    times, end = reference_events(system, start, until)
    path = follow(tmp_path, "xvyw", system.formulas(), [float(v) for v in start], until)
    assert event_times(path) == pytest.approx([float(t) for t in times], abs=EVENT_ERROR)
    assert path.end.state == pytest.approx([float(v) for v in end], abs=EVENT_ERROR)
    assert path.unique


@few(1)
@pytest.mark.parametrize("until", keep(1, UNTIL))
@pytest.mark.parametrize("seed", range(20))
def test_three_masses_on_a_belt(tmp_path: Path, seed: int, until: float) -> None:
    """Sliding of codimension three is left on time too."""
    system, start = random_stick_slip(seed, masses=3)
    times, end = reference_events(system, start, until)
    path = follow(tmp_path, "xvywzu", system.formulas(), [float(v) for v in start], until)
    assert event_times(path) == pytest.approx([float(t) for t in times], abs=EVENT_ERROR)
    assert path.end.state == pytest.approx([float(v) for v in end], abs=EVENT_ERROR)
    assert path.unique


@few(1)
@pytest.mark.parametrize("seed", range(20))
def test_central_weights_against_a_linear_program(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(20):
        rank = int(rng.integers(1, 4))
        count = int(rng.integers(rank + 1, 9))
        vectors = rng.normal(size=(count, rank))
        if rank > 1 and rng.random() < 0.3:
            vectors[:, -1] = vectors[:, 0]
        equations = np.vstack([np.c_[vectors.T, np.zeros(rank)], [*np.ones(count), 0.0]])
        least = linprog(
            [*np.zeros(count), -1.0],
            A_ub=np.c_[-np.eye(count), np.ones(count)],
            b_ub=np.zeros(count),
            A_eq=equations,
            b_eq=[*np.zeros(rank), 1.0],
            bounds=[(None, None)] * (count + 1),
        )
        weights = central_weights(vectors)
        assert (weights is None) == (least.status != 0)
        if weights is not None:
            assert weights.sum() == pytest.approx(1.0)
            assert weights @ vectors == pytest.approx(np.zeros(rank), abs=1e-9)
            assert weights.min() == pytest.approx(-least.fun, rel=1e-7, abs=1e-9)
            assert (weights.min() >= 0) == bool(len(basic_weights(vectors)))


def test_a_flat_secant_is_not_a_root() -> None:
    """A guard that only says yes and no: bisection goes on where the slope is zero."""
    assert find_root(lambda t: 1.0 if t < 0.3 else -1.0, (0.0, 1.0), (1.0, -1.0)) == pytest.approx(0.3, abs=1e-14)
