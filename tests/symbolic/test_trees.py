"""Formulas as trees: what is written is read back as the same tree, and rewriting changes no value."""

from __future__ import annotations

import ast
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.formulas.trees import (
    DEEPEST,
    ExpressionError,
    float_value,
    formula_tree,
    literal_value,
    multiplied,
    number,
    parse_tree,
    quotient,
    tidied,
    total,
    with_names,
    written,
)
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.thorough import examples

LEAVES = st.sampled_from(["x", "y", "0", "1", "2", "0.5", "1e-3", "12.50"])


def of_parts(parts: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Texts with more parentheses than they need."""
    bracketed = parts.map("({})".format)
    return (
        st.tuples(st.sampled_from("+-"), bracketed).map("".join)
        | st.tuples(bracketed, st.sampled_from([" + ", " - ", "*", "/"]), bracketed).map("".join)
        | st.tuples(parts, st.sampled_from([" + ", "*"]), bracketed).map("".join)
        | st.tuples(bracketed, st.sampled_from(["**2", "**3"])).map("".join)
        | st.tuples(st.sampled_from(["Abs", "sign", "sin"]), bracketed).map("".join)
    )


FORMULAS = st.recursive(LEAVES, of_parts, max_leaves=12)


def value(tree: ast.expr, x: float, y: float) -> float | None:
    try:
        return float_value(tree, {"x": x, "y": y}, "")
    except ExpressionError:
        return None  # divided by zero


@examples(300)
@given(FORMULAS)
def test_what_is_written_is_read_back(text: str) -> None:
    tree = formula_tree(text)
    assert ast.dump(formula_tree(written(tree))) == ast.dump(tree)
    assert len(written(tree)) <= len(text) + 2 * text.count("-")


@examples(300)
@given(FORMULAS, st.floats(-2, 2), st.floats(-2, 2))
def test_a_tidied_formula_has_the_same_values(text: str, x: float, y: float) -> None:
    tree = formula_tree(text)
    expected = value(tree, x, y)
    if expected is not None:
        assert value(tidied(tree), x, y) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@examples(200)
@given(FORMULAS, FORMULAS, st.floats(-2, 2))
def test_a_formula_in_place_of_a_name(text: str, inner: str, x: float) -> None:
    inside = value(formula_tree(inner), x, x)
    expected = None if inside is None else value(formula_tree(text), x, inside)
    changed = with_names(formula_tree(text), {"y": formula_tree(inner)})
    if expected is not None:
        assert value(changed, x, x) == pytest.approx(expected, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("text", ["0.1", "1_000.50", "1e-30", "12345678901234567890123.5", ".5"])
def test_decimals_keep_their_digits(text: str) -> None:
    (node,) = ast.walk(formula_tree(text))
    assert isinstance(node, ast.Constant)
    assert written(node) == text
    assert literal_value(node) == Fraction(text)


@pytest.mark.parametrize(
    ("text", "whole"),
    [
        ("sat(x)", "sat(x, -1, 1)"),
        ("-sat((x + sat(y))/0.10) - sat(x, 0, 2)", "-sat((x + sat(y, -1, 1))/0.10, -1, 1) - sat(x, 0, 2)"),
        ("(x) + sat(x, -1, 1)", "(x) + sat(x, -1, 1)"),  # as it was written
    ],
)
def test_a_saturation_without_limits_is_within_minus_one_and_one(text: str, whole: str) -> None:
    read, tree = parse_tree(text, 100, "a formula")
    assert read == whole
    assert written(tree) == written(formula_tree(whole))


@pytest.mark.parametrize(
    ("built", "text"),
    [
        (total([number(0), number(-2), ast.Name("x")]), "-2 + x"),
        (total([ast.Name("x"), number(Fraction(-2, 3))]), "x - 2/3"),
        (multiplied(number(1), ast.Name("x"), number(Fraction(-1, 2))), "-x*(1/2)"),
        (multiplied(number(0), ast.Name("x")), "0"),
        (quotient(ast.Name("x"), number(1)), "x"),
        (total([]), "0"),
        (multiplied(), "1"),
    ],
)
def test_what_changes_nothing_is_not_built(built: ast.expr, text: str) -> None:
    assert written(built) == text


DEEP = "x" + " + x" * (4 * DEEPEST)


@pytest.mark.parametrize("more", ["", " - sqrt(Abs(x))", " - sin(x)", " - k*x/(1 + x**2)"])
def test_deep_formulas_are_refused_in_one_line(more: str, tmp_path: Path) -> None:
    scene = tmp_path / "deep.toml"
    tables: dict[str, Any] = {"states": '["x"]', "rhs": f'["{DEEP}{more}"]', "parameters": "{ k = 2 }"}
    scene.write_text("[system]\n" + "\n".join(f"{key} = {text}" for key, text in tables.items()))
    with pytest.raises(SceneError, match="required at most 60 nested operations"):
        load_system(scene)
