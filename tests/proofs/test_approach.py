"""Sets of equilibria that solutions approach: dry friction, agents, epidemics; and what does not come to rest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.system_certificates import certificate_text
from nonsmooth.proofs.system_decision import REQUIRABLE
from nonsmooth.proofs.systems.coupled_energy import coupled_energy
from nonsmooth.reports.checks.check import OF_SYSTEMS
from tests.thorough import but, few, keep

STILL = 2.0**-6  # of a speed along the smooth layer of signs, in units of its first
LAYER = 1e-3  # half its width
LONG = 200.0


def approach_of(states: list[str], rhs: list[str], **more: Any) -> dict[str, Any] | None:
    """What a check says of the set of equilibria; a certificate of it is accepted, and states as much."""
    result = ns.System(states, rhs, **more).check()
    found: dict[str, Any] | None = result.facts().get("approach")
    if found is not None:
        certificate = result.certificate()
        text = certificate_text(certificate)
        assert not refusal(certificate, len(text))
        region = {"function": found["V"], "within": found["within"], "below": found["level"]}
        said = "everywhere" if found["everywhere"] else region if found["level"] else "near"
        assert {"approaches": said} in certificate["statement"]["claims"]
    return found


SETS = {
    "dry friction": (["x", "v"], ["v", "-x - sign(v)"], True),
    "beside damping": (["x", "v"], ["v", "-x - v - sign(v)"], True),
    "on one of two masses": (["q", "p", "v", "w"], ["v", "w", "-2*q + p - v", "q - 2*p - 2*sign(w)"], True),
    "a pendulum": (["x", "v"], ["v", "-sin(x) - sign(v)"], False),
    "a dead zone": (["x", "v"], ["v", "-v - (Abs(x - 1) - Abs(x + 1) + 2*x)/2"], False),
    "a state that rests": (["x", "y"], ["-sign(x)", "0"], True),
    "agents": (["x", "y", "z"], ["y - x", "x - 2*y + z", "y - z"], True),
    "agents by signs": (["x", "y", "z"], ["sign(y - x)", "sign(x - y) + sign(z - y)", "sign(y - z)"], True),
    "an epidemic": (["s", "i"], ["-s*i", "s*i - i"], False),
}


@few(5)
@pytest.mark.parametrize("name", SETS)
def test_sets_of_equilibria_are_approached(name: str) -> None:
    """From everywhere, or from below a level; a certificate says the same."""
    states, rhs, everywhere = SETS[name]
    found = approach_of(states, rhs)
    assert found is not None
    assert found["everywhere"] is everywhere
    assert everywhere or found["level"] is not None
    assert found["text"].endswith("is kept, nothing moves")


MOVING = {
    "orbits": (["x", "y"], ["y", "-x"]),
    "orbits beside a relay": (["x", "y", "z"], ["y", "-x", "-sign(z)"]),
    "friction on one of two masses that the other does not move": (
        ["q", "p", "v", "w"],
        ["v", "w", "-q", "-p - sign(w)"],
    ),
    "closed squares": (["x", "y"], ["sign(y)", "-sign(x)"]),
}


@pytest.mark.parametrize("name", but(["orbits beside a relay"], MOVING))
def test_what_goes_on_moving_is_not_said_to_rest(name: str) -> None:
    """Stable all the same."""
    states, rhs = MOVING[name]
    result = ns.System(states, rhs).check()
    assert str(result.verdict) == "stable"
    assert "approach" not in result.facts()


def test_a_point_that_attracts_is_no_set() -> None:
    assert "approach" not in ns.System(["x", "y"], ["-x", "-y"]).check().facts()


def chains() -> Iterator[tuple[int, int]]:
    """Seeds with one to three masses."""
    return ((seed, 1 + seed % 3) for seed in range(12))


@pytest.mark.parametrize(("seed", "masses"), keep(3, chains()))
def test_random_dry_friction_comes_to_rest(seed: int, masses: int) -> None:
    """Springs between neighbours, dry friction on some of the masses and damping on others.

    Where it is said that solutions approach equilibria, smooth layers of the signs are slow in the end (SciPy).
    """
    source = np.random.default_rng(seed)
    dry, damped = source.integers(0, 3, masses), source.integers(0, 3, masses)
    stiff = source.integers(1, 4, masses)

    def force(k: int) -> str:
        springs = [f"-{stiff[k]}*q{k}"]
        springs += [f"- q{k} + q{j}" for j in (k - 1, k + 1) if 0 <= j < masses]
        return " ".join([*springs, f"- {damped[k]}*v{k}", f"- {dry[k]}*sign(v{k})"])

    states = [f"q{k}" for k in range(masses)] + [f"v{k}" for k in range(masses)]
    rhs = [f"v{k}" for k in range(masses)] + [force(k) for k in range(masses)]
    result = ns.System(states, rhs).check()
    found = result.facts().get("approach")
    rubs = bool(np.all((dry > 0) | (damped > 0)))
    assert (found is not None) == (rubs and str(result.verdict) == "stable")
    if found is None:
        return

    def velocity(_: float, z: np.ndarray) -> np.ndarray:
        q, v = z[:masses], z[masses:]
        springs = -stiff * q
        for k in range(masses - 1):
            springs[k] += q[k + 1] - q[k]
            springs[k + 1] += q[k] - q[k + 1]
        return np.concatenate([v, springs - damped * v - dry * np.tanh(v / LAYER)])

    start = source.uniform(-3, 3, 2 * masses) if found["everywhere"] else source.uniform(-0.05, 0.05, 2 * masses)
    end = solve_ivp(velocity, (0, LONG), start, method="LSODA", rtol=1e-8, atol=1e-10).y[:, -1]
    assert np.linalg.norm(velocity(0.0, end)) < STILL * np.linalg.norm(velocity(0.0, start))


COUPLED = {
    "springs": (["v", "2*w", "-2*q + p - v", "(q - 2*p - 2*sign(w))/3"], "q**2 - q*p + p**2 + 1/2*v**2 + 3*w**2"),
    "a potential of third degree": (
        ["v", "w", "-q - 2*q*p - v", "-p - q**2 + p**2"],
        "q**2*p - 1/3*p**3 + 1/2*q**2 + 1/2*p**2 + 1/2*v**2 + 1/2*w**2",
    ),
    "forces that turn": (["v", "w", "-q - p", "-p + q"], None),
    "a place without a speed": (["v", "w", "-q - v", "-w"], None),
}


@pytest.mark.parametrize("name", COUPLED)
def test_the_energy_of_masses_that_springs_join(name: str) -> None:
    """With the masses with which forces have a potential."""
    rhs, energy = COUPLED[name]
    found = coupled_energy(ns.System(["q", "p", "v", "w"], rhs).system)
    assert (None if found is None else found.text) == energy


def test_the_energy_is_about_the_checked_point() -> None:
    """In the displacement from it."""
    rhs = ["v", "-(q - 1) + p - 1", "w", "-2*(p - 1) + q - 1"]
    energy = coupled_energy(ns.System(["q", "v", "p", "w"], rhs, at=["1", "0", "1", "0"]).system)
    assert energy is not None
    assert energy.text == "1/2*q**2 - q*p + 1/2*v**2 + p**2 + 1/2*w**2"


@pytest.mark.parametrize(
    ("rhs", "statuses"),
    [
        (["v", "-x - sign(v)"], (0, 1, 1, 0)),
        (["v", "-x - v"], (0, 0, 0, 0)),
        (["v", "-x + x**2/8 - v"], (0, 0, 3, 0)),
        (["v", "x"], (1, 1, 1, 1)),
        (["v", "-x"], (0, 1, 1, 3)),
    ],
)
def test_what_exit_status_0_says_of_a_system_is_asked_for(rhs: list[str], statuses: tuple[int, ...]) -> None:
    """Shown, refuted, or neither; several are asked together."""
    result = ns.System(["x", "v"], rhs).check().evidence
    assert tuple(result.status([name]) for name in REQUIRABLE) == statuses
    assert OF_SYSTEMS == REQUIRABLE
    assert result.status(REQUIRABLE) == (1 if 1 in statuses else max(statuses))
