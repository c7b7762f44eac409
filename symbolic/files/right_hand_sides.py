"""Right-hand sides of a plain system from what its file states to formulas that are polynomials on each cell.

Parameters take their values, interval parameters all their ends; fractions are cleared by one positive factor
(:mod:`nonsmooth.symbolic.cleared_fractions`); sines and cosines of states are enclosed
(:mod:`nonsmooth.symbolic.sine_enclosures`).  What comes out is one list of formulas, or several: arbitrary switching.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from nonsmooth.symbolic.cleared_fractions import Clearing
from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.files.interval_parameters import corners, require_affine
from nonsmooth.symbolic.files.parameters import parameter_texts, with_parameters
from nonsmooth.symbolic.files.scene_values import Exact
from nonsmooth.symbolic.float_formulas import float_value
from nonsmooth.symbolic.scene_error import SceneError, StatedFact, requirement
from nonsmooth.symbolic.sine_enclosures import Wave, enclosing_formulas, has_waves, named_formulas

MAX_MEMBERS = 64  # right-hand sides


@dataclass(frozen=True)
class RightHandSides:
    """Formulas that are polynomials on each cell, with what was done to the stated ones.

    Attributes:
        sides: each with its key and its formulas.
        written: the stated lists with their parameters, where something else was done to them; empty otherwise.
        waves: what is enclosed.
        denominators: must be positive on the checked square.
        scale: the positive factor of all fields; empty without fractions.
        named: one list with names in place of sines and cosines; empty without these, and where several are stated.
        names: what these names mean.
    """

    sides: tuple[tuple[str, tuple[object, ...]], ...]
    written: tuple[tuple[str, ...], ...] = ()
    waves: tuple[Wave, ...] = ()
    denominators: tuple[str, ...] = ()
    scale: str = ""
    named: tuple[object, ...] = ()
    names: tuple[Wave, ...] = ()


def read_right_hand_sides(
    stated: Mapping[str, tuple[object, ...]],
    values: Mapping[str, str],
    intervals: Mapping[str, tuple[Any, Any]],
    clearing: Clearing,
    file: str,
) -> RightHandSides:
    """All right-hand sides of a system.

    Args:
        stated: lists of formulas by key.
        values: what stands for each parameter with one value.
        intervals: the ends of the others.
        clearing: the states and the checked point.
        file: for messages.

    Raises:
        SceneError: for formulas that cannot be rewritten, and for too many right-hand sides.
    """
    for key, formulas in stated.items():
        for j, formula in enumerate(formulas, 1):
            require_affine(formula, intervals, file, f"{key}[{j}]")
    lists: list[tuple[str, tuple[object, ...]]] = []
    for corner in corners(intervals):
        texts = {**values, **parameter_texts(corner, (), file)}
        lists += [(key, tuple(with_parameters(f, texts) for f in formulas)) for key, formulas in stated.items()]
    cleared, denominators, scale = _cleared(lists, clearing, file)
    sides, waves = _enclosed(cleared, file)
    if len(sides) > MAX_MEMBERS:
        expected = f"at most {MAX_MEMBERS} right-hand sides, with intervals at their ends and sines enclosed"
        raise SceneError(file, "system.rhs", expected, StatedFact(f"{len(sides)}"))
    written = tuple(tuple(map(str, formulas)) for _, formulas in lists) if waves or scale else ()
    named = named_formulas(cleared[0][1], clearing.states) if waves and len(cleared) == 1 else ((), ())
    return RightHandSides(tuple(sides), written, tuple(waves), denominators, scale, *named)


def _cleared(
    lists: Sequence[tuple[str, tuple[object, ...]]], clearing: Clearing, file: str
) -> tuple[list[tuple[str, tuple[object, ...]]], tuple[str, ...], str]:
    """All lists without fractions, times one factor."""
    every = [formula for _, formulas in lists for formula in formulas]
    try:
        cleared = clearing.clear(every)
    except ExpressionError as error:
        raise SceneError(
            file, _refused_key(lists, clearing), requirement(error), StatedFact(_received(error))
        ) from None
    rest = iter(cleared.formulas)
    return [(key, tuple(next(rest) for _ in side)) for key, side in lists], cleared.denominators, cleared.scale


def _refused_key(lists: Sequence[tuple[str, tuple[object, ...]]], clearing: Clearing) -> str:
    """The key of the first formula that cannot be cleared."""
    for key, formulas in lists:
        for j, formula in enumerate(formulas, 1):
            try:
                clearing.clear((formula,))
            except ExpressionError:
                return f"{key}[{j}]"
    return lists[0][0]


def _received(error: ExpressionError) -> str:
    return str(error).partition(", received ")[2]


def _enclosed(
    lists: Sequence[tuple[str, tuple[object, ...]]], file: str
) -> tuple[list[tuple[str, tuple[object, ...]]], list[Wave]]:
    """All lists without sines and cosines of states."""
    sides: list[tuple[str, tuple[object, ...]]] = []
    waves: list[Wave] = []
    for key, formulas in lists:
        try:
            found, here = enclosing_formulas(formulas)
        except ExpressionError as error:
            j = next((k for k, text in enumerate(formulas) if has_waves(text)), 0)
            raise SceneError(file, f"{key}[{j + 1}]", requirement(error), formulas[j]) from None
        sides += [(key, side) for side in found]
        waves += here
    return sides, waves


def float_point(states: Sequence[str], values: Sequence[Exact] | None) -> dict[str, float]:
    """The checked point in floats, the origin unless given; what has no value is left to others."""
    found = dict.fromkeys(states, 0.0)
    for name, value in zip(states, values or (), strict=False):
        found[name] = float(value) if isinstance(value, Fraction) else float_value(value.tree, {}, value.text)
    return found
