"""Headings at which wheels come under the edge of a body whose centre of mass stays where it is, as balls.

A wheel at ``q = p - c`` from the centre of mass is on the line of a side with outward unit normal n and height h, in
the body's own frame, iff ``n . R(theta)^T q = h``, so iff ::

    theta = arg(q) - arg(n) +- acos(h/|q|)

and on a circle of radius R about m iff ``theta = arg(q) - arg(m) +- acos((|q|^2 + |m|^2 - R^2)/(2 |q| |m|))``.
Between two such headings that follow each other the same wheels carry the body.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import arb

from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.numbers.enclosures import PRECISION
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector, around, cross, dot, minus
from nonsmooth.symbolic.numbers.rounded import Rounded

BallVector: TypeAlias = tuple[arb, arb]


@dataclass(frozen=True)
class EdgeHeading:
    """A heading at which one wheel lies under the edge.

    Attributes:
        wheel: its place in the list of wheels.
        theta: encloses the heading, in radians from the checked one, within half a turn of zero but for its radius.
    """

    wheel: int
    theta: arb


class BallOutline:
    """The outline of a body in balls, turned to the checked heading; to be used at one working precision."""

    def __init__(self, body: Body) -> None:
        self.middle: BallVector = _ball_of(body.centroid)
        self.radius: arb | None = None
        self.normals: list[BallVector] = []
        self.heights: list[arb] = []
        if isinstance(body.outline, Disc):
            self.radius = ball_of(body.outline.radius)
            return
        for a, b in around(body.vertices):
            along = minus(b, a)
            length = ball_of(dot(along, along)).sqrt()
            self.normals.append((ball_of(along[1]) / length, -ball_of(along[0]) / length))
            self.heights.append(ball_of(cross(a, b)) / length)  # n . a, as cross(a, b - a) = cross(a, b)

    def edge_headings(self, wheel: int, place: BallVector) -> Iterator[EdgeHeading]:
        """All headings at which a wheel at ``q`` may lie under the edge; none is missing."""
        reach = length_of(place)
        for side, (share, direction) in enumerate(self._lines(place, reach)):
            for theta in _headings(place, direction, share):
                if self.radius is not None or not self._is_beyond(side, seen(place, theta)):
                    yield EdgeHeading(wheel, theta)

    def side_of(self, place: BallVector) -> int:
        """1 for a place that is certainly under the outline, seen from the body; -1 if it is certainly not, else 0."""
        slacks = self.slacks(place)
        if all(slack > 0 for slack in slacks):
            return 1
        return -1 if any(slack < 0 for slack in slacks) else 0

    def slacks(self, place: BallVector) -> list[arb]:
        """``h_e - n_e . q`` of every side; ``R - |q - m|`` of a disc."""
        if self.radius is not None:
            return [self.radius - length_of(minus(place, self.middle))]
        return [height - dot(normal, place) for normal, height in zip(self.normals, self.heights, strict=True)]

    def _lines(self, place: BallVector, reach: arb) -> Iterator[tuple[arb, BallVector]]:
        """Cosine of the angle between the wheel and a direction of the body at which it lies on each line or circle."""
        if self.radius is None:
            yield from ((height / reach, n) for n, height in zip(self.normals, self.heights, strict=True))
            return
        offset = length_of(self.middle)
        excess = dot(place, place) + dot(self.middle, self.middle) - self.radius * self.radius
        yield excess / (2 * reach * offset), self.middle

    def _is_beyond(self, side: int, place: BallVector) -> bool:
        """Whether a place on the line of a side is certainly not on the side itself."""
        return any(slack < 0 for k, slack in enumerate(self.slacks(place)) if k != side)


def _headings(place: BallVector, direction: BallVector, share: arb) -> list[arb]:
    """``arg(q) - arg(n) +- acos(share)``; one wide ball where it is not certain that the circle meets the line."""
    if share > 1 or share < -1 or not share.is_finite():
        return []
    between = arb.atan2(cross(direction, place), dot(direction, place))
    if share < 1 and share > -1:
        half = share.acos()
        return [_within_half_a_turn(between - half), _within_half_a_turn(between + half)]
    if share > 0:
        reach = arb(min(share.lower(), arb(1))).acos() if share.lower() < 1 else arb(0)
        return [_within_half_a_turn(between + arb(0, reach.upper()))]
    reach = (-arb(max(share.upper(), arb(-1)))).acos() if share.upper() > -1 else arb(0)
    return [_within_half_a_turn(between + arb.pi() + arb(0, reach.upper()))]


def _within_half_a_turn(angle: arb) -> arb:
    """The angle without full turns."""
    turns = ((angle / (2 * arb.pi())).mid() + arb(1) / 2).floor().mid()
    return angle - 2 * arb.pi() * turns


def seen(place: BallVector, theta: arb) -> BallVector:
    """``R(theta)^T q``: a place as the body sees it."""
    s, c = theta.sin_cos()
    return c * place[0] + s * place[1], c * place[1] - s * place[0]


def length_of(vector: BallVector) -> arb:
    """Euclidean length."""
    return (dot(vector, vector)).sqrt()


def ball_of(value: Number) -> arb:
    """A ball about a number, accurate even where it is small."""
    return value.accurate_ball(PRECISION) if isinstance(value, Rounded) or value else arb(0)


def _ball_of(vector: Vector) -> BallVector:
    return ball_of(vector[0]), ball_of(vector[1])


def places_of(positions: Sequence[Vector], centre: Vector) -> list[BallVector]:
    """``p_i - c`` as balls."""
    return [_ball_of(minus(position, centre)) for position in positions]


@dataclass(frozen=True)
class HeadingCluster:
    """A heading with wheels under the edge, or several that the balls do not tell apart.

    Attributes:
        theta: encloses them, in radians from the checked heading.
        edges: the wheels, each once for every side that it lies under.
    """

    theta: arb
    edges: tuple[EdgeHeading, ...]

    @property
    def wheels(self) -> tuple[int, ...]:
        """Places of the wheels in the list of wheels, ascending."""
        return tuple(sorted({edge.wheel for edge in self.edges}))

    def merged(self, theta: arb, edges: Sequence[EdgeHeading]) -> HeadingCluster:
        """With what overlaps it."""
        return HeadingCluster(self.theta.union(theta), (*self.edges, *edges))


@dataclass(frozen=True)
class Gap:
    """An open interval of headings without a wheel under the edge.

    Attributes:
        low: encloses its lower end, in radians from the checked heading.
        high: encloses its upper end; above ``low``, perhaps beyond half a turn.
        ends: places, in the list of wheels, of those under the edge at the lower and at the upper end.
    """

    low: arb
    high: arb
    ends: tuple[tuple[int, ...], tuple[int, ...]]


def clusters(headings: Sequence[EdgeHeading]) -> list[HeadingCluster]:
    """Headings in ascending order, within one turn; those whose balls overlap count as one."""
    ordered: list[HeadingCluster] = []
    for edge in sorted(headings, key=lambda one: float(one.theta.mid())):
        if ordered and ordered[-1].theta.overlaps(edge.theta):
            ordered[-1] = ordered[-1].merged(edge.theta, [edge])
        else:
            ordered.append(HeadingCluster(edge.theta, (edge,)))
    turn = 2 * arb.pi()
    if len(ordered) > 1 and ordered[-1].theta.overlaps(ordered[0].theta + turn):
        first = ordered.pop(0)
        ordered[-1] = ordered[-1].merged(first.theta + turn, first.edges)
    return ordered


def gaps(ordered: Sequence[HeadingCluster]) -> list[Gap]:
    """From every cluster to the next, around; one full turn where there are none."""
    if not ordered:
        return [Gap(-arb.pi(), arb.pi(), ((), ()))]
    first = HeadingCluster(ordered[0].theta + 2 * arb.pi(), ordered[0].edges)
    pairs = zip(ordered, [*ordered[1:], first], strict=True)
    return [Gap(low.theta, high.theta, (low.wheels, high.wheels)) for low, high in pairs]
