"""Interval parameters of a plain system: ``k = [1, 2]`` stands for every value between, at any time.

A right-hand side that is affine in every such parameter lies in the hull of those with all parameters at their ends, so
the system is one under arbitrary switching between these.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import product
from typing import Any

from nonsmooth.symbolic.expression import ExpressionError, parse_tree
from nonsmooth.symbolic.files.scene_values import Exact, field_of, read_exact
from nonsmooth.symbolic.piecewise import MAX_TEXT
from nonsmooth.symbolic.scene_error import SceneError

MAX_INTERVALS = 4
NOT_AFFINE = 2


def split_intervals(parameters: Mapping[str, Any], file: str) -> tuple[dict[str, Any], dict[str, tuple[Any, Any]]]:
    """Parameters with one value, and those with two ends.

    Raises:
        SceneError: for an interval that is none, and for too many.
    """
    single, intervals = {}, {}
    for name, value in parameters.items():
        if isinstance(value, list):
            intervals[name] = _ends(value, file, f"system.parameters.{name}")
        else:
            single[name] = value
    if len(intervals) > MAX_INTERVALS:
        raise SceneError(file, "system.parameters", f"at most {MAX_INTERVALS} intervals", len(intervals))
    return single, intervals


def _ends(value: list[Any], file: str, key: str) -> tuple[Any, Any]:
    expected = "an interval of two rational numbers, the lower one first, such as [1, 2]"
    try:
        ends = [_rational(read_exact(end)) for end in value]
    except ExpressionError:
        raise SceneError(file, key, expected, value) from None
    if len(ends) != 2 or not ends[0] < ends[1]:
        raise SceneError(file, key, expected, value)
    return value[0], value[1]


def _rational(number: Exact) -> Fraction:
    """A rational number.

    Raises:
        ExpressionError: for any other.
    """
    if isinstance(number, Fraction):
        return number
    known = None if any(number.turns()) else number.value(field_of([])).as_rational()
    if known is None:
        raise ExpressionError(f"required a rational number, received {number.text}")
    return Fraction(int(known.p), int(known.q))


def corners(intervals: Mapping[str, tuple[Any, Any]]) -> Iterator[dict[str, Any]]:
    """All parameters at one of their ends."""
    for ends in product(*intervals.values()):
        yield dict(zip(intervals, ends, strict=True))


def require_affine(formula: object, intervals: Mapping[str, Any], file: str, key: str) -> None:
    """Refuse a formula that is not affine in an interval parameter.

    Raises:
        SceneError: for such a formula; one that cannot be parsed is left to the parser.
    """
    try:
        tree = parse_tree(formula, MAX_TEXT, "a formula")[1]
    except ExpressionError:
        return
    for name in intervals:
        if _degree(tree, name) >= NOT_AFFINE:
            raise SceneError(file, key, f"a formula that is affine in the interval parameter {name}", formula)


def _degree(node: ast.AST, name: str) -> int:
    """The degree in a name, as the formula is written; where it is no polynomial in it, two."""
    match node:
        case ast.Name():
            return int(node.id == name)
        case ast.UnaryOp():
            return _degree(node.operand, name)
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            return max(_degree(node.left, name), _degree(node.right, name))
        case ast.BinOp(op=ast.Mult()):
            return _degree(node.left, name) + _degree(node.right, name)
        case ast.BinOp(op=ast.Div()) if not _degree(node.right, name):
            return _degree(node.left, name)
    inside = any(isinstance(part, ast.Name) and part.id == name for part in ast.walk(node))
    return NOT_AFFINE if inside else 0
