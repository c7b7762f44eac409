"""Other checkers: one that was written from docs/specification.md alone, and those of version 1."""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.formulas import no_sign
from nonsmooth.proofs.checker.polynomials import variable
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from tests.certificates.corpus import bad_certificates, forged_text, good_certificates
from tests.oracles import earlier, second_checker
from tests.oracles.earlier import NoWordError
from tests.oracles.mutants import Hand, Record
from tests.oracles.second_formulas import GENS, Reading, terms
from tests.proofs.system_families import families
from tests.proofs.test_known_systems import KNOWN, build, system_of
from tests.proofs.test_known_systems import system_of as planar
from tests.thorough import but, few, keep

# ---- A checker that was written from docs/specification.md alone says the same as the first one, of mutants too.

NEWER = ("second", "proper", "growth", "denominator", "logarithm")  # hypotheses that the second checker does not know
PLANAR = {known.name: known for known in families()}
FIRST = [
    *("crossed relays, contracting", "twisting 2, 1", "Coulomb friction", "parabola far away", "node and focus"),
    *("flower", "two units, negative loop", "relays with a weak repeller", "van der Pol, reversed", "saddle"),
]
SHORT = (
    "two units, negative loop",
    "Coulomb friction",
    "relays",
    "bends",
    "plane",
    "saddle",
    "waves",
)  # of few numbers, for mutants
OWN = {
    "relays": ns.System(["x", "y"], ["-sign(x) + y/4 + x**3", "-sign(y) - x/4 + y**3"], radius="1/2"),
    "bends": ns.System(["x", "y"], ["-sign(x)", "-y"], lyapunov="Abs(x) + y**2", radius="1/2"),
    "plane": ns.System(["x", "y"], ["-x + y", "-x - y"]),
    "waves": ns.System(["x", "y"], ["-2*x + sin(y)/4 - sin(x)/8", "-y*cos(x) - x/8"], radius="1/2"),
}


@cache
def text_of(name: str) -> str:
    """The certificate of a system; empty where there is none by a V alone."""
    system = OWN[name].system if name in OWN else system_of(PLANAR[name])
    try:
        record = certificate_of(decide_system(system))
    except NoCertificateError:
        return ""
    known = without_newer(record)
    return json.dumps(known) if is_by_v(known) else ""


def without_newer(record: Record) -> Record:
    """A certificate without the entries of hypotheses that the second checker does not know, and what these show."""
    older = [own for own in record["evidence"] if not any(own["hypotheses"].get(key) for key in NEWER)]
    if len(older) == len(record["evidence"]):
        return record
    claims = [own for own in record["statement"]["claims"] if own != {"attracts": "everywhere"}]
    return {**record, "statement": {**record["statement"], "claims": claims}, "evidence": older}


def is_by_v(record: Record) -> bool:
    """Whether the second checker knows all of a certificate."""
    entries = record["evidence"]
    by_v = all(own["theorem"] in ("lyapunov", "instability") for own in entries)
    about = record["statement"]["subject"]
    return bool(entries) and by_v and len(about["states"]) == 2 and "roots" not in about and "numbers" not in about


def both(record: Record) -> tuple[str, str]:
    """Why each checker refuses a certificate."""
    return refusal(record, len(json.dumps(record))), second_checker.refusal(record)


@few(4)
@pytest.mark.parametrize("name", keep(len(FIRST), [*FIRST, *(name for name in PLANAR if name not in FIRST)]))
def test_both_checkers_accept(name: str) -> None:
    text = text_of(name)
    assert text or name not in FIRST
    if text:
        assert both(json.loads(text)) == ("", "")


@pytest.mark.parametrize("order", range(3))
@pytest.mark.parametrize(
    "side", [("sin(x) + x*cos(y) - (sin(y) - y)", "-cos(x) - -sin(x + y)"), ("y", "sin(2*x)*sin(y)")]
)
def test_both_checkers_count_waves_alike(side: tuple[str, str], order: int) -> None:
    system = read_system({"states": ["x", "y"], "rhs": [[*side]], "at": ["0", "0"], "order": order})
    own = [
        [formula.on(no_sign) for formula in field]
        for field in system.fields({"x": variable(2, 0), "y": variable(2, 1)})
    ]
    other = Reading({"x": GENS[0], "y": GENS[1]}, order=order).fields(side)
    as_fractions = [[{e[:2]: Fraction(str(c)) for e, c in terms(part)} for part in field] for field in other]
    assert [[part.terms for part in field] for field in own] == as_fractions


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("name", SHORT)
def test_both_checkers_agree_on_mutants(name: str, seed: int) -> None:
    """One letter of the hypotheses, the proofs or the statement is another one."""
    record, source = json.loads(text_of(name)), random.Random(seed)
    hand, refused = Hand(source, "".join(record["statement"]["subject"]["states"])), 0
    for _ in range(20):
        forged = copy.deepcopy(record)
        hand.another_letter(forged[source.choice(["statement", "evidence"])])
        first, second = both(forged)
        assert bool(first) == bool(second), (first, second, forged)
        refused += bool(first)
    assert refused


def entry_without(record: Record, key: str) -> Record:
    (entry, *others) = record["evidence"]
    proofs = {name: own for name, own in entry["proofs"].items() if name != key}
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
    for own in forged:
        assert all(both(own))


def test_the_corpus_is_accepted() -> None:
    """All good ones by a V alone, but those that ask what the second checker does not know."""
    known = {name: own for name, own in good_certificates().items() if is_by_v(own) and without_newer(own) is own}
    refused = {name: second_checker.refusal(own) for name, own in known.items()}
    assert {why for why in refused.values() if why} <= {"a V that bends on lines"}
    assert len(known) >= 50


@pytest.mark.parametrize("start", keep(1, range(8)))
def test_what_is_forged_of_the_corpus_is_rejected(start: int) -> None:
    """Whatever the first checker must reject."""
    good, seen = good_certificates(), 0
    for own in bad_certificates()[start::8]:
        if own.of not in good or own.text or not is_by_v(good[own.of]):
            continue
        seen += 1
        assert second_checker.refusal(json.loads(forged_text(own, good))), own
    assert seen


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


# ---- The checkers of version 1, which share no code with the new one, accept what it accepts, where they have words.

# What the checkers of version 1 do not show of a certificate, word for word, and why that is no contradiction.
NOT_SHOWN: Mapping[str, str] = {
    # The formulas switch on curves; version 1 takes lines in two states.
    "parabola far away": "switching expressions that are products of lines",
    "parabola": "switching expressions that are products of lines",
    "circle": "switching expressions that are products of lines",
    # The rates are not shown by halves of cells within its limits of work; without them version 1 accepts these.
    "two relays on skew lines": "V' below its bound on every cell",
    "buck converter": "V' below its bound on every cell",
    "two genes that repress themselves": "V' below its bound on every cell",
}
# Theorems and hypotheses that version 1 has no words for; each is refused with these words alone.
NO_WORDS = {
    "theorem basin",
    "theorem circles",
    "theorem escape",
    "theorem outside",
    "departure in two states",
    "instability by two functions",
    "claims below a level alone",
    "instability by a V of both signs in two states",
    "instability asked where V is not positive alone",
    "further functions in three states and more",
    "V by pieces in three states and more",
    "the whole space as the domain",
    "empty patterns by other evidence than mixtures",
    "roots in one state",
    "irrational numbers",
    "sines and cosines",
    "theorem choice",
    "theorem cascade",
    "theorem sliding",
    "theorem reversible",
    "theorem integral",
    "a V with a denominator",
    "algebraic rates",
    "surfaces and pieces without a common point",
}

FIRST_PLANAR = [
    *("relay, viscous 1", "crossed relays, contracting", "twisting 2, 1", "Coulomb friction", "parabola far away"),
    *("weak focus, cubic growth", "flower"),
]
ONE_STATE = {
    "-x": "asymptotically stable",
    "-sign(x)": "asymptotically stable",
    "-x + x**3": "asymptotically stable",
    "-relu(x)": "stable",
    "x**3 - 2*sign(x)*x**2": "asymptotically stable",
    "Abs(x)": "unstable",
    "1 + sign(x)/2": "unstable",
}


def why_not(certificate: Any) -> str:
    """What the checker of version 1 says of a certificate of version 2; empty where it accepts it."""
    try:
        return earlier.refusal(earlier.translated(certificate))
    except NoWordError as error:
        assert earlier.earlier(certificate) is None
        return f"no words: {error}"


def require_as_known(name: str, certificate: Any) -> None:
    """Version 1 accepts a certificate, unless it has no words for it or is known not to show it."""
    reason = why_not(certificate)
    if name in NOT_SHOWN:
        assert reason == NOT_SHOWN[name]
    else:
        assert reason == "" or reason.removeprefix("no words: ") in NO_WORDS


def require_agreement(name: str, result: StabilityResult) -> None:
    """Version 1 accepts a certificate, if there is one, unless it has no words for it or is known not to show it."""
    try:
        certificate = certificate_of(result)
    except NoCertificateError:
        return  # which verdicts have a certificate other tests say
    require_as_known(name, json.loads(json.dumps(certificate)))


@few(1)
@pytest.mark.parametrize("name", keep(3, [*FIRST_PLANAR, *(name for name in PLANAR if name not in FIRST_PLANAR)]))
def test_planar_systems(name: str) -> None:
    require_agreement(name, decide_system(planar(PLANAR[name])))


@few(2)
@pytest.mark.parametrize(
    "number", keep(4, [2, 3, 8, 0, 7, *(k for k in range(len(KNOWN)) if k not in (0, 2, 3, 7, 8))])
)
def test_systems_in_three_to_six_states(number: int) -> None:
    require_agreement(str(number), decide_system(build(KNOWN[number])))


@pytest.mark.parametrize("rhs", ONE_STATE)
def test_systems_in_one_state(rhs: str) -> None:
    require_agreement(rhs, decide_system(ns.System(["x"], [rhs]).system))


@pytest.mark.parametrize("start", keep(1, range(12)))
def test_the_corpus(start: int) -> None:
    """Certificates of all theorems, in one to eight states."""
    for name in list(good_certificates())[start::12]:
        require_as_known(name, good_certificates()[name])
