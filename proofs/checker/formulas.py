"""Formulas of a system and of functions, read by Python's grammar and never evaluated by Python.

A formula is built of the states, names of irrational numbers, decimals, ``+ - * / **`` and the switching functions
``sign``, ``Abs``, ``Max``, ``Min``, ``relu`` and ``sat``.  Where the signs of its switching expressions are known it is
a polynomial.

A right-hand side may hold ``sin``, ``cos``, ``tanh``, ``atan`` and ``exp`` of polynomials v, too (*waves*).  For every
real v, with an e between 0 and 1 that depends on v,

    sin v = v - v^3/6 + e v^5/120,    cos v = 1 - v^2/2 + v^4/24 - e v^6/720,
    tanh v = v - v^3/3 + e 2 v^5/15,  atan v = v - v^3/3 + e v^5/5,  and exp v = 1 + v + e v^2/2 for v <= 0,

and so between later sums, with further terms, whose number is the *order* of a system.  (Integrate ``cos <= 1`` and
``exp <= 1`` from 0 again and again, and ``1/(1 + t^2)`` between sums of its geometric series; ``tanh v`` is the sum
over odd k of ``8 v/(k^2 pi^2 + 4 v^2)``, each between sums of its geometric series.)  What exp is of must be minus a
sum of even powers and absolute values as it is written.  In other files *sines and cosines* stand for all five, unless
they speak of angles.  A wave stands in sums and products alone, and each has its own e, so that the formula is affine
in every e: its value is in the hull of those with all e at 0 or 1.  Where v switches, that is so on every cell.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from math import factorial
from typing import Any, TypeAlias

from .polynomials import Polynomial, constant
from .work import BUDGET, MAX_DIGITS, RejectedError, require, text

MAX_DEPTH, MAX_WAVES = 60, 5
TERMS = {"sin": 3, "cos": 4, "tanh": 3, "atan": 3, "exp": 3}  # of the series, the last one times e
WAVES, ANGULAR = tuple(TERMS), ("sin", "cos")
DECIMAL = re.compile(r"[0-9_.]+([eE][+-]?[0-9]{1,3})?")
WRITTEN = re.compile(r"[A-Za-z0-9_.+*/(), -]*")  # one line, without comments, texts and comparisons
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")

SignOf: TypeAlias = Callable[[Polynomial], int]  # the sign of a switching expression on a cell: -1 or 1
WaveAt: TypeAlias = Callable[[str, Polynomial, int], Polynomial]  # a wave of a polynomial, with e at an end


def series(name: str, v: Polynomial, e: int, order: int = 0) -> Polynomial:
    """A wave of a polynomial with ``e`` at 0 or 1, which weighs the last term."""
    numbers = coefficients(name, TERMS[name] + order)
    power = v if name in ("sin", "tanh", "atan") else constant(v.count, 1)
    step, total = v if name == "exp" else v * v, constant(v.count, 0)
    for number in numbers[:-1]:
        total += power.times(number)
        power *= step
    return total + power.times(numbers[-1] * e)


def coefficients(name: str, count: int) -> list[Fraction]:
    """Of the powers that occur in a series; those of tanh by ``tanh' = 1 - tanh^2``."""
    if name == "tanh":
        numbers = [Fraction(1)]
        for k in range(1, count):
            numbers.append(-sum((numbers[i] * numbers[k - 1 - i] for i in range(k)), Fraction(0)) / (2 * k + 1))
        return numbers
    if name == "atan":
        return [Fraction((-1) ** k, 2 * k + 1) for k in range(count)]
    if name == "exp":
        return [Fraction(1, factorial(k)) for k in range(count)]
    return [Fraction((-1) ** k, factorial(2 * k + (name == "sin"))) for k in range(count)]


def sign_as_written(node: ast.expr) -> int:
    """1 where a formula is seen to have no negative value, -1 where it has no positive one; 0 where that is not seen.

    It is a sum, product or quotient of even powers, absolute values and numbers.
    """
    match node:
        case ast.Constant() | ast.Call(func=ast.Name(id="Abs")):
            return 1
        case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(exponent))) if exponent % 2 == 0:
            return 1
        case ast.UnaryOp(op=ast.USub()):
            return -sign_as_written(node.operand)
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            right = sign_as_written(node.right) * (1 if isinstance(node.op, ast.Add) else -1)
            return right if right == sign_as_written(node.left) else 0
        case ast.BinOp(op=ast.Mult() | ast.Div()):
            return sign_as_written(node.left) * sign_as_written(node.right)
    return 0


class Formula:
    """A formula in the states.

    Args:
        data: a text such as ``-sign(x) + y/4``.
        states: the polynomial that stands for each name.
        ends: which end of what they may be the waves are at, 0 or 1; none where a formula may hold no waves; None where
            they have no ends.
        wave: a wave of a polynomial at an end.

    Raises:
        RejectedError: for a text that is too long, or holds other characters than formulas do.
        SyntaxError: for one that is no formula.
    """

    def __init__(
        self, data: Any, states: Mapping[str, Polynomial], ends: Sequence[int] | None = (), wave: WaveAt = series
    ) -> None:
        self.text, self.states, self.wave = text(data).strip(), states, wave
        self.count = next(iter(states.values())).count
        self.tree = parsed(self.text)
        waves = waves_in(self.tree)
        wave_ends = [0] * len(waves) if ends is None else ends
        require(len(waves) == len(wave_ends), "sines and cosines in right-hand sides alone")
        self.ends = dict(zip(waves, wave_ends, strict=True))
        self.smooth = parts_without_calls(self.tree)
        self._known: dict[ast.expr, Polynomial] = {}

    def on(self, sign_of: SignOf) -> Polynomial:
        """The polynomial on a cell.

        Raises:
            RejectedError: for anything that is not in the grammar, and from ``sign_of``.
        """
        return self._value(self.tree, sign_of, MAX_DEPTH)

    def arguments(self) -> list[tuple[str, Polynomial]]:
        """The sines and cosines, with the polynomials that they are of."""
        return [(ast.unparse(node.func), self._value(node.args[0], no_sign, MAX_DEPTH)) for node in self.ends]

    def _value(self, node: ast.expr, sign_of: SignOf, depth: int) -> Polynomial:
        """The polynomial of a part; of one without calls it is kept, as all cells ask for it."""
        if node in self._known:
            return self._known[node]
        polynomial = self._built(node, sign_of, depth)
        if node in self.smooth:
            self._known[node] = polynomial
        return polynomial

    def _built(self, node: ast.expr, sign_of: SignOf, depth: int) -> Polynomial:
        require(depth > 0, f"formulas of at most {MAX_DEPTH} nested operations")
        BUDGET.spend(1)
        match node:
            case ast.Constant():
                return constant(self.count, self._number(node))
            case ast.Name():
                require(node.id in self.states, "formulas in the states")
                return self.states[node.id]
            case ast.UnaryOp(op=ast.UAdd()):
                return self._value(node.operand, sign_of, depth - 1)
            case ast.UnaryOp(op=ast.USub()):
                return -self._value(node.operand, sign_of, depth - 1)
            case ast.BinOp():
                return self._operation(node, sign_of, depth - 1)
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in WAVES:
                require(not waves_in(argument), "no sine or cosine inside another")
                known = name != "exp" or sign_as_written(argument) < 0
                require(known, "exp of minus a sum of even powers")
                return self.wave(name, self._value(argument, sign_of, depth - 1), self.ends[node])
            case ast.Call(func=ast.Name(), keywords=[]):
                without_waves = self.smooth.issuperset(node.args) or not waves_in(*node.args)
                require(without_waves, "no sine or cosine inside a switching function")
                values = [self._value(argument, sign_of, depth - 1) for argument in node.args]
                return switched(node.func.id, values, sign_of)  # type: ignore[attr-defined]
        raise RejectedError("formulas of sums, products, powers and switching functions")

    def _number(self, node: ast.Constant) -> Fraction:
        digits = self.text[node.col_offset : node.end_col_offset]
        BUDGET.spend(1 + len(digits) ** 2 // 4096)
        require(DECIMAL.fullmatch(digits) and len(digits) <= MAX_DIGITS, "numbers as decimals")
        return Fraction(digits)

    def _operation(self, node: ast.BinOp, sign_of: SignOf, depth: int) -> Polynomial:
        left = self._value(node.left, sign_of, depth)
        if isinstance(node.op, ast.Pow):
            exponent = node.right
            written = self.text[exponent.col_offset : exponent.end_col_offset]
            require(re.fullmatch("[0-9]{1,2}", written), "whole exponents")
            require(not waves_in(node.left), "no powers of sines and cosines")
            return left.power(int(written))
        right = self._value(node.right, sign_of, depth)
        match node.op:
            case ast.Add():
                return left + right
            case ast.Sub():
                return left - right
            case ast.Mult():
                return left * right
        require(isinstance(node.op, ast.Div) and right and right.degree == 0, "division by numbers that are not zero")
        return left.times(1 / right.at_origin)


def no_sign(value: Polynomial) -> int:
    """What a sine or cosine is of may ask for no sign."""
    raise RejectedError("sines and cosines of polynomials")


def parsed(data: Any) -> ast.expr:
    """The tree of a formula.

    Raises:
        RejectedError: for a text that is too long, or holds other characters than formulas do.
        SyntaxError: for one that is no formula.
    """
    formula = text(data).strip()
    BUDGET.spend(1 + len(formula))
    require(WRITTEN.fullmatch(formula), "formulas of names, decimals, brackets, commas and + - * /")
    return exact_tree(formula)


@lru_cache  # claims ask for the same few formulas again and again
def exact_tree(formula: str) -> ast.expr:
    """The tree of a text of Python's grammar, with its decimals as they are written."""
    tree, written = ast.parse(formula, mode="eval").body, formula.encode()
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, float):
            node.value = Decimal(written[node.col_offset : node.end_col_offset].decode())
    return tree


class Decimal(float):
    """A decimal of which ``ast.unparse`` makes the text that stood in the formula: different ones remain different."""

    def __init__(self, written: str) -> None:
        self.written = written

    def __repr__(self) -> str:
        return self.written


@lru_cache
def parts_without_calls(tree: ast.expr, switching: Collection[str] = ()) -> set[ast.AST]:
    """The parts of a formula that hold no sine or cosine, and nothing that switches, as some names may do."""
    parts: set[ast.AST] = set()
    for node in reversed(list(ast.walk(tree))):  # what a part consists of comes before it
        switches = isinstance(node, ast.Call) or (isinstance(node, ast.Name) and node.id in switching)
        if not switches and parts.issuperset(ast.iter_child_nodes(node)):
            parts.add(node)
    return parts


@lru_cache
def waves_in(*nodes: ast.expr) -> list[ast.Call]:
    """The sines and cosines in parts of a formula."""
    calls = [part for node in nodes for part in ast.walk(node) if isinstance(part, ast.Call)]
    return [call for call in calls if isinstance(call.func, ast.Name) and call.func.id in WAVES]


def switched(name: str, values: list[Polynomial], sign_of: SignOf) -> Polynomial:
    """A switching function of polynomials, where the signs of what it switches by are known.

    Raises:
        RejectedError: for other functions, and for the wrong number of arguments.
    """
    if name in ("Max", "max", "Min", "min"):
        chosen, choose = values[0], larger if name in ("Max", "max") else smaller
        for value in values[1:]:
            chosen = choose(chosen, value, sign_of)
        return chosen
    if name == "sat":
        value, low, high = values
        return larger(low, smaller(high, value, sign_of), sign_of)
    require(name in ("sign", "sgn", "Abs", "relu"), "calls of sign, Abs, Max, Min, relu or sat")
    (value,) = values
    sign, zero = sign_of(value) if value else 0, constant(value.count, 0)
    if name == "Abs":
        return value if sign > 0 else -value
    if name == "relu":
        return value if sign > 0 else zero
    return constant(value.count, sign)


def larger(a: Polynomial, b: Polynomial, sign_of: SignOf) -> Polynomial:
    """The larger of two polynomials on a cell."""
    return a if not a - b or sign_of(a - b) > 0 else b


def smaller(a: Polynomial, b: Polynomial, sign_of: SignOf) -> Polynomial:
    """The smaller one."""
    return b if not a - b or sign_of(a - b) > 0 else a
