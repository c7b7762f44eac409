"""Numbers that were rounded: a member of a box of numbers, and how far the others are.

The cosine of an angle that no number field of the scene holds is replaced by a rational number within 1e-15 of it
(:mod:`nonsmooth.symbolic.numbers.rational_directions`).  What is decided of the rational number need not be true of the
cosine.  So such a number, and every number that is computed from it, is a :class:`Rounded`: an element of the field as
any other, which also carries

- ``box``, a ball around its values for all angles within the closeness of the given ones;
- ``member``, its value at angles a millionth or so away, in 256 bits.

Interval arithmetic carries both along.  A sign that is the same all over the box is certain.  Any other is that of the
rational number alone: the field counts it (:attr:`nonsmooth.symbolic.numbers.number.Tower.rounded_signs`),
and a decision during which that count rose is one of rounding.  Elsewhere the same steps are taken for every member of
the box, so the decision holds for all of them.

Sums that cancel for every angle (``cos^2 + sin^2 - 1``, the forces on a symmetric array) are no ties.  They are told
from those that cancel for the rational numbers alone by the other member, at which these would have to vanish to some
seventy digits as well (an identity test at a random point, after Schwartz and Zippel).  Such a sum is exact again.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import lru_cache, wraps
from typing import Any, TypeVar

from flint import arb, ctx, fmpq

from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.exact_real import ExactReal
from nonsmooth.symbolic.numbers.number import Number, Tower
from nonsmooth.symbolic.numbers.rational_directions import CLOSENESS

BY_ROUNDING = "rounding decides: "  # how all reasons of the kind begin
ROUNDING_DECIDES = (
    f"{BY_ROUNDING}of the arrays whose measured angles lie within {float(CLOSENESS):.0e} of the stated ones, "
    "it may be true of some and not of others"
)

PLACE_DECIDES = (
    f"{BY_ROUNDING}the point is a place of rest that is enclosed, and it may be true of some points so close and not "
    "of others"
)

Found = TypeVar("Found")

_PRECISION = 256  # bits of the box and of the other member
_DECIMALS = 50  # of the middle of an enclosure, before it is rounded
_LEAST_RADIUS = 2.0**-100  # of an enclosure: a smaller one is printed with too many digits
_FAR, _FARTHER = 2.0**30, 2.0**-20  # of the radius, and at least: where the other member of an enclosed number is
_CONSTANT = 2.0**-40  # of the box's radius: what differs less at the other member, a billion radii away, is the same


class Rounded(Number):
    """A number of a box; the arithmetic is that of the rounded member, with the box and another member beside it.

    Args:
        exact: the rounded member, an element of the field.
        box: encloses the values of all members.
        member: the value of another member.
    """

    __slots__ = ("box", "exact", "member")

    def __init__(self, exact: Number, box: arb, member: arb) -> None:
        super().__init__(exact.field, exact.terms)
        self.exact, self.box, self.member = exact, box, member

    # ---- arithmetic ------------------------------------------------------------------------------

    # Returned is a Rounded, or where the result is the same for all members a Number.
    def _with(self, value: Any, operation: Callable[[Any, Any], Any]) -> Any:
        other = self._operand(value)
        return NotImplemented if other is None else _computed(operation, self, other)

    def __add__(self, value: Any) -> Any:
        return self._with(value, operator.add)

    def __sub__(self, value: Any) -> Any:
        return self._with(value, operator.sub)

    def __rsub__(self, value: Any) -> Any:
        return self._with(value, lambda a, b: b - a)

    def __mul__(self, value: Any) -> Any:
        return self._with(value, operator.mul)

    def __truediv__(self, value: Any) -> Any:
        return self._with(value, operator.truediv)

    def __rtruediv__(self, value: Any) -> Any:
        return self._with(value, lambda a, b: b / a)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Any:
        return _computed(operator.neg, self)

    def __abs__(self) -> Any:
        return _computed(abs, self)

    def inverse(self) -> Number:
        """Multiplicative inverse; raises as that of an exact number."""
        return _computed(lambda a: 1 / a, self)

    def sqrt(self) -> Number:
        """Non-negative square root; raises as that of an exact number."""
        return _computed(lambda a: a.sqrt(), self)

    # ---- decisions -------------------------------------------------------------------------------

    def sign(self) -> int:
        """Sign of the rounded member: certain where the box has one sign, else counted as decided by rounding."""
        if self.box > 0:
            return 1
        if self.box < 0:
            return -1
        self.field.rounded_signs += 1
        return self.exact.sign()

    _compare, __bool__, __eq__ = ExactReal._compare, ExactReal.__bool__, ExactReal.__eq__  # all by the sign

    def __hash__(self) -> int:
        return hash(self.exact)

    # ---- conversion ------------------------------------------------------------------------------

    def ball(self) -> arb:
        """Enclosure of all members, whatever the working precision."""
        return self.box

    def accurate_ball(self, bits: int) -> arb:
        """Enclosure of all members: no precision makes it smaller."""
        return self.box

    def as_rational(self) -> fmpq | None:
        """The rounded member where it is rational; who decides by it decides by rounding, so it is counted."""
        self.field.rounded_signs += 1
        return self.exact.as_rational()

    def __float__(self) -> float:
        return float(self.exact)


def _computed(operation: Callable[..., Any], *numbers: Number) -> Number:
    """What an operation gives of numbers of which one is rounded; of width zero where it is the same for all members.

    Raises:
        ZeroDivisionError: for a division by zero.
        ValueError: for the root of a negative number.
    """
    exact: Number = operation(*map(plain, numbers))
    before, ctx.prec = ctx.prec, _PRECISION  # a third of the time that ``ctx.workprec`` takes
    try:
        boxes, members = zip(*map(_box_and_member, numbers), strict=True)
        box, member = operation(*boxes), operation(*members)
        is_constant = box.overlaps(member) and box.is_finite()
        is_constant = is_constant and abs(member - exact.ball()) <= box.rad() * _CONSTANT
    finally:
        ctx.prec = before
    return exact if is_constant else Rounded(exact, box, member)


def _box_and_member(number: Number) -> tuple[arb, arb]:
    """The values of all members, and that of the other one; twice the value where it is the same for all."""
    return (number.box, number.member) if isinstance(number, Rounded) else (number.ball(),) * 2


@contextmanager
def either_way(field: Tower) -> Iterator[None]:
    """Count no decisions of rounding: whichever of the ways is gone, what comes of it is right, or verified later."""
    before = field.rounded_signs
    yield
    field.rounded_signs = before


def counted(field: Tower, find: Callable[[], Found]) -> tuple[Found, int]:
    """What a function finds, and how many signs rounding decided on the way, which the field does not count yet."""
    with either_way(field):
        before = field.rounded_signs
        found = find()
        return found, field.rounded_signs - before


def remembered(most: int) -> Callable[[Callable[..., Found]], Callable[..., Found]]:
    """Remember what a function finds of the last few scenes; what rounding decided of it counts at every use."""

    def decorated(find: Callable[..., Found]) -> Callable[..., Found]:
        @lru_cache(most)
        def found_by_rounding(scene: Any, *more: Any) -> tuple[Found, int]:
            return counted(scene.field, lambda: find(scene, *more))

        @wraps(find)
        def counting(scene: Any, *more: Any) -> Found:
            found, by_rounding = found_by_rounding(scene, *more)
            scene.field.rounded_signs += by_rounding
            return found

        return counting

    return decorated


def certain_sign(number: Number) -> int:
    """The sign of a number where it is that of all members; 0 where it is not, which is not counted."""
    with either_way(number.field):
        before = number.field.rounded_signs
        sign = number.sign()
        return sign if number.field.rounded_signs == before else 0


def plain(number: Number) -> Number:
    """The rounded member of a number, as a number of width zero."""
    return number.exact if isinstance(number, Rounded) else number


def rounded(exact: Number, away: Fraction) -> Rounded:
    """A number that was rounded by up to the closeness of rational directions, with its value at another member."""
    radius = rational_ball(CLOSENESS)
    with ctx.workprec(_PRECISION):
        return Rounded(exact, exact.ball() + radius * arb(0, 1), rational_ball(away))


def enclosed(field: Tower, box: arb, share: float) -> Rounded:
    """A number of which only an enclosure is known; a decimal number in its middle stands for it.

    Args:
        field: of the number.
        box: the enclosure, finite.
        share: how far away the other member is, between one half and one; another one for each number, so that no sum
            of several vanishes at both members by chance.
    """
    with ctx.workprec(_PRECISION):
        radius = max(float(box.rad()), _LEAST_RADIUS)
        middle = field.rational(round(Fraction(box.mid().str(_DECIMALS, radius=False)), math.ceil(-math.log10(radius))))
        around = (box + arb(0, _LEAST_RADIUS)).union(middle.ball())
        return Rounded(middle, around, around.mid() + max(_FAR * radius, _FARTHER) * share)
