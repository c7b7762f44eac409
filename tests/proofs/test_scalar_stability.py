"""Systems in one state: against known truths, and against the formula in floats at points beside the equilibrium."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.reports.checks.check import check_system
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.plain import built
from tests.proofs.forged import with_deciding

ATTRACTS, STAYS, LEAVES = Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE
NAMES = {
    **{"sin": math.sin, "cos": math.cos, "Abs": abs, "Max": max, "Min": min},
    "sgn": lambda a: float(np.sign(a)),
    "relu": lambda a: max(a, 0.0),
}


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
    right, left = (eval(formula, dict(NAMES), {"x": side * 1e-4}) for side in (1, -1))  # noqa: S307 - of this file
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
            value = eval(formula, dict(NAMES), {"x": sign * share * float(side.reach)})  # noqa: S307
            assert sign * value < 1e-12
        if side.reach != result.scene.check.radius:
            beyond = sign * float(side.reach) * (1 + 1e-7)
            assert sign * eval(formula, dict(NAMES), {"x": beyond}) > -1e-5  # noqa: S307


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


def test_denominators_that_vanish_are_refused_in_one_line() -> None:
    with pytest.raises(SceneError, match="does not vanish on the checked interval"):
        decide_system(built(["-x/(x + 1/4)"]))


def test_the_region_is_in_the_state() -> None:
    found = check_system(built(["-sgn(x - 1)"], equilibrium=[1])).to_dict()
    assert found["region"]["text"] == "every start with 1/2 < x < 3/2 reaches the equilibrium"
    json.dumps(found)
