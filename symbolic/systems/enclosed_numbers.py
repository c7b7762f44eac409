"""Systems with irrational numbers between systems with rational ones, for proofs that hold rational numbers alone.

Every irrational number that a right-hand side names, such as ``sqrt(2)/2``, is replaced by a rational one below it and
by one above it, each place by itself, in all combinations.  A right-hand side is affine in the number at each place, so
the stated field is a mixture of those with the bounds: what holds for solutions of all of these, in any mixture, holds
for those of the stated system.  A number inside a switching function or a power has no such place: between two surfaces
lies more than both, and a power is not affine.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from math import ceil, floor, frexp

from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.enclosures import rational_above, rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

BITS = 30  # of the bounds
PRECISION = 64  # bits of the ball that is rounded outward
MOST_PLACES = 5  # of irrational numbers in one right-hand side: two to this power others


class NoEnclosureError(ValueError):
    """A system that lies between no systems with rational numbers, or between too many."""


@dataclass(frozen=True)
class Place:
    """Where an irrational number stands in a formula.

    Attributes:
        start: its first character.
        end: the character after its last one.
        bounds: a rational number below, and one above.
    """

    start: int
    end: int
    bounds: tuple[Fraction, Fraction]


def with_known_numbers(system: SwitchedSystem) -> SwitchedSystem:
    """The system between rational bounds of its irrational numbers; itself where there are no such bounds."""
    with suppress(NoEnclosureError):
        return enclose_numbers(system)
    return system


def enclose_numbers(system: SwitchedSystem) -> SwitchedSystem:
    """A system in rational numbers that encloses another one; the same where all its numbers are rational.

    Raises:
        NoEnclosureError: for irrational numbers inside switching functions and powers, for too many of them, and in
            systems that are seen by roots of states.
    """
    sides = [_between(member) for member in system.members]
    if all(len(own) == 1 for own in sides):
        return system
    if system.by_roots is not None:
        raise NoEnclosureError("irrational numbers beside roots of states")
    first, *others = (side for own in sides for side in own)
    stated = tuple(tuple(side.text for side in member.rhs) for member in system.members)
    return replace(system, rhs=first, others=tuple(others), written=system.written or stated, encloses_numbers=True)


def _between(system: SwitchedSystem) -> list[tuple[PiecewiseExpression, ...]]:
    """The right-hand sides with bounds for the irrational numbers of one; itself where it has none."""
    sides = [parse_piecewise(one_line(side.text), system.states) for side in system.rhs]
    places = [list(_places(side.tree, side, system)) for side in sides]
    count = sum(map(len, places))
    if not count:
        return [system.rhs]
    if count > MOST_PLACES:
        raise NoEnclosureError(f"over {MOST_PLACES} irrational numbers in a right-hand side")
    found = []
    for chosen in product((0, 1), repeat=count):
        numbers = iter(chosen)
        at = [[(own, next(numbers)) for own in listed] for listed in places]
        texts = [_replaced(side.text, own) for side, own in zip(sides, at, strict=True)]
        found.append(tuple(parse_piecewise(text, system.states) for text in texts))
    return found


def _places(node: ast.expr, whole: PiecewiseExpression, system: SwitchedSystem) -> Iterator[Place]:
    """The irrational numbers of a part of a formula, from the left to the right."""
    if node in whole.numbers:
        number = whole.numbers[node].value(system.field)
        if number.as_rational() is None:
            yield Place(node.col_offset, node.end_col_offset or 0, bounds_of(number))
        return
    match node:
        case ast.UnaryOp():
            yield from _places(node.operand, whole, system)
        case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div()):
            yield from _places(node.left, whole, system)
            yield from _places(node.right, whole, system)
        case _:
            inner = (part for part in ast.walk(node) if isinstance(part, ast.expr) and part in whole.numbers)
            if any(whole.numbers[part].value(system.field).as_rational() is None for part in inner):
                raise NoEnclosureError("irrational numbers inside switching functions or powers")


def bounds_of(number: Number) -> tuple[Fraction, Fraction]:
    """Rational numbers of few digits below and above an irrational one."""
    ball, (_, exponent) = number.accurate_ball(PRECISION), frexp(float(number))
    scale = Fraction(2) ** (BITS - exponent)
    return floor(rational_below(ball) * scale) / scale, ceil(rational_above(ball) * scale) / scale


def _replaced(text: str, chosen: list[tuple[Place, int]]) -> str:
    """A formula with one of the bounds at each place."""
    for place, which in reversed(chosen):
        text = f"{text[: place.start]}({place.bounds[which]}){text[place.end :]}"
    return text
