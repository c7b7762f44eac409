"""Right-hand sides of a plain system from what its file states to formulas that are polynomials on each cell.

Parameters take their values, interval parameters all their ends; fractions are cleared by one positive factor
(:mod:`nonsmooth.symbolic.formulas.cleared_fractions`); norms of states (:mod:`nonsmooth.symbolic.formulas.norms`), and
sines and cosines of them, are enclosed (:mod:`nonsmooth.symbolic.formulas.enclosed_functions`).  What comes out is one
list of formulas, or several: arbitrary switching.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.symbolic.files.scene_values import Exact, field_of, read_exact
from nonsmooth.symbolic.files.system_document import names_in, parameter_texts, with_parameters
from nonsmooth.symbolic.formulas.cleared_fractions import ClearedFractions, FractionClearing
from nonsmooth.symbolic.formulas.enclosed_functions import Wave, enclosing_formulas, named_formulas
from nonsmooth.symbolic.formulas.expression import formula_refused
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.formulas.trees import ExpressionError, float_value, names_of, readable_tree
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, requirement
from nonsmooth.symbolic.numbers.coefficients import as_fraction

MAX_MEMBERS = 64  # right-hand sides

if TYPE_CHECKING:
    from nonsmooth.symbolic.formulas.norms import Bounded

ROOTS = re.compile(r"sqrt|\*\* *(?![0-9]+(?![0-9./e]))")  # a root, or a power that may be one

Side: TypeAlias = tuple[str, tuple[object, ...]]  # its key, and its formulas


@dataclass(frozen=True)
class RightHandSides:
    """Formulas that are polynomials on each cell, with what was done to the stated ones.

    Attributes:
        sides: each with its key and its formulas.
        written: the stated lists with their parameters, where something else was done to them; empty otherwise.
        waves: the sines and the like that are enclosed.
        denominators: must be positive on the checked square; in the states and in the names of norms.
        scale: the positive factor of all fields, in the same names; empty without fractions.
        named: one list with names in place of norms, sines and cosines; empty without these, and where several are
            stated.
        names: what these names mean.
        norms: what those of norms and of entries of unit vectors mean, also where several lists are stated.
        bounded: the kinds of names, ``sqrt`` of a norm and ``unit`` of an entry of a unit vector, of which there are
            bounds in the formulas.
    """

    sides: tuple[Side, ...]
    written: tuple[tuple[str, ...], ...] = ()
    waves: tuple[Wave, ...] = ()
    denominators: tuple[str, ...] = ()
    scale: str = ""
    named: tuple[object, ...] = ()
    names: tuple[Wave, ...] = ()
    norms: tuple[Bounded, ...] = ()
    bounded: frozenset[str] = frozenset()


def read_right_hand_sides(
    stated: Mapping[str, tuple[object, ...]],
    values: Mapping[str, str],
    intervals: Mapping[str, tuple[Any, Any]],
    clearing: FractionClearing,
    file: str,
    *,
    point: Mapping[str, Fraction | None],
    order: int = 0,
) -> RightHandSides:
    """All right-hand sides of a system.

    Args:
        stated: lists of formulas by key.
        values: what stands for each parameter with one value.
        intervals: the ends of the others.
        clearing: the states and the checked point.
        file: for messages.
        point: the checked point, by the names of the states; None where it is not rational.
        order: further terms of sines and cosines, and closer bounds of norms.

    Raises:
        SceneError: for formulas that cannot be rewritten, and for too many right-hand sides.
    """
    for key, formulas in stated.items():
        for j, formula in enumerate(formulas, 1):
            require_affine(formula, intervals, file, f"{key}[{j}]")
    lists: list[Side] = []
    for corner in corners(intervals):
        texts = {**values, **parameter_texts(corner, (), file)}
        here = [(key, tuple(with_parameters(f, texts) for f in formulas)) for key, formulas in stated.items()]
        lists += [side for side in here if side not in lists]  # a list that none of the intervals changes counts once
    clearing, with_names = _with_norms(lists, clearing, point, intervals, file)
    cleared, denominators, scale = _cleared(with_names, clearing, file)
    norms, between = clearing.norms, _between_norms(cleared, clearing, order)
    sides, waves = _enclosed(between, clearing.states, file, order)
    if len(sides) > MAX_MEMBERS:
        expected = f"at most {MAX_MEMBERS} right-hand sides, with intervals at their ends and sines enclosed"
        raise SceneError(file, "system.rhs", expected, StatedFact(f"{len(sides)}"))
    written = tuple(tuple(map(str, formulas)) for _, formulas in lists) if waves or scale or norms else ()
    named, names = _named(cleared[0][1], clearing, scale) if (waves or norms) and len(cleared) == 1 else ((), ())
    cleared_names = _names_in(formula for _, side in cleared for formula in side)
    bounded = frozenset(
        norm.kind for norm in norms if norm.name in cleared_names and len(norm.bounds(clearing.states)) > 1
    )
    return RightHandSides(tuple(sides), written, tuple(waves), denominators, scale, named, names, norms, bounded)


def _named(
    formulas: Sequence[object], clearing: FractionClearing, scale: str
) -> tuple[tuple[object, ...], tuple[Wave, ...]]:
    """Formulas with names in place of norms, or of one over a norm, and of sines and cosines, and what these mean."""
    roots: tuple[Wave, ...] = ()
    if clearing.norms:
        from nonsmooth.symbolic.formulas.unit_vectors import by_inverses

        formulas, roots = by_inverses(formulas, clearing.norms)
        names = _names_in((*formulas, scale))
        roots = tuple(root for root in roots if root.name in names)
    named, waves = named_formulas(formulas, clearing.states | {root.name for root in roots})
    return named, (*roots, *waves)


def _names_in(formulas: Iterable[object]) -> set[str]:
    """All names in formulas; what cannot be read is refused elsewhere."""
    trees = map(readable_tree, formulas)
    return {name for tree in trees if tree is not None for name in names_of(tree)}


def has_norms(formulas: Sequence[object], states: Collection[str]) -> bool:
    """Whether roots of sums of squares of states stand in some formulas."""
    if not any(ROOTS.search(str(formula)) for formula in formulas):
        return False
    from nonsmooth.symbolic.formulas.norms import holds_norms

    return any(holds_norms(formula, states) for formula in formulas)


def _with_norms(
    lists: Sequence[Side],
    clearing: FractionClearing,
    point: Mapping[str, Fraction | None],
    intervals: Collection[str],
    file: str,
) -> tuple[FractionClearing, list[Side]]:
    """All lists with names in place of norms and of entries of unit vectors, and what these mean."""
    if not has_norms([formula for _, side in lists for formula in side], clearing.states):
        return clearing, list(lists)
    from nonsmooth.symbolic.formulas.norms import named_norms
    from nonsmooth.symbolic.formulas.unit_vectors import with_unit_entries

    try:
        named, norms = named_norms([side for _, side in lists], point, clearing.states | set(intervals))
    except ExpressionError as error:
        raise SceneError(file, "system.rhs", requirement(error), StatedFact(_received(error))) from None
    with_entries, entries = with_unit_entries(named, norms, clearing.states)
    sides = [(key, tuple(side)) for (key, _), side in zip(lists, with_entries, strict=True)]
    return replace(clearing, norms=(*norms, *entries)), sides


def _between_norms(lists: Sequence[Side], clearing: FractionClearing, order: int) -> list[Side]:
    """All lists with all norms and entries at either bound."""
    if not clearing.norms:
        return list(lists)
    from nonsmooth.symbolic.formulas.norms import at_ends

    return [
        (key, tuple(formulas))
        for key, side in lists
        for formulas in at_ends(side, clearing.norms, clearing.states, order)
    ]


def _cleared(lists: Sequence[Side], clearing: FractionClearing, file: str) -> tuple[list[Side], tuple[str, ...], str]:
    """All lists without fractions, times one factor."""
    every = [formula for _, formulas in lists for formula in formulas]
    try:
        cleared = _affine(clearing.clear(every), clearing)
    except ExpressionError as error:
        received = clearing.restored(_received(error))
        raise SceneError(file, _refused_key(lists, clearing), requirement(error), StatedFact(received)) from None
    rest = iter(cleared.formulas)
    return [(key, tuple(next(rest) for _ in side)) for key, side in lists], cleared.denominators, cleared.scale


def _affine(cleared: ClearedFractions, clearing: FractionClearing) -> ClearedFractions:
    """Formulas that are affine in every norm.

    Raises:
        ExpressionError: for a norm elsewhere than in sums, products and whole powers.
    """
    if not clearing.norms:
        return cleared
    from nonsmooth.symbolic.formulas.norms import affine_in_norms

    formulas = tuple(affine_in_norms(formula, clearing.norms) for formula in cleared.formulas)
    *denominators, scale = (
        str(affine_in_norms(text, clearing.norms)) for text in (*cleared.denominators, cleared.scale)
    )
    return ClearedFractions(formulas, tuple(denominators), scale)


def _refused_key(lists: Sequence[Side], clearing: FractionClearing) -> str:
    """The key of the first formula that cannot be cleared."""
    for key, formulas in lists:
        for j, formula in enumerate(formulas, 1):
            try:
                _affine(clearing.clear((formula,)), clearing)
            except ExpressionError:
                return f"{key}[{j}]"
    return lists[0][0]


def _received(error: ExpressionError) -> str:
    return str(error).partition(", received ")[2]


def _enclosed(lists: Sequence[Side], states: Collection[str], file: str, order: int) -> tuple[list[Side], list[Wave]]:
    """All lists without sines and cosines of states."""
    sides: list[Side] = []
    waves: list[Wave] = []
    for key, formulas in lists:
        _require_arguments(formulas, states, file, key)
        try:
            enclosing, here = enclosing_formulas(formulas, order)
        except ExpressionError as error:
            for j, formula in enumerate(formulas, 1):
                if _is_refused(formula, order):
                    raise SceneError(file, f"{key}[{j}]", requirement(error), formula) from None
            raise SceneError(file, key, requirement(error), StatedFact(_received(error))) from None  # too many in all
        sides += [(key, side) for side in enclosing]
        waves += here
    return sides, waves


def _is_refused(formula: object, order: int) -> bool:
    """Whether the sines and cosines of one formula cannot be enclosed by themselves."""
    try:
        enclosing_formulas((formula,), order)
    except ExpressionError:
        return True
    return False


def _require_arguments(formulas: Sequence[object], states: Collection[str], file: str, key: str) -> None:
    """Refuse sines and cosines of other names than states."""
    for j, formula in enumerate(formulas, 1):
        with suppress(ExpressionError):  # said where they are enclosed
            _, waves = named_formulas((formula,), frozenset(states))
            for wave in waves:
                with formula_refused(file, f"{key}[{j}]", formula):
                    parse_piecewise(wave.argument, states)


def float_point(states: Sequence[str], values: Sequence[Exact] | None) -> dict[str, float]:
    """The checked point in floats, the origin unless given; what has no value is left to others.

    Raises:
        ExpressionError: for a number beyond floats.
    """
    point = dict.fromkeys(states, 0.0)
    for name, value in zip(states, values or (), strict=False):
        try:
            point[name] = float(value) if isinstance(value, Fraction) else float_value(value.tree, {}, value.text)
        except OverflowError:
            raise ExpressionError("required numbers within the range of floats, received another") from None
    return point


def rational_point(states: Sequence[str], values: Sequence[Exact] | None) -> dict[str, Fraction | None]:
    """The checked point, the origin unless given; None for what is not rational."""
    point: dict[str, Fraction | None] = dict.fromkeys(states, Fraction(0))
    for name, value in zip(states, values or (), strict=False):
        try:
            point[name] = _rational(value)
        except ExpressionError:
            point[name] = None
    return point


# ---- parameters of intervals ---------------------------------------------------------------------
#
# A right-hand side that is affine in every such parameter lies in the hull of those with all parameters at their ends,
# so the system is one under arbitrary switching between these.


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


def intervals_in(formulas: Iterable[object], intervals: Mapping[str, Any]) -> dict[str, Any]:
    """Those that stand in formulas."""
    names = {name for text in formulas for name in names_in(text)}
    return {name: ends for name, ends in intervals.items() if name in names}


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
    rational = None if any(number.turns()) else number.value(field_of([])).as_rational()
    if rational is None:
        raise ExpressionError(f"required a rational number, received {number.text}")
    return as_fraction(rational)


def corners(intervals: Mapping[str, tuple[Any, Any]]) -> Iterator[dict[str, Any]]:
    """All parameters at one of their ends."""
    for ends in product(*intervals.values()):
        yield dict(zip(intervals, ends, strict=True))


def require_affine(formula: object, intervals: Mapping[str, Any], file: str, key: str) -> None:
    """Refuse a formula that is not affine in an interval parameter.

    Raises:
        SceneError: for such a formula; one that cannot be parsed is left to the parser.
    """
    tree = readable_tree(formula)
    for name in intervals:
        if tree is not None and _degree(tree, name) >= NOT_AFFINE:
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
    return NOT_AFFINE if name in names_of(node) else 0
