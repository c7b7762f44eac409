"""The plane with exact numbers: chains that go around once, convex polygons, and ellipses that they hold."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cmp_to_key
from itertools import pairwise
from typing import Any, TypeAlias

from .tower import Number, Vector, charge, cross, dot
from .work import require


def around(values: Sequence[Any]) -> list[tuple[Any, Any]]:
    """Neighbours in a closed chain."""
    return list(pairwise([*values, values[0]]))


def turns_once(steps: Iterable[tuple[Vector, Vector]]) -> bool:
    """Whether counterclockwise steps, each of less than a half turn, that return to their start go around once.

    They do iff they pass from the lower half plane into the upper one exactly once.
    """
    entries = 0
    for step in steps:
        before, after = ((v[1].sign() or v[0].sign()) > 0 for v in step)
        entries += after > before
    return entries == 1


def convex_hull(places: Sequence[Vector]) -> list[Vector]:
    """The corners of the convex hull of plane points, counterclockwise (Andrew's monotone chain)."""
    ordered = sorted(places, key=cmp_to_key(_compare_places))
    if len(ordered) < 3:
        return ordered
    return [*_half_hull(ordered), *_half_hull(ordered[::-1])]


def _compare_places(a: Vector, b: Vector) -> int:
    return (a[0] - b[0]).sign() or (a[1] - b[1]).sign()


def _half_hull(ordered: Sequence[Vector]) -> list[Vector]:
    """The corners below the line from the first point to the last, without the last one."""
    chain: list[Vector] = []
    for place in ordered:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], place) <= 0:
            chain.pop()
        chain.append(place)
    return chain[:-1]


def _turn(a: Vector, b: Vector, c: Vector) -> int:
    """Sign of the turn from a over b to c, positive to the left."""
    return cross((b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1])).sign()


# ---- convex polygons by their sides, in whole numbers ---------------------------------------------

Side: TypeAlias = tuple[int, int, int]  # a, b, c of a x + b y <= c
Point: TypeAlias = tuple[int, int, int]  # X, Y, W of (X/W, Y/W), W > 0


def corners(sides: Sequence[Side]) -> list[Point]:
    """Where each side of a convex polygon ends, and the next one counterclockwise starts.

    There the polygon turns left by less than a half turn, because sides have lengths and it has an area: so ``W > 0``.
    """
    return [(c * e - f * b, a * f - d * c, a * e - d * b) for (a, b, c), (d, e, f) in around(sides)]


def clipped(sides: list[Side], half_planes: Iterable[Side]) -> list[Side]:
    """The part of a convex polygon in half planes; no sides where it has no area.

    Sides that reach into a half plane remain, and its own line follows the one on which the polygon leaves it.
    """
    for line in half_planes:
        if not sides:
            break
        charge(40 * len(sides))
        a, b, c = line
        ends = [a * x + b * y - c * w for x, y, w in corners(sides)]
        if max(ends) <= 0:
            continue
        polygon: list[Side] = []
        for side, start, end in zip(sides, [ends[-1], *ends[:-1]], ends, strict=True):
            polygon += [side] if min(start, end) < 0 else []
            polygon += [line] if start < 0 <= end else []
        sides = polygon
    return sides


# ---- ellipses ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Form:
    """A quadratic form ``c^T P c`` that is positive off the origin, by ``P = [[p, q], [q, s]]``.

    Raises:
        RejectedError: for another one.
    """

    p: Number
    q: Number
    s: Number

    def __post_init__(self) -> None:
        require(self.p.sign() > 0 and self.determinant.sign() > 0, "a positive quadratic form")

    @property
    def determinant(self) -> Number:
        """Of P."""
        return self.p * self.s - self.q * self.q

    @property
    def spread(self) -> Number:
        """The squared difference of the eigenvalues of P."""
        gap = self.p - self.s
        return gap * gap + (self.q + self.q) * (self.q + self.q)

    def image(self, c: Vector) -> Vector:
        """``P c``."""
        return self.p * c[0] + self.q * c[1], self.q * c[0] + self.s * c[1]

    def at(self, c: Vector) -> Number:
        """``c^T P c``."""
        return dot(self.image(c), c)

    def scaled(self, factor: Number) -> Form:
        """A multiple by a positive number."""
        return Form(self.p * factor, self.q * factor, self.s * factor)

    def is_at_most(self, bound: Number) -> bool:
        """Whether ``c^T P c <= bound |c|^2`` everywhere."""
        return _is_not_negative(bound - self.p, self.q, bound - self.s)

    def is_at_least(self, bound: Number) -> bool:
        """Whether ``c^T P c >= bound |c|^2`` everywhere."""
        return _is_not_negative(self.p - bound, self.q, self.s - bound)

    def margins(self, level: Number, sides: Iterable[tuple[Vector, Vector]], *, whole: bool = True) -> list[int]:
        """For each side from a to b, points ``(X, Y, W)``: whether ``c^T P c <= level`` stays left of it.

        1 where it does, 0 where it touches it, else -1; of the ``whole`` line, or of the side alone.  With the step
        ``e = b - a`` the least value on the line is ``det P (a x b)^2/(e^T P e)``.  The form grows along the side
        where ``c . P e >= 0``: so on the side it is least at a or at b, or there, if that changes its sign between.
        """
        margins = []
        for a, b in sides:
            step = (b[0] * a[2] - a[0] * b[2], b[1] * a[2] - a[1] * b[2])
            reach, grows = cross(a, b), self.image(step)
            spare = self.determinant * reach * reach - level * dot(grows, step)
            left, right = dot(grows, a).sign(), dot(grows, b).sign()
            if not whole and (left >= 0 or right <= 0):
                end = a if left >= 0 else b
                spare = self.at(end) - level * end[2] * end[2]
            margins.append(min(reach.sign(), spare.sign()))
        return margins


def _is_not_negative(p: Number, q: Number, s: Number) -> bool:
    """Whether ``[[p, q], [q, s]]`` is positive semidefinite."""
    return min(p.sign(), s.sign(), (p * s - q * q).sign()) >= 0


def outweighs(inward: Number, outward: Number, square: Number) -> bool:
    """Whether ``inward >= |outward| sqrt(square)``, by signs of numbers without that root; ``square >= 0``."""
    return inward.sign() >= 0 and (inward * inward - outward * outward * square).sign() >= 0
