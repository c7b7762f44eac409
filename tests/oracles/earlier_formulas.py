"""What the checkers of version 1 for plain systems share: bounded work, and formulas, read but never evaluated.

They compute with polynomials of their own.
"""

from __future__ import annotations

import ast
import re
import warnings
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

MAX_TEXT, MAX_DEPTH, MAX_DEGREE = 4_000, 60, 16
MAX_DIGITS = 400  # of a number, and the largest power of ten in one
WORD, LONG = 32, 4096  # bits of a word; words times words that cost as much as all else about a product

RATIONAL = re.compile(rf"-?[0-9]{{1,{MAX_DIGITS}}}(/[0-9]{{1,{MAX_DIGITS}}})?")
DECIMAL = re.compile(r"[0-9_.]+(?:[eE]([+-]?[0-9]{1,3}))?")
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")


class RejectedError(ValueError):
    """A claim that does not hold or is not shown."""


# What data of another form than a certificate's raise while they are read.
MALFORMED = (
    *(KeyError, TypeError, ValueError, IndexError, AttributeError, ArithmeticError),
    *(RecursionError, MemoryError, SyntaxError),
)


def require(holds: object, claim: str) -> None:
    """Reject the certificate unless something holds."""
    if not holds:
        raise RejectedError(claim)


class Budget:
    """Work that may still be done.

    Sums and products of rational numbers reduce fractions, in a time that grows with the square of their length; so a
    product of numbers of n words counts as ``1 + n^2/LONG`` products.  Work is counted, not time: a certificate that
    is accepted on one machine is accepted on all.
    """

    def __init__(self) -> None:
        self.left = 0  # set where a check begins

    def spend(self, work: int) -> None:
        """Take from it.

        Raises:
            RejectedError: where nothing is left.
        """
        self.left -= work
        require(self.left > 0, "a proof within the limits of this checker")

    def spend_on(self, count: int, numbers: Iterable[Fraction], factors: int = 1) -> None:
        """Pay for operations on numbers before they are done.

        Args:
            count: of the operations.
            numbers: that enter them.
            factors: how many such numbers are multiplied with each other in one operation.
        """
        words = max(map(words_of, numbers), default=0) * factors
        self.spend(1 + count * (1 + words * words // LONG))


def words_of(value: Fraction) -> int:
    """The length of a rational number in words."""
    return (value.numerator.bit_length() + value.denominator.bit_length()) // WORD


BUDGET = Budget()


def add_to(total: dict[Any, Fraction], key: Any, value: Fraction) -> None:
    """Add a value to an entry; the denominators of a long sum may grow with every term, which is paid for."""
    before = total.get(key)
    if before is None:
        total[key] = value
        return
    words = words_of(before) + words_of(value)
    if words > WORD:
        BUDGET.spend(words * words // LONG)
    total[key] = before + value


# ---- formulas ----------------------------------------------------------------------------------


SignOf: TypeAlias = Callable[[Any], int]


def rational(text: Any) -> Fraction:
    """A number of the certificate."""
    BUDGET.spend(1)
    require(type(text) is str and RATIONAL.fullmatch(text), "rational numbers as texts such as '-3/4'")
    return Fraction(text)


class Formula:
    """A formula in the states, read by Python's grammar and never evaluated by Python.

    Args:
        text: such as ``-sign(x) + y/4``.
        states: the polynomial for each name.
    """

    def __init__(self, text: Any, states: dict[str, Any]) -> None:
        require(type(text) is str and len(text) <= MAX_TEXT, f"formulas as texts of at most {MAX_TEXT} characters")
        self.text, self.states = " ".join(text.split()).encode(), states
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python's advice on "1if 2else 3" and the like, refused below
            self.tree = ast.parse(self.text, mode="eval").body

    def constant(self, value: Fraction | int) -> Any:
        """A number as a polynomial of the checker's own."""
        raise NotImplementedError

    def on(self, sign_of: SignOf) -> Any:
        """The polynomial on a cell, given the signs of switching expressions there."""
        return self._value(self.tree, sign_of, MAX_DEPTH)

    def _value(self, node: ast.expr, sign_of: SignOf, depth: int) -> Any:
        require(depth > 0, f"formulas of at most {MAX_DEPTH} nested operations")
        BUDGET.spend(1)
        if isinstance(node, ast.Constant):
            return self.constant(self._number(node))
        if isinstance(node, ast.Name):
            return self._state(node.id, sign_of)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
            value = self._value(node.operand, sign_of, depth - 1)
            return -value if isinstance(node.op, ast.USub) else value
        if isinstance(node, ast.BinOp):
            return self._operation(node, sign_of, depth - 1)
        require(isinstance(node, ast.Call), "formulas of sums, products, powers and switching functions")
        return self._call(node, sign_of, depth - 1)  # type: ignore[arg-type]

    def _state(self, name: str, sign_of: SignOf) -> Any:
        require(name in self.states, "formulas in the states")
        return self.states[name]

    def _square_root(self, arguments: Sequence[ast.expr], sign_of: SignOf) -> Any:
        raise RejectedError("rational numbers")

    def _number(self, node: ast.Constant) -> Fraction:
        text = self.text[node.col_offset : node.end_col_offset].decode()
        found = DECIMAL.fullmatch(text) if len(text) <= MAX_DIGITS else None
        require(found, f"numbers as decimals of at most {MAX_DIGITS} characters")
        power = int(found[1] or 0)  # type: ignore[index]
        require(abs(power) <= MAX_DIGITS, f"powers of ten from -{MAX_DIGITS} to {MAX_DIGITS}")
        return Fraction(text)

    def _operation(self, node: ast.BinOp, sign_of: SignOf, depth: int) -> Any:
        left = self._value(node.left, sign_of, depth)
        if isinstance(node.op, ast.Pow):
            exponent = node.right
            require(isinstance(exponent, ast.Constant) and type(exponent.value) is int, "whole exponents")
            return self._power(left, exponent.value)  # type: ignore[attr-defined]
        right = self._value(node.right, sign_of, depth)
        if isinstance(node.op, ast.Add):
            return left + right
        if isinstance(node.op, ast.Sub):
            return left - right
        if isinstance(node.op, ast.Mult):
            return left * right
        require(isinstance(node.op, ast.Div) and right and right.degree == 0, "division by numbers that are not zero")
        (divisor,) = right.terms.values()
        return left * self.constant(1 / divisor)

    def _power(self, base: Any, exponent: int) -> Any:
        require(0 <= exponent <= MAX_DEGREE, f"exponents from 0 to {MAX_DEGREE}")
        value = self.constant(1)
        for _ in range(exponent):
            value *= base
        return value

    def _call(self, node: ast.Call, sign_of: SignOf, depth: int) -> Any:
        require(isinstance(node.func, ast.Name) and not node.keywords, "calls of sign, Abs, Max, Min, relu or sat")
        require(node.func.id not in ("sin", "cos"), "rational numbers")  # type: ignore[attr-defined]
        if node.func.id == "sqrt":  # type: ignore[attr-defined]
            return self._square_root(node.args, sign_of)
        name, values = node.func.id, [self._value(arg, sign_of, depth) for arg in node.args]  # type: ignore[attr-defined]
        if name in ("sign", "sgn", "Abs", "relu"):
            require(len(values) == 1, f"one argument of {name}")
            (value,) = values
            own = sign_of(value) if value else 0
            zero = self.constant(0)
            size = value if own > 0 else -value if own else zero
            return {"Abs": size, "relu": value if own > 0 else zero}.get(name, self.constant(own))
        if name == "sat":
            require(len(values) == 3, "three arguments of sat")
            value, low, high = values
            return _larger(low, _smaller(high, value, sign_of), sign_of)
        require(name in ("Max", "max", "Min", "min") and values, "calls of sign, Abs, Max, Min, relu or sat")
        chosen, choose = values[0], _larger if name in ("Max", "max") else _smaller
        for value in values[1:]:
            chosen = choose(chosen, value, sign_of)
        return chosen


def _larger(a: Any, b: Any, sign_of: SignOf) -> Any:
    return a if not a - b or sign_of(a - b) > 0 else b


def _smaller(a: Any, b: Any, sign_of: SignOf) -> Any:
    return b if not a - b or sign_of(a - b) > 0 else a
