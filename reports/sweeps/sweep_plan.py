"""The scenes of a sweep, by number: every combination of the values of its axes, or random draws within ranges.

Nothing is listed: the values of scene k follow from k, so a plan of 10^12 scenes costs nothing until it is run.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from numbers import Integral
from typing import Any, TypeAlias

from nonsmooth.symbolic.files.key_paths import Path, find_path, path_text
from nonsmooth.symbolic.files.scene_values import read_exact
from nonsmooth.symbolic.formulas.expression import Expression
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.messages.scene_error import requirement, shown

# ---- values --------------------------------------------------------------------------------------
#
# The values that a number of a scene takes in a sweep, exact: ``0.05:1:40``, ``0:pi/2:10``, ``1/2,sqrt(2)/2,1``.
#
# Every text passes the formula parser of scene files; nothing is evaluated otherwise.


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
    try:
        value = Value(*found.parts_in_pi(), unit) if isinstance(found, Expression) else Value(found, unit=unit)
    except ExpressionError:
        return WrittenValue(text)
    try:
        _ = value.number
    except OverflowError:
        raise SweepError(f"{keyword}: required numbers within the range of floats, received {shown(text)}") from None
    return value


# ---- the plan ------------------------------------------------------------------------------------

DRAW_BITS = 20  # of a random share of a range: short fractions keep exact arithmetic fast
LARGE = 10**6  # scenes beyond which a sweep asks first
MAX_DRAWS = 10**12

Point: TypeAlias = tuple[Value | WrittenValue, ...]  # one value for each axis


@dataclass(frozen=True)
class Axis:
    """One number of the scene, and its values.

    Attributes:
        name: ``friction.mu_side``.
        path: where it stands in the document.
        values: a range or a list.
    """

    name: str
    path: Path
    values: Values


@dataclass(frozen=True)
class SweepPlan:
    """The scenes of a sweep.

    Attributes:
        axes: the numbers that vary; the last one varies fastest.
        draws: how many random scenes; None for every combination.
        seed: of the draws.
    """

    axes: tuple[Axis, ...]
    draws: int | None = None
    seed: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """The key paths."""
        return tuple(axis.name for axis in self.axes)

    @property
    def counts(self) -> tuple[int, ...]:
        """How many values each axis has, in a grid."""
        return tuple(axis.values.count or 0 for axis in self.axes)

    @property
    def size(self) -> int:
        """How many scenes."""
        return math.prod(self.counts) if self.draws is None else self.draws

    def point(self, k: int) -> Point:
        """The values of scene k, counted from 0."""
        return self._drawn(k) if self.draws is not None else self.at(self.places(k))

    def places(self, k: int) -> tuple[int, ...]:
        """Where scene k stands in the grid, along each axis."""
        found = []
        for count in reversed(self.counts):
            k, place = divmod(k, count)
            found.append(place)
        return tuple(reversed(found))

    def index(self, places: Sequence[int]) -> int:
        """The number of the scene at a place of the grid."""
        k = 0
        for count, place in zip(self.counts, places, strict=True):
            k = k * count + place
        return k

    def at(self, places: Sequence[int]) -> Point:
        """The values at a place of the grid."""
        return tuple(axis.values.value(place) for axis, place in zip(self.axes, places, strict=True))

    def _drawn(self, k: int) -> Point:
        """Draw k, which depends on the seed and on k alone: a longer sweep begins with the same scenes."""
        source = random.Random(f"{self.seed}:{k}")
        return tuple(_draw(axis.values, source) for axis in self.axes)


def _draw(values: Values, source: random.Random) -> Value | WrittenValue:
    """One of a list, or a rational number of a range."""
    if isinstance(values, Listed):
        return values.values[source.randrange(values.count)]
    return values.start.between(values.stop, Fraction(source.randrange((1 << DRAW_BITS) + 1), 1 << DRAW_BITS))


def read_plan(
    vary: Mapping[str, str], document: Mapping[str, Any], file: str, draws: int | None = None, seed: int = 0
) -> SweepPlan:
    """The plan of what a user wrote.

    Args:
        vary: values by key path, such as ``{"mu_side": "0.05:1:40"}``.
        document: the tables of the scene.
        file: the scene, for messages.
        draws: how many random scenes; None for every combination.
        seed: of the draws.

    Raises:
        SceneError: for a path that names no number of the scene.
        SweepError: for values that cannot be used.
    """
    if not vary:
        raise SweepError("vary: required a number to vary, such as mu_side=0.05:1:40, received none")
    axes = tuple(_axes(vary, document, file))
    names = [axis.name for axis in axes]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise SweepError(f"vary: required each number once, received {twice} twice")
    if draws is not None and not (isinstance(draws, Integral) and 1 <= draws <= MAX_DRAWS):
        raise SweepError(f"random: required 1 to {MAX_DRAWS} draws, received {shown(draws)}")
    for axis in axes:
        if isinstance(axis.values, Range) and (axis.values.count is None) is (draws is None):
            kinds = ("start:stop:count, or random draws", "start:stop")
            required, received = kinds if draws is None else ("start:stop for random draws", "start:stop:count")
            raise SweepError(f"vary {axis.name}: required {required}, received {received}")
    return SweepPlan(axes, draws, seed)


def _axes(vary: Mapping[str, str], document: Mapping[str, Any], file: str) -> Iterator[Axis]:
    for name, text in vary.items():
        path = find_path(name, document, file)
        yield Axis(path_text(path, document), path, read_values(text, f"vary {name}"))
