"""The theorem of one solution that leaves: known systems, forgeries, mutants, and paths in floats beside each."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.statements import VERSION
from nonsmooth.proofs.checker.theorems import UNSTABLE
from nonsmooth.proofs.kernel.escapes import show_escape_of
from nonsmooth.proofs.kernel.search import NotShownError, SampledProofs, Search
from tests.oracles.floats import Floats, value
from tests.oracles.mutants import Record, is_one_line
from tests.plain import refused
from tests.thorough import but, thorough

STEP, BESIDE = 1e-2, 1e-7  # of a polygon, and of the displacement into a cell, over the distance from the point
STEPS = 20_000

LEAVING: dict[str, tuple[str, Any]] = {
    "runs into a cell": ("x y", ["1", "x"]),
    "runs into a half plane": ("x y", ["y", "2*sign(x + y)"]),
    "slides where it attracts": ("x y", ["sign(x)", "-3*sign(y)"]),
    "slides where it repels": ("x y", ["3*sign(x) - 1", "1"]),
    "slides slowly": ("x y", ["-sign(x) + y", "y - x + sign(x)*y**2"]),
    "slides along a curve": ("x y", ["-sign(x - y**2)", "1 + x"]),
    "eigenvector in a cone": ("x y", ["-x + 2*Max(y, 0)", "-y + 2*Max(x, 0)"]),
    "line between foci": ("x y", ["x/2 - y*sign(y)", "-y"]),
    "saddle": ("x y", ["x + y**2", "-y"]),
    "focus beside a curve": ("x y", ["y", "-x + y + relu(x**2 + y**2 - 1)"]),
    "one of two fields": ("x y", [["-x", "-y"], ["x/2 + y**2", "-y"]]),
    "neither of two fields alone": ("x y", [["-x/4 + y", "-y/4"], ["-x/4", "x - y/4"]]),
    "cubic ray": ("x y", ["x**3 - y**2*x*2", "-y*x**2"]),
    "three states, into a cell": ("x y z", ["y", "z", "2*sign(x + 3*y + 3*z)"]),
    "three states, slide": ("x y z", ["x + y", "-2*sign(y)", "x - z"]),
    "rises from a border where it rests": ("x y", ["-x - y", "Max(x, 0) - Max(-y, 0)"]),
    "three states, a double integrator in a plane": ("x y z", ["y", "-x*z", "-z"]),
    "along the border of a cell": ("x y", ["-x", "-3*y - 3*sign(x)"]),
    "along a border that two states keep off": ("a b c d", ["-a", "-2*b + a", "-c + b", "-3*d - 3*sign(c)"]),
    "a state that adds up one that swings": ("x y z", ["y", "z", "-y**3"]),
    "a state that adds up one that creeps home": ("x y z", ["y", "2*z", "-y**3 - 3*z"]),
    "beside a slow curve": ("x y", ["-x**3 + y", "x**8 - y**3"]),
    "beside a slow curve, turned": ("x y", ["x**8", "2*x + y**5"]),
    "where two surfaces meet": ("x y z", ["-sign(x)", "-sign(y)", "-z + 2*sign(x)*sign(y)"]),
}
# Those that are searched for half a second and more.
LONG = ("a state that adds up one that swings", "a state that adds up one that creeps home", "beside a slow curve")


def certificate(name: str) -> Record:
    states, rhs = LEAVING[name]
    system = ns.System(states.split(), rhs, radius="1/2").system
    entry, claims = show_escape_of(system, UNSTABLE)
    sides = [list(side) for side in ([rhs] if isinstance(rhs[0], str) else rhs)]
    subject = {"states": states.split(), "rhs": sides, "at": ["0"] * len(states.split())}
    record = {"version": VERSION, "statement": {"subject": subject, "claims": claims}, "evidence": [entry]}
    return json.loads(json.dumps(record))


@pytest.mark.parametrize("name", but(["a state that adds up one that creeps home", "beside a slow curve"], LEAVING))
def test_solutions_that_leave_are_certified_and_followed(name: str) -> None:
    record = certificate(name)
    assert refused(record) == ""
    assert record["statement"]["claims"] == [{"stability": "unstable"}]
    assert_leaves(record)


# ---- the oracle: a polygon of the literal fields, mixed as the certificate says ------------------


def in_floats(text: str, states: list[str]) -> Callable[[Floats], float]:
    """The test's own reading of a formula."""
    return lambda place: float(value(text, **dict(zip(states, place, strict=True))))


def assert_leaves(record: Record) -> None:
    """From near the point a polygon along a mixture of literal fields comes to the border of the cube.

    Each field of the mixture is read off a little way inside the cell that it is said to belong to.
    """
    subject, hypotheses = record["statement"]["subject"], record["evidence"][0]["hypotheses"]
    states, half = subject["states"], float(Fraction(hypotheses["within"]))
    at = np.array([float(Fraction(value)) for value in subject["at"]])
    mixture = []
    for _, number, weight, toward in hypotheses["mixture"]:
        fields = [in_floats(text, states) for text in subject["rhs"][number]]
        mixture.append((fields, in_floats(weight, states), np.array([float(Fraction(x)) for x in toward])))
    marked = zip(hypotheses["surfaces"], hypotheses["signs"], strict=True)
    zero = [in_floats(text, states) for text, sign in marked if sign == "0"]
    zero += [in_floats(text, states) for text in hypotheses["along"]]
    place = np.array([float(Fraction(x)) for x in hypotheses["direction"]])
    place = nearer(zero, 0.02 * half * place / np.abs(place).max())
    for _ in range(STEPS):
        size = float(np.abs(place).max())
        if size >= 0.9 * half:
            return
        total, velocity = 0.0, np.zeros(len(at))
        for fields, weight, toward in mixture:
            share = weight(place)
            assert share >= -1e-9, record
            beside = at + place + BESIDE * size * toward
            velocity += share * np.array([field(beside) for field in fields])
            total += share
        assert total > 0, record
        ahead = place + STEP * size * velocity / np.abs(velocity).max()
        place = nearer(zero, ahead)
        assert float(np.abs(place - ahead).max()) < 0.1 * STEP * size, record  # the mixture is tangent
    raise AssertionError(record)


def nearer(zero: list[Callable[[Floats], float]], place: Floats) -> Floats:
    """A place moved onto surfaces, by one step of Newton's method for each, with slopes by differences."""
    for surface in zero:
        moves = 1e-6 * np.eye(len(place))
        slope = np.array([(surface(place + move) - surface(place - move)) / 2e-6 for move in moves])
        place = place - surface(place) * slope / float(slope @ slope)
    return place


# ---- what is false -------------------------------------------------------------------------------

SLIDE, BORDER = "slides where it attracts", "rises from a border where it rests"
FORGED: dict[str, tuple[str, dict[str, Any], str]] = {
    "rises too slowly": (BORDER, {"speed": "5"}, "rises"),
    "no speed": (BORDER, {"speed": None}, "rises"),
    "a negative speed": (BORDER, {"speed": "-1/16"}, "a positive speed"),
    "inward": (SLIDE, {"direction": ["-1", "0"]}, "positive in the direction"),
    "not along the subspace": (SLIDE, {"direction": ["1", "1"]}, "along the subspace"),
    "a function with a value at the point": (SLIDE, {"function": "x + 1"}, "zero at the point"),
    "a function that falls": ("runs into a cell", {"function": "x - 5*x**2"}, "rises"),
    "another sign of a surface": (SLIDE, {"function": "-x", "direction": ["-1", "0"]}, "surface"),
    "a surface left out": (SLIDE, {"surfaces": ["y"], "signs": "0", "mixture": [["+", 0, "3", ["0", "1"]],
                                   ["-", 0, "3", ["0", "-1"]]]}, "products of the surfaces"),
    "a surface in two signs": (SLIDE, {"signs": "00"}, "a direction along the subspace"),
    "a field alone": (SLIDE, {"mixture": [["++", 0, "1", ["0", "1"]]]}, "tangent"),
    "weights that do not cancel": (SLIDE, {"mixture": [["++", 0, "1", ["0", "1"]], ["+-", 0, "2", ["0", "-1"]]]},
                                   "tangent"),
    "negative weights": (SLIDE, {"mixture": [["++", 0, "-1", ["0", "1"]], ["+-", 0, "-1", ["0", "-1"]]]}, "weight"),
    "no weight": (SLIDE, {"mixture": [["++", 0, "0", ["0", "1"]], ["+-", 0, "0", ["0", "-1"]]]}, "weights"),
    "the other cell twice": (SLIDE, {"mixture": [["++", 0, "1", ["0", "1"]], ["+-", 0, "1", ["0", "1"]]]}, "beside"),
    "a cell elsewhere": (SLIDE, {"mixture": [["-+", 0, "1", ["0", "1"]], ["--", 0, "1", ["0", "-1"]]]},
                         "cells beside the subspace"),
    "no field": (SLIDE, {"mixture": []}, "weights"),
    "a barrier that is crossed": ("runs into a cell", {"barriers": [["x/2 - y", "0"], ["x/2 - 8*y", "0"]]}, "proof"),
    "a start behind a barrier": ("runs into a cell", {"barriers": [["y - x", "0"]]}, "positive in the direction"),
    "the whole space": ("runs into a cell", {"within": None}, "cube"),
    "no such right-hand side": ("runs into a cell", {"mixture": [["", 1, "1", ["0", "0"]]]}, "whole number"),
}  # fmt: skip


@pytest.mark.parametrize("name", FORGED)
def test_forged_hypotheses_are_rejected(name: str) -> None:
    """With the proofs of the true ones, and with proofs that are searched for the forged ones."""
    original, changes, why = FORGED[name]
    record = certificate(original)
    entry = record["evidence"][0]
    entry["hypotheses"] = {**entry["hypotheses"], **changes}
    assert is_one_line(refused(record))
    with pytest.raises(NotShownError) as error:
        Search(1_000).entry(read_system(record["statement"]["subject"]), "escape", entry["hypotheses"])
    assert why in refused(record) or why in str(error.value)


STABLE: dict[str, tuple[str, list[Any]]] = {
    "a slide home": ("x y", ["-sign(x)", "-sign(y)"]),
    "a focus": ("x y", ["-x + y", "-x - y"]),
    "a slide home beside velocities that leave": ("x y", ["y", "-2*sign(x + y)"]),
    "a slide home on one side of a repeller": (
        "x y",
        ["sign(x)*(3*sign(y + Abs(x)) - 1)/2", "-1 - 2*sign(y + Abs(x))"],
    ),
    "a stable node with an outward velocity beside a cell": ("x y", ["-2*sign(x) + 1", "-y + sign(x) - 1/2"]),
    "a relay beside a state that comes to its surface": ("x y", ["-sign(x)", "-3*y - 3*sign(x)"]),
    "a slow curve over which no velocity leads": ("x y", ["-x**3 + y", "-x**7 - y**3"]),
    "a slide home with one eigenvalue thrice": ("a b c d", ["b", "c", "d", "-2*sign(a + 3*b + 3*c + d)"]),
}


@pytest.mark.parametrize("name", STABLE)
def test_nothing_is_shown_of_points_that_attract(name: str) -> None:
    """Neither by the writer, nor with the hypotheses of others."""
    states, rhs = STABLE[name]
    system = ns.System(states.split(), rhs, radius="1/2").system
    with pytest.raises(NotShownError):
        show_escape_of(system, UNSTABLE)


def random_hypotheses(source: random.Random) -> Record:
    """Signs, mixtures, barriers, a function and a direction by chance, few of them sound; the lines are the axes."""
    forms = ["x", "y", "-x", "-y", "x + y", "x - y", "y - x", "x**2 - y**2", "2*x - y", "x*y", "y**2 - x"]
    signs = source.choice(["++", "+-", "-+", "--", "0+", "0-", "+0", "-0"])
    mixture = []
    for k in range(1 if "0" not in signs else 2):
        cell = signs.replace("0", "-+"[k]) if source.random() < 0.9 else source.choice(["++", "+-", "-+", "--"])
        toward = [str({"-": -1, "+": 1}[sign]) for sign in cell]
        mixture.append([cell, 0, source.choice(["1", "1", "2", "x", "-y", "0"]), toward])
    direction = [{"-": -2, "+": 2, "0": 0}[sign] for sign in signs]
    direction[source.randrange(2)] //= 2
    x, y = direction
    forms = [form for form in forms if value(form, x=x, y=y) > 0]
    return {
        "within": "1/8", "surfaces": ["x", "y"], "signs": signs, "along": [], "mixture": mixture,
        "barriers": [[source.choice(forms), source.choice(["0", "-1", "1"])] for _ in range(source.randint(0, 2))],
        "function": source.choice(forms), "direction": list(map(str, direction)),
    }  # fmt: skip


def attack_by_chance(count: int, seed: int) -> int:
    """How many hypotheses by chance about random relays are shown; each is followed in floats."""
    source, shown = random.Random(seed), 0
    for _ in range(count):
        a, b, c, d = (source.randint(-2, 2) for _ in range(4))
        rhs = [f"{a}*sign(x) + {b}*sign(y) + x/4", f"{c}*sign(x) + {d}*sign(y) - y/2"]
        subject = {"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"]}
        hypotheses = random_hypotheses(source)
        try:
            SampledProofs().entry(read_system(subject), "escape", hypotheses)
            entry, claims = Search(200).entry(read_system(subject), "escape", hypotheses)
        except NotShownError:
            continue
        shown += 1
        assert_leaves({"statement": {"subject": subject, "claims": claims}, "evidence": [entry]})
    return shown


def test_what_is_shown_by_chance_is_true() -> None:
    assert attack_by_chance(300, 1) > 3


@thorough  # the small one: test_what_is_shown_by_chance_is_true
def test_what_is_shown_by_much_chance_is_true() -> None:
    assert attack_by_chance(2_000, 2) > 50


def test_long_numbers_are_charged_as_work() -> None:
    """A direction of thousands of digits, to high powers: refused before it is worked out."""
    record = certificate("saddle")
    hypotheses = record["evidence"][0]["hypotheses"]
    hypotheses["function"] = " + ".join(f"x**{i}*y**{40 - i}" for i in range(41))
    hypotheses["direction"] = ["9" * 4000 + "/" + "7" * 3999] * 2
    record["evidence"] = [json.loads(json.dumps(record["evidence"][0])) for _ in range(20)]
    assert "limits of work" in refused(record)
