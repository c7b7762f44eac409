"""Certificates by LaSalle's principle: energies of damped systems, and systems that keep some solution."""

from __future__ import annotations

import random
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.proofs.system_checker import check_certificate
from nonsmooth.proofs.system_decision import certificate_of
from nonsmooth.proofs.systems.conclusion import Method
from nonsmooth.proofs.systems.system_certificate import NoCertificateError, build_system_certificate
from nonsmooth.proofs.systems.system_stability import SystemResult, system_check
from tests.proofs import mutants
from tests.proofs.mutants import Record, is_one_line
from tests.proofs.test_system_checker import claim, in_floats
from tests.thorough import thorough


def energy(friction: str, potential: str, curves: list[str] | None = None, **more: Any) -> Record:
    """A certificate of ``x' = y, y' = -friction`` by hand."""
    own = claim(["y", f"-({friction})"], f"y**2/2 + {potential}", **{"radius": "1/2", **more})
    return {**own, "curves": ["y"] if curves is None else curves}


# ---- what is true --------------------------------------------------------------------------------

TRUE = {
    "cubic": energy("x + y**3", "x**2/2"),
    "hints are no proofs": energy("x + y**3", "x**2/2", ["y", "y", "3", "0", "x - y**2"]),
    "relay": energy("sign(x) + sign(y)*y**2", "Abs(x)"),
    "one quarter without friction": energy("x + relu(y)**3", "x**2/2"),
    "stiffening": energy("x**3 + y**3", "x**4/4"),
    "with a region": energy("x + y**3", "x**2/2", level="1/8"),
    "in the plane": {**energy("x + y**3", "x**2/2"), "radius": None},
}


@pytest.mark.parametrize("name", TRUE)
def test_true_claims_are_accepted(name: str) -> None:
    assert check_certificate(TRUE[name]) == ""


@pytest.mark.usefixtures("strict_search")
@pytest.mark.parametrize("friction", ["sign(x) + y**3", "x**3 + y**3", "x*Abs(x) + y**3", "2*x + Abs(x) + y**3"])
def test_what_the_principle_decides_is_certified(friction: str) -> None:
    result = system_check(ns.System(["p", "q"], ["q", f"-({friction})".replace("x", "p").replace("y", "q")]).system)
    assert result.method is Method.INVARIANCE
    record = build_system_certificate(result)
    assert record["curves"] == ["q"]
    assert check_certificate({**record, "verdict": "stable"})
    without = {key: value for key, value in record.items() if key != "curves"}
    assert check_certificate(without)
    assert check_certificate({**without, "verdict": "stable", "level": None, "rate": None}) == ""


def test_where_a_searched_v_is_not_certified_the_stated_one_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """The V that is searched for ``x + y**3`` falls strictly, of degree 4, and takes more than the checker's limits."""
    result = system_check(ns.System(["x", "y"], ["y", "-x - y**3"]).system)
    assert result.method is Method.LYAPUNOV

    def limited(asked: SystemResult) -> Record:
        if asked.searched is not None:
            raise NoCertificateError("required a proof within the limits of this checker")
        return build_system_certificate(asked)

    monkeypatch.setattr("nonsmooth.proofs.system_decision.build_system_certificate", limited)
    record = certificate_of(result)
    assert (record["verdict"], record["lyapunov"]) == ("asymptotically stable", "x**2 + y**2")
    assert (record["curves"], record["level"]) == (["y"], None)
    with pytest.raises(NoCertificateError, match="limits"):  # the stated V of a relay rises: nothing stands beside
        certificate_of(system_check(ns.System(["x", "y"], ["y", "-sgn(x) - y"]).system))


@thorough  # the small one is above
def test_a_searched_v_beyond_the_checker() -> None:
    result = system_check(ns.System(["x", "y"], ["y", "-x - y**3"]).system)
    with pytest.raises(NoCertificateError, match="limits"):
        build_system_certificate(result)
    assert certificate_of(result)["lyapunov"] == "x**2 + y**2"


# ---- what is false -------------------------------------------------------------------------------

FALSE = {
    "nothing falls": energy("x", "x**2/2"),
    "nothing falls, relay": energy("sign(x)", "Abs(x)"),
    "a segment of rest": energy("x + sign(y)", "x**2/2"),
    "a short segment of rest": energy("x + sign(y)/1000 + y", "x**2/2"),
    "another equilibrium": energy("x - 4*x**3 + y**3", "x**2/2 - x**4"),
    "an equilibrium inside": energy("x*(4*x - 1)**2 + y**3", "4*x**4 - 8*x**3/3 + x**2/2"),
    "orbits below the dead zone": energy("x + relu(y - 1/8)", "x**2/2"),
    # |x| + |y| = 1/4 is an orbit on which V' = 0
    "a limit cycle": {
        **claim(
            [
                "sign(y) - sign(x)*Abs(Abs(x) + Abs(y) - 1/4)",
                "-sign(x) - sign(y)*Abs(Abs(x) + Abs(y) - 1/4)",
            ],
            "Abs(x) + Abs(y)",
        ),
        "curves": ["x + y - 1/4", "x - y - 1/4", "x + y + 1/4", "x - y + 1/4"],
    },
    "a dead disc": energy("x + y*(1 + sign(x**2 + y**2 - 1/16))", "x**2/2"),
    "grows": energy("x - y**3", "x**2/2"),
    "rests on an axis": {**claim(["-x", "0"], "x**2 + y**2"), "curves": ["x"]},
    "rests on a ray": {**claim(["-x", "-relu(y)"], "x**2 + y**2"), "curves": ["x", "y"]},
    "turns in a level square": {**claim(["sign(y)", "-sign(x)"], "Abs(x) + Abs(y)"), "curves": []},
    "a line of equilibria": {**claim(["y - x", "x - y"], "x**2 + y**2"), "curves": ["x - y"]},
    "one of two fields": {**energy("x + y**3", "x**2/2"), "rhs": [["y", "-x - y**3"], ["y", "-x"]]},
    "a larger level": energy("x + y**3", "x**2/2", level="1/7"),
    "unstable": energy("x + y**3", "x**2/2", verdict="unstable"),
}


def test_the_reason_is_the_orbit() -> None:
    assert check_certificate(FALSE["a limit cycle"]) == "finitely many points of a level of V with V' = 0"


SLOW = "a short segment of rest"  # the small one: a segment of rest


@pytest.mark.parametrize("name", [pytest.param(name, marks=thorough if name == SLOW else ()) for name in FALSE])
def test_false_claims_are_rejected(name: str) -> None:
    assert check_certificate(FALSE[name])


CURVES: list[Any] = [None, "y", [1], ["sign(y)"], ["z"], ["y"] * 999, [["y"]], ["y**99"], ["("], {"y": "y"}]


@pytest.mark.parametrize("curves", CURVES, ids=range(len(CURVES)))
def test_malformed_curves_are_rejected_in_one_line(curves: Any) -> None:
    refused = check_certificate({**TRUE["cubic"], "curves": curves})
    assert is_one_line(refused)


# ---- mutations -----------------------------------------------------------------------------------


def mutated(record: Record, source: random.Random) -> Record:
    """One digit, sign or operator of one text changed."""
    return mutants.mutant(record, ("rhs", "lyapunov", "radius", "verdict", "level", "curves"), "xy", source)


def followed(f: Any, g: Any, x: float, y: float, step: float) -> tuple[float, float]:
    """One step of the midpoint rule; one that changes the sign of x ends there, unless that is at once."""
    for _ in range(2):
        a, b = f(x + step / 2 * f(x, y), y + step / 2 * g(x, y)), g(x + step / 2 * f(x, y), y + step / 2 * g(x, y))
        end = (x + step * a, y + step * b)
        share = abs(x) / (abs(x) + abs(end[0])) if x * end[0] < 0 else 1.0
        if not 1e-3 < share < 1:
            break
        step *= share * (1 + 1e-9)
    return end


def assert_true(record: Record, source: random.Random) -> None:
    """Paths from near the point: V does not rise, and between two late times a path moves, unless it has arrived."""
    if record["verdict"] != "asymptotically stable":
        return
    (texts,) = record["rhs"]
    f, g = map(in_floats, texts)
    potential = in_floats(record["lyapunov"])
    top, _, bottom = (record["radius"] or "1/2").partition("/")
    half, step = min(int(top) / int(bottom or 1), 0.5), 2e-3
    x, y = (source.choice((-1, 1)) * source.uniform(0.1, 0.4) * half for _ in range(2))
    first, places = potential(x, y), []
    for k in range(8_000):
        x, y = followed(f, g, x, y, step)
        if k % 1_000 == 999:
            places.append((x, y))
        if max(abs(x), abs(y)) > 1.5 * half:
            return  # left the domain: nothing is claimed of such starts
    assert potential(x, y) < first * (1 + 1e-2) + 1e-6, record
    (a, b), last = places[-2], max(abs(x), abs(y))
    assert last < 0.02 * half or max(abs(x - a), abs(y - b)) > 1e-2 * last, record


def attack(count: int, seed: int) -> int:
    """How many of many mutants are accepted; each is put to the test."""
    originals = list(TRUE.values())
    return mutants.attack(originals, mutated, check_certificate, assert_true, count, seed)


@thorough  # the small one: test_false_claims_are_rejected
def test_mutants_are_rejected_or_still_true() -> None:
    assert 0 < attack(120, 1) < 120
