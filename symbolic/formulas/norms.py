"""Norms of states, ``sqrt(x**2 + y**2)``: names in formulas that are affine in them, then between formulas without any.

The sum of squares under the root is ``q = sum_i c_i b_i^2`` with positive numbers c_i and polynomials b_i, or what
switches between some.  Where it is positive at the checked point, with the value r^2, and ``u = q/r^2 - 1``,

    r (1 + u/2 - u^2/2)  <=  sqrt(q)  <=  r (1 + u/2),

for ``(1 + u/2 - u^2/2)^2 - (1 + u) = u^2 (u + 1) (u - 3)/4`` is not positive where ``-1 <= u <= 3``, and beyond the
left side is negative; and ``r <= sqrt(q)`` where u is a sum of squares.  Where q is zero at the point, the bounds are
polyhedral norms.  For sizes ``a, b >= 0`` and unit vectors ``u_j = (cos t_j, sin t_j)`` that are rational,

    max_j u_j . (a, b)  <=  sqrt(a^2 + b^2)  <=  max_j u_j . (a, b) / c,

where c is the least value of the left side on the quarter circle: it is on an axis, or where two neighbours are equal.
A longer sum is taken pair by pair, as both sides grow with a and b.  With two vectors, (12, 5)/13 and (5, 12)/13, the
bounds differ by a twelfth of the norm; the *order* says how often their number is doubled.  In more than two states
there is one at first, (7, 7)/10, whose bounds switch where a size is zero alone.  At the point both bounds are what the
norm is.

A formula is rewritten by ``s^2 = q`` until it is affine in every norm s, so its value lies in the hull of those with
every norm at either bound, with the same bound wherever this norm stands, in all right-hand sides.
"""

from __future__ import annotations

import ast
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from math import isqrt, pi, tan

from nonsmooth.symbolic.formulas.enclosed_functions import NORM, Wave
from nonsmooth.symbolic.formulas.expression import parse
from nonsmooth.symbolic.formulas.trees import (
    ONE,
    ZERO,
    ExpressionError,
    Interpretation,
    called,
    float_value,
    formula_tree,
    is_call,
    minus,
    multiplied,
    names_of,
    number,
    plus,
    power,
    quotient,
    readable_tree,
    replaced,
    tidied,
    total,
    with_names,
    written,
)
from nonsmooth.symbolic.messages.scene_error import shown

EXAMPLE = "sqrt(x**2 + y**2)"
NAMED = "norm_{}"
MAX_NORMS = 3  # different ones: two to this power right-hand sides
PLANE = 2  # states
ALIKE = Fraction(7, 10)  # both entries of a vector that is a little shorter than one
SIMPLE = 10  # denominators of tangents
FINE = 1 << 10  # parts of roots by which rational numbers beside them differ at most
RATIONAL = Interpretation(
    Fraction, None, {"Abs": abs, "Max": max, "Min": min, "sgn": lambda value: (value > 0) - (value < 0)}
)

Square = tuple[Fraction, ast.expr]  # c and b of ``c b^2``


@dataclass(frozen=True)
class Bounded(Wave, ABC):
    """What a name in formulas stands for, with formulas between which it is."""

    @property
    @abstractmethod
    def stated(self) -> ast.expr:
        """As a formula of the states."""

    @abstractmethod
    def bounds(self, states: Collection[str], order: int = 0) -> tuple[ast.expr, ...]:
        """A formula below and one above, or the one that it is."""


@dataclass(frozen=True)
class Norm(Bounded):
    """The root of a sum of squares.

    Attributes:
        square: the value of this sum at the checked point.
    """

    square: Fraction = Fraction(0)

    @property
    def stated(self) -> ast.expr:
        """As a formula of the states."""
        return called(NORM, formula_tree(self.argument))

    def bounds(self, states: Collection[str], order: int = 0) -> tuple[ast.expr, ...]:
        """A formula below and one above, or the one that it is: of a single square."""
        squares = squares_in(formula_tree(self.argument), states) or []
        if len(squares) == 1:
            ((c, base),) = squares
            return (multiplied(exact_root(c), _size(base)),)
        if self.square:
            return _beside_root(self, squares, order)
        vectors = directions(order if len(states) <= PLANE else order - 1)
        lower = _largest(squares, *vectors, is_above=False)
        return lower, _largest(squares, *vectors, is_above=True)


def exact_root(value: Fraction) -> ast.expr:
    """The root of a number as a formula."""
    root = root_beside(value, is_above=False)
    return number(root) if root**2 == value else called(NORM, number(value))


# ---- read ----------------------------------------------------------------------------------------


def squares_in(tree: ast.expr, states: Collection[str]) -> list[Square] | None:
    """The squares of which a formula is written as the sum; None where it is no such sum, or holds no state.

    Even powers are squares, and numbers that are not negative are multiples of ``1^2``.
    """
    squares = list(_squares(tree, states))
    is_sum = all(square is not None and square[0] >= 0 for square in squares)
    if not is_sum or names_of(tree).isdisjoint(states):
        return None
    return [square for square in squares if square is not None and square[0]]


def _squares(node: ast.expr, states: Collection[str]) -> Iterator[Square | None]:
    """The summands as squares, None for any other."""
    match node:
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            yield from _squares(left, states)
            yield from _squares(right, states)
        case ast.UnaryOp(op=ast.UAdd(), operand=inner):
            yield from _squares(inner, states)
        case _:
            yield _square(node, states)


def _square(node: ast.expr, states: Collection[str]) -> Square | None:
    if names_of(node).isdisjoint(states):
        value = _rational(node)
        return None if value is None else (value, ONE)
    match node:
        case ast.BinOp(left=base, op=ast.Pow(), right=ast.Constant(value=int(exponent))) if exponent % 2 == 0:
            return Fraction(1), power(base, exponent // 2)
        case ast.BinOp(op=ast.Mult()):
            numbers, others = _factors(node, states)
            if len(others) == 2 and ast.dump(others[0]) == ast.dump(others[1]):
                return _scaled((Fraction(1), others[0]), _rational(multiplied(*numbers)))
            square = _square(others[0], states) if len(others) == 1 else None
            return _scaled(square, _rational(multiplied(*numbers)))
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            value = _rational(right)
            return _scaled(_square(left, states), 1 / value if value else None)
    return None


def _factors(node: ast.expr, states: Collection[str]) -> tuple[list[ast.expr], list[ast.expr]]:
    """The factors of a product without states, and those with some."""
    match node:
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            (numbers, others), (more, beside) = _factors(left, states), _factors(right, states)
            return numbers + more, others + beside
    return ([node], []) if names_of(node).isdisjoint(states) else ([], [node])


def _scaled(square: Square | None, factor: Fraction | None) -> Square | None:
    return None if square is None or factor is None else (square[0] * factor, square[1])


def _rational(node: ast.expr) -> Fraction | None:
    """The value of a part without states, where it is rational as it is written; None for any other."""
    try:
        value, in_pi = parse(written(node)).parts_in_pi()
    except ExpressionError:
        return None
    return None if in_pi else value


def _norm_of(node: ast.AST, states: Collection[str]) -> tuple[ast.expr, int] | None:
    """The sum of squares q of a part ``q**(k/2)``, and k; None for any other."""
    match node:
        case ast.Call(args=[inner]) if is_call(node, "sqrt"):
            return (inner, 1) if squares_in(inner, states) else None
        case ast.BinOp(left=inner, op=ast.Pow(), right=right):
            twice = 2 * (_rational(right) or 0)
            if twice.denominator == 1 and twice % 2 and squares_in(inner, states):
                return inner, int(twice)
    return None


def holds_norms(formula: object, states: Collection[str]) -> bool:
    """Whether a root of a sum of squares of states stands in a formula."""
    tree = readable_tree(formula)
    return tree is not None and any(_norm_of(node, states) for node in ast.walk(tree))


def named_norms(
    lists: Sequence[Sequence[object]], point: Mapping[str, Fraction | None], taken: Collection[str]
) -> tuple[list[tuple[object, ...]], tuple[Norm, ...]]:
    """Formulas with a name in place of every norm, equal ones with one name, and what these names mean.

    Args:
        lists: of formulas of the states.
        point: the checked point, by the names of the states; None where it is not rational.
        taken: names that mean something else.

    Raises:
        ExpressionError: for too many different ones, and for one whose square is not rational at the point.
    """
    states, norms = point.keys(), dict[str, Norm]()

    def change(node: ast.expr) -> ast.expr | None:
        norm = _norm_of(node, states)
        if norm is None:
            return None
        argument, exponent = written(norm[0]), norm[1]
        if argument not in norms:
            name = NAMED.format(len(norms) + 1)
            while any(name in other for other in taken):  # entries of unit vectors are named after their norm
                name += "_"
            norms[argument] = Norm(NORM, argument, name, _value_at(norm[0], point))
        size = power(ast.Name(norms[argument].name), abs(exponent))
        return size if exponent > 0 else quotient(ONE, size)

    def named(formula: object) -> object:
        tree = readable_tree(formula) if holds_norms(formula, states) else None
        return formula if tree is None else written(replaced(tree, change))

    named_lists = [tuple(map(named, formulas)) for formulas in lists]
    if len(norms) > MAX_NORMS:
        raise ExpressionError(f"required at most {MAX_NORMS} different roots of sums of squares, received {len(norms)}")
    return named_lists, tuple(norms.values())


def _value_at(square: ast.expr, point: Mapping[str, Fraction | None]) -> Fraction:
    try:
        return Fraction(RATIONAL.value(square, point))
    except (TypeError, KeyError):
        expected = "sums of squares under roots that are rational at the checked point, without functions such as sin"
        raise ExpressionError(f"required {expected}, received {shown(written(square))}") from None


def with_norms(norms: Sequence[Bounded], place: Mapping[str, float]) -> dict[str, float]:
    """A place in floats, by name, with the values of norms beside those of the states."""
    roots = [norm for norm in norms if norm.kind == NORM]
    return {**place, **{root.name: float_value(root.stated, place, root.argument) for root in roots}}


def restored(tree: ast.expr, norms: Sequence[Bounded]) -> ast.expr:
    """A formula with roots in place of the names of norms."""
    return with_names(tree, {norm.name: norm.stated for norm in norms})


# ---- affine in every norm ------------------------------------------------------------------------


def affine_in_norms(formula: object, norms: Sequence[Bounded]) -> object:
    """A formula of states and names of norms that is affine in each of these; as it is where it holds none.

    Raises:
        ExpressionError: for a norm that does not stand in sums, products and whole powers alone.
    """
    tree, roots = readable_tree(formula), [norm for norm in norms if norm.kind == NORM]
    if tree is None or names_of(tree).isdisjoint(root.name for root in roots):
        return formula
    for root in roots:
        without, factor = affine_parts(tree, root.name, formula_tree(root.argument), str(formula))
        tree = total([without, multiplied(ast.Name(root.name), factor)])
    return written(tidied(tree))


def affine_parts(node: ast.expr, name: str, square: ast.expr | None, text: str) -> tuple[ast.expr, ast.expr]:
    """A and B of a part that is ``A + s B``, where ``s^2`` is known; or does not occur.

    Raises:
        ExpressionError: for any other part.
    """
    if name not in names_of(node):
        return node, ZERO
    match node:
        case ast.Name():
            return ZERO, ONE
        case ast.UnaryOp(op=ast.UAdd() | ast.USub()):
            parts = affine_parts(node.operand, name, square, text)
            first, second = map(minus, parts) if isinstance(node.op, ast.USub) else parts
            return first, second
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            (a, b), (c, d) = (affine_parts(side, name, square, text) for side in (node.left, node.right))
            if isinstance(node.op, ast.Sub):
                c, d = minus(c), minus(d)
            return total([a, c]), total([b, d])
        case ast.BinOp(op=ast.Mult()):
            (a, b), (c, d) = (affine_parts(side, name, square, text) for side in (node.left, node.right))
            factor = total([multiplied(a, d), multiplied(b, c)])
            if b is ZERO or d is ZERO:
                return multiplied(a, c), factor
            if square is not None:
                return total([multiplied(a, c), multiplied(square, b, d)]), factor
        case ast.BinOp(op=ast.Div()) if name not in names_of(node.right):
            without, factor = affine_parts(node.left, name, square, text)
            return quotient(without, node.right), ZERO if factor is ZERO else quotient(factor, node.right)
        case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(exponent))) if exponent > 1:
            return affine_parts(multiplied(*[node.left] * exponent), name, square, text)
    raise ExpressionError(
        f"required roots such as {EXAMPLE} in sums, products and quotients only, received {shown(text)}"
    )


# ---- between polyhedral norms --------------------------------------------------------------------


def at_ends(
    formulas: Sequence[object], norms: Sequence[Bounded], states: Collection[str], order: int
) -> list[list[object]]:
    """Lists of formulas whose hull holds some that are affine in norms: with each of these at its bounds, all alike."""
    trees = map(readable_tree, formulas)
    names = {name for tree in trees if tree is not None for name in names_of(tree)}
    present = [norm for norm in norms if norm.name in names]
    lists = []
    for chosen in product(*(norm.bounds(states, order) for norm in present)):
        meanings = {norm.name: bound for norm, bound in zip(present, chosen, strict=True)}
        lists.append([with_meanings(formula, meanings) for formula in formulas])
    return lists


def with_meanings(formula: object, meanings: Mapping[str, ast.expr]) -> object:
    """A formula with others in place of names; as it is written where it holds none of these."""
    tree = readable_tree(formula)
    if tree is None or meanings.keys().isdisjoint(names_of(tree)):
        return formula
    return written(tidied(with_names(tree, meanings)))


def _beside_root(norm: Norm, squares: Sequence[Square], order: int) -> tuple[ast.expr, ...]:
    """The bounds where a norm is positive at the point, which the one below is at least at order 0 if it may be."""
    root, others = called(NORM, number(norm.square)), [square for square in squares if square[1] is not ONE]
    is_least = sum(c for c, base in squares if base is ONE) == norm.square
    if is_least:
        part = total(multiplied(number(c / norm.square), power(base, 2)) for c, base in others)
    else:
        part = plus(quotient(formula_tree(norm.argument), number(norm.square)), number(-1))
    upper = plus(ONE, quotient(part, number(2)))
    lower = ONE if is_least and not order else plus(upper, minus(quotient(power(part, 2), number(2))))
    return multiplied(root, lower), multiplied(root, upper)


def _largest(
    squares: Sequence[Square], vectors: Sequence[tuple[Fraction, Fraction]], least: Fraction, *, is_above: bool
) -> ast.expr:
    """The polyhedral norm below or above a norm."""
    bound, *others = (multiplied(number(root_beside(c, is_above=is_above)), _size(base)) for c, base in squares)
    for size in others:
        parts = [_weighted(vector, (bound, size), least if is_above else Fraction(1)) for vector in vectors]
        bound = called("Max", *parts) if len(parts) > 1 else parts[0]
    return bound


def _size(base: ast.expr) -> ast.expr:
    return base if base is ONE else called("Abs", base)


def _weighted(vector: tuple[Fraction, Fraction], sizes: tuple[ast.expr, ast.expr], least: Fraction) -> ast.expr:
    return total(multiplied(number(weight / least), size) for weight, size in zip(vector, sizes, strict=True))


def root_beside(value: Fraction, *, is_above: bool) -> Fraction:
    """A rational number at most, or at least, the square root of a positive one, by less than a part in FINE.

    The root where it is rational.
    """
    top, bottom = isqrt(value.numerator), isqrt(value.denominator)
    if Fraction(top, bottom) ** 2 == value:
        return Fraction(top, bottom)
    scale = FINE
    while value * scale**2 < FINE**2:
        scale *= 2
    below = Fraction(isqrt(value.numerator * scale**2 // value.denominator), scale)
    return below + Fraction(1, scale) if is_above else below


@cache
def directions(order: int) -> tuple[tuple[tuple[Fraction, Fraction], ...], Fraction]:
    """Rational vectors u of the first quadrant, and a bound of the least ``max u . e`` of its unit vectors e.

    At order -1 there is one, which is shorter than a unit vector.
    """
    if order < 0:
        return ((ALIKE, ALIKE),), ALIKE
    count = 2 ** (order + 1)
    first = [_unit_vector((2 * j + 1) * pi / (4 * count)) for j in range(count // 2)]
    vectors = (*first, *((y, x) for x, y in reversed(first)))
    least = vectors[0][0]  # on an axis
    for (a, b), (c, d) in pairwise(vectors):
        x, y = b - d, c - a  # where both are equal, of any length
        squared = (a * x + b * y) ** 2 / (x * x + y * y)
        least = min(least, root_beside(squared, is_above=False))
    return vectors, least


def _unit_vector(angle: float) -> tuple[Fraction, Fraction]:
    """A rational unit vector near an angle, by the tangent of half of it."""
    t = Fraction(tan(angle / 2)).limit_denominator(SIMPLE)
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
