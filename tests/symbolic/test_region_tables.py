"""Region tables: the field inside each against the table that a reader would pick, and verdicts of equal systems."""

from __future__ import annotations

import operator
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.system_facts import rewriting_words
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.thorough import keep

COMPARISONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
TABLES: list[list[dict[str, Any]]] = [
    [{"where": ["x > 0"], "rhs": ["y", "-1 - y"]}, {"rhs": ["y", "1 - y"]}],
    [
        {"where": ["x > 0", "y >= x"], "rhs": ["-1", "-2"]},
        {"where": "x**2 + y**2 <= 1", "rhs": ["x - y", "x"]},
        {"where": ["y < 1/2", "x < -y"], "rhs": ["0", "x*y"]},
        {"rhs": ["1", "sgn(y)"]},
    ],
]


def built(tables: list[dict[str, Any]], states: tuple[str, ...] = ("x", "y"), **system: Any) -> SwitchedSystem:
    document = {"system": {"states": list(states), **system}, "region": tables}
    return build_system(document, "t", Path("t.toml"))


def picked(tables: list[dict[str, Any]], named: dict[str, float]) -> list[float]:
    """The right-hand side of the first table whose guards hold."""
    return all_picked(tables, named)[0]


def all_picked(tables: list[dict[str, Any]], named: dict[str, float]) -> list[list[float]]:
    """The right-hand sides of all tables whose guards hold."""

    def holds(guard: str) -> bool:
        left, sign, right = re.split(r"(<=|>=|<|>)", guard)
        return bool(COMPARISONS[sign](eval(left, {}, named), eval(right, {}, named)))  # noqa: S307 - of this file

    def guards(table: dict[str, Any]) -> list[str]:
        where = table.get("where", [])
        return [where] if isinstance(where, str) else where

    sides = [table["rhs"] for table in tables if all(map(holds, guards(table)))]
    return [[float(eval(text, {"sgn": np.sign}, named)) for text in side] for side in sides]  # noqa: S307


@pytest.mark.parametrize("tables", TABLES)
def test_the_first_table_whose_guards_hold_counts(tables: list[dict[str, Any]]) -> None:
    field = system_field(built(tables))
    for x in np.random.default_rng(3).uniform(-2, 2, (200, 2)):
        signs = tuple(1 if surface.value(x) > 0 else -1 for surface in field.surfaces)
        assert field.flow(signs)(0.0, x) == pytest.approx(picked(tables, {"x": x[0], "y": x[1]}))


@pytest.mark.parametrize("tables", TABLES)
def test_tables_that_overlap_all_act(tables: list[dict[str, Any]]) -> None:
    """The last one, without guards, where no other does."""
    fields = [system_field(member) for member in built(tables, overlap=True).members]
    most = 0
    for x in np.random.default_rng(3).uniform(-2, 2, (200, 2)):
        found = set()
        for field in fields:
            signs = tuple(1 if surface.value(x) > 0 else -1 for surface in field.surfaces)
            found.add(tuple(np.round(field.flow(signs)(0.0, x), 9)))
        named = {"x": x[0], "y": x[1]}
        expected = all_picked(tables[:-1], named) or all_picked(tables[-1:], named)
        assert found == {tuple(np.round(own, 9)) for own in expected}
        most = max(most, len(found))
    assert most == min(2, len(tables) - 1)


def test_overlap_without_tables_is_refused() -> None:
    document = {"system": {"states": ["x", "y"], "rhs": ["-x", "-y"], "overlap": True}}
    with pytest.raises(SceneError, match=r"system\.overlap"):
        build_system(document, "t", Path("t.toml"))


@pytest.mark.usefixtures("without_reach")
def test_a_verdict_of_overlapping_tables() -> None:
    """Both fields attract, and their mean does not; one of them alone is what the first table that holds says."""
    tables = [
        {"where": ["x > -1/4"], "rhs": ["-x + 4*y", "-y"]},
        {"where": ["x < 1/4"], "rhs": ["-x", "4*x - y"]},
        {"rhs": ["0", "0"]},
    ]
    assert decide_system(built(tables)).verdict == "asymptotically stable"
    assert decide_system(built(tables, overlap=True)).verdict == "unstable"


SINE = {"states": ["x", "y"], "rhs": ["y", "-k*sin(x) - y"], "parameters": {"k": [1, 2]}}


@pytest.mark.parametrize(
    ("system", "words", "refused"),
    [
        (
            built(TABLES[1], overlap=True),
            "where [[region]] tables overlap any of them acts",
            r"overlap: required false",
        ),
        (
            build_system({"system": SINE}, "t", Path("t")),
            "k takes any value of its interval",
            r"k: required a number",
        ),
    ],
)
def test_it_is_said_why_there_are_several_right_hand_sides(system: SwitchedSystem, words: str, refused: str) -> None:
    assert words in rewriting_words(system)
    with pytest.raises(SceneError, match=refused):
        system_field(system)


RELAY = [{"where": ["x > 0"], "rhs": ["-1", "-y"]}, {"rhs": ["1", "-y"]}]


@pytest.mark.parametrize(("tables", "rhs"), keep(1, [(RELAY, ["-sgn(x)", "-y"]), (TABLES[0], ["y", "-sgn(x) - y"])]))
def test_tables_and_signs_have_the_same_verdict(tables: list[dict[str, Any]], rhs: list[str]) -> None:
    by_tables = decide_system(built(tables))
    by_signs = decide_system(build_system({"system": {"states": ["x", "y"], "rhs": rhs}}, "t", Path("t.toml")))
    assert (by_tables.verdict, by_tables.reason) == (by_signs.verdict, by_signs.reason)
    assert by_tables.check()


def test_tables_take_parameters_sines_and_one_state() -> None:
    tables = [{"where": ["x < c"], "rhs": ["k"]}, {"rhs": ["-k*sin(x)/(1 + x**2)"]}]
    found = decide_system(built(tables, ("x",), parameters={"k": 2, "c": 0}))
    assert str(found.verdict) == "asymptotically stable"


@pytest.mark.parametrize(
    ("guard", "verdict"), [("Abs(x) - x <= 0", "unstable"), ("Abs(x) - x < 0", "asymptotically stable")]
)
def test_a_guard_that_is_zero_on_a_whole_cell_holds_there_or_not(guard: str, verdict: str) -> None:
    """Where x > 0 the guard is zero: with ``<=`` it holds, and ``x' = x``."""
    tables = [{"where": [guard], "rhs": ["x"]}, {"rhs": ["-x"]}]
    assert str(decide_system(built(tables, ("x",))).verdict) == verdict


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ([], "system.rhs: required formulas, or [[region]] tables, received neither"),
        ([{"where": ["x > 0"], "rhs": ["y", "1"]}], "region[1].where: required guards in all tables but the last one"),
        ([{"rhs": ["y", "1"]}, {"rhs": ["y", "2"]}], "region[1].where: required guards in all tables but the last"),
        ([{"where": ["x"], "rhs": ["y", "1"]}, {"rhs": ["y", "2"]}], "region[1].where[1]: required a guard such as"),
        ([{"where": ["0 < x < 1"], "rhs": ["y", "1"]}, {"rhs": ["y", "2"]}], "region[1].where[1]: required a guard"),
        ([{"where": ["z > 1"], "rhs": ["y", "1"]}, {"rhs": ["y", "2"]}], "region[1].where[1]: required a formula of x"),
        ([{"where": [3], "rhs": ["y", "1"]}, {"rhs": ["y", "2"]}], "region[1].where[1]: required a guard such as"),
        ([{"where": ["x > 0"], "rhs": ["y"]}, {"rhs": ["y", "2"]}], "region[1].rhs: required 2 formulas"),
        ([{"where": ["x > 0"], "rhs": ["y", "1 +"]}, {"rhs": ["y", "2"]}], "region[1].rhs[2]: required a formula"),
        ([{"where": ["x > 0"], "rhs": ["y", "1"], "z": 0}, {"rhs": ["y", "2"]}], "region[1].z: required one of the"),
        ([{"where": ["x > 0"], "rhs": ["y", "1"]}] * 13, "region: required at most 12 tables, received 13"),
    ],
)
def test_bad_tables_in_one_line(tables: list[dict[str, Any]], said: str) -> None:
    with pytest.raises(SceneError) as caught:
        built(tables)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_tables_or_formulas_not_both() -> None:
    with pytest.raises(SceneError, match="received both"):
        built(TABLES[0], rhs=["y", "x"])
