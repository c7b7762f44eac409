"""A region in three states: polyhedra about the point, nested along rays, between which a continuous W rises.

All polyhedra have corners on the same rays, so that what lies between two of them are prisms over triangles of a
sphere, each of three tetrahedra; W is the number of the polyhedron.  On a tetrahedron with three corners on one of them
the gradient of W is the normal of this side, so velocities f must lead inward over all sides, and over planes that
are parallel to an edge of each polyhedron.  What is proposed here is shown by theorem ``basin`` of the checker.

*Growth.*  Polyhedra begin as an ellipsoid in the level set that attracts.  A ray then goes as far as a place from which
the field, disturbed by a part a of its speed along the outward normal, leads into the polyhedron before.  In the limit
of small steps such fronts meet the field at an angle of at least ``arcsin a``, as sides of some size need it; so they
tend to the border of the basin under disturbances.  They are also made smoother than that, do not grow by more than a
part of their size at once, and slow down near a cube: as long as a front does not move where the angle is too small, it
meets the field well.  Where a side would not do all of its corners stay, and the front goes on without them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.systems.basin_rings import Bernstein, FloatField, Floats, bernstein

INSIDE = 0.98  # of the largest ellipsoid in the level set: the first polyhedron
SHIFT = 0.5  # of the slowest rate of decay: how much faster than the given field the one of the ellipsoid grows
SMALLER, WIDER = 20, 2.0  # times that the ellipsoid gets smaller by a fifth; of it, a cube that polyhedra do not leave
SLOW = 2.0**-10  # rate of decay, against the largest entry: a slower one is none
PATH = 0.25  # of the distance from the point: a step along the field
BLUNT, SMOOTHINGS = 0.5, 4  # part of the mean of neighbours that corners become, and how often
SLOWEST = 0.25  # part of their way that corners go at least for all that
MARGIN, SMALL = 2.0**-8, 2.0**-13  # of rates on sides, and on tetrahedra, against the sizes of both vectors
HALVINGS, WIDELY, ROUNDS = 3, 6, 40  # of the way of corners beside a bad side; then they stay, and then neighbours, too
STILL = 2.0**-12  # mean growth of a polyhedron at which there is an end
AHEAD = (64, 48, 32, 24, 16, 12, 8, 6, 4, 3, 2, 1)  # polyhedra, of which the farthest that serves is the next
MENDINGS, FEW, MENDED = 16, 0.02, 0.3  # rounds; bad tetrahedra at most; of the way that their corners go
TOGETHER = 1000  # tetrahedra that are looked at, before others are
APART = 2.0**-24  # of their sizes: what polyhedra are apart at least
BITS = 40  # of coordinates

Triples = NDArray[np.int64]


@dataclass(frozen=True)
class ShellEffort:
    """What a search may cost.

    Attributes:
        frequency: parts of an edge of the icosahedron.
        disturbances: parts a of the speed, tried in turn.
        growth: of a front in a step, at most.
        steps: of a front, at most.
        shells: at most.
        starts: in a row of those that are sampled.
    """

    frequency: int
    disturbances: tuple[float, ...]
    growth: float
    steps: int
    shells: int
    starts: int


EFFORTS = {
    "fast": ShellEffort(6, (0.1,), 0.02, 160, 10, 9),
    "best": ShellEffort(10, (0.06, 0.12), 0.02, 250, 20, 15),
}


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


# ---- fronts --------------------------------------------------------------------------------------


class Front:
    """Polyhedra with corners on rays, each by the logarithms of the distances of its corners.

    Args:
        field: of a system in three states that does not switch.
        inside: which places are in the level set that attracts.
        within: half the side of a cube that holds this.
        limit: half the side of a cube that no polyhedron should leave; a wider one serves where they begin in that.
        effort: of the search.
    """

    def __init__(
        self,
        field: FloatField,
        inside: Callable[[Floats], NDArray[np.bool_]],
        within: float,
        limit: float,
        effort: ShellEffort,
    ) -> None:
        self.field, self.effort = field, effort
        self.sphere, self.triangles = geodesic_sphere(effort.frequency)
        self.count = len(self.sphere)
        units = unit_ball(self._linear_part(2.0**-12 * within))
        self.units = units * INSIDE * min(_reach(own, inside, within) for own in self.sphere @ units.T)
        for _ in range(SMALLER):
            if not self._bad_sides(np.zeros(self.count)).any():
                break
            self.units = 0.8 * self.units
        self.back = np.linalg.inv(self.units)
        self.limit = max(limit, WIDER * float(np.abs(self.rays).max()))
        self.between = tetrahedra_between(self.triangles, self.count)
        ends = np.concatenate([self.triangles[:, own] for own in ([0, 1], [1, 2], [0, 2])])
        self.edges = np.unique(np.sort(ends, axis=1), axis=0)

    @property
    def rays(self) -> Floats:
        """The corners of the first polyhedron."""
        return np.asarray(self.sphere @ self.units.T)

    def _linear_part(self, size: float) -> Floats:
        steps = size * np.eye(3)
        return np.asarray((self.field.at(steps)[0] - self.field.at(-steps)[0]).T / (2 * size))

    def grown(self, announce: Callable[[int, int], None]) -> list[Floats]:
        """Polyhedra from the first one on, as few as serve, on whose shells floats see W fall."""
        best, tries = [np.zeros(self.count)], self.effort.disturbances
        for number, part in enumerate(tries):
            steps, found = self.effort.steps, [np.zeros(self.count)]
            for step in range(steps):
                announce(number * steps + step, len(tries) * steps)
                after = self._after(found[-1], part)
                growth = float((after - found[-1]).mean())
                found.append(after)
                if growth < STILL:
                    break
            kept = self._thinned(found)
            if self.volume(kept[-1]) > self.volume(best[-1]):
                best = kept
        return best

    def _after(self, before: Floats, part: float) -> Floats:
        """The next polyhedron: corners of bad sides go only a part of their way, or none."""
        way, shares = self._aim(before, part) - before, np.ones(self.count)
        for round_ in range(ROUNDS):
            after = before + shares * way
            bad = self._bad_sides(after)
            if not bad.any():
                return np.asarray(after)
            hit = np.zeros(self.count, dtype=bool)
            hit[self.triangles[bad].ravel()] = True
            if round_ >= WIDELY:
                hit[self.edges[hit[self.edges].any(axis=1)].ravel()] = True
            shares[hit] *= 0.5 if round_ < HALVINGS else 0.0
        return before

    def _aim(self, before: Floats, part: float) -> Floats:
        """How far rays go if the disturbed field is to lead into a polyhedron, made smoother."""
        normals, most = self._normals(before), self.effort.growth
        near, far = (self._outside(before, before + own, normals, part) for own in (0.0, most))
        share = np.where(far <= 0, 1.0, -near / np.where(far > near, far - near, np.inf))
        aim = before + most * np.clip(share, 0, 1)
        smooth = aim
        for _ in range(SMOOTHINGS):
            total = np.bincount(self.edges.ravel(), smooth[self.edges[:, ::-1]].ravel())
            mean = total / np.bincount(self.edges.ravel())
            smooth = np.minimum(smooth, (1 - BLUNT) * smooth + BLUNT * mean)
        return np.maximum(smooth, SLOWEST * aim + (1 - SLOWEST) * before)

    def _outside(self, before: Floats, start: Floats, normals: Floats, part: float) -> Floats:
        """How far outside of a polyhedron the disturbed field leads from places on rays, as a logarithm."""
        z = np.exp(start)[:, None] * self.sphere
        middle = z + PATH / 2 * self._course(z, normals, part)
        end = z + PATH * self._course(middle, normals, part)
        return np.asarray(np.log(np.linalg.norm(end, axis=1)) - self._toward(before, end))

    def _course(self, z: Floats, normals: Floats, part: float) -> Floats:
        """The disturbed field, of a speed that is the distance from the point, less near the limit."""
        places = z @ self.units.T
        field = self.field.at(places)[0] @ self.back.T
        course = field / (np.linalg.norm(field, axis=1)[:, None] + np.finfo(float).tiny) + part * normals
        room = np.clip(1 - (np.abs(places).max(axis=1) / self.limit) ** 4, 0, 1)
        return np.asarray(course * (room * np.linalg.norm(z, axis=1))[:, None])

    def _normals(self, logarithms: Floats) -> Floats:
        """Outward at each corner, in the units of the sphere: the mean over its sides by their areas."""
        corners = (np.exp(logarithms)[:, None] * self.sphere)[self.triangles]
        sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        weights = np.repeat(sides, 3, axis=0)
        total = np.stack([np.bincount(self.triangles.ravel(), weights[:, k]) for k in range(3)], axis=1)
        return np.asarray(total / np.linalg.norm(total, axis=1)[:, None])

    @cached_property
    def _middles(self) -> Any:
        """The middles of the triangles of the sphere, to look for the nearest."""
        from scipy.spatial import cKDTree

        middles = self.sphere[self.triangles].mean(axis=1)
        return cKDTree(middles / np.linalg.norm(middles, axis=1)[:, None])

    @cached_property
    def _weights(self) -> Floats:
        """Of each triangle of the sphere what the weights of its corners are of a place in its cone."""
        return np.asarray(np.linalg.inv(self.sphere[self.triangles].transpose(0, 2, 1)))

    def _toward(self, logarithms: Floats, z: Floats) -> Floats:
        """The logarithm of the distance of a polyhedron in the directions of places, between its corners."""
        units = z / np.linalg.norm(z, axis=1)[:, None]
        near = self._middles.query(units, k=3)[1]
        weights = np.einsum("pkij,pj->pki", self._weights[near], units)
        rows = np.arange(len(z))
        chosen = weights.min(axis=2).argmax(axis=1)
        own = np.clip(weights[rows, chosen], 0, None)
        corners = self.triangles[near[rows, chosen]]
        return np.asarray((logarithms[corners] * own).sum(axis=1) / own.sum(axis=1))

    @cached_property
    def _on_sides(self) -> Bernstein:
        """For polynomials of the field's degree; sines and cosines are taken for cubic ones."""
        parts = [part for side in self.field.plane.sides(()) for part in side.parts]
        degrees = [max(own.degree for own in part) for part in parts]
        return bernstein(max([*degrees[:1], *(own + 3 for own in degrees[1:])]))

    def _bad_sides(self, logarithms: Floats) -> NDArray[np.bool_]:
        """Over which sides the field is not seen to lead inward."""
        corners = self.places(logarithms)[self.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        places = np.einsum("kc,mcd->mkd", self._on_sides.nodes, corners)
        bad = np.zeros(len(corners), dtype=bool)
        for velocities in self.field.at(places.reshape(-1, 3)):
            own = velocities.reshape(places.shape)
            rates = self._on_sides.coefficients(np.einsum("mkd,md->mk", own, normals))
            scale = np.linalg.norm(own, axis=2).max(axis=1) * np.linalg.norm(normals, axis=1)
            bad |= rates.max(axis=1) > -MARGIN * scale
        return bad

    def _thinned(self, found: Sequence[Floats]) -> list[Floats]:
        """Some of the polyhedra, a little apart: after each one the farthest of a few that serves as the next."""
        apart = [own + APART * number for number, own in enumerate(found)]
        kept, here = [apart[0]], 0
        while here < len(found) - 1 and len(kept) <= self.effort.shells:
            for number in dict.fromkeys(min(here + step, len(found) - 1) for step in AHEAD):
                few = FEW if number > here + 1 else 1.0
                margin = SMALL / (1 + len(kept) / self.effort.shells)  # corners that stay need ever less
                after = self._mended(kept[-1], np.maximum(apart[number], kept[-1] + APART), few, margin)
                if after is not None:
                    break
            else:
                break
            kept.append(after)
            here = number
        return kept

    def _mended(self, inner: Floats, outer: Floats, few: float, margin: float) -> Floats | None:
        """An outer polyhedron of which few corners go a part of their way only, so that W falls; None without one."""
        shares, most = np.ones(self.count), few * len(self.between)
        touched = np.arange(len(self.between))
        for _ in range(MENDINGS):
            after = np.maximum(inner + shares * (outer - inner), inner + APART)
            failing = np.zeros(len(self.between), dtype=bool)
            for part in (touched[own] for own in _parts(len(touched), TOGETHER)):
                failing[part] = self._failing(inner, after, margin, self.between[part])
                if failing.sum() > most:
                    return None
            if not failing.any():
                return np.asarray(after)
            slower = np.zeros(self.count, dtype=bool)
            slower[self.between[failing].ravel() % self.count] = True
            shares[slower] *= MENDED
            touched = np.nonzero(slower[self.between % self.count].any(axis=1))[0]
        return None

    def _failing(self, inner: Floats, outer: Floats, margin: float, own: Triples) -> NDArray[np.bool_]:
        """Those of some tetrahedra between two polyhedra on which floats do not see W fall."""
        places = np.concatenate([self.places(inner), self.places(outer)])[own]
        sizes, slopes = gradients(places, (own >= self.count).astype(float))
        good = sizes > 0
        for velocities, points in self.field.velocities((), places):
            rates = points.coefficients(np.einsum("mkd,md->mk", velocities, slopes))
            scale = np.linalg.norm(velocities, axis=2).max(axis=1) * np.linalg.norm(slopes, axis=1)
            good &= rates.max(axis=1) < -margin * scale
        return np.asarray(~good)

    def places(self, logarithms: Floats) -> Floats:
        """The corners of a polyhedron, in the displacement from the point."""
        return np.asarray(np.exp(logarithms)[:, None] * self.rays)

    def volume(self, logarithms: Floats) -> float:
        """Of a polyhedron."""
        return float(np.linalg.det(self.places(logarithms)[self.triangles]).sum() / 6)

    def record(self, found: Sequence[Floats]) -> dict[str, Any]:
        """The mesh between polyhedra, as a certificate holds it: W is 0, 1, 2 and so on."""
        power = BITS - int(np.ceil(np.log2(float(np.abs(self.places(found[-1])).max()))))
        corners, tetrahedra = list[str](), list[str]()
        for value, logarithms in enumerate(found):
            whole = np.rint(self.places(logarithms) * 2.0**power).astype(np.int64)
            corners += [f"{x} {y} {z} {value}" for x, y, z in whole.tolist()]
        for number in range(len(found) - 1):
            listed = (self.between + number * self.count).tolist()
            tetrahedra += [" ".join(map(str, own)) for own in listed]
        unit = f"1/{2**power}" if power >= 0 else str(2**-power)
        return {"unit": unit, "corners": corners, "tetrahedra": tetrahedra}


def unit_ball(linear: Floats) -> Floats:
    """Units U in which a ball shrinks at a good angle along ``x' = A x``, with ``x = U z``.

    ``P = (U U')^-1`` has ``(A + s I)' P + P (A + s I) = -I``, where s is a part of the slowest rate.  Where a rate is
    nearly zero, these are the units of the states.
    """
    from scipy.linalg import solve_continuous_lyapunov

    slowest = -float(np.linalg.eigvals(linear).real.max())
    if not slowest > SLOW * float(np.abs(linear).max()):
        return np.eye(len(linear))
    shifted = linear + SHIFT * slowest * np.eye(len(linear))
    weights = solve_continuous_lyapunov(shifted.T, -np.eye(len(linear)))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(weights).T))


def _reach(ray: Floats, inside: Callable[[Floats], NDArray[np.bool_]], within: float) -> float:
    """How many times a vector leads to where a set is left first, on its way out of a cube."""
    shares = np.linspace(0, 1, 513)[1:] * within / float(np.abs(ray).max())
    left = ~inside(shares[:, None] * ray)
    return float(shares[max(int(left.argmax()) - 1, 0)] if left.any() else shares[-1])


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
        beneath = (own >= -APART).all(axis=2) & (own.sum(axis=2) < 1)
        found[part] = beneath.any(axis=1)
    return found


def _parts(count: int, size: int) -> Iterator[slice]:
    return (slice(k, k + size) for k in range(0, count, size))
