"""Values with first derivatives in ball arithmetic, to enclose a function over a box of parameters.

With q0 in the box Q and partial derivatives enclosed over all of Q, the mean value theorem gives
``f(q) in f(q0) + sum_k f_k(Q) (q_k - q0_k)``, which is right to first order in the size of the box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb


@dataclass(frozen=True)
class Jet:
    """A value and its partial derivatives, all balls."""

    value: arb
    slopes: tuple[arb, ...]

    def __add__(self, other: Jet) -> Jet:
        return Jet(self.value + other.value, tuple(a + b for a, b in zip(self.slopes, other.slopes, strict=True)))

    def __sub__(self, other: Jet) -> Jet:
        return Jet(self.value - other.value, tuple(a - b for a, b in zip(self.slopes, other.slopes, strict=True)))

    def __mul__(self, other: Jet) -> Jet:
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(self.value * other.value, tuple(a * other.value + self.value * b for a, b in pairs))

    def __truediv__(self, other: Jet) -> Jet:
        """The quotient; the divisor's ball must not hold zero."""
        quotient = self.value / other.value
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(quotient, tuple((a - quotient * b) / other.value for a, b in pairs))


def direction(first: Jet, second: Jet) -> tuple[Jet, Jet] | None:
    """The unit vector e along ``w = (first, second)``; None where w may vanish.

    Written so that little is lost where w is known in proportion: ``e = (1, t)/sqrt(1 + t^2)`` with the ratio t of the
    smaller to the larger entry, and ``e' = (-e_2, e_1) (e_1 w_2' - e_2 w_1')/|w|``.
    """
    a, b = first.value, second.value
    square = a * a + b * b
    if not square > 0:
        return None
    size = square.sqrt()
    e, f = _unit(a, b) if abs(a) > abs(b) else (_unit(b, a)[::-1] if abs(b) > abs(a) else (a / size, b / size))
    turns = [(e * q - f * p) / size for p, q in zip(first.slopes, second.slopes, strict=True)]
    return Jet(e, tuple(-f * turn for turn in turns)), Jet(f, tuple(e * turn for turn in turns))


def _unit(larger: arb, smaller: arb) -> tuple[arb, arb]:
    """``(larger, smaller)`` divided by its length."""
    ratio = smaller / abs(larger)
    size = (1 + ratio * ratio).sqrt()
    return (1 if larger > 0 else -1) / size, ratio / size


def parameter(value: arb, number: int, count: int) -> Jet:
    """The parameter of a number among ``count``."""
    return Jet(value, tuple(arb(int(k == number)) for k in range(count)))


def over_box(middle: Jet, whole: Jet, sizes: Sequence[arb]) -> arb:
    """An enclosure over a box of half-widths ``sizes``.

    Args:
        middle: the function at the middle of the box.
        whole: the same evaluated over the whole box.
        sizes: half-width of every parameter, not negative.
    """
    unit, total = arb(0, 1), middle.value
    for slope, size in zip(whole.slopes, sizes, strict=True):
        total += slope * size * unit
    return total
