"""Certificates in one state: what the program certifies is accepted without it, what is false is not."""

from __future__ import annotations

import json
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs import system_checker
from nonsmooth.proofs.system_checker import SCALAR_SCHEMA, check_certificate
from nonsmooth.proofs.system_decision import certificate_of, decide_system
from nonsmooth.proofs.systems.system_certificate import NoCertificateError
from tests.proofs import mutants
from tests.proofs.mutants import Record, is_one_line
from tests.proofs.test_scalar_stability import NAMES, built, random_formula
from tests.thorough import thorough

ATTRACTS, STAYS, LEAVES = "asymptotically stable", "stable", "unstable"


def claim(*rhs: str, verdict: str = ATTRACTS, starts: Any = None, at: str = "0", **more: Any) -> Record:
    """A certificate written by hand."""
    own = {"schema": SCALAR_SCHEMA, "states": ["x"], "rhs": [[side] for side in rhs], "at": [at]}
    return {**own, "verdict": verdict, "starts": starts, "notes": {}, **more}


# ---- what is true --------------------------------------------------------------------------------

TRUE = {
    "relay": claim("-sign(x)", starts=["-9", "9"]),
    "flat": claim("-x**3", starts=["-1000", "1000"]),
    "up to another equilibrium": claim("-x + 8*x**3", starts=["-35355/100000", "35355/100000"]),
    "irrational switching": claim("-x*(3 + 2*sign(x**2 - 2))", starts=["-5", "5"]),
    "sliding from jumps": claim("1/2 - sign(x)", starts=["-1", "1"]),
    "arbitrary switching": claim("-sign(x)", "-x**5", starts=["-2", "2"]),
    "elsewhere": claim("2 - x", at="2", starts=["0", "4"]),
    "rests on the left": claim("-relu(x)", verdict=STAYS),
    "everywhere at rest": claim("0", verdict=STAYS),
    "one of two leaves": claim("-x", "x", verdict=LEAVES),
    "leaves on one side": claim("x**2", verdict=LEAVES),
    "no equilibrium": claim("2 - sign(x)", verdict=LEAVES),
    "attracts is stable too": claim("-x", verdict=STAYS),
}


@pytest.mark.parametrize("name", TRUE)
def test_true_claims_are_accepted(name: str) -> None:
    assert check_certificate(TRUE[name]) == ""


def test_the_checker_needs_nothing_else(tmp_path: Path) -> None:
    file = tmp_path / "c.json"
    file.write_text(json.dumps(certificate_of(decide_system(built(["-x + 8*x**3"])))), encoding="utf-8")
    line = [sys.executable, "-I", "-S", str(Path(system_checker.__file__)), str(file)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout.splitlines()[0]) == (0, "valid")
    assert "reaches the point" in done.stdout


@pytest.mark.parametrize("seed", range(40))
def test_random_systems_are_certified(seed: int) -> None:
    result = decide_system(built([random_formula(np.random.default_rng(1000 + seed))]))
    assert certificate_of(result)["verdict"] == str(result.verdict)


def test_square_roots_of_the_state_have_none() -> None:
    with pytest.raises(NoCertificateError, match="sqrt"):
        certificate_of(decide_system(built(["-sqrt(Abs(x))*sgn(x)"])))


# ---- what is false -------------------------------------------------------------------------------

FALSE = {
    "wrong verdict": claim("x"),
    "not unstable": claim("-x", verdict=LEAVES),
    "rest is no attraction": claim("-relu(x)"),
    "rest on both sides": claim("0"),
    "rest is not unstable": claim("0", verdict=LEAVES),
    "no equilibrium": claim("2 - sign(x)", verdict=STAYS),
    "leaves to the left": claim("-x**2", verdict=STAYS),
    "one of two leaves": claim("-sign(x)", "x/1000", verdict=STAYS),
    "one of two rests": claim("-sign(x)", "0"),
    "a larger interval": claim("-x + 8*x**3", starts=["-1/4", "35356/100000"]),
    "an equilibrium inside": claim("-x*(x - 1/2)**2", starts=["-1", "1"]),
    "an irrational equilibrium inside": claim("-x*(x**2 - 2)**2", starts=["-2", "2"]),
    "turned round in a gap": claim("-x*sign((x - 1/3)*(x - 1/3 - 1/1000000))", starts=["-1", "1"]),
    "rests at a jump": claim("-sign(x)*(1 + sign(x - 1/2))/2 - relu(1/2 - x)*sign(x)", starts=["-1", "1"]),
    "slides off the point": claim("-sign(x)*sign(1/2 - x)", starts=["-1", "1"]),
    "starts of a stable point": claim("-x", verdict=STAYS, starts=["-1", "1"]),
    "starts beside the point": claim("-x", starts=["1", "2"]),
    "starts in disorder": claim("-x", starts=["1", "-1"]),
    "another point": claim("-x", at="1"),
}


@pytest.mark.parametrize("name", FALSE)
def test_false_claims_are_rejected(name: str) -> None:
    assert check_certificate(FALSE[name])


MALFORMED: list[Any] = [
    {"schema": SCALAR_SCHEMA}, {**claim("-x"), "more": 1}, claim(), claim("-x", states=["x", "y"]), claim("-y"),
    claim("-x", at="nan"), claim("-x", at=""), claim("-x", starts=[-1, 1]), claim("-x", starts=["-1"]),
    claim("-x", starts=["-inf", "inf"]), claim("-x", starts="11"), claim("-x", verdict="holds"), claim("-x/0"),
    claim("-x*9e999999"), claim("-x**99"), claim("__import__('os')"), claim("-" * 5000 + "x"), claim("x.real"),
    claim("(" * 900 + "x" + ")" * 900), claim("-x", states=[["x"]]), claim("-x", rhs=["-x"]),
    claim("-x", rhs=[["-x"] * 2]),
    claim("-x", starts=["-1", "1/0"]), claim("-" + "9" * 500 + "*x"), claim("-x", at="9" * 5000),
]  # fmt: skip


@pytest.mark.parametrize("data", MALFORMED, ids=range(len(MALFORMED)))
def test_malformed_data_are_rejected_in_one_line(data: Any) -> None:
    refused = check_certificate(data)
    assert is_one_line(refused)


def test_no_formula_keeps_the_checker_busy() -> None:
    signs = " + ".join(f"sign(x**16 - {k}*x**15 - 1/{k + 7})*x**{k % 16}" for k in range(1, 60))
    assert check_certificate(claim(f"-x - ({signs})/9", starts=["-99", "99"]))


# ---- mutations -----------------------------------------------------------------------------------


def mutated(record: Record, source: random.Random) -> Record:
    """One digit, sign or operator of one text changed."""
    return mutants.mutant(record, ("rhs", "at", "verdict", "starts"), "x", source)


def speeds(record: Record, place: float) -> list[float]:
    """The literal fields at a place, in floats: the test's own reading of its own certificates."""
    own = {**NAMES, "sign": NAMES["sgn"], "x": place}
    return [float(eval(side, {"__builtins__": {}}, dict(own))) for (side,) in record["rhs"]]  # noqa: S307  # our own text


def as_float(text: str) -> float:
    top, _, bottom = text.partition("/")
    return int(top) / int(bottom or 1)


def assert_true(record: Record, source: random.Random) -> None:
    """The literal fields beside the point, and at many starts of the interval."""
    at = as_float(record["at"][0])
    beside = [[side * v for v in speeds(record, at + side * 1e-7)] for side in (1, -1)]
    if record["verdict"] == LEAVES:
        limits = [*beside[0], *(-v for v in beside[1])]
        assert max(map(max, beside)) > 0 or min(limits) > 0 or max(limits) < 0, record
        return
    assert max(map(max, beside)) <= 0, record
    if record["starts"] is None:
        return
    low, high = map(as_float, record["starts"])
    for place in (source.uniform(low, high) for _ in range(40)):
        assert max(v * np.sign(place - at) for v in speeds(record, place)) < 1e-9, record


def attack(count: int, seed: int) -> int:
    """How many of many mutants are accepted; each is put to the test."""
    originals = list(TRUE.values())
    return mutants.attack(originals, mutated, check_certificate, assert_true, count, seed)


@thorough  # the small one: test_false_claims_are_rejected
def test_mutants_are_rejected_or_still_true() -> None:
    assert 0 < attack(1_000, 1) < 1_000
