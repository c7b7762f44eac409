"""Relay oscillators that an energy leaves open: terms of higher weight decide, and half turns of polygons agree."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.kernel_strategies import decide_by_weights
from nonsmooth.proofs.system_certificates import certificate_text
from nonsmooth.proofs.system_decision import checked_point
from nonsmooth.proofs.systems.findings import Known
from tests.thorough import few, thorough

Force = Callable[[float, float], float]
GROWS, FALLS = "unstable", "asymptotically stable"
FORCES: dict[str, tuple[str, Force]] = {  # y' of x' = y
    "-3*sign(x) + 2*y**3 + x**2": (GROWS, lambda x, y: -3 * np.sign(x) + 2 * y**3 + x**2),
    "-3*sign(x) - 2*y**3 + x**2": (FALLS, lambda x, y: -3 * np.sign(x) - 2 * y**3 + x**2),
    "-2*sign(x) + y**2*x + y**3": (GROWS, lambda x, y: -2 * np.sign(x) + y**2 * x + y**3),
    "-3*sign(x) - 2*y**3 - x**2*y + x*y": (FALLS, lambda x, y: -3 * np.sign(x) - 2 * y**3 - x**2 * y + x * y),
}
CENTRE = "-sign(x) + x*y"  # turned by (x, t) -> (-x, -t) into itself: all orbits near the point are closed


def half_turns(force: Force, y: float = 0.3, step: float = 1e-4) -> list[float]:
    """The speeds at which x passes 0, by the midpoint rule on each side of it."""
    x, found = 0.0, list[float]()
    for _ in range(200_000):
        if abs(y) > 1:
            break
        side = np.sign(x) if x else np.sign(y)
        middle = x + step / 2 * y, y + step / 2 * force(side * max(abs(x), 1e-12), y)
        after = x + step * middle[1], y + step * force(side * max(side * middle[0], 1e-12), middle[1])
        if after[0] * side < 0:
            found.append(abs(after[1]))
            after = 0.0, after[1]
        x, y = after
    return found


def verdict_by_weights(force: str) -> str:
    """What terms of higher weight say, and nothing else."""
    found = decide_by_weights(checked_point(ns.System(["x", "y"], ["y", force]).system), Known())
    return "nothing" if found is None else str(found.verdict)


@pytest.mark.parametrize("force", FORCES)
def test_terms_of_higher_weight_are_found(force: str) -> None:
    verdict, _ = FORCES[force]
    assert verdict_by_weights(force) == verdict


@thorough  # how it is decided: the test above; certificates of all theorems: checker/test_corpus.py
@pytest.mark.parametrize("force", FORCES)
def test_terms_of_higher_weight_decide(force: str) -> None:
    verdict, _ = FORCES[force]
    result = ns.System(["x", "y"], ["y", force]).check()
    assert result.verdict == verdict
    certificate = result.certificate()
    assert {"stability": verdict} in certificate["statement"]["claims"]
    assert not refusal(certificate, len(certificate_text(certificate)))


@few(1)  # of the force whose certificate is looked at
@pytest.mark.parametrize("force", FORCES)
def test_half_turns_agree(force: str) -> None:
    verdict, own = FORCES[force]
    turns = half_turns(own)
    every_other = turns[::2]
    assert len(every_other) > 5
    signs = {after > before for before, after in pairwise(every_other)}
    assert signs == {verdict == GROWS}


def test_a_centre_is_neither() -> None:
    """Its half turns come back after two."""
    turns = half_turns(lambda x, y: -np.sign(x) + x * y)
    assert turns[20] == pytest.approx(turns[0], rel=1e-2)
    assert verdict_by_weights(CENTRE) == "nothing"


@thorough  # the test above asks for one theorem
def test_no_theorem_decides_a_centre() -> None:
    assert ns.System(["x", "y"], ["y", CENTRE]).check().verdict not in (GROWS, FALLS)
