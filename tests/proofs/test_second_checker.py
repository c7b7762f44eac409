"""A checker that was written from docs/specification.md alone says the same as the first one, of mutants too."""

from __future__ import annotations

import copy
import json
import random
from fractions import Fraction
from functools import cache
from typing import Any

import pytest
from flint import fmpq

import nonsmooth as ns
from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.formulas import no_sign
from nonsmooth.proofs.checker.polynomials import variable
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.certificates.corpus import bad_certificates, forged_text, good_certificates
from tests.oracles import second_checker
from tests.oracles.mutants import Hand, Record
from tests.oracles.second_formulas import GENS, ZERO, Poly, Reading, at_zero, number, terms
from tests.proofs.system_families import families
from tests.proofs.test_known_systems import KNOWN, build, system_of
from tests.thorough import but, few, keep

NEWER = ("proper", "growth", "denominator", "logarithm", "roots")  # hypotheses that the second checker does not know
THEOREMS = ("lyapunov", "instability", "departure", "approach")
PLANAR = {known.name: known for known in families()}
FIRST = [
    *("crossed relays, contracting", "twisting 2, 1", "Coulomb friction", "parabola far away", "node and focus"),
    *("flower", "two units, negative loop", "relays with a weak repeller", "van der Pol, reversed", "saddle"),
]
CURVED = "a V that bends on lines"  # what the second checker misses where functions bend on curves
BENT = tuple(f"bang-bang, {which}" for which in ("curved line 1/4", "curved line 1/2", "curved line 1", "turned curve"))
SHORT = (
    "two units, negative loop",
    "Coulomb friction",
    "relays",
    "bends",
    "plane",
    "saddle",
    "oscillator",
    "chain",
    "drift",
    "waves",
)  # of few numbers, for mutants
OWN = {
    "relays": ns.System(["x", "y"], ["-sign(x) + y/4 + x**3", "-sign(y) - x/4 + y**3"], radius="1/2"),
    "bends": ns.System(["x", "y"], ["-sign(x)", "-y"], lyapunov="Abs(x) + y**2", radius="1/2"),
    "plane": ns.System(["x", "y"], ["-x + y", "-x - y"]),
    "oscillator": ns.System(["x", "y"], ["y", "-x - y"], lyapunov="x**2 + y**2", radius="1/2"),
    "chain": ns.System(["x", "y", "z"], ["-x + y**2/4", "-y - sign(y)", "-z + x*y/2"], radius="1/2"),
    "drift": ns.System(["x", "y", "z"], ["1 + sign(x)/2", "-y", "x - z"], radius="1/2"),
    "waves": ns.System(["x", "y"], ["-2*x + sin(y)/4 - sin(x)/8", "-y*cos(x) - x/8"], radius="1/2"),
}


def named(name: str) -> SwitchedSystem:
    """One of the systems above, or the known one of a number."""
    if name in PLANAR:
        return system_of(PLANAR[name])
    return OWN[name].system if name in OWN else build(KNOWN[int(name)])


@cache
def text_of(name: str) -> str:
    """The certificate of a system; empty where there is none that the second checker knows."""
    try:
        record = certificate_of(decide_system(named(name)))
    except NoCertificateError:
        return ""
    older = without_newer(record)
    return json.dumps(older) if is_known(older) else ""


def without_newer(record: Record) -> Record:
    """A certificate without the entries that the second checker does not know, and without what these alone show."""
    entries = record["evidence"]
    older = [entry for entry in entries if not is_newer(entry)]
    if len(older) == len(entries):
        return record
    lost = [{"attracts": "everywhere"}, {"approaches": "everywhere"}]
    if all(entry["theorem"] != "approach" for entry in older):
        lost.append({"approaches": "near"})
    claims = [claim for claim in record["statement"]["claims"] if claim not in lost and "arrives" not in claim]
    return {**record, "statement": {**record["statement"], "claims": claims}, "evidence": older}


def is_newer(entry: Record) -> bool:
    """Whether the second checker does not know a theorem, or one of its hypotheses."""
    return entry["theorem"] == "homogeneous" or any(entry["hypotheses"].get(key) for key in NEWER)


def is_known(record: Record) -> bool:
    """Whether the second checker knows all of a certificate."""
    entries, about = record["evidence"], record["statement"]["subject"]
    theorems = {entry["theorem"] for entry in entries}
    return bool(entries) and theorems <= set(THEOREMS) and "roots" not in about and "numbers" not in about


def both(record: Record) -> tuple[str, str]:
    """Why each checker refuses a certificate."""
    return refusal(record, len(json.dumps(record))), second_checker.refusal(record)


@few(4)
@pytest.mark.parametrize("name", keep(len(FIRST), [*FIRST, *(name for name in PLANAR if name not in FIRST)]))
def test_both_checkers_accept(name: str) -> None:
    text = text_of(name)
    assert text or name not in FIRST
    if text:
        assert both(json.loads(text)) == ("", CURVED if name in BENT else "")


@few(2)
@pytest.mark.parametrize("known", keep(4, [2, 3, 8, 0, 7, *(k for k in range(len(KNOWN)) if k not in (0, 2, 3, 7, 8))]))
def test_both_accept_systems_in_three_to_six_states(known: int) -> None:
    text = text_of(str(known))
    if text:
        assert both(json.loads(text)) == ("", "")


@pytest.mark.parametrize("order", range(3))
@pytest.mark.parametrize(
    "side", [("sin(x) + x*cos(y) - (sin(y) - y)", "-cos(x) - -sin(x + y)"), ("y", "sin(2*x)*sin(y)")]
)
def test_both_checkers_count_waves_alike(side: tuple[str, str], order: int) -> None:
    system = read_system({"states": ["x", "y"], "rhs": [[*side]], "at": ["0", "0"], "order": order})
    fields = [
        [formula.on(no_sign) for formula in field]
        for field in system.fields({"x": variable(2, 0), "y": variable(2, 1)})
    ]
    other = Reading({"x": GENS[0], "y": GENS[1]}, order=order).fields(side)
    as_fractions = [[{e[:2]: Fraction(str(c)) for e, c in terms(part)} for part in field] for field in other]
    assert [[part.terms for part in field] for field in fields] == as_fractions


@few(1)
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("name", SHORT)
def test_both_checkers_agree_on_mutants(name: str, seed: int) -> None:
    """One letter of the hypotheses, the proofs or the statement is another one."""
    record, source = json.loads(text_of(name)), random.Random(seed)
    hand, refused = Hand(source, "".join(record["statement"]["subject"]["states"])), 0
    for _ in range(10):
        forged = copy.deepcopy(record)
        hand.another_letter(forged[source.choice(["statement", "evidence"])])
        first, second = both(forged)
        assert bool(first) == bool(second), (first, second, forged)
        refused += bool(first)
    assert refused


def entry_without(record: Record, key: str) -> Record:
    (entry, *others) = record["evidence"]
    proofs = {name: proof for name, proof in entry["proofs"].items() if name != key}
    return {**record, "evidence": [{**entry, "proofs": proofs}, *others]}


@few(4)
@pytest.mark.parametrize("name", but(["waves"], SHORT))
def test_both_checkers_reject(name: str) -> None:
    """A missing proof of each kind, one too many, another version, an unknown key, no claim, another claim."""
    record = json.loads(text_of(name))
    (entry, *_) = record["evidence"]
    more = {**entry, "proofs": {**entry["proofs"], "cell": {"squares": []}}}
    statement = record["statement"]
    forged: list[Any] = [
        *(entry_without(record, key) for key in {key.split()[0]: key for key in entry["proofs"]}.values()),
        {**record, "evidence": [more]},
        {**record, "version": "nonsmooth-certificate/3"},
        {**record, "more": 1},
        {**record, "evidence": []},
        {**record, "statement": {**statement, "claims": []}},
        {**record, "statement": {**statement, "claims": [{"stability": "certain"}]}},
        {**record, "statement": {**statement, "subject": {**statement["subject"], "at": ["0"]}}},
    ]
    for forgery in forged:
        assert all(both(forgery))


def test_the_corpus_is_accepted() -> None:
    """All good ones of theorems that the second checker knows, in one to eight states."""
    records = {
        name: record
        for name, record in good_certificates().items()
        if is_known(record) and without_newer(record) is record
    }
    refused = {name: second_checker.refusal(record) for name, record in records.items()}
    assert {why for why in refused.values() if why} <= {CURVED}
    assert {len(record["statement"]["subject"]["states"]) for record in records.values()} == set(range(1, 9))
    assert len(records) >= 200


@pytest.mark.parametrize("start", keep(1, range(8)))
def test_what_is_forged_of_the_corpus_is_rejected(start: int) -> None:
    """Whatever the first checker must reject."""
    good, count = good_certificates(), 0
    for forgery in bad_certificates()[start::8]:
        if forgery.of not in good or forgery.text or not is_known(good[forgery.of]):
            continue
        count += 1
        assert second_checker.refusal(json.loads(forged_text(forgery, good))), forgery
    assert count


FORMULAS = [
    *(
        "x",
        "-x**2",
        "+x - -y",
        "x/2/3",
        "2*(x + y)**3",
        "1.5e-2*x",
        ".5 + 1. + 1_0",
        "x**((2))",
        "x/(1 + 1)",
        "  x * y  ",
    ),
    *(
        "x**0x2",
        "x**-1",
        "x**2**3",
        "x**41",
        "x**2.0",
        "x**True",
        "x//2",
        "x y",
        "x/y",
        "x/0",
        "012",
        "1__0",
        "0x1",
        "1j",
    ),
    *(
        "",
        "x if x else y",
        "x and y",
        "(x,)",
        "lambda: x",
        "x # y",
        "x;y",
        "z",
        "Abs(x)",
        "f(x)",
        "x.real",
        "1e1000",
        "x\n",
    ),
]


@pytest.mark.parametrize("text", FORMULAS)
def test_both_read_the_same_formulas(text: str) -> None:
    """Of the grammar, and of what only looks like it; there is no surface by whose sign Abs(x) would be known."""
    about = {"states": ["x", "y"], "rhs": [["-x", "-y"]], "at": ["0", "0"]}
    function = f"x**2 + y**2 + 0*({text})"
    hypotheses: Record = {"cells": {"within": "1", "surfaces": [], "empty": []}, "function": function, "second": None}
    hypotheses |= {"verdict": "stable", "everywhere": False, "level": None, "below": False, "rate": None}
    plain: Record = {"simplices": [{}] * 8}
    entry = {"theorem": "lyapunov", "hypotheses": hypotheses, "proofs": {"V ": plain, "cell  field 0": plain}}
    statement = {"subject": about, "claims": [{"stability": "stable"}]}
    record = {"version": "nonsmooth-certificate/2", "statement": statement, "evidence": [entry]}
    first, second = both(record)
    assert bool(first) == bool(second), (first, second)
    assert bool(first) == (FORMULAS.index(text) >= 10)


# ---- One state: the signs of the formulas beside the point decide, whatever the theorem -------------

BESIDE = fmpq(1, 10**9)
ONE_STATE = {
    "-x": "asymptotically stable",
    "-sign(x)": "asymptotically stable",
    "-x + x**3": "asymptotically stable",
    "-relu(x)": "stable",
    "x**3 - 2*sign(x)*x**2": "asymptotically stable",
    "Abs(x)": "unstable",
    "1 + sign(x)/2": "unstable",
}


def by_signs(about: Record) -> str:
    """The verdict that the signs of all right-hand sides beside the point say."""

    def sign(value: Poly) -> int:
        return int(at_zero(value) > 0) - int(at_zero(value) < 0)

    outward = set()
    for side in (1, -1):
        place = {about["states"][0]: ZERO + number(about["at"][0]) + side * BESIDE}
        reading = Reading(place, sign, about.get("order", 0))
        outward |= {side * sign(value) for rhs in about["rhs"] for (value,) in reading.fields(rhs)}
    return {1: "unstable", 0: "stable", -1: "asymptotically stable"}[max(outward)]


@pytest.mark.parametrize("rhs", ONE_STATE)
def test_systems_in_one_state(rhs: str) -> None:
    record = certificate_of(decide_system(ns.System(["x"], [rhs]).system))
    assert {"stability": ONE_STATE[rhs]} in record["statement"]["claims"]
    assert by_signs(record["statement"]["subject"]) == ONE_STATE[rhs]
    older = without_newer(record)
    assert not is_known(older) or both(older) == ("", "")


def test_certificates_in_one_state() -> None:
    """Of all theorems."""
    claims = [record["statement"] for record in good_certificates().values()]
    listed = [
        statement
        for statement in claims
        if len(statement["subject"]["states"]) == 1 and not {"roots", "numbers"} & set(statement["subject"])
    ]
    for statement in listed:
        assert {"stability": by_signs(statement["subject"])} in statement["claims"], statement
    assert len(listed) >= 50
