"""Evidence by what acts near the point: fans, linearizations, points that are no equilibria, beside floats."""

from __future__ import annotations

import json

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.cells import Inclusion, read_system
from nonsmooth.proofs.checker.statements import VERSION
from nonsmooth.proofs.kernel.cells import BeyondReachError, sharpened, stated_cells
from nonsmooth.proofs.kernel.fans import show_by_fan
from nonsmooth.proofs.kernel.first_terms import leading_direction, show_departure_of
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.proofs.theorem_searches import show_verdict
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.oracles.mutants import Record, is_one_line
from tests.plain import refused
from tests.proofs.switched_oracle import Judge, random_fan, spread
from tests.thorough import but, few, thorough

ATTRACTS, STABLE, UNSTABLE = "asymptotically stable", "stable", "unstable"
TURN = ["sign(y)", "-sign(x) - sign(y)/2"]

KNOWN = {
    "turns outward": (["sign(y)", "-sign(x) + sign(y)/2"], UNSTABLE, "instability"),
    "turns inward": (TURN, ATTRACTS, "lyapunov"),
    "turns inward, higher terms": (["sign(y) + 5*x**2", "-sign(x) - sign(y)/2 + 9*x"], ATTRACTS, "lyapunov"),
    "turns inward, curved": (["sign(y - x**2)", "-sign(x) - sign(y - x**2)/2"], ATTRACTS, "lyapunov"),
    "closed orbits": (["sign(y)", "-sign(x)"], STABLE, "lyapunov"),
    "equilibria on a line": (["0", "-sign(y)"], STABLE, "lyapunov"),
    "slides home where it repels": (
        ["sign(x)*(3*sign(y + Abs(x)) - 1)/2", "-1 - 2*sign(y + Abs(x))"], ATTRACTS, "lyapunov"
    ),
    "slides away": (["sign(x)", "-3*sign(y)"], UNSTABLE, "escape"),
    "no equilibrium": (["1 + sign(x)/2", "y"], UNSTABLE, "departure"),
    "no equilibrium beside a curve": (["-sign(x**3 - x**2 - y**2)", "-y"], UNSTABLE, "departure"),
    "saddle beside curves": (["x + relu(y)**2", "-y"], UNSTABLE, "instability"),
    "center and an unstable direction": (["y", "x**3", "z"], UNSTABLE, "instability"),
    "node beside curves": (["-x + relu(y)**2", "-2*y + Abs(x)*x"], ATTRACTS, "lyapunov"),
    "twisting outward": (["y", "-3*sign(x) + 2*sign(y)"], UNSTABLE, "instability"),
    "twisting inward": (["y", "-3*sign(x) - sign(y) + x"], ATTRACTS, "lyapunov"),
    "relay that is pushed": (["y", "-sign(x) + y"], UNSTABLE, "instability"),
    "forms of several degrees": (["-x**3 - sign(x)*y**2", "-y**3"], ATTRACTS, "lyapunov"),
    "enclosed sine": (["y", "-sin(x) + y/4"], UNSTABLE, "instability"),
}  # fmt: skip


def build(rhs: list[str]) -> SwitchedSystem:
    return ns.System(["x", "y", "z"][: len(rhs)], rhs, radius="1/2").system


def certificate(system: SwitchedSystem, verdict: str) -> Record:
    entry, claims = show_verdict(system, verdict)
    assert {"stability": verdict} in claims
    found = {"version": VERSION, "statement": {"subject": about(system), "claims": claims}, "evidence": [entry]}
    return json.loads(json.dumps(found))


LONG = ["turns inward, curved", "twisting outward", "slides home where it repels", "relay that is pushed"]


@pytest.mark.parametrize("name", but(LONG, KNOWN))
def test_known_verdicts_are_shown_to_the_checker(name: str) -> None:
    rhs, verdict, theorem = KNOWN[name]
    record = certificate(build(rhs), verdict)
    assert record["evidence"][0]["theorem"] == theorem
    assert refused(record) == ""


@few(2)
@pytest.mark.parametrize(
    "name", ["turns outward", "turns inward", "closed orbits", "slides away", "saddle beside curves"]
)
def test_no_other_verdict_is_shown(name: str) -> None:
    rhs, verdict, _ = KNOWN[name]
    for other in {ATTRACTS, STABLE, UNSTABLE} - {verdict} - ({STABLE} if verdict == ATTRACTS else set()):
        with pytest.raises(NotShownError):
            show_verdict(build(rhs), other)


def test_a_value_of_the_function_that_is_too_large_is_rejected() -> None:
    record = certificate(build(TURN), ATTRACTS)
    pieces = record["evidence"][0]["hypotheses"]["function"]
    for piece in pieces:
        changed = [[mark, "x" if own == piece[1] else own] for mark, own in pieces]
        forged = json.loads(json.dumps(record))
        forged["evidence"][0]["hypotheses"]["function"] = changed
        assert refused(forged)


def compare_with_formulas(count: int, first: int) -> list[str]:
    """The verdicts by formulas in floats on random fans, each shown, and no other one."""
    decided = []
    for seed in range(first, first + count):
        system = random_fan(seed)
        known = Judge(system).verdict()
        for verdict in (ATTRACTS, UNSTABLE) if known is not None else ():
            try:
                record = certificate(build(list(system.rhs)), verdict)
            except NotShownError:
                continue
            assert verdict == known, (seed, system.rhs)
            assert refused(record) == "", (seed, system.rhs)
            decided.append(verdict)
    return decided


def test_random_fans_against_formulas() -> None:
    assert set(compare_with_formulas(2, 0)) == {ATTRACTS, UNSTABLE}


@thorough  # the small one: test_random_fans_against_formulas
def test_many_random_fans_against_formulas() -> None:
    decided = compare_with_formulas(60, 1000)
    assert min(decided.count(ATTRACTS), decided.count(UNSTABLE)) > 10


@thorough  # the small one: test_random_fans_against_formulas
def test_random_fans_against_paths() -> None:
    """What attracts by a piecewise linear V attracts polygons with small steps."""
    attracted = 0
    for seed in range(2000, 2010):
        system = random_fan(seed, drift=False)
        try:
            show_by_fan(build(list(system.rhs)), ATTRACTS)
        except NotShownError:
            continue
        attracted += 1
        assert any(spread(system, steps=steps)[1] < 0.5 for steps in (4000, 64000)), (seed, system.rhs)
    assert attracted > 0


def test_patterns_without_points_are_those_of_a_fine_grid() -> None:
    system = build(["-sign(y - x**2) + sign(x - y**3)", "-sign(x**2 + y**2 - 2)"])
    search, subject = Search(), read_system(about(system))
    stated = stated_cells(system, system.check.radius)
    found = sharpened(stated, subject, search)
    line = np.linspace(-0.5, 0.5, 202)
    x, y = np.meshgrid(line, line)
    signs = np.stack([y - x**2, x - y**3, x**2 + y**2 - 2], axis=-1).reshape(-1, 3) > 0
    occurring = len(np.unique(signs, axis=0))
    assert len(Inclusion(subject, stated.record, [], search).cells) == 8
    assert len(Inclusion(subject, found.record, [], search).cells) == occurring == 4


def test_directions_lead() -> None:
    """All products are positive, where a point of the hull nearest to the origin says that there is a direction."""
    rng = np.random.default_rng(5)
    for _ in range(40):
        velocities = rng.normal(size=(4, 3)) + 1
        shares = rng.dirichlet(np.ones(4), 20_000)
        nearest = float(np.linalg.norm(shares @ velocities, axis=1).min())
        direction = leading_direction(velocities)
        assert direction is None or (velocities @ direction > 0).all()
        assert direction is not None or nearest < 0.2


def test_an_equilibrium_has_no_direction() -> None:
    with pytest.raises(NotShownError):
        show_departure_of(build(["-sign(x)", "1 - 2*sign(y)"]), UNSTABLE)


@pytest.mark.parametrize(
    ("rhs", "verdict"),
    [
        (["sign(y - sqrt(2)*x)", "-sign(x) + sign(y - sqrt(2)*x)/2"], UNSTABLE),
        (["-sign(x) + sqrt(Abs(y))", "-sign(y)"], ATTRACTS),
        (["-y", "sqrt(2)*x"], STABLE),
    ],
)
def test_other_systems_are_refused_in_one_line(rhs: list[str], verdict: str) -> None:
    with pytest.raises((NotShownError, BeyondReachError)) as error:
        show_verdict(build(rhs), verdict)
    assert is_one_line(str(error.value))


def test_irrational_numbers_are_shown_as_they_are() -> None:
    entry, shown = show_verdict(build(["sqrt(2)*sign(y)", "-sign(x) + sign(y)/2"]), UNSTABLE)
    assert (entry["theorem"], shown) == ("instability", [{"stability": UNSTABLE}])
