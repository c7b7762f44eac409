"""A region in three states: polyhedra about the point, nested along rays, between which a continuous W rises.

All polyhedra have corners on the same rays, so that what lies between two of them are prisms over triangles of a
sphere, each of three tetrahedra; W is the number of the polyhedron.  On a tetrahedron with three corners on one of them
the gradient of W is the normal of this side, so velocities f must lead inward over all sides, and over planes that
are parallel to an edge of each polyhedron.  Up to three planes through the point on which the field switches are made
of edges, so that W may bend in them; other surfaces cut tetrahedra, which the fields of both sides must suit.  What is
proposed here is shown by theorem ``basin`` of the checker.

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
from itertools import combinations_with_replacement, product
from math import gcd
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.systems.basin_mesh import on_plane, whole_plane
from nonsmooth.proofs.systems.basin_rings import (
    AttractedLevel,
    FloatField,
    falls,
    gradients,
    lattice_unit,
    mixtures,
    unit_ball,
)
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    Mask,
    max_norm,
    max_norms,
    row_norms,
    row_products,
    unit_rows,
)

INSIDE = 0.98  # of the largest ellipsoid in the level set: the first polyhedron
SHIFT = 0.5  # of the slowest rate of decay: how much faster than the given field the one of the ellipsoid grows
SMALLER, WIDER = 20, 2.0  # times that the ellipsoid gets smaller by a fifth; of it, a cube that polyhedra do not leave
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
FINER = 1.5  # than those of an icosahedron are the parts of an edge of an octahedron
NEAR = 2.0**-12  # of the cube of the set that attracts: where slopes at the point are taken
WIDTH = 2.0**-20  # of the distance from the point: how far beside a plane velocities of its sides are taken

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


def geodesic_sphere(frequency: int, planes: Floats | None = None) -> tuple[Floats, Triples, Mask]:
    """Corners and triangles, counterclockwise from outside, of a divided polyhedron on the unit sphere.

    Args:
        frequency: parts of an edge of an icosahedron; of an octahedron, which has fewer edges, there are more.
        planes: normals of up to three planes through the middle that edges are to follow, shape (planes, 3); then an
            octahedron is divided, with corners where three planes meet.

    Returns:
        The corners, the triangles, and for each corner which of the planes hold it.
    """
    if planes is None or not len(planes):
        golden = (1 + 5**0.5) / 2
        corners = [np.roll((0.0, s, t * golden), k) for k in range(3) for s in (-1, 1) for t in (-1, 1)]
        chosen = ((i, j, k) for i in range(12) for j in range(i) for k in range(j))
        sides = [triple for triple in chosen if _is_side(corners, *triple)]
    else:
        frequency, span = round(FINER * frequency), np.linalg.svd(planes)[2]
        ends = np.linalg.inv(np.vstack([planes, span[len(planes) :]])).T
        corners = [sign * end / np.linalg.norm(end) for sign in (1, -1) for end in ends]
        sides = list(product((0, 3), (1, 4), (2, 5)))
    numbers: dict[tuple[tuple[int, int], ...], int] = {}
    places, triangles = list[Floats](), list[tuple[int, int, int]]()

    def number(weights: Sequence[tuple[int, int]]) -> int:
        key = tuple((corner, weight) for corner, weight in weights if weight)
        if key not in numbers:
            numbers[key] = len(places)
            place = sum(weight * corners[corner] for corner, weight in key)
            places.append(np.asarray(place / np.linalg.norm(place)))
        return numbers[key]

    for side in sides:

        def at(i: int, j: int, side: tuple[int, ...] = side) -> int:
            return number(tuple(zip(side, (i, j, frequency - i - j), strict=True)))

        for i in range(frequency):
            for j in range(frequency - i):
                triangles.append((at(i + 1, j), at(i, j + 1), at(i, j)))
                if i + j + 1 < frequency:
                    triangles.append((at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)))
    sphere, faces = np.array(places), np.array(triangles)
    inward = np.linalg.det(sphere[faces]) < 0
    faces[inward] = faces[inward][:, ::-1]
    count = 0 if planes is None else len(planes)
    incidence = np.array(
        [[all(corner % 3 != k for corner, _ in key) for k in range(count)] for key in numbers], dtype=bool
    )
    return sphere, faces, incidence


def _is_side(corners: Sequence[Floats], *numbers: int) -> bool:
    return all(np.linalg.norm(corners[i] - corners[j]) < 2.1 for i in numbers for j in numbers)


def tetrahedra_between(triangles: Triples, count: int) -> Triples:
    """Those of the prisms between two polyhedra, of positive size; corners of the outer one come after all others.

    A prism is cut at the diagonals from its lower numbers inside to its higher numbers outside, as its neighbours are.
    """
    is_even = np.linalg.det(np.eye(3)[np.argsort(triangles, axis=1)]) > 0
    a, b, c = np.sort(triangles, axis=1).T
    tetrahedra = []
    for columns in ((a, b, c, c + count), (a, b, c + count, b + count), (a, a + count, b + count, c + count)):
        corners = np.stack(columns, axis=1)
        corners[~is_even] = corners[~is_even][:, [1, 0, 2, 3]]
        tetrahedra.append(corners)
    return np.concatenate(tetrahedra)


# ---- fronts --------------------------------------------------------------------------------------


class Front:
    """Polyhedra with corners on rays, each by the logarithms of the distances of its corners.

    Args:
        field: of a system in three states that does not switch.
        home: the level set that attracts.
        limit: half the side of a cube that no polyhedron should leave; a wider one serves where they begin in that.
        effort: of the search.
    """

    def __init__(
        self,
        field: FloatField,
        home: AttractedLevel,
        limit: float,
        effort: ShellEffort,
    ) -> None:
        self.field, self.effort = field, effort
        self.planes = switching_planes(field)
        numbers = list(self.planes)
        units = unit_ball(slopes_along(lambda x: field.at(x)[0], np.eye(3), NEAR * home.within), SHIFT)
        if numbers:
            along = self._along_plane(home) if len(numbers) == 1 else None
            units = self._level_set(home) if along is None else along
        normals = np.array([self.planes[k] for k in numbers], dtype=float).reshape(-1, 3) @ units
        self.normals = unit_rows(normals)
        self.sphere, self.triangles, self.held = geodesic_sphere(effort.frequency, self.normals)
        self.count = len(self.sphere)
        self.units = units * INSIDE * reach(home, self.sphere @ units.T).min()
        for _ in range(SMALLER):
            if not self._bad_sides(np.zeros(self.count)).any():
                break
            self.units = 0.8 * self.units
        self.back = np.linalg.inv(self.units)
        self.limit = max(limit, WIDER * max_norm(self.rays))
        self.between = tetrahedra_between(self.triangles, self.count)
        ends = np.concatenate([self.triangles[:, columns] for columns in ([0, 1], [1, 2], [0, 2])])
        self.edges = np.unique(np.sort(ends, axis=1), axis=0)

    @property
    def rays(self) -> Floats:
        """The corners of the first polyhedron."""
        return self.sphere @ self.units.T

    def _level_set(self, home: AttractedLevel) -> Floats:
        """Units U of the ellipsoid nearest to the set that attracts: ``r^-2 = u' P u`` for its distances r on rays u.

        ``P = (U U')^-1``; where that is not positive, U are the units of the states.
        """
        sphere, _, _ = geodesic_sphere(self.effort.frequency)
        distances = reach(home, sphere)
        pairs = list(combinations_with_replacement(range(3), 2))
        columns = np.stack([sphere[:, i] * sphere[:, j] for i, j in pairs], axis=1)
        form = np.zeros((3, 3))
        for (i, j), coefficient in zip(pairs, np.linalg.lstsq(columns, distances**-2)[0], strict=True):
            form[i, j] += coefficient / 2
            form[j, i] += coefficient / 2
        if not np.linalg.eigvalsh(form).min() > 0:
            return np.eye(3)
        return np.linalg.inv(np.linalg.cholesky(form).T)

    def _along_plane(self, home: AttractedLevel) -> Floats | None:
        """Units in which a ball shrinks along a plane on which solutions slide near the point; None where none do.

        Its third axis is that of the jump of the field, so that off the plane the ball shrinks by what jumps.
        """
        normal = np.array(next(iter(self.planes.values())), dtype=float)
        size, plane = NEAR * home.within, np.linalg.svd(normal[None])[2][1:]
        _, slides = sliding(self.field, size * plane, normal)
        if not slides.all():
            return None
        slopes = slopes_along(lambda x: sliding(self.field, x, normal)[0], plane, size)
        across = WIDTH * size * normal / np.linalg.norm(normal)
        jump = np.subtract(*(self.field.at(place[None])[0, 0] for place in (across, -across)))
        flat, jump = plane.T @ unit_ball(plane @ slopes, SHIFT), jump / np.linalg.norm(jump)
        flat = flat * reach(home, flat.T).min()
        units = np.column_stack([flat, reach(home, jump[None])[0] * jump])
        return units * [1, 1, np.sign(np.linalg.det(units))]  # as the axes of the states are turned

    def grown(self, announce: Callable[[int, int], None]) -> list[Floats]:
        """Polyhedra from the first one on, as few as serve, on whose shells floats see W fall."""
        best, tries = [np.zeros(self.count)], self.effort.disturbances
        for number, part in enumerate(tries):
            steps, polyhedra = self.effort.steps, [np.zeros(self.count)]
            for step in range(steps):
                announce(number * steps + step, len(tries) * steps)
                after = self._after(polyhedra[-1], part)
                growth = float((after - polyhedra[-1]).mean())
                polyhedra.append(after)
                if growth < STILL:
                    break
            selection = self._thinned(polyhedra)
            if self.volume(selection[-1]) > self.volume(best[-1]):
                best = selection
        return best

    def _after(self, before: Floats, part: float) -> Floats:
        """The next polyhedron: corners of bad sides go only a part of their way, or none."""
        way, shares = self._aim(before, part) - before, np.ones(self.count)
        for round_ in range(ROUNDS):
            after = before + shares * way
            bad = self._bad_sides(after)
            if not bad.any():
                return after
            hit = np.zeros(self.count, dtype=bool)
            hit[self.triangles[bad].ravel()] = True
            if round_ >= WIDELY:
                hit[self.edges[hit[self.edges].any(axis=1)].ravel()] = True
            shares[hit] *= 0.5 if round_ < HALVINGS else 0.0
        return before

    def _aim(self, before: Floats, part: float) -> Floats:
        """How far rays go if the disturbed field is to lead into a polyhedron, made smoother."""
        normals, most = self._normals(before), self.effort.growth
        near, far = (self._outside(before, before + growth, normals, part) for growth in (0.0, most))
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
        course = self._course(z, normals, part)
        step = np.full((self.count, 1), PATH)
        for normal, is_on in zip(self.normals, self.held.T, strict=True):  # no further than to a plane
            away, speed = z @ normal, course @ normal
            meets = ~is_on & (away * speed < 0)
            step[meets, 0] = np.minimum(step[meets, 0], -away[meets] / speed[meets])
        middle = z + step / 2 * course
        end = z + step * self._course(middle, normals, part)
        return np.log(row_norms(end)) - self._toward(before, end)

    def _course(self, z: Floats, normals: Floats, part: float) -> Floats:
        """The disturbed field, of a speed that is the distance from the point, less near the limit."""
        places = z @ self.units.T
        field = self.field.at(places)[0]
        for normal, is_on in zip(self.planes.values(), self.held.T, strict=True):
            mixed, slides = sliding(self.field, places[is_on], np.array(normal, dtype=float))
            field[is_on] = np.where(slides[:, None], mixed, field[is_on])
        field = field @ self.back.T
        course = field / (row_norms(field)[:, None] + np.finfo(float).tiny) + part * normals
        room = np.clip(1 - (max_norms(places) / self.limit) ** 4, 0, 1)
        return course * (room * row_norms(z))[:, None]

    def _normals(self, logarithms: Floats) -> Floats:
        """Outward at each corner, in the units of the sphere: the mean over its sides by their areas."""
        corners = (np.exp(logarithms)[:, None] * self.sphere)[self.triangles]
        sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        weights = np.repeat(sides, 3, axis=0)
        totals = [np.bincount(self.triangles.ravel(), weights[:, k]) for k in range(3)]
        return unit_rows(np.stack(totals, axis=1, dtype=np.float64))

    @cached_property
    def _middles(self) -> Any:
        """The middles of the triangles of the sphere, to look for the nearest."""
        from scipy.spatial import cKDTree

        middles = self.sphere[self.triangles].mean(axis=1)
        return cKDTree(unit_rows(middles))

    @cached_property
    def _weights(self) -> Floats:
        """Of each triangle of the sphere what the weights of its corners are of a place in its cone."""
        return np.asarray(np.linalg.inv(self.sphere[self.triangles].transpose(0, 2, 1)))

    def _toward(self, logarithms: Floats, z: Floats) -> Floats:
        """The logarithm of the distance of a polyhedron in the directions of places, between its corners."""
        units = unit_rows(z)
        near = self._middles.query(units, k=3)[1]
        weights = np.einsum("pkij,pj->pki", self._weights[near], units)
        rows = np.arange(len(z))
        chosen = weights.min(axis=2).argmax(axis=1)
        shares = np.clip(weights[rows, chosen], 0, None)
        corners = self.triangles[near[rows, chosen]]
        return row_products(logarithms[corners], shares) / shares.sum(axis=1)

    def _bad_sides(self, logarithms: Floats) -> Mask:
        """Over which sides the field is not seen to lead inward."""
        corners = self.places(logarithms)[self.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return ~falls(self.field, corners, normals, MARGIN, self._on_planes(corners, self.triangles))

    def _thinned(self, polyhedra: Sequence[Floats]) -> list[Floats]:
        """Some of the polyhedra, a little apart: after each one the farthest of a few that serves as the next."""
        apart = [polyhedron + APART * number for number, polyhedron in enumerate(polyhedra)]
        selection, here = [apart[0]], 0
        while here < len(polyhedra) - 1 and len(selection) <= self.effort.shells:
            for number in dict.fromkeys(min(here + step, len(polyhedra) - 1) for step in AHEAD):
                few = FEW if number > here + 1 else 1.0
                margin = SMALL / (1 + len(selection) / self.effort.shells)  # corners that stay need ever less
                after = self._mended(selection[-1], np.maximum(apart[number], selection[-1] + APART), few, margin)
                if after is not None:
                    break
            else:
                break
            selection.append(after)
            here = number
        return selection

    def _mended(self, inner: Floats, outer: Floats, few: float, margin: float) -> Floats | None:
        """An outer polyhedron of which few corners go a part of their way only, so that W falls; None without one."""
        shares, most = np.ones(self.count), few * len(self.between)
        touched = np.arange(len(self.between))
        for _ in range(MENDINGS):
            after = np.maximum(inner + shares * (outer - inner), inner + APART)
            failing = np.zeros(len(self.between), dtype=bool)
            for part in (touched[piece] for piece in _parts(len(touched), TOGETHER)):
                failing[part] = self._failing(inner, after, margin, self.between[part])
                if failing.sum() > most:
                    return None
            failing |= self._failing_beside_planes(inner, after, margin)
            if not failing.any():
                return after
            slower = np.zeros(self.count, dtype=bool)
            slower[self.between[failing].ravel() % self.count] = True
            shares[slower] *= MENDED
            touched = np.nonzero(slower[self.between % self.count].any(axis=1))[0]
        return None

    def _failing(self, inner: Floats, outer: Floats, margin: float, tetrahedra: Triples) -> Mask:
        """Those of some tetrahedra between two polyhedra on which floats do not see W fall."""
        places = np.concatenate([self.places(inner), self.places(outer)])[tetrahedra]
        sizes, slopes = gradients(places, (tetrahedra >= self.count).astype(float))
        return ~(
            (sizes > 0) & falls(self.field, places, slopes, margin, self._on_planes(places, tetrahedra % self.count))
        )

    @cached_property
    def _beside_planes(self) -> tuple[Triples, Triples]:
        """Pairs of tetrahedra with a side between them in a plane, shape (pairs, 2), and the corners of the sides."""
        is_on = self.held[self.between % self.count]
        by_side: dict[tuple[int, ...], list[int]] = {}
        for k in range(len(self.planes)):
            for number in np.nonzero(is_on[:, :, k].sum(axis=1) == 3)[0].tolist():
                side = tuple(sorted(self.between[number][is_on[number, :, k]].tolist()))
                by_side.setdefault(side, []).append(number)
        both = {side: pair for side, pair in by_side.items() if len(pair) == 2}
        pairs, sides = np.array(list(both.values()), dtype=int), np.array(list(both), dtype=int)
        return pairs.reshape(-1, 2), sides.reshape(-1, 3)

    def _failing_beside_planes(self, inner: Floats, outer: Floats, margin: float) -> Mask:
        """Tetrahedra beside sides in planes on which no mixture of both gradients falls for the fields of both cells.

        Velocities are looked at where the corners of the side are.
        """
        failing = np.zeros(len(self.between), dtype=bool)
        pairs, sides = self._beside_planes
        if not len(pairs):
            return failing
        corners = np.concatenate([self.places(inner), self.places(outer)])
        tetrahedra = corners[self.between[pairs]]  # (pairs, 2, 4, 3)
        heights = (self.between[pairs] >= self.count).astype(float)
        first, second = (gradients(tetrahedra[:, k], heights[:, k])[1] for k in (0, 1))
        low, high = np.zeros(len(pairs)), np.ones(len(pairs))  # bounds of the part of the second gradient
        for k, corner in product((0, 1), range(3)):
            middle = tetrahedra[:, k].mean(axis=1)
            at = corners[sides[:, corner]]
            for velocities in self.field.beside(middle, at):
                speeds = row_norms(velocities)
                rate, other = (
                    row_products(velocities, slope) + margin * speeds * row_norms(slope) for slope in (first, second)
                )
                rise = other - rate
                bound = -rate / np.where(rise == 0, 1, rise)
                low = np.where(rise < 0, np.maximum(low, bound), low)
                high = np.where(rise > 0, np.minimum(high, bound), high)
                high -= (rise == 0) & (rate >= 0)
        failing[pairs[low >= high]] = True
        return failing

    def _on_planes(self, places: Floats, rays: Triples) -> dict[int, Floats]:
        """The values of the surfaces that edges follow, at corners on rays: zero on those along the plane."""
        return {
            number: np.where(self.held[rays, k], 0, places @ np.array(normal, dtype=float))
            for k, (number, normal) in enumerate(self.planes.items())
        }

    def places(self, logarithms: Floats) -> Floats:
        """The corners of a polyhedron, in the displacement from the point."""
        return np.exp(logarithms)[:, None] * self.rays

    def volume(self, logarithms: Floats) -> float:
        """Of a polyhedron."""
        return float(np.linalg.det(self.places(logarithms)[self.triangles]).sum() / 6)

    def record(self, polyhedra: Sequence[Floats]) -> dict[str, Any]:
        """The mesh between polyhedra, as a certificate holds it: W is 0, 1, 2 and so on."""
        power = BITS - int(np.ceil(np.log2(max_norm(self.places(polyhedra[-1])))))
        corners, tetrahedra = list[str](), list[str]()
        for value, logarithms in enumerate(polyhedra):
            whole = np.rint(self.places(logarithms) * 2.0**power).astype(np.int64).tolist()
            for place, incidence in zip(whole, self.held, strict=True):
                x, y, z = on_planes(
                    place, [normal for normal, is_on in zip(self.planes.values(), incidence, strict=True) if is_on]
                )
                corners.append(f"{x} {y} {z} {value}")
        for number in range(len(polyhedra) - 1):
            listed = (self.between + number * self.count).tolist()
            tetrahedra += [" ".join(map(str, tetrahedron)) for tetrahedron in listed]
        return {"unit": lattice_unit(power), "corners": corners, "tetrahedra": tetrahedra}


def switching_planes(field: FloatField) -> dict[int, tuple[int, int, int]]:
    """Up to three planes through the point on which a field switches: their normals, by the numbers of the surfaces."""
    planes: dict[int, tuple[int, int, int]] = {}
    for number, surface in enumerate(field.surfaces):
        if surface.degree == 1 and not surface.at_origin:
            x, y, z = whole_plane(surface)[0]
            normals = np.array([*planes.values(), (x, y, z)], dtype=float)
            if len(planes) < 3 and np.linalg.matrix_rank(normals) == len(normals):
                planes[number] = x, y, z
    return planes


def on_planes(place: Sequence[int], normals: Sequence[tuple[int, int, int]]) -> tuple[int, int, int]:
    """A whole place near another one, on up to two planes through the origin."""
    if len(normals) == 2:
        (a, b, c), (d, e, f) = normals
        line = (b * f - c * e, c * d - a * f, a * e - b * d)
        common = gcd(*line)
        x, y, z = (entry // common for entry in line)
        steps = round((x * place[0] + y * place[1] + z * place[2]) / (x * x + y * y + z * z))
        return steps * x, steps * y, steps * z
    x, y, z = on_plane(place, normals[0], 0) if normals else place
    return x, y, z


def slopes_along(at: Callable[[Floats], Floats], directions: Floats, size: float) -> Floats:
    """The derivatives of a field at the point along some directions, by differences: a column for each."""
    return (at(size * directions) - at(-size * directions)).T / (2 * size)


def sliding(field: FloatField, x: Floats, normal: Floats) -> tuple[Floats, Mask]:
    """The mixtures along a plane of velocities of both sides at places in it, and where both lead to it."""
    width = WIDTH * row_norms(x)[:, None] * normal / np.linalg.norm(normal)
    there = x - np.outer(x @ normal, normal) / (normal @ normal)
    above, below = (field.at(there + offset)[0] for offset in (width, -width))
    return mixtures(below, above, normal[None])


def reach(home: AttractedLevel, rays: Floats) -> Floats:
    """How many times vectors lead to where the level set is left first, on their way out of its cube.

    To a part of the way, nearer than :meth:`AttractedLevel.reach`: polyhedra that begin elsewhere grow to others,
    larger and smaller ones by a factor, without an order.
    """
    shares = np.linspace(0, 1, 513)[1:, None] * home.within / max_norms(rays)
    outside = ~home((shares[:, :, None] * rays).reshape(-1, 3)).reshape(shares.shape)
    last = np.where(outside.any(axis=0), np.maximum(outside.argmax(axis=0) - 1, 0), -1)
    return shares[last, np.arange(len(rays))]


def inside_polyhedron(sides: Floats, x: Floats) -> Mask:
    """Which places lie in a polyhedron that all rays from the point leave once.

    Args:
        sides: their corners, shape (sides, 3, 3).
        x: places, shape (places, 3).
    """
    weights = np.linalg.inv(sides.transpose(0, 2, 1))
    inside = np.zeros(len(x), dtype=bool)
    for part in _parts(len(x), 400):
        coordinates = np.einsum("tij,pj->pti", weights, x[part])
        beneath = (coordinates >= -APART).all(axis=2) & (coordinates.sum(axis=2) < 1)
        inside[part] = beneath.any(axis=1)
    return inside


def _parts(count: int, size: int) -> Iterator[slice]:
    return (slice(k, k + size) for k in range(0, count, size))
