"""User text to exact numbers, through a small whitelist over Python's own grammar.

Text is parsed by :func:`ast.parse` and walked; it is never evaluated.  Allowed: numbers (decimals are
exact, ``0.1 = 1/10``), ``+ - * /``, ``**`` with a small literal integer, ``sqrt``, ``sin``, ``cos``, ``pi``
and the variable names the caller names.  Length, exponents and the size of results are bounded, so no
text can keep the machine busy.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from nonsmooth.symbolic.formulas.trees import (
    MAX_LENGTH,
    OPERATIONS,
    ExpressionError,
    literal_value,
    names_of,
    number,
    parse_tree,
    replaced,
    written,
)
from nonsmooth.symbolic.messages.scene_error import SceneError, requirement, shown
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField, base_order
from nonsmooth.symbolic.numbers.square_roots import NestingError

MAX_EXPONENT = 64
MAX_BITS = 20_000  # size of an intermediate rational
MAX_ROOTS = 6  # independent square roots in one number: quotients hold up to 2^6 terms
MAX_ANGLE_DENOMINATOR = 360
MAX_FIELD_ORDER = 2_000  # angles with many different denominators multiply the degree of the field

_FUNCTIONS = ("sqrt", "sin", "cos")


@contextmanager
def formula_refused(file: str, key: str, received: object) -> Iterator[None]:
    """A formula that cannot be used is an error of the scene, under its key; ``received`` stands in the message.

    Raises:
        SceneError: for an :class:`ExpressionError`.
    """
    try:
        yield
    except ExpressionError as error:
        raise SceneError(file, key, requirement(error), received) from None


@dataclass(frozen=True)
class Expression:
    """A checked formula; ``names`` are the variables it mentions."""

    text: str
    tree: ast.expr
    names: frozenset[str]

    def value(self, field: NumberField, values: Mapping[str, Number] | None = None) -> Number:
        """Exact value for the given variables.

        Raises:
            ExpressionError: on division by zero, a negative square root, or a number out of bounds.
        """
        try:
            return _value(self.tree, self.text, field, values or {})
        except ZeroDivisionError:
            raise ExpressionError(
                f"required a finite number, received a division by zero in {shown(self.text)}"
            ) from None

    def turns(self) -> Iterator[Fraction]:
        """Every angle ``pi * turn`` under a sine or cosine: these fix the base of the number field."""
        return turns_in(self.tree, self.text)

    def parts_in_pi(self) -> tuple[Fraction, Fraction]:
        """Rational a and b of a formula ``a + b pi``.

        Raises:
            ExpressionError: for any other formula.
        """
        return _linear_in_pi(self.tree, self.text)


def parse(value: object, variables: Collection[str] = ()) -> Expression:
    """Check a TOML number or string and return it as an :class:`Expression`.

    Raises:
        ExpressionError: for anything outside the whitelist.
    """
    return (_parsed_once if isinstance(value, int | str) else _parsed)(value, frozenset(variables))


def _parsed(value: object, variables: frozenset[str]) -> Expression:
    text, tree = parse_tree(value, MAX_LENGTH, 'a number or a formula such as "sqrt(2)/2"')
    _check(tree, text, variables)
    expression = Expression(text, tree, variables & names_of(tree))
    if base_order(expression.turns()) > MAX_FIELD_ORDER:
        raise ExpressionError(f"required angles of few different denominators, received {shown(text)}")
    return expression


_parsed_once = lru_cache(maxsize=4096, typed=True)(_parsed)  # scenes of a sweep repeat most of their texts


def with_whole_exponents(tree: ast.expr) -> ast.expr:
    """A formula whose whole exponents are numbers, also where they were written ``2.0`` or ``(1 + 2*1)``."""

    def change(node: ast.expr) -> ast.expr | None:
        if not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)) or isinstance(node.right, ast.Name):
            return None
        exponent = _whole(node.right)
        if exponent is None or (isinstance(node.right, ast.Constant) and isinstance(node.right.value, int)):
            return None
        return ast.BinOp(replaced(node.left, change), ast.Pow(), number(exponent))

    return replaced(tree, change)


def _whole(node: ast.expr) -> Fraction | None:
    """The value of a formula that is a whole number; None for any other."""
    try:
        value, in_pi = parse(written(node)).parts_in_pi()
    except ExpressionError:
        return None
    return value if value.denominator == 1 and not in_pi else None


def turns_in(tree: ast.expr, text: str) -> Iterator[Fraction]:
    """Every angle ``pi * turn`` under a sine or cosine of a formula; raises as :func:`turn_of`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("sin", "cos"):
            yield turn_of(node.args[0], text)


def turn_of(node: ast.expr, text: str) -> Fraction:
    """Rational t with ``node = t * pi``.

    Raises:
        ExpressionError: if the angle is no rational multiple of pi of moderate denominator.
    """
    constant, multiple = _linear_in_pi(node, text)
    if constant:
        raise ExpressionError(f'required a rational multiple of pi such as "pi/3", received {shown(text)}')
    if multiple.denominator > MAX_ANGLE_DENOMINATOR:
        raise ExpressionError(
            f"required a multiple of pi of denominator up to {MAX_ANGLE_DENOMINATOR}, received {shown(text)}"
        )
    return multiple


def _check(node: ast.expr, text: str, variables: frozenset[str]) -> None:
    """Refuse every construct outside the whitelist."""
    match node:
        case ast.Constant(value=int() | float()) if not isinstance(node.value, bool):
            literal_value(node)
        case ast.Name(id="pi"):
            pass
        case ast.Name(id=name) if name in variables:
            pass
        case ast.UnaryOp(op=ast.UAdd() | ast.USub()):
            _check(node.operand, text, variables)
        case ast.BinOp(op=ast.Pow()):
            _check(node.left, text, variables)
            _exponent(node.right, text)
        case ast.BinOp() if type(node.op) in OPERATIONS:
            _check(node.left, text, variables)
            _check(node.right, text, variables)
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in _FUNCTIONS:
            if name == "sqrt":
                _check(argument, text, variables)
            else:
                turn_of(argument, text)
        case _:
            allowed = ", ".join([*sorted(variables), "numbers", "+ - * / **", *_FUNCTIONS, "pi"])
            raise ExpressionError(f"required a formula of {allowed}, received {shown(text)}")


def _exponent(node: ast.expr, text: str) -> int:
    signed = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd)
    negative = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub)
    inner = node.operand if isinstance(node, ast.UnaryOp) and signed else node
    value = inner.value if isinstance(inner, ast.Constant) else None
    if not isinstance(value, int) or isinstance(value, bool) or value > MAX_EXPONENT:
        raise ExpressionError(f"required an integer exponent up to {MAX_EXPONENT}, received {shown(text)}")
    return -value if negative else value


def _linear_in_pi(node: ast.expr, text: str) -> tuple[Fraction, Fraction]:
    """``node = constant + multiple * pi`` with rational parts."""
    match node:
        case ast.Constant():
            return literal_value(node), Fraction(0)
        case ast.Name(id="pi"):
            return Fraction(0), Fraction(1)
        case ast.UnaryOp(op=ast.USub()):
            constant, multiple = _linear_in_pi(node.operand, text)
            return -constant, -multiple
        case ast.UnaryOp(op=ast.UAdd()):
            return _linear_in_pi(node.operand, text)
        case ast.BinOp():
            (a, b), (c, d) = _linear_in_pi(node.left, text), _linear_in_pi(node.right, text)
            match node.op:
                case ast.Add() | ast.Sub():
                    return OPERATIONS[type(node.op)](a, c), OPERATIONS[type(node.op)](b, d)
                case ast.Mult() if not (b and d):
                    return a * c, a * d + b * c
                case ast.Div() if not d and c:
                    return a / c, b / c
    raise ExpressionError(f'required a rational multiple of pi such as "2*pi/3", received {shown(text)}')


def _value(node: ast.expr, text: str, field: NumberField, values: Mapping[str, Number]) -> Number:
    match node:
        case ast.Constant():
            return field.rational(literal_value(node))
        case ast.Name(id=name) if name in values:
            return values[name]
        case ast.Name(id="pi"):
            expected = "numbers such as 1/3 or sqrt(3)/2, with pi only inside sin and cos or in an angle"
            raise ExpressionError(f"required {expected}, received {shown(text)}")
        case ast.UnaryOp():
            operand = _value(node.operand, text, field, values)
            return -operand if isinstance(node.op, ast.USub) else operand
        case ast.BinOp(op=ast.Pow()):
            base, exponent = _value(node.left, text, field, values), _exponent(node.right, text)
            _bounded(base, text, factor=max(1, abs(exponent)))
            return base**exponent
        case ast.BinOp():
            left, right = _value(node.left, text, field, values), _value(node.right, text, field, values)
            return _bounded(OPERATIONS[type(node.op)](left, right), text)
        case ast.Call(func=ast.Name(id=name), args=[argument]):
            if name == "sqrt":
                return _square_root(_value(argument, text, field, values), text)
            turn = turn_of(argument, text)
            return field.cos_pi(turn) if name == "cos" else field.sin_pi(turn)
    raise ExpressionError(f"required a formula, received {shown(text)}")


def _square_root(value: Number, text: str) -> Number:
    if value.sign() < 0:
        raise ExpressionError(f"required a non-negative number under sqrt, received {shown(text)}")
    try:
        return value.sqrt()
    except NestingError as error:
        raise ExpressionError(f"{error}, received {shown(text)}") from None


def _bounded(value: Number, text: str, factor: int = 1) -> Number:
    """Refuse numbers whose coefficients or square roots grow beyond the bounds."""
    roots = 0
    for mask in value.terms:
        roots |= mask
    if roots.bit_count() > MAX_ROOTS:
        raise ExpressionError(f"required at most {MAX_ROOTS} independent square roots, received {shown(text)}")
    if value.size_bits * factor > MAX_BITS:
        raise ExpressionError(f"required numbers of at most {MAX_BITS} bits, received {shown(text)}")
    return value
