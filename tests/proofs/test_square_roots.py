"""Systems with sqrt(Abs(x)), and their certificates in signed roots."""

from __future__ import annotations

import copy
import random
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.checker.descriptions import describe
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.statements import VERSION
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.system_certificates import certificate_of, left_out
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import require_stated
from tests.certificates.inclusion import numbers_of
from tests.oracles.floats import value
from tests.oracles.mutants import Record, is_one_line
from tests.plain import built, refused
from tests.thorough import few, keep, thorough

# ---- Systems with sqrt(Abs(x)): known truths, paths against closed forms, and where nothing may be said.

ATTRACTS, LEAVES, OPEN = Translation.ASYMPTOTICALLY_STABLE, Translation.UNSTABLE, Translation.UNDECIDED
ROOT = "sqrt(Abs(x))*sgn(x)"


def largest_end(rhs: list[str], size: float, until: float, step: float = 5e-4) -> float:
    """Where Euler polygons from a small curve end, ``max(sqrt|x|, |y|)`` over that of their starts."""
    angles = np.linspace(0.1, 6.2, 12)
    x, y = np.sign(np.cos(angles)) * (size * np.cos(angles)) ** 2, size * np.sin(angles)
    x, y = followed(rhs, x, y, until, step)
    return float(np.maximum(np.sqrt(np.abs(x)), np.abs(y)).max() / size)


KNOWN = [
    ([f"-3/2*{ROOT} + y", "-11/10*sgn(x)"], ATTRACTS, True),  # super-twisting
    ([f"-1/2*{ROOT} + y", "-3*sgn(x)"], ATTRACTS, True),
    ([f"-3/2*{ROOT} + y - x", "-11/10*sgn(x) - x"], ATTRACTS, True),  # with linear terms (Moreno 2009)
    ([f"-3/2*{ROOT} + y + 2*x + y**2", "-11/10*sgn(x) + x*y"], ATTRACTS, True),  # and with destabilizing ones
    ([f"1/2*{ROOT} + y", "-11/10*sgn(x)"], LEAVES, False),  # anti-damped
    ([f"-3/2*{ROOT} + y", "11/10*sgn(x)"], LEAVES, False),  # a saddle of the roots
    ([f"-3/2*{ROOT} + y", "-11/10*sgn(x) + 12/10*sgn(y)"], LEAVES, False),  # a relay that wins
    ([f"-3*{ROOT} + y", "-11/10*sgn(x) + 1/2*sgn(y)"], ATTRACTS, True),  # and one that does not
    (["y", "-2*sgn(y + sqrt(Abs(x))*sgn(x))"], ATTRACTS, None),  # a prescribed law of convergence (Levant 1993)
]


@few(2)
@pytest.mark.parametrize(("rhs", "truth", "in_time"), keep(5, KNOWN))
def test_known_systems_agree_with_their_polygons(rhs: list[str], truth: Translation, in_time: bool | None) -> None:
    result = decide_system(built(rhs))
    assert result.verdict is truth, result.reason
    assert result.check()
    assert in_time is None or result.reach.in_finite_time is in_time
    last = largest_end(rhs, 0.15, 2.0)
    assert last < 0.3 if truth is ATTRACTS else last > 2


def test_a_disturbance_within_the_gain_is_rejected_and_a_larger_one_is_not() -> None:
    """``|d| < k_2`` alone is not enough of k_1; here k_1 = 3 is large (Levant 1993)."""
    rhs = [f"-3*{ROOT} + y", "-11/10*sgn(x) + d"]
    found = decide_system(built(rhs, {"d": ["-1/2", "1/2"]}))
    assert found.verdict is ATTRACTS
    assert found.reach.in_finite_time
    assert found.check()
    assert decide_system(built(rhs, {"d": [-2, 2]})).verdict is not ATTRACTS


SLIDING = [
    ([f"-{ROOT} + x*y", "-y - x"], ATTRACTS),  # slides to the point along x = 0, which the roots do not see
    (["-sgn(x) + y", f"-y - {ROOT}"], ATTRACTS),
]


@pytest.mark.parametrize(("rhs", "truth"), SLIDING)
def test_nothing_is_said_where_solutions_slide_on_a_zero_of_the_root(rhs: list[str], truth: Translation) -> None:
    result = decide_system(built(rhs))
    assert result.verdict in (truth, OPEN)
    assert result.verdict is OPEN
    assert "not every solution crosses" in result.reason
    assert result.check()


def test_what_slides_away_on_a_zero_of_the_root_is_told_by_its_parts() -> None:
    result = decide_system(built([f"-{ROOT}", "y - x"]))
    assert result.verdict is LEAVES
    assert result.method is Method.CASCADE
    assert result.check()


BY_THEMSELVES = [
    ([f"-{ROOT}", "1 - y"], [0, 1], ATTRACTS),
    ([f"-{ROOT}", "y - 1"], [0, 1], LEAVES),
    # these two, marked, are searched for a second each; instability has a shorter one above
    pytest.param([f"{ROOT}/2 - x", "-sqrt(Abs(y))*sgn(y) - x/(1 + y**2)"], [0, 0], LEAVES, marks=thorough),
    ([f"-{ROOT} - sgn(x)", "-sin(y)"], [0, 0], ATTRACTS),
    ([f"-{ROOT}", "0"], [0, 0], Translation.STABLE),
    pytest.param([f"{ROOT}/2 - x", "1 - sqrt(Abs(y)) - x**2"], [0, 1], LEAVES, marks=thorough),
    ([f"-{ROOT}", "2 - sqrt(Abs(y)) + x"], [0, 4], ATTRACTS),  # x drives y
    ([f"-{ROOT}", "-y - x"], [0, 0], ATTRACTS),  # x drives y
    ([f"-{ROOT}", f"{ROOT} - sqrt(Abs(y))*sgn(y)"], [0, 0], ATTRACTS),  # Torricelli's tanks, which run empty
]


AWAY = "relu(y - 1/4)"  # beyond 1/4 solutions slide along x = 0, and y grows there


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize(
    ("rhs", "verdict", "radius"),
    [
        (["-sqrt(Abs(x))*sgn(x) - sgn(x)", "y"], Translation.UNSTABLE, None),
        (
            [f"y - 8*{AWAY}*sgn(x) - sqrt(Abs(x))*sgn(x)", f"-sgn(x)/2 + 4*{AWAY}"],
            Translation.ASYMPTOTICALLY_STABLE,
            0.3,
        ),
        ([f"y - 8*{AWAY}*sgn(x) - {AWAY}*sqrt(Abs(x))", f"-sgn(x)/2 + 4*{AWAY}"], Translation.STABLE, 0.25),
    ],
)
def test_a_v_is_not_kept_where_time_stands_still(rhs: list[str], verdict: Translation, radius: float | None) -> None:
    """Of the scaled field V does not increase on the square of 1/2; of the states it does on x = 0."""
    result = decide_system(built(rhs, lyapunov="root_x**2 + y**2"))
    assert (result.verdict, result.given) == (verdict, None)
    assert radius is None or 0 < float(result.function.domain.radius) <= radius


@pytest.mark.usefixtures("without_reach")
@few(4)
@pytest.mark.parametrize(("rhs", "at", "truth"), BY_THEMSELVES)
def test_states_that_no_other_one_moves_are_decided_by_themselves(
    rhs: list[str], at: list[int], truth: Translation
) -> None:
    result = decide_system(built(rhs, equilibrium=at))
    drives = any("x" in formula for formula in rhs[1:]) and truth is ATTRACTS
    assert (result.verdict, result.deciding.theorem) == (truth, Method.CASCADE if drives else Method.STATES)
    assert result.check()


def test_no_equilibrium_is_said_of_the_stated_field() -> None:
    """The scaled field vanishes in y on the axis of the root; the stated one does not."""
    result = decide_system(built([f"-{ROOT} + y", "-1 - sgn(x)/2"]))
    assert result.verdict is LEAVES
    assert "0 is not in F" in result.reason
    assert result.check()


@cache
def two_tanks() -> StabilityResult:
    """Torricelli's, of which the first one is filled."""
    rhs = ["1/2 - sqrt(Abs(x))", "sqrt(Abs(x)) - sqrt(Abs(y))"]
    return decide_system(built(rhs, equilibrium=["1/4", "1/4"]))


def test_an_equilibrium_off_the_zero_of_the_root_is_that_of_its_jacobian() -> None:
    """Torricelli's two tanks: x' = q - sqrt(x), y' = sqrt(x) - sqrt(y) rests at (q^2, q^2), a node."""
    result = two_tanks()
    assert result.verdict is ATTRACTS
    assert not result.reach.everywhere
    assert not result.reach.in_finite_time
    assert result.check()
    turned = decide_system(built(["sqrt(Abs(x)) - 1/2", "sqrt(Abs(x)) - sqrt(Abs(y))"], equilibrium=["1/4", "1/4"]))
    assert turned.verdict is LEAVES


def test_one_state() -> None:
    result = decide_system(built([f"-{ROOT} + x"], radius=2))
    assert result.verdict is ATTRACTS
    assert result.check()
    assert decide_system(built([f"{ROOT} - x"])).verdict is LEAVES


def closed_form(k1: str, k2: str) -> tuple[list[tuple[mpf, mpf]], mpf]:
    """Times and y of super-twisting at its first crossings of x = 0 from (1, 0), and the time of arrival.

    Between crossings ``y`` falls at the rate k2, so times are differences of y; the linear flow of (z, y) in time s,
    ``z' = y - k1 z``, ``y' = -2 k2 z``, gives y at the crossings (eigenvalues ``a +- i w``).
    """
    with mp.workdps(40):
        a, k = -mpf(k1) / 2, mpf(k2)
        w = mp.sqrt(2 * k - a * a)
        first = mp.findroot(lambda s: mp.cos(w * s) + a / w * mp.sin(w * s), mpf(2) / w)
        y = -2 * k / w * mp.exp(a * first) * mp.sin(w * first)
        t, ratio, crossings = -y / k, -mp.exp(a * mp.pi / w), []
        for _ in range(6):
            crossings.append((t, y))
            t, y = t + abs(ratio * y - y) / k, ratio * y
        last, height = crossings[0]
        return crossings, last + abs(height) * (1 - ratio) / k / (1 + ratio)


@pytest.mark.parametrize(("k1", "k2"), [("1.5", "1.1"), pytest.param("0.8", "2", marks=thorough)])
def test_paths_meet_the_closed_form(k1: str, k2: str) -> None:
    system = built([f"-{Fraction(k1)}*{ROOT} + y", f"-{Fraction(k2)}*sgn(x)"])
    path = simulate(system_field(system, (1.0, 0.0)), (1.0, 0.0), 20.0)
    expected, arrival = closed_form(k1, k2)
    crossed = [e for e in path.events if not e.state[0] and e.state[1]]
    for event, (time, height) in zip(crossed, expected, strict=False):
        assert float(event.t) == pytest.approx(float(time), abs=1e-11)
        assert float(event.state[1]) == pytest.approx(float(height), abs=1e-11)
    assert len(crossed) >= len(expected)
    rest = [e for e in path.events if max(map(abs, e.state)) < 1e-12]
    assert float(rest[0].t) == pytest.approx(float(arrival), abs=1e-10)
    assert path.unique
    assert path.end.state == (0.0, 0.0)


def test_a_path_slides_on_a_zero_of_the_root_in_its_own_time() -> None:
    """x arrives at 2 sqrt(x_0) and y goes on like exp(-t)."""
    path = simulate(system_field(built([f"-{ROOT}", "-y"]), (0.25, 1.0)), (0.25, 1.0), 3.0)
    arrived = next(e for e in path.events if not e.state[0])
    assert float(arrived.t) == pytest.approx(1.0, abs=1e-6)  # the root is not smooth where it ends
    assert path.end.state[1] == pytest.approx(np.exp(-3), abs=1e-10)


@pytest.mark.usefixtures("without_reach")
@few(1)
@pytest.mark.parametrize("seed", range(20))
def test_random_gains_agree_with_eigenvalues(seed: int) -> None:
    """In roots super-twisting with a relay of y is conewise linear; without it the trace and determinant decide."""
    rng = np.random.default_rng(seed)
    a, b, c = (Fraction(int(k), 8) for k in rng.integers(-24, 25, 3))
    if not a or not b or b * 2 == c * c:
        return
    rhs = [f"({-a})*{ROOT} + y", f"({-b})*sgn(x) + ({c})*x"]
    truth = ATTRACTS if a > 0 and b > 0 else LEAVES
    result = decide_system(built(rhs))
    assert result.verdict is truth, (rhs, result.reason)
    assert result.check()


@few(1)
@pytest.mark.parametrize("seed", range(24))
def test_random_systems_agree_with_their_polygons(seed: int) -> None:
    """Super-twisting with random gains and one random term more; near the point, as asymptotic stability is local."""
    rng = np.random.default_rng(seed)
    a, b, c, d, e = (f"({k}/4)" for k in (*rng.integers(-12, 13, 4), rng.integers(-4, 5)))
    first, second = f"{a}*{ROOT} + 3/2*y", f"{b}*sgn(x)"
    first, second = (
        (f"{first} + {c}*x", f"{second} + {d}*y"),
        (first, f"{second} + {e}*sgn(y)"),
        (f"{first} + {e}*sqrt(Abs(x))", second),
        (first, f"{second} + {e}*sgn(y + {ROOT})"),
    )[seed % 4]
    result = decide_system(built([first, second]))
    assert result.check()
    last = largest_end([first, second], 0.01, 0.5, 1e-4)
    if result.verdict is ATTRACTS:
        assert last < 0.9
    elif result.verdict is LEAVES:
        assert last > 1.1


@pytest.mark.parametrize(
    "rhs", [[f"-2*{ROOT} - sat(x, -1, 1) + x/(1 + x**2)"], [f"-2*{ROOT} + x/(1 + x**2) + y", "-sgn(x)"]]
)
def test_a_certificate_beside_a_quotient(rhs: list[str]) -> None:
    """It speaks of the right-hand sides times the denominator."""
    certificate = certificate_of(decide_system(built(rhs)))
    assert "(1 + x**2)" in certificate["statement"]["subject"]["rhs"][0][0]


@pytest.mark.usefixtures("without_reach")
def test_instability_beside_multiples_of_a_state_under_a_root_is_certified() -> None:
    """The search for a function once took its subject for one without roots, the checker 3 x for that of x > 0."""
    result = decide_system(built([f"3/4*{ROOT} + 3*x + 3/2*y", "-3/2*sgn(x) + 11/4*y"]))
    assert result.verdict is LEAVES
    record = certificate_of(result)
    assert (refused(record), record["statement"]["claims"]) == ("", [{"stability": "unstable"}])


def test_an_interval_of_starts_is_that_of_the_state() -> None:
    """Half of the stated width is that of the root."""
    result = decide_system(built([f"-{ROOT}"]))
    assert result.deciding.facts[0].words == "every start with -1/4 < x < 1/4 reaches the equilibrium"


def test_a_refusal_names_the_formula_that_holds_the_root() -> None:
    system = built(["y", f"-{ROOT} - y"])
    with pytest.raises(SceneError, match=r"system\.rhs\[2\]: .* received '-sqrt\(Abs\(x\)\)\*sgn\(x\) - y'"):
        require_stated(system)
    with pytest.raises(SceneError, match=r"check\.lyapunov: required .* without 'sqrt\(1 \+ x\*\*2\)'"):
        built(["y", "-x - y"], lyapunov="sqrt(1 + x**2) - 1 + y**2")


# ---- Certificates in signed roots: super-twisting and others, and what would be true of the roots alone.

STABLE = "asymptotically stable"
TWISTING = [f"-2*{ROOT} + y", "-sgn(x)"]
WITH_REGION = [f"-3*{ROOT} + y + sgn(y)/9", "-2*sgn(x)"]
TANKS = ["1/2 - sqrt(Abs(x))", "sqrt(Abs(x)) - sqrt(Abs(y))", "sqrt(Abs(y)) - sqrt(Abs(z))"]
NEVER_EMPTY = ["-..", ".-.", "..-"]  # the tanks' levels near the point: their roots are positive


def written(subject: Record, theorem: str, hypotheses: Record) -> Record:
    """A certificate of what a theorem shows; NotShownError where a hypothesis is not shown."""
    entry, claims = Search().entry(read_subject(subject), theorem, hypotheses)
    return {"version": VERSION, "statement": {"subject": subject, "claims": claims}, "evidence": [entry]}


def by_roots(rhs: list[str], function: str, verdict: str = STABLE, **more: Any) -> Record:
    """A certificate in two states by a V in the root of x."""
    cells = {"within": "1/2", "surfaces": ["root_x", "y"], "empty": []}
    options = {"second": None, "everywhere": False, "level": None, "below": False, "rate": None}
    hypotheses = {"cells": cells, "function": function, "verdict": verdict, **options, **more}
    return written({"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"], "roots": ["x"]}, "lyapunov", hypotheses)


def certified(rhs: list[str]) -> Record:
    """The certificate of a system about the origin; a copy of one that is built once."""
    return copy.deepcopy(_certified(tuple(rhs)))


@cache
def _certified(rhs: tuple[str, ...]) -> Record:
    return certificate_of(decide_system(built(list(rhs))))


# ---- what is true --------------------------------------------------------------------------------

CERTIFIED = [
    WITH_REGION,
    TWISTING,
    [f"-3/2*{ROOT} + y - x", "-11/10*sgn(x) - x"],
    [f"-3*{ROOT} + y", "-11/10*sgn(x) + 1/2*sgn(y)"],
    ["y", f"-2*sgn(y + {ROOT})"],
]


@few(1)
@pytest.mark.parametrize("rhs", keep(2, CERTIFIED))
def test_super_twisting_and_its_kin_are_certified(rhs: list[str]) -> None:
    record = certified(rhs)
    subject, claims = record["statement"]["subject"], record["statement"]["claims"]
    assert (claims[0], subject["rhs"], subject["roots"]) == ({"stability": STABLE}, [rhs], ["x"])
    assert refused({**record, "statement": {**record["statement"], "claims": [{"stability": "unstable"}]}})
    assert_true(record, random.Random(1))


SINES = [
    ([f"-2*{ROOT} + y", "-2*sgn(x) + sin(x)/2"], STABLE),  # super-twisting on a pendulum
    ([f"-{ROOT} + sin(sqrt(Abs(x)))/2", "-tanh(y)"], STABLE),
    (["y", f"-2*{ROOT} - 2*y - sin(y)"], STABLE),  # where V rests on a line
    ([f"-2*{ROOT} + y - sin(x)", "-2*sgn(x) + cos(x) - 1 + sin(y)/4"], STABLE),
    ([f"1/2*{ROOT} + y", "-11/10*sgn(x) + sin(x)"], "unstable"),
]


@few(1)
@pytest.mark.parametrize(("rhs", "verdict"), keep(1, SINES))
def test_sines_beside_roots_are_certified(rhs: list[str], verdict: str) -> None:
    """By a key of the subject: without it no certificate with both is valid."""
    record = certified(rhs)
    statement = record["statement"]
    assert (statement["claims"][0], statement["subject"]["rhs"]) == ({"stability": verdict}, [rhs])
    assert_true(record, random.Random(1))
    del statement["subject"]["order"]
    assert "an order of sines and cosines beside roots" in refused(record)


def test_the_region_is_stated_in_the_roots() -> None:
    """V < level within the cube of (root_x, y): starts there end at the point, along Euler polygons."""
    record = certified(WITH_REGION)
    region = next(claim["attracts"] for claim in record["statement"]["claims"] if "attracts" in claim)
    assert region["in"] == ["root_x", "y"]
    line = describe(record["statement"])[0]
    assert line.startswith("system in x, y at (0, 0), root_x = sign(x)*sqrt(Abs(x)): asymptotically stable")
    rng, size = np.random.default_rng(3), _number(region["within"])
    w, y = rng.uniform(-size, size, (2, 400))
    inside = value(region["function"], root_x=w, y=y) < _number(region["below"])
    assert 20 < inside.sum() < 400
    x, y = followed(WITH_REGION, w[inside] * np.abs(w[inside]), y[inside], until=3.0)
    assert max(np.sqrt(np.abs(x)).max(), np.abs(y).max()) < 0.05


@pytest.mark.usefixtures("without_reach")
def test_arbitrary_switching_growth_and_velocities_at_the_point() -> None:
    disturbed = built([f"-3*{ROOT} + y", "-11/10*sgn(x) + d"], {"d": ["-1/2", "1/2"]})
    assert certificate_of(decide_system(disturbed))["statement"]["claims"][0] == {"stability": STABLE}
    grows = built([f"1/2*{ROOT} + y", "-11/10*sgn(x)"])
    assert certificate_of(decide_system(grows))["statement"]["claims"] == [{"stability": "unstable"}]
    # In the time of the roots y rests at the point; in that of the states it falls.
    subject = {"states": ["x", "y"], "rhs": [[f"-{ROOT} + y", "-1 - sgn(x)/2"]], "at": ["0", "0"], "roots": ["x"]}
    cells = {"within": "1/2", "surfaces": ["root_x"], "empty": []}
    leaves = written(subject, "departure", {"cells": cells, "direction": ["0", "-1"]})
    assert (refused(leaves), leaves["statement"]["claims"][0]) == ("", {"stability": "unstable"})
    with pytest.raises(NotShownError):
        written(subject, "departure", {"cells": cells, "direction": ["0", "1"]})


def test_one_solution_that_leaves() -> None:
    """x grows like t^2/4 from any start on the right, along the field of one of two right-hand sides."""
    rhs = [[f"-{ROOT}", "-y"], ["sqrt(Abs(x))", "-y"]]
    subject = {"states": ["x", "y"], "rhs": rhs, "at": ["0", "0"], "roots": ["x"]}
    mixture = [["+", 1, "1", ["1", "0"]]]
    hypotheses = {
        "within": "1/2",
        "surfaces": ["root_x"],
        "signs": "+",
        "along": ["y"],
        "mixture": mixture,
        "barriers": [],
    }
    record = written(subject, "escape", {**hypotheses, "function": "root_x", "direction": ["1", "0"]})
    assert (refused(record), record["statement"]["claims"]) == ("", [{"stability": "unstable"}])
    still = [["+", 0, "1", ["1", "0"]]]
    with pytest.raises(NotShownError):
        written(subject, "escape", {**hypotheses, "mixture": still, "function": "root_x", "direction": ["1", "0"]})


def test_roots_away_from_zero_in_two_states_and_three() -> None:
    record = certificate_of(two_tanks())
    subject = record["statement"]["subject"]
    assert (subject["at"], subject["roots"]) == (["1/4", "1/4"], ["x", "y"])
    elsewhere = {**record["statement"], "subject": {**subject, "at": ["1/2", "1/4"]}}
    assert refused({**record, "statement": elsewhere}) == "a point whose roots are rational"
    names = ["x", "y", "z"]
    tanks = {"states": names, "rhs": [TANKS], "at": ["1/4"] * 3, "roots": names}
    surfaces = [f"root_{name} + 1/2" for name in names]
    hypotheses = {
        "cells": {"within": "1/8", "surfaces": surfaces, "empty": NEVER_EMPTY},
        "function": " + ".join(f"root_{name}**2" for name in names),
        **{"second": None, "verdict": STABLE, "everywhere": False, "level": "1/64", "below": False, "rate": None},
    }
    assert refused(written(tanks, "lyapunov", hypotheses)) == ""


# ---- what is false -------------------------------------------------------------------------------

FALSE: dict[str, tuple[list[str], str, str]] = {
    # in the time of the roots nothing moves on x = 0; in the stated time y grows there
    "slides outward where the root is zero": (["-sgn(x)", "y/10"], "root_x**2 + y**2", "stable"),
    "slides along a part of it": ([f"-{ROOT} + Max(y - 1/4, 0)", "y/9"], "root_x**2 + y**2/9", "stable"),
    "damped the wrong way": ([f"{ROOT} + y", "-sgn(x)"], "root_x**2 + y**2/2", STABLE),
    "not damped": (["y", "-sgn(x)"], "root_x**2 + y**2/2", STABLE),
    "no equilibrium": ([f"1 - {ROOT}", "-y"], "root_x**2 + y**2", STABLE),
    "V of the state": (TWISTING, "x**2 + y**2", STABLE),
    "roots in the right-hand side": (["-root_x + y", "-sgn(x)"], "root_x**2 + y**2", STABLE),
}


@pytest.mark.parametrize("name", keep(4, FALSE))
def test_false_claims_are_not_shown(name: str) -> None:
    rhs, function, verdict = FALSE[name]
    with pytest.raises(NotShownError):
        by_roots(rhs, function, verdict)


@pytest.mark.parametrize("bad", [["-sgn(x)", "y/10"], ["-sgn(x)*y", "-y"]])
def test_the_reason_is_that_nothing_crosses(bad: list[str]) -> None:
    """V does not rise in the roots' time; solutions slide along x = 0, or speeds across it differ in sign."""
    with pytest.raises(NotShownError, match="no proof was found of crosses 0 speeds"):
        by_roots(bad, "root_x**2 + y**2", "stable")


IRRATIONAL = [f"-3/2*sqrt(2)*{ROOT} + y", "-11/5*sgn(x)"]


def test_irrational_gains_are_certified() -> None:
    """Super-twisting with ``3/2 sqrt(L)`` and ``11/10 L``, L = 2: the number has a name, and its polynomial."""
    record = certified(IRRATIONAL)
    subject = record["statement"]["subject"]
    assert subject["rhs"] == [[f"-3/2*sqrt_2*{ROOT} + y", "-11/5*sgn(x)"]]
    assert subject["numbers"] == [{"name": "sqrt_2", "polynomial": ["-2", "0", "1"], "above": "0"}]
    assert {"arrives": "in finite time"} in record["statement"]["claims"]
    assert not refused(record)
    assert_true(record, random.Random(2))


@pytest.mark.parametrize(
    "number",
    [
        {"above": "-2"},  # two roots above it
        {"polynomial": ["-1", "0", "4"]},  # not monic
        {"name": "root_x"},  # what stands for the root of the state
        {"name": "x"},
    ],
    ids=["above", "polynomial", "root", "state"],
)
def test_numbers_beside_roots_are_roots_of_polynomials_with_names_of_their_own(number: Record) -> None:
    record = certified(IRRATIONAL)
    subject = record["statement"]["subject"]
    subject["numbers"] = [{**subject["numbers"][0], **number}]
    assert is_one_line(refused(record))


def test_what_is_shown_with_one_number_is_not_with_its_negative() -> None:
    record = certified(IRRATIONAL)
    subject = record["statement"]["subject"]
    subject["rhs"] = [[formula.replace("sqrt_2", "(-sqrt_2)") for formula in side] for side in subject["rhs"]]
    assert is_one_line(refused(record))


def test_a_point_beside_roots_is_rational() -> None:
    record = certified(IRRATIONAL)
    record["statement"]["subject"]["at"][0] = [["1", 0]]
    assert "roots are rational" in refused(record)


@pytest.mark.usefixtures("without_reach")
def test_functions_of_numbers_beside_roots_are_written_as_numbers() -> None:
    record = certified([f"-sqrt(4)*{ROOT} + y", "-2*sin(pi/6)*sgn(x)"])
    assert record["statement"]["subject"]["rhs"] == [[f"-2*{ROOT} + y", "-1*sgn(x)"]]
    assert "numbers" not in record["statement"]["subject"]
    assert not refused(record)


def test_crossing_must_be_shown() -> None:
    record = certified(TWISTING)
    entry, *others = record["evidence"]
    name = next(key for key in entry["proofs"] if key.startswith("crosses"))
    without = {key: proof for key, proof in entry["proofs"].items() if key != name}
    assert name in refused({**record, "evidence": [{**entry, "proofs": without}, *others]})


def test_rates_in_the_time_of_the_roots_are_no_rates() -> None:
    rate = {"kind": "exponential", "kappa": "1/100"}
    with pytest.raises(NotShownError, match="rates in the time of the states"):
        by_roots(TWISTING, "root_x**2 - root_x*y/2 + y**2", rate=rate)
    assert not any("rate" in claim for claim in certified(TWISTING)["statement"]["claims"])
    assert {"arrives": "in finite time"} in certified(TWISTING)["statement"]["claims"]
    assert any("finite time" in line for line in left_out(certified([f"-3/2*{ROOT} + y - x", "-11/10*sgn(x) - x"])))


CHANGES: list[dict[str, Any]] = [
    {"roots": []}, {"roots": None}, {"roots": ["z"]}, {"roots": ["x", "x"]}, {"roots": "x"}, {"roots": [1]},
    {"roots": ["y"]}, {"rhs": [[f"-3*{ROOT} + y + sgn(y)/9 + sqrt(x)", "-2*sgn(x)"]]},
    {"rhs": [["-sqrt(Abs(y))", "-2*sgn(x)"]]}, {"rhs": [["-sqrt(Abs(x), 2)", "-y"]]}, {"rhs": [["-sqrt()", "-y"]]},
    {"rhs": [["-sqrt(2)", "-y"]]}, {"rhs": [["-sqrt(Abs(x, x))", "-y"]]}, {"rhs": [["-sqrt(Abs(2*x))", "-y"]]},
    {"rhs": [["-root_x", "-2*sgn(x)"]]}, {"states": ["x", "root_x"]}, {"at": ["1/3", "0"]}, {"at": ["1/4", "0"]},
]  # fmt: skip


@pytest.mark.parametrize("change", CHANGES, ids=range(len(CHANGES)))
def test_other_subjects_are_rejected_in_one_line(change: dict[str, Any]) -> None:
    record = certified(WITH_REGION)
    subject = {**record["statement"]["subject"], **change}
    assert is_one_line(refused({**record, "statement": {**record["statement"], "subject": subject}}))


# ---- an oracle of mutants (tests/proofs/attacks.py) ----------------------------------------------


def _number(text: str) -> float:
    top, _, bottom = text.partition("/")
    return int(top) / int(bottom or 1)


def followed(
    rhs: list[str], x: Any, y: Any, until: float, step: float = 2e-4, numbers: Mapping[str, Any] = MappingProxyType({})
) -> tuple[Any, Any]:
    """Where Euler polygons of the stated fields end."""
    for _ in range(int(until / step)):
        f, g = (value(text, x=x, y=y, **numbers) for text in rhs)
        x, y = np.clip(x + step * f, -9, 9), np.clip(y + step * g, -9, 9)
    return x, y


def assert_true(record: Record, source: random.Random) -> None:
    """Polygons from small starts end nearer; for instability farther."""
    subject = record["statement"]["subject"]
    angles, size = np.array([source.uniform(0, 2 * np.pi) for _ in range(6)]), 0.05
    starts = np.sign(np.cos(angles)) * (size * np.cos(angles)) ** 2, size * np.sin(angles)
    unstable = {"stability": "unstable"} in record["statement"]["claims"]
    for rhs in subject["rhs"]:  # each of them is one of the velocities that are possible
        x, y = followed(rhs, *starts, until=1.2, numbers=numbers_of(subject))
        last = float(np.maximum(np.sqrt(np.abs(x)), np.abs(y)).max() / size)
        assert last > 1 if unstable else last < 2, record


@cache
def originals(count: int = 3) -> list[Record]:
    """Valid certificates: of a V in the root of x, and so many of systems that are decided."""
    listed = (WITH_REGION, SINES[0][0], IRRATIONAL)
    return [by_roots(TWISTING, "root_x**2 - root_x*y/2 + y**2"), *map(certified, listed[:count])]
