"""User text to exact numbers, through a small whitelist over Python's own grammar.

Text is parsed by :func:`ast.parse` and walked; it is never evaluated.  Allowed: numbers (decimals are
exact, ``0.1 = 1/10``), ``+ - * /``, ``**`` with a small literal integer, ``sqrt``, ``sin``, ``cos``, ``pi``
and the variable names the caller names.  Length, exponents and the size of results are bounded, so no
text can keep the machine busy.
"""

from __future__ import annotations

import ast
import operator
import re
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from functools import lru_cache
from typing import Any

from nonsmooth.symbolic.messages.scene_error import SceneError, requirement, shown
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField, base_order
from nonsmooth.symbolic.numbers.square_roots import NestingError

MAX_LENGTH = 400  # characters; longer formulas belong in a CSV file
MAX_EXPONENT = 64
MAX_BITS = 20_000  # size of an intermediate rational
MAX_ROOTS = 6  # independent square roots in one number: quotients hold up to 2^6 terms
MAX_DECIMAL_EXPONENT = 400
MAX_ANGLE_DENOMINATOR = 360
MAX_FIELD_ORDER = 2_000  # angles with many different denominators multiply the degree of the field

_WITH_UNIT = re.compile(r"([0-9]{1,20}(?:\.[0-9]{1,20})?) ?(%|kg|g|lb|N|m|cm|mm|in|(?:m|cm|mm|in)/s|s)")
_ABS = re.compile(r"\babs *\(")  # read as Abs, the one name that certificates and the checker know
_ODD_EXPONENT = re.compile(r"\*\*\s*(?!\d+\b(?!\.))")  # not in digits alone
_OTHER_DIGITS = re.compile(r"(?<![\w.])0[box]\w*", re.IGNORECASE)  # Python's integers to other bases
_FUNCTIONS = ("sqrt", "sin", "cos")
OPERATIONS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {  # in any arithmetic
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


class ExpressionError(ValueError):
    """Text that is no number or formula of the accepted kind; the message says what was expected."""


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
    names = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)} & variables
    expression = Expression(text, tree, frozenset(names))
    if base_order(expression.turns()) > MAX_FIELD_ORDER:
        raise ExpressionError(f"required angles of few different denominators, received {shown(text)}")
    return expression


_parsed_once = lru_cache(maxsize=4096, typed=True)(_parsed)  # scenes of a sweep repeat most of their texts


_read_once = lru_cache(ast.parse)


def parse_tree(value: object, longest: int, required: str) -> tuple[str, ast.expr]:
    """The text of a TOML number or string, and its tree, of which nothing is checked yet; ``abs(x)`` is ``Abs(x)``.

    Equal texts have one tree: who changes a tree parses its own.

    Args:
        value: what the file holds.
        longest: characters of a string.
        required: what should have stood there, with an example.

    Raises:
        ExpressionError: for other values, long texts, decimals out of bounds, powers by ``^``, hexadecimal numbers,
            and what Python cannot parse.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal | str):
        raise ExpressionError(f"required a number or a formula in quotes, received {shown(value)}")
    if isinstance(value, int) and value.bit_length() > 4 * MAX_LENGTH:  # str() refuses very long integers
        raise ExpressionError(f"required at most {MAX_LENGTH} digits, received {shown(value)}")
    text = str(value).strip()
    if "#" not in text:  # a comment would go on
        text = " ".join(text.splitlines()).expandtabs(1)
    text = _ABS.sub("Abs(", text)
    most = longest if isinstance(value, str) else MAX_LENGTH
    if len(text) > most:
        raise ExpressionError(f"required at most {most} characters, received {len(text)}")
    if isinstance(value, float | Decimal):
        decimal_value(text)
    if "^" in text:
        raise ExpressionError(f"required ** for powers, as in x**2, received {shown(value)}")
    if _OTHER_DIGITS.search(text):
        raise ExpressionError(f"required decimal numbers, received {shown(value)}")
    try:
        if "#" in text:
            raise SyntaxError("a comment")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python's advice on "1if 2else 3" and the like, refused below
            return text, _read_once(text, mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        hint = _without_unit(text)
        raise ExpressionError(f"required {hint or required}, received {shown(value)}") from None


def with_whole_exponents(text: str) -> str:
    """A formula whose whole exponents stand there in digits, also where they are written ``2.0`` or ``(1 + 2*1)``.

    A text that cannot be read stays as it is, for who reads it to refuse.
    """
    if not text.isascii() or not _ODD_EXPONENT.search(text):
        return text
    try:
        text, tree = parse_tree(text, len(text), "a formula")
    except ExpressionError:
        return text
    found, waiting = [], [tree]
    while waiting:
        node = waiting.pop()
        inner = [part for part in ast.iter_child_nodes(node) if isinstance(part, ast.expr)]
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
            inner = [node.left]
            found.append(node.right)
        waiting += inner
    for exponent in sorted(found, key=lambda own: -own.col_offset):
        first, last = exponent.col_offset, exponent.end_col_offset
        try:
            value, in_pi = parse(text[first:last]).parts_in_pi()
        except ExpressionError:
            continue
        if value.denominator == 1 and not in_pi:
            text = f"{text[:first]}{value}{text[last:]}"
    return text


def _without_unit(text: str) -> str:
    """What stands for a number with a percent sign or a unit behind it; empty for other texts."""
    named = _WITH_UNIT.fullmatch(text)
    if named is None:
        return ""
    if named[2] == "%":
        return f'a number (for {named[1]} % write "{named[1]}/100")'
    return f"a number without a unit: lengths and speeds as [units] states them, mass in kg (is {named[1]} meant?)"


def decimal_value(text: str) -> Fraction:
    """Exact value of a decimal literal.

    Raises:
        ExpressionError: for NaN, infinities and exponents beyond the bound.
    """
    try:
        number = Decimal(text.replace("_", ""))
    except InvalidOperation:
        raise ExpressionError(f"required a decimal number, received {shown(text)}") from None
    if not number.is_finite():
        raise ExpressionError(f"required a finite number, received {shown(text)}")
    if abs(number.adjusted()) > MAX_DECIMAL_EXPONENT and number:
        bound = MAX_DECIMAL_EXPONENT
        raise ExpressionError(f"required a decimal exponent between -{bound} and {bound}, received {shown(text)}")
    return Fraction(number) if number else Fraction(0)


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
            _literal(node, text)
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


def _literal(node: ast.Constant, text: str) -> Fraction:
    if isinstance(node.value, int):
        return Fraction(node.value)
    return decimal_value(ast.get_source_segment(text, node) or "nan")


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
            return _literal(node, text), Fraction(0)
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
            return field.rational(_literal(node, text))
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
