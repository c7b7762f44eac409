"""Functions about the origin whose level sets bodies are followed through: the distance, and those of polygons.

On a sector between two rays through the vertices ``w_k`` of a polygon let V be linear with ``V(w_k) = h_k``, so that
it is continuous, positively homogeneous, and has one slope g on each sector.  With ``h_k = 1`` its level sets are the
polygons ``s P``; rings between such polygons are looked at whatever the ``h_k`` are.  A solution of an inclusion
``c' in F(c)`` has ``V' <= -kappa`` where ``g . f <= -kappa`` for all f in F and the slopes g of all closed sectors that
hold the point (Clarke's gradient is their hull).

The distance itself, ``V = |c|`` with ``V' = c . c'/|c|``, is the limit of many vertices, and spares its own bends.

A polygon's vertices have 24 bits, and so have the levels: their products are exact, and neighbouring pieces share
their corners.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, even_angles, following, norms, unit_vectors

SECTORS = 24  # of each ring of circles
VERTICES = 32
BITS = 24  # of levels and vertices
MARGIN = 2.0**-20  # of a radius: corners lie so far beyond a ring of circles, which rounding does not reach
LONGEST = 40.0  # half-axis of an ellipse, over the other one
NEUTRAL = 2.0**-36  # of the fastest mode: floats do not tell slower ones from those that neither grow nor fall


@dataclass(frozen=True)
class RingPieces:
    """Quadrangles that cover rings, the pieces of one ring after the other, and the slope of V on them.

    Attributes:
        corners: counterclockwise (pieces, 4, 2).
        slopes: g at the corners, by x and by y, affine on each quadrangle; (pieces, 4) each.
        moments: ``g . J c``, affine too; (pieces, 4).
        sizes: what ``V'`` is multiplied by, to be ``g . c'``, convex on each quadrangle; (pieces, 4).
        per_ring: pieces of each ring.
    """

    corners: Floats
    slopes: tuple[Intervals, Intervals]
    moments: Intervals
    sizes: Floats
    per_ring: int

    @cached_property
    def middles(self) -> Floats:
        """(pieces, 2)."""
        return self.corners.mean(axis=1)

    @cached_property
    def middle_slopes(self) -> Floats:
        """About the slope g there, (pieces, 2)."""
        return np.stack([slope.middle.mean(axis=1) for slope in self.slopes], axis=1)

    @property
    def turned(self) -> RingPieces:
        """The same for -V."""
        x, y = self.slopes
        return RingPieces(self.corners, (-x, -y), -self.moments, self.sizes, self.per_ring)

    @property
    def halves(self) -> tuple[RingPieces, Mask]:
        """Each cut across its longer sides: the first halves, then the second ones, and which are exact.

        The middle of a side is exact where its corners have bits to spare: otherwise the halves, and neighbours that
        are not cut, may leave a gap between them.
        """
        along, across = (norms(self.corners[:, k] - self.corners[:, 0]) for k in (1, 3))
        order = np.where((along > across)[:, None], [0, 1, 2, 3], [1, 2, 3, 0])
        pieces = np.arange(len(order))[:, None]

        def both(entries: Floats) -> Floats:
            a, b, c, d = np.moveaxis(entries[pieces, order], 1, 0)
            near, far = (a + b) / 2, (d + c) / 2
            return np.concatenate([np.stack([a, near, far, d], axis=1), np.stack([near, b, c, far], axis=1)])

        x, y, moments = (Intervals(both(g.low), both(g.high)).widened for g in (*self.slopes, self.moments))
        a, b, c, d = np.moveaxis(self.corners[pieces, order], 1, 0)
        is_exact = np.tile(_adds_exactly(a, b) & _adds_exactly(d, c), 2)
        return RingPieces(both(self.corners), (x, y), moments, both(self.sizes) * (1 + 2.0**-50), 1), is_exact

    def at(self, chosen: NDArray[np.intp]) -> RingPieces:
        """Some of them."""
        x, y = self.slopes
        slopes = x[chosen], y[chosen]
        return RingPieces(self.corners[chosen], slopes, self.moments[chosen], self.sizes[chosen], self.per_ring)


class LevelFunction(ABC):
    """A function V whose sublevel set of level s holds the disc ``s inside`` and lies in the disc ``s outside``."""

    inside: float
    outside: float

    @abstractmethod
    def pieces(self, inner: Floats, outer: Floats, parts: int = 1) -> RingPieces:
        """Of the rings between levels, (rings) each; the sectors divided into parts, a power of two."""


class Distance(LevelFunction):
    """``V = |c|``."""

    inside = outside = 1.0

    def pieces(self, inner: Floats, outer: Floats, parts: int = 1) -> RingPieces:
        """Neighbours share their corners to the last bit, so that no gap is between them."""
        count = SECTORS * parts
        angles = even_angles(count)
        rays = unit_vectors(angles)
        far = outer * (1 + MARGIN) / math.cos(math.pi / count)
        corners = _quadrangles(rays, inner * (1 - MARGIN), far)
        x, y = (Intervals.of(corners[:, :, k]) for k in range(2))
        sizes = (x.square + y.square).sqrt().high
        return RingPieces(corners, (x, y), Intervals.of(np.zeros_like(sizes)), sizes, count)


@dataclass(frozen=True)
class SectorFunction(LevelFunction):
    """Linear on the sectors between the rays through the vertices.

    Attributes:
        vertices: ``w_k``, counterclockwise about the origin, 24 bits each; (n, 2).
        values: ``h_k``, 24 bits each; (n,).
    """

    vertices: Floats
    values: Floats

    @classmethod
    def of_ellipse(cls, matrix: Floats, count: int = VERTICES) -> SectorFunction:
        """Inscribed in the ellipse ``c . P c = 1``, made as large as holds the unit disc, for a definite P (2 x 2)."""
        angles = even_angles(count)
        circle = np.stack([np.cos(angles), np.sin(angles)])
        vertices = np.linalg.solve(np.linalg.cholesky(matrix).T, circle).T
        unscaled = cls(short_vertices(vertices), np.ones(count))
        return cls(short_vertices(vertices / unscaled.inside), unscaled.values)

    @cached_property
    def slopes(self) -> tuple[Intervals, Intervals]:
        """The slope g on each sector, by x and by y, (n,) each.

        Raises:
            ArithmeticError: where rays do not go counterclockwise.
        """
        (a, b), (c, d) = (
            (Intervals.of(w[:, 0]), Intervals.of(w[:, 1])) for w in (self.vertices, following(self.vertices))
        )
        first, second = Intervals.of(self.values), Intervals.of(following(self.values))
        area = a * d - b * c
        if not (area.low > 0).all():
            raise ArithmeticError("required rays that go counterclockwise")
        inverse = Intervals(1 / area.high, 1 / area.low).widened
        return (first * d - second * b) * inverse, (second * a - first * c) * inverse

    @cached_property
    def inside(self) -> float:  # type: ignore[override]
        """Of the polygon: with all ``h_k = 1`` no slope is longer than one over it."""
        x, y = SectorFunction(self.vertices, np.ones(len(self.vertices))).slopes
        return float(1 / (x.square + y.square).sqrt().high.max()) * (1 - 2.0**-40)

    @cached_property
    def outside(self) -> float:  # type: ignore[override]
        """The largest distance of a vertex."""
        return float(norms(self.vertices).max()) * (1 + 2.0**-40)

    @cached_property
    def sectors(self) -> NDArray[np.intp]:
        """Where V is positive somewhere, (m,)."""
        return np.flatnonzero(np.maximum(self.values, following(self.values)) > 0)

    def pieces(self, inner: Floats, outer: Floats, parts: int = 1) -> RingPieces:
        """Of the sectors where V is positive somewhere; levels must have no more than 24 bits."""
        shares = (np.arange(parts) / parts)[None, :, None]
        ahead = following(self.vertices)[:, None] - self.vertices[:, None]
        every = _quadrangles((self.vertices[:, None] + shares * ahead).reshape(-1, 2), inner, outer)
        corners = every.reshape(len(inner), len(self.vertices), parts, 4, 2)[:, self.sectors].reshape(-1, 4, 2)
        x, y = (_repeated(slope[self.sectors], parts, len(inner)) for slope in self.slopes)
        moments = y * Intervals.of(corners[:, :, 0]) - x * Intervals.of(corners[:, :, 1])
        return RingPieces(corners, (x, y), moments, np.ones(corners.shape[:2]), len(self.sectors) * parts)

    def rays(self, sector: int) -> Floats:
        """The vertices on both sides of a sector (2, 2), counterclockwise."""
        return self.vertices[[sector, (sector + 1) % len(self.vertices)]]


def shapes_about(slope: Floats) -> Iterator[LevelFunction]:
    """The distance, and ellipses on which ``c' = A c`` falls, where it does: by its modes, and by Lyapunov's equation.

    Args:
        slope: about A (2 x 2).
    """
    yield Distance()
    matrix = lyapunov_matrix(slope)
    if matrix is None:
        return
    matrices, (_, modes) = [matrix], np.linalg.eig(slope)
    if abs(np.linalg.det(modes)) > 1 / LONGEST:
        inverse = np.linalg.inv(modes)
        matrices.insert(0, (inverse.conj().T @ inverse).real)
    for matrix in matrices:
        low, high = np.linalg.eigvalsh(matrix)
        if high < LONGEST**2 * low:
            yield SectorFunction.of_ellipse(matrix)


def lyapunov_matrix(slope: Floats) -> Floats | None:
    """P with ``A^T P + P A = -1``; None where floats do not show that all motions ``c' = A c`` fall."""
    roots = np.linalg.eigvals(slope)
    if not (roots.real < -NEUTRAL * np.abs(roots).max()).all():
        return None
    one = np.eye(2)
    system = np.kron(one, slope.T) + np.kron(slope.T, one)
    try:
        return np.asarray(np.linalg.solve(system, -one.ravel()).reshape(2, 2))
    except np.linalg.LinAlgError:  # a shear, whose modes are rounding alone
        return None


def short_levels(levels: Floats, bits: int = BITS) -> Floats:
    """Levels with 24 bits, or fewer."""
    size = 2.0 ** (np.floor(np.log2(levels)) - bits + 1)
    return np.floor(levels / size) * size


def short_vertices(entries: Floats) -> Floats:
    """Vertices or values that are multiples of a power of two, 2^24 of which the largest has."""
    size = 2.0 ** (math.floor(math.log2(np.abs(entries).max())) - BITS + 1)
    return np.round(entries / size) * size


def _quadrangles(rays: Floats, inner: Floats, outer: Floats) -> Floats:
    """(rings times rays, 4, 2)."""
    ahead, near, far = following(rays), inner[:, None, None], outer[:, None, None]
    corners = np.stack([near * rays, far * rays, far * ahead, near * ahead], axis=2)
    return corners.reshape(-1, 4, 2)


def _adds_exactly(a: Floats, b: Floats) -> Mask:
    """Whether sums of points (n, 2) are not rounded (Knuth's two-sum), (n,)."""
    total = a + b
    rest = total - a
    return (((a - (total - rest)) + (b - rest)) == 0).all(axis=1)


def _repeated(slope: Intervals, parts: int, rings: int) -> Intervals:
    """(n,) as (rings times n times parts, 4)."""
    low, high = (np.tile(np.repeat(ends, parts), rings)[:, None] for ends in (slope.low, slope.high))
    return Intervals(np.repeat(low, 4, axis=1), np.repeat(high, 4, axis=1))


# ---- quadrangles with rational corners that cover rings about the origin -------------------------
#
# The rays of all quadrangles are multiples of the same rational directions, so that neighbours leave no gap between
# them.


Place: TypeAlias = tuple[Fraction, Fraction]

INSIDE = 1 - Fraction(1, 2**20)  # of a radius: a ray's direction is longer than one by no more than rounding
OUTSIDE = 1 + Fraction(1, 2**20)


@dataclass(frozen=True)
class AnnulusPiece:
    """A quadrangle that holds the part of a ring ``inner <= |c| <= outer`` in a sector.

    Attributes:
        inner: smaller radius of the ring.
        outer: larger radius of the ring.
        start: first ray of the sector, as a share of a full turn.
        width: of the sector, as a share of a full turn.
    """

    inner: Fraction
    outer: Fraction
    start: Fraction
    width: Fraction

    @property
    def corners(self) -> tuple[Place, ...]:
        """Counterclockwise.

        Raises:
            ArithmeticError: where rounding leaves a part of the ring outside.
        """
        first, last = ray(self.start), ray(self.start + self.width)
        near = self.inner * INSIDE
        far = self.outer * OUTSIDE * Fraction(1 / math.cos(math.pi * float(self.width)))
        if max(_square(first), _square(last)) * INSIDE**2 > 1 or not side_is_outside(far, first, last, self.outer):
            raise ArithmeticError("required a quadrangle that holds its part of the ring")
        return _times(near, first), _times(far, first), _times(far, last), _times(near, last)

    @property
    def parts(self) -> Iterator[AnnulusPiece]:
        """Four parts that cover the same part of the ring."""
        middle, half = (self.inner + self.outer) / 2, self.width / 2
        for inner, outer in ((self.inner, middle), (middle, self.outer)):
            for start in (self.start, self.start + half):
                yield AnnulusPiece(inner, outer, start, half)


CORNERS = 16  # of a polygon about a disc


def polygon_about(radius: Fraction) -> tuple[Place, ...]:
    """The corners of a polygon that holds a disc about the origin: those of a ring on its outer side.

    Raises:
        ArithmeticError: where rounding leaves a part of the disc outside.
    """
    return tuple(piece.corners[1] for piece in ring(radius / 2, radius, CORNERS))


def ring(inner: Fraction, outer: Fraction, sectors: int) -> Iterator[AnnulusPiece]:
    """Pieces that cover a ring."""
    width = Fraction(1, sectors)
    for k in range(sectors):
        yield AnnulusPiece(inner, outer, k * width, width)


@lru_cache(maxsize=4096)
def ray(share: Fraction) -> Place:
    """A rational direction of length about one, at a share of a full turn."""
    angle = 2 * math.pi * float(share % 1)
    return Fraction(math.cos(angle)), Fraction(math.sin(angle))


def side_is_outside(far: Fraction, first: Place, last: Place, radius: Fraction) -> bool:
    """Whether the side between two points ``far`` along their rays is no nearer than a radius."""
    (a, b), (c, d) = _times(far, first), _times(far, last)
    area = a * d - b * c
    return area > 0 and area * area >= radius * radius * _square((c - a, d - b))


def _times(factor: Fraction, place: Place) -> Place:
    return factor * place[0], factor * place[1]


def _square(place: Place) -> Fraction:
    return place[0] ** 2 + place[1] ** 2
