"""Homogeneous systems with weights: known ones, dilations of their formulas, starts from far away, and certificates."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.kernel.homogeneity import homogeneity_of
from nonsmooth.proofs.system_certificates import certificate_of, left_out
from nonsmooth.proofs.system_decision import decide_system
from tests.oracles.floats import velocity
from tests.plain import built, refused
from tests.thorough import but, few, keep

ROOTED = "Abs({0})**({1})*sgn({0})"
BHAT = ["y", f"-{ROOTED.format('x', '1/3')} - {ROOTED.format('y', '1/2')}"]

# Right-hand sides with the weights of the stated states, the least of them one, and the degree.
KNOWN: list[tuple[list[str], list[str], str]] = [
    (["y", "-2*sign(x) - sign(y)"], ["2", "1"], "-1"),  # twisting
    (["y", "-sign(x + y*Abs(y))"], ["2", "1"], "-1"),  # time-optimal
    (["y", "-x - y"], ["1", "1"], "0"),
    (["-x + y**3", "-y"], ["3", "1"], "0"),
    (["-x**3", "-y**3 + x*y**2"], ["1", "1"], "2"),
    (["y", "-x**3 - Abs(x)*y"], ["1", "2"], "1"),
    (["-sign(x) + sign(y)/2", "-sign(y)", "-2*sign(z)"], ["1", "1", "1"], "-1"),
    (["-3*sqrt(Abs(x))*sign(x) + y", "-sign(x)"], ["2", "1"], "-1"),  # super-twisting
    (BHAT, ["3", "2"], "-1"),
    ([f"-{ROOTED.format('x', '1/3')}"], ["3"], "-2"),
    (["-sqrt(2)*sign(x)"], ["1"], "-1"),
]
NOT = [
    ["y", "-x - sign(y)"],
    ["-x + x**3"],
    ["-x", "-sign(y)"],
    ["-sin(x)"],
    ["-x/(1 + x**2)"],
    ["-x*(2 + sign(x - 1))"],
]


@pytest.mark.parametrize(("rhs", "weights", "degree"), KNOWN)
def test_weights_and_degrees_are_known(rhs: list[str], weights: list[str], degree: str) -> None:
    homogeneity = homogeneity_of(built(rhs))
    assert homogeneity is not None
    scale = Fraction(weights[0]) / homogeneity.weights[0]
    assert [w * scale for w in homogeneity.weights] == list(map(Fraction, weights))
    assert homogeneity.degree * scale == Fraction(degree)


@pytest.mark.parametrize("rhs", NOT)
def test_other_systems_are_not_homogeneous(rhs: list[str]) -> None:
    assert homogeneity_of(built(rhs)) is None


TERMS = ["x", "y", "x**2", "x*y", "y**2", "x**3", "y**3", "sign(x)", "sign(y)", "Abs(x)", "y*Abs(y)", "Abs(x - y)"]


@pytest.mark.parametrize("count", keep(1, [60, 120]))
def test_formulas_scale_as_it_is_said(count: int) -> None:
    """Sums of random terms: the formulas themselves at a place and at its dilation."""
    rng, found = np.random.default_rng(0), 0
    for _ in range(count):
        rhs = [" + ".join(f"{rng.integers(1, 4)}*{t}" for t in rng.choice(TERMS, rng.integers(1, 3))) for _ in "xy"]
        homogeneity = homogeneity_of(built(rhs))
        if homogeneity is not None:
            places = rng.uniform(-2, 2, (2, 50))
            sizes = np.array([[1.7 ** float(weight)] for weight in homogeneity.weights])
            dilated = velocity(rhs, places) * sizes * 1.7 ** float(homogeneity.degree)
            assert velocity(rhs, places * sizes) == pytest.approx(dilated, rel=1e-12, abs=1e-12)
            found += 1
    assert count / 6 < found < 5 * count / 6


ARRIVING = [rhs for rhs, _, degree in KNOWN if degree.startswith("-")]


@few(2)
@pytest.mark.parametrize("rhs", but([KNOWN[1][0]], ARRIVING))
def test_every_start_arrives(rhs: list[str]) -> None:
    """Small steps from far away come as near as their chattering allows, and stay: linear decay would not."""
    result = decide_system(built(rhs))
    assert result.reach.everywhere
    record = certificate_of(result)
    assert refused(record) == ""
    claims = record["statement"]["claims"]
    finite = any(claim.get("rate", {}).get("kind") == "finite" for claim in claims)
    assert {"attracts": "everywhere"} in claims
    assert finite or {"arrives": "in finite time"} in claims
    assert not any("finite time" in line for line in left_out(record))
    x = np.array([[9.0, -7.0, 5.0], [-6.0, 8.0, 4.0]]).T[: len(rhs)]
    for step in (1e-2, 1e-3, 1e-4):
        for _ in range(4_000):
            x = x + step * velocity(rhs, x)
    assert np.abs(x).max() < 1e-2


def test_certificates_of_other_degrees_do_not_speak_of_arrival() -> None:
    record = certificate_of(decide_system(built(["-x + y**3", "-y"])))
    assert {"arrives": "in finite time"} not in record["statement"]["claims"]
    claims = [*record["statement"]["claims"], {"arrives": "in finite time"}]
    assert "evidence of the claim" in refused({**record, "statement": {**record["statement"], "claims": claims}})


def test_the_answer_says_why(capsys: pytest.CaptureFixture[str]) -> None:
    check = ns.System(["x", "y"], ["y", "-2*sign(x) - sign(y)"]).check()
    check.to_terminal()
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "in finite time" in text
    assert "homogeneous of degree -1 with the weights x: 2, y: 1" in text
    homogeneity = check.to_dict()["homogeneous"]
    assert (homogeneity["weights"], homogeneity["exact"]["weights"], homogeneity["degree"]) == (
        [2.0, 1.0],
        ["2", "1"],
        -1.0,
    )
