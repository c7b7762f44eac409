"""Sines, cosines and fractions of states: in certificates, where first terms cancel, in energies, and in verdicts."""

from __future__ import annotations

import copy
import json
import math
from fractions import Fraction
from functools import cache
from random import Random
from typing import Any

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth.proofs import system_decision
from nonsmooth.proofs.checker.basin import Plane, barycentric
from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.formulas import WAVES, series
from nonsmooth.proofs.checker.polynomials import variable
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.checker.waves import BITS, KINDS, LARGEST, interpolation_error, wave_value
from nonsmooth.proofs.checker.work import BUDGET, RejectedError
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.many_states.weak_functions import find_energy_on_circles
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_certificates import certificate_of, certificate_text
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.system_facts import rewriting_words
from nonsmooth.proofs.systems.findings import Method, Reach
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.reports.checks.check import check_system
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.certificates.cases import solutions_that_leave
from tests.oracles.floats import runge_kutta, value
from tests.plain import built
from tests.thorough import but, few, keep, thorough

# ---- Sines and cosines in certificates: values, bounds on triangles, series, subjects that hold them

UNSHOWN = "evidence of the claim"


def test_values_are_within_two_units() -> None:
    random = Random(1)
    with BUDGET.granted(10**6), mp.workdps(60):
        for _ in range(300):
            v = Fraction(random.randint(-(10**9), 10**9), random.randint(1, 10**9))
            v = v if abs(v) <= LARGEST else v / 10**9
            near = mp.mpf(v.numerator) / v.denominator
            for name in KINDS:
                assert abs(getattr(mp, name)(near) * 2**BITS - wave_value(name, v)) < 2
        assert wave_value("cos", Fraction(0)) == 2**BITS
        with pytest.raises(RejectedError):
            wave_value("sin", Fraction(LARGEST + 1))


def test_waves_on_triangles_are_within_the_bound() -> None:
    random = np.random.default_rng(2)
    for _ in range(200):
        v = [Fraction(int(number), 64) for number in random.integers(-300, 300, 3)]
        bound = interpolation_error(int(64 * (max(v) - min(v))), 64) / 2**BITS
        weights = random.dirichlet(np.ones(3), 200)
        values = np.array([float(number) for number in v])
        for wave in (np.sin, np.cos, np.tanh, np.arctan):
            assert np.abs(wave(weights @ values) - weights @ wave(values)).max() <= bound


def test_the_highest_coefficients_are_those_of_some_ends() -> None:
    """Of fields between bounds of three waves, whose combinations are asked one by one only where solutions slide."""
    system = System(("x", "y"), (("sin(x + y)*y - cos(2*x)*x", "x - sin(3*y)*x"),), (Fraction(0), Fraction(0)))
    corners = [(0, 1), (5, 2), (1, 7)]
    with BUDGET.granted(10**6):
        (field,) = Plane(system, "1/8", [], Proofs({})).fields((), corners)
        ends = [end.along((3, -2)).on(corners) for end in field.ends()]
        assert len(ends) == 8
        assert field.along((3, -2)).highest(corners) == list(map(max, zip(*ends, strict=True)))


def test_weights_on_a_side() -> None:
    """At a place between two corners these are its shares of them."""
    for a, b in (((3, -2), (7, 5)), ((0, 4), (-9, 4))):
        whole, forms = barycentric((a, b))
        for share in (Fraction(0), Fraction(1, 3), Fraction(1)):
            x, y = (p + share * (q - p) for p, q in zip(a, b, strict=True))
            weights = [sum(c * x**i * y**j for (i, j), c in form.items()) / whole for form in forms]
            assert weights == [1 - share, share]


def test_series_hold_sines_and_cosines() -> None:
    """The ends are fields of the inclusion: velocities lie between them, coordinate by coordinate for single waves."""
    system = System(("x", "y"), (("sin(2*x - y)*y", "cos(x) - 1"),), (Fraction(0), Fraction(0)))
    with BUDGET.granted(10**6):
        place = {name: variable(2, k, Fraction(1)) for k, name in enumerate(system.states)}
        fields = [[formula.on(lambda _: 0) for formula in field] for field in system.fields(place)]
    assert len(fields) == 4
    for x, y in np.random.default_rng(3).uniform(-3, 3, (100, 2)):
        stated = (np.sin(2 * x - y) * y, np.cos(x) - 1)
        for k, exact in enumerate(stated):
            ends = [sum(float(c) * x**a * y**b for (a, b), c in field[k].terms.items()) for field in fields]
            assert min(ends) - 1e-9 <= exact <= max(ends) + 1e-9


REFUSED = [
    "sin(x)**2",
    "sin(sin(x))",
    "Abs(sin(x))",
    "sin(Abs(x))",
    "sin(x, y)",
    "cos()",
    "1/sin(x)",
    "exp(x)",
    "tanh(atan(x))",
]


@pytest.mark.parametrize("text", REFUSED)
def test_waves_stand_in_sums_and_products_alone(text: str) -> None:
    subject = {"states": ["x", "y"], "rhs": [["-x", f"-y + {text}"]], "at": ["0", "0"]}
    certificate = check_system(ns.System(["x", "y"], ["-x", "-y"]).system).certificate()
    certificate["statement"]["subject"] = subject
    reason = refusal(certificate, 10**5)
    assert reason
    assert UNSHOWN not in reason


SYSTEMS = {
    "pendulum": (["y", "-sin(x) - y/2"], {"y", "-sin(x) - 1/2*y"}),
    "turned": (["y", "-y - cos(x + pi/6) + cos(pi/6)"], {"y"}),
    "inverted": (["y", "sin(x) - y"], {"y", "sin(x) - y"}),
    "relay": (["y", "-sin(x) - y - sign(y)"], {"y"}),
}


@pytest.mark.parametrize("name", but(["turned"], SYSTEMS))
def test_certificates_speak_of_the_stated_sines(name: str) -> None:
    rhs, formulas = SYSTEMS[name]
    certificate = check_system(ns.System(["x", "y"], rhs).system).certificate()
    subject = certificate["statement"]["subject"]
    assert formulas <= {formula for side in subject["rhs"] for formula in side}
    assert any("sin(" in formula or "cos(" in formula for side in subject["rhs"] for formula in side)
    assert not refusal(certificate, len(json.dumps(certificate)))


def test_one_solution_of_what_encloses_sines_shows_nothing() -> None:
    """Theorem ``escape`` follows one field of the inclusion, which the stated one need not."""
    certificate = next(case for case in solutions_that_leave() if "saddle" in case.name).certificate()
    assert not refusal(certificate, 10**5)
    certificate["statement"]["subject"]["rhs"][0][1] += " + 0*sin(x)"
    assert "no sines and cosines" in refusal(certificate, 10**5)


# ---- Sines and cosines whose first terms cancel: further terms of their series decide, and certificates name them.

KNOWN = {
    ("sin(x) - x + x**3/6",): ("unstable", 1),  # x^5/120
    ("x - x**3/6 - sin(x)",): ("asymptotically stable", 1),
    ("1 - x**2/2 + x**4/24 - cos(x) - x**7/1000",): ("unstable", 1),  # x^6/720: on the right alone
    ("sin(x) - x + x**3/6 - x**5/120",): ("asymptotically stable", 2),  # -x^7/5040
    ("-x", "sin(y) - y + y**3/6"): ("unstable", 1),
    ("y", "sin(x) - x + x**3/6 - y"): ("unstable", 1),
    ("y", "-sin(x) - y"): ("asymptotically stable", 0),
}


class Open:
    verdict, reach = Translation.UNDECIDED, Reach()


def checked(rhs: tuple[str, ...]) -> Any:
    return ns.System(["x", "y"][: len(rhs)], list(rhs)).check()


@pytest.mark.parametrize("rhs", [rhs if len(rhs) < 2 else pytest.param(rhs, marks=thorough) for rhs in KNOWN])
def test_further_terms_decide(rhs: tuple[str, ...]) -> None:
    """Of those in two states test_another_order_does_not_show_it decides one."""
    verdict, order = KNOWN[rhs]
    result = checked(rhs)
    assert result.verdict == verdict
    certificate = result.certificate()
    assert certificate["statement"]["subject"].get("order", 0) == order
    assert not refusal(certificate, len(certificate_text(certificate)))


def test_further_terms_are_not_tried_where_first_ones_are_larger(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[int]()

    def ask(system: SwitchedSystem) -> Open:
        asked.append(system.rewriting.order)
        return Open()

    monkeypatch.setattr(system_decision, "_decided", ask)
    for rhs, orders in ((("y", "sin(x) - x + x**3/6 - y"), [0, 1, 2]), (("y", "-k*sin(x)"), [0])):
        decide_system(ns.System(["x", "y"], list(rhs), parameters={"k": [1, 2]}).system)
        assert asked == orders
        asked.clear()


def test_another_order_does_not_show_it() -> None:
    certificate = checked(("sin(x) - x + x**3/6",)).certificate()
    assert certificate["statement"]["subject"]["order"] == 1
    assert not refusal(certificate, len(certificate_text(certificate)))
    for order in (0, 5, -1, True, "1", 1.0, None):
        forged = copy.deepcopy(certificate)
        forged["statement"]["subject"]["order"] = order
        assert refusal(forged, len(certificate_text(forged)))


@pytest.mark.parametrize("order", range(5))
@pytest.mark.parametrize("name", WAVES)
def test_values_lie_between_neighbouring_sums(name: str, order: int) -> None:
    """Up to where rounding tells nothing."""
    ends = [series(name, variable(1, 0), e, order) for e in (0, 1)]
    for k in range(-40, 1 if name == "exp" else 41):
        at = Fraction(k, 8)
        low, high = sorted(float(sum(c * at ** e[0] for e, c in end.terms.items())) for end in ends)
        assert low - 1e-9 <= getattr(math, name)(float(at)) <= high + 1e-9


# ---- Energies with sines and cosines: pendulums that swing for ever, and what shows nothing of them.

Record = dict[str, Any]

PENDULUM = ["y", "-sin(x)"]
COUPLED = ["u", "v", "-sin(a) - sin(a - b)", "-sin(b) + sin(a - b)"]


def decided(rhs: list[str]) -> StabilityResult:
    return decide_system(ns.System(["x", "y"], rhs).system)


@cache
def swinging() -> StabilityResult:
    return decided(PENDULUM)


@pytest.fixture(scope="module")
def pendulum() -> Record:
    """Its certificate."""
    return certificate_of(swinging())


def test_a_pendulum_is_stable_by_its_energy(pendulum: Record) -> None:
    result = swinging()
    assert (result.verdict, result.method) == (Translation.STABLE, Method.CIRCLES)
    assert result.check()
    assert not refusal(pendulum, len(json.dumps(pendulum)))
    assert pendulum["statement"]["claims"] == [{"stability": "stable"}]


@pytest.mark.parametrize("rhs", [["y", "-sin(x) - sin(2*x)/4"], ["y", "-2*sin(x) - y**3*0"], ["2*y", "-sin(x)"]])
def test_other_potentials(rhs: list[str]) -> None:
    found = find_energy_on_circles(ns.System(["x", "y"], rhs).system)
    assert found is not None
    *_, is_kept = found
    assert is_kept


def test_coupled_pendulums() -> None:
    """V is kept along solutions of another integrator."""
    found = find_energy_on_circles(ns.System(list("abuv"), COUPLED).system)
    assert found is not None
    _, text, _, is_kept = found
    assert is_kept
    z = np.array([0.3, -0.2, 0.1, 0.4])

    def rate(z: Any) -> Any:
        a, b, u, v = z
        return np.array([u, v, -np.sin(a) - np.sin(a - b), -np.sin(b) + np.sin(a - b)])

    def energy(z: Any) -> float:
        return float(value(text, **dict(zip("abuv", z, strict=True))))

    first = energy(z)
    for _ in range(4000):
        z = runge_kutta(rate, z, 0.005)
    assert energy(z) == pytest.approx(first, rel=1e-6)


@pytest.mark.parametrize("rhs", [["y", "sin(x)"], ["y", "-sin(x) + y/8"]])
def test_what_is_unstable_is_not_called_stable(rhs: list[str]) -> None:
    assert decided(rhs).verdict is Translation.UNSTABLE


@pytest.mark.parametrize("rhs", [["y", "-sin(x) - x"], ["y", "-sin(x/2)"], ["y", "-sin(x*y) - x**3"]])
def test_states_that_are_no_angles(rhs: list[str]) -> None:
    assert find_energy_on_circles(ns.System(["x", "y"], rhs).system) is None


FORGED: list[tuple[str, Any]] = [
    ("rhs", [["y", "-sin(x) - x"]]),
    ("rhs", [["y", "-sin(x/2)"]]),
    ("rhs", [["y", "-sin(x + y)"]]),
    ("rhs", [["y", "sin(x)"]]),
    ("rhs", [["y", "-sin(x)"], ["y", "-sin(x) + y"]]),
    ("rhs", [["y", "-sin(x) - sign(sin(x))"]]),
    ("at", ["1", "0"]),
    ("angles", []),
    ("angles", ["y"]),
    ("angles", ["x", "x"]),
    ("angles", ["x", "y"]),
    ("function", "y**2 + sin_x**2"),
    ("function", "y**2 + 2*sin_x**2 + cos_x**2"),
    ("function", "y**2 + x**2"),
]


@pytest.mark.parametrize(("key", "value"), FORGED)
def test_forged_energies_are_rejected(key: str, value: Any, pendulum: Record) -> None:
    forged = json.loads(json.dumps(pendulum))
    part = forged["statement"]["subject"] if key in {"rhs", "at"} else forged["evidence"][0]["hypotheses"]
    part[key] = value
    assert refusal(forged, 10**5)


# ---- Verdicts on systems with fractions, sines of states and interval parameters: known truths, and polygons.

ATTRACTS, LEAVES = Translation.ASYMPTOTICALLY_STABLE, Translation.UNSTABLE


def ends(rhs: tuple[str, str], radius: float, until: float = 60.0, step: float = 2e-3) -> float:
    """The largest of the distances that semi-implicit polygons from a small circle end with, over the radius."""
    angles = np.linspace(0.1, 6.2, 12)
    x, y = radius * np.cos(angles), radius * np.sin(angles)
    for _ in range(int(until / step)):
        y = np.clip(y + step * value(rhs[1], x=x, y=y), -9, 9)
        x = np.clip(x + step * value(rhs[0], x=x, y=y), -9, 9)
    return float(np.max(np.hypot(x, y)) / radius)


VERDICTS = [
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
    (("y", "-x - tanh(y)"), ATTRACTS),
    (("y", "-tanh(x + y)"), ATTRACTS),
    (("y", "-sgn(x) - tanh(2*y)"), ATTRACTS),
    (("-x + 2*tanh(x)", "-y"), LEAVES),
    (("y", "-atan(x) - atan(y)"), ATTRACTS),
    (("y", "-x - y*(2 - 3*exp(-y**2 - x**2))"), LEAVES),
    (("y", "-sin(x) - y*(1 + exp(-(3*y)**2))"), ATTRACTS),
    (("y", "-x - y*exp(-Abs(y))"), ATTRACTS),
    (("y", "-x + y*exp(-3*Abs(x) - Abs(y)/2)"), LEAVES),
    (("y", "-x - tanh(Abs(y) + relu(y))*sign(y)"), ATTRACTS),
    (("y", "-sin(Max(x, x/2)) - y"), ATTRACTS),
    (("y", "-atan(Min(2*x, x)) + y*exp(-Abs(x*y))/3"), LEAVES),
]
# Where every start comes to the point: y**2 + ln(1 + x**2) grows without bound, and falls but for y = 0.
FROM_EVERYWHERE = {("y", "-x/(1 + x**2) - y")}


@few(1)
@pytest.mark.parametrize(("rhs", "truth"), VERDICTS)
def test_known_systems(rhs: tuple[str, str], truth: Translation) -> None:
    result = decide_system(built(list(rhs)))
    assert result.verdict is truth
    assert result.check()
    assert result.reach.everywhere is (rhs in FROM_EVERYWHERE)
    assert (result.reach.rate is None) or not result.scene.rewriting.scale
    assert rewriting_words(result.scene)
    last = ends(rhs, 0.05)
    assert last < 0.7 if truth is ATTRACTS else last > 3


@pytest.mark.usefixtures("without_reach")
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
    assert audit(built(["-x", "-y", "sin(z)"]), "x**2 + y**2 + z**2").verdict is AuditVerdict.INVALID


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
