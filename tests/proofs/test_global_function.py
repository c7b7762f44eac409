"""A V for the whole space is searched where that of the checked square says nothing about it.

The truths are published: the sources stand beside the systems in :mod:`tests.proofs.literature`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.files import parse
from nonsmooth.proofs.checker.statements import show_evidence
from nonsmooth.proofs.system_certificates import certificate_text
from tests.thorough import few

GLOBAL: dict[str, Any] = {
    "energy that falls weakly": ("y", "-x**3 - y"),
    "a quadratic form whose mixed terms cancel": ("-x - 3*x**2*y**3/2", "-y**3 + x**3*y**2/2"),
    "a cascade": ("-x + y**2", "-y"),
    "jet engine": ("-y - 3*x**2/2 - x**3/2", "3*x - y"),
    "Lorenz": ("10*(y - x)", "x/2 - y - x*z", "x*y - 8*z/3"),
    "arbitrary switching": [["-x + y**2", "-y"], ["-x - y**2", "-2*y"]],
}
LOCAL = {
    "a limit cycle": ("-y", "x - y + x**2*y"),
    "other places of rest": ("y", "-x + x**3 - y"),
    "all but a line": ("-x + x**2*y", "-y"),
}


def system(rhs: tuple[str, ...] | list[list[str]]) -> ns.System:
    first = rhs[0] if isinstance(rhs, list) else rhs
    return ns.System(["x", "y", "z"][: len(first)], rhs, radius="1/2")


@few(3)
@pytest.mark.parametrize("name", GLOBAL)
def test_every_start_arrives(name: str) -> None:
    result = system(GLOBAL[name]).check()
    assert result.evidence.reach.everywhere
    _, shown = show_evidence(*parse(certificate_text(result.certificate()).encode()))
    assert {"attracts": "everywhere"} in shown


@pytest.mark.parametrize("name", LOCAL)
def test_not_every_start_is_said_to_arrive(name: str) -> None:
    result = system(LOCAL[name]).check()
    assert result.verdict == "asymptotically stable"
    assert not result.evidence.reach.everywhere


def test_starts_far_away_arrive_in_floats() -> None:
    """Of the jet engine, by steps of Runge and Kutta that know nothing of V."""
    x = np.random.default_rng(0).uniform(-20, 20, (2, 200))

    def field(place: np.ndarray) -> np.ndarray:
        u, v = place
        return np.stack([-v - 3 * u**2 / 2 - u**3 / 2, 3 * u - v])

    for _ in range(8_000):
        step = 4e-3 / (1 + 0.05 * np.abs(x).max(axis=0) ** 2)
        middle = x + step / 2 * field(x)
        x = x + step * field(middle)
    assert np.linalg.norm(x, axis=0).max() < 1e-2
