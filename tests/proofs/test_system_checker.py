"""The stand-alone checker of plain systems: what the program certifies is accepted, what is false is not."""

from __future__ import annotations

import json
import random
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs import system_checker
from nonsmooth.proofs.system_checker import check_certificate
from nonsmooth.proofs.systems.system_certificate import NoCertificateError, build_system_certificate, left_out
from nonsmooth.proofs.systems.system_stability import system_check
from nonsmooth.symbolic.files.system_file import load_system
from tests.proofs import mutants
from tests.proofs.mutants import Record, is_one_line
from tests.proofs.switched_oracle import random_relay
from tests.thorough import thorough

Rhs: TypeAlias = Callable[[float, float], tuple[float, float]]

RELAYS = ns.System(["x", "y"], ["-sign(x) + y/4", "-sign(y) - x/4"], radius="1/2")


def certificate_of(system: ns.System) -> Record:
    return build_system_certificate(system_check(system.system))


def claim(rhs: list[str], lyapunov: Any, verdict: str = "asymptotically stable", **more: Any) -> Record:
    """A certificate written by hand."""
    own = {"schema": system_checker.SCHEMA, "states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"], "radius": "1"}
    return {**own, "lyapunov": lyapunov, "verdict": verdict, "level": None, "rate": None, "notes": {}, **more}


# ---- what is true --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["relay-oscillator-damped", "flower"])
def test_built_in_systems_are_accepted_without_the_program(name: str, tmp_path: Path) -> None:
    file = tmp_path / "c.json"
    file.write_text(json.dumps(build_system_certificate(system_check(load_system(name)))), encoding="utf-8")
    line = [sys.executable, "-I", "-S", str(Path(system_checker.__file__)), str(file)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout.splitlines()[0]) == (0, "valid")


def test_region_and_rate_are_shown_and_larger_ones_are_not() -> None:
    record = certificate_of(RELAYS)
    assert record["level"] == "1/4"
    assert record["rate"] == {"kind": "exponential", "kappa": "15/4"}
    assert "border" in check_certificate({**record, "level": "257/1024"})
    assert check_certificate({**record, "rate": {"kind": "exponential", "kappa": "17/4"}})
    assert check_certificate({**record, "rate": None, "level": None}) == ""


@pytest.mark.parametrize("seed", range(1, 41))
def test_narrow_forms_with_small_higher_terms_are_decided(seed: int) -> None:
    """``l^2/n + m^2 + g`` in random directions l, m: by values at many points of fine polar grids, not by cones."""
    rng = random.Random(seed)
    turn, thin = rng.uniform(0, np.pi), Fraction(1, rng.choice([20, 100, 400]))
    c, s = (Fraction(round(64 * own(turn)), 64) for own in (np.cos, np.sin))
    form = {(2, 0): c * c * thin + s * s, (1, 1): 2 * c * s * (thin - 1), (0, 2): s * s * thin + c * c}
    higher = {(i, 4 - i): thin * Fraction(rng.randint(-8, 8), 8) for i in range(5)}
    polynomial = system_checker.Polynomial({**form, **higher})
    corners = tuple((Fraction(x), Fraction(y), Fraction(1)) for x, y in ((0, 0), (1, 0), (1, 1)))
    angles, sizes = np.linspace(0, np.pi / 4, 4001)[:, None], np.linspace(0.001, 1, 400)[None]
    x, y = sizes + 0 * angles, sizes * np.tan(angles)
    least = (sum(float(own) * x**i * y**j for (i, j), own in polynomial.terms.items()) / (x * x + y * y)).min()
    system_checker.BUDGET.left = system_checker.MAX_WORK // 4
    found = system_checker.proved_sign(polynomial, corners, strict=True)
    assert found == (least > 0) or abs(least) < 1e-3 * float(thin)


def test_a_viscous_pendulum_has_a_certificate_with_its_rate() -> None:
    """``V' <= -7/16 V`` is a form close to zero along one direction, with terms of order four."""
    record = certificate_of(ns.System(["phi", "v"], ["v", "-sin(phi) - v"], radius="1/2"))
    assert record["rate"] == {"kind": "exponential", "kappa": "7/16"}
    assert check_certificate(record) == ""


def test_a_claim_that_is_not_shown_is_left_out_and_named() -> None:
    """Of a rate four times too large nothing is written but that it is missing; verdict and level stand."""
    result = system_check(RELAYS.system)
    assert result.rate is not None
    record = build_system_certificate(replace(result, rate=replace(result.rate, kappa=result.rate.kappa * 4)))
    assert (record["verdict"], record["level"], record["rate"]) == ("asymptotically stable", "1/4", None)
    assert check_certificate(record) == ""
    (rate, _) = left_out(record)
    assert rate.startswith("V' <= -15 V on abs(x), abs(y) <= 1/2")
    assert "required V' below its bound" in rate


def test_what_a_certificate_has_no_words_for_is_named() -> None:
    """A region beyond the square on which V is proved, its rate, and the gain of a disturbance."""
    record = certificate_of(ns.System(["x", "y"], ["-x", "-y - 2*y**2"], radius="1/2"))
    assert (record["radius"], record["level"]) == ("1/32", "1/1024")
    region, rate, gain = left_out(record)
    assert region.startswith("every start with V < 1/4 within abs(x), abs(y) <= 1/2 reaches")
    assert rate.startswith("V' <= -35/64 V where V < 1/8 within abs(x), abs(y) <= 1/2")
    assert gain.startswith("with x' in F + d: V' <= -7/4 V + 3/32 abs(d) on abs(x), abs(y) <= 1/32")


def test_arbitrary_switching_and_growth() -> None:
    switched = ns.System(["x", "v"], [["v", "-2*x - v"], ["v", "-5/2*x - v"]])
    assert certificate_of(switched)["verdict"] == "asymptotically stable"
    assert check_certificate(claim(["x + y", "y - x"], "x**2 + y**2", "unstable")) == ""
    assert check_certificate(claim(["-x + y", "-y - x"], "x**2 + y**2", "unstable"))


@pytest.mark.parametrize("seed", range(12))
def test_random_relays_that_a_v_decides_are_certified(seed: int, load: Any) -> None:
    made = random_relay(seed)
    result = system_check(load(*made.rhs))
    if result.proving is None:
        return
    assert check_certificate(build_system_certificate(result)) == ""


def test_other_verdicts_have_none() -> None:
    with pytest.raises(NoCertificateError, match="received one by fan of cones"):
        build_system_certificate(system_check(load_system("relay-oscillator")))
    with pytest.raises(NoCertificateError, match="rational"):
        build_system_certificate(system_check(load_system("eq-4")))


# ---- what is false -------------------------------------------------------------------------------

FALSE = {
    # V falls in every open cell, but solutions slide outward along the x axis
    "slides outward": claim(["sign(x)", "-3*sign(y)"], "Abs(x) + Abs(y)"),
    # V stands still along solutions that turn for ever
    "turns": claim(["sign(y)", "-sign(x)"], "Abs(x) + Abs(y)"),
    # equilibria on both axes
    "rests on axes": claim(["-Abs(y)*sign(x)", "0"], "x**2 + y**2"),
    "rests on a diagonal": claim(["-x*Abs(x - y)", "-y*Abs(x - y)"], "x**2 + y**2"),
    "rests at a corner": claim(["-sign(x - 1/2)", "-sign(y)"], "Abs(x) + Abs(y)"),
    "not positive": claim(["-x", "-y"], "x**2 - y**2"),
    "zero on a line": claim(["-x", "-y"], "(x - y)**2"),
    "not zero at the point": claim(["-x", "-y"], "x**2 + y**2 + 1"),
    "jumps": claim(["-x", "-y"], "x**2 + y**2 + (1 + sign(x))*(x + 1)/9"),
    "leaves the plane": claim(["-x + x**3", "-y"], "x**2 + y**2", radius=None),
    "one of two fields": {**claim(["-x", "-y"], "x**2 + y**2"), "rhs": [["-x", "-y"], ["x", "-y"]]},
    # each field alone falls, but one above and the other below the x axis slide outward together
    "a pair of two fields": {
        **claim(["-x", "-y"], "Abs(x) + Abs(y)"),
        "rhs": [["sign(x)*(7*sign(y) - 3)/2", "-sign(y)*(2 + sign(y))"],
                ["-sign(x)*(7*sign(y) + 3)/2", "-sign(y)*(2 - sign(y))"]],
    },
}  # fmt: skip


@pytest.mark.parametrize("name", FALSE)
def test_false_claims_are_rejected(name: str) -> None:
    assert check_certificate(FALSE[name])


MALFORMED: list[Any] = [
    None, [], {}, {**claim(["-x", "-y"], "x**2 + y**2"), "more": 1}, claim(["-x"], "x**2 + y**2"),
    claim(["-x", "-z"], "x**2"), claim(["-x", "__import__('os')"], "x**2 + y**2"), claim(["-x", "x.y"], "x**2 + y**2"),
    claim(["-x", "(" * 500 + "y" + ")" * 500], "x**2 + y**2"), claim(["-x", "y**9**9"], "x**2 + y**2"),
    claim(["-x", "9**9999999*y"], "x**2 + y**2"), claim(["-x", "-y"], "x**2 + y**2", radius="-1"),
    claim(["-x", "-y"], "x**2 + y**2", radius=1), claim(["-x", "-y"], "x**2 + y**2", at=["0", "0", "0"]),
    claim(["-x", "-y"], "x**2 + y**2", states=["x", "x"]), claim(["-x", "-y/0"], "x**2 + y**2"),
    claim(["-x", "-y"], "x**2 + y**2", level="0"), claim(["-x", "-y"], "x**2 + y**2", rate={"kind": "fast"}),
    claim(["-x", "-y"], [], ), claim(["-x", "-y"], [{"from": ["1", "0"], "to": ["0", "1"], "V": "x**2 + y**2"}]),
    claim(["-x", "-y"], "x**2 + y**2", verdict="holds"), claim(["sign(x**3 + y**5)", "-y"], "x**2 + y**2"),
]  # fmt: skip


@pytest.mark.parametrize("data", MALFORMED, ids=range(len(MALFORMED)))
def test_malformed_data_are_rejected_in_one_line(data: Any) -> None:
    refused = check_certificate(data)
    assert is_one_line(refused)


def test_no_formula_keeps_the_checker_busy() -> None:
    lines = " + ".join(f"sign(x - {k}*y/7 - 1/{k + 3})*sign(y + {k}*x/5)" for k in range(12))
    assert check_certificate(claim([f"-9*x + {lines}", "-y"], "x**2 + y**2"))
    many = "+".join(f"(x + {k}*y)**16" for k in range(1, 60))
    assert check_certificate(claim([f"-x*({many})", f"-y*({many})"], f"x**2 + y**2 + {many}")) is not None


# ---- mutations -----------------------------------------------------------------------------------


def mutated(record: Record, source: random.Random) -> Record:
    """One digit, sign or operator of one text changed."""
    return mutants.mutant(record, ("rhs", "lyapunov", "radius", "level", "rate", "verdict", "at"), "xy", source)


NAMES = {
    **{"sign": np.sign, "Abs": abs, "Max": max, "Min": min},
    "sat": lambda v, low, high: max(low, min(high, v)),
    "relu": lambda v: max(v, 0.0),
}


def in_floats(text: str) -> Callable[[float, float], float]:
    """The test's own reading of a formula of its own certificates."""
    code = compile(text, "formula", "eval")
    return lambda x, y: float(eval(code, {"__builtins__": {}}, {**NAMES, "x": x, "y": y}))  # noqa: S307  # our own text


def assert_true(record: Record, source: random.Random) -> None:
    """V along Euler paths of the literal fields from random starts, whose steps chatter where solutions slide."""
    fields = [tuple(in_floats(text) for text in side) for side in record["rhs"]]
    potential = in_floats(record["lyapunov"])
    grows = record["verdict"] == "unstable"
    half = 1.0 if record["radius"] is None else _float(record["radius"])
    at = [_float(text) for text in record["at"]]
    for _ in range(6):
        x, y = (source.uniform(-half, half) * 0.9 for _ in range(2))
        f, g = source.choice(fields)
        size = max(abs(f(x + at[0], y + at[1])), abs(g(x + at[0], y + at[1])), 1e-9)
        step, first = 1e-4 * half / size, potential(x, y)
        assert first > 0
        for _ in range(150):
            if max(abs(x), abs(y)) < 0.02 * half or max(abs(x), abs(y)) > half:
                break
            x, y = x + step * f(x + at[0], y + at[1]), y + step * g(x + at[0], y + at[1])
        last = potential(x, y)
        slack = 1e-3 * first
        assert (last > first - slack) if grows else (last < first + slack), record


def _float(text: str) -> float:
    top, _, bottom = text.partition("/")
    return int(top) / int(bottom or 1)


def attack(count: int, seed: int) -> int:
    """How many of many mutants are accepted; each is put to the test."""
    originals = [
        certificate_of(RELAYS),
        certificate_of(ns.System(["x", "y"], ["sign(y)", "-sign(x) - sign(y)/2"], radius="1/2")),
        certificate_of(ns.System(["x", "y"], ["y", "x - sat(3*x + y, -1/2, 1/2)"], radius="1/2")),
        claim(["x + y", "y - x"], "x**2 + y**2", "unstable"),
    ]
    return mutants.attack(originals, mutated, check_certificate, assert_true, count, seed)


@thorough  # the small one: test_false_claims_are_rejected
def test_mutants_are_rejected_or_still_true() -> None:
    accepted = attack(160, 1)
    assert 0 < accepted < 160
