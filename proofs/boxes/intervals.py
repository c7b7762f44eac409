"""Arrays of intervals of doubles that are rounded outward: balls in bulk.

Sums, products, quotients and square roots of doubles are those of IEEE 754, correct to half a unit in the last place;
ends are moved outward by more than that.  A comparison with an interval that is not a number is false.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask

UNITS = 2.0**-51  # of a double: two to four units in its last place
TINY = 2.0**-1000  # more than the rounding of numbers near zero


@dataclass(frozen=True)
class Intervals:
    """Closed intervals, arrays of one shape; shapes broadcast as those of arrays.

    Attributes:
        low: lower ends.
        high: upper ends.
    """

    low: Floats
    high: Floats

    @classmethod
    def of(cls, values: Floats | float) -> Intervals:
        """Doubles as they are."""
        array = np.asarray(values, dtype=float)
        return cls(array, array)

    @classmethod
    def about(cls, balls: Sequence[Any]) -> Intervals:
        """Balls, in lists of any depth."""
        array = np.array(balls, dtype=object)
        low = np.array([float(ball.lower()) for ball in array.flat]).reshape(array.shape)
        high = np.array([float(ball.upper()) for ball in array.flat]).reshape(array.shape)
        return _outward(low, high)

    @classmethod
    def joined(cls, several: Sequence[Intervals]) -> Intervals:
        """One after the other, along the only axis."""
        return cls(np.concatenate([each.low for each in several]), np.concatenate([each.high for each in several]))

    @classmethod
    def stacked(cls, several: Sequence[Intervals]) -> Intervals:
        """Side by side, along a new last axis."""
        return cls(
            np.stack([each.low for each in several], axis=-1), np.stack([each.high for each in several], axis=-1)
        )

    def __getitem__(self, key: Any) -> Intervals:
        return Intervals(self.low[key], self.high[key])

    def __add__(self, other: Intervals) -> Intervals:
        return _outward(self.low + other.low, self.high + other.high)

    def __sub__(self, other: Intervals) -> Intervals:
        return _outward(self.low - other.high, self.high - other.low)

    def __radd__(self, number: float) -> Intervals:
        return Intervals.of(number) + self

    def __rsub__(self, number: float) -> Intervals:
        return Intervals.of(number) - self

    def __neg__(self) -> Intervals:
        return Intervals(-self.high, -self.low)

    def __mul__(self, other: Intervals) -> Intervals:
        if other.low is other.high:  # doubles as they are
            first, last = self.low * other.low, self.high * other.low
            return _outward(np.minimum(first, last), np.maximum(first, last))
        if self.low is self.high:
            return other * self
        low = np.asarray(self.low * other.low)
        high = low.copy()
        for product in (self.low * other.high, self.high * other.low, self.high * other.high):
            np.minimum(low, product, out=low)
            np.maximum(high, product, out=high)
        return _outward(low, high)

    def __rmul__(self, number: float) -> Intervals:
        return Intervals.of(number) * self

    def __pow__(self, exponent: int) -> Intervals:
        """The product of so many of them, at least one."""
        return self if exponent == 1 else self ** (exponent - 1) * self

    def __truediv__(self, other: Intervals) -> Intervals:
        """All numbers where the divisor may be zero."""
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = _outward(1 / other.high, 1 / other.low)
            product = self * inverse
        low, high = (
            np.where(other.holds_zero, end, ends) for end, ends in ((-np.inf, product.low), (np.inf, product.high))
        )
        return Intervals(low, high)

    def sum(self, axis: int) -> Intervals:
        """Along an axis; n doubles, added in whatever order, err by at most n half units of their sizes."""
        unit = self.low.shape[axis] * UNITS
        below, above = (np.abs(ends).sum(axis) * unit + TINY for ends in (self.low, self.high))
        return Intervals(self.low.sum(axis) - below, self.high.sum(axis) + above)

    @property
    def widened(self) -> Intervals:
        """With the next doubles beyond its ends."""
        return _outward(self.low, self.high)

    @cached_property
    def middle(self) -> Floats:
        """About the middle, in floats."""
        return (self.low + self.high) / 2

    @cached_property
    def reach(self) -> Floats:
        """About half of the width, in floats."""
        return (self.high - self.low) / 2

    @property
    def holds_zero(self) -> Mask:
        """Whether zero may be inside; so it is where an end is not a number."""
        return ~((self.low > 0) | (self.high < 0))

    @property
    def square(self) -> Intervals:
        """The squares of all numbers inside."""
        size = abs(self)
        squares = _outward(size.low * size.low, size.high * size.high)
        return Intervals(np.maximum(squares.low, 0.0), squares.high)

    def sqrt(self) -> Intervals:
        """The square roots of all numbers inside that are not negative."""
        roots = _outward(np.sqrt(np.maximum(self.low, 0.0)), np.sqrt(np.maximum(self.high, 0.0)))
        return Intervals(np.maximum(roots.low, 0.0), roots.high)

    def __abs__(self) -> Intervals:
        low = np.where(self.holds_zero, 0.0, np.minimum(np.abs(self.low), np.abs(self.high)))
        return Intervals(low, np.maximum(np.abs(self.low), np.abs(self.high)))

    def sign(self) -> Intervals:
        """Between the signs of both ends."""
        return Intervals(np.sign(self.low), np.sign(self.high))

    @property
    def is_one(self) -> Mask:
        """Whether these are exactly one."""
        return np.asarray((self.low == 1) & (self.high == 1))

    def below_zero(self, where: Mask) -> Intervals:
        """Minus one in some places, to choose there by :meth:`by_sign`."""
        return Intervals(np.where(where, -1.0, self.low), np.where(where, -1.0, self.high))

    def by_sign(self, positive: Intervals, negative: Intervals) -> Intervals:
        """One where these are positive, another where negative, and the hull of both where that is not told."""
        above, below = self.low > 0, self.high < 0
        low = np.where(above, positive.low, np.where(below, negative.low, np.minimum(positive.low, negative.low)))
        high = np.where(above, positive.high, np.where(below, negative.high, np.maximum(positive.high, negative.high)))
        return Intervals(low, high)

    def within(self, most: Intervals) -> Intervals:
        """``max(-most, min(x, most))`` for x inside and a bound inside ``most``, which is not negative."""
        low = np.maximum(np.minimum(self.low, most.low), -most.high)
        high = np.minimum(np.maximum(self.high, -most.low), most.high)
        return Intervals(low, high)


def cosine(a: Intervals, b: Intervals) -> Intervals:
    """``a/|(a, b)|`` for all numbers inside; all of [-1, 1] where both may vanish.

    It grows with a; where a is positive it falls with abs(b), where a is negative it grows with it.
    """
    beside = abs(b)
    low = _quotient(a.low, np.where(a.low < 0, beside.low, beside.high), -np.inf)
    high = _quotient(a.high, np.where(a.high > 0, beside.low, beside.high), np.inf)
    free = a.holds_zero & b.holds_zero
    return Intervals(np.where(free, -1.0, np.maximum(low, -1.0)), np.where(free, 1.0, np.minimum(high, 1.0)))


def _quotient(a: Floats, b: Floats, toward: float) -> Floats:
    """``a/|(a, b)|`` rounded in one direction."""
    squares = a * a + b * b  # to one unit in the last place
    size = _outward(squares, squares).sqrt()
    down = toward < 0
    # the quotient is least in size where the divisor is largest
    divisor = np.where((a < 0) == down, size.low, size.high)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.nextafter(a / divisor, toward)


def _outward(low: Floats, high: Floats) -> Intervals:
    """Ends that are correct to half a unit in the last place, moved outward by more than one."""
    below, above = np.asarray(np.abs(low)), np.asarray(np.abs(high))
    for doubt in (below, above):  # in place: large arrays are not copied
        np.multiply(doubt, UNITS, out=doubt)
        np.add(doubt, TINY, out=doubt)
    return Intervals(np.subtract(low, below, out=below), np.add(high, above, out=above))
