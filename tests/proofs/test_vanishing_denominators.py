"""Denominators that are zero at the checked point alone: verdicts, what is refused, and paths in floats beside ours."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs.kernel.subject import NoCertificateError
from tests.plain import decided_with_certificate, stated
from tests.thorough import keep

ATTRACTS, STAYS, LEAVES = "asymptotically stable", "stable", "unstable"
QUASI = "-{0}*(y + {1}*sqrt(Abs(x))*sign(x))/(Abs(y) + {1}*sqrt(Abs(x)))"

DECIDED = {
    "y; -2*(y + sqrt(Abs(x))*sign(x))/(Abs(y) + sqrt(Abs(x)))": ATTRACTS,
    "-x/(Abs(x) + Abs(y)); -2*y/(Abs(x) + Abs(y))": ATTRACTS,
    "-x**3/(x**2 + y**2); -y": ATTRACTS,
    "(x - y)/(Abs(x) + Abs(y)); (x + y)/(Abs(x) + Abs(y))": LEAVES,
    "y; -3*(y + sqrt(Abs(x))*sign(x))/(Abs(y) + sqrt(Abs(x))) - sign(x)/4": ATTRACTS,  # against a disturbance
    "-x/(Abs(x) + Abs(y) + Abs(z)); -y/(Abs(x) + Abs(y) + Abs(z)); -z/(Abs(x) + Abs(y) + Abs(z))": ATTRACTS,
}


@pytest.mark.parametrize("text", keep(4, DECIDED))
def test_it_is_decided_with_a_certificate(text: str) -> None:
    result = decided_with_certificate(stated(text), DECIDED[text])
    assert result.facts()["lyapunov"]["rate"] is None  # it would be one of another time


def test_a_point_that_solutions_pass_is_no_equilibrium() -> None:
    """``x' = 1``, written as a quotient: the cleared field is zero there."""
    record = stated("(Abs(x) + Abs(y))/(Abs(x) + Abs(y)); -y").check().facts()
    assert record["translation"]["verdict"] == LEAVES
    assert record["equilibrium"]["verdict"] == "undecided"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("-x/(x**2 + y**2); -y/(x**2 + y**2)", "proved bounded beside the point"),
        ("x/(x**2 + y**4); -y", "proved bounded beside the point"),
        ("-x/y; -y", "not zero at the checked point"),
        ("-x/(x**2 - y**2); -y", "not zero at the checked point"),
        ("x*y/(x**2 + y**2 - 8*x**4); -y", "proved not to vanish"),
        ("x/Abs(x); -y", "not zero at the checked point"),  # zero on an axis
    ],
)
def test_what_has_no_bound_or_sign_is_refused(text: str, said: str) -> None:
    with pytest.raises(ns.SceneError, match=said):
        stated(text).check()


@pytest.mark.parametrize(("gain", "slope"), keep(1, [(2, 1), (1, 1), (5, 2), (1, 3)]))
def test_a_path_comes_to_the_point_when_other_steps_do(gain: int, slope: int) -> None:
    path = ns.System(["x", "y"], ["y", QUASI.format(gain, slope)]).simulate(start=(0.3, 0.2), until=30)
    end = path.facts()["end"]

    def field(t: float, state: np.ndarray) -> list[float]:
        x, y = state
        root = slope * np.sqrt(abs(x))
        return [y, -gain * (y + root * np.sign(x)) / (abs(y) + root)]

    def near(t: float, state: np.ndarray) -> float:
        return float(np.sqrt(abs(state[0])) + abs(state[1]) - 1e-2)

    near.terminal = True  # type: ignore[attr-defined]
    other = solve_ivp(field, (0, 30), (0.3, 0.2), events=near, max_step=1e-3)
    assert end["state"] == pytest.approx([0, 0], abs=1e-9)
    assert end["t"] == pytest.approx(other.t_events[0][0], abs=0.1)  # from there on a little longer
    assert "denominator" in end["note"]


def test_a_path_from_the_point_is_refused() -> None:
    with pytest.raises(TrajectoryError, match="a denominator is zero"):
        stated("-x/(Abs(x) + Abs(y)); -y/(Abs(x) + Abs(y))").simulate(start=(0, 0), until=1)


@pytest.mark.parametrize(("place", "method"), keep(5, product([(0, 0), (1, 2)], ["events", "smoothed", "hysteresis"])))
def test_paths_of_all_methods_come_to_the_point(place: tuple[int, int], method: str) -> None:
    """From 0.3 and 0.1 beside it they arrive at 0.35, and none goes on, or is said to escape.

    Away from the origin a denominator that is multiplied out is a small difference of large numbers.
    """
    x, y = (f"({name} - {coordinate})" for name, coordinate in zip("xy", place, strict=True))
    size = f"(Abs{x} + Abs{y})"
    start = (place[0] + 0.3, place[1] + 0.1)
    rhs = [f"-{x}/{size}", f"-2*{y}/{size}"]
    until = 0.36 if method == "hysteresis" and any(place) else 0.7  # it switches ever more often there
    path = ns.System(["x", "y"], rhs, at=place).simulate(start=start, until=until, method=method)
    end = path.facts()["end"]
    assert end["state"] == pytest.approx(place, abs=1e-9 if method == "events" else 2e-3)
    assert end["t"] >= 0.35 - 2e-3
    assert "grows" not in end["reason"]
    if method == "events":
        assert end["t"] == pytest.approx(0.35, abs=1e-9)
        assert "denominator" in end["note"]
    path.to_terminal()


def test_a_field_without_surfaces_is_followed_with_hysteresis() -> None:
    path = ns.System(["x", "y"], ["-x", "-2*y"]).simulate(start=(0.5, 0.25), until=1, method="hysteresis")
    assert path.facts()["end"]["state"] == pytest.approx([0.5 * np.exp(-1), 0.25 * np.exp(-2)])


@pytest.mark.usefixtures("without_reach")
def test_a_denominator_without_the_state_under_a_root_is_read() -> None:
    """The sizes of roots are no directions in which its sign is looked at."""
    found = stated("y; -sqrt(Abs(x))*sign(x) - y*Abs(y)/(Abs(x) + Abs(y))").check()
    assert found.verdict == ATTRACTS


@pytest.mark.usefixtures("without_reach")
def test_beside_roots_and_sines_a_verdict_without_a_certificate_says_so() -> None:
    result = stated(f"y; {QUASI.format(2, 1)} + sin(x)").check()
    assert result.verdict == ATTRACTS
    with pytest.raises(NoCertificateError, match="denominators with states beside roots and sines"):
        result.certificate()
