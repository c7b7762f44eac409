"""Formulas as trees: read from text, taken apart, put together, and written again.

A tree is an expression of Python's own grammar (:mod:`ast`): numbers, names, ``+ - * / **``, a minus before something,
and functions of formulas.  It is walked and never evaluated.  Decimals keep their digits (:class:`Digits`), so a tree
says all that its text says, and no part of it asks for the text that it was read from.  Trees are not changed: who
rewrites a formula builds another one, which may share parts with the first.
"""

from __future__ import annotations

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from functools import lru_cache, reduce
from typing import Any

from nonsmooth.symbolic.messages.scene_error import shown

MAX_LENGTH = 400  # characters; longer formulas belong in a CSV file
MAX_TEXT = 20_000  # characters of a formula of states: of a layer of rectifiers written out
MAX_DECIMAL_EXPONENT = 400
MAX_DEPTH = 60  # nested operations of a formula of states
DEEPEST = 250  # of anything: whoever walks a tree may do so by recursion

_WITH_UNIT = re.compile(r"([0-9]{1,20}(?:\.[0-9]{1,20})?) ?(%|kg|g|lb|N|m|cm|mm|in|(?:m|cm|mm|in)/s|s)")
_ABS = re.compile(r"\babs *\(")  # read as Abs, the one name that certificates and the checker know
_OTHER_DIGITS = re.compile(r"(?<![\w.])0[box]\w*", re.IGNORECASE)  # Python's integers to other bases
SIGNS = ("sign", "sgn")
EXTREMES = {"Max": 1, "max": 1, "Min": -1, "min": -1}  # the sign of Abs(a - b)
LIMITERS = {"relu": 1, "sat": 3}  # with their numbers of arguments
OPERATIONS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {  # in any arithmetic
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


class ExpressionError(ValueError):
    """Text that is no number or formula of the accepted kind; the message says what was expected."""


class Digits(float):
    """A decimal number in a tree, with the digits that it was written in."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.text = text

    def __repr__(self) -> str:
        return self.text


# ---- from text -----------------------------------------------------------------------------------


def parse_tree(value: object, longest: int, required: str) -> tuple[str, ast.expr]:
    """The text of a TOML number or string, and its tree, of which nothing is checked yet.

    ``abs(x)`` is ``Abs(x)``, and ``sat(x)`` is ``sat(x, -1, 1)``: certificates and the checker know these alone.

    Equal texts have one tree.

    Args:
        value: what the file holds.
        longest: characters of a string.
        required: what should have stood there, with an example.

    Raises:
        ExpressionError: for other values, long texts, decimals out of bounds, powers by ``^``, hexadecimal numbers,
            what Python cannot parse, and what is nested very deep.
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
            tree, depth = _read_once(text)
            if any(is_call(node, "sat") for node in ast.walk(tree)):
                text = written(_with_limits(tree))
                tree, depth = _read_once(text)
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        hint = _without_unit(text)
        raise ExpressionError(f"required {hint or required}, received {shown(value)}") from None
    if depth > DEEPEST:
        raise ExpressionError(f"required at most {MAX_DEPTH} nested operations, received {shown(text)}")
    return text, tree


@lru_cache
def _read_once(text: str) -> tuple[ast.expr, int]:
    """The tree of a text, and how deep it is nested."""
    tree = ast.parse(text, mode="eval").body
    level, depth = [tree], 0
    while level:
        depth += 1
        for node in level:
            if isinstance(node, ast.Constant) and isinstance(node.value, float):
                node.value = Digits(ast.get_source_segment(text, node) or "nan")
        level = [part for node in level for part in ast.iter_child_nodes(node) if isinstance(part, ast.expr)]
    return tree, depth


def _with_limits(tree: ast.expr) -> ast.expr:
    """With the limits that ``sat(a)`` has."""

    def change(node: ast.expr) -> ast.expr | None:
        match node:
            case ast.Call(func=ast.Name(id="sat"), args=[inner], keywords=[]):
                return called("sat", _with_limits(inner), number(-1), number(1))
        return None

    return replaced(tree, change)


def formula_tree(text: object) -> ast.expr:
    """The tree of a formula of states, of which nothing is checked yet.

    Raises:
        ExpressionError: as :func:`parse_tree`.
    """
    return parse_tree(text, MAX_TEXT, "a formula")[1]


def readable_tree(text: object) -> ast.expr | None:
    """The same; None for what is no formula, for who reads it to refuse."""
    try:
        return formula_tree(text)
    except ExpressionError:
        return None


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


# ---- taken apart ---------------------------------------------------------------------------------


def literal_value(node: ast.Constant) -> Fraction:
    """The exact value of a number in a tree.

    Raises:
        ExpressionError: for exponents beyond the bound, and for what is no number.
    """
    value = node.value
    if isinstance(value, int) and not isinstance(value, bool):
        return Fraction(value)
    return decimal_value(repr(value))


def names_of(node: ast.AST) -> set[str]:
    """All names in a tree, those of functions among them."""
    return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}


def is_call(node: ast.AST, name: str) -> bool:
    """Whether a part is a function of that name with one argument."""
    match node:
        case ast.Call(func=ast.Name(id=found), args=[_], keywords=[]):
            return found == name
    return False


def replaced(tree: ast.expr, change: Callable[[ast.expr], ast.expr | None]) -> ast.expr:
    """The tree with other trees in place of some of its parts, from the outside in.

    Args:
        tree: stays as it is.
        change: what stands for a part; None where its own parts are asked for.
    """
    replacement = change(tree)
    if replacement is not None:
        return replacement
    match tree:
        case ast.UnaryOp():
            return ast.UnaryOp(tree.op, replaced(tree.operand, change))
        case ast.BinOp():
            return ast.BinOp(replaced(tree.left, change), tree.op, replaced(tree.right, change))
        case ast.Call(keywords=[]):
            return ast.Call(tree.func, [replaced(part, change) for part in tree.args], [])
    return tree


def with_names(tree: ast.expr, meanings: Mapping[str, ast.expr]) -> ast.expr:
    """The tree with formulas in place of names."""
    return replaced(tree, lambda node: meanings.get(node.id) if isinstance(node, ast.Name) else None)


# ---- values --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Interpretation:
    """What formulas mean: in an arithmetic, or in a library or a language that has formulas of its own.

    Attributes:
        number: of a rational number.
        pi: the number.
        functions: sgn, Abs, Max and Min of two, and others by their names.
        operators: of the classes of Python's grammar: Add, Sub, Mult, Div, USub and Pow.
    """

    number: Callable[[Fraction], Any]
    pi: Any
    functions: Mapping[str, Callable[..., Any]]
    operators: Mapping[type, Callable[..., Any]] = field(
        default_factory=lambda: {**OPERATIONS, ast.Pow: operator.pow, ast.USub: operator.neg}
    )

    def value(self, node: ast.expr, names: Mapping[str, Any]) -> Any:
        """The value of a formula.

        Args:
            node: the formula, or a part of it.
            names: what stands for each name.

        Raises:
            TypeError: for what is no formula.
            KeyError: for a name, or a function, that has no meaning here.
        """
        match node:
            case ast.Constant():
                return self.number(literal_value(node))
            case ast.Name(id=name):
                return self.pi if name == "pi" and name not in names else names[name]
            case ast.UnaryOp(op=ast.USub()):
                return self.operators[ast.USub](self.value(node.operand, names))
            case ast.UnaryOp(op=ast.UAdd()):
                return self.value(node.operand, names)
            case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(exponent))):
                return self.operators[ast.Pow](self.value(node.left, names), exponent)
            case ast.BinOp():
                return self.operators[type(node.op)](self.value(node.left, names), self.value(node.right, names))
            case ast.Call(func=ast.Name(id=name), keywords=[]):
                return self._called(name, [self.value(argument, names) for argument in node.args])
        raise TypeError(f"required a formula, received {ast.dump(node)}")

    def _called(self, name: str, arguments: list[Any]) -> Any:
        """A function of formulas; ``relu`` and ``sat`` are written by Max and Min, these two by two."""
        largest, smallest = self.functions["Max"], self.functions["Min"]
        if name == "relu":
            return largest(arguments[0], self.number(Fraction(0)))
        if name == "sat":
            return largest(arguments[1], smallest(arguments[2], arguments[0]))
        if name in EXTREMES:
            return reduce(largest if EXTREMES[name] > 0 else smallest, arguments)
        return self.functions["sgn" if name in SIGNS else name](*arguments)


FLOATS = Interpretation(
    float,
    math.pi,
    {name: getattr(math, name) for name in ("sin", "cos", "tanh", "atan", "exp", "sqrt")}
    | {"Abs": abs, "Max": max, "Min": min, "sgn": lambda a: float((a > 0) - (a < 0))},
)


def float_value(node: ast.expr, values: Mapping[str, float], text: str) -> float:
    """The value of a part of a formula in floats, which only propose.

    Args:
        node: the part.
        values: of the states.
        text: the whole formula, for messages.

    Raises:
        ExpressionError: for anything that is no formula of the states, and where there is no finite value.
    """
    try:
        return float(FLOATS.value(node, values))
    except (KeyError, IndexError, TypeError, ValueError, ArithmeticError):
        raise ExpressionError(f"required a formula of the states with a finite value, received {shown(text)}") from None


# ---- put together --------------------------------------------------------------------------------
#
# What changes nothing is left out: summands that are zero, factors that are one.


ZERO, ONE = ast.Constant(0), ast.Constant(1)


def number(value: int | Fraction) -> ast.expr:
    """A rational number."""
    size = abs(Fraction(value))
    tree: ast.expr = ast.Constant(size.numerator)
    if size.denominator > 1:
        tree = ast.BinOp(tree, ast.Div(), ast.Constant(size.denominator))
    return minus(tree) if value < 0 else tree


def called(name: str, *arguments: ast.expr) -> ast.expr:
    """A function of formulas."""
    return ast.Call(ast.Name(name), list(arguments), [])


def minus(tree: ast.expr) -> ast.expr:
    """``-a``."""
    match tree:
        case ast.Constant(value=0):
            return tree
        case ast.UnaryOp(op=ast.USub()):
            return tree.operand
    return ast.UnaryOp(ast.USub(), tree)


def quotient(top: ast.expr, bottom: ast.expr) -> ast.expr:
    """``a/b``."""
    return top if _is(bottom, 1) else ast.BinOp(top, ast.Div(), bottom)


def power(base: ast.expr, exponent: int | Fraction) -> ast.expr:
    """``a**k``."""
    return base if exponent == 1 else ast.BinOp(base, ast.Pow(), number(exponent))


def plus(left: ast.expr, right: ast.expr) -> ast.expr:
    """``a + b``, or ``a - c`` where b is ``-c``."""
    match right:
        case ast.UnaryOp(op=ast.USub()):
            return ast.BinOp(left, ast.Sub(), right.operand)
    return ast.BinOp(left, ast.Add(), right)


def total(terms: Iterable[ast.expr]) -> ast.expr:
    """A sum."""
    others = [term for term in terms if not _is(term, 0)]
    return reduce(plus, others) if others else ZERO


def multiplied(*factors: ast.expr) -> ast.expr:
    """A product, its sign in front: zero where one factor is."""
    if any(_is(factor, 0) for factor in factors):
        return ZERO
    is_negative, others = False, []
    for factor in factors:
        positive = factor
        if isinstance(factor, ast.UnaryOp) and isinstance(factor.op, ast.USub):
            is_negative, positive = not is_negative, factor.operand
        if not _is(positive, 1):
            others.append(positive)
    first, *rest = others or [ONE]
    product = minus(first) if is_negative else first
    for other in rest:
        product = ast.BinOp(product, ast.Mult(), other)
    return product


def _is(node: ast.expr, value: int) -> bool:
    return isinstance(node, ast.Constant) and node.value == value and not isinstance(node.value, bool)


# ---- written -------------------------------------------------------------------------------------


_JOINTS: dict[type[ast.operator], tuple[str, int, int, int]] = {  # with how tightly they bind: themselves, both sides
    ast.Add: (" + ", 1, 1, 2),
    ast.Sub: (" - ", 1, 1, 2),
    ast.Mult: ("*", 2, 2, 3),
    ast.Div: ("/", 2, 2, 3),
    ast.Pow: ("**", 4, 5, 3),
}
_UNARY = 3


def written(tree: ast.expr) -> str:
    """A formula as text, with the parentheses that it needs.

    Raises:
        ExpressionError: for what is no formula.
    """
    return _written(tree, 0)


def _written(node: ast.expr, least: int) -> str:
    """A part of it, in parentheses where it binds less tightly than its surroundings ask for."""
    match node:
        case ast.Name(id=name):
            return name
        case ast.Call(func=ast.Name(id=name)):
            return f"{name}({', '.join(_written(part, 0) for part in node.args)})"
        case ast.UnaryOp(op=ast.USub() | ast.UAdd()):
            text = f"{'-' if isinstance(node.op, ast.USub) else '+'}{_after(_written(node.operand, _UNARY))}"
            binds = _UNARY
        case ast.BinOp() if type(node.op) in _JOINTS:
            joint, binds, left, right = _JOINTS[type(node.op)]
            text = f"{_written(node.left, left)}{joint}{_after(_written(node.right, right))}"
        case ast.Constant():
            return repr(node.value)
        case _:
            raise ExpressionError("required numbers, names, + - * / **, and functions of formulas")
    return text if binds >= least else f"({text})"


def _after(text: str) -> str:
    """What stands behind an operator: in parentheses where it begins with a minus."""
    return f"({text})" if text.startswith("-") else text


def tidied(tree: ast.expr) -> ast.expr:
    """A formula without signs, factors and summands that change nothing, as people read it.

    ``1*((+v) - (+v)**3/6 + 0*(+v)**5/120) - w`` becomes ``v - v**3/6 - w``.
    """
    match tree:
        case ast.UnaryOp():
            inner = tidied(tree.operand)
            return inner if isinstance(tree.op, ast.UAdd) or _is(inner, 0) else ast.UnaryOp(tree.op, inner)
        case ast.BinOp():
            return _tidied(tidied(tree.left), tree.op, tidied(tree.right))
        case ast.Call():
            return ast.Call(tree.func, list(map(tidied, tree.args)), tree.keywords)
    return tree


_NEUTRAL: dict[type[ast.operator], int] = {ast.Add: 0, ast.Sub: 0, ast.Mult: 1, ast.Div: 1}  # on the right


def _tidied(left: ast.expr, joint: ast.operator, right: ast.expr) -> ast.expr:
    """Two tidy parts, joined."""
    neutral = _NEUTRAL.get(type(joint))
    if neutral is not None and _is(right, neutral):
        return left
    if neutral is not None and isinstance(joint, ast.Add | ast.Mult) and _is(left, neutral):
        return right
    match joint:
        case ast.Mult() if _is(left, 0) or _is(right, 0):
            return ZERO
        case ast.Div() if _is(left, 0):
            return left
        case ast.Sub() if _is(left, 0):
            return ast.UnaryOp(ast.USub(), right)
        case ast.Add() | ast.Sub() if (positive := _without_minus(right)) is not None:
            return ast.BinOp(left, ast.Add() if isinstance(joint, ast.Sub) else ast.Sub(), positive)
    return ast.BinOp(left, joint, right)


def _without_minus(node: ast.expr) -> ast.expr | None:
    """What has a minus before it, or a first factor that has, without it; None where none is."""
    match node:
        case ast.UnaryOp(op=ast.USub()):
            return node.operand
        case ast.BinOp(left=left, op=ast.Mult() | ast.Div() as joint, right=right):
            positive = _without_minus(left)
            return None if positive is None else ast.BinOp(positive, joint, right)
    return None
