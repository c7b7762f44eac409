"""Forged certificates: each is refused in bounded time, or what it says is true."""

from __future__ import annotations

import copy
import json
import random
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.checker import statements
from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.positivity import Claim, Proofs
from nonsmooth.proofs.checker.statements import THEOREMS, VERSION, refusal
from nonsmooth.proofs.kernel.search import NotShownError, Search
from tests.array_certificates import check_certificate, evidence, subject
from tests.built_in import checked
from tests.certificates import inclusion
from tests.oracles.mutants import Attack, Hand, Record, is_number, leaves, other_numbers, run
from tests.proofs import test_second_function as further
from tests.proofs import test_square_roots as roots
from tests.proofs.attacks import ATTACKS, escaping, in_one_state, of_ties
from tests.proofs.test_escape_theorem import LONG
from tests.thorough import but, few, thorough

# ---- Forged certificates of arrays that ask for as much work as they can: each is refused within some seconds.
#
# The limits are counted in work, not in time, so what is refused here is refused on every machine; the allowed
# processor time is several times what an idle machine takes.

AT_ONCE = 10.0  # where nothing but the reading is asked for
RANDOM = np.random.default_rng(1)
FIRST = RANDOM.bit_generator.state  # from which every test begins, whichever ran before


def digits(count: int) -> str:
    """A whole number of so many digits, none of them zero."""
    return "".join(map(str, RANDOM.integers(1, 10, count)))


def ratio(count: int) -> str:
    """A rational number; its denominator shares no factor with others, as good as always."""
    return f"{digits(count)}/{digits(count)}"


def root(radicand: str, degree: int = 2) -> Record:
    return {"polynomial": [f"-{radicand}", *["0"] * (degree - 1), "1"], "above": "0"}


def dense_reduction(c: Record) -> None:
    """Products of powers of three roots of dense polynomials, which are long sums when they are reduced."""
    first = len(subject(c)["field"])
    for _ in range(3):
        dense = [f"-{digits(3)}", *(digits(3) for _ in range(59)), "1"]
        subject(c)["field"].append({"polynomial": dense, "above": "0"})
    subject(c)["at"] = [[["1", *[first] * 21, *[first + 1] * 21], ["1", *[first + 2] * 31]]] * 2


def nested_roots(c: Record) -> None:
    for k in range(12):
        subject(c)["field"].append(
            {"polynomial": [[["-2"], ["-1", len(subject(c)["field"]) - 1]] if k else "-2", "0", "1"], "above": "0"}
        )
    subject(c)["at"] = [[["1", *range(1, len(subject(c)["field"]))], ["1"]]] * 2


def equal_monomials(c: Record) -> None:
    subject(c)["at"] = [[[f"1/{digits(3999)}"] for _ in range(80)], "0"]


def long_bottoms(c: Record) -> None:
    first = len(subject(c)["field"])
    subject(c)["field"] += [root(str(k)) for k in range(2, 52)]
    subject(c)["at"] = [[[f"1/{digits(3999)}", first + k] for k in range(50)], "0"]


def long_root(c: Record) -> None:
    subject(c)["field"].append(root(digits(3999)))
    subject(c)["wheels"][0]["friction"][0] = [["1", len(subject(c)["field"]) - 1]]


def long_points(c: Record) -> None:
    evidence(c)["points"] = [[ratio(3999), ratio(3999), "1"] for _ in range(60)]


LIMITS = "a certificate that is checked within the limits of work"
ARRAYS: dict[str, tuple[Callable[[Record], object], str]] = {
    "dense reduction": (dense_reduction, "cell 0: a twist for each choice of rows, which it obeys"),
    "nested roots": (nested_roots, "a sign that 1536 bits show"),
    "equal monomials": (equal_monomials, LIMITS),
    "long denominators": (long_bottoms, LIMITS),
    "a long root": (long_root, LIMITS),
    "long points": (long_points, "cell 0: wheels by their distance, at every corner"),
}


@cache
def good() -> str:
    return json.dumps(build_certificate(checked("four-wheel", "nearest")))


@pytest.mark.parametrize("name", but(["equal monomials", "nested roots", "long denominators"], ARRAYS))
def test_forged_arrays_end(name: str) -> None:
    RANDOM.bit_generator.state = FIRST
    data = json.loads(good())
    forge, claim = ARRAYS[name]
    forge(data)
    start = time.process_time()
    assert check_certificate(data) == claim
    assert time.process_time() - start < AT_ONCE


# ---- Certificates of false claims that hide what happens on faces; more: tests/proofs/checker/test_statements.py.


def written(rhs: list[str], cells: Record, function: str, **more: Any) -> Record:
    """A certificate of attraction in the plane.

    Raises:
        NotShownError: where a claim of it is not shown.
    """
    subject = {"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"]}
    defaults = {"verdict": "asymptotically stable", "everywhere": False, "level": None, "below": False, "rate": None}
    hypotheses = {"cells": cells, "function": function, "second": None, **defaults, **more}
    entry, claims = Search().entry(read_system(subject), "lyapunov", hypotheses)
    return {"version": VERSION, "statement": {"subject": subject, "claims": claims}, "evidence": [entry]}


UPPER = "(1 + sign(y - x))*(1 + sign(y + x))/4"  # the quarter about the upper half of the axis
RIGHT = "(1 + sign(x))/2"
ESCAPING = [
    f"{UPPER}*({RIGHT}*y - 1) - (1 - {UPPER})*x",
    f"{UPPER}*{RIGHT}*(y - 2)/6 - (1 - {UPPER})*y",
]


def test_forms_on_a_cube_do_not_speak_of_all_space_where_their_fields_are_none() -> None:
    """V' is a form on all cells; on the axis beyond y = 2 the fields part, and what stays between them leaves."""
    right, left = np.array([3.0 - 1, (3 - 2) / 6]), np.array([-1.0, 0.0])
    between = (right + 2 * left) / 3  # at (0, 3)
    assert between[0] == 0
    assert between[1] > 0
    empty = ["++.-", "--.+", "+-+.", "-+-."]
    cells = {"within": "1/2", "surfaces": ["x", "y", "y - x", "y + x"], "empty": empty}
    function = f"4*Abs(y) + Abs(x) + {UPPER}*(2*y - 2*Abs(x))"
    record = written(ESCAPING, cells, function)
    text = json.dumps(record)
    assert refusal(json.loads(text), len(text)) == ""
    with pytest.raises(NotShownError, match="whole space"):
        written(ESCAPING, cells, function, everywhere=True)
    record["evidence"][0]["hypotheses"]["everywhere"] = True
    record["statement"]["claims"].append({"attracts": "everywhere"})
    assert "whole space" in refusal(record, len(text))


# ---- A statement that is false, for which the checker must ask something that cannot be shown ----
#
# It was accepted once: of patterns of signs that have no point too few claims were asked.

Cells = dict[str, Any]


class Believed(Proofs):
    """Proofs that show whatever is asked, and keep it: what a forger would have to show."""

    def __init__(self) -> None:
        super().__init__({})
        self.asked: dict[str, Claim] = {}

    def show(self, claim: Claim) -> None:
        self.asked[claim.name] = claim
        self.note_form(claim)


def subject_of(*rhs: str) -> dict[str, Any]:
    states = ["x", "y", "z"][: len(rhs)]
    return {"states": states, "rhs": [list(rhs)], "at": ["0"] * len(rhs)}


def attracts(cells: Cells, function: Any, **more: Any) -> dict[str, Any]:
    defaults = {"second": None, "everywhere": False, "level": None, "below": False, "rate": None, **more}
    return {"cells": cells, "function": function, "verdict": "asymptotically stable", **defaults}


def asked(rhs: tuple[str, ...], hypotheses: dict[str, Any]) -> Believed:
    proofs = Believed()
    THEOREMS["lyapunov"](read_system(subject_of(*rhs)), hypotheses, proofs)
    return proofs


def test_patterns_without_a_point_hide_no_equilibrium() -> None:
    """(0, 1/2) rests: it holds both (-1, 2) and (1, -2) in F, in cells right and left of it, where V has two slopes.

    The pattern "right of x = 0, but left of both other lines" has no point, so what is claimed there says nothing.
    """
    upper, lower = "x + y - 1/2", "x - y + 1/2"
    right = f"(1 + sign({upper}))*(1 + sign({lower}))/4"
    left = f"(1 - sign({upper}))*(1 - sign({lower}))/4"
    rhs = (f"{left} - {right} - x*(1 - {left} - {right})", f"2*{right} - 2*{left} - y*(1 - {left} - {right})")
    cells = {"within": "1", "surfaces": ["x", upper, lower], "empty": []}
    proofs = asked(rhs, attracts(cells, "20*x**2 + y**2 + 4*x*y + 2*Abs(x)*y", level="1/2"))
    face = proofs.asked["face 0.."]
    assert len(face.inequalities) == 8


def test_claims_are_compared_as_json() -> None:
    """Python takes 0 for False; a reader of the file need not."""
    about = subject_of("1 + sign(x)/2")
    hypotheses = {"cells": {"within": "1", "surfaces": ["x"], "empty": []}, "direction": ["1"]}
    entry, claims = Search().entry(read_system(about), "departure", hypotheses)
    assert {"equilibrium": False} in claims
    for value, accepted in ((False, True), (0, False)):
        statement = {"subject": about, "claims": [{"equilibrium": value}]}
        certificate = {"version": VERSION, "statement": statement, "evidence": [entry]}
        assert (refusal(certificate, 1000) == "") == accepted


# ---- Mutants of certificates: rejected in one line, or true; and each oracle sees what a careless checker would
# accept.

FEW = {
    **{
        "ties": 8,
        "further functions": 3,
        "roots": 2,
        "theorem 4": 8,
        "feedback": 2,
        "one state": 5,
        "tolerances": 3,
    },
    **{"irrational numbers": 5, "basin": 4, "basin, searched": 8, "escape": 4, "lyapunov, searched": 6},
    **{"circles, searched": 3, "triangles": 5},
}
SOME, MANY = 8, 10_000


FEWER = {
    **{"ties": partial(of_ties, 1), "further functions": partial(further.originals, 1)},
    "one state": partial(in_one_state, 6),
    "roots": partial(roots.originals, 1),
    "escape": partial(escaping, LONG),
}


def attack_of(name: str) -> Attack:
    """An attack, with fewer originals where they take time."""
    return replace(ATTACKS[name], originals=FEWER.get(name, ATTACKS[name].originals))


@pytest.mark.parametrize("name", ATTACKS)
def test_mutants_are_rejected_or_true(name: str) -> None:
    found = run(attack_of(name), FEW.get(name, SOME), seed=1)
    assert not found.false
    assert found.rejected


@thorough  # the test above tries fewer
@pytest.mark.parametrize("name", ATTACKS)
def test_many_mutants_are_rejected_or_true(name: str) -> None:
    """Some are accepted."""
    found = run(ATTACKS[name], MANY, seed=2)
    print(f"{name}: {found}")
    assert not found.false
    assert found.accepted
    assert found.rejected


@few(2)
@pytest.mark.parametrize("name", [name for name in ATTACKS if "searched" not in name and name != "further functions"])
def test_oracles_see_what_is_claimed_falsely(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A checker that believes every claim that is well formed: the oracle contradicts one.

    Floats wait long before they contradict that a point is unstable, which spares true claims alone; that they still
    contradict false ones then, test_floats_see_what_is_false shows.
    """
    monkeypatch.setattr(statements, "not_among", lambda shown, claims: [])
    monkeypatch.setattr(inclusion, "PATIENT", 1)
    attack = replace(attack_of(name), forgers=(other_claim,))
    assert run(attack, 300, seed=3, most_false=1).false


def test_the_oracle_of_further_functions_sees_another_system() -> None:
    """Without friction V is not lost; this oracle looks at the system rather than at words."""
    (record,) = further.originals(1)
    further.assert_true(record, random.Random(1))
    (rhs,) = record["statement"]["subject"]["rhs"]
    rhs[1] = rhs[1].replace("y**3", "0")
    with pytest.raises(AssertionError):
        further.assert_true(record, random.Random(1))


def other_claim(original: Record, source: random.Random) -> Record:
    """A certificate of which one word or number of a claim is another one of its kind."""
    forged = copy.deepcopy(original)
    claim = source.choice(forged["statement"]["claims"])
    ((kind, about),) = claim.items()
    numbers = [
        (holder, key) for holder, key in leaves(claim) if isinstance(holder[key], str) and is_number(holder[key])
    ]
    if isinstance(about, str) and kind in OTHER:
        claim[kind] = source.choice([word for word in OTHER[kind] if word != about])
    elif numbers:
        holder, key = source.choice(numbers)
        holder[key] = source.choice(other_numbers(holder[key], source))
    return forged


OTHER = {
    "stability": ("asymptotically stable", "stable", "unstable"),
    "translation": ("asymptotically stable", "stable", "unstable"),
    "rotation": ("unstable", "stable, not attractive"),
    "feedback": ("stabilizable", "no certificate", "not applicable"),
    "theorem 4": ("holds", "fails", "hypotheses not met"),
}


EVERY = {"states": ["x", "y"], "rhs": [["-x + 1/2", "y"]], "at": ["0", "3"], "flags": [True, None, 7, {}]}


def test_a_hand_changes_something_of_every_kind() -> None:
    """Every change happens, keeps what is JSON, and leaves documents without a place for it as they are."""
    for change in {change.__name__ for change in Hand(random.Random(0), "xy").any}:
        texts = set[str]()
        for seed in range(40):
            document, hand = copy.deepcopy(EVERY), Hand(random.Random(seed), "xy")
            hand.change(document, [getattr(hand, change)])
            texts.add(json.dumps(document))
            hand.change([], [getattr(hand, change)])
        assert len(texts - {json.dumps(EVERY)}) > 1, change
