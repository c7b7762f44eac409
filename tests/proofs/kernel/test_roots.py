"""Certificates in signed roots: super-twisting and others, and what would be true of the roots alone."""

from __future__ import annotations

import copy
import random
from functools import cache
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.checker.descriptions import describe
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.statements import VERSION
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.system_certificates import certificate_of, left_out
from nonsmooth.proofs.system_decision import decide_system
from tests.oracles.mutants import Record, is_one_line
from tests.plain import built, refused
from tests.proofs.test_square_roots import NAMES, ROOT
from tests.thorough import few, keep

ATTRACTS = "asymptotically stable"
TWISTING = [f"-2*{ROOT} + y", "-sgn(x)"]
WITH_REGION = [f"-3*{ROOT} + y + sgn(y)/9", "-2*sgn(x)"]
TANKS = ["1/2 - sqrt(Abs(x))", "sqrt(Abs(x)) - sqrt(Abs(y))", "sqrt(Abs(y)) - sqrt(Abs(z))"]
NEVER_EMPTY = ["-..", ".-.", "..-"]  # the tanks' levels near the point: their roots are positive


def written(subject: Record, theorem: str, hypotheses: Record) -> Record:
    """A certificate of what a theorem shows; NotShownError where a hypothesis is not shown."""
    entry, shown = Search().entry(read_subject(subject), theorem, hypotheses)
    return {"version": VERSION, "statement": {"subject": subject, "claims": shown}, "evidence": [entry]}


def by_roots(rhs: list[str], function: str, verdict: str = ATTRACTS, **more: Any) -> Record:
    """A certificate in two states by a V in the root of x."""
    cells = {"within": "1/2", "surfaces": ["root_x", "y"], "empty": []}
    options = {"second": None, "everywhere": False, "level": None, "below": False, "rate": None}
    hypotheses = {"cells": cells, "function": function, "verdict": verdict, **options, **more}
    return written({"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"], "roots": ["x"]}, "lyapunov", hypotheses)


def certified(rhs: list[str]) -> Record:
    """The certificate of a system about the origin; a copy of one that is built once."""
    return copy.deepcopy(_certified(tuple(rhs)))


@cache
def _certified(rhs: tuple[str, ...]) -> Record:
    return certificate_of(decide_system(built(list(rhs))))


# ---- what is true --------------------------------------------------------------------------------

KNOWN = [
    WITH_REGION,
    TWISTING,
    [f"-3/2*{ROOT} + y - x", "-11/10*sgn(x) - x"],
    [f"-3*{ROOT} + y", "-11/10*sgn(x) + 1/2*sgn(y)"],
    ["y", f"-2*sgn(y + {ROOT})"],
]


@few(1)
@pytest.mark.parametrize("rhs", keep(2, KNOWN))
def test_super_twisting_and_its_kin_are_certified(rhs: list[str]) -> None:
    record = certified(rhs)
    subject, claims = record["statement"]["subject"], record["statement"]["claims"]
    assert (claims[0], subject["rhs"], subject["roots"]) == ({"stability": ATTRACTS}, [rhs], ["x"])
    assert refused({**record, "statement": {**record["statement"], "claims": [{"stability": "unstable"}]}})
    assert_true(record, random.Random(1))


def test_the_region_is_stated_in_the_roots() -> None:
    """V < level within the cube of (root_x, y): starts there end at the point, along Euler polygons."""
    record = certified(WITH_REGION)
    region = next(own["attracts"] for own in record["statement"]["claims"] if "attracts" in own)
    assert region["in"] == ["root_x", "y"]
    line = describe(record["statement"])[0]
    assert line.startswith("system in x, y at (0, 0), root_x = sign(x)*sqrt(Abs(x)): asymptotically stable")
    rng, size = np.random.default_rng(3), _number(region["within"])
    w, y = rng.uniform(-size, size, (2, 400))
    inside = _values(region["function"], root_x=w, y=y) < _number(region["below"])
    assert 20 < inside.sum() < 400
    x, y = followed(WITH_REGION, w[inside] * np.abs(w[inside]), y[inside], until=3.0)
    assert max(np.sqrt(np.abs(x)).max(), np.abs(y).max()) < 0.05


def test_arbitrary_switching_growth_and_velocities_at_the_point() -> None:
    disturbed = built([f"-3*{ROOT} + y", "-11/10*sgn(x) + d"], {"d": ["-1/2", "1/2"]})
    assert certificate_of(decide_system(disturbed))["statement"]["claims"][0] == {"stability": ATTRACTS}
    grows = built([f"1/2*{ROOT} + y", "-11/10*sgn(x)"])
    assert certificate_of(decide_system(grows))["statement"]["claims"] == [{"stability": "unstable"}]
    # In the time of the roots y rests at the point; in that of the states it falls.
    subject = {"states": ["x", "y"], "rhs": [[f"-{ROOT} + y", "-1 - sgn(x)/2"]], "at": ["0", "0"], "roots": ["x"]}
    cells = {"within": "1/2", "surfaces": ["root_x"], "empty": []}
    leaves = written(subject, "departure", {"cells": cells, "direction": ["0", "-1"]})
    assert (refused(leaves), leaves["statement"]["claims"][0]) == ("", {"stability": "unstable"})
    with pytest.raises(NotShownError):
        written(subject, "departure", {"cells": cells, "direction": ["0", "1"]})


def test_one_solution_that_leaves() -> None:
    """x grows like t^2/4 from any start on the right, along the field of one of two right-hand sides."""
    rhs = [[f"-{ROOT}", "-y"], ["sqrt(Abs(x))", "-y"]]
    subject = {"states": ["x", "y"], "rhs": rhs, "at": ["0", "0"], "roots": ["x"]}
    mixture = [["+", 1, "1", ["1", "0"]]]
    own = {"within": "1/2", "surfaces": ["root_x"], "signs": "+", "along": ["y"], "mixture": mixture, "barriers": []}
    record = written(subject, "escape", {**own, "function": "root_x", "direction": ["1", "0"]})
    assert (refused(record), record["statement"]["claims"]) == ("", [{"stability": "unstable"}])
    still = [["+", 0, "1", ["1", "0"]]]
    with pytest.raises(NotShownError):
        written(subject, "escape", {**own, "mixture": still, "function": "root_x", "direction": ["1", "0"]})


def test_roots_away_from_zero_in_two_states_and_three() -> None:
    system = built(["1/2 - sqrt(Abs(x))", "sqrt(Abs(x)) - sqrt(Abs(y))"], equilibrium=["1/4", "1/4"])
    record = certificate_of(decide_system(system))
    subject = record["statement"]["subject"]
    assert (subject["at"], subject["roots"]) == (["1/4", "1/4"], ["x", "y"])
    elsewhere = {**record["statement"], "subject": {**subject, "at": ["1/2", "1/4"]}}
    assert refused({**record, "statement": elsewhere}) == "a point whose roots are rational"
    names = ["x", "y", "z"]
    tanks = {"states": names, "rhs": [TANKS], "at": ["1/4"] * 3, "roots": names}
    surfaces = [f"root_{name} + 1/2" for name in names]
    hypotheses = {
        "cells": {"within": "1/8", "surfaces": surfaces, "empty": NEVER_EMPTY},
        "function": " + ".join(f"root_{name}**2" for name in names),
        **{"second": None, "verdict": ATTRACTS, "everywhere": False, "level": "1/64", "below": False, "rate": None},
    }
    assert refused(written(tanks, "lyapunov", hypotheses)) == ""


# ---- what is false -------------------------------------------------------------------------------

FALSE: dict[str, tuple[list[str], str, str]] = {
    # in the time of the roots nothing moves on x = 0; in the stated time y grows there
    "slides outward where the root is zero": (["-sgn(x)", "y/10"], "root_x**2 + y**2", "stable"),
    "slides along a part of it": ([f"-{ROOT} + Max(y - 1/4, 0)", "y/9"], "root_x**2 + y**2/9", "stable"),
    "damped the wrong way": ([f"{ROOT} + y", "-sgn(x)"], "root_x**2 + y**2/2", ATTRACTS),
    "not damped": (["y", "-sgn(x)"], "root_x**2 + y**2/2", ATTRACTS),
    "no equilibrium": ([f"1 - {ROOT}", "-y"], "root_x**2 + y**2", ATTRACTS),
    "V of the state": (TWISTING, "x**2 + y**2", ATTRACTS),
    "roots in the right-hand side": (["-root_x + y", "-sgn(x)"], "root_x**2 + y**2", ATTRACTS),
}


@pytest.mark.parametrize("name", keep(4, FALSE))
def test_false_claims_are_not_shown(name: str) -> None:
    rhs, function, verdict = FALSE[name]
    with pytest.raises(NotShownError):
        by_roots(rhs, function, verdict)


@pytest.mark.parametrize("bad", [["-sgn(x)", "y/10"], ["-sgn(x)*y", "-y"]])
def test_the_reason_is_that_nothing_crosses(bad: list[str]) -> None:
    """V does not rise in the roots' time; solutions slide along x = 0, or speeds across it differ in sign."""
    with pytest.raises(NotShownError, match="no proof was found of crosses 0 speeds"):
        by_roots(bad, "root_x**2 + y**2", "stable")


def test_crossing_must_be_shown() -> None:
    record = certified(TWISTING)
    (entry,) = record["evidence"]
    name = next(key for key in entry["proofs"] if key.startswith("crosses"))
    without = {key: proof for key, proof in entry["proofs"].items() if key != name}
    assert name in refused({**record, "evidence": [{**entry, "proofs": without}]})


def test_rates_in_the_time_of_the_roots_are_no_rates() -> None:
    rate = {"kind": "exponential", "kappa": "1/100"}
    with pytest.raises(NotShownError, match="rates in the time of the states"):
        by_roots(TWISTING, "root_x**2 - root_x*y/2 + y**2", rate=rate)
    assert not any("rate" in own for own in certified(TWISTING)["statement"]["claims"])
    assert any("finite time" in line for line in left_out(certified(TWISTING)))


CHANGES: list[dict[str, Any]] = [
    {"roots": []}, {"roots": None}, {"roots": ["z"]}, {"roots": ["x", "x"]}, {"roots": "x"}, {"roots": [1]},
    {"roots": ["y"]}, {"rhs": [[f"-3*{ROOT} + y + sgn(y)/9 + sqrt(x)", "-2*sgn(x)"]]},
    {"rhs": [["-sqrt(Abs(y))", "-2*sgn(x)"]]}, {"rhs": [["-sqrt(Abs(x), 2)", "-y"]]}, {"rhs": [["-sqrt()", "-y"]]},
    {"rhs": [["-sqrt(2)", "-y"]]}, {"rhs": [["-sqrt(Abs(x, x))", "-y"]]}, {"rhs": [["-sqrt(Abs(2*x))", "-y"]]},
    {"rhs": [["-root_x", "-2*sgn(x)"]]}, {"states": ["x", "root_x"]}, {"at": ["1/3", "0"]}, {"at": ["1/4", "0"]},
]  # fmt: skip


@pytest.mark.parametrize("change", CHANGES, ids=range(len(CHANGES)))
def test_other_subjects_are_rejected_in_one_line(change: dict[str, Any]) -> None:
    record = certified(WITH_REGION)
    subject = {**record["statement"]["subject"], **change}
    assert is_one_line(refused({**record, "statement": {**record["statement"], "subject": subject}}))


# ---- an oracle of mutants (tests/proofs/attacks.py) ----------------------------------------------


def _number(text: str) -> float:
    top, _, bottom = text.partition("/")
    return int(top) / int(bottom or 1)


def _values(formula: str, **values: Any) -> Any:
    """A formula in floats, by Python: the test's own reading of its own texts."""
    own = {**NAMES, "sign": np.sign, "Max": np.maximum, "relu": lambda a: np.maximum(a, 0)}
    return eval(_compiled(formula), {"__builtins__": {}}, {**own, **values})  # noqa: S307  # our own text


@cache
def _compiled(formula: str) -> Any:
    return compile(formula, "formula", "eval")


def followed(rhs: list[str], x: Any, y: Any, until: float, step: float = 2e-4) -> tuple[Any, Any]:
    """Where Euler polygons of the stated fields end."""
    for _ in range(int(until / step)):
        f, g = (_values(text, x=x, y=y) for text in rhs)
        x, y = np.clip(x + step * f, -9, 9), np.clip(y + step * g, -9, 9)
    return x, y


def assert_true(record: Record, source: random.Random) -> None:
    """Polygons from small starts end nearer; for instability farther."""
    (rhs,) = record["statement"]["subject"]["rhs"]
    angles, size = np.array([source.uniform(0, 2 * np.pi) for _ in range(6)]), 0.05
    x, y = np.sign(np.cos(angles)) * (size * np.cos(angles)) ** 2, size * np.sin(angles)
    x, y = followed(rhs, x, y, until=1.2)
    last = float(np.maximum(np.sqrt(np.abs(x)), np.abs(y)).max() / size)
    unstable = {"stability": "unstable"} in record["statement"]["claims"]
    assert last > 1 if unstable else last < 2, record


@cache
def originals() -> list[Record]:
    """Valid certificates."""
    return [
        by_roots(TWISTING, "root_x**2 - root_x*y/2 + y**2"),
        certified(WITH_REGION),
        certified([f"-3/2*{ROOT} + y - x", "-11/10*sgn(x) - x"]),
    ]
