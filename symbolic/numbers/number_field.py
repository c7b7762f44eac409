"""One real number field per scene, grown on demand.

The field is a tower ``Q(2 cos(2 pi/N)) (sqrt g_1) ... (sqrt g_r)``: a real cyclotomic base for
regular rings, square roots for the lengths of rim directions.  Its elements are sparse sums of products of the
roots (:mod:`nonsmooth.symbolic.numbers.number`), so a sum of three square roots stays three terms however many square
roots the scene holds.

Why this and not one primitive element: the degree doubles with every new wheel length, while the
numbers that a contact state needs hold at most three of them.  A generator is adjoined only when it
is proved to be no square yet (:mod:`nonsmooth.symbolic.numbers.square_roots`), hence the products of the
generators are linearly independent.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction

from nonsmooth.symbolic.numbers.coefficients import Rational
from nonsmooth.symbolic.numbers.number import Number, Tower
from nonsmooth.symbolic.numbers.rational_directions import direction_beside, rational_direction
from nonsmooth.symbolic.numbers.rounded import rounded
from nonsmooth.symbolic.numbers.square_roots import square_root


class FirstRemark(str):
    """A remark that stands above all results: what was read may not be what was meant."""

    __slots__ = ()


class NumberField(Tower):
    """The field ``Q(2 cos(2 pi/N), sqrt g_1, ..., sqrt g_r)``, r growing on demand.

    Args:
        order: see :class:`nonsmooth.symbolic.numbers.number.Tower`.
        measured: see there.
        remarks: sentences about the scene's file that a reader of any result must see: how its numbers were read,
            and what in it was not.
    """

    def __init__(self, order: int = 1, measured: Iterable[Fraction] = (), remarks: Iterable[str] = ()) -> None:
        super().__init__(order, measured)
        self.remarks = tuple(remarks)
        self._measured = {angle % 2 for turn in self.measured for angle in (turn, Fraction(1, 2) - turn)}

    def has_angle(self, turn: Fraction) -> bool:
        """Whether cos and sin of ``pi * turn`` are numbers of this field, exactly or as a measured angle's."""
        return turn % 2 in self._measured or self.order % base_order([turn]) == 0

    def cos_pi(self, turn: Fraction) -> Number:
        """``cos(pi * turn)``: square roots for multiples of pi/12, the base field otherwise.

        Of a measured angle it is that of its rational direction, with the box around it.

        Raises:
            ValueError: if the base field does not hold it (see :func:`base_order`).
        """
        if turn % 2 in self._measured:
            return rounded(self.rational(rational_direction(turn)[0]), direction_beside(turn)[0])
        if 12 % turn.denominator == 0:
            twelfths = int(turn * 12) % 24
            twelfths = min(twelfths, 24 - twelfths)
            value = self._cos_twelfth(min(twelfths, 12 - twelfths))
            return value if twelfths <= 6 else -value
        multiple = turn * self.order / 2
        if multiple.denominator != 1:
            raise ValueError(f"required an angle of the field of order {self.order}, received pi*{turn}")
        return self.two_cos(multiple.numerator) / 2

    def _cos_twelfth(self, k: int) -> Number:
        """``cos(k pi/12)`` for 0 <= k <= 6."""
        root = self.sqrt
        match k:
            case 1:
                return (root(6) + root(2)) / 4
            case 2:
                return root(3) / 2
            case 3:
                return root(2) / 2
            case 5:
                return (root(6) - root(2)) / 4
            case _:
                return self.rational({0: Fraction(1), 4: Fraction(1, 2), 6: Fraction(0)}[k])

    def sin_pi(self, turn: Fraction) -> Number:
        """``sin(pi * turn) = cos(pi * (1/2 - turn))``."""
        return self.cos_pi(Fraction(1, 2) - turn)

    def sqrt(self, value: Number | Rational) -> Number:
        """Non-negative square root; adjoins a generator when the field does not hold it yet.

        Raises:
            ValueError: if the value is negative.
        """
        number = self(value)
        if number not in self.square_roots:
            self.square_roots[number] = square_root(self, number)
        return self.square_roots[number]


def base_order(turns: Iterable[Fraction]) -> int:
    """Order N of the smallest base that holds cos and sin of every angle ``pi * turn``."""
    order = 1
    for turn in turns:
        for angle in (turn, Fraction(1, 2) - turn):
            if 12 % angle.denominator:
                order = math.lcm(order, 2 * angle.denominator)
    return order
