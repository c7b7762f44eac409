"""Systems in one state: known truths, the formula in floats, and certificates."""

from __future__ import annotations

import json
import math
import random
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.reports.checks.check import check_system
from tests.oracles.floats import value
from tests.oracles.mutants import Record
from tests.plain import built
from tests.proofs.forged import with_deciding
from tests.thorough import but, few, keep

# ---- Systems in one state: against known truths, and against the formula in floats at points beside the equilibrium.

ATTRACTS, STAYS, LEAVES = Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE


@few(7)
@pytest.mark.parametrize(
    ("formula", "truth", "left", "right"),
    [
        ("-sgn(x)", ATTRACTS, -0.5, 0.5),
        ("-x**3", ATTRACTS, -0.5, 0.5),
        ("-sgn(x)*(1 - 4*x)", ATTRACTS, -0.5, 0.25),
        ("-x + 8*x**3", ATTRACTS, -(0.125**0.5), 0.125**0.5),
        ("-sgn(x)*(1 - 2*sgn(Abs(x) - 1/4))", ATTRACTS, -0.25, 0.25),
        ("-x + 4*Max(x - 1/3, 0)", ATTRACTS, -0.5, 4 / 9),
        ("-x + 20*Max(Min(x - 1/4, 1/40), 0)", ATTRACTS, -0.5, 5 / 19),  # a dip between two switchings
        ("sin(x) - x", ATTRACTS, -0.5, 0.5),
        ("-x/(1 - x)", ATTRACTS, -0.5, 0.5),
        ("-Abs(x)**(1/3)*sgn(x) + 16*x", ATTRACTS, -1 / 64, 1 / 64),  # of x, not of its root
        ("sgn(x)", LEAVES, None, None),
        ("x**2", LEAVES, None, None),
        ("2 - sgn(x)", LEAVES, None, None),
        ("1 - cos(x)", LEAVES, None, None),
        ("-relu(x)", STAYS, None, None),
        ("1 - sgn(x)", STAYS, None, None),
        ("0", STAYS, None, None),
    ],
)
def test_known_systems(formula: str, truth: Translation, left: float | None, right: float | None) -> None:
    result = decide_system(built([formula]))
    assert result.verdict is truth
    assert result.check()
    region = check_system(built([formula])).to_dict()["region"]
    assert (region is None) == (left is None)
    if region is not None:
        assert (region["from"], region["to"]) == (pytest.approx(left), pytest.approx(right))


def random_formula(rng: np.random.Generator) -> str:
    parts = ["x", "x**2", "x**3", "sgn(x)", "Abs(x)", "sgn(x - 1/5)", "relu(x + 1/8)", "Max(x, x**2)", "x*Abs(x)", "1"]
    chosen = rng.choice(parts, rng.integers(1, 4), replace=False)
    return " + ".join(f"({rng.integers(-3, 4)})*{part}" for part in chosen)


@pytest.mark.parametrize("seed", range(60))
def test_random_systems_against_values_beside_the_point(seed: int) -> None:
    formula = random_formula(np.random.default_rng(seed))
    result = decide_system(built([formula]))
    assert result.check()
    right, left = (value(formula, x=side * 1e-4) for side in (1, -1))
    if result.verdict is ATTRACTS:
        assert right < 0 < left
    elif right * left < 0 and right < 0:
        assert result.verdict is ATTRACTS
    if result.verdict is STAYS:
        assert right <= 0 <= left
    if right > 0 or left < 0:
        assert result.verdict is LEAVES
    for side, sign in ((result.deciding.proofs.right, 1), (result.deciding.proofs.left, -1)):
        if side.reach is None:
            continue
        for share in np.linspace(0.01, 0.99, 60):
            assert sign * value(formula, x=sign * share * float(side.reach)) < 1e-12
        if side.reach != result.scene.check.radius:
            beyond = sign * float(side.reach) * (1 + 1e-7)
            assert sign * value(formula, x=beyond) > -1e-5


@pytest.mark.usefixtures("without_reach")
def test_arbitrary_switching_counts_every_member() -> None:
    assert decide_system(built([["-x"], ["-sgn(x)"]])).verdict is ATTRACTS
    assert decide_system(built([["-x"], ["0"]])).verdict is STAYS
    assert decide_system(built([["-x"], ["x"]])).verdict is LEAVES
    assert decide_system(built(["-k*x"], {"k": [1, 2]})).verdict is ATTRACTS


def test_forged_evidence_is_refused() -> None:
    result = decide_system(built(["-x + 8*x**3"]))
    sides = result.deciding.proofs
    farther = replace(sides, right=replace(sides.right, reach=result.scene.check.radius))
    assert not with_deciding(result, proofs=farther).check()
    assert not with_deciding(result, verdict=LEAVES).check()


def test_the_region_is_in_the_state() -> None:
    found = check_system(built(["-sgn(x - 1)"], equilibrium=[1])).to_dict()
    assert found["region"]["text"] == "every start with 1/2 < x < 3/2 reaches the equilibrium"
    json.dumps(found)


# ---- Certificates in one state: what is stated is sampled in the literal formulas, and what is false has none.

EVERYWHERE, FAR = "everywhere", 1_000.0


def claims(record: Record, kind: str) -> list[Any]:
    return [claim[kind] for claim in record["statement"]["claims"] if kind in claim]


def speeds(record: Record, displacement: float) -> list[float]:
    """The literal velocities at a displacement from the point, away from it."""
    subject = record["statement"]["subject"]
    place = float(Fraction(subject["at"][0])) + displacement
    return [np.sign(displacement) * value(side, x=place) for (side,) in subject["rhs"]]


def assert_true(record: Record, source: random.Random) -> None:
    """The literal fields beside the point, and at many starts that are said to reach it."""
    beside = [speeds(record, side * 1e-7) for side in (1, -1)]
    for verdict in claims(record, "stability"):
        if verdict == "unstable":
            limits = [*beside[0], *(-v for v in beside[1])]
            assert max(map(max, beside)) > 0 or min(limits) > 0 or max(limits) < 0, record["statement"]
        else:
            fastest = max(map(max, beside))  # no formula of a degree that is read is so slow there that floats see zero
            assert fastest < 0 or (fastest == 0 and verdict == "stable"), record["statement"]
    for region in claims(record, "attracts"):
        size, level = (
            (FAR, math.inf) if region == EVERYWHERE else (float(Fraction(region[key])) for key in ("within", "below"))
        )
        for displacement in (source.uniform(-size, size) for _ in range(60)):
            if region == EVERYWHERE or value(region["function"], x=displacement) < level:
                assert max(speeds(record, displacement)) < 1e-9, (record["statement"], displacement)
    for rate in claims(record, "rate"):
        kappa, power = float(Fraction(rate["kappa"])), ("finite", "exponential", "algebraic").index(rate["kind"])
        size = FAR if rate["within"] is None else float(Fraction(rate["within"]))
        for displacement in (source.uniform(-size, size) for _ in range(60)):
            v, wider = (float(value(rate["function"], x=displacement * factor)) for factor in (1, 1 + 1e-7))
            fall = -(wider - v) / (1e-7 * abs(displacement)) * max(speeds(record, displacement))
            assert fall > (1 - 1e-5) * kappa * v**power, (record["statement"], displacement)


def starts(record: Record) -> tuple[float, float]:
    """The ends of the largest interval about the point on which V is below the level, to six digits of the cube."""
    region = next(claim for claim in claims(record, "attracts") if claim != EVERYWHERE)
    at, size = (float(Fraction(text)) for text in (record["statement"]["subject"]["at"][0], region["within"]))
    ends = []
    for side in (-1, 1):
        steps = size * np.linspace(0, 1 - 1e-9, 200_001)
        inside = [value(region["function"], x=side * float(s)) < float(region["below"]) for s in steps[::200]]
        ends.append(at + side * float(steps[::200][np.flatnonzero(inside)[-1]]))
    return ends[0], ends[1]


# ---- what is true --------------------------------------------------------------------------------

LARGE = "123456789012345678901234567890123456789"
TRUE: dict[str, tuple[list[Any], dict[str, Any], Translation, tuple[float, float] | None]] = {
    "relay": (["-sign(x)"], {"radius": 9}, ATTRACTS, (-9, 9)),
    "flat": (["-x**3"], {"radius": 1000}, ATTRACTS, (-1000, 1000)),
    "up to another equilibrium": (["-x + 8*x**3"], {"radius": 1}, ATTRACTS, (-(8**-0.5), 8**-0.5)),
    "up to a rational one": (["-x*(1 - 3*x)"], {"radius": 1}, ATTRACTS, (-1, 1 / 3)),
    "up to a double one": (["-x*(1 - 3*x)**2"], {"radius": 1}, ATTRACTS, (-1, 1 / 3)),
    "up to where the field jumps": (["-sign(x)*(1 - 2*sign(Abs(x) - 1/4))"], {}, ATTRACTS, (-0.25, 0.25)),
    "irrational switching": (["-x*(3 + 2*sign(x**2 - 2))"], {"radius": 5}, ATTRACTS, (-5, 5)),
    "switching by an even factor": (["-sign(x)*(2 + sign((x - 1/3)**2*(x - 1/4)))"], {}, ATTRACTS, (-0.5, 0.5)),
    "a narrow escape": (["-x*((x**2 - 2)**2 + 1/10**18)"], {"radius": 2}, ATTRACTS, (-2, 2)),
    "a narrow cell": (["-x*(3 + sign(x - 1/3) - sign(x - 1/3 - 1/10**9))"], {}, ATTRACTS, (-0.5, 0.5)),
    "degree 16": (["-x**15 + x**16/1000"], {}, ATTRACTS, (-0.5, 0.5)),
    "large numbers": ([f"-{LARGE}/98765432109876543210*x**3 + x**5/{LARGE}"], {}, ATTRACTS, (-0.5, 0.5)),
    "sliding from jumps": (["1/2 - sign(x)"], {"radius": 1}, ATTRACTS, (-1, 1)),
    "arbitrary switching": ([["-sign(x)"], ["-x**5"]], {"radius": 2}, ATTRACTS, (-2, 2)),
    "elsewhere": (["2 - x"], {"equilibrium": [2], "radius": 2}, ATTRACTS, (0, 4)),
    "root": (["-sqrt(Abs(x))*sign(x)"], {}, ATTRACTS, None),
    "root off its zero": (["1/2 - sqrt(Abs(x))"], {"equilibrium": ["1/4"]}, ATTRACTS, None),
    "root that leaves": (["relu(sqrt(Abs(x))*sign(x))"], {}, LEAVES, None),
    "rests on the left": (["-relu(x)"], {}, STAYS, None),
    "everywhere at rest": (["0"], {}, STAYS, None),
    "rests up to a switching": (["-relu(x - 1/4) + relu(-x)*sign(x + 1/8)*0"], {}, STAYS, None),
    "one of two leaves": ([["-x"], ["x"]], {}, LEAVES, None),
    "one of three leaves to the left": ([["0"], ["-sign(x)"], ["-relu(-x)**2/9"]], {}, LEAVES, None),
    "leaves on one side": (["x**2"], {}, LEAVES, None),
    "leaves on one side of a rest": (["relu(x)"], {}, LEAVES, None),
    "no equilibrium": (["2 - sign(x)"], {}, LEAVES, None),
}


@cache
def decided(name: str) -> StabilityResult:
    rhs, check, *_ = TRUE[name]
    return decide_system(built(rhs, **check))


@cache
def certificate(name: str) -> Record:
    """Of a true claim; attacked in tests/proofs/test_forged_certificates.py too."""
    return certificate_of(decided(name))


@pytest.mark.parametrize("name", but(["a narrow escape", "arbitrary switching", "degree 16"], TRUE))
def test_true_claims_are_certified(name: str) -> None:
    _, _, verdict, interval = TRUE[name]
    assert decided(name).verdict is verdict
    record = certificate(name)
    assert claims(record, "stability") == [str(verdict)]
    assert bool(claims(record, "attracts")) == (verdict is ATTRACTS)
    if interval is not None:
        assert starts(record) == pytest.approx(interval, abs=0.002 * (interval[1] - interval[0]))
    if "roots" not in record["statement"]["subject"]:
        assert_true(record, random.Random(1))


def test_an_end_that_is_rational_is_exact() -> None:
    """Every start up to the equilibrium at 1/3 is stated, though V stands still there."""
    (region,) = claims(certificate_of(decide_system(built(["-x*(1 - 3*x)"], radius=1))), "attracts")
    assert (region["function"], region["within"], region["below"]) == ("relu(x)**2/(1/9) + relu(-x)**2/(1)", "1", "1")


@pytest.mark.parametrize("seed", range(40))
def test_random_systems_are_certified(seed: int) -> None:
    result = decide_system(built([random_formula(np.random.default_rng(1000 + seed))]))
    record = certificate_of(result)
    assert claims(record, "stability") == [str(result.verdict)]
    assert_true(record, random.Random(seed))


@pytest.mark.usefixtures("without_reach")
def test_many_switchings_are_few_cells() -> None:
    """8 surfaces have 9 cells, not 2^8, which are more than are taken."""
    relays = " + ".join(f"sign(x - {k}/20)" for k in range(1, 9))
    assert claims(certificate_of(decide_system(built([f"-99*x - ({relays})/9*x**2"]))), "stability") == [str(ATTRACTS)]


# ---- what is false -------------------------------------------------------------------------------

FALSE: dict[str, tuple[list[Any], dict[str, Any], Translation, tuple[str, str] | None]] = {
    "wrong verdict": (["x"], {}, ATTRACTS, ("1/2", "1/2")),
    "not unstable": (["-x"], {}, LEAVES, None),
    "rest is no attraction": (["-relu(x)"], {}, ATTRACTS, ("1/2", "1/2")),
    "rest on both sides": (["0"], {}, ATTRACTS, ("1/2", "1/2")),
    "rest is not unstable": (["0"], {}, LEAVES, None),
    "no equilibrium": (["2 - sign(x)"], {}, STAYS, None),
    "leaves to the left": (["-x**2"], {}, STAYS, None),
    "one of two leaves": ([["-sign(x)"], ["x/1000"]], {}, STAYS, None),
    "one of two rests": ([["-sign(x)"], ["0"]], {}, ATTRACTS, ("1/2", "1/2")),
    "a larger interval": (["-x + 8*x**3"], {}, ATTRACTS, ("1/4", "35356/100000")),
    "an equilibrium inside": (["-x*(x - 1/2)**2"], {}, ATTRACTS, ("1", "1")),
    "turned round in a gap": (["-x*sign((x - 1/3)*(x - 1/3 - 1/1000000))"], {}, ATTRACTS, ("1", "1")),
    "slides off the point": (["-sign(x)*sign(1/2 - x)"], {}, ATTRACTS, ("1", "1")),
    "another point": (["-x"], {"equilibrium": [1]}, STAYS, None),
    "a root that rises": (["sqrt(Abs(x))*sign(x)"], {}, STAYS, None),
    "a root that is met": (["-sqrt(Abs(x))*sign(x) + 2*x"], {}, ATTRACTS, ("3/4", "3/4")),
    "an irrational equilibrium inside": (["-x*(x**2 - 2)**2"], {}, ATTRACTS, ("2", "2")),
    "rests at a jump": (
        ["-sign(x)*(1 + sign(x - 1/2))/2 - relu(1/2 - x)*sign(x)"], {}, ATTRACTS, ("1", "1")
    ),
}  # fmt: skip
LONG = 2  # the last ones, whose proofs are searched for some seconds


@pytest.mark.parametrize("name", keep(len(FALSE) - LONG, FALSE))
def test_false_claims_have_no_certificate(name: str) -> None:
    """A result with another verdict, or with a larger interval of starts."""
    rhs, check, verdict, interval = FALSE[name]
    result = forged(decide_system(built(rhs, **check)), verdict, interval)
    with pytest.raises(NoCertificateError):
        certificate_of(result)


def forged(result: StabilityResult, verdict: Translation, interval: tuple[str, str] | None) -> StabilityResult:
    ends = map(Fraction, interval or ("1", "1"))
    sides = result.deciding.proofs
    left, right = (replace(side, reach=end) for side, end in zip((sides.left, sides.right), ends, strict=True))
    claimed = with_deciding(result, verdict=verdict, proofs=replace(sides, left=left, right=right))
    return replace(claimed, equilibrium=Equilibrium.HOLDS)
