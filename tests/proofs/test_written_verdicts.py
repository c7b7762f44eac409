"""Verdicts on systems with fractions, sines of states and interval parameters: known truths, and polygons."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.system_facts import rewriting_words
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.plain import built
from tests.thorough import few, keep

ATTRACTS, LEAVES = Translation.ASYMPTOTICALLY_STABLE, Translation.UNSTABLE
NAMES = {"sin": np.sin, "cos": np.cos, "pi": math.pi, "Abs": np.abs, "sgn": np.sign, "Max": np.maximum}


def ends(rhs: tuple[str, str], radius: float, until: float = 60.0, step: float = 2e-3) -> float:
    """The largest of the distances that semi-implicit polygons from a small circle end with, over the radius."""
    angles = np.linspace(0.1, 6.2, 12)
    x, y = radius * np.cos(angles), radius * np.sin(angles)
    first, second = (compile(text, "rhs", "eval") for text in rhs)
    for _ in range(int(until / step)):
        y = np.clip(y + step * eval(second, dict(NAMES), {"x": x, "y": y}), -9, 9)  # noqa: S307 - this file's
        x = np.clip(x + step * eval(first, dict(NAMES), {"x": x, "y": y}), -9, 9)  # noqa: S307
    return float(np.max(np.hypot(x, y)) / radius)


KNOWN = [
    (("y", "-sin(x) - y"), ATTRACTS),  # the pendulum that hangs
    (("y", "-sin(x + pi) - y"), LEAVES),  # and the one that stands
    (("y", "-sin(x + pi) - 3*sin(x) - y"), ATTRACTS),
    (("y", "-sin(x) - sgn(x) - y"), ATTRACTS),
    (("y", "-sin(x) - y*cos(x)"), ATTRACTS),
    (("y", "-sin(x) + y*cos(x)/3"), LEAVES),
    (("y", "-x/(1 + x**2) - y"), ATTRACTS),
    (("y", "x/(1 + x**2) - y"), LEAVES),
    (("y", "-sgn(x/(1 + Abs(y))) - y/(2 + x)"), ATTRACTS),
    (("y", "-2*sgn(x + y)/(1 + y**2)"), ATTRACTS),
    (("y/(x**2 + 1)", "-sin(x)/(1 + y**2) - y"), ATTRACTS),
    (("-x/(1 - x)", "-y/(2 - x)"), ATTRACTS),
]


@few(1)
@pytest.mark.parametrize(("rhs", "truth"), KNOWN)
def test_known_systems(rhs: tuple[str, str], truth: Translation) -> None:
    result = decide_system(built(list(rhs)))
    assert result.verdict is truth
    assert result.check()
    assert not result.reach.everywhere
    assert (result.reach.rate is None) or not result.scene.scale
    assert rewriting_words(result.scene)
    last = ends(rhs, 0.05)
    assert last < 0.7 if truth is ATTRACTS else last > 3


@pytest.mark.parametrize("steps", keep(1, [40_000, 400_000]))
def test_a_weak_spiral_of_a_fraction_agrees_with_its_polygon(steps: int) -> None:
    result = decide_system(built(["y", "1 - x/(y + 1) - y"], equilibrium=[1, 0]))
    assert result.verdict is LEAVES
    x, y, sizes = 1.2, 0.0, []
    for k in range(steps):  # semi-implicit midpoint steps, of second order
        f = 1 - x / (y + 1) - y
        mx, my = x + 1e-3 * y / 2, y + 1e-3 * f / 2
        x, y = x + 1e-3 * my, y + 1e-3 * (1 - mx / (my + 1) - my)
        if k % (steps // 8) == 0:
            sizes.append(math.hypot(x - 1, y))
    assert math.isfinite(x)
    assert max(sizes[-3:]) > max(sizes[:3])


def test_what_only_encloses_claims_rays_of_all_of_it_alone() -> None:
    result = decide_system(built(["y", "-sin(x) - sgn(y)"]))  # rests where abs(sin(x)) <= 1, and so do its enclosures
    assert {str(ray) for ray in PlanePoint(result.scene).rays} == {
        f"every point of the ray through ({side}, 0) near the equilibrium is an equilibrium" for side in (1, -1)
    }
    assert result.verdict is Translation.STABLE
    assert result.check()
    moves = built(["y", "sin(x) - x + x**3/6 - x**5/240 - y"])  # x**5/240 + ..., and +-x**5/240 encloses
    assert PlanePoint(moves).rays == ()


def test_interval_parameters_hold_for_all_values() -> None:
    result = decide_system(built(["y", "-k*x - c*y"], {"k": [1, 2], "c": ["1/2", 1]}))
    assert result.verdict is ATTRACTS
    assert result.check()
    rng = np.random.default_rng(0)
    x = np.array([0.1, 0.0])
    for _ in range(20_000):  # values drawn anew at every step
        k, c = rng.uniform(1, 2), rng.uniform(0.5, 1)
        x = x + 1e-3 * np.array([x[1], -k * x[0] - c * x[1]])
    assert np.hypot(*x) < 0.01


def test_an_interval_that_holds_an_unstable_value_is_not_stable() -> None:
    result = decide_system(built(["y", "-x - c*y"], {"c": ["-1/4", 1]}))
    assert result.verdict in (LEAVES, Translation.UNDECIDED)


def test_denominators_must_not_vanish_on_the_square() -> None:
    with pytest.raises(SceneError, match="a smaller check"):
        decide_system(built(["y", "-x/(x + 1/4) - y"]))
    with pytest.raises(SceneError, match="a smaller check"):
        audit(built(["y", "-x/(x + 1/4) - y"]), "x**2 + y**2")
    assert decide_system(built(["y", "-x/(x + 1/4) - y"], radius="1/8")).verdict is ATTRACTS


def test_an_audit_speaks_of_the_stated_field() -> None:
    assert audit(built(["y", "-sin(x) - y"]), "x**2 + x*y/2 + y**2").verdict is AuditVerdict.VALID
    assert audit(built(["y", "-sin(x) - y"]), "x**2 - x*y + y**2").verdict is AuditVerdict.INVALID


@few(3)
@pytest.mark.parametrize("frequency", [1, 2, 3, "7/2", 6])
@pytest.mark.parametrize("relay", ["", " - 2*sign(x)", " - sign(x)/9"], ids=["none", "large", "small"])
def test_an_audit_with_sines_agrees_with_samples_of_the_stated_derivative(frequency: int | str, relay: str) -> None:
    """V = x^2 + y^2 has V' = 2 x x' + 2 y y'; what only encloses the sine refutes nothing."""
    system = built([f"-sin({frequency}*x){relay}", "-y"])
    found = audit(system, "x**2 + y**2")
    x = np.linspace(-0.5, 0.5, 4_001)
    friction = {"": 0.0, " - 2*sign(x)": 2.0, " - sign(x)/9": 1 / 9}[relay]
    rate = np.sin(float(Fraction(frequency)) * x) + friction * np.sign(x)
    rises = bool(np.any(-2 * x * rate > 0))
    assert found.verdict is not (AuditVerdict.VALID if rises else AuditVerdict.INVALID)
    if found.witness is not None:
        (a, _), value = (float(c) for c in found.witness.point), found.witness.value
        assert value is None
        assert a * np.sin(float(Fraction(frequency)) * a) < 0
    many = audit(built([f"-sin({frequency}*x){relay}", "-y", "-z"]), "x**2 + y**2 + z**2")
    assert many.verdict is not (AuditVerdict.VALID if rises else AuditVerdict.INVALID)


def test_an_audit_with_sines_refutes_a_function_that_rises_along_the_stated_field() -> None:
    found = audit(built(["-sin(6*x)/4 - sign(y)/8", "-sign(y)"]), "x**2 + y**2")
    assert found.verdict is AuditVerdict.INVALID
    assert found.witness is not None
    x, y = (float(c) for c in found.witness.point)
    assert 2 * x * (-np.sin(6 * x) / 4 - np.sign(y) / 8) - 2 * abs(y) > 0
    many = audit(built(["sin(x) - sign(y)/8", "-sign(y)", "-z"]), "x**2 + y**2 + z**2")
    assert many.verdict is AuditVerdict.INVALID
    assert many.witness is not None
    x, y, z = map(float, many.witness.point)
    assert x * (np.sin(x) - np.sign(y) / 8) - abs(y) - z * z > 0
