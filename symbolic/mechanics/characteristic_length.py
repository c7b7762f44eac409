"""The length l that weighs headings against places: ``V = |c|^2 + l^2 theta^2``, what a scene takes by default.

That length is a part of the array, whatever the unit: the root mean square distance of the wheels from the checked
point, as ``a q`` with a rational a that scales with the array and three digits of the ratio q.  So it is rational, and
the same length in every unit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Context, Decimal
from fractions import Fraction

from flint import arb, ctx, fmpq

from nonsmooth.symbolic.mechanics.body import extent, outer_positions
from nonsmooth.symbolic.numbers.coefficients import as_fraction, rational_ball
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector, minus

DIGITS = 3  # of the ratio q
_SETTLED = 12  # digits to which q is rounded first, so that a tie of the rounding is a tie in every unit
_BITS = 64  # of the distances
SMALL, LARGE = 2.0**-332, 2.0**332  # sums of squares of floats in between neither vanish nor overflow


def default_length(positions: Sequence[Vector], point: Vector) -> Fraction:
    """Root mean square distance (length) of the wheels from a point, to about three digits.

    Args:
        positions: of at least two wheels, at different places.
        point: the checked one.
    """
    outer = outer_positions(positions)
    unit = rational_size(max(extent(outer, 0), extent(outer, 1)))
    coordinates = [entry for position in positions for entry in minus(position, point) if entry]
    settled = _root_mean_square(coordinates, len(positions), unit)
    return unit * Fraction(Context(prec=DIGITS).plus(settled))


def _root_mean_square(coordinates: Sequence[Number], count: int, unit: Fraction) -> Decimal:
    """``sqrt(sum x^2/count)/unit`` to more digits than are kept: in floats, or beyond their range in balls."""
    sizes = [abs(float(entry)) for entry in coordinates]
    if SMALL < max(sizes) < LARGE and SMALL < unit < LARGE:
        mean = math.fsum(size * size for size in sizes) / count
        return Decimal(f"{math.sqrt(mean) / float(unit):.{_SETTLED}g}")
    with ctx.workprec(2 * _BITS):
        squares = sum((entry.accurate_ball(_BITS) ** 2 for entry in coordinates), arb(0))
        ratio = (squares / count).sqrt() / rational_ball(unit)
        return Decimal(ratio.str(_SETTLED, radius=False))


def rational_size(value: Number) -> Fraction:
    """A positive rational that scales with a nonzero number: its size, or of an irrational one its first coefficient.

    ``rational_size(k x) = |k| rational_size(x)`` for every rational k.
    """
    first = value.terms[min(value.terms)]
    rational = first if isinstance(first, fmpq) else next(entry for entry in first.coeffs() if entry)
    return abs(as_fraction(rational))
