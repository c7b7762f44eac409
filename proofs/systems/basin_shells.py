"""A region in three states: polyhedra about the point, nested along rays, between which a continuous W rises.

All polyhedra have corners on the same rays, so that what lies between two of them are prisms over triangles of a
sphere, each of three tetrahedra; W is the number of the polyhedron.  On a tetrahedron with three corners on one of them
the gradient of W is the normal of this side, so velocities f must lead inward over all sides, and over planes that
are parallel to an edge of each polyhedron.

*Shapes.*  With the linear part A of the velocities at the point, and z the displacement in units in which ``z'z`` falls
fast along ``z' = A z``, polyhedra follow the level sets of the integral of ``-2 z'A z`` along solutions, which is
``z'z`` near the point: floats integrate it from places on the rays.  Near the border of the basin velocities are nearly
along these sets, too nearly for a polyhedron of few sides.  So a corner whose tetrahedra would fail goes only a part of
its way, or hardly any, while the others go on.  What is proposed here is shown by theorem ``basin`` of the checker.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.systems.basin_rings import FloatField, Floats

INSIDE = 0.98  # of the largest ellipsoid in the level set: the first polyhedron
SHIFT = 0.5  # of the slowest rate of decay: how much faster than the given field the one of the ellipsoid grows
REACH = 16.0  # of rays, in units of the first polyhedron
RATIO = 1.4  # of levels of the integral, one after the other
STEP, STEPS, FAR = 0.03, 2_500, 60.0  # of paths: length over the distance from the point, how many, how far away
UNSEEN = 0.3  # of the way between places on a ray beyond which no integral is known
HALVINGS, WIDELY, CRAWLS, STOPS = 18, 6, 9, 13  # rounds; from which on neighbours, tenths, and no way at all
CRAWL = 2.0**-18  # of its distance: what a corner moves at least
MARGIN, SMALL = 2.0**-10, 2.0**-30  # of rates, against the sizes of both vectors
STILL, PAUSE = 1.05, 3  # growth of the volume, over some polyhedra, below which there is an end
BITS = 36  # of coordinates

Triples = NDArray[np.int64]


@dataclass(frozen=True)
class ShellEffort:
    """What a search may cost.

    Attributes:
        frequency: parts of an edge of the icosahedron.
        places: on a ray.
        shells: at most.
        starts: in a row of those that are sampled.
    """

    frequency: int
    places: int
    shells: int
    starts: int


EFFORTS = {"fast": ShellEffort(6, 36, 8, 13), "best": ShellEffort(14, 90, 24, 21)}


# ---- a sphere of triangles -----------------------------------------------------------------------


def geodesic_sphere(frequency: int) -> tuple[Floats, Triples]:
    """The corners and the triangles, counterclockwise from outside, of a divided icosahedron on the unit sphere."""
    golden = (1 + 5**0.5) / 2
    corners = [np.roll((0.0, s, t * golden), k) for k in range(3) for s in (-1, 1) for t in (-1, 1)]
    near = [(i, j, k) for i in range(12) for j in range(i) for k in range(j) if _is_side(corners, i, j, k)]
    numbers: dict[tuple[tuple[int, int], ...], int] = {}
    places, triangles = list[Floats](), list[tuple[int, int, int]]()

    def number(weights: Sequence[tuple[int, int]]) -> int:
        key = tuple((corner, weight) for corner, weight in weights if weight)
        if key not in numbers:
            numbers[key] = len(places)
            place = sum(weight * corners[corner] for corner, weight in key)
            places.append(np.asarray(place / np.linalg.norm(place)))
        return numbers[key]

    for a, b, c in near:

        def at(i: int, j: int, own: tuple[int, int, int] = (a, b, c)) -> int:
            return number(tuple(zip(own, (i, j, frequency - i - j), strict=True)))

        for i in range(frequency):
            for j in range(frequency - i):
                triangles.append((at(i + 1, j), at(i, j + 1), at(i, j)))
                if i + j + 1 < frequency:
                    triangles.append((at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)))
    sphere, found = np.array(places), np.array(triangles)
    inward = np.linalg.det(sphere[found]) < 0
    found[inward] = found[inward][:, ::-1]
    return sphere, found


def _is_side(corners: Sequence[Floats], *own: int) -> bool:
    return all(np.linalg.norm(corners[i] - corners[j]) < 2.1 for i in own for j in own)


def tetrahedra_between(triangles: Triples, count: int) -> Triples:
    """Those of the prisms between two polyhedra, of positive size; corners of the outer one come after all others.

    A prism is cut at the diagonals from its lower numbers inside to its higher numbers outside, as its neighbours are.
    """
    is_even = np.linalg.det(np.eye(3)[np.argsort(triangles, axis=1)]) > 0
    a, b, c = np.sort(triangles, axis=1).T
    found = []
    for own in ((a, b, c, c + count), (a, b, c + count, b + count), (a, a + count, b + count, c + count)):
        corners = np.stack(own, axis=1)
        corners[~is_even] = corners[~is_even][:, [1, 0, 2, 3]]
        found.append(corners)
    return np.concatenate(found)


# ---- level sets of the integral ------------------------------------------------------------------


class Rays:
    """Places on rays, with the integral from each.

    Args:
        field: of a system in three states that does not switch.
        inside: which places are in the level set that attracts.
        within: half the side of a cube that holds this.
        limit: half the side of a cube that no path may leave; None without one.
        effort: of the search.
    """

    def __init__(
        self,
        field: FloatField,
        inside: Callable[[Floats], NDArray[np.bool_]],
        within: float,
        limit: float | None,
        effort: ShellEffort,
    ) -> None:
        self.field, self.limit = field, np.inf if limit is None else limit
        self.sphere, self.triangles = geodesic_sphere(effort.frequency)
        linear = self._linear_part(1e-4 * within)
        units = unit_ball(linear)
        distances = np.array([_reach(own, inside, within) for own in self.sphere @ units.T])
        self.units = units * INSIDE * distances.min()
        self.directions = self.sphere @ self.units.T
        self.back = np.linalg.inv(self.units)
        own = self.back @ linear @ self.units
        self.loss = -(own + own.T)
        self.distances = np.geomspace(1.0, REACH, effort.places)
        self.integrals = self._integrals()

    def _linear_part(self, size: float) -> Floats:
        steps = size * np.eye(3)
        return np.asarray((self.field.at(steps)[0] - self.field.at(-steps)[0]).T / (2 * size))

    def _rate(self, z: Floats) -> Floats:
        return np.asarray(self.field.at(z @ self.units.T)[0] @ self.back.T)

    def _lost(self, z: Floats) -> Floats:
        return np.asarray(np.einsum("ij,jk,ik->i", z, self.loss, z))

    def _integrals(self) -> Floats:
        """From all places, until paths are in the ball of size one: shape (distances, rays); infinite where unknown."""
        z = (self.distances[:, None, None] * self.sphere).reshape(-1, 3)
        total, found, left = np.zeros(len(z)), np.full(len(z), np.inf), np.arange(len(z))
        with np.errstate(all="ignore"):
            for _ in range(STEPS):
                sizes = np.linalg.norm(z, axis=1)
                done = sizes <= 1
                found[left[done]] = total[left[done]] + sizes[done] ** 2
                kept = ~done & (sizes < FAR) & (np.abs(z @ self.units.T).max(axis=1) <= self.limit)
                z, left, sizes = z[kept], left[kept], sizes[kept]
                if not len(left):
                    break
                first = self._rate(z)
                dt = STEP * sizes / np.linalg.norm(first, axis=1)
                step = dt[:, None]
                second = self._rate(z + step / 2 * first)
                middle = z + step / 2 * second
                third = self._rate(middle)
                after = z + step / 6 * (first + 2 * second + 2 * third + self._rate(z + step * third))
                total[left] += dt / 6 * (self._lost(z) + 4 * self._lost(middle) + self._lost(after))
                z = after
        return found.reshape(len(self.distances), -1)

    def where(self, level: float) -> Floats:
        """The distances on all rays at which the integral first is a level; the last place where it never is."""
        above = self.integrals >= level
        high = np.where(above.any(axis=0), above.argmax(axis=0), len(self.distances) - 1)
        low, rays = np.maximum(high - 1, 0), np.arange(len(high))
        first, last = np.log(self.integrals[low, rays]), np.log(self.integrals[high, rays])
        share = np.full(len(rays), UNSEEN)
        known = np.isfinite(last) & (last > first)
        share[known] = (np.log(level) - first[known]) / (last - first)[known]
        return np.asarray(self.distances[low] ** (1 - (s := np.clip(share, 0, 1))) * self.distances[high] ** s)


def unit_ball(linear: Floats) -> Floats:
    """Units U in which a ball shrinks at a good angle along ``x' = A x``, with ``x = U z``.

    ``P = (U U')^-1`` has ``(A + s I)' P + P (A + s I) = -I``, where s is a part of the slowest rate.
    """
    from scipy.linalg import solve_continuous_lyapunov

    slowest = -float(np.linalg.eigvals(linear).real.max())
    shifted = linear + SHIFT * slowest * np.eye(len(linear))
    weights = solve_continuous_lyapunov(shifted.T, -np.eye(len(linear)))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(weights).T))


def _reach(ray: Floats, inside: Callable[[Floats], NDArray[np.bool_]], within: float) -> float:
    """How many times a vector leads to where a set is left first, on its way out of a cube."""
    shares = np.linspace(0, 1, 513)[1:] * within / float(np.abs(ray).max())
    left = ~inside(shares[:, None] * ray)
    return float(shares[max(int(left.argmax()) - 1, 0)] if left.any() else shares[-1])


# ---- polyhedra -----------------------------------------------------------------------------------


class Shells:
    """Polyhedra, each with the distances of its corners on all rays.

    Args:
        rays: with their integrals.
        most: polyhedra that are proposed, beside the first.
    """

    def __init__(self, rays: Rays, most: int) -> None:
        self.rays, self.most = rays, most
        self.count = len(rays.sphere)
        self.between = tetrahedra_between(rays.triangles, self.count)
        ends = np.concatenate([rays.triangles[:, [0, 1]], rays.triangles[:, [1, 2]]])
        self.edges = np.unique(np.sort(ends, axis=1), axis=0)

    def grown(self, announce: Callable[[int, int], None]) -> list[Floats]:
        """Polyhedra from the first one on, as few as serve, on whose shells floats see W fall."""
        found = [np.ones(self.count)]
        highest = float(np.max(self.rays.integrals, where=np.isfinite(self.rays.integrals), initial=1.0))
        levels = RATIO ** np.arange(1, np.log(highest) / np.log(RATIO) + 1)
        for number, level in enumerate(levels):
            announce(number, len(levels))
            after = self._toward(found[-1], self.rays.where(float(level)))
            if after is None:
                break
            found.append(after)
            if len(found) > PAUSE and self.volume(after) < STILL * self.volume(found[-1 - PAUSE]):
                break
        return self._thinned(found)

    def _toward(self, before: Floats, aim: Floats) -> Floats | None:
        """A polyhedron whose corners go as far toward their aims as W falls; None where that is not found."""
        shares, least = np.ones(self.count), before * (1 + CRAWL)
        for round_ in range(HALVINGS):
            after = np.maximum(before + shares * (aim - before), least)
            failing = self._failing(before, after, MARGIN if round_ < CRAWLS else SMALL)
            if not failing.any():
                return after
            hit = np.zeros(self.count, dtype=bool)
            hit[self.between[failing].ravel() % self.count] = True
            if round_ >= WIDELY:
                hit[self.edges[hit[self.edges].any(axis=1)].ravel()] = True
            shares[hit] *= 0.5 if round_ < CRAWLS else 0.1 if round_ < STOPS else 0.0
        return None

    def _thinned(self, found: Sequence[Floats]) -> list[Floats]:
        """Some of the polyhedra: from each one the farthest of a few that serves as the next."""
        kept, here, step = [0], 0, 4
        while here < len(found) - 1 and len(kept) <= self.most:
            step = min(2 * step, len(found) - 1 - here)
            while step > 1 and self._failing(found[here], found[here + step], MARGIN / 16).any():
                step = 2 * step // 3
            here += max(step, 1)
            kept.append(here)
        return [found[k] for k in kept]

    def _failing(self, inner: Floats, outer: Floats, margin: float) -> NDArray[np.bool_]:
        """The tetrahedra between two polyhedra on which floats do not see W fall."""
        places = np.concatenate([self.places(inner), self.places(outer)])[self.between]
        sizes, slopes = gradients(places, (self.between >= self.count).astype(float))
        good = sizes > 0
        for velocities, points in self.rays.field.velocities((), places):
            rates = points.coefficients(np.einsum("mkd,md->mk", velocities, slopes))
            scale = np.linalg.norm(velocities, axis=2).max(axis=1) * np.linalg.norm(slopes, axis=1)
            good &= rates.max(axis=1) < -margin * scale
        return np.asarray(~good)

    def places(self, distances: Floats) -> Floats:
        """The corners of a polyhedron, in the displacement from the point."""
        return np.asarray(distances[:, None] * self.rays.directions)

    def volume(self, distances: Floats) -> float:
        """Of a polyhedron."""
        return float(np.linalg.det(self.places(distances)[self.rays.triangles]).sum() / 6)

    def record(self, found: Sequence[Floats]) -> dict[str, Any]:
        """The mesh between polyhedra, as a certificate holds it: W is 0, 1, 2 and so on."""
        power = BITS - int(np.ceil(np.log2(float(np.abs(self.places(found[-1])).max()))))
        corners, tetrahedra = list[str](), list[str]()
        for value, distances in enumerate(found):
            whole = np.rint(self.places(distances) * 2.0**power).astype(np.int64)
            corners += [f"{x} {y} {z} {value}" for x, y, z in whole.tolist()]
        for number in range(len(found) - 1):
            listed = (self.between + number * self.count).tolist()
            tetrahedra += [" ".join(map(str, own)) for own in listed]
        unit = f"1/{2**power}" if power >= 0 else str(2**-power)
        return {"unit": unit, "corners": corners, "tetrahedra": tetrahedra}


def gradients(places: Floats, heights: Floats) -> tuple[Floats, Floats]:
    """Six times the sizes of tetrahedra, and the gradients of affine functions on them, times these.

    Args:
        places: their corners, shape (tetrahedra, 4, 3).
        heights: the values there, shape (tetrahedra, 4).
    """
    a, b, c = (places[:, k] - places[:, 0] for k in (1, 2, 3))
    rises = heights[:, 1:] - heights[:, :1]
    normals = [np.cross(b, c), np.cross(c, a), np.cross(a, b)]
    slopes = sum(rises[:, k, None] * own for k, own in enumerate(normals))
    return np.asarray((a * normals[0]).sum(axis=1)), np.asarray(slopes)


def inside_polyhedron(sides: Floats, x: Floats) -> NDArray[np.bool_]:
    """Which places lie in a polyhedron that all rays from the point leave once.

    Args:
        sides: their corners, shape (sides, 3, 3).
        x: places, shape (places, 3).
    """
    weights = np.linalg.inv(sides.transpose(0, 2, 1))
    found = np.zeros(len(x), dtype=bool)
    for part in _parts(len(x), 400):
        own = np.einsum("tij,pj->pti", weights, x[part])
        beneath = (own >= -1e-12).all(axis=2) & (own.sum(axis=2) < 1)
        found[part] = beneath.any(axis=1)
    return found


def _parts(count: int, size: int) -> Iterator[slice]:
    return (slice(k, k + size) for k in range(0, count, size))
