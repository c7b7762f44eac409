"""Lines and points that floats or whole numbers know, and polygons that are cut by them; exact values on demand.

A line is where an affine form ``a + b x + c y`` vanishes, a point is ``(w, x, y)`` with ``w > 0``, which stands for
``(x/w, y/w)``; so the form has the sign of their inner product there, and two lines meet in their cross product.  Both
are kept as floats with a bound of their error, or without error as whole numbers, where the three are rational
multiples of one number.  Exact field elements are made only where these leave a sign open, and where somebody asks
for a vertex.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

from nonsmooth.analysis.cells.loads import Affine
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, cut, meeting
from nonsmooth.symbolic.numbers.coefficients import whole_multiples
from nonsmooth.symbolic.numbers.lazy import Lazy, sure_float
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.rounded import Rounded

Three: TypeAlias = tuple[Any, Any, Any]
Exact = TypeVar("Exact")

ROUNDING = 2.0**-50  # relative, of a sum of three products and of its terms' absolute values
LEAST, MOST = 2.0**-200, 2.0**200  # between these, products of products of products are normal floats
ROUNDED = 2.0**-29  # of what is computed by a few products from numbers that stand for others close by
CLOSE = 2.0**-34  # of its size: how far those others are from such a number at most
MOST_BITS = 100  # of whole numbers: products of products of products are in the range of floats, too


class Filtered(NamedTuple):
    """Three numbers up to a common positive factor.

    Attributes:
        values: whole numbers, or floats; nan where they are not known.
        sizes: bounds of their absolute values.
        error: each value errs by at most this times its size; zero for whole numbers.
    """

    values: Three
    sizes: Three
    error: float

    @classmethod
    def of(cls, numbers: Sequence[Any]) -> Filtered:
        """From exact numbers, and such as stand for others close by."""
        whole = whole_numbers(numbers)
        if whole:
            return cls.bounded(whole, [abs(value) for value in whole], 0)
        values = [float(number) if isinstance(number, Rounded) else sure_float(number) for number in numbers]
        sizes = [size_of(*pair) for pair in zip(numbers, values, strict=True)]
        return cls.bounded(values, sizes, ROUNDED if any(isinstance(x, Rounded) for x in numbers) else ROUNDING)

    @classmethod
    def bounded(cls, values: Sequence[Any], sizes: Sequence[Any], error: float) -> Filtered:
        """From floats with bounds; what is too small or too large is not known."""
        if error and not all(LEAST < size < MOST or not size for size in sizes):
            values = [math.nan] * 3
        return cls((values[0], values[1], values[2]), (sizes[0], sizes[1], sizes[2]), error)

    def plus(self, other: Filtered) -> Filtered:
        """The sum of two that have one factor."""
        (a, b, c), (r, s, t), error = self
        (x, y, z), (u, v, w), more = other
        return Filtered((a + x, b + y, c + z), (r + u, s + v, t + w), max(error, more) and max(error, more) + ROUNDING)

    def times(self, factor: Any) -> Filtered:
        """Of one factor, which is positive and known as well as these are."""
        (a, b, c), (r, s, t), error = self
        return Filtered((a * factor, b * factor, c * factor), (r * factor, s * factor, t * factor), error)


def size_of(number: Any, value: float) -> float:
    """A bound of the absolute value of a number, given as a float too.

    Where only a ball is known of it, the size is so large that all of that lies within :data:`CLOSE` of it.
    """
    if type(number) is Number:
        return abs(value)
    ball = number.ball if isinstance(number, Lazy) else number.ball()
    return max(abs(value), float(ball.rad()) / CLOSE)


def whole_numbers(numbers: Sequence[Any]) -> list[int] | None:
    """Whole numbers in the same ratios as exact ones; None where there are none of few digits."""
    is_known = all(type(number) is Number for number in numbers)
    return whole_multiples([number.terms for number in numbers], MOST_BITS) if is_known else None


def known_sign(line: Filtered, point: Filtered) -> int | None:
    """Sign of the form at a point; None where rounding decides it."""
    (a, b, c), sizes, error = line
    (w, x, y), others, more = point
    value = a * w + b * x + c * y
    if error or more:
        size = sizes[0] * others[0] + sizes[1] * others[1] + sizes[2] * others[2]
        if not abs(value) > size * (error + more + ROUNDING):
            return None
    return 1 if value > 0 else -1 if value < 0 else 0


def meet(first: Filtered, second: Filtered) -> Filtered:
    """Where two lines meet: the cross product, without a common factor."""
    (a, b, c), (r, s, t), error = first
    (x, y, z), (u, v, w), more = second
    values = b * z - c * y, c * x - a * z, a * y - b * x
    if error or more:
        return Filtered(values, (s * w + t * v, t * u + r * w, r * v + s * u), error + more + ROUNDING)
    return _whole(values)


def between(first: Filtered, second: Filtered) -> Filtered:
    """The midpoint of two points."""
    (w, x, y), sizes, error = first
    (v, p, q), others, more = second
    values = 2 * w * v, x * v + p * w, y * v + q * w
    if error or more:
        (w, x, y), (v, p, q) = sizes, others
        return Filtered(values, (2 * w * v, x * v + p * w, y * v + q * w), error + more + ROUNDING)
    return _whole(values)


def _whole(values: Three) -> Filtered:
    factor = math.gcd(*values) or 1
    a, b, c = values[0] // factor, values[1] // factor, values[2] // factor
    return Filtered((a, b, c), (abs(a), abs(b), abs(c)), 0)


@dataclass(eq=False)
class OnDemand(Generic[Exact]):
    """A form, a half-plane or a point that is exact on demand.

    Attributes:
        filtered: a positive multiple of the form, or of that behind the half-plane, or the point.
        build: makes it.
    """

    filtered: Filtered
    build: Callable[[], Exact]

    @cached_property
    def exact(self) -> Exact:
        """Made once."""
        return self.build()


class Form(OnDemand[Affine]):
    """An affine form."""


@dataclass(eq=False)
class OutlineCorner(OnDemand[Three]):
    """A corner of an outline: ``(w, x, y)`` with ``w > 0``, which are made by a few products."""

    @cached_property
    def point(self) -> Point:
        """``(x/w, y/w)``."""
        w, x, y = self.exact
        return x / w, y / w


@dataclass(eq=False)
class OutlineSide(OnDemand[HalfPlane]):
    """A closed half-plane in which a form is not negative.

    Attributes:
        origin: that form; None for the border of the domain.
    """

    origin: Form | None = None


@dataclass(frozen=True, eq=False)
class Outline:
    """A convex polygon as :class:`nonsmooth.analysis.cells.polygon.Polygon`, exact on demand."""

    corners: tuple[OutlineCorner, ...]
    sides: tuple[OutlineSide, ...]

    @classmethod
    def of(cls, polygon: Polygon) -> Outline:
        """From a polygon."""
        vertices = [(_one(p), *p) for p in polygon.vertices]
        corners = [OutlineCorner(Filtered.of(v), lambda v=v: v) for v in vertices]  # type: ignore[misc]
        sides = [OutlineSide(Filtered.of((s.offset, -s.normal[0], -s.normal[1])), lambda s=s: s) for s in polygon.sides]  # type: ignore[misc]
        return cls(tuple(corners), tuple(sides))

    @property
    def polygon(self) -> Polygon:
        """With exact vertices and sides."""
        return Polygon(tuple(c.point for c in self.corners), tuple(s.exact for s in self.sides))

    def keeps(self, form: Filtered) -> bool:
        """Whether a form is known not to be negative at any corner."""
        signs = (known_sign(form, corner.filtered) for corner in self.corners)
        return all(sign is not None and sign >= 0 for sign in signs)

    def clipped(self, side: OutlineSide) -> Outline | None:
        """See :meth:`nonsmooth.analysis.cells.polygon.Polygon.clipped`."""
        signs = [sign_at(side, corner) for corner in self.corners]
        if min(signs) >= 0:
            return self
        if max(signs) <= 0:
            return None

        def corner(crossed: OutlineSide, here: int) -> OutlineCorner:
            first, second = (crossed, side) if here > 0 else (side, crossed)
            return OutlineCorner(meet(first.filtered, second.filtered), lambda: meeting(first.exact, second.exact))

        return Outline(*cut(signs, self.corners, self.sides, side, corner))


def sign_at(side: OutlineSide, corner: OutlineCorner) -> int:
    """Sign of the form behind a side."""
    known = known_sign(side.filtered, corner.filtered)
    if known is not None:
        return known
    line, (w, x, y) = side.exact, corner.exact
    return sign(line.offset * w - (line.normal[0] * x + line.normal[1] * y))


def _one(point: Point) -> Any:
    return point[0].field.one
