"""Further functions W of LaSalle's principle: searched, checked, forged, and beside observability, hulls and paths."""

from __future__ import annotations

import copy
import json
import random
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

import nonsmooth as ns
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.polynomials import variable
from nonsmooth.proofs.checker.positivity import Claim, Inequality, cube_guards, identity, show
from nonsmooth.proofs.checker.statements import VERSION, refusal
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.inequalities.prover import Counterexample
from nonsmooth.proofs.kernel import simplices
from nonsmooth.proofs.kernel.cells import stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import Search
from nonsmooth.proofs.kernel.second_function import extreme_velocities, find_second
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.proofs.many_states.weak_functions import find_weak_growth
from nonsmooth.proofs.system_certificates import certificate_text
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from tests.dissipative_systems import dissipative_systems
from tests.oracles.floats import Floats, midpoint, value, velocity
from tests.plain import built, refused
from tests.thorough import few, keep, thorough

Record = dict[str, Any]

DISC, BALL = "x**2 + y**2", "x**2 + y**2 + z**2"


def certificate(rhs: Any, function: str, states: str = "x y", radius: str | None = "1/2", **more: Any) -> Record | None:
    """A certificate of attraction (of instability, where a direction is given); None where no W is found.

    It is searched once, and may be changed.
    """
    record: Record | None = json.loads(searched(json.dumps([rhs, function, states, radius, more])))
    return record


@cache
def searched(key: str) -> str:
    """That certificate as text."""
    rhs, function, states, radius, more = json.loads(key)
    return json.dumps(shown_by(rhs, function, states, radius, more))


def shown_by(rhs: Any, function: str, states: str, radius: str | None, more: Record) -> Record | None:
    system = built(rhs, states=states.split(), radius=radius or "1/2")
    bends = surfaces_of(system, parse_piecewise(function, system.states))
    half = None if radius is None else system.field(Fraction(radius))
    cells, subject, search = stated_cells(system, half, bends).record, about(system), Search()
    second = find_second(read_system(subject), cells, function, search)
    if second is None:
        return None
    hypotheses: Record = {"cells": cells, "function": function, "second": second}
    if "direction" in more:
        entry, claims = search.entry(read_system(subject), "instability", {**hypotheses, **more})
    else:
        defaults = {
            "verdict": "asymptotically stable",
            "everywhere": False,
            "level": None,
            "below": False,
            "rate": None,
        }
        entry, claims = search.entry(read_system(subject), "lyapunov", {**hypotheses, **defaults, **more})
    return {"version": VERSION, "statement": {"subject": subject, "claims": claims}, "evidence": [entry]}


def oscillator(friction: str, potential: str) -> tuple[list[str], str]:
    """``x' = y, y' = -friction`` and its energy."""
    return ["y", f"-({friction})"], f"y**2/2 + {potential}"


# ---- what attracts -------------------------------------------------------------------------------

ATTRACTING: dict[str, tuple[Any, str, str]] = {
    "cubic friction": (*oscillator("x + y**3", "x**2/2"), "x y"),
    "relay and cubic friction": (*oscillator("sign(x) + y**3", "Abs(x)"), "x y"),
    "hard spring": (*oscillator("x**3 + y**3", "x**4/4"), "x y"),
    "friction above": (*oscillator("x + relu(y)**3", "x**2/2"), "x y"),
    "friction on the right": (*oscillator("x + relu(x)*y", "x**2/2"), "x y"),
    "two fields": ([["y", "-sign(x) - y**3"], ["y", "-sign(x) - y"]], "Abs(x) + y**2/2", "x y"),
    "a relay that is crossed": (["y", "-x - sgn(y + z)", "-z - sgn(y + z)"], BALL, "x y z"),
    "a relay and two steps": (["y", "-sign(x) - z", "y - z"], "Abs(x) + y**2/2 + z**2/2", "x y z"),
    "relay and drag": (*oscillator("sign(x) + y*Abs(y)", "Abs(x)"), "x y"),
    "friction off an axis": (*oscillator("x + x**2*y", "x**2/2"), "x y"),
    "friction off a line": (*oscillator("x + y*(x - 1/4)**2", "x**2/2"), "x y"),
    "friction off a skew line": (["y - x*(x - 2*y)**2", "-x - 2*y*(x - 2*y)**2"], DISC, "x y"),
    "two speeds": ([["y", "-x - y**3"], ["2*y", "-2*x - y"]], DISC, "x y"),
    "seen after two derivatives": (["y", "-x - z", "y - z**3"], BALL, "x y z"),
    "half the space is crossed": (["y", "-x - relu(y)", "-z"], BALL, "x y z"),
    "V in two pieces": (["y", "-x - relu(x) - y**3", "-z"], "x**2 + relu(x)**2 + y**2 + z**2", "x y z"),
}
BENDING = {
    "a quarter with friction": (*oscillator("x + relu(-x)*relu(y)", "x**2/2"), "x y"),
    "relay, friction on the right": (*oscillator("sign(x) + relu(x)*y", "Abs(x)"), "x y"),
}


@few(2)
@pytest.mark.parametrize("name", keep(8, [*ATTRACTING, *BENDING]))
def test_what_attracts_is_certified(name: str) -> None:
    rhs, function, states = {**ATTRACTING, **BENDING}[name]
    record = certificate(rhs, function, states)
    assert record is not None
    assert record["statement"]["claims"] == [{"stability": "asymptotically stable"}]
    assert refused(record) == ""
    assert refused(without_bounds(record))


def without_bounds(record: Record) -> Record:
    """The same certificate without what it states of the zeros of rates."""
    forged = copy.deepcopy(record)
    forged["evidence"][0]["hypotheses"]["second"]["zeros"] = {}
    return forged


def test_regions_and_all_of_space() -> None:
    rhs, function = oscillator("x + y**3", "x**2/2")
    record = certificate(rhs, function, level="1/8")
    assert record is not None
    assert record["statement"]["claims"][1]["attracts"]["below"] == "1/8"
    assert refused(record) == ""
    record = certificate(rhs, function, radius=None, everywhere=True)
    assert record is not None
    assert record["statement"]["claims"][1] == {"attracts": "everywhere"}
    assert refused(record) == ""


@pytest.mark.parametrize("damping", keep(1, ["-1/4*y", "-3*y", "-y**3"]))
def test_what_leaves_is_certified(damping: str) -> None:
    """A relay that gains energy: V falls where y is not zero, and rests nowhere."""
    record = certificate(["y", f"-(sign(x) + {damping})"], "-(Abs(x) + y**2/2)", direction=["1", "1"])
    assert record is not None
    assert record["statement"]["claims"] == [{"stability": "unstable"}]
    assert refused(record) == ""
    assert certificate(["y", "-sign(x)"], "-(Abs(x) + y**2/2)", direction=["1", "1"]) is None


@pytest.mark.parametrize("force", keep(1, ["-sign(x) + y/4", "-sign(x) + 3*y", "-x + y*(1 - x**2)"]))
def test_functions_of_reversed_time(force: str) -> None:
    """The energy and W of relays that gain energy are found; a path in floats gains it."""
    system = built(["y", force], radius="1/2")
    growth = find_weak_growth(system)
    assert growth is not None
    entry, claims = growth
    assert claims == [{"stability": "unstable"}]
    statement = {"subject": about(system), "claims": claims}
    assert refused({"version": VERSION, "statement": statement, "evidence": [entry]}) == ""
    x, y = simulate(system_field(system, (0.1, 0.0)), (0.1, 0.0), 12.0).end.state
    function = entry["hypotheses"]["function"]
    assert value(function, x=x, y=y) < 1.5 * value(function, x=0.1, y=0.0)


# ---- what does not -------------------------------------------------------------------------------

STAYING: dict[str, tuple[Any, str, str]] = {
    "nothing falls": (*oscillator("x", "x**2/2"), "x y"),
    "a segment of rest": (*oscillator("x + sign(y)", "x**2/2"), "x y"),
    "orbits below the dead zone": (*oscillator("x + relu(y - 1/8)", "x**2/2"), "x y"),
    "a limit cycle": (*oscillator("x + y*(x**2 + y**2 - 1/16)**2", "x**2/2"), "x y"),
    "rests on a ray": (["-x", "-relu(y)"], DISC, "x y"),
    "a line of equilibria": (["y - x", "x - y"], DISC, "x y"),
    "one of two fields keeps V": ([["y", "-x - y**3"], ["y", "-x"]], DISC, "x y"),
    "halves that each field leaves": ([["y", "-x - relu(x)*y"], ["y", "-x - relu(-x)*y"]], DISC, "x y"),
    "opposite turns": ([["y", "-x - y"], ["-y", "x - y"]], DISC, "x y"),
    "V rises": (*oscillator("x - y**3", "x**2/2"), "x y"),
    "slides and oscillates": (["y", "-x - sgn(y + z)", "-sgn(y + z)"], BALL, "x y z"),
    "a relay that holds": (["y", "-x + z", "-y - sgn(z)"], BALL, "x y z"),
    "one field alone on the surface": (["-x", "-y*(1 + sgn(x))/2", "-z*(1 - sgn(x))/2"], BALL, "x y z"),
}
SLOW = ("slides and oscillates", "a relay that holds", "halves that each field leaves")


@pytest.mark.parametrize("name", [pytest.param(name, marks=thorough if name in SLOW else ()) for name in STAYING])
def test_where_something_stays_nothing_is_found(name: str) -> None:
    assert certificate(*STAYING[name]) is None


def test_places_at_which_other_functions_failed_are_looked_at_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is found is the same."""
    system, energy = built(["y", "-sign(x) - y"], states=["x", "y"]), "Abs(x) + y**2/2"
    bends = surfaces_of(system, parse_piecewise(energy, system.states))
    cells = stated_cells(system, system.check.radius, bends).record
    subject, asked, show = read_system(about(system)), list[str](), Search.show

    def noted(search: Search, claim: Claim) -> None:
        asked.append(claim.name)
        show(search, claim)

    monkeypatch.setattr(Search, "show", noted)
    second = find_second(subject, cells, energy, Search())
    names = [name for name in asked if name.startswith("cell")]
    last = max(set(names), key=names.index)
    assert second is not None
    assert names[0] != last
    search = Search()
    search.missed[last] = Claim(last, (), strict=True)
    asked.clear()
    assert find_second(subject, cells, energy, search) == second
    first = next(name for name in asked if name.startswith("cell"))
    assert last.startswith(first)
    assert not names[0].startswith(first)


@pytest.mark.parametrize("count", keep(1, [8, 30]))
def test_random_dissipative_systems_against_observability(count: int) -> None:
    counts: Counter[tuple[bool, bool]] = Counter()
    for system in dissipative_systems(count):
        record = certificate(list(system.rhs), system.energy, " ".join(system.states))
        assert record is None or refused(record) == ""
        counts[record is not None, system.attracts] += 1
    assert set(counts) == {(True, True), (False, False)}, counts  # complete on these


# ---- forged --------------------------------------------------------------------------------------


def forged(name: str, zeros: Record | None = None, functions: Any = None) -> str:
    """What the checker says of a certificate with other bounds or functions."""
    record = certificate(*ATTRACTING[name])
    assert record is not None
    second = record["evidence"][0]["hypotheses"]["second"]
    second["zeros"] = second["zeros"] if zeros is None else {**second["zeros"], **zeros}
    second["functions"] = second["functions"] if functions is None else functions
    return refused(record)


CUBIC = "cell  field 0"  # of "cubic friction"


@pytest.mark.parametrize(
    ("bound", "reason"),
    [
        ([["1/2", [["y", 3]]]], "even powers"),
        ([["-1/2", [["y", 4]]]], "positive factors"),
        ([["0", [["y", 4]]]], "positive factors"),
        ([["1/2", [["y", 0]]]], "even powers"),
        ([["1/2", [["y*x + y**2 + x**2", 4]]]], ""),
        ([["1/2", [["sign(y)", 4]]]], "surfaces without switching"),
        ([["2", [["y", 4]]]], ""),  # r is y^4
        ([["1/2", [["y", 4]]], ["1/64", [["x", 4]]]], ""),  # a larger bound than the rate
        ([["1/2", [["y", 4]]]] * 17, "at most 16"),
        ([["1/2", [["y", 99]]]], "whole number"),
        ("y", "list"),
        ([["1/2", "y"]], "list"),
    ],
)
def test_forged_bounds_are_rejected(bound: Any, reason: str) -> None:
    said = forged("cubic friction", {CUBIC: bound})
    assert said
    assert reason in said


def test_forged_functions_are_rejected() -> None:
    for functions in ([], ["x*y"], ["x", "-x*y"], ["Abs(y)"], ["x"] * 5, ["sign(y)"], "x*y", [["+", "x"]]):
        assert forged("cubic friction", functions=functions), functions
    assert forged("a relay and two steps", functions=["-x*y", "y*z"])  # the order matters
    assert "nothing that stays" in forged("cubic friction", {f"{CUBIC} then 0": []})


@pytest.mark.parametrize("name", ["nothing falls", "a segment of rest", "one of two fields keeps V"])
def test_evidence_of_another_system_is_rejected(name: str) -> None:
    record = certificate(*ATTRACTING["cubic friction"])
    assert record is not None
    rhs, function, _ = STAYING[name]
    record["statement"]["subject"]["rhs"] = rhs if isinstance(rhs[0], list) else [rhs]
    record["evidence"][0]["hypotheses"]["function"] = function
    assert refused(record)


# ---- by the definition -----------------------------------------------------------------------------


def test_extreme_velocities_against_linear_programs() -> None:
    """How far tangent mixtures of random velocities reach in a direction is how far the extreme ones do."""
    rng, reached = np.random.default_rng(3), 0
    for count in (0, 1, 2) * 6:
        fields, normals = rng.normal(size=(5, 3)), rng.normal(size=(count, 3))
        acts = np.ones(1, dtype=bool)
        _, extreme = extreme_velocities([(acts, field[None]) for field in fields], [normal[None] for normal in normals])
        equations, right = np.vstack([normals @ fields.T, np.ones(5)]), [*np.zeros(count), 1.0]
        for direction in rng.normal(size=(4, 3)):
            solved = linprog(-fields @ direction, A_eq=equations, b_eq=right)
            assert (solved.status == 2) == (not len(extreme))
            if len(extreme):
                reached += 1
                assert np.max(extreme @ direction) == pytest.approx(-solved.fun, abs=1e-9)
    assert reached > 30


@pytest.mark.parametrize(("name", "side"), keep(1, [("friction above", 1), ("friction on the right", 0)]))
def test_functions_rise_along_paths_that_keep_v(name: str, side: int) -> None:
    """Along a path in floats, while a state is negative so that nothing damps, the first W that changes rises."""
    rhs = ATTRACTING[name][0]
    record = certificate(*ATTRACTING[name])
    assert record is not None
    functions = record["evidence"][0]["hypotheses"]["second"]["functions"]
    place, kept = np.array([0.3, 0.1]), 0
    for _ in range(300):
        before = place
        for _ in range(10):
            place = midpoint(partial(velocity, rhs), place, 1e-3)
        if max(place[side], before[side]) < 0:
            kept += 1
            changes = velocity(functions, place) - velocity(functions, before)
            assert next(change for change in changes if abs(change) > 1e-9) > 0, (before, changes)
    assert kept > 50


# ---- an oracle of mutants (tests/proofs/attacks.py) ----------------------------------------------


def assert_true(record: Record, source: random.Random) -> None:
    """A path from near the point loses V again and again, if it stays in the square: of each right-hand side."""
    hypotheses = record["evidence"][0]["hypotheses"]
    half = float(Fraction(hypotheses["cells"]["within"]))
    start = np.array([source.uniform(0.6, 0.8), source.uniform(-0.2, 0.2)]) * half
    for rhs in record["statement"]["subject"]["rhs"]:
        values = partial(velocity, (*rhs, hypotheses["function"]))
        first, lost = values(start)[2], lost_along(values, start, half)
        assert lost is None or lost > 1e-5 * first, record


def lost_along(values: Callable[[Floats], Floats], place: Floats, half: float) -> float | None:
    """How much of V a path loses; None where it leaves the square."""
    lost = 0.0
    for _ in range(10_000):
        x, y, before = values(place)
        slope = (values(place + 1e-6 * np.array([x, y]))[2] - before) / 1e-6
        lost += 2e-3 * max(-slope - 1e-7, 0.0)
        place = place + 2e-3 * values(place + 1e-3 * np.array([x, y]))[:2]
        if np.max(np.abs(place)) > half:
            return None
    return lost


def originals(count: int = 5) -> list[Record]:
    """Valid certificates."""
    names = ("cubic friction", "relay and cubic friction", "friction above", "friction on the right", "hard spring")
    records = [certificate(*ATTRACTING[name]) for name in names[:count]]
    return [record for record in records if record is not None]


def test_a_guard_that_is_positive_nowhere_has_a_multiplier() -> None:
    """Where x >= 0 and -x >= 0, y^2 - 5 x + x y is y^2; beside this line it is negative at places."""
    x, y = variable(2, 0), variable(2, 1)
    value = y * y - x.times(5) + x * y
    on_the_line = Inequality(value, {"s0": x, "s1": -x, **cube_guards(identity(2), 2)})
    claim = Claim("line", (on_the_line,), strict=False)
    evidence = simplices.search(claim, 10_000)
    assert isinstance(evidence, dict)
    show(claim, evidence)
    half = Claim("half", (replace(on_the_line, guards={"s0": x, **cube_guards(identity(2), 2)}),), strict=False)
    against = simplices.search(half, 10_000)
    assert isinstance(against, Counterexample)
    px, py = against.point
    assert px > 0 > py * py - 5 * px + px * py == against.value
    with pytest.raises(RejectedError):
        show(half, evidence)


def test_rates_with_irrational_numbers_have_no_bounds_by_factors() -> None:
    """The search for further functions goes on without them; it ended in a TypeError."""
    first = "-4*x + 2*y + 2*Abs(sqrt(3)*x + y) - Abs(y)"
    second = "x - 2*y - 2*Abs(sqrt(3)*x + y) + Abs(y)"
    result = ns.System(["x", "y"], [first, second]).check()
    certificate = result.certificate()
    assert {"stability": "asymptotically stable"} in certificate["statement"]["claims"]
    assert not refusal(certificate, len(certificate_text(certificate)))
