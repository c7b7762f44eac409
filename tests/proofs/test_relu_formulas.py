"""Loops with a layer of rectifiers: verdicts agree with paths of the same loop in floats."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.thorough import keep

DAMPED = np.array([-2.0, -1.5])


def random_layer(seed: int, units: int, *, biased: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Weights and biases of the units, and weights of their sum, as decimals of two digits."""
    rng = np.random.default_rng(seed)
    inner, outer = np.round(rng.normal(size=(units, 2)), 2), np.round(rng.normal(size=(1, units)), 2)
    return inner, np.round(rng.normal(size=units) / 2, 2) * biased, outer[0]


def loop(inner: np.ndarray, biases: np.ndarray, outer: np.ndarray) -> SwitchedSystem:
    """``x'' = -2 x - 3/2 x' + sum w_k (relu(a_k x + b_k x' + c_k) - relu(c_k))``, which rests at the origin."""
    units = zip(inner, biases, outer, strict=True)
    terms = [f"({w:.2f})*(relu(({a:.2f})*x + ({b:.2f})*v + ({c:.2f})) - relu({c:.2f}))" for (a, b), c, w in units]
    rhs = ["v", " + ".join(["-2*x - 3*v/2", *terms])]
    return build_system({"system": {"states": ["x", "v"], "rhs": rhs}}, "t", Path("t.toml"))


def largest_end(
    inner: np.ndarray, biases: np.ndarray, outer: np.ndarray, *, size: float = 1e-3, until: float = 40.0
) -> float:
    """Where paths from a small circle end, over its radius, by a solver that steps over the kinks."""

    def field(t: float, x: np.ndarray) -> np.ndarray:
        layer = outer @ (np.maximum(inner @ x + biases, 0) - np.maximum(biases, 0))
        return np.array([x[1], DAMPED @ x + layer])

    def gone(t: float, x: np.ndarray) -> float:
        return float(np.hypot(*x) - 50 * size)

    stop: Any = gone
    stop.terminal = True
    ends = []
    for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        start = size * np.array([np.cos(angle), np.sin(angle)])
        found = solve_ivp(field, (0, until), start, rtol=1e-9, atol=1e-13, events=stop)
        ends.append(np.hypot(*found.y[:, -1]) / size)
    return max(ends)


@pytest.mark.parametrize("units", keep(1, [4, 16, 8]))
@pytest.mark.parametrize("seed", range(6))
def test_verdicts_agree_with_paths(seed: int, units: int) -> None:
    layer = random_layer(100 * units + seed, units, biased=bool(seed % 2))
    result = decide_system(loop(*layer))
    assert result.check()
    last = largest_end(*layer)
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
        assert last < 0.5
    elif result.verdict is Translation.UNSTABLE:
        assert last > 2
    else:
        pytest.fail(f"{result.verdict}: {result.reason}")
