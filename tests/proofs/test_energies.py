"""Candidates for V of systems of second order: energies with a cross term."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.decay_rate import DecayKind
from nonsmooth.proofs.systems.energies import energies, falling_energies
from nonsmooth.symbolic.formulas.cleared_fractions import float_value
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from tests.plain import built

# Right-hand sides, the place of the position, and its force; at rest that of friction is the mean of both directions.
SECOND_ORDER = [
    (("y", "-2*sign(x) - y"), 0, lambda x: 2 * np.sign(x)),
    (("y", "-x*Abs(x) - 3*y"), 0, lambda x: x * abs(x)),
    (("y", "-x - x**3 - Max(x, 0)/2 - sign(y)"), 0, lambda x: x + x**3 + max(x, 0) / 2),
    (("-3*y**3 - Abs(y)*y - x", "x"), 1, lambda x: 3 * x**3 + abs(x) * x),
]


def energy_of(formula: PiecewiseExpression, place: int, x: float, v: float) -> float:
    """A candidate without its cross term, which changes its sign with v."""
    both = [dict(zip(("x", "y") if place == 0 else ("y", "x"), (x, speed), strict=True)) for speed in (v, -v)]
    return sum(float_value(formula.tree, values, formula.text) for values in both) / 2


@pytest.mark.parametrize(("rhs", "place", "force"), SECOND_ORDER)
def test_the_energy_has_the_slope_of_the_force(
    rhs: tuple[str, str], place: int, force: Callable[[float], float]
) -> None:
    system, step = built(rhs), 1e-6
    crossed = list(falling_energies(system, system.check.radius))[1:]
    found = [*crossed, *energies(system)]
    assert len(crossed) in (2, 4)
    for formula in found:
        for x, v in np.random.default_rng(3).uniform(-0.4, 0.4, (20, 2)).tolist():
            high, low = (energy_of(formula, place, x + move, v) for move in (step, -step))
            assert (high - low) / (2 * step) == pytest.approx(force(x), abs=1e-6)
            assert energy_of(formula, place, x, v) - energy_of(formula, place, x, 0.0) == pytest.approx(v**2 / 2)


def test_what_is_of_no_second_order_has_none() -> None:
    for rhs in (("y - x", "-2*x - 3*y"), ("y", "-sqrt(2)*x - y"), ("y*Abs(y)", "-x - y")):
        system = built(rhs)
        assert not list(falling_energies(system, system.check.radius))[1:]


@pytest.mark.parametrize(
    ("rhs", "energy"),
    [
        (("y", "-x**3 - y + 2*z", "-y/3 - z**3"), "z**2/2 + y**2/12 + x**4/24"),  # a chain of three
        (("2*y", "-sign(x) - y"), "Abs(x) + y**2"),
        (("y", "-3*sat(x, -1, 2)"), "3*(x*sat(x, -1, 2) - sat(x, -1, 2)**2/2) + y**2/2"),
        (("-x + y**3", "-x/2 - y"), "x**2/2 + y**4/2"),
        (("y", "-x**3 - 3*y/(1 + x**4)"), "x**4/4 + y**2/2"),
    ],
)
def test_energies_of_chains(rhs: tuple[str, ...], energy: str) -> None:
    system, states = built(rhs), "xyz"[: len(rhs)]
    found, *_ = energies(system)
    expected = parse_piecewise(energy, tuple(states))
    ratios = []
    for place in np.random.default_rng(3).uniform(-4, 4, (20, len(rhs))).tolist():
        values = dict(zip(states, place, strict=True))
        ratios.append(float_value(found.tree, values, found.text) / float_value(expected.tree, values, energy))
    assert ratios == pytest.approx([ratios[0]] * len(ratios))


def test_a_relay_with_viscous_friction_has_a_short_function() -> None:
    result = decide_system(built(["y", "-2*sign(x) - y"]))
    assert result.function is not None
    assert result.function.text == "2*Abs(x) + y**2/2 + x*y/4"
    assert result.reach.region is not None
    assert result.reach.region.level >= 0.1  # 1681/262144 of the richest family, on a smaller square
    assert result.reach.rate is not None
    assert result.reach.rate.decay is DecayKind.EXPONENTIAL
    kinds = {kind for claim in certificate_of(result)["statement"]["claims"] for kind in claim}
    assert {"stability", "attracts", "rate", "gain"} <= kinds


def test_slight_damping_beside_a_sine_is_seen_by_the_energy() -> None:
    result = decide_system(built(["y - x**3/1000", "-sin(x) - x - y**3/1000"]))
    claims = certificate_of(result)["statement"]["claims"]
    assert {"stability": "asymptotically stable"} in claims
    assert {kind for claim in claims for kind in claim} == {"stability", "attracts", "rate"}
