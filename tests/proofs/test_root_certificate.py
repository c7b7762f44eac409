"""Certificates about signed roots of states: super-twisting and others, and what would be true of the roots alone."""

from __future__ import annotations

import copy
import random
from functools import cache
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.system_checker import check_certificate
from nonsmooth.proofs.systems.system_certificate import build_system_certificate
from nonsmooth.proofs.systems.system_stability import system_check
from tests.proofs import mutants
from tests.proofs.mutants import Record, is_one_line
from tests.proofs.test_square_roots import NAMES, ROOT, built
from tests.proofs.test_system_checker import claim
from tests.thorough import thorough

TWISTING = [f"-2*{ROOT} + y", "-sgn(x)"]
WITH_REGION = [f"-3*{ROOT} + y + sgn(y)/9", "-2*sgn(x)"]


def by_roots(rhs: list[str], lyapunov: str, verdict: str = "asymptotically stable", **more: Any) -> Record:
    return {**claim(rhs, lyapunov, verdict), "radius": "1/2", "roots": ["x"], **more}


def certified(rhs: list[str]) -> Record:
    """The certificate of a system about the origin; a copy of one that is built once."""
    return copy.deepcopy(_certified(tuple(rhs)))


@cache
def _certified(rhs: tuple[str, ...]) -> Record:
    return build_system_certificate(system_check(built(list(rhs))))


# ---- what is true --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "rhs", [TWISTING, WITH_REGION, [f"-3/2*{ROOT} + y - x", "-11/10*sgn(x) - x"], ["y", f"-2*sgn(y + {ROOT})"]]
)
def test_super_twisting_and_its_kin_are_certified(rhs: list[str]) -> None:
    record = certified(rhs)
    assert (record["verdict"], record["rhs"], record["roots"]) == ("asymptotically stable", [rhs], ["x"])
    assert check_certificate({**record, "verdict": "unstable", "level": None})


def test_two_roots_away_from_zero() -> None:
    system = built(["1/2 - sqrt(Abs(x))", "sqrt(Abs(x)) - sqrt(Abs(y))"], equilibrium=["1/4", "1/4"])
    record = build_system_certificate(system_check(system))
    assert (record["at"], record["roots"]) == (["1/4", "1/4"], ["x", "y"])
    assert check_certificate({**record, "at": ["1/2", "1/4"]}) == "switching lines in rationals"


# ---- what is false -------------------------------------------------------------------------------

FALSE = {
    # in the time of the roots nothing moves on x = 0; in the stated time y grows there
    "slides outward where the root is zero": by_roots(["-sgn(x)", "y/10"], "root_x**2 + y**2", "stable"),
    "slides along a part of it": by_roots([f"-{ROOT} + Max(y - 1/4, 0)", "y/9"], "root_x**2 + y**2/9", "stable"),
    "damped the wrong way": by_roots([f"{ROOT} + y", "-sgn(x)"], "root_x**2 + y**2/2"),
    "not damped": by_roots(["y", "-sgn(x)"], "root_x**2 + y**2/2"),
    "roots of another state": {**by_roots(TWISTING, "x**2 + y**2"), "roots": ["y"]},
    "V of the state": by_roots(TWISTING, "x**2 + y**2"),
    "no equilibrium": by_roots([f"1 - {ROOT}", "-y"], "root_x**2 + y**2"),
}


@pytest.mark.parametrize("name", FALSE)
def test_false_claims_are_rejected(name: str) -> None:
    assert check_certificate(FALSE[name])


def test_the_reason_is_that_nothing_crosses() -> None:
    name = "slides outward where the root is zero"
    assert check_certificate(FALSE[name]) == "velocities that cross where a root is zero"


CHANGES: list[dict[str, Any]] = [
    {"roots": []}, {"roots": None}, {"roots": ["z"]}, {"roots": ["x", "x"]}, {"roots": "x"}, {"roots": [1]},
    {"rate": {"kind": "finite", "kappa": "1/100"}}, {"curves": []}, {"level": "1/2"}, {"radius": None},
    {"rhs": [[f"-3*{ROOT} + y + sgn(y)/9 + sqrt(x)", "-2*sgn(x)"]]}, {"rhs": [["-sqrt(Abs(y))", "-2*sgn(x)"]]},
    {"rhs": [["-sqrt(Abs(x), 2)", "-y"]]}, {"rhs": [["-sqrt()", "-y"]]}, {"rhs": [["-sqrt(2)", "-y"]]},
    {"states": ["x", "root_x"]}, {"lyapunov": "sqrt(Abs(root_x)) + y**2"}, {"at": ["1/3", "0"]},
]  # fmt: skip


@pytest.mark.parametrize("change", CHANGES, ids=range(len(CHANGES)))
def test_other_claims_are_rejected_in_one_line(change: dict[str, Any]) -> None:
    refused = check_certificate({**certified(WITH_REGION), **change})
    assert is_one_line(refused)


# ---- mutations -----------------------------------------------------------------------------------


def mutated(record: Record, source: random.Random) -> Record:
    """One digit, sign or operator of one text changed."""
    return mutants.mutant(record, ("rhs", "lyapunov", "radius", "verdict", "level", "roots"), "xy", source)


def assert_true(record: Record, source: random.Random) -> None:
    """Euler polygons of the stated fields from small starts: they end nearer, or for instability farther."""
    own = {**NAMES, "sign": np.sign}
    (rhs,) = record["rhs"]
    angles = np.array([source.uniform(0, 2 * np.pi) for _ in range(6)])
    size = 0.05
    x, y = np.sign(np.cos(angles)) * (size * np.cos(angles)) ** 2, size * np.sin(angles)
    for _ in range(12_000):
        f, g = (eval(text, {"__builtins__": {}}, {**own, "x": x, "y": y}) for text in rhs)  # noqa: S307  # our own text
        x, y = np.clip(x + 1e-4 * f, -9, 9), np.clip(y + 1e-4 * g, -9, 9)
    last = float(np.maximum(np.sqrt(np.abs(x)), np.abs(y)).max() / size)
    assert last < 2 if record["verdict"] != "unstable" else last > 1, record


def attack(count: int, seed: int) -> int:
    """How many of many mutants are accepted; each is put to the test."""
    originals = [
        by_roots(TWISTING, "root_x**2 - root_x*y/2 + y**2"),
        certified(WITH_REGION),
        certified([f"-3/2*{ROOT} + y - x", "-11/10*sgn(x) - x"]),
    ]
    return mutants.attack(originals, mutated, check_certificate, assert_true, count, seed)


@thorough  # the small one: test_false_claims_are_rejected
def test_mutants_are_rejected_or_still_true() -> None:
    assert 0 < attack(40, 1) < 40
