"""Formulas of scene files, written from the graphs and matrices of other libraries.

What a library hands over is walked node by node and written as a text that :mod:`nonsmooth.symbolic.piecewise` reads;
nothing of it is evaluated.  Integers and fractions stay exact.  A float is the rational number that it is: the double
0.1 is 3602879701896397/36028797018963968.  Who means decimals says so (``decimals=True``): then it is one tenth.

A condition ``g > 0`` is the factor ``relu(sgn(g))``: 1 where it holds, 0 where it does not.  The factor
``(1 + sgn(g))/2`` would be one half wherever g is zero, and a g with absolute values may be zero on whole cells.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from numbers import Integral, Rational, Real
from typing import Any

from nonsmooth.symbolic.piecewise import MAX_TEXT
from nonsmooth.symbolic.scene_error import SceneError, StatedFact

ZERO, ONE, MINUS_ONE = "0", "1", "(-1)"


@dataclass(frozen=True)
class Reading:
    """How what one door receives is read.

    Attributes:
        source: what messages call it, such as ``System.from_sympy``.
        decimals: whether a float means its shortest decimal; otherwise it is the rational number that it is.
    """

    source: str
    decimals: bool = False

    def refused(self, key: str, expected: str, received: object) -> SceneError:
        """The error that says in one line what cannot be used; the received is stated in our words."""
        return SceneError(self.source, key, expected, StatedFact(str(received)))

    def number(self, value: Any, key: str) -> str:
        """The text of an exact number.

        Args:
            value: an integer, a Fraction, a Decimal, a float of Python or NumPy, or a formula as text.
            key: its place, for messages.

        Raises:
            SceneError: for anything else, for infinities and NaN.
        """
        match value:
            case bool():
                raise self.refused(key, "a number", value)
            case str():
                return in_parentheses(value.strip())
            case Integral():
                return fraction_text(Fraction(int(value)))
            case Decimal() if value.is_finite():
                return fraction_text(Fraction(value))
            case Rational():
                return fraction_text(Fraction(int(value.numerator), int(value.denominator)))
            case Real():
                return self._float(value, key)
        raise self.refused(key, "a finite number", value)

    def _float(self, value: Any, key: str) -> str:
        try:
            exact = Fraction(*value.as_integer_ratio())
        except (OverflowError, ValueError):  # infinities, and NaN
            raise self.refused(key, "a finite number", value) from None
        return fraction_text(Fraction(Decimal(str(value))) if self.decimals else exact)

    def require_short(self, text: str, key: str) -> str:
        """The text, unless it is longer than a formula may be.

        Raises:
            SceneError: for a longer one.
        """
        if len(text) > MAX_TEXT:
            expected = f"formulas of at most {MAX_TEXT} characters, shared parts written out"
            raise self.refused(key, expected, f"{len(text)}")
        return text


def fraction_text(value: Fraction) -> str:
    """A rational number as a factor: in parentheses where it is a quotient or negative."""
    return str(value) if value >= 0 and value.denominator == 1 else f"({value})"


def in_parentheses(text: str) -> str:
    """A formula as a factor."""
    return text if text.isalnum() else f"({text})"


def sum_text(terms: Sequence[str]) -> str:
    """A sum as a factor, without terms that are zero; nested like a balanced tree, since depth is limited."""
    return _balanced([term for term in terms if term != ZERO], " + ", ZERO)


def product_text(factors: Sequence[str]) -> str:
    """A product as a factor: zero where one factor is, without factors that are one."""
    if ZERO in factors:
        return ZERO
    others = [factor for factor in factors if factor not in (ONE, MINUS_ONE)]
    found = _balanced(others, "*", ONE)
    return f"(-{found})" if factors.count(MINUS_ONE) % 2 else found


def difference_text(left: str, right: str) -> str:
    """``left - right`` as a factor."""
    return left if right == ZERO else f"({left} - {right})"


def indicator(guard: str, *, strict: bool = True) -> str:
    """1 where a formula is positive (or where it is not negative), else 0, as a factor."""
    return f"relu(sgn({guard}))" if strict else complement(indicator(f"-{in_parentheses(guard)}"))


def complement(truth: str) -> str:
    """1 where a factor of truth is 0, and 0 where it is 1."""
    return {ZERO: ONE, ONE: ZERO}.get(truth, f"(1 - {truth})")


def disjunction(truths: Sequence[str]) -> str:
    """1 where one of some factors of truth is 1."""
    return complement(product_text([complement(truth) for truth in truths]))


def first_that_holds(choices: Sequence[tuple[str, str]], otherwise: str) -> str:
    """The formula of the first choice whose factor of truth is 1, and another formula where none is.

    ``1_1 f_1 + (1 - 1_1) (1_2 f_2 + (1 - 1_2) (...))``.
    """
    formula = otherwise
    for truth, chosen in reversed(choices):
        if chosen != formula:
            kept = product_text([complement(truth), formula])
            formula = sum_text([product_text([truth, chosen]), kept])
    return formula


def _balanced(parts: Sequence[str], joint: str, empty: str) -> str:
    if len(parts) <= 1:
        return parts[0] if parts else empty
    middle = len(parts) // 2
    return f"({_balanced(parts[:middle], joint, empty)}{joint}{_balanced(parts[middle:], joint, empty)})"


def without_parentheses(text: str) -> str:
    """The formula without parentheses that say nothing; as it is where it holds decimals, which stay as written."""
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return text  # for the parser of formulas to refuse
    decimals = any(isinstance(node, ast.Constant) and not isinstance(node.value, int) for node in ast.walk(tree))
    return text if decimals else ast.unparse(tree)


FUNCTIONS: dict[str, Callable[..., str]] = {
    "sqrt": "sqrt({})".format,
    "sin": "sin({})".format,
    "cos": "cos({})".format,
    "Abs": "Abs({})".format,
    "sign": "sgn({})".format,
    "Heaviside": "((1 + sgn({}))/2)".format,
}  # of one argument, as formulas write them
