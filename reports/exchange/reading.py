"""How the objects of other libraries are read: their numbers, exactly, and what is refused in one line.

What a library hands over is walked node by node and written as a text (:mod:`nonsmooth.symbolic.formulas.formula_text`)
that :mod:`nonsmooth.symbolic.formulas.piecewise` reads; nothing of it is evaluated.  Integers and fractions stay exact.
A float is the rational number that it is: the double 0.1 is 3602879701896397/36028797018963968.  Who means decimals
says so (``decimals=True``): then it is one tenth.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from importlib import import_module
from numbers import Integral, Rational, Real
from typing import Any

from nonsmooth.symbolic.formulas.formula_text import in_parentheses
from nonsmooth.symbolic.formulas.trees import MAX_TEXT, ExpressionError, formula_tree, tidied, written
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact


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

    @contextmanager
    def misfits_refused(self, expected: str) -> Iterator[None]:
        """Objects that lack what is asked of them end in one line; the error of Python is its cause.

        Raises:
            SceneError: in place of it.
        """
        try:
            yield
        except SceneError:
            raise
        except (AttributeError, LookupError, TypeError, ValueError) as error:
            raise self.refused("", expected, f"what Python refuses: {error!r}") from error

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

    def library(self, name: str) -> Any:
        """A library that is not required.

        Raises:
            SceneError: where it is not installed.
        """
        try:
            return import_module(name)
        except ImportError:
            raise self.refused("", f"the package {name} (extra nonsmooth[{name}])", "a Python without it") from None

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


def tidy_formula(text: str) -> str:
    """The formula without what says nothing; what is none stays, for the parser of formulas to refuse."""
    with suppress(ExpressionError):
        return written(tidied(formula_tree(text)))
    return text
