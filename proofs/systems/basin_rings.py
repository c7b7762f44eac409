"""Rings that grow from a level set backward in time, in floats: what they propose a mesh proves.

A ring is a closed polygon, counterclockwise, over which all velocities f lead inward: ``n . f < 0`` for its outward
normal n.  Rings move by ``dx/du = -R f s / |x|^p``; where R is the identity they are level sets of the integral of
``|x|^p / s`` along solutions, with p = 0 of the time.  Where parts of a ring come to the border of a basin long before
others, rings that follow each other are too near there for triangles; another p may then do better.  The positive
factor s is zero on the border of a square that no ring may leave: where rings come near it they lie along it, and grow
elsewhere.

Near the border of a basin f is nearly along these rings, too nearly for a polygon of few sides.
So R turns f by an angle toward n: f then meets all rings at that angle at least, and they tend to the border of the
basin of the turned field, which is smaller (the rotated vector fields of Duff 1953).  A smaller angle gives a larger
basin, and asks for sides that are shorter in proportion.

Errors here, such as those of interpolated points, cost share and never soundness.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, partial
from itertools import accumulate, product
from math import factorial, prod
from operator import mul
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.checker.basin import Plane
from nonsmooth.proofs.checker.cells import Pattern, System
from nonsmooth.proofs.checker.formulas import Formula
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.findings import Record
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    Mask,
    are_finite,
    cross,
    finite_rows,
    following,
    max_norm,
    max_norms,
    row_norms,
    row_products,
    turned,
    unit_rows,
    unit_vectors,
)

FUNCTIONS = {"sin": np.sin, "cos": np.cos, "tanh": np.tanh, "atan": np.arctan}
PAUSE, GROWTH = 1.0, 1.0015  # of a ring's size, between looks at the area; by which this must grow
BEND = 0.15  # of a side: interpolation that bends more is not believed
FOLD = 0.2  # sine of the angle between f and n below which f is turned less
PHASE = 2.0  # in radians: sines and cosines need as many points over it as a ring of this size has
WIDTH = 2.0**-20  # of a ring: of differences
APART = 2.0**-10  # of a side: as near to a corner no other one is put
UNFOLDED = 5  # times that points are left out at which a ring turns back
INSIDE = 0.9  # of the certified level: the first ring
STARTS = 400  # points of the first ring
TURNS, SHARP = 20, 0.8  # within half a step, of a start that stays somewhere else; cosines of these are below
ALONG_SIDE = 5  # places on a side at which floats look whether velocities lead over it
SLOW = 2.0**-10  # rate of decay, against the largest entry: a slower one is none
SMALL = 2.0**-40  # of the largest: what is as small counts as zero, for either sign


@dataclass(frozen=True)
class RingGrowth:
    """How rings grow.

    Attributes:
        angle: by which velocities are turned outward, in radians.
        gap: between neighbours on a ring, of its size.
        move: of the size of a ring, by which the fastest of its points moves in a step.
    """

    angle: float
    gap: float
    move: float


class FieldInCells(Protocol):
    """The velocities of an inclusion with cells at many places, in floats."""

    @property
    def surfaces(self) -> Sequence[Polynomial]:
        """Those of which the lines are worth having corners of triangles on them."""

    def at(self, x: Floats) -> Floats:
        """The velocities at places, those of one cell where several meet: shape (right-hand sides, places, 2)."""

    @property
    def scale(self) -> float:
        """A length over which velocities of one cell change little; infinite for polynomials."""

    def velocities(self, cell: Any, triangles: Floats) -> Iterator[tuple[Floats, Bernstein]]:
        """Polynomial fields that have those of a cell in their hull, at the nodes of triangles."""

    def slides(self, ring: Floats) -> tuple[NDArray[np.int64], Floats, Floats]:
        """Where a ring crosses lines along which solutions slide: after which points, the places, and velocities."""

    def meeting(self, triangles: Floats, exact: Mapping[int, Floats]) -> Iterator[tuple[Any, Mask]]:
        """Each cell with the triangles whose inside it may meet.

        Args:
            triangles: their corners, shape (triangles, 3, 2).
            exact: of some surfaces, by their numbers, their values at the corners without error, up to a factor.
        """


@dataclass(frozen=True)
class FloatField:
    """The velocities of all right-hand sides, and the switching surfaces, at many places.

    Attributes:
        plane: the cells of the system, in its own lengths.
    """

    plane: Plane

    @classmethod
    def of(cls, system: System, surfaces: Sequence[str]) -> FloatField:
        """That of a system which switches on surfaces in the displacement."""
        return cls(Plane(system, "1", list(surfaces), Proofs({})))

    @property
    def surfaces(self) -> Sequence[Polynomial]:
        """All on which the system switches."""
        return self.plane.surfaces.listed

    def crossings(self, ring: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
        """Sides over which one surface alone changes its sign: its number, the first point, and about where."""
        guards = self.guards(ring)
        after = following(guards)
        changes = (guards >= 0) != (after >= 0)
        alone = changes & (changes.sum(axis=1) == 1)[:, None]
        rows, numbers = np.nonzero(alone)
        shares = guards[rows, numbers] / (guards[rows, numbers] - after[rows, numbers])
        return numbers, rows, np.asarray(ring[rows] + shares[:, None] * (following(ring) - ring)[rows])

    def slides(self, ring: Floats) -> tuple[NDArray[np.int64], Floats, Floats]:
        """Where a ring crosses surfaces to which the velocities of both sides lead, with the mixtures along these."""
        numbers, rows, places = self.crossings(ring)
        if not len(rows) or len(self.at(ring[:1])) > 1:
            return rows[:0], places[:0], places[:0]
        f, h = (self.beside(ends, places)[0] for ends in (ring[rows], following(ring)[rows]))
        width = WIDTH * max_norm(ring)
        rises = [self.guards(places + step) - self.guards(places - step) for step in np.eye(2) * width]
        slopes = np.stack(rises, axis=2)[np.arange(len(rows)), numbers]
        normals = np.where(self.guards(ring)[rows, numbers] >= 0, -1, 1)[:, None] * slopes
        mixed, slides = mixtures(f, h, normals)
        return rows[slides], places[slides], mixed[slides]

    @property
    def scale(self) -> float:
        """A length over which no sine or cosine changes much; infinite without any."""
        arguments = [v for side in self.plane.waves for _, v in side]
        slopes = [float(np.hypot(float(v.slope(0)), float(v.slope(1)))) for v in arguments]
        return PHASE / max(slopes, default=0.0) if any(slopes) else np.inf

    def velocities(self, cell: Pattern, triangles: Floats) -> Iterator[tuple[Floats, Bernstein]]:
        """Polynomial fields that have those of a cell in their hull, at the nodes of triangles.

        Sines and cosines lie between affine functions, as the checker bounds them (:mod:`..checker.waves`).
        """
        for k, side in enumerate(self.plane.sides(cell)):
            still, *moved = (max(polynomial.degree for polynomial in part) for part in side.parts)
            count, states = triangles.shape[1:]
            points = bernstein(max([still, *(degree + 1 for degree in moved)]), count)
            at, corners = points.places(triangles), triangles.reshape(-1, states)
            bounds = []
            for (_, v), wave in zip(self.plane.waves[k], self.waves(k, corners), strict=True):
                arguments = values(v, corners).reshape(len(triangles), count)
                error = (arguments.max(axis=1) - arguments.min(axis=1)) ** 2 / 8
                mean = points.weights(wave.reshape(len(triangles), count))
                bounds.append([(mean + sign * error[:, None]).ravel() for sign in (-1, 1)])
            for waves in product(*bounds):
                yield self.side(cell, k, at.reshape(-1, states), waves).reshape(at.shape), points

    def meeting(self, triangles: Floats, exact: Mapping[int, Floats]) -> Iterator[tuple[Pattern, Mask]]:
        """Each cell with the triangles whose inside it may meet: all surfaces may have its signs there.

        Likewise for tetrahedra, and for triangles in space.
        """
        listed = self.surfaces
        if not listed:
            yield (), np.ones(len(triangles), dtype=bool)
            return
        points = bernstein(max(surface.degree for surface in listed), triangles.shape[1])
        at = points.places(triangles)
        guards = self.guards(at.reshape(-1, at.shape[2])).reshape(*at.shape[:2], len(listed))
        allowed = np.empty((len(triangles), len(listed), 2), dtype=bool)
        for number in range(len(listed)):
            if number in exact:
                coefficients, slack = exact[number], 0.0
            else:
                coefficients = points.coefficients(guards[:, :, number])
                slack = SMALL * max_norm(coefficients)
            allowed[:, number] = np.stack([coefficients.min(axis=1) < -slack, coefficients.max(axis=1) > slack], axis=1)
            if slack:
                allowed[:, number] |= np.abs(coefficients).min(axis=1)[:, None] <= slack
        groups: list[tuple[Pattern, Mask]] = [((), np.ones(len(triangles), dtype=bool))]
        for number in range(len(listed)):
            more = [
                ((*signs, s), here & allowed[:, number, k]) for signs, here in groups for k, s in enumerate((-1, 1))
            ]
            groups = [(signs, here) for signs, here in more if here.any()]
        yield from groups

    def guards(self, x: Floats) -> Floats:
        """The values of the surfaces: shape (places, surfaces)."""
        return self._guards(x).T if self.surfaces else np.zeros((len(x), 0))

    @cached_property
    def _guards(self) -> Callable[[Floats], Floats]:
        return together(self.surfaces)

    def on(self, signs: Pattern, x: Floats) -> Floats:
        """The velocities that a cell has, wherever the places are: shape (right-hand sides, places, states)."""
        sides = range(len(self.plane.sides(signs)))
        return np.stack([self.side(signs, k, x, self.waves(k, x)) for k in sides])

    def side(self, signs: Pattern, number: int, x: Floats, waves: Sequence[Floats]) -> Floats:
        """The velocities of one right-hand side for some values of its sines and cosines: shape (places, states)."""
        still, *moved = self._parts(signs, number)(x)
        return still + sum(wave[:, None] * part for wave, part in zip(waves, moved, strict=True))

    @cached_property
    def _parts(self) -> Callable[[Pattern, int], Callable[[Floats], Floats]]:
        """For the signs of a cell and the number of a right-hand side polynomials: shape (parts, places, states)."""

        @cache
        def made(signs: Pattern, number: int) -> Callable[[Floats], Floats]:
            parts = self.plane.sides(signs)[number].parts
            at = together([polynomial for part in parts for polynomial in part])
            return lambda x: at(x).reshape(len(parts), -1, len(x)).transpose(0, 2, 1)

        return made

    def waves(self, number: int, x: Floats) -> list[Floats]:
        """The sines and cosines of one right-hand side at places."""
        return [FUNCTIONS[name](at(x)[0]) for name, at in self._arguments[number]]

    @cached_property
    def _arguments(self) -> list[list[tuple[str, Callable[[Floats], Floats]]]]:
        return [[(name, together([v])) for name, v in side] for side in self.plane.waves]

    def at(self, x: Floats) -> Floats:
        """The velocities at places, those of one cell where several meet: shape (right-hand sides, places, states)."""
        return self.beside(x, x)

    def beside(self, x: Floats, ends: Floats) -> Floats:
        """The velocities that the cells of places have at other places."""
        guards = self.guards(x)
        if not guards.shape[1]:
            return self.on((), ends)
        velocities = None
        for signs, here in by_pattern(np.where(guards >= 0, 1, -1)):
            cell_velocities = self.on(signs, ends[here])
            velocities = np.zeros((len(cell_velocities), *x.shape)) if velocities is None else velocities
            velocities[:, here] = cell_velocities
        if velocities is None:
            raise ValueError("required a place")
        return velocities


def mixtures(below: Floats, above: Floats, normals: Floats) -> tuple[Floats, Mask]:
    """The mixtures along surfaces of velocities on both sides, and where both velocities lead to the surface.

    With the parts a and b of velocities f and h along the normal, which leads upward, it is ``(b f - a h) / (b - a)``.
    """
    a, b = row_products(normals, below), row_products(normals, above)
    slides = (a > 0) & (b < 0)
    return (b[:, None] * below - a[:, None] * above) / np.where(slides, b - a, 1)[:, None], slides


def by_pattern(signs: NDArray[np.int64]) -> Iterator[tuple[Pattern, Mask]]:
    """Each pattern among rows of signs, and where it is: by a number for each, which are sorted faster than rows."""
    numbers = (signs > 0) @ (1 << np.arange(signs.shape[1]))
    for number in np.unique(numbers):
        here = numbers == number
        yield tuple(signs[here.argmax()].tolist()), here


class Bernstein:
    """Values at the points of a simplex's lattice, and Bernstein coefficients from these."""

    def __init__(self, degree: int, corners: int) -> None:
        self.degree = degree
        chosen = product(range(degree, -1, -1), repeat=corners)
        powers = np.array([exponents for exponents in chosen if sum(exponents) == degree])[::-1]
        self.nodes = powers / degree if degree else np.full((1, corners), 1 / corners)
        columns = []
        for exponents in powers:
            weight = factorial(degree) / prod(factorial(k) for k in exponents)
            columns.append(weight * (self.nodes**exponents).prod(axis=1))
        self.inverse = np.linalg.inv(np.stack(columns, axis=1))

    def places(self, triangles: Floats) -> Floats:
        """The points at which a polynomial is looked at: shape (simplices, nodes, states)."""
        return self.nodes @ triangles

    def weights(self, at_corners: Floats) -> Floats:
        """The affine functions with some values at the corners, of shape (simplices, corners), at these points."""
        return at_corners @ self.nodes.T

    def coefficients(self, at_nodes: Floats) -> Floats:
        """From values of shape (triangles, nodes)."""
        return at_nodes @ self.inverse.T


@cache
def bernstein(degree: int, corners: int = 3) -> Bernstein:
    """Of polynomials of a degree, on simplices with some corners."""
    return Bernstein(degree, corners)


def together(polynomials: Sequence[Polynomial]) -> Callable[[Floats], Floats]:
    """Polynomials of the checker in floats, by the powers that they share: at places, shape (polynomials, places)."""
    exponents = sorted({key for p in polynomials for key in p.terms}) or [(0,) * polynomials[0].count]
    weights = np.array([[float(p.terms.get(key, 0)) for key in exponents] for p in polynomials])
    top = max(max(key) for key in exponents)

    def at(x: Floats) -> Floats:
        powers = list(accumulate([x.T] * top, mul))
        terms = np.ones((len(exponents), len(x)))
        for number, key in enumerate(exponents):
            for k, e in enumerate(key):
                if e:
                    terms[number] *= powers[e - 1][k]
        return weights @ terms

    return at


def gradients(places: Floats, heights: Floats) -> tuple[Floats, Floats]:
    """The sizes of simplices in d states, times d!, and the gradients of affine functions on them, times these.

    Args:
        places: their corners, shape (simplices, d + 1, d).
        heights: the values there, shape (simplices, d + 1).
    """
    count, _, states = places.shape
    edges, rises = np.zeros((3, count, 3)), np.zeros((3, count))
    edges[2, :, 2] = 1  # a triangle is the base of a prism of height 1, along which the function is constant
    edges[:states, :, :states] = (places[:, 1:] - places[:, :1]).transpose(1, 0, 2)
    rises[:states] = (heights[:, 1:] - heights[:, :1]).T
    normals = np.stack([np.cross(edges[k - 2], edges[k - 1]) for k in range(3)])
    slopes = (rises[:, :, None] * normals).sum(axis=0)
    return row_products(edges[0], normals[0]), slopes[:, :states]


def falls(field: FieldInCells, places: Floats, slopes: Floats, margin: float, exact: Mapping[int, Floats]) -> Mask:
    """On which simplices a function is seen to fall for the fields of all cells that they may meet.

    Args:
        field: the velocities.
        places: the corners of the simplices, or of sides in space.
        slopes: the gradient of the function on each, or the outward normal of each side.
        margin: of the rate at which it falls, against the sizes of both vectors.
        exact: as :meth:`FieldInCells.meeting` has it.
    """
    good = np.ones(len(places), dtype=bool)
    for cell, here in field.meeting(places, exact):
        for velocities, points in field.velocities(cell, places[here]):
            rates = points.coefficients(np.einsum("mkd,md->mk", velocities, slopes[here]))
            sizes = np.linalg.norm(velocities, axis=2).max(axis=1) * row_norms(slopes[here])
            good[here] &= rates.max(axis=1) < -margin * sizes
    return good


def values(polynomial: Polynomial, x: Floats) -> Floats:
    """A polynomial of the checker at places."""
    return together([polynomial])(x)[0]


def area(ring: Floats) -> float:
    """Of a polygon, positive where it is counterclockwise."""
    after = following(ring)
    return float(np.sum(cross(ring, after)) / 2)


class AttractedLevel:
    """Where a V that falls is below a level, on the square or cube on which that is shown, in floats.

    Attributes:
        potential: V.
        level: a part of the certified one, at which polyhedra begin.
        within: half the side of the cube.
    """

    def __init__(self, system: System, local: Record) -> None:
        self.potential = _potential(system, local)
        self.level, self.within = INSIDE * float(Fraction(local["level"])), float(Fraction(local["cells"]["within"]))

    def __call__(self, x: Floats) -> Mask:
        """Which places are there."""
        return (self.potential(x) < self.level) & (max_norms(x) <= self.within)

    def reach(self, rays: Floats) -> Floats:
        """How many times vectors lead to where V first is the level; NaN where it is not on the way out of the cube."""
        near, far = np.zeros(len(rays)), np.full(len(rays), np.nan)
        for share in np.linspace(0, 1, 65)[1:]:
            here = share * self.within / max_norms(rays)
            above = self.potential(rays * here[:, None]) >= self.level
            far = np.where(np.isnan(far) & above, here, far)
            near = np.where(np.isnan(far), here, near)
        for _ in range(40):
            middle = (near + far) / 2
            above = self.potential(rays * middle[:, None]) >= self.level
            near, far = np.where(above, near, middle), np.where(above, middle, far)
        return np.where(np.isnan(far), np.nan, near)


def _potential(system: System, local: Record) -> Callable[[Floats], Floats]:
    """V in floats: one formula, or one for each of some patterns of signs; infinite where it is not known."""
    function, field = local["function"], FloatField.of(system, local["cells"]["surfaces"])
    place, near = field.plane.domain.displacement, field.plane

    def sign_patterns(x: Floats) -> NDArray[np.int64]:
        return np.where(field.guards(x) >= 0, 1, -1)

    @cache
    def piece(signs: Pattern) -> Polynomial | None:
        for mark, formula in [["", function]] if isinstance(function, str) else function:
            if all(m == "." or "-+".index(m) * 2 - 1 == s for m, s in zip(mark, signs, strict=False)):
                return Formula(formula, place).on(partial(near.surfaces.sign_on, signs))
        return None

    def potential(x: Floats) -> Floats:
        heights = np.full(len(x), np.inf)
        for signs, here in by_pattern(sign_patterns(x)):
            polynomial = piece(signs)
            if polynomial is not None:
                heights[here] = values(polynomial, x[here])
        return heights

    return potential


def level_ring(field: FloatField, home: AttractedLevel) -> Floats | None:
    """Where V first is a level on rays from the point, within a square; None where it is not on all of them.

    There are rays to where the level set crosses surfaces, too: it may have corners there.
    """
    rays = unit_vectors(np.linspace(0, 2 * np.pi, STARTS, endpoint=False))
    ring = rays * home.reach(rays)[:, None]
    if np.isnan(ring).any():
        return None
    _, rows, places = field.crossings(ring)
    gaps = row_norms(places - ring[rows]), row_norms(places - following(ring)[rows])
    apart = np.minimum(*gaps) > APART * (gaps[0] + gaps[1])
    directions = (unit_rows(places))[apart]
    rays = np.insert(unit_rows(ring), rows[apart] + 1, directions, axis=0)
    ring = rays * home.reach(rays)[:, None]
    return None if np.isnan(ring).any() else ring


def grow(
    field: FieldInCells,
    ring: Floats,
    pace: RingGrowth,
    limit: float,
    most: int,
    way: float,
    announce: Callable[[int, int], None],
    power: int = 2,
) -> Iterator[Floats]:
    """Rings from the first one on, until they grow no more; each is made when it is asked for.

    Args:
        field: of the system.
        ring: the first one.
        pace: of them.
        limit: half the side of a square that no ring leaves.
        most: points of a ring.
        way: of its fastest points, in multiples of its size, at most.
        announce: told the number of steps that are done, and of all.
        power: p of the speed ``f / |x|^p``.
    """
    yield ring
    before, steps, pause = area(ring), round(way / pace.move), round(PAUSE / pace.move)
    for step in range(1, steps):
        announce(step, steps)
        ring = next_ring(field, ring, pace, limit, power)
        if not are_finite(ring) or max_norm(ring) > limit or area(ring) <= 0:
            return
        if len(ring) > most:
            return
        yield ring
        if step % pause == 0:
            if area(ring) < GROWTH * before:
                return
            before = area(ring)


def next_ring(field: FieldInCells, ring: Floats, pace: RingGrowth, limit: float, power: int) -> Floats:
    """One step of Runge and Kutta backward in time, in which each point keeps its right-hand side and its turn."""
    size = float(lengths(ring).max())
    along = following(ring) - np.roll(ring, 1, axis=0)
    normals = -turned(along)
    chords = lengths(normals)
    normals /= np.where(chords == 0, 1, chords)[:, None]  # a ring may fold onto itself
    velocities = field.at(ring)
    speeds = lengths(velocities) + np.finfo(float).tiny
    outward = np.einsum("kij,ij->ki", velocities, normals) / speeds
    chosen = outward.argmax(axis=0)  # the one that leads least inward
    rows = np.arange(len(ring))
    v, speed = velocities[chosen, rows], speeds[chosen, rows]
    turn = pace.angle * np.clip(cross(v, normals) / speed / FOLD, -1, 1)
    c, s = np.cos(turn), np.sin(turn)

    def backward(x: Floats) -> Floats:
        all_fields = field.at(x)
        f, g = (all_fields[0] if len(all_fields) == 1 else all_fields[chosen, rows]).T
        return -np.stack([c * f - s * g, s * f + c * g], axis=1) * slower(x)[:, None]

    def slower(x: Floats) -> Floats:
        room = np.clip(1 - (x / limit) ** 2, 0, 1)
        return room[:, 0] * room[:, 1] / lengths(x) ** power

    first = backward(ring)
    du = pace.move * size / float(lengths(first).max())
    second = backward(ring + du / 2 * first)
    third = backward(ring + du / 2 * second)
    fourth = backward(ring + du * third)
    moved = ring + du / 6 * (first + 2 * second + 2 * third + fourth)
    after, places, slides = field.slides(ring)
    tips = places - du * (1 - pace.angle) * slides * slower(places)[:, None]
    is_tip = np.insert(np.zeros(len(ring), dtype=bool), after + 1, np.ones(len(after), dtype=bool))
    return _spaced(*_unfolded(np.insert(moved, after + 1, tips, axis=0), is_tip), pace.gap * min(size, field.scale))


def _unfolded(ring: Floats, is_tip: Mask) -> tuple[Floats, Mask]:
    """A ring without the points at which it turns back, but for its tips, on lines along which solutions slide; both.

    Where velocities on both sides of a border lead away from it, points of a ring come to it from both sides, and
    overshoot.  Where they lead to it, points go away from it on both sides; the tip between them goes along the line.
    """
    for _ in range(UNFOLDED):
        after = following(ring) - ring
        turns_back = (row_products(after, np.roll(after, 1, axis=0)) < 0) & ~is_tip
        if not turns_back.any() or turns_back.sum() > len(ring) - 3:
            break
        ring, is_tip = ring[~turns_back], is_tip[~turns_back]
    return ring, is_tip


def _spaced(ring: Floats, is_tip: Mask, gap: float) -> Floats:
    """A ring with points between those that are far apart, and without some of those that are near each other."""
    for _ in range(3):
        after, sides = following(ring), _sides(ring)
        wide = sides > gap
        if not wide.any():
            break
        straight = (ring + after) / 2
        bent = (9 * (ring + after) - np.roll(ring, 1, axis=0) - np.roll(ring, -2, axis=0)) / 16
        believed = lengths(bent - straight) < BEND * sides
        middle = np.where(believed[:, None], bent, straight)
        ring = np.insert(ring, np.nonzero(wide)[0] + 1, middle[wide], axis=0)
        is_tip = np.insert(is_tip, np.nonzero(wide)[0] + 1, False)
    crowded = (_sides(ring) < gap / 6) & ~is_tip
    crowded[::2] = False  # never two neighbours
    return ring[~crowded]


def _sides(ring: Floats) -> Floats:
    return lengths(following(ring) - ring)


def lengths(x: Floats) -> Floats:
    """Of vectors in the plane, which stand in the last axis."""
    return np.sqrt(x[..., 0] ** 2 + x[..., 1] ** 2)


def sines(field: FieldInCells, ring: Floats, sides: Floats | None = None) -> Floats:
    """The least sine of the angle at which velocities lead to the right over sides from corners, as floats see it."""
    sides = following(ring) - ring if sides is None else sides
    normals = -turned(sides)
    places = ring + np.linspace(0, 1, ALONG_SIDE)[:, None, None] * sides
    velocities = field.at(places.reshape(-1, 2)).reshape(-1, *places.shape)
    across = (velocities * normals).sum(axis=-1)
    sizes = np.linalg.norm(velocities, axis=-1) * row_norms(normals)
    return (across / np.where(sizes == 0, 1, sizes)).min(axis=(0, 1))


def followed_home(field: FieldInCells, starts: Floats, home: Callable[[Floats], Mask], far: float) -> Mask:
    """Which starts come to where ``home`` is true before they are farther away than some distance, in floats.

    Steps have a length in proportion to the distance from the point; of several right-hand sides the first is taken.
    Where nothing switches, who turns sharply within many a step stays around another place of rest.
    """
    x, came, alive = starts.copy(), home(starts), np.ones(len(starts), dtype=bool)
    turns = np.zeros(len(starts), dtype=np.int64)
    for _ in range(4_000):
        todo = np.nonzero(alive & ~came)[0]
        if not len(todo):
            break
        here = x[todo]
        first = field.at(here)[0]
        step = 0.02 * row_norms(here) / (row_norms(first) + np.finfo(float).tiny)
        second = field.at(here + step[:, None] / 2 * first)[0]
        x[todo] = here + step[:, None] * second
        came[todo] = home(x[todo])
        alive[todo] = finite_rows(x[todo]) & (row_norms(x[todo]) < far)
        if not field.surfaces:
            sizes = row_norms(first) * row_norms(second)
            turns[todo] += row_products(first, second) < SHARP * sizes
            alive &= turns < TURNS
    return came


def inside_ring(ring: Sequence[Sequence[float]] | Floats, x: Floats) -> Mask:
    """Which places a polygon goes around."""
    inside = np.zeros(len(x), dtype=bool)
    corners = np.asarray(ring, dtype=float)
    for (ax, ay), (bx, by) in zip(corners, following(corners), strict=True):
        if ay == by:
            continue
        crosses = (ay > x[:, 1]) != (by > x[:, 1])
        inside ^= crosses & (x[:, 0] < ax + (x[:, 1] - ay) / (by - ay) * (bx - ax))
    return inside


def unit_ball(linear: Floats, share: float) -> Floats:
    """Units U in which balls shrink along ``x' = A x``, with ``x = U z``, by about a share s of the slowest rate r.

    ``P = (U U')^-1`` has ``(A + s r I)' P + P (A + s r I) = -I``.  Where a rate is nearly zero, these are the units of
    the states.
    """
    from scipy.linalg import solve_continuous_lyapunov

    slowest, one = -float(np.linalg.eigvals(linear).real.max()), np.eye(len(linear))
    if not slowest > SLOW * max_norm(linear):
        return one
    form = solve_continuous_lyapunov((linear + share * slowest * one).T, -one)
    return np.linalg.inv(np.linalg.cholesky(form).T)


def lattice_unit(power: int) -> str:
    """The unit ``2^-power`` of corners in whole numbers, as a certificate holds it."""
    return str(1 / Fraction(2) ** power)
