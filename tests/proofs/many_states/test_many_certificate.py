"""Certificates in three states and more: accepted without the program, and rejected when anything of them is false."""

from __future__ import annotations

import copy
import json
import random
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

from nonsmooth.proofs import many_state_checker
from nonsmooth.proofs.many_state_checker import check_certificate
from nonsmooth.proofs.many_states.audit import audit_many
from nonsmooth.proofs.many_states.decision import decide_many
from nonsmooth.proofs.many_states.examination import Inequality, answers, by_face, questions_on
from nonsmooth.proofs.many_states.many_certificate import CertifiedFunction
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.system_decision import certificate_of, decide_system
from nonsmooth.proofs.systems.system_certificate import NoCertificateError
from nonsmooth.symbolic.files.system_file import load_system, parse_lyapunov
from tests.proofs import mutants
from tests.proofs.many_states.test_attacks import built
from tests.proofs.many_states.test_random_systems import NAMES, linear, random_matrix
from tests.proofs.many_states.test_random_systems import built as built_of_many
from tests.proofs.mutants import Record, is_one_line
from tests.thorough import keep, thorough

Change: TypeAlias = Callable[[Record], Any]

BENDS = "4*Abs(x) + 4*Abs(y) + z**2"
SYSTEMS: dict[str, tuple[list[Any], dict[str, Any]]] = {
    "slides": (["-sgn(x)", "-sgn(y)", "-z"], {"lyapunov": BENDS}),
    "whole space": (["-x", "-y", "-z + Abs(x)"], {"lyapunov": "Abs(x) + Abs(y) + Abs(z)/2"}),
    "curved surface": (["-x", "-y", "-z + Abs(x*y - z)/2"], {}),
    "several planes": (["-x + relu(y - 1/8)/4", "-y", "-z + relu(y - 1/4)/4"], {}),
    "centre": (["y", "-x", "-z"], {}),
    "switched": ([["y - x", "z - y", "-x - y - z"], ["y - x", "z - y", "-x - y - 2*z"]], {}),
    "grows": (["sgn(x) + y", "-sgn(y)", "-z"], {}),
    "saddle": (["x", "-y", "-z"], {}),
    "no equilibrium": (["2 - sgn(x)", "-y", "-z"], {}),
}


@cache
def text_of(name: str) -> str:
    if name == "relay-chain":
        return json.dumps(certificate_of(decide_system(load_system(name))))
    rhs, check = SYSTEMS[name]
    return json.dumps(certificate_of(decide_many(built(rhs, **check))))


def record_of(name: str) -> Record:
    found: Record = json.loads(text_of(name))
    return found


# ---- what is true --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SYSTEMS)
def test_verdicts_are_certified(name: str) -> None:
    record = record_of(name)
    assert check_certificate(record) == ""
    rhs, check = SYSTEMS[name]
    assert record["verdict"] == str(decide_many(built(rhs, **check)).verdict)


def test_a_chain_of_relays_is_accepted_without_the_program(tmp_path: Path) -> None:
    file = tmp_path / "c.json"
    file.write_text(text_of("relay-chain"), encoding="utf-8")
    line = [sys.executable, "-I", "-S", str(Path(many_state_checker.__file__)), str(file)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout.splitlines()[0]) == (0, "valid")
    assert "every start with V <" in done.stdout


@pytest.mark.parametrize("seed", range(6))
def test_random_linear_systems_that_a_v_decides_are_certified(seed: int) -> None:
    rng = np.random.default_rng(500 + seed)
    count = int(rng.integers(3, 7))
    result = decide_many(built_of_many([linear(row) for row in random_matrix(rng, count)], count))
    try:
        record = certificate_of(result)
    except NoCertificateError as error:
        assert "received" in str(error)  # noqa: PT017 - some verdicts have none, and it says which
        return
    assert record["states"] == list(NAMES[:count])
    assert record["verdict"] == str(result.verdict)


# ---- what is false -------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "step"), keep(3, [("slides", 3), ("several planes", 1), ("grows", 1), ("slides", 1)]))
def test_every_condition_must_be_shown(name: str, step: int) -> None:
    """Each condition whose number is a multiple of the step."""
    record = record_of(name)
    for k, key in list(enumerate(record["proofs"]))[::step]:
        without = {**record, "proofs": {k: v for k, v in record["proofs"].items() if k != key}}
        assert check_certificate(without if k % 2 else {**record, "proofs": {**record["proofs"], key: []}})
    assert check_certificate({**record, "proofs": {**record["proofs"], "cell +++ field 9": []}})


@pytest.mark.parametrize(
    ("more", "planes", "face"), keep(1, [("", 2, "00+"), (" + Abs(x + y) + Abs(x - y)", 4, "00+00")])
)
def test_faces_come_from_the_checker(more: str, planes: int, face: str) -> None:
    """Some planes share the z axis, along which solutions slide outward; everything else is shown."""
    system = built(["-3*sgn(x)", "-3*sgn(y)", "sgn(z)"])
    text = f"Abs(x) + Abs(y){more} + Abs(z)"
    formula = parse_lyapunov(text, system.states, system.origin, "V")
    cells, questions = questions_on(system, formula, system.check.radius)
    shown: list[Inequality] = []
    for asked in by_face(questions.listed):
        if len(asked[0].zero) < planes:
            shown += answers(asked, Effort.STRICT)
    assert all(inequality.proved is not None for inequality in shown)
    base = decide_many(built(["-sgn(x)", "-sgn(y)", "-z"], lyapunov=BENDS))
    record = CertifiedFunction(system, formula, system.check.radius, cells).record(base, shown, direction=None)
    assert record["verdict"] == "asymptotically stable"
    assert check_certificate(record) == f"multipliers for face {face}"
    assert audit_many(system, text).proves is None


CHANGES: list[tuple[str, dict[str, Any]]] = [
    ("relay-chain", {"verdict": "unstable"}),
    ("relay-chain", {"verdict": "unstable", "direction": ["1", "0", "0"], "level": None, "rate": None}),
    ("relay-chain", {"level": "1/2"}),
    ("relay-chain", {"level": "-1/2"}),
    ("relay-chain", {"radius": "3/4"}),
    ("relay-chain", {"rate": {"kind": "finite", "kappa": "5/8"}}),
    ("relay-chain", {"rate": {"kind": "exponential", "kappa": "19/32"}}),
    ("relay-chain", {"everywhere": True}),
    ("relay-chain", {"everywhere": True, "level": None}),
    ("relay-chain", {"at": ["1/8", "0", "0"]}),
    ("relay-chain", {"faces": {}}),
    ("relay-chain", {"surfaces": ["x", "y"]}),
    ("relay-chain", {"surfaces": ["x", "x", "y", "z"]}),
    ("relay-chain", {"surfaces": ["Abs(x)", "y", "z"]}),
    ("relay-chain", {"surfaces": ["x", "y", "z", "3"]}),
    ("relay-chain", {"lyapunov": "Abs(x) + Abs(y) - Abs(z)"}),
    ("relay-chain", {"lyapunov": "Abs(x) + Abs(y) + Abs(z) + 1"}),
    ("relay-chain", {"lyapunov": "Abs(x) + Abs(y) + Abs(z) + sign(x) + 1"}),
    ("relay-chain", {"lyapunov": None}),
    ("relay-chain", {"rhs": [["-sign(x) + y/2", "-sign(y) + z/2", "sign(z) - x/2"]]}),
    ("slides", {"rhs": [["-sign(x)", "-sign(y)", "-z"], ["-sign(x)", "-sign(y)", "z"]]}),
    ("whole space", {"level": "1/1000"}),
    ("whole space", {"radius": "1/1000000"}),
    ("centre", {"verdict": "asymptotically stable"}),
    ("saddle", {"verdict": "asymptotically stable", "direction": None}),
    ("saddle", {"verdict": "stable", "direction": None}),
    ("saddle", {"direction": ["0", "1", "0"]}),
    ("saddle", {"direction": ["0", "0", "0"]}),
    ("saddle", {"direction": None}),
    ("grows", {"direction": ["0", "1", "1"]}),
    ("no equilibrium", {"direction": ["0", "1", "0"]}),
    ("no equilibrium", {"direction": ["-1", "0", "0"]}),
    ("no equilibrium", {"rhs": [["1 - sgn(x)", "-y", "-z"]]}),
    ("no equilibrium", {"verdict": "stable"}),
]


@pytest.mark.parametrize(("name", "change"), CHANGES, ids=range(len(CHANGES)))
def test_other_claims_are_rejected(name: str, change: dict[str, Any]) -> None:
    if name == "whole space" and "radius" in change:
        assert check_certificate({**record_of(name), "everywhere": False, "rate": None, **change})
    assert check_certificate({**record_of(name), **change})


EMPTY: list[Any] = [
    [[[0, "+", "1"]]], [[[0, "+", "1"], [1, "-", "1"]]], [[[0, "+", "0"]]], [[[0, "+", "1"], [0, "-", "1"]]],
    [[[0, "+", "-1"], [1, "+", "1"]]], [[[9, "+", "1"]]], [[[-1, "+", "1"]]], [[[0, "?", "1"]]], [[]], None,
    [[[0, "+", "nan"]]], [[[0.0, "+", "1"]]], [[[True, "+", "1"]]], [[[0, "+"]]], {"0": "+"},
]  # fmt: skip


@pytest.mark.parametrize("empty", EMPTY, ids=range(len(EMPTY)))
def test_cells_cannot_be_left_out(empty: Any) -> None:
    assert check_certificate({**record_of("relay-chain"), "empty": empty})


def squares_of(record: Record) -> list[Record]:
    return [square for squares in record["proofs"].values() for square in squares]


def test_multipliers_that_still_sum_up_are_rejected() -> None:
    """The same polynomial, but much of an entry moved to another of the same monomial: no longer semidefinite."""
    tried, text = 0, text_of("curved surface")
    for number, square in enumerate(squares_of(json.loads(text))):
        by_monomial: dict[tuple[int, ...], list[tuple[int, int]]] = {}
        for i, a in enumerate(square["monomials"]):
            for j, b in enumerate(square["monomials"][: i + 1]):
                by_monomial.setdefault(tuple(map(int.__add__, a, b)), []).append((i, j))
        for first, second, *_ in (entries for entries in by_monomial.values() if len(entries) > 1):
            record = json.loads(text)
            gram = squares_of(record)[number]["gram"]
            for (row, column), amount in ((first, 2000), (second, -2000)):
                share = amount if row == column else amount // 2
                gram[row][column] = str(Fraction(gram[row][column]) + share)
            tried += 1
            assert check_certificate(record) == "positive semidefinite matrices"
    assert tried


def moved(record: Record, name: str, amount: int) -> Record:
    """A proof with the polynomial kept: a product of guards is added to one square and taken from another."""
    forged = copy.deepcopy(record)
    count = len(record["states"])
    zero = [0] * count
    forged["proofs"][name] += [
        {"guards": ["b0"], "monomials": [zero], "gram": [[str(amount)]]},
        {"guards": ["b0"], "monomials": [zero], "gram": [[str(-amount)]]},
    ]
    return forged


def test_negative_squares_are_rejected() -> None:
    record = record_of("slides")
    name = next(name for name in record["proofs"] if name.startswith("cell"))
    assert check_certificate(moved(record, name, 0)) == ""
    assert "semidefinite" in check_certificate(moved(record, name, 1))
    assert "semidefinite" in check_certificate(moved(record, name, -1))


def with_square(**change: Any) -> Change:
    """How the first square of the first cell is changed."""

    def changed(record: Record) -> Record:
        name = next(name for name in record["proofs"] if name.startswith("cell"))
        record["proofs"][name][0].update(change)
        return record

    return changed


def with_entry(**change: Any) -> Change:
    """How entries of a certificate are changed."""
    return lambda record: {**record, **change}


def instead(data: Any) -> Change:
    """Other data in place of a certificate."""
    return lambda _: data


MALFORMED: list[Change] = [
    instead(None), instead([]), instead({}), instead({"schema": many_state_checker.SCHEMA}),
    with_square(guards=["s99"]), with_square(guards=["b9"]),
    with_square(guards=[0]), with_square(guards=["s0"] * 9), with_square(guards=None), with_square(monomials=[[0]]),
    with_square(monomials=[[10**9, 0, 0]]), with_square(monomials=[[-1, 0, 0]]), with_square(monomials=[[0.5, 0, 0]]),
    with_square(gram=[["nan"]]), with_square(gram=[[1]]), with_square(gram=[["1" * 5000]]), with_square(gram="11"),
    with_square(gram=[]), with_square(monomials=[[True, 0, 0]]), with_square(more=1),
    with_entry(radius="nan"), with_entry(radius=float("nan")), with_entry(radius="-1/2"), with_entry(radius="0"),
    with_entry(states=["x", "y"]), with_entry(states=["x", "y", "x"]), with_entry(states=["x"] * 99),
    with_entry(rhs=[]), with_entry(rhs=[["-x", "-y"]]), with_entry(rhs=[["-x", "-y", "w"]]),
    with_entry(rhs=[["-x", "-y", "__import__('os')"]]), with_entry(more=1),
    with_entry(rhs=[["-x", "-y", "(" * 500 + "z" + ")" * 500]]), with_entry(at=[]),
    with_entry(rhs=[["-x", "-y", "-z**999999999"]]), with_entry(proofs=[]),
    with_entry(rhs=[["-x", "-y", "-z*9e99999999"]]), with_entry(everywhere=1),
    with_entry(proofs={"V ...": 7}), with_entry(faces=[]),
    with_entry(verdict="holds"), with_entry(rate={"kind": "fast"}),
]  # fmt: skip


@pytest.mark.parametrize("change", MALFORMED, ids=range(len(MALFORMED)))
def test_malformed_data_are_rejected_in_one_line(change: Change) -> None:
    refused = check_certificate(change(record_of("slides")))
    assert is_one_line(refused)


def test_multipliers_of_faces_are_read_with_care() -> None:
    record = record_of("relay-chain")
    name = next(iter(record["faces"]))
    forged: list[Any] = [
        None,
        {"9": []},
        {"0": [["1", [0]]], "1": 3},
        {"0": [["nan", [0, 0]]]},
        {"0": [["1", [99, 0]]]},
    ]
    for mu in forged:
        assert check_certificate({**record, "faces": {**record["faces"], name: {**record["faces"][name], "mu": mu}}})
    for cell in (None, "+++++", "", 0):
        own = {**record["faces"][name], "cell": cell}
        assert check_certificate({**record, "faces": {**record["faces"], name: own}})


def test_nested_files_are_unreadable(tmp_path: Path) -> None:
    file = tmp_path / "deep.json"
    file.write_text("[" * 200_000 + "]" * 200_000, encoding="utf-8")
    assert many_state_checker.check_file(str(file))[0] == 2


def test_no_certificate_keeps_the_checker_busy() -> None:
    record = record_of("relay-chain")
    planes = [f"x + {k}*y - {k * k}*z + {k}/99" for k in range(30)]
    assert check_certificate({**record, "surfaces": ["x", "y", "z", *planes]})
    many = "+".join(f"(x + {k}*y - z)**16" for k in range(1, 60))
    assert check_certificate({**record, "rhs": [[f"-x*({many})", "-y", "-z"]]})


def test_what_has_none_says_so() -> None:
    with pytest.raises(NoCertificateError, match="received one by nothing"):
        certificate_of(decide_many(built(["y**3", "-x**3 + z**2*y", "-z*x**2"])))


# ---- mutations -----------------------------------------------------------------------------------

STATED = ("rhs", "lyapunov", "radius", "level", "rate", "verdict", "at", "direction", "surfaces", "empty", "faces")


def mutated(record: Record, source: random.Random) -> Record:
    """One digit, sign or operator of what is stated or of a proof changed; or a claim left out; or a proof moved."""
    kind = source.randrange(8)
    if kind == 0:
        return left_out(record, source)
    if kind == 1 and record["proofs"]:
        first, second = (source.choice(list(record["proofs"])) for _ in range(2))
        return {**record, "proofs": {**record["proofs"], first: record["proofs"][second]}}
    part: Record = {key: record[key] for key in STATED}
    name = source.choice(list(record["proofs"])) if record["proofs"] and kind < 5 else None
    changed = mutants.changed(part if name is None else record["proofs"][name], "xyz", source)
    return {**record, **changed} if name is None else {**record, "proofs": {**record["proofs"], name: changed}}


def left_out(record: Record, source: random.Random) -> Record:
    """Without a claim and its proofs, or with another verdict, or with another place where it holds."""
    key = source.choice(("rate", "level", "everywhere", "verdict"))
    if key == "everywhere":
        return {**record, "everywhere": not record["everywhere"]}
    if key == "verdict":
        verdicts = ("stable", "unstable", "asymptotically stable")
        return {**record, "verdict": source.choice(verdicts)}
    prefix = "rate " if key == "rate" else "border "
    return {**record, key: None, "proofs": {k: v for k, v in record["proofs"].items() if not k.startswith(prefix)}}


FUNCTIONS: dict[str, Any] = {
    **{"sign": np.sign, "sgn": np.sign, "Abs": abs, "Max": max, "Min": min},
    "relu": lambda v: max(v, 0.0),
    "sat": lambda v, low, high: max(low, min(high, v)),
}


def value(text: str, names: list[str], place: list[float]) -> float:
    """The test's own reading of a formula of its own certificates."""
    own = {**FUNCTIONS, **dict(zip(names, place, strict=True))}
    return float(eval(text, {"__builtins__": {}}, own))  # noqa: S307  # our own text


def as_float(text: str) -> float:
    top, _, bottom = text.partition("/")
    return int(top) / int(bottom or 1)


def assert_true(record: Record, source: random.Random) -> None:
    """V along Euler paths of the literal fields from random starts, whose steps chatter where solutions slide."""
    names, half = record["states"], as_float(record["radius"])
    at = [as_float(text) for text in record["at"]]

    def speed(rhs: list[str], place: list[float]) -> list[float]:
        return [value(text, names, [a + b for a, b in zip(place, at, strict=True)]) for text in rhs]

    for _ in range(3):
        rhs = source.choice(record["rhs"])
        place = [source.uniform(-half, half) * 0.9 for _ in names]
        if record["lyapunov"] is None:
            near = speed(rhs, [1e-6 * x for x in place])
            assert sum(as_float(n) * v for n, v in zip(record["direction"], near, strict=True)) > 0
            continue
        first = value(record["lyapunov"], names, place)
        size = max(*map(abs, speed(rhs, place)), 1e-9)
        for _ in range(100):
            place = [x + 1e-4 * half / size * v for x, v in zip(place, speed(rhs, place), strict=True)]
            if max(map(abs, place)) > half:
                break
        assert value(record["lyapunov"], names, place) < first + 1e-3 * abs(first) + 1e-6, record
        assert record["verdict"] == "unstable" or first > 0


def attack(count: int, seed: int) -> int:
    """How many of many mutants are accepted; each is put to the test."""
    originals = [record_of(name) for name in ("slides", "whole space", "centre", "switched", "grows", "no equilibrium")]
    originals += [record_of("several planes"), record_of("saddle")]
    return mutants.attack(originals, mutated, check_certificate, assert_true, count, seed)


@thorough  # the small one: test_other_claims_are_rejected
def test_mutants_are_rejected_or_still_true() -> None:
    assert 0 < attack(400, 1) < 400
