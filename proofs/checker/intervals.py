"""Intervals whose ends lie on a grid and are rounded outward, and functions of parameters that lie in intervals.

``Interval(l, h)``, l and h whole numbers, holds all real numbers from ``l/G`` to ``h/G``, with ``G = 2^128``.  Every
operation holds what it gives for any numbers of its operands.  *Proof.*  Sums and opposites of whole numbers are exact.
For x from ``a/G`` to ``b/G`` and y from ``c/G`` to ``d/G`` ``G^2 x y`` lies between the least and the largest of
ac, ad, bc and bd, because it is linear in x and in y; a shift divides these by G and rounds down, and between two
signs up.  Where y keeps its sign, ``G/y`` falls in y: it lies between ``G^2/d`` and ``G^2/c``, rounded in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .tower import Number
from .work import require

BITS = 128
GRID = 1 << BITS


def above(value: int) -> int:
    """A product of two numbers on the grid, rounded up to the grid."""
    return -(-value >> BITS)


@dataclass(frozen=True, slots=True)
class Interval:
    """All numbers from ``low`` to ``high``, in units of the grid."""

    low: int
    high: int

    def __add__(self, other: Interval) -> Interval:
        return Interval(self.low + other.low, self.high + other.high)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __sub__(self, other: Interval) -> Interval:
        return self + -other

    def __mul__(self, other: Interval) -> Interval:
        a, b, c, d = self.low, self.high, other.low, other.high
        products = (a * c, a * d, b * c, b * d)
        return Interval(min(products) >> BITS, above(max(products)))

    def __truediv__(self, other: Interval) -> Interval:
        require(other.low > 0 or other.high < 0, "a divisor that is not zero")
        return self * Interval(GRID * GRID // other.high, -(-GRID * GRID // other.low))

    @property
    def size(self) -> int:
        """The largest absolute value."""
        return max(-self.low, self.high)


ZERO, ONE = Interval(0, 0), Interval(GRID, GRID)


def interval(number: Number) -> Interval:
    """Bounds of an exact number, which must be smaller than G."""
    enclosure = Interval(*number.enclosure(BITS))
    require(enclosure.size < GRID * GRID, "numbers of moderate size")
    return enclosure


@dataclass(frozen=True, slots=True)
class Jet:
    """A function over a box of parameters: bounds of its value, and of its slope in every parameter."""

    value: Interval
    slopes: tuple[Interval, ...] = ()  # none over a single point

    def __add__(self, other: Jet) -> Jet:
        return Jet(self.value + other.value, tuple(a + b for a, b in zip(self.slopes, other.slopes, strict=True)))

    def __neg__(self) -> Jet:
        return Jet(-self.value, tuple(-a for a in self.slopes))

    def __sub__(self, other: Jet) -> Jet:
        return self + -other

    def __mul__(self, other: Jet) -> Jet:
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(self.value * other.value, tuple(a * other.value + self.value * b for a, b in pairs))

    def __truediv__(self, other: Jet) -> Jet:
        ratio = self.value / other.value
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(ratio, tuple((a - ratio * b) / other.value for a, b in pairs))


def mean_value(middle: Interval, over: Jet, sizes: Sequence[int]) -> Interval:
    """Bounds of a function over a box, by the mean value theorem.

    Its value at the middle changes by at most ``slope * size`` for each parameter that is off by up to its size.
    """
    reach = sum(above(slope.size * size) for slope, size in zip(over.slopes, sizes, strict=True))
    return Interval(middle.low - reach, middle.high + reach)
