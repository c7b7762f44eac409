"""The values that a number of a scene takes in a sweep, exact: ``0.05:1:40``, ``0:pi/2:10``, ``1/2,sqrt(2)/2,1``.

Every text passes the formula parser of scene files; nothing is evaluated otherwise.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from nonsmooth.symbolic.files.scene_values import read_exact
from nonsmooth.symbolic.formulas.expression import Expression, ExpressionError
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.messages.scene_error import requirement, shown


class SweepError(ValueError):
    """``keyword: required ..., received ...``; the command line puts two dashes before it."""


MAX_COUNT = 10**9  # of the values of one range: each has an index, none is kept
MAX_LISTED = 10_000  # values of a list
_UNIT = re.compile(rf"(.*\S)\s*({'|'.join(AngleUnit)})", re.DOTALL)

Entry: TypeAlias = int | str  # a value as a scene file would hold it


@dataclass(frozen=True)
class Value:
    """The rational number ``constant + multiple pi``, with the unit of an angle where one is stated."""

    constant: Fraction
    multiple: Fraction = Fraction(0)
    unit: str = ""

    @property
    def entry(self) -> Entry:
        """The value as a scene file would hold it."""
        if self.multiple:
            constant = f"{self.constant} + " if self.constant else ""
            text = f"{constant}{self.multiple}*pi"
        elif self.constant.denominator == 1 and not self.unit:
            return int(self.constant)
        else:
            text = str(self.constant)
        return f"{text} {self.unit}".rstrip()

    @property
    def number(self) -> float:
        """Where it stands on an axis: multiples of pi as floats."""
        from math import pi

        return float(self.constant) + float(self.multiple) * pi

    def between(self, other: Value, share: Fraction) -> Value:
        """``self + share (other - self)``, exact."""
        constant = self.constant + share * (other.constant - self.constant)
        return Value(constant, self.multiple + share * (other.multiple - self.multiple), self.unit)


@dataclass(frozen=True)
class WrittenValue:
    """A value that is no rational number, as it was written."""

    entry: Entry

    @property
    def number(self) -> None:
        """It has no place on an axis."""
        return


@dataclass(frozen=True)
class Range:
    """``count`` values from ``start`` to ``stop``, both included; without a count every value between."""

    start: Value
    stop: Value
    count: int | None

    def value(self, k: int) -> Value:
        """The k-th value, counted from 0."""
        if self.count is None:
            raise IndexError("a range without a count has no k-th value")
        return self.start.between(self.stop, Fraction(k, self.count - 1))


@dataclass(frozen=True)
class Listed:
    """Values one by one."""

    values: tuple[Value | WrittenValue, ...]

    @property
    def count(self) -> int:
        """How many."""
        return len(self.values)

    def value(self, k: int) -> Value | WrittenValue:
        """The k-th value, counted from 0."""
        return self.values[k]


Values: TypeAlias = Range | Listed


def read_values(text: str, keyword: str) -> Values:
    """A range ``start:stop:count`` or ``start:stop``, or a list ``a,b,c``.

    Args:
        text: what the user wrote.
        keyword: names it in errors.

    Raises:
        SweepError: for anything else, empty ranges, and counts below 2.
    """
    if ":" in text:
        return _range(text.split(":"), text, keyword)
    entries = [part.strip() for part in text.split(",")]
    if len(entries) > MAX_LISTED:
        raise SweepError(f"{keyword}: required at most {MAX_LISTED} values, received {len(entries)}")
    return Listed(tuple(_listed(entry, keyword) for entry in entries))


def _range(parts: list[str], text: str, keyword: str) -> Range:
    if len(parts) not in (2, 3):
        raise SweepError(f"{keyword}: required start:stop:count, received {shown(text)}")
    start, stop = (_rational(part.strip(), keyword) for part in parts[:2])
    if start.unit != stop.unit:
        raise SweepError(f"{keyword}: required two ends in one unit, received {shown(text)}")
    if start.number >= stop.number:
        raise SweepError(f"{keyword}: required start < stop, received {shown(text)}")
    return Range(start, stop, None if len(parts) == 2 else _count(parts[2].strip(), keyword))


def _count(text: str, keyword: str) -> int:
    # Ten digits are more than the largest count, and int() is given no longer text.
    if not re.fullmatch(r"[0-9]{1,10}", text) or not 2 <= int(text) <= MAX_COUNT:
        raise SweepError(f"{keyword}: required a count of 2 to {MAX_COUNT} values, received {shown(text)}")
    return int(text)


def _rational(text: str, keyword: str) -> Value:
    """An end of a range."""
    value = _listed(text, keyword)
    if isinstance(value, WrittenValue):
        raise SweepError(f"{keyword}: required rational ends, or multiples of pi, received {shown(text)}")
    return value


def _listed(text: str, keyword: str) -> Value | WrittenValue:
    """One value; a formula is kept as it was written."""
    named = _UNIT.fullmatch(text)
    number, unit = (named[1], named[2]) if named else (text, "")
    try:
        found = read_exact(number)
    except ExpressionError as error:
        raise SweepError(f"{keyword}: required {requirement(error)}, received {shown(text)}") from None
    if isinstance(found, Expression):
        try:
            return Value(*found.parts_in_pi(), unit)
        except ExpressionError:
            return WrittenValue(text)
    return Value(found, unit=unit)
