"""Formulas with ``sign``, ``Abs``, ``Max`` and ``Min``: polynomials on each side of where an inner expression vanishes.

``Max(a, b)`` is ``(a + b + Abs(a - b))/2``, and ``Min`` likewise; more than two arguments are compared one by one.
``relu(a)`` is ``Max(a, 0)``, and ``sat(a, low, high)`` is ``Max(low, Min(high, a))``.
Text is parsed and walked like that of :mod:`nonsmooth.symbolic.formulas.expression`, never evaluated; every part
without a state is handed to that module, so numbers, roots and cosines are its own.  Given the sign of every inner
expression, a formula is a polynomial (:meth:`PiecewiseExpression.polynomial`); who asks decides where each sign holds.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, lru_cache, reduce
from typing import TypeAlias

from nonsmooth.symbolic.formulas.expression import Expression, parse, turns_in
from nonsmooth.symbolic.formulas.trees import (
    EXTREMES,
    LIMITERS,
    MAX_DEPTH,
    MAX_TEXT,
    OPERATIONS,
    SIGNS,
    ExpressionError,
    parse_tree,
    written,
)
from nonsmooth.symbolic.messages.scene_error import shown
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial

MAX_DEGREE = 16  # of a smooth piece

SWITCHES = (*SIGNS, "Abs", *EXTREMES, *LIMITERS)
NUMBERS = ("pi", "sqrt", "sin", "cos")

SignOf: TypeAlias = Callable[[Polynomial], int]


@dataclass(frozen=True)
class PiecewiseExpression:
    """A checked formula in named states."""

    text: str
    tree: ast.expr = field(compare=False)  # of the text
    states: frozenset[str]

    def polynomial(self, values: Mapping[str, Polynomial], sign_of: SignOf) -> Polynomial:
        """The smooth piece for the given signs.

        Args:
            values: a polynomial for each state.
            sign_of: sign of an inner expression on the piece; not asked about constants.

        Raises:
            ExpressionError: where a piece is no polynomial, divides by zero or is of too high a degree.
        """
        return _polynomial(self.tree, self, values, sign_of)

    def turns(self) -> Iterator[Fraction]:
        """Every angle ``pi * turn`` under a sine or cosine."""
        return turns_in(self.tree, self.text)

    @cached_property
    def switching_parts(self) -> tuple[PiecewiseExpression, ...]:
        """The outermost parts that may switch, each as a formula of its own."""
        parts: list[PiecewiseExpression] = []
        waiting: list[ast.AST] = [self.tree]
        while waiting:
            node = waiting.pop()
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in SWITCHES:
                parts.append(PiecewiseExpression(self.text, node, self.states))
            else:
                waiting += reversed(list(ast.iter_child_nodes(node)))
        return tuple(parts)

    @property
    def summands(self) -> Iterator[PiecewiseExpression]:
        """What it is the sum of, up to signs, from left to right; itself where it is no sum."""
        waiting = [self.tree]
        while waiting:
            node = waiting.pop()
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
                waiting += [node.right, node.left]
            else:
                yield PiecewiseExpression(self.text, node, self.states)

    def is_constant(self, node: ast.expr) -> bool:
        """Whether a part mentions no name but those of numbers."""
        return node in self._constant_parts

    @cached_property
    def _constant_parts(self) -> frozenset[ast.AST]:
        """All parts that mention none; of a long formula nothing is walked twice."""
        constant: set[ast.AST] = set()
        for node in reversed(list(ast.walk(self.tree))):  # what a part consists of comes before it
            if node.id in NUMBERS if isinstance(node, ast.Name) else constant.issuperset(ast.iter_child_nodes(node)):
                constant.add(node)
        return frozenset(constant)

    @cached_property
    def smooth_parts(self) -> frozenset[ast.AST]:
        """The largest parts that do not switch, longer than a state."""
        smooth: set[ast.AST] = set()
        for node in reversed(list(ast.walk(self.tree))):  # what a part consists of comes before it
            if node in self.numbers or not (isinstance(node, ast.Call) or set(ast.iter_child_nodes(node)) - smooth):
                smooth.add(node)
        inner = {part for node in smooth for part in ast.iter_child_nodes(node)}
        return frozenset(node for node in smooth - inner if not isinstance(node, ast.Name))

    @cached_property
    def numbers(self) -> Mapping[ast.expr, Expression]:
        """The largest parts without states, from left to right, read once for all pieces."""
        numbers: dict[ast.expr, Expression] = {}
        waiting = [self.tree]
        while waiting:
            node = waiting.pop()
            if self.is_constant(node):
                numbers[node] = _constant(node)
            else:
                waiting += reversed([part for part in ast.iter_child_nodes(node) if isinstance(part, ast.expr)])
        return numbers


_known = lru_cache(PiecewiseExpression)  # with what was read of its tree


def parse_piecewise(value: object, states: Collection[str], beside: Sequence[str] = ()) -> PiecewiseExpression:
    """Check a formula of the states.

    Args:
        value: its text.
        states: their names.
        beside: what a file may state here too, and was rewritten before; named where something else is refused.

    Raises:
        ExpressionError: for anything outside the whitelist.
    """
    text, tree = parse_tree(value, MAX_TEXT, 'a formula such as "-sign(x)"')
    expression = _known(text, tree, frozenset(states))
    try:
        _check(tree, expression, MAX_DEPTH)
    except _OutsideError as error:
        functions = "sign, abs, max, min, relu, sat", "sqrt, sin, cos of numbers"
        allowed = ", ".join((*sorted(states), "numbers", "+ - * / **", *functions, *beside))
        part = ast.get_source_segment(text, error.node)
        without = f", without {shown(part)}" if part != text else ""
        raise ExpressionError(f"required a formula of {allowed}{without}, received {shown(text)}") from None
    return expression


class _OutsideError(Exception):
    """A construct outside the whitelist."""

    def __init__(self, node: ast.expr) -> None:
        super().__init__()
        self.node = node


def _check(node: ast.expr, whole: PiecewiseExpression, depth: int) -> None:
    """Refuse every construct outside the whitelist."""
    if not depth:
        raise ExpressionError(f"required at most {MAX_DEPTH} nested operations, received {shown(whole.text)}")
    if whole.is_constant(node):
        _constant(node)
        return
    match node:
        case ast.Name(id=name) if name in whole.states:
            pass
        case ast.UnaryOp(op=ast.UAdd() | ast.USub()):
            _check(node.operand, whole, depth - 1)
        case ast.BinOp(op=ast.Pow()):
            _check(node.left, whole, depth - 1)
            _exponent(node.right, whole)
        case ast.BinOp() if type(node.op) in OPERATIONS:
            _check(node.left, whole, depth - 1)
            _check(node.right, whole, depth - 1)
        case ast.Call(func=ast.Name(id=name), keywords=[]) if _takes(name, len(node.args)):
            for argument in node.args:
                _check(argument, whole, depth - 1)
        case ast.Call(func=ast.Name(id=name)) if name in SWITCHES:
            raise ExpressionError(f"required {name}({', '.join(_arguments(name))}), received {shown(whole.text)}")
        case _:
            raise _OutsideError(node)


def _takes(name: str, count: int) -> bool:
    """Whether a function of that name has so many arguments."""
    if name in EXTREMES:
        return count >= 2
    return name in SWITCHES and count == LIMITERS.get(name, 1)


def _arguments(name: str) -> Sequence[str]:
    """Names of what a function takes."""
    return ("a", "b", "...") if name in EXTREMES else ("a", "low", "high")[: LIMITERS.get(name, 1)]


def _constant(node: ast.expr) -> Expression:
    """A part without states, checked by the parser of numbers."""
    return parse(written(node))


def _exponent(node: ast.expr, whole: PiecewiseExpression) -> int:
    value = node.value if isinstance(node, ast.Constant) else None
    if not isinstance(value, int) or isinstance(value, bool) or value > MAX_DEGREE:
        raise ExpressionError(f"required an integer exponent from 0 to {MAX_DEGREE}, received {shown(whole.text)}")
    return value


def _polynomial(
    node: ast.expr, whole: PiecewiseExpression, values: Mapping[str, Polynomial], sign_of: SignOf
) -> Polynomial:
    some = next(iter(values.values()))
    if node in whole.numbers:
        number = whole.numbers[node].value(some.field)
        return Polynomial.constant(some.field, some.variables, number)
    if node in whole.smooth_parts:
        return _smooth_part(node, whole, some.field, tuple(values.items()))
    return _of_parts(node, whole, values, sign_of)


@lru_cache(maxsize=1024)
def _smooth_part(
    node: ast.expr, whole: PiecewiseExpression, field: NumberField, values: Sequence[tuple[str, Polynomial]]
) -> Polynomial:
    """A part that does not switch: every piece asks for it again."""
    return _of_parts(node, whole, dict(values), no_sign)


def no_sign(inner: Polynomial) -> int:
    """Refuse to switch."""
    raise ExpressionError(f"required no switching, received {inner}")


def _of_parts(
    node: ast.expr, whole: PiecewiseExpression, values: Mapping[str, Polynomial], sign_of: SignOf
) -> Polynomial:
    match node:
        case ast.Name(id=name):
            return values[name]
        case ast.UnaryOp():
            operand = _polynomial(node.operand, whole, values, sign_of)
            return -operand if isinstance(node.op, ast.USub) else operand
        case ast.BinOp(op=ast.Pow()):
            exponent = _exponent(node.right, whole)
            base = _polynomial(node.left, whole, values, sign_of)
            _bounded(base.degree * exponent, whole)
            return base**exponent
        case ast.BinOp():
            left = _polynomial(node.left, whole, values, sign_of)
            right = _polynomial(node.right, whole, values, sign_of)
            return _combined(node.op, left, right, whole)
        case ast.Call(func=ast.Name(id=name)) if name in LIMITERS:
            arguments = [_polynomial(argument, whole, values, sign_of) for argument in node.args]
            return _limited(name, arguments, sign_of, whole)
        case ast.Call(func=ast.Name(id=name), args=[argument]):
            inner = _polynomial(argument, whole, values, sign_of)
            sign = _sign(inner, sign_of)
            return inner * sign if name == "Abs" else Polynomial.constant(inner.field, inner.variables, sign)
        case ast.Call(func=ast.Name(id=name)):
            arguments = [_polynomial(argument, whole, values, sign_of) for argument in node.args]
            return reduce(lambda a, b: _extreme(a, b, EXTREMES[name], sign_of), arguments)
    raise ExpressionError(f"required a formula, received {shown(whole.text)}")


def _sign(inner: Polynomial, sign_of: SignOf) -> int:
    constant = inner.constant_value
    return sign_of(inner) if constant is None else constant.sign()


def _limited(name: str, arguments: Sequence[Polynomial], sign_of: SignOf, whole: PiecewiseExpression) -> Polynomial:
    """``relu(a)`` or ``sat(a, low, high)``.

    Raises:
        ExpressionError: for numbers as limits of which the lower one is the larger.
    """
    first = arguments[0]
    if name == "relu":
        return _extreme(first, first * 0, 1, sign_of)
    _, low, high = arguments
    room = (high - low).constant_value
    if room is not None and room.sign() < 0:
        raise ExpressionError(f"required sat(a, low, high) with low <= high, received {shown(whole.text)}")
    return _extreme(_extreme(first, high, -1, sign_of), low, 1, sign_of)


def _extreme(a: Polynomial, b: Polynomial, side: int, sign_of: SignOf) -> Polynomial:
    """The larger of two for side 1, the smaller for side -1."""
    difference = a - b
    return (a + b + difference * (side * _sign(difference, sign_of))) * a.field.rational(Fraction(1, 2))


def _combined(operator: ast.operator, left: Polynomial, right: Polynomial, whole: PiecewiseExpression) -> Polynomial:
    if isinstance(operator, ast.Mult):
        _bounded(left.degree + right.degree, whole)
    if not isinstance(operator, ast.Div):
        combined: Polynomial = OPERATIONS[type(operator)](left, right)
        return combined
    divisor = right.constant_value
    if divisor is None:
        raise ExpressionError(f"required polynomials (no division by a state), received {shown(whole.text)}")
    if not divisor:
        raise ExpressionError(f"required a finite number, received a division by zero in {shown(whole.text)}")
    return left * divisor.inverse()


def _bounded(degree: int, whole: PiecewiseExpression) -> None:
    if degree > MAX_DEGREE:
        raise ExpressionError(f"required polynomials of degree up to {MAX_DEGREE}, received {shown(whole.text)}")
