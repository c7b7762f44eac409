"""Lazy quotients, exact but evaluated when needed: a ball first, the field element where the ball is undecided.

Cell vertices are quotients of sums over many square roots.  Their exact form is long, and inverting such a sum
doubles in length with every root; yet nearly every sign needed of them is clear from a 256-bit ball.  A
:class:`Lazy` keeps the ball and the recipe.  Only when a sign is not clear, which means a true tie or nearly so,
the recipe is carried out as a fraction of field elements, whose sign is certified.  So no answer depends on a
precision: the ball only saves work.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import reduce
from operator import or_
from typing import Any, TypeAlias

from flint import arb, ctx, fmpq

from nonsmooth.symbolic.numbers.exact_real import ExactReal
from nonsmooth.symbolic.numbers.number import HUGE, TINY, Number, Tower
from nonsmooth.symbolic.numbers.rounded import Rounded

# With more independent square roots than this, quotients stay unevaluated: their exact form may hold 2^r terms.
FEW_ROOTS = 2
# Longer numbers are lazy as well: balls of 256 bits are then much shorter than exact products.
FEW_BITS = 1024

# Square roots in a denominator up to which a quotient that is shown is carried out.
EXACT_DENOMINATOR = 4

_PRECISION = 256
# Of a sum of absolute terms, whose rounding error stays below 2^-39 of it for up to a thousand terms: a float value
# beyond this bound has a certain sign.
FLOAT_DOUBT = 2.0**-29
_RATIONAL = (int, fmpq, Fraction)  # as a tuple: the union would be made anew at every call
_FLOAT_BITS = 53

Quotient: TypeAlias = tuple[Number, Number]  # numerator, nonzero denominator


class Lazy(ExactReal):
    """A real number of a field, known as a ball and as a recipe for its exact value."""

    __slots__ = ("_float", "_quotient", "_recipe", "_sign", "ball", "field")

    def __init__(self, field: Tower, ball: arb, recipe: Callable[[], Quotient]) -> None:
        self.field = field
        self.ball = ball
        self._recipe = recipe
        self._quotient: Quotient | None = None
        self._sign: int | None = None
        self._float: float | None = None

    @classmethod
    def of(cls, number: Number) -> Lazy:
        """Wrap a field element."""
        return cls(number.field, _precisely(number.ball), lambda: (number, number.field.one))

    def quotient(self) -> Quotient:
        """Exact numerator and denominator."""
        if self._quotient is None:
            self._quotient = _reduced(*self._recipe())
        return self._quotient

    def sign(self) -> int:
        """Certified sign: -1, 0 or 1."""
        if self._sign is None:
            if self.ball > 0:
                self._sign = 1
            elif self.ball < 0:
                self._sign = -1
            else:
                numerator, denominator = self.quotient()
                sign = numerator.sign() * denominator.sign()
                if isinstance(numerator, Rounded) or isinstance(denominator, Rounded):
                    return sign  # asked again, it is counted again
                self._sign, self.ball = sign, self._tight_ball(sign)
        return self._sign

    def tight_ball(self) -> arb:
        """A ball that shows the sign of the value, unless rounding decides that."""
        self.sign()
        return self.ball

    def _tight_ball(self, sign: int) -> arb:
        """A ball from the exact value that shows its sign."""
        if not sign:
            return arb(0)
        numerator, denominator = self.quotient()
        precision = _PRECISION
        while True:
            with ctx.workprec(precision):
                ball = numerator.ball() / denominator.ball()
            if ball > 0 or ball < 0:
                return ball
            precision *= 2

    def _operand(self, value: Any) -> Lazy | None:
        if isinstance(value, Lazy):
            return value
        if isinstance(value, Number):
            return Lazy.of(value)
        if isinstance(value, _RATIONAL):
            return Lazy.of(self.field.rational(value))
        return None

    def __add__(self, value: Any) -> Lazy:
        other = self._operand(value)
        if other is None:
            return NotImplemented
        return _make(self.field, self.ball, other.ball, arb.__add__, lambda: _add(self.quotient(), other.quotient()))

    def __neg__(self) -> Lazy:
        ball = _precisely(self.ball.__neg__)  # arb rounds even a negation to the working precision
        return Lazy(self.field, ball, lambda: (-self.quotient()[0], self.quotient()[1]))

    def __mul__(self, value: Any) -> Lazy:
        other = self._operand(value)
        if other is None:
            return NotImplemented
        return _make(
            self.field,
            self.ball,
            other.ball,
            arb.__mul__,
            lambda: _multiply(self.quotient(), other.quotient()),
        )

    def __truediv__(self, value: Any) -> Lazy:
        """Quotient.

        Raises:
            ZeroDivisionError: if the divisor is zero.
        """
        other = self._operand(value)
        if other is None:
            return NotImplemented
        if not other.sign():
            raise ZeroDivisionError("division by zero in the number field")

        def recipe() -> Quotient:
            top, bottom = other.quotient()
            return _multiply(self.quotient(), (bottom, top))

        return _make(self.field, self.ball, other.ball, arb.__truediv__, recipe)

    def __rtruediv__(self, value: Any) -> Lazy:
        other = self._operand(value)
        return NotImplemented if other is None else other / self

    def inverse(self) -> Lazy:
        """``1/x``."""
        return 1 / self

    def sqrt(self) -> Number:
        """Square root as a field element (carries out the recipe).

        Raises:
            ValueError: if the value is negative.
        """
        return self.exact().sqrt()

    def exact(self) -> Number:
        """The value as a field element; may be slow where many square roots meet in the denominator."""
        numerator, denominator = self.quotient()
        return numerator / denominator

    def __float__(self) -> float:
        rounded = self.float_of_ball()
        return float_quotient(*self.quotient()) if math.isnan(rounded) else rounded

    def float_of_ball(self) -> float:
        """The value rounded, as far as the ball tells it; nan where it does not."""
        if self._float is None:
            self._float = float(self.ball.mid()) if self.ball.rel_accuracy_bits() > _FLOAT_BITS else math.nan
        return self._float

    def __str__(self) -> str:
        numerator, denominator = self.quotient()
        return str(numerator) if denominator == 1 else f"({numerator})/({denominator})"

    __repr__ = __str__


def _make(field: Tower, a: arb, b: arb, operation: Callable[[arb, arb], arb], recipe: Callable[[], Quotient]) -> Lazy:
    if field.meter is not None:
        field.meter.spend(1)
    return Lazy(field, _precisely(operation, a, b), recipe)


def _precisely(operation: Callable[..., arb], *operands: arb) -> arb:
    """The result of an operation at the precision of lazy quotients; ``ctx.workprec`` takes as long as ten of them."""
    before = ctx.prec
    ctx.prec = _PRECISION
    try:
        return operation(*operands)
    finally:
        ctx.prec = before


def _reduced(numerator: Number, denominator: Number) -> Quotient:
    """The same quotient without a rational denominator: such numbers stay short, and dividing by them is cheap.

    Rounded numbers are rational ones with a box; dividing by them decides nothing.
    """
    if isinstance(denominator, Rounded):
        return numerator / denominator, denominator.field.one
    rational = denominator.as_rational()
    if rational is None or rational == 1:
        return numerator, denominator
    return numerator * (1 / rational), denominator.field.one


def _add(left: Quotient, right: Quotient) -> Quotient:
    (a, b), (c, d) = left, right
    return (a + c, b) if b == d else (a * d + c * b, b * d)


def _multiply(left: Quotient, right: Quotient) -> Quotient:
    (a, b), (c, d) = left, right
    if a == d:
        return c, b
    if b == c:
        return a, d
    return a * c, b * d


def sure_float(value: Any) -> float:
    """An exact number as a float that errs by less than some 2^-51 of it.

    It is nan where that is not known: far from one, of lazy quotients whose ball is wide, and of all that was rounded.
    """
    if type(value) is Number:
        rounded = float(value)
        return rounded if TINY < abs(rounded) < HUGE or not value.terms else math.nan
    if type(value) is Lazy:
        rounded = value.float_of_ball()
        return rounded if TINY < abs(rounded) < HUGE or not rounded else math.nan
    return math.nan


def clear_sign(a: float, b: float, c: float = 0.0) -> int:
    """Sign of a sum of sure floats, or of products of two, where rounding does not decide it; 0 where it may."""
    value, size = a + b + c, abs(a) + abs(b) + abs(c)
    if TINY < size < HUGE and abs(value) > size * FLOAT_DOUBT:
        return 1 if value > 0 else -1
    return 0


def is_clear(value: Any) -> bool:
    """Whether the sign of a number is short work: of a lazy quotient, whether its ball shows it."""
    return not isinstance(value, Lazy) or bool(value.ball > 0 or value.ball < 0)


def is_long(value: Any) -> bool:
    """Whether a field element is better lazy: over many square roots, or of many bits."""
    return isinstance(value, Number) and (len(value.field.radicands) > FEW_ROOTS or value.size_bits > FEW_BITS)


def divided(numerator: Number, denominator: Number) -> Any:
    """The quotient: a field element over few square roots, lazy otherwise."""
    if len(numerator.field.radicands) > FEW_ROOTS:
        return Lazy.of(numerator) / Lazy.of(denominator)
    return numerator / denominator


def float_quotient(numerator: Number, denominator: Number) -> float:
    """The quotient, rounded; of numbers beyond the range of floats too, as their quotient may well lie within it."""
    parts = float(numerator), float(denominator)
    if not numerator or all(TINY < abs(part) < HUGE for part in parts):
        return parts[0] / parts[1] if numerator else 0.0
    with ctx.workprec(_PRECISION):
        return float((numerator.accurate_ball(_FLOAT_BITS) / denominator.accurate_ball(_FLOAT_BITS)).mid())


def quotient(numerator: Number, denominator: Number) -> Number | Lazy:
    """The quotient: a field element where few square roots meet in the denominator, lazy otherwise."""
    roots = reduce(or_, denominator.terms, 0).bit_count()
    return numerator / denominator if roots <= EXACT_DENOMINATOR else divided(numerator, denominator)


def evaluated(value: Any) -> Any:
    """The number itself, where it is a lazy quotient; anything else as it is."""
    return value.exact() if isinstance(value, Lazy) else value
