"""Sines and cosines of states: in certificates, where first terms cancel, and in energies."""

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
from nonsmooth.proofs.checker.formulas import series
from nonsmooth.proofs.checker.polynomials import variable
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.checker.waves import BITS, LARGEST, interpolation_error, wave_value
from nonsmooth.proofs.checker.work import BUDGET, RejectedError
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.many_states.weak_functions import find_energy_on_circles
from nonsmooth.proofs.system_certificates import certificate_of, certificate_text
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.reports.checks.check import check_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.certificates.cases import solutions_that_leave
from tests.thorough import but, thorough

# ---- Sines and cosines in certificates: values, bounds on triangles, series; and subjects that hold them.

UNSHOWN = "evidence of the claim"


def test_values_are_within_two_units() -> None:
    random = Random(1)
    with BUDGET.granted(10**6), mp.workdps(60):
        for _ in range(300):
            v = Fraction(random.randint(-(10**9), 10**9), random.randint(1, 10**9))
            v = v if abs(v) <= LARGEST else v / 10**9
            near = mp.mpf(v.numerator) / v.denominator
            for name, value in (("sin", mp.sin(near)), ("cos", mp.cos(near))):
                assert abs(value * 2**BITS - wave_value(name, v)) < 2
        assert wave_value("cos", Fraction(0)) == 2**BITS
        with pytest.raises(RejectedError):
            wave_value("sin", Fraction(LARGEST + 1))


def test_waves_on_triangles_are_within_the_bound() -> None:
    random = np.random.default_rng(2)
    for _ in range(200):
        v = [Fraction(int(own), 64) for own in random.integers(-300, 300, 3)]
        bound = interpolation_error(int(64 * (max(v) - min(v))), 64) / 2**BITS
        weights = random.dirichlet(np.ones(3), 200)
        values = np.array([float(own) for own in v])
        for wave in (np.sin, np.cos):
            assert np.abs(wave(weights @ values) - weights @ wave(values)).max() <= bound


def test_the_highest_coefficients_are_those_of_some_ends() -> None:
    """Of fields between bounds of three waves, whose combinations are asked one by one only where solutions slide."""
    system = System(("x", "y"), (("sin(x + y)*y - cos(2*x)*x", "x - sin(3*y)*x"),), (Fraction(0), Fraction(0)))
    corners = [(0, 1), (5, 2), (1, 7)]
    with BUDGET.granted(10**6):
        (field,) = Plane(system, "1/8", [], Proofs({})).fields((), corners)
        ends = [own.along((3, -2)).on(corners) for own in field.ends()]
        assert len(ends) == 8
        assert field.along((3, -2)).highest(corners) == list(map(max, zip(*ends, strict=True)))


def test_weights_on_a_side() -> None:
    """At a place between two corners these are its shares of them."""
    for a, b in (((3, -2), (7, 5)), ((0, 4), (-9, 4))):
        whole, forms = barycentric((a, b))
        for share in (Fraction(0), Fraction(1, 3), Fraction(1)):
            x, y = (p + share * (q - p) for p, q in zip(a, b, strict=True))
            found = [sum(c * x**i * y**j for (i, j), c in own.items()) / whole for own in forms]
            assert found == [1 - share, share]


def test_series_hold_sines_and_cosines() -> None:
    """The ends are fields of the inclusion: velocities lie between them, coordinate by coordinate for single waves."""
    system = System(("x", "y"), (("sin(2*x - y)*y", "cos(x) - 1"),), (Fraction(0), Fraction(0)))
    with BUDGET.granted(10**6):
        place = {name: variable(2, k, Fraction(1)) for k, name in enumerate(system.states)}
        fields = [[own.on(lambda _: 0) for own in field] for field in system.fields(place)]
    assert len(fields) == 4
    for x, y in np.random.default_rng(3).uniform(-3, 3, (100, 2)):
        stated = (np.sin(2 * x - y) * y, np.cos(x) - 1)
        for k, value in enumerate(stated):
            ends = [sum(float(c) * x**a * y**b for (a, b), c in field[k].terms.items()) for field in fields]
            assert min(ends) - 1e-9 <= value <= max(ends) + 1e-9


REFUSED = ["sin(x)**2", "sin(sin(x))", "Abs(sin(x))", "sin(Abs(x))", "sin(x, y)", "cos()", "1/sin(x)"]


@pytest.mark.parametrize("text", REFUSED)
def test_waves_stand_in_sums_and_products_alone(text: str) -> None:
    subject = {"states": ["x", "y"], "rhs": [["-x", f"-y + {text}"]], "at": ["0", "0"]}
    certificate = check_system(ns.System(["x", "y"], ["-x", "-y"]).system).certificate()
    certificate["statement"]["subject"] = subject
    said = refusal(certificate, 10**5)
    assert said
    assert UNSHOWN not in said


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
    assert formulas <= {own for side in subject["rhs"] for own in side}
    assert any("sin(" in own or "cos(" in own for side in subject["rhs"] for own in side)
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
    verdict = Translation.UNDECIDED


def checked(rhs: tuple[str, ...]) -> Any:
    return ns.System(["x", "y"][: len(rhs)], list(rhs)).check()


@pytest.mark.parametrize("rhs", [own if len(own) < 2 else pytest.param(own, marks=thorough) for own in KNOWN])
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
        asked.append(system.order)
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
@pytest.mark.parametrize("name", ["sin", "cos"])
def test_values_lie_between_neighbouring_sums(name: str, order: int) -> None:
    """Up to where rounding tells nothing."""
    ends = [series(name, variable(1, 0), e, order) for e in (0, 1)]
    for k in range(-40, 41):
        at = Fraction(k, 8)
        low, high = sorted(float(sum(c * at ** e[0] for e, c in own.terms.items())) for own in ends)
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
        names = {"sin": np.sin, "cos": np.cos, **dict(zip("abuv", z, strict=True))}
        return float(eval(text, {"__builtins__": {}}, names))  # noqa: S307 (the program's own words)

    first = energy(z)
    for _ in range(4000):
        k1 = rate(z)
        k2 = rate(z + 0.0025 * k1)
        k3 = rate(z + 0.0025 * k2)
        z = z + 0.005 / 6 * (k1 + 2 * k2 + 2 * k3 + rate(z + 0.005 * k3))
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
