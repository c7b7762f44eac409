"""Right-hand sides with states in denominators, multiplied by one positive function until they have none.

``x' = f/d`` and ``x' = f`` with ``d > 0`` have the same paths at other speeds, also as Filippov inclusions: one
positive factor of all fields scales the set of velocities.  So stability, regions and the signs of V' are the same;
rates are not.  A denominator that is negative at the checked point changes its sign and that of its numerator: floats
choose, and whoever decides stability proves that all denominators are positive on the checked square.

A denominator may be zero at the checked point alone, as in the quasi-continuous law
``-(y + sqrt(Abs(x))*sign(x))/(Abs(y) + sqrt(Abs(x)))`` (Levant 2005).  Off the point all is as before; a solution of
``x' = f/d`` that leaves the point would be one of ``x' = f`` that comes from arbitrarily near it, and one that arrives
is one that comes to it: so stability and attraction are the same there too.  That ``f/d`` stays bounded is proved with
the sign of d, for a solution to go on from the point.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from random import Random
from typing import TYPE_CHECKING

from nonsmooth.symbolic.formulas.enclosed_functions import has_waves
from nonsmooth.symbolic.formulas.piecewise import SWITCHES
from nonsmooth.symbolic.formulas.trees import (
    MAX_TEXT,
    ONE,
    SIGNS,
    ExpressionError,
    called,
    float_value,
    formula_tree,
    minus,
    multiplied,
    parse_tree,
    power,
    quotient,
    readable_tree,
    written,
)
from nonsmooth.symbolic.messages.scene_error import shown

if TYPE_CHECKING:
    from nonsmooth.symbolic.formulas.norms import Bounded

BESIDE = 64  # directions in which signs beside the checked point are looked at, but for the axes
NEAR = (2.0**-10, 2.0**-20)  # at these distances


@dataclass(frozen=True)
class Fraction:
    """A formula as a numerator over a product of denominators, which are texts, so that equal ones are seen."""

    top: ast.expr
    bottom: Counter[str] = field(default_factory=Counter)


@dataclass(frozen=True)
class ClearedFractions:
    """Formulas times one product of denominators.

    Attributes:
        formulas: without fractions.
        denominators: each once; empty where there were none.
        scale: the product; empty where there were none.
    """

    formulas: tuple[object, ...]
    denominators: tuple[str, ...] = ()
    scale: str = ""


@dataclass(frozen=True)
class FractionClearing:
    """What it takes to clear the fractions of formulas.

    Attributes:
        states: their names.
        point: the checked point in floats, by name.
        sizes: the states that are sizes of roots, of which positive values count.
        norms: what further names in formulas mean, those of norms and of entries of unit vectors.
    """

    states: frozenset[str]
    point: Mapping[str, float]
    sizes: frozenset[str] = frozenset()
    norms: tuple[Bounded, ...] = ()

    def clear(self, formulas: Sequence[object]) -> ClearedFractions:
        """The formulas times one product of denominators; as they were where there are none.

        Raises:
            ExpressionError: for a denominator that is zero at the checked point and has no one sign beside it, and for
                a fraction in a denominator.
        """
        if not any(map(self._has_fraction, formulas)):
            return ClearedFractions(tuple(formulas))
        parsed = [parse_tree(formula, MAX_TEXT, "a formula") for formula in formulas]
        fractions = [self._fraction(tree, text) for text, tree in parsed]
        every: Counter[str] = Counter()
        for part in fractions:
            every |= part.bottom
        # A field that is no cone by its factors is none by accident either: cones claim the whole plane.
        extra = Counter() if all(map(self._is_positive_sum, every)) else Counter(list(every))
        cleared = tuple(written(_times(part.top, every - part.bottom + extra)) for part in fractions)
        return ClearedFractions(cleared, tuple(every), written(_times(ONE, every + extra)))

    def restored(self, text: str) -> str:
        """A text about formulas with roots in place of the names of norms."""
        for norm in self.norms:
            text = re.sub(rf"\b{norm.name}\b", written(norm.stated), text)
        return text

    @property
    def _names(self) -> set[str]:
        """The names of norms."""
        return {norm.name for norm in self.norms}

    def _has_fraction(self, formula: object) -> bool:
        tree = readable_tree(formula)
        return tree is not None and self._divides(tree)

    def _divides(self, node: ast.expr) -> bool:
        """Whether a part holds a fraction with a state in its denominator."""
        parts = (part for part in ast.walk(node) if isinstance(part, ast.BinOp) and isinstance(part.op, ast.Div))
        return any(self._moves(part.right) for part in parts)

    def _moves(self, node: ast.AST) -> bool:
        """Whether a part holds a state outside of ``sign``: elsewhere it is a number on each cell."""
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in SIGNS:
            return False
        if isinstance(node, ast.Name):
            return node.id in self.states or node.id in self._names
        return any(map(self._moves, ast.iter_child_nodes(node)))

    def _fraction(self, node: ast.expr, text: str) -> Fraction:
        if not self._divides(node):
            return Fraction(node)
        match node:
            case ast.UnaryOp(op=ast.UAdd() | ast.USub()):
                inner = self._fraction(node.operand, text)
                return Fraction(minus(inner.top), inner.bottom) if isinstance(node.op, ast.USub) else inner
            case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(whole))) if whole > 0:
                inner = self._fraction(node.left, text)
                return Fraction(power(inner.top, whole), Counter({d: k * whole for d, k in inner.bottom.items()}))
            case ast.BinOp(op=ast.Add() | ast.Sub()):
                (left, right), bottom = self._common([node.left, node.right], text)
                return Fraction(ast.BinOp(left, node.op, right), bottom)
            case ast.BinOp(op=ast.Mult()):
                first, second = (self._fraction(side, text) for side in (node.left, node.right))
                return Fraction(multiplied(first.top, second.top), first.bottom + second.bottom)
            case ast.BinOp(op=ast.Div()):
                return self._quotient(node, text)
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in SWITCHES:
                return self._switching(name, node.args, text)
        raise ExpressionError(f"required fractions of polynomials, received {shown(text)}")

    def _quotient(self, node: ast.BinOp, text: str) -> Fraction:
        left = self._fraction(node.left, text)
        if not self._moves(node.right):
            return Fraction(quotient(left.top, node.right), left.bottom)
        right = self._fraction(node.right, text)
        bottom = written(right.top)
        if right.bottom or has_waves(bottom):
            raise ExpressionError(
                f"required no fraction and no sine of states in a denominator, received {shown(text)}"
            )
        if self._is_positive(right.top, text):
            return Fraction(left.top, left.bottom + Counter([bottom]))
        return Fraction(minus(left.top), left.bottom + Counter([written(minus(right.top))]))

    def _is_positive(self, node: ast.expr, text: str) -> bool:
        """Whether a denominator is positive at the checked point, or beside it where it is zero there, in floats.

        Raises:
            ExpressionError: for one that has no sign there.
        """
        value = self._value(node, self.point, text)
        values = [value] if value else [self._value(node, place, text) for place in self._places_beside()]
        if min(values) <= 0 <= max(values):
            raise ExpressionError(f"required denominators that are not zero at the checked point, received {text}")
        return values[0] > 0

    def _value(self, node: ast.expr, place: Mapping[str, float], text: str) -> float:
        """The value of a part at a place that names the states, in floats."""
        if self.norms:
            from nonsmooth.symbolic.formulas.norms import with_norms

            place = with_norms(self.norms, place)
        return float_value(node, place, text)

    def _places_beside(self) -> Iterator[dict[str, float]]:
        """Places near the checked point in many directions, those of the axes too, with positive sizes of roots."""
        drawn, names = Random(0), sorted(self.point.keys() - self.sizes)
        along = [[float(side * (other == name)) for other in names] for name in names for side in (1, -1)]
        between = [[drawn.uniform(-1, 1) for _ in names] for _ in range(BESIDE)]
        for direction, size in product((*along, *between), NEAR):
            place = {name: self.point[name] + size * step for name, step in zip(names, direction, strict=True)}
            yield place | {name: self.point[name] + size for name in self.sizes}

    def _switching(self, name: str, arguments: Sequence[ast.expr], text: str) -> Fraction:
        """Positive denominators go through: all these functions but sign are homogeneous of degree one."""
        tops, bottom = self._common(arguments, text)
        joined = called(name, *tops)
        return Fraction(joined) if name in SIGNS else Fraction(joined, bottom)

    def _is_positive_sum(self, text: str) -> bool:
        """Whether a denominator is a sum of squares and norms, and has a positive number in it or is zero at the point.

        It is positive wherever not all of these are zero.
        """
        for norm in self.norms:
            if norm.name == text:
                return self._is_positive_sum(norm.argument)
        tree = formula_tree(text)
        terms = _terms(tree)
        is_positive = any(not self._moves(term) and self._is_square(term) for term in terms)
        return all(map(self._is_square, terms)) and (is_positive or not self._value(tree, self.point, text))

    def _is_square(self, node: ast.expr) -> bool:
        """Whether a summand is a positive number, an even power, a power of a norm, or a product of such."""
        match node:
            case ast.Constant(value=int() | float() as value):
                return value > 0
            case ast.Name(id=name):
                return name in self._names
            case ast.BinOp(op=ast.Mult() | ast.Div(), left=left, right=right):
                return self._is_square(left) and self._is_square(right)
            case ast.BinOp(left=base, op=ast.Pow(), right=ast.Constant(value=int(power))):
                return power % 2 == 0 or self._is_square(base)
        return False

    def _common(self, nodes: Sequence[ast.expr], text: str) -> tuple[list[ast.expr], Counter[str]]:
        """Numerators over one product of denominators."""
        parts = [self._fraction(node, text) for node in nodes]
        bottom: Counter[str] = Counter()
        for part in parts:
            bottom |= part.bottom
        return [_times(part.top, bottom - part.bottom) for part in parts], bottom


def _times(top: ast.expr, factors: Counter[str]) -> ast.expr:
    return multiplied(top, *map(formula_tree, sorted(factors.elements())))


def _terms(node: ast.expr) -> list[ast.expr]:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return [*_terms(node.left), *_terms(node.right)]
    return [node]
