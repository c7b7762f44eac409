"""A place and the outline of a body: on which side, how far from the border, how far the body may move or turn.

Exact for polygons where the numbers allow it, else short rational lower bounds from balls.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import isqrt

from flint import arb, fmpq

from nonsmooth.symbolic.body import Body
from nonsmooth.symbolic.continuum import Disc
from nonsmooth.symbolic.numbers.enclosures import PRECISION, rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector, around, cross, dot, minus
from nonsmooth.symbolic.scene import Scene

BELOW_ROOT_HALF = Fraction(7071, 10_000)  # a square of that half-width lies in the unit disc
SHORT_BITS = 24  # of a margin, which is rounded down


def side_of_outline(body: Body, place: Vector) -> int:
    """1 strictly inside the outline, 0 on it, -1 outside; the place is measured from the centre of mass."""
    if isinstance(body.outline, Disc):
        away = minus(place, body.centroid)
        return (body.outline.radius * body.outline.radius - dot(away, away)).sign()
    signs = [cross(minus(b, a), minus(place, a)).sign() for a, b in around(body.vertices)]
    return min(signs)


def outward_at(body: Body, place: Vector) -> Vector:
    """A direction out of the body at a place on its edge."""
    if isinstance(body.outline, Disc):
        return minus(place, body.centroid)
    for a, b in around(body.vertices):
        if not cross(minus(b, a), minus(place, a)):
            return b[1] - a[1], a[0] - b[0]
    raise ValueError("required a place on the edge")


def distance_below(body: Body, place: Vector) -> Fraction:
    """A lower bound of the distance of a place from the outline's border; the distance itself where it is rational."""
    if isinstance(body.outline, Disc):
        gap = body.outline.radius.accurate_ball(PRECISION) - _length(minus(place, body.centroid))
        return _short(rational_below(abs(gap)))
    return _root_below(_squared_gap(body, place))


def _squared_gap(body: Body, place: Vector) -> Number:
    """Squared distance of a place from the border of a polygon."""
    return min(_squared_distance(a, b, place) for a, b in around(body.vertices))


def _squared_distance(a: Vector, b: Vector, p: Vector) -> Number:
    """Squared distance of p from the segment."""
    along, away = minus(b, a), minus(p, a)
    ahead, whole = dot(along, away), dot(along, along)
    if ahead.sign() <= 0:
        return dot(away, away)
    if (ahead - whole).sign() >= 0:
        past = minus(p, b)
        return dot(past, past)
    area = cross(along, away)
    return area * area / whole


def free_angle(body: Body, places: Sequence[Vector], margin: Fraction) -> Fraction | None:
    """``min d_i/|q_i|``; wheels that no turn brings nearer to the body than the margin do not count."""
    if isinstance(body.outline, Disc):
        reach = body.outline.radius.accurate_ball(PRECISION) + _length(body.centroid)
    else:
        reach = max(dot(corner, corner) for corner in body.vertices).accurate_ball(PRECISION).sqrt()
    far = reach + arb(fmpq(margin.numerator, margin.denominator))
    turned = [place for place in places if any(place) and not _length(place) > far]
    return min((_turn_below(body, place) for place in turned), default=None)


def _turn_below(body: Body, place: Vector) -> Fraction:
    """A lower bound of ``d/|q|``."""
    if isinstance(body.outline, Disc):
        return _short(distance_below(body, place) / -rational_below(-_length(place)))
    return _root_below(_squared_gap(body, place) / dot(place, place))


def _length(vector: Vector) -> arb:
    """The length of a vector, as a ball."""
    return dot(vector, vector).accurate_ball(PRECISION).sqrt() if any(vector) else arb(0)


def _root_below(squared: Number) -> Fraction:
    """The root of a positive number where it is rational, else a short fraction just below."""
    rational = squared.as_rational()
    if rational is not None:
        above, below = isqrt(int(rational.p)), isqrt(int(rational.q))
        if above * above == rational.p and below * below == rational.q:
            return Fraction(above, below)
    return _short(rational_below(squared.accurate_ball(PRECISION).sqrt()))


def _short(value: Fraction) -> Fraction:
    """A short fraction just below a positive number."""
    exponent = SHORT_BITS - (value.numerator.bit_length() - value.denominator.bit_length())
    scale = Fraction(2) ** exponent
    return Fraction((value * scale).__floor__()) / scale


def free_half_width(body: Body, places: Sequence[Vector], scene: Scene) -> Number:
    """Half-width of the largest square of c in which, at the checked heading, no wheel enters or leaves."""
    if isinstance(body.outline, Disc):
        return scene.field.rational(_short(min(distance_below(body, place) for place in places) * BELOW_ROOT_HALF))
    return min(_half_width_of(body.vertices, place) for place in places)


def _half_width_of(corners: Sequence[Vector], place: Vector) -> Number:
    """How far a square may reach until it brings one wheel across the border of a convex polygon.

    For a side with outward normal m through a: inside, ``m . (place - a) <= -r (|m_x| + |m_y|)`` for every side;
    outside, ``>= r (|m_x| + |m_y|)`` for one of the sides, or of the sides of the square.
    """
    slacks = list(_slacks(corners, place))
    if all(slack.sign() < 0 for slack in slacks):
        return -max(slacks)
    x, y = place
    apart = [
        x - max(corner[0] for corner in corners),
        min(corner[0] for corner in corners) - x,
        y - max(corner[1] for corner in corners),
        min(corner[1] for corner in corners) - y,
    ]
    return max(*slacks, *apart)


def _slacks(corners: Sequence[Vector], place: Vector) -> Iterator[Number]:
    """``m . (place - a)/(|m_x| + |m_y|)`` of every side."""
    for a, b in around(corners):
        along = minus(b, a)
        yield -cross(along, minus(place, a)) / (abs(along[0]) + abs(along[1]))
