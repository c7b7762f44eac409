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
from functools import cache
from typing import NamedTuple

from flint import arb, ctx, fmpz

from nonsmooth.symbolic.numbers.coefficients import Rational, exactly, rational_ball
from nonsmooth.symbolic.numbers.number import Number, Tower
from nonsmooth.symbolic.numbers.rational_directions import CLOSENESS, direction_beside, rational_direction
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


# ---- angles that were measured -------------------------------------------------------------------
#
# Which angles of a scene stay exact, and which are taken as measured.
#
# ``cos`` and ``sin`` of ``pi t`` lie in a real cyclotomic field whose degree grows with the denominator of t, and
# different denominators multiply: a few headings in whole degrees need degree 48, over which no partition ends.  So the
# angles of one scene are looked at together.  If their common field has a degree of at most :data:`MOST_DEGREE`, all
# stay exact.  Otherwise those alone stay exact that need no such field, the multiples of 15 degrees with their square
# roots; each other is taken as measured, and stands for a rational direction beside it
# (:mod:`nonsmooth.symbolic.numbers.rational_directions`).
#
# An angle given as a number of radians is no multiple of pi, unless it is zero.  It becomes the turn beside it, a
# fraction so long that the angle is taken as measured (:func:`turn_of_radians`).


# Of the cyclotomic field of a scene: multiples of 5 or 9 or 12 degrees alone, rings of up to 16 wheels.  A check of
# nine wheels takes three seconds at this degree, six at 16 (multiples of 3 degrees) and half a minute at 24.
MOST_DEGREE = 12

MOST_ORDER = 90  # phi(n) > 24 for every larger n, so the field of such an order has a degree above MOST_DEGREE

MOST_SHOWN = 4  # measured angles that a note lists
SHORT = 360  # denominators of turns that are shown as multiples of pi

# A number of radians this close to a multiple of pi (of denominator up to 360) is a rounded one, and taken as it.
ROUNDING = Fraction(1, 10**12)
_PRECISION = 160  # bits after the point of a turn from radians


class AngleChoice(NamedTuple):
    """The angles of one scene, as turns t of ``pi t``.

    Attributes:
        order: N of the field ``Q(2 cos(2 pi/N))`` that holds the exact ones.
        measured: those that stand for rational directions, ascending.
    """

    order: int
    measured: tuple[Fraction, ...]

    @property
    def field(self) -> NumberField:
        """A new field for the scene."""
        return NumberField(self.order, self.measured)


def choose_angles(turns: Iterable[Fraction]) -> AngleChoice:
    """The exact and the measured angles of a scene, all together."""
    different = set(turns)
    order = 1
    for turn in different:
        order = math.lcm(order, base_order([turn]))
        if order > MOST_ORDER or degree_of(order) > MOST_DEGREE:
            measured = [turn for turn in different if base_order([turn]) > 1]
            return AngleChoice(1, tuple(sorted(measured)))
    return AngleChoice(order, ())


def turn_of_radians(value: Fraction) -> tuple[Fraction, bool]:
    """A rational t with ``pi t`` at the given angle, to far less than the closeness of a rational direction.

    Args:
        value: the angle (radian).

    Returns:
        t, and whether a multiple of pi within :data:`ROUNDING` was taken for the angle.
    """
    if not value:
        return Fraction(0), False
    with ctx.workprec(_PRECISION + int(abs(value)).bit_length()):
        turn = exactly((rational_ball(value) / arb.pi()).mid())
    near = turn.limit_denominator(SHORT)
    is_near = 4 * abs(near - turn) < ROUNDING  # pi < 4
    return (near, True) if is_near else (turn, False)


def angle_notes(field: NumberField) -> tuple[str, ...]:
    """What a reader must know about the numbers of a scene: the remarks on its file, and the measured angles."""
    if not field.measured:
        return field.remarks
    angles = [_shown(turn, field.writes_decimals) for turn in field.measured[:MOST_SHOWN]]
    more = [f"and {len(field.measured) - MOST_SHOWN} more"] * (len(field.measured) > MOST_SHOWN)
    return (
        *field.remarks,
        f"angles taken as measured: {', '.join(angles + more)}: no number field of degree up to {MOST_DEGREE} holds "
        f"them all, so each stands for a rational direction of length one within {float(CLOSENESS):.0e} of it",
    )


def _shown(turn: Fraction, decimals: bool) -> str:
    """An angle between minus and plus a half turn, in degrees or as a short multiple of pi."""
    turn = 1 - (1 - turn) % 2
    return f"{turn}*pi" if turn.denominator <= SHORT and not decimals else f"{float(180 * turn):.10g} deg"


@cache
def degree_of(order: int) -> int:
    """Degree of ``Q(2 cos(2 pi/N))``: half of Euler's phi, at least one."""
    phi = order
    for prime, _ in fmpz(order).factor():
        phi -= phi // int(prime)
    return max(1, phi // 2)
