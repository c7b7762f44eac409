"""Every number beside a V names where it holds: there it is compared with solutions by small steps and with samples.

The oracle shares nothing with the proofs: formulas are evaluated in floats, solutions are polygons with small steps,
and what is compared are the numbers of the JSON record alone, on the domain that stands beside each.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.systems.decay_rate import SublevelRegion
from tests.proofs.forged import with_reach

NAMES: dict[str, Any] = {"Abs": np.abs, "sign": np.sign, "sgn": np.sign, "Max": np.maximum, "sin": np.sin}
STEP = 1 / 512
STARTS = 60
DIRECTIONS = 16  # of disturbances


def smooth(seed: int, count: int) -> list[str]:
    """A contraction with a shear, and random terms of degree two and three that are felt near the border."""
    rng = np.random.default_rng(seed)
    names = ["x", "y", "z"][:count]
    quadratic = [f"{a}*{b}" for a in names for b in names]
    rhs = []
    for k, name in enumerate(names):
        other = names[(k + 1) % count]
        terms = [f"-{name}", f"({rng.integers(-4, 5)}/8)*{other}"]
        terms += [f"({rng.integers(-8, 9)}/2)*{rng.choice(quadratic)}", f"({rng.integers(-8, 9)}/4)*{name}**3"]
        rhs.append(" + ".join(terms))
    return rhs


def relay(seed: int, count: int) -> list[str]:
    """Relays that push back, with random linear terms."""
    rng = np.random.default_rng(seed)
    names = ["x", "y", "z"][:count]
    others = names[1:] + names[:1]
    pairs = zip(names, others, strict=True)
    return [f"-{rng.integers(1, 4)}*sign({own}) + ({rng.integers(-4, 5)}/4)*{other}" for own, other in pairs]


FAMILIES = {"smooth": smooth, "relay": relay}


def values(text: str, states: np.ndarray) -> np.ndarray:
    """A formula at the columns of an array of states."""
    places = dict(zip("xyz", states, strict=False))
    return np.asarray(eval(text, dict(NAMES), places), dtype=float) + 0 * states[0]  # noqa: S307 - texts of this test


def velocity(rhs: list[str], states: np.ndarray) -> np.ndarray:
    return np.array([values(text, states) for text in rhs])


def record_of(rhs: list[str]) -> dict[str, Any]:
    record = ns.System(["x", "y", "z"][: len(rhs)], rhs, radius="1/2").check().to_dict()["lyapunov"]
    return dict(record)


def starts_below(record: dict[str, Any], within: dict[str, Any], count: int) -> np.ndarray:
    """Random points of the square at which V is below the level that is named; as columns."""
    rng = np.random.default_rng(0)
    radius = within["radius"]
    points = rng.uniform(-radius, radius, (count, 200_000)) * rng.uniform(0, 1, 200_000)
    inside = values(record["V"], points) < within["level"]
    return points[:, inside][:, :STARTS]


def requires_rate(rhs: list[str], record: dict[str, Any], kind: str, kappa: float, within: dict[str, Any]) -> None:
    """V falls at the rate along polygons from everywhere in the domain, which they never leave."""
    states = starts_below(record, within, len(rhs))
    assert states.shape[1] == STARTS
    first = values(record["V"], states)
    slack = 4 * STEP * np.abs(velocity(rhs, states)).max()  # of a polygon across a surface
    for step in range(1, 3 * 512):
        states = states + STEP * velocity(rhs, states)
        t = step * STEP
        now = values(record["V"], states)
        bound = first * np.exp(-kappa * t) if kind == "exponential" else np.maximum(first - kappa * t, 0)
        smallest = slack if "sign" in "".join(rhs) else 2 * STEP * first
        assert np.all(now <= bound + smallest)
        assert np.all(np.abs(states) <= within["radius"] + slack)


def requires_inequality(rhs: list[str], record: dict[str, Any], kappa: float, within: dict[str, Any]) -> None:
    """``V' <= -kappa V`` at random points of the domain, the slope of V by central differences."""
    states = starts_below(record, within, len(rhs))
    small = 1e-6
    along = velocity(rhs, states)
    rise = (values(record["V"], states + small * along) - values(record["V"], states - small * along)) / (2 * small)
    assert np.all(rise <= -kappa * values(record["V"], states) + 1e-6)


def requires_gain(rhs: list[str], record: dict[str, Any], gain: dict[str, Any]) -> None:
    """Disturbances that do their worst keep to ``V' <= -kappa V + gamma abs(d)`` in the level set that is named."""
    states = starts_below(record, gain["within"], len(rhs))
    kappa, kind, level = record["rate"]["kappa"], record["rate"]["kind"], gain["within"]["level"]
    delta = 0.9 * gain["largest"]
    angles = np.linspace(0, 2 * np.pi, DIRECTIONS, endpoint=False)
    pushes = delta * np.array([np.cos(angles), np.sin(angles)])[:, :, None]
    first = values(record["V"], states)
    slack = 8 * STEP * gain["gamma"] * (np.abs(velocity(rhs, states)).max() + delta)
    for step in range(1, 2 * 512):
        moved = (states + STEP * velocity(rhs, states))[:, None] + STEP * pushes
        worst = values(record["V"], moved.reshape(2, -1)).reshape(DIRECTIONS, -1).argmax(axis=0)
        states = moved[:, worst, np.arange(states.shape[1])]
        t = step * STEP
        falls = np.exp(-kappa * t)
        bound = first * falls + gain["gamma"] * delta / kappa * (1 - falls)
        if kind == "finite":
            bound = np.maximum(first - (kappa - gain["gamma"] * delta) * t, 0)
        assert np.all(values(record["V"], states) <= bound + slack)
    assert values(record["V"], states).max() < level + slack


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", [2, 1, *range(3, 21)])
def test_planar_numbers_hold_where_they_say(family: str, seed: int) -> None:
    rhs = FAMILIES[family](seed, 2)
    record = record_of(rhs)
    rate, gain, region = record["rate"], record["gain"], record["region"]
    if region is not None:
        states = starts_below(record, {"radius": region["within"], "level": region["level"]}, 2)
        for _ in range(20 * 512):
            states = states + STEP * velocity(rhs, states)
        assert np.all(np.abs(states) < 0.02)
    if rate is None:
        return
    requires_rate(rhs, record, rate["kind"], rate["kappa"], rate["within"])
    assert rate["within"]["text"] in rate["text"]
    if rate["region"] is not None:
        requires_rate(rhs, record, "exponential", rate["region"]["kappa"], rate["region"]["within"])
        requires_inequality(rhs, record, rate["region"]["kappa"], rate["region"]["within"])
    if gain is not None:
        requires_gain(rhs, record, gain)
        assert gain["within"]["text"] in gain["text"]


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(4))
def test_numbers_in_three_states_hold_where_they_say(family: str, seed: int) -> None:
    rhs = FAMILIES[family](seed, 3)
    record = record_of(rhs)
    rate = record["rate"]
    if rate is not None and rate["within"]["level"] is not None:
        requires_rate(rhs, record, rate["kind"], rate["kappa"], rate["within"])
        assert rate["within"]["text"] in rate["text"]


def test_a_rate_beside_a_larger_region_names_its_own_square() -> None:
    """``y' = -y - 2 y^2`` rests at ``y = -1/2``: no rate holds all over the region, the near one far less."""
    record = record_of(["-x", "-y - 2*y**2"])
    region, rate, gain = record["region"], record["rate"], record["gain"]
    assert (region["level"], region["within"]) == (1 / 4, 1 / 2)
    assert rate["within"]["radius"] == gain["within"]["radius"] == 1 / 32
    assert rate["within"]["level"] == gain["within"]["level"] == 1 / 1024
    y = -np.sqrt(rate["region"]["within"]["level"])
    assert 2 * y * (-y - 2 * y * y) <= -rate["region"]["kappa"] * y * y
    assert 2 * y * (-y - 2 * y * y) > -rate["kappa"] * y * y  # so a rate that names no domain misleads


def test_a_forged_rate_on_a_region_is_rejected() -> None:
    result = ns.System(["x", "y"], ["-x", "-y - 2*y**2"], radius="1/2").check().evidence
    reach = result.reach
    assert reach.region_rate is not None
    assert reach.region is not None
    assert result.check()
    faster = replace(reach.region_rate, kappa=reach.region_rate.kappa * 2)
    farther = replace(reach.region_rate, level=reach.region.level * 2)
    for forged in (faster, farther):
        assert not with_reach(result, region_rate=forged).check()
    assert isinstance(reach.near, SublevelRegion)
    assert not with_reach(result, near=replace(reach.near, level=reach.region.level)).check()
