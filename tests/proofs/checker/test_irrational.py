"""Certificates about systems with irrational numbers: equalities that hold exactly, and forgers who bend the numbers.

A generator is part of what is stated, so a forger who changes it claims something else; what the checker then accepts
must be true of the number that is stated now.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from math import cos, pi, sqrt
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.cells import read_numbers
from nonsmooth.proofs.checker.descriptions import describe
from nonsmooth.proofs.checker.tower import Field, Number
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.kernel.written import exact, twin, written_number
from nonsmooth.proofs.system_certificates import certificate_of, find_system_difference
from nonsmooth.proofs.system_decision import decide_system
from tests.certificates.corpus import good_arrays, good_certificates
from tests.certificates.inclusion import contradiction, half_width
from tests.plain import refused
from tests.thorough import but, few

Record = dict[str, Any]

ROOT_2 = {"name": "r", "polynomial": ["-2", "0", "1"], "above": "0"}
ROOT_3 = {"name": "s", "polynomial": ["-3", "0", "1"], "above": "0"}

# Right-hand sides, and V where one is stated.
SYSTEMS: dict[str, tuple[list[str], str | None]] = {
    "max": (["-Max(x, sqrt(2)*x)"], None),
    "centre": (["sqrt(2)*y", "-sqrt(2)*x"], None),
    "weighted centre": (["sqrt(2)*y", "-x"], "x**2 + sqrt(2)*y**2"),
    "nested centre": (["sqrt(2 + sqrt(2))*y", "-sqrt(2 + sqrt(2))*x"], "x**2 + y**2"),
    "golden centre": (["(1 + sqrt(5))/2*y", "-cos(pi/5)*2*x"], None),
    "two roots": (["sqrt(6)*y - sqrt(2)*sqrt(3)*y - x", "-y/sqrt(3)"], None),
    "line": (["-sign(x - sqrt(2)*y)", "-sign(y)"], None),
    "bends": (["-sign(x - sqrt(2)*y)", "-y"], "Abs(x - sqrt(2)*y) + x**2/2 + y**2"),
    "lines": (["-sign(x - sqrt(2)*y) - x", "-sign(x + sqrt(2)*y) - y"], None),
    "turned": (["-cos(pi/7)*sign(x) + sin(pi/7)*sign(y)", "-sin(pi/7)*sign(x) - cos(pi/7)*sign(y)"], None),
    "leaves": (["sign(x - sqrt(2)*y)", "sign(y)"], None),
    "leads away": (["sqrt(2) + sign(x - sqrt(2)*y)", "-sign(y)"], None),
    "cancels": (["-sign(x - sqrt(2)*y) + sqrt(2)*y", "-sqrt(2)*sign(y - x*sqrt(2)/2) - sqrt(2)*x"], None),
}


@cache
def record_of(name: str) -> Record:
    rhs, potential = SYSTEMS[name]
    stated: Record = {} if potential is None else {"lyapunov": potential}
    return certificate_of(decide_system(ns.System(["x", "y"][: len(rhs)], rhs, radius="1", **stated).system))


def originals() -> list[Record]:
    """Those that are attacked with mutants: small ones, with one generator and with two."""
    return [record_of(name) for name in ("max", "weighted centre", "two roots", "bends", "cancels")]


def changed(record: Record, change: Callable[[Record], None]) -> Record:
    """A copy of which something of the subject is changed."""
    found = copy.deepcopy(record)
    change(found["statement"]["subject"])
    return found


# ---- what is shown -------------------------------------------------------------------------------


@few(3)
@pytest.mark.parametrize("name", but(["turned"], SYSTEMS))
def test_the_system_itself_is_certified(name: str) -> None:
    """One right-hand side, with the irrational numbers as they are, and floats agree with what is claimed."""
    record = record_of(name)
    assert not refused(record)
    assert len(record["statement"]["subject"]["rhs"]) == 1
    assert record["statement"]["subject"]["numbers"]
    assert not contradiction(record["statement"], half_width(record["evidence"][0]["hypotheses"]))


def test_an_equality_holds_for_the_exact_number_alone() -> None:
    """``V' = 2 (r - 1.414...) x y`` has both signs, however many digits of the root of two stand there."""
    record = record_of("centre")
    assert record["statement"]["claims"] == [{"stability": "stable"}]
    near = str(Fraction(1414213562373095, 10**15))

    def with_digits(subject: Record) -> None:
        subject["rhs"][0][1] = f"-({near})*x"

    assert refused(changed(record, with_digits))


def test_the_numbers_of_the_subject_are_said_in_words() -> None:
    lines = describe(record_of("weighted centre")["statement"])
    assert lines[-1] == "sqrt_2 is the root t > 0 of (-2) + (1) t^2"


def test_numbers_beyond_floats_are_said() -> None:
    """A point at ``10^400``, and one beside which no float but zero is near."""
    plain = good_certificates()["one-linear-1"]
    for square, text in (("1" + 800 * "0", "1.00000e+400"), ("1", "1")):
        root = {"name": "t", "polynomial": [f"-{square}", "0", "1"], "above": "1/2"}
        subject = {"states": ["x"], "rhs": [["-x"]], "at": [[["1", 0]]], "numbers": [root]}
        (line, *_) = describe({**plain["statement"], "subject": subject})
        assert f"at (({text} rounded))" in line
    field = [{"polynomial": ["-2", "0", "1"], "above": "1"}]
    array = good_arrays()["array-four-wheel-nearest"]["statement"]
    drift = {"drift": [[["1", 0]], "2", "1/" + "1" + 400 * "0"]}
    lines = describe({"subject": {**array["subject"], "field": field}, "claims": [drift]})
    assert lines[-1].endswith("turns at rates from 1.41421e+400 to 2.00000e+400, rounded")


def test_a_scene_is_told_from_one_with_another_root(tmp_path: Any) -> None:
    file = tmp_path / "c.json"
    file.write_text(json.dumps(record_of("centre")))
    same, other = (ns.System(["x", "y"], [f"sqrt({n})*y", f"-sqrt({n})*x"], radius="1").system for n in (2, 3))
    assert find_system_difference(str(file), same) == ""
    assert find_system_difference(str(file), other)


# ---- forgers -------------------------------------------------------------------------------------


def test_another_root_shows_nothing_of_this_one() -> None:
    """The negative root of the polynomial, which fulfils the same equations, makes this system unstable."""
    record = certificate_of(decide_system(ns.System(["x", "y"], ["-sqrt(2)*x + y", "-sqrt(2)*y"], radius="1").system))
    assert not refused(record)

    def with_signs(subject: Record) -> None:
        subject["rhs"] = [[formula.replace("sqrt_2", "(-sqrt_2)") for formula in side] for side in subject["rhs"]]

    def below_zero(subject: Record) -> None:
        subject["numbers"][0]["above"] = "-2"

    assert refused(changed(record, with_signs))
    assert "one root" in refused(changed(record, below_zero))


@pytest.mark.parametrize(
    "entry",
    [
        {"polynomial": ["2", "0", "1"], "above": "0"},  # no root
        {"polynomial": ["-2", "0", "1"], "above": "3/2"},  # none above the bound
        {"polynomial": ["6", "-5", "1"], "above": "0"},  # two roots above it
        {"polynomial": ["-2", "0", "2"], "above": "0"},  # not monic
        {"polynomial": ["-1/2", "0", "1"], "above": "0"},  # no whole coefficients
        {"polynomial": ["-2", "1"], "above": "0"},  # of degree one
    ],
)
def test_a_generator_is_one_root(entry: Record) -> None:
    record = changed(record_of("centre"), lambda subject: subject["numbers"][0].update(entry))
    assert "field" in refused(record)


@pytest.mark.parametrize("names", [["x"], ["r", "r"], ["1r"], ["r+1"], [3]])
def test_names_of_numbers_are_names_of_nothing_else(names: list[Any]) -> None:
    def renamed(subject: Record) -> None:
        subject["numbers"] = [{**ROOT_2, "name": name} for name in names]

    assert refused(changed(record_of("centre"), renamed))


def test_a_reducible_polynomial_hides_no_zero() -> None:
    """The root above 3/2 of ``(t - 2)(t - 1)`` is two: ``r - 2`` is zero, and taken for no number with a sign."""
    tower, numbers = read_numbers([{"name": "r", "polynomial": ["2", "-3", "1"], "above": "3/2"}])
    hidden = numbers["r"] - 2
    for ask in (
        bool,
        lambda number: number > 0,
        lambda number: number == 0,
        lambda number: number.inverse(),
        lambda number: 1 / number,
    ):
        with pytest.raises(RejectedError):
            ask(hidden)
    assert tower.generator(0) > Fraction(19, 10)


def test_dependent_generators_hide_no_zero() -> None:
    """The root of six beside those of two and three: ``t - r s`` has terms, and is zero."""
    root_6 = {"name": "t", "polynomial": ["-6", "0", "1"], "above": "0"}
    _, numbers = read_numbers([ROOT_2, ROOT_3, root_6])
    hidden = numbers["t"] - numbers["r"] * numbers["s"]
    for ask in (bool, lambda number: number >= 0, lambda number: number.inverse()):
        with pytest.raises(RejectedError):
            ask(hidden)


def test_a_false_bound_of_a_rate_is_refused() -> None:
    """``V' = -2 sqrt(2) V`` is at most ``-2.828 V``, and not ``-2.829 V``."""
    record = certificate_of(decide_system(ns.System(["x", "y"], ["-sqrt(2)*x", "-sqrt(2)*y"], radius="1").system))
    entry, *_ = record["evidence"]
    for kappa, holds in (("2828/1000", True), ("2829/1000", False)):
        claimed = copy.deepcopy(record)
        hypotheses = {**entry["hypotheses"], "everywhere": False, "level": None}
        hypotheses["cells"] = {**entry["hypotheses"]["cells"], "within": "1"}
        hypotheses["rate"] = {"kind": "exponential", "kappa": kappa}
        proofs = {**entry["proofs"], "rate cell ": {"simplices": [{}] * 8}}
        claimed["evidence"] = [{**entry, "hypotheses": hypotheses, "proofs": proofs}]
        claimed["statement"]["claims"] = [{"stability": "asymptotically stable"}]
        reason = refused(claimed)
        assert ("coefficients" not in reason) if holds else reason


# ---- arithmetic ----------------------------------------------------------------------------------


def random_numbers(tower: Field, count: int, seed: int) -> list[Number]:
    rng = np.random.default_rng(seed)
    basis = tower.basis()
    return [
        tower.parse([[f"{rng.integers(-9, 10)}/{rng.integers(1, 9)}", *monomial] for monomial in basis])
        for _ in range(count)
    ]


FIELDS: dict[str, tuple[list[Record], list[float]]] = {
    "roots": ([ROOT_2, ROOT_3], [sqrt(2), sqrt(3)]),
    "golden": ([{"name": "g", "polynomial": ["-1", "1", "1"], "above": "1/2"}], [2 * cos(2 * pi / 5)]),
    "nested": (
        [ROOT_2, {"name": "n", "polynomial": [[["-2"], ["-1", 0]], "0", "1"], "above": "0"}],
        [sqrt(2), sqrt(2 + sqrt(2))],
    ),
    "of pi/7": (
        [{"name": "c", "polynomial": ["-1", "-2", "1", "1"], "above": "1"}, ROOT_2],
        [2 * cos(2 * pi / 7), sqrt(2)],
    ),
}


@pytest.mark.parametrize("name", FIELDS)
def test_arithmetic_and_order_are_those_of_real_numbers(name: str) -> None:
    entries, values = FIELDS[name]
    tower, numbers = read_numbers(entries)
    assert [float(number) for number in numbers.values()] == pytest.approx(values)
    for a, b in zip(random_numbers(tower, 12, 1), random_numbers(tower, 12, 2), strict=True):
        assert float(a * b) == pytest.approx(float(a) * float(b))
        assert float(a + b - Fraction(1, 3)) == pytest.approx(float(a) + float(b) - 1 / 3)
        assert (a > b, a == b, a > 2) == (float(a) > float(b), False, float(a) > 2)
        if b:
            assert (a / b) * b == a
            assert hash((a / b) * b) == hash(a)
            assert float(1 / b) == pytest.approx(1 / float(b))


@pytest.mark.parametrize("name", FIELDS)
def test_searches_compute_with_the_same_numbers(name: str) -> None:
    """What the checker holds is what the program computes with, and is written as it was."""
    tower, _ = read_numbers(FIELDS[name][0])
    for number in random_numbers(tower, 12, 3):
        twin_of_it = exact(number)
        assert float(twin_of_it) == pytest.approx(float(number))
        assert tower.coefficient(written_number(twin_of_it)) == number
        assert float(exact(number * number)) == pytest.approx(float(twin_of_it * twin_of_it))
    assert twin(tower) is twin(tower)
