"""What the theory of the plane leaves open and the kernel decides: verdicts, certificates, forged ones."""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel.quotients import proposed
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.findings import Method
from tests.certificates.inclusion import contradiction
from tests.thorough import keep

SIZE = 1 << 20  # of a file, for which there is enough work


@cache
def decided(*rhs: str) -> StabilityResult:
    return decide_system(ns.System(list("xyzuv"[: len(rhs)]), list(rhs)).system)


@pytest.mark.parametrize(
    "rhs",
    keep(
        2,
        [
            "x + y**2; -y**3",
            "x*y; x**2 + y**2",
            "y; sign(x) - sign(y)",  # V = -x y falls where it is negative
            "y; -2*sign(x) + y**3",  # energy grows, and nothing stays where it does not
            "y; -sign(x) + y/2; -z",  # the same energy beside a third state
        ],
    ),
)
def test_instability(rhs: str) -> None:
    result = decided(*rhs.split("; "))
    assert result.verdict is Translation.UNSTABLE
    assert not contradiction(certificate_of(result)["statement"])


def test_a_center_manifold_has_a_rate_where_its_v_falls_everywhere() -> None:
    """``u' = -u^3`` on it, so V falls as ``1/t`` and no faster; the certificate says so with the V."""
    result = decided("y", "-x**3 - y")
    rate, near = result.reach.rate, result.reach.near
    assert (result.method, result.reach.everywhere) == (Method.CENTER, True)
    assert rate is not None
    assert near is not None
    assert (rate.decay.name, rate.function != "") == ("ALGEBRAIC", True)
    statement = certificate_of(result)["statement"]
    stated = [own["rate"] for own in statement["claims"] if "rate" in own]
    assert [(own["kappa"], own["function"]) for own in stated] == [(str(rate.kappa), rate.function)]
    assert not contradiction(statement)


def test_a_solution_in_a_thin_cell() -> None:
    """For ``0 < y < x^2`` the field is ``x^2, -y``: x = 1 / (1 / x_0 - t) grows while y falls, so it stays there."""
    result = decided("(1 + sign(y)*sign(x**2 - y))*x**2/2 - x*(1 - sign(y)*sign(x**2 - y))", "-y")
    assert (result.verdict, result.method) == (Translation.UNSTABLE, Method.ESCAPE)
    assert result.check()


def test_a_mixture_of_stable_systems_may_leave() -> None:
    """Under arbitrary switching: both are Hurwitz, and half of each has the eigenvalue 3/2."""
    system = ns.System(["x", "y"], [["-x + 5*y", "-y"], ["-x", "5*x - y"]]).system
    result = decide_system(system)
    assert (result.verdict, result.method) == (Translation.UNSTABLE, Method.ESCAPE)
    assert result.check()
    calm = ns.System(["x", "y"], [["-x + y", "-y"], ["-x", "y*0 + x - y"]]).system
    assert decide_system(calm).verdict is Translation.ASYMPTOTICALLY_STABLE


@pytest.mark.parametrize(
    "rhs", keep(1, [["y", "-sign(x) - y/2 + z", "-z"], ["y - x", "-sign(x) + z", "-z - y"]]), ids="; ".join
)
def test_energies_of_three_states(rhs: list[str]) -> None:
    result = decided(*rhs)
    assert (result.verdict, result.method) == (Translation.ASYMPTOTICALLY_STABLE, Method.INVARIANCE)
    assert result.check()


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize("rhs", keep(2, ["0; -y", "-x*y; -y + x**2", "y; -sign(x) - sign(y)", "y; -2*sign(x) - y**3"]))
def test_what_stays_near_is_not_called_unstable(rhs: str) -> None:
    """Beside points from which solutions leave: with another sign, and where only some move."""
    system = ns.System(["x", "y"], rhs.split("; ")).system
    assert decide_system(system).verdict is not Translation.UNSTABLE


@pytest.fixture(scope="module")
def product() -> dict[str, Any]:
    result = decided("y", "sign(x) - sign(y)")
    assert result.method is Method.INSTABILITY
    certificate = certificate_of(result)
    assert not refusal(certificate, SIZE)
    return certificate


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("speed", "0"),
        ("speed", "-1/16"),
        ("speed", "1000000"),
        ("speed", None),
        ("second", {"functions": [], "zeros": {}}),
        ("function", "x*y"),
        ("function", "-(x*y) - x"),
        ("direction", ["1", "-1"]),
    ],
)
def test_forged_products_are_rejected(key: str, value: object, product: dict[str, Any]) -> None:
    forged = deepcopy(product)
    forged["evidence"][0]["hypotheses"][key] = value
    assert refusal(forged, SIZE)


def test_functions_that_do_not_change_are_not_proposed() -> None:
    assert not list(proposed(np.zeros((3, 2))))
