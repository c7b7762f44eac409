"""Which angles of a scene stay exact, and which are taken as measured.

``cos`` and ``sin`` of ``pi t`` lie in a real cyclotomic field whose degree grows with the denominator of t, and
different denominators multiply: a few headings in whole degrees need degree 48, over which no partition ends.  So the
angles of one scene are looked at together.  If their common field has a degree of at most :data:`MOST_DEGREE`, all stay
exact.  Otherwise those alone stay exact that need no such field, the multiples of 15 degrees with their square roots;
each other is taken as measured, and stands for a rational direction beside it
(:mod:`nonsmooth.symbolic.numbers.rational_directions`).

An angle given as a number of radians is no multiple of pi, unless it is zero.  It becomes the turn beside it, a
fraction so long that the angle is taken as measured (:func:`turn_of_radians`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from flint import arb, ctx, fmpq, fmpz

from nonsmooth.symbolic.numbers.coefficients import exactly
from nonsmooth.symbolic.numbers.number_field import NumberField, base_order
from nonsmooth.symbolic.numbers.rational_directions import CLOSENESS

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
        turn = exactly((arb(fmpq(value.numerator, value.denominator)) / arb.pi()).mid())
    near = turn.limit_denominator(SHORT)
    is_near = 4 * abs(near - turn) < ROUNDING  # pi < 4
    return (near, True) if is_near else (turn, False)


def angle_notes(field: NumberField) -> tuple[str, ...]:
    """What a reader must know about the numbers of a scene: the remarks on its file, and the measured angles."""
    if not field.measured:
        return field.remarks
    shown = [_shown(turn, field.writes_decimals) for turn in field.measured[:MOST_SHOWN]]
    more = [f"and {len(field.measured) - MOST_SHOWN} more"] * (len(field.measured) > MOST_SHOWN)
    return (
        *field.remarks,
        f"angles taken as measured: {', '.join(shown + more)}: no number field of degree up to {MOST_DEGREE} holds "
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
