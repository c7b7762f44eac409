"""Denominators that are zero at the checked point alone: verdicts, what is refused, and paths in floats beside ours."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.system_certificates import certificate_text
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


def system(text: str) -> ns.System:
    rhs = [side.strip() for side in text.split(";")]
    return ns.System(list("xyz"[: len(rhs)]), rhs)


@pytest.mark.parametrize("text", keep(4, DECIDED))
def test_it_is_decided_with_a_certificate(text: str) -> None:
    result = system(text).check()
    assert result.verdict == DECIDED[text]
    certificate = result.certificate()
    assert {"stability": result.verdict} in certificate["statement"]["claims"]
    assert not refusal(certificate, len(certificate_text(certificate)))
    assert result.facts()["lyapunov"]["rate"] is None  # it would be one of another time


def test_a_point_that_solutions_pass_is_no_equilibrium() -> None:
    """``x' = 1``, written as a quotient: the cleared field is zero there."""
    record = system("(Abs(x) + Abs(y))/(Abs(x) + Abs(y)); -y").check().facts()
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
        system(text).check()


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
        system("-x/(Abs(x) + Abs(y)); -y/(Abs(x) + Abs(y))").simulate(start=(0, 0), until=1)
