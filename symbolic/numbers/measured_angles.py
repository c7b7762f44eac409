"""Which angles of a scene stay exact, and which are taken as measured.

``cos`` and ``sin`` of ``pi t`` lie in a real cyclotomic field whose degree grows with the denominator of t, and
different denominators multiply: a few headings in whole degrees need degree 48, over which no partition ends.  So the
angles of one scene are looked at together.  If their common field has a degree of at most :data:`MOST_DEGREE`, all stay
exact.  Otherwise those alone stay exact that need no such field, the multiples of 15 degrees with their square roots;
each other is taken as measured, and stands for a rational direction beside it
(:mod:`nonsmooth.symbolic.numbers.rational_directions`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from nonsmooth.symbolic.numbers.number_field import NumberField, base_order
from nonsmooth.symbolic.numbers.rational_directions import CLOSENESS

# Of the cyclotomic field of a scene: multiples of 5 or 9 or 12 degrees alone, rings of up to 16 wheels.  A check of
# nine wheels takes three seconds at this degree, six at 16 (multiples of 3 degrees) and half a minute at 24.
MOST_DEGREE = 12

MOST_SHOWN = 4  # measured angles that a note lists


@dataclass(frozen=True)
class AngleChoice:
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
        if degree_of(order) > MOST_DEGREE:
            measured = [turn for turn in different if base_order([turn]) > 1]
            return AngleChoice(1, tuple(sorted(measured)))
    return AngleChoice(order, ())


def angle_notes(field: NumberField) -> tuple[str, ...]:
    """What a reader must know about the angles of a scene; nothing where all are exact."""
    if not field.measured:
        return ()
    shown = [f"{turn}*pi" for turn in field.measured[:MOST_SHOWN]]
    more = [f"and {len(field.measured) - MOST_SHOWN} more"] * (len(field.measured) > MOST_SHOWN)
    return (
        f"angles taken as measured: {', '.join(shown + more)}: their common number field has a degree above "
        f"{MOST_DEGREE}, so each stands for a rational direction of length one within {float(CLOSENESS):.0e} of it",
    )


@cache
def degree_of(order: int) -> int:
    """Degree of ``Q(2 cos(2 pi/N))``: half of Euler's phi, at least one."""
    return max(1, sum(math.gcd(k, order) == 1 for k in range(order)) // 2)
