"""Foci that are weak and not smooth, which terms after the first ones decide; full turns in floats agree."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.kernel_strategies import decide_by_kept_energy
from nonsmooth.proofs.system_certificates import certificate_text
from nonsmooth.proofs.system_decision import checked_point
from tests.thorough import few, keep, thorough

Side = Callable[[float, float], float]
GROWS, FALLS, OPEN = "unstable", "asymptotically stable", "nothing"
STEPS = 4_000  # of a full turn


def rhs_of(text: str) -> list[str]:
    return [side.strip() for side in text.split(";")]


def said_by_energy(text: str) -> str:
    """What an energy with further terms says, and nothing else."""
    found = decide_by_kept_energy(checked_point(ns.System(["x", "y"], rhs_of(text)).system))
    return OPEN if found is None else str(found.verdict)


def growth_in_a_turn(sides: tuple[Side, Side], radius: float = 0.02) -> float:
    """By how much ln of the distance grows in a full turn, over the radius: Runge and Kutta's method in the angle.

    The angle grows or falls as solutions turn.
    """

    def slope(angle: float, distance: float) -> float:
        x, y = distance * np.cos(angle), distance * np.sin(angle)
        f, g = (side(x, y) for side in sides)
        return float((x * f + y * g) * distance / (x * g - y * f))

    sense = np.sign(sides[1](radius, 0.0))  # on the first axis
    distance, step = radius, sense * 2 * np.pi / STEPS
    for k in range(STEPS):
        angle = (k + 0.01) * step
        first = slope(angle, distance)
        second = slope(angle + step / 2, distance + step / 2 * first)
        third = slope(angle + step / 2, distance + step / 2 * second)
        fourth = slope(angle + step, distance + step * third)
        distance += step / 6 * (first + 2 * second + 2 * third + fourth)
    return float(np.log(distance / radius) / radius)


WEAK_FOCI: dict[str, tuple[Side, Side]] = {
    "-y - 2*x*Abs(x); x + y*Abs(y)": (lambda x, y: -y - 2 * x * abs(x), lambda x, y: x + y * abs(y)),
    "-y + x*Abs(x); x + y*Abs(y) + 2*x*y*sign(x - y)": (
        lambda x, y: -y + x * abs(x),
        lambda x, y: x + y * abs(y) + 2 * x * y * np.sign(x - y),
    ),
    # the field jumps on a curve, V bends on it
    "-y - 3*x*Abs(x); x + 2*y*Abs(y) + 2*x*y*sign(y - x**2)": (
        lambda x, y: -y - 3 * x * abs(x),
        lambda x, y: x + 2 * y * abs(y) + 2 * x * y * np.sign(y - x**2),
    ),
    # turns are ellipses
    "-x - 2*y - 2*x**2; 2*x + y - 2*Abs(x)*y": (
        lambda x, y: -x - 2 * y - 2 * x**2,
        lambda x, y: 2 * x + y - 2 * abs(x) * y,
    ),
    # first terms of third order
    "y - 3*x**3; -x + 2*y**3 - 3*x**2*y*sign(y)": (
        lambda x, y: y - 3 * x**3,
        lambda x, y: -x + 2 * y**3 - 3 * x**2 * y * np.sign(y),
    ),
    # energies of two half ellipses, and damping on one side alone
    "y; -Max(x, 0) - 4*Min(x, 0) - Max(x, 0)*y": (
        lambda x, y: y,
        lambda x, y: -max(x, 0.0) - 4 * min(x, 0.0) - max(x, 0.0) * y,
    ),
}


NEAR_ONLY = "-y - 3*x*Abs(x); x + 2*y*Abs(y) + 2*x*y*sign(y - x**2)"  # by terms at the point, not on a cube
FROM_EVERYWHERE = "y; -Max(x, 0) - 4*Min(x, 0) - Max(x, 0)*y"  # by a V that does not rise


@pytest.mark.parametrize("text", keep(3, WEAK_FOCI))
def test_a_weak_focus_is_decided_as_it_turns(text: str) -> None:
    turned = growth_in_a_turn(WEAK_FOCI[text])
    assert abs(turned) > 1e-3
    assert said_by_energy(text) == (GROWS if turned > 0 else FALLS)


@thorough  # how they are decided: the test above; certificates of all theorems: checker/test_corpus.py
@pytest.mark.parametrize("text", WEAK_FOCI)
def test_its_certificate_is_accepted(text: str) -> None:
    """A focus that attracts has a region, but one, and a rate, but where nothing is known but that all starts come."""
    result = ns.System(["x", "y"], rhs_of(text)).check()
    certificate = result.certificate()
    claims = certificate["statement"]["claims"]
    assert {"stability": result.verdict} in claims
    assert not refusal(certificate, len(certificate_text(certificate)))
    if result.verdict == FALLS:
        assert any("attracts" in claim for claim in claims) is (text != NEAR_ONLY)
        assert any("rate" in claim for claim in claims) is (text not in (NEAR_ONLY, FROM_EVERYWHERE))


def test_what_cancels_in_a_turn_is_left_open() -> None:
    """``-2 |cos|^3 + 3 |sin|^3 - 2 |cos| sin^2`` has the mean zero."""
    sides = (lambda x, y: -y - 2 * x * abs(x), lambda x, y: x + 3 * y * abs(y) - 2 * x * y * np.sign(x))
    assert abs(growth_in_a_turn(sides, 1e-3)) < 1e-2
    assert said_by_energy("-y - 2*x*Abs(x); x + 3*y*Abs(y) - 2*x*y*sign(x)") == OPEN


LINES: dict[str, Callable[[float, float], float]] = {
    "x": lambda x, y: x,
    "x + y": lambda x, y: x + y,
    "x + 2*y": lambda x, y: x + 2 * y,
}


@few(6)
@pytest.mark.parametrize(("seed", "line"), list(product(range(12), LINES)))
def test_random_weak_foci_are_decided_as_they_turn(seed: int, line: str) -> None:
    """Where a turn changes the distance clearly, the energy decides, and as the turn does."""
    a, b, c = (int(coefficient) for coefficient in np.random.default_rng(seed).choice([-3, -2, -1, 1, 2, 3], 3))
    sides = (
        lambda x, y: -y + a * x * abs(x),
        lambda x, y: x + b * y * abs(y) + c * x * y * np.sign(LINES[line](x, y)),
    )
    turned = growth_in_a_turn(sides, 1e-3)
    verdict = said_by_energy(f"-y + {a}*x*Abs(x); x + {b}*y*Abs(y) + {c}*x*y*sign({line})")
    assert verdict in {OPEN, GROWS if turned > 0 else FALLS}
    if abs(turned) > 2:
        assert verdict != OPEN


@thorough
@pytest.mark.parametrize("seed", range(40))
def test_random_weak_foci_of_any_kind_are_never_decided_otherwise(seed: int) -> None:
    """With terms of second and third order that jump on two lines."""
    a, b, c, d = (int(coefficient) for coefficient in np.random.default_rng(seed).integers(-3, 4, 4))
    sides = (
        lambda x, y: -y + a * x * abs(y) + b * x**3,
        lambda x, y: x + c * y * y * np.sign(x - 2 * y) + d * y * x**2 * np.sign(x),
    )
    text = f"-y + {a}*x*Abs(y) + {b}*x**3; x + {c}*y**2*sign(x - 2*y) + {d}*y*x**2*sign(x)"
    turned = growth_in_a_turn(sides, 1e-3)
    verdict = said_by_energy(text)
    if abs(turned) > 1e-4:
        assert verdict in {OPEN, GROWS if turned > 0 else FALLS}
