"""Cascades, and surfaces on which solutions slide: systems that are decided by some of their states."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import TypeAlias

import pytest

import nonsmooth as ns
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import (
    StabilityResult,
    checked_point,
    decide_by_cascade,
    decide_by_sliding,
    decide_system,
)
from nonsmooth.proofs.systems.findings import CheckedPoint, Finding, Known, Method, Reach
from nonsmooth.reports.exchange.obligations import obligations_of
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.certificates.inclusion import contradiction
from tests.thorough import few

Decide: TypeAlias = Callable[[CheckedPoint, Known], Finding | None]

ATTRACTS, RESTS, LEAVES = Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE

# No polynomial V is known for these; what the states do one after the other is by hand.
CASCADES = {
    "a cube drives a cube": (["-x**3", "-y**3 + x"], None, ATTRACTS),
    "elsewhere": (["-(x - 1)**3", "-(y + 2)**3 + x - 1"], [1, -2], ATTRACTS),
    "rotation drives": (["y", "-x", "-z**3 + x*z + x*y"], None, RESTS),
    "a sine of what drives": (["-x**3", "-y**3 + sin(x)"], None, ATTRACTS),
}
SLIDES = {
    "zero dynamics of third degree": (["y", "z", "-sign(x**3 + y + z)"], None, ATTRACTS),
    "drifts along the plane": (["y", "z", "-x - 2*y - 2*z - sign(z)/2"], None, LEAVES),
    "unstable zero dynamics": (["y", "z", "w", "-sign(-x + 3*y + 3*z + w) + x*y"], None, LEAVES),
    "slides, then a cascade": (["-sign(x)", "-y**3 + x", "-z**5 + y*z + x"], None, ATTRACTS),
    "elsewhere": (["y - 1", "z + 2", "-sign((x - 3)**3 + y + z + 1)"], [3, 1, -2], ATTRACTS),
}


def system(rhs: list[str], at: list[int] | None = None) -> SwitchedSystem:
    return ns.System(list("xyzw")[: len(rhs)], rhs, at=at).system


@pytest.mark.parametrize("name", CASCADES)
def test_states_that_drive_others(name: str) -> None:
    require_shown(decide_by_cascade, CASCADES[name], Method.CASCADE)


@few(3)
@pytest.mark.parametrize("name", SLIDES)
def test_surfaces_on_which_solutions_slide(name: str) -> None:
    require_shown(decide_by_sliding, SLIDES[name], Method.SLIDING)


def require_shown(decide: Decide, case: tuple[list[str], list[int] | None, Translation], method: Method) -> None:
    """One of the two theorems decides by itself, with a certificate."""
    rhs, at, truth = case
    point = checked_point(system(rhs, at))
    found = decide(point, Known())
    assert found is not None
    assert (found.verdict, found.theorem) == (truth, method)
    assert {"stability": str(truth)} in certificate_of(decided_by(point, found))["statement"]["claims"]


def test_both_decide_where_nothing_else_does() -> None:
    for name, cases, method in (
        ("rotation drives", CASCADES, Method.CASCADE),
        ("zero dynamics of third degree", SLIDES, Method.SLIDING),
    ):
        rhs, at, truth = cases[name]
        result = decide_system(system(rhs, at))
        assert (result.verdict, result.method) == (truth, method)


def test_the_field_on_the_surface_is_said() -> None:
    assert (
        "x**3 + y + z = 0 and slide there, where x' = y, y' = -x**3 - y"
        in decide_system(system(SLIDES["zero dynamics of third degree"][0])).reason
    )


def test_what_parts_ask_is_exported() -> None:
    certificate = certificate_of(decide_system(system(SLIDES["zero dynamics of third degree"][0])))
    names = [own.name for own in obligations_of(certificate, "relay")]
    assert names
    assert all(name.startswith("1 sliding: part 1: ") for name in names)


# What is driven only rests; jumps with what drives it; is driven on the way to a surface that it comes to.
NOTHING = [
    (["-x**3", "x"], decide_by_cascade),
    (["-x**3", "2*y*sign(x)**2 - y"], decide_by_cascade),
    (["y", "-x - y"], decide_by_cascade),
    (["y", "sign(x + y)"], decide_by_sliding),
    (["2*x*sign(y)**2 - x", "-sign(y)"], decide_by_sliding),
    (["x", "-sign(x + y**3)"], decide_by_sliding),
]


@pytest.mark.parametrize(("rhs", "decide"), NOTHING)
def test_nothing_is_said(rhs: list[str], decide: Decide) -> None:
    assert decide(checked_point(system(rhs)), Known()) is None


@pytest.mark.parametrize("seed", range(40))
def test_random_systems_are_not_contradicted(seed: int) -> None:
    """By solutions of the inclusion that are followed in floats, of whatever one of the two theorems says."""
    source = random.Random(seed)
    for rhs, decide in ((random_relay(source), decide_by_sliding), (random_cascade(source), decide_by_cascade)):
        point = checked_point(system(rhs))
        found = decide(point, Known())
        if found is not None:
            certificate = certificate_of(decided_by(point, found))
            assert not contradiction(certificate["statement"]), rhs


def decided_by(point: CheckedPoint, found: Finding) -> StabilityResult:
    return StabilityResult(point.system, point.equilibrium, (found,), None, Reach())


def random_relay(source: random.Random) -> list[str]:
    """A relay that pushes to a surface, in three states, with nonlinear terms."""
    c, a = (source.choice([-2, -1, 1, 2]) for _ in range(2))
    first, second = (source.choice(["y", "-x", "x", "-y", "-x**3", "x*y", "z"]) for _ in range(2))
    push, curve = source.choice(["x", "-z", "y**2", "x*z"]), source.choice(["0", "x**2", "y**3"])
    return [f"{first} + {c}*z", f"{second} - {source.choice([1, 2])}*y", f"{push} - 2*sign({a}*x + y + 3*z + {curve})"]


def random_cascade(source: random.Random) -> list[str]:
    """Three states, each driven by those before, with nonlinear terms."""
    falls = [source.choice(["-{}**3", "-sign({})", "-{}", "-{}*Abs({})", "{}"]) for _ in range(3)]
    drives = [
        "0",
        source.choice(["x", "x**2", "y*x", "Abs(x)"]),
        source.choice(["y", "x*z", "z**2*x", "sat(y, -1, 1)"]),
    ]
    pairs = zip("xyz", zip(falls, drives, strict=True), strict=True)
    return [f"{fall.format(name, name)} + {drive}" for name, (fall, drive) in pairs]
