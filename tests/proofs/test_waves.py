"""Sines and cosines in certificates: values, bounds on triangles, series; and subjects that hold them."""

from __future__ import annotations

import json
from fractions import Fraction
from random import Random

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth.proofs.checker.basin import Plane, barycentric
from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.polynomials import variable
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.checker.waves import BITS, LARGEST, interpolation_error, wave_value
from nonsmooth.proofs.checker.work import BUDGET, RejectedError
from nonsmooth.reports.checks.check import check_system
from tests.certificates.cases import solutions_that_leave
from tests.thorough import but

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
