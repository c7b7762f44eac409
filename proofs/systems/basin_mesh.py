"""A mesh between rings, on which W is the number of the ring: points on whole multiples of a unit, exactly on lines.

In a triangle with a side on a ring W has the gradient of the normal n of this side, up to a positive factor, so all
velocities f that the triangle may have must fulfil ``n . f < 0``.  Where floats see that fail the side is halved, or
those of the other ring beside the triangle, until the points of the rings are used up; then a ring is put between.
Bands are refined from the first ring on, a few at a time, so that nothing is spent beyond one that cannot be; and rings
are made in stages, the next one only where the mesh has come to the end of the one before.
Where cells meet, each band is at last put to the checker's own conditions; rings end before the first that fails them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import accumulate, islice, pairwise
from math import gcd, lcm
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.checker.basin import CellFields, Mesh, show_falls, whole_argument
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.systems.basin_rings import SMALL, FieldInCells, RingGrowth, area, falls, gradients, grow, lengths
from nonsmooth.symbolic.numbers.plane_arrays import Floats, following, max_norm

BETWEEN = 0.5  # the way between two rings that are used at first, of their size
ROUNDS = 8  # in which a band is refined
AHEAD = 4  # bands that are refined at a time: those beyond one that cannot be refined are not needed
WAY = 30.0  # of the fastest points of rings, in multiples of their size, at most
STAGES = (0.5, 7.5, 15.0, WAY)  # of the way that rings go, as long as the mesh goes as far as they do
BITS = 26  # of coordinates
HUGE = 2**500
NEAR_LINE = 0.25  # of the distance of neighbours: points of a ring that are as near to a point on a line are left out

Announce: TypeAlias = Callable[[str, int, int], None]  # what is done, how much of it, and of how much
Corner: TypeAlias = tuple[int, int]  # a ring, and a point of it
Triangle: TypeAlias = tuple[Corner, Corner, Corner]
Band: TypeAlias = tuple[int, int]  # the rings on both sides
Failing: TypeAlias = tuple[tuple[int, int, int], bool]  # a triangle of a band, and whether it is turned over


@dataclass(frozen=True)
class BasinEffort:
    """What a search may cost.

    Attributes:
        pace: of rings.
        starts: in a row of those that are sampled.
        every: as many points of a ring there are for each that is a corner at first.
        points: of a ring, at most.
        way: of rings, in multiples of their size, at most.
        triangles: that are looked at in floats for a mesh, at most; those near the point come first.
        outward: steps of rings that look for a polygon outside, at most.
    """

    pace: RingGrowth
    starts: int
    every: int = 12
    points: int = 4_000
    way: float = WAY
    triangles: int = 300_000
    outward: int = 10_000


@dataclass
class LatticeRing:
    """A dense ring on the lattice.

    Attributes:
        points: whole numbers, in units.
        lines: of each point the surface, a line, on which it lies; -1 of all others.
        chosen: the points that are corners of the mesh, in order.
    """

    points: Floats
    lines: NDArray[np.int64]
    chosen: list[int]

    def halve(self, position: int) -> int | None:
        """The point between two chosen neighbours; None where there is none."""
        size, count = len(self.chosen), len(self.points)
        low, high = self.chosen[position % size], self.chosen[(position + 1) % size]
        high += count if high <= low else 0
        return None if high - low < 2 else (low + high) // 2 % count


class Lattice:
    """Points that are multiples of a unit, among them many of every line on which a system switches.

    Attributes:
        unit: such that the offset of every line is whole, too, and its largest slope divides it.
        lines: a, b, c of the surfaces that are lines, by their numbers: ``a X + b Y + c`` times a positive number.
        is_huge: whether floats may not hold its numbers.
    """

    def __init__(self, surfaces: Sequence[Polynomial], size: float) -> None:
        forms = {number: whole_plane(surface) for number, surface in enumerate(surfaces) if surface.degree == 1}
        shared = lcm(1, *((offset / max(normal, key=abs)).denominator for normal, offset in forms.values()))
        power = BITS - int(np.ceil(np.log2(size)))
        self.unit = Fraction(1, shared) / Fraction(2) ** power
        self.lines = {number: (a, b, int(offset / self.unit)) for number, ((a, b), offset) in forms.items()}
        self.is_huge = (
            max([shared, *(abs(coefficient) for line in self.lines.values() for coefficient in line)]) >= HUGE
        )

    def ring(self, ring: Floats, every: int) -> LatticeRing:
        """A ring with the points at which it crosses lines, all on the lattice; one of some points is a corner."""
        scale = 1 / float(self.unit)
        points, on_line = np.rint(ring * scale), np.full(len(ring), -1)
        for number, (a, b, c) in self.lines.items():
            value = a * points[:, 0] + b * points[:, 1] + c
            on_line = np.where((value == 0) & (on_line < 0), number, on_line)
            after, nearest = np.roll(value, -1), following(points)
            crossed = np.nonzero((value * after < 0) & (on_line < 0) & (np.roll(on_line, -1) < 0))[0]
            shares = value[crossed] / (value[crossed] - after[crossed])
            places = points[crossed] + shares[:, None] * (nearest[crossed] - points[crossed])
            places = np.array([on_plane(place, (a, b), c) for place in places]).reshape(-1, 2)
            points = np.insert(points, crossed + 1, places, axis=0)
            on_line = np.insert(on_line, crossed + 1, number)
        points, on_line = _thinned(points, on_line)
        return LatticeRing(
            points, on_line, sorted({*range(0, len(points), every), *np.nonzero(on_line >= 0)[0].tolist()})
        )

    def on_lines(self, corners: Floats) -> dict[int, Floats]:
        """The values of the surfaces that are lines at whole places: shape (triangles, 3), without error."""
        return {n: a * corners[:, :, 0] + b * corners[:, :, 1] + c for n, (a, b, c) in self.lines.items()}


def whole_plane(surface: Polynomial) -> tuple[list[int], Fraction]:
    """The normal of a line or plane in whole numbers without a common factor, and its value at the point."""
    _, offset, *normal = whole_argument(surface)
    common = gcd(*normal)
    return [slope // common for slope in normal], Fraction(offset, common)


def on_plane(place: Sequence[float], normal: Sequence[int], offset: int) -> list[int]:
    """A whole place near another one on a line or plane: its largest slope, the pivot, is to divide the offset."""
    numbers = range(len(normal))
    pivot = max(numbers, key=lambda k: abs(normal[k]))
    moved = [round(coordinate / normal[pivot]) * normal[pivot] for coordinate in place]
    moved[pivot] = -(offset + sum(normal[k] * moved[k] for k in numbers if k != pivot)) // normal[pivot]
    return moved


def _thinned(points: Floats, on_line: NDArray[np.int64]) -> tuple[Floats, NDArray[np.int64]]:
    """Without points that are on no line and very near one that is."""
    mask = np.ones(len(points), dtype=bool)
    for k in np.nonzero(on_line >= 0)[0]:
        for step in (-1, 1):
            beside, beyond = (k + step) % len(points), (k + 2 * step) % len(points)
            near, far = (np.linalg.norm(points[other] - points[k]) for other in (beside, beyond))
            mask[beside] &= bool(on_line[beside] >= 0 or near > NEAR_LINE * far)
    return points[mask], on_line[mask]


# ---- triangles between two rings -----------------------------------------------------------------


def band(inner: LatticeRing, outer: LatticeRing) -> list[tuple[int, int, int]]:
    """Triangles between two rings by the shorter diagonals: the ring of a side, its place, and the place of its apex.

    Places are those in the lists of chosen points.  Where both rings cross lines in the same order, triangles lie
    between neighbouring crossings.
    """
    triangles: list[tuple[int, int, int]] = []
    near, far = ([complex(x, y) for x, y in ring.points[ring.chosen]] for ring in (inner, outer))
    for (first, count), (start, steps) in _sectors(inner, outer):
        i = j = 0
        while i < count or j < steps:
            a, a_next = near[(first + i) % len(near)], near[(first + i + 1) % len(near)]
            b, b_next = far[(start + j) % len(far)], far[(start + j + 1) % len(far)]
            if j == steps or (i < count and abs(a_next - b) <= abs(b_next - a)):
                triangles.append((0, first + i, start + j))
                i += 1
            else:
                triangles.append((1, start + j, first + i))
                j += 1
    return triangles


def _sectors(inner: LatticeRing, outer: LatticeRing) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Stretches of both rings that belong together: the first place of each, and the number of its sides."""
    starts, other = ([k for k, point in enumerate(ring.chosen) if ring.lines[point] >= 0] for ring in (inner, outer))
    lines = [[ring.lines[ring.chosen[k]] for k in listed] for ring, listed in ((inner, starts), (outer, other))]
    turns = [t for t in range(len(other)) if lines[0] == lines[1][t:] + lines[1][:t]]
    if not turns:
        starts, other, turns = [0], list(range(len(outer.chosen))), list(range(len(outer.chosen)))
    places = outer.points[np.array(outer.chosen)[other]][turns]
    turn = turns[int(lengths(places - inner.points[inner.chosen[starts[0]]]).argmin())]
    other = other[turn:] + other[:turn] if len(starts) > 1 else [other[turn]]
    for k in range(len(starts)):
        stretches = []
        for ring, listed in ((inner, starts), (outer, other)):
            size = len(ring.chosen)
            sides = (listed[(k + 1) % len(starts)] - listed[k]) % size
            stretches.append((listed[k], sides or size))
        yield stretches[0], stretches[1]


@dataclass(frozen=True)
class BuiltMesh:
    """A mesh on which W falls, as floats see it.

    Attributes:
        record: as a certificate holds it.
        below: W on its last ring.
    """

    record: Record
    below: int

    @property
    def corners(self) -> Floats:
        """Places in the displacement from the point, each with its value of W: shape (corners, 3)."""
        return mesh_corners(self.record)

    @property
    def area(self) -> float:
        """Of what the last ring goes around."""
        return area(last_ring(self.corners))


def mesh_corners(mesh: Record) -> Floats:
    """The corners of a mesh in floats."""
    corners = np.array([corner.split(" ") for corner in mesh["corners"]], dtype=float)
    corners[:, :-1] *= float(Fraction(mesh["unit"]))
    return corners


def last_ring(corners: Floats) -> Floats:
    """The corners with the largest value, which are a ring in order."""
    return corners[corners[:, -1] == corners[:, -1].max()][:, :-1]


def grown_mesh(
    field: FieldInCells,
    exact: Callable[[str], CellFields],
    first: Floats,
    effort: BasinEffort,
    limit: float,
    announce: Announce,
    *,
    power: int = 2,
    is_first_whole: bool = False,
) -> tuple[BuiltMesh | None, Floats]:
    """The mesh of rings that are made as far as it comes, and the last of them.

    Args:
        field: the velocities in floats.
        exact: the checker's cells, told the unit of the mesh.
        first: ring.
        effort: of the search.
        limit: half the side of a square that no ring leaves.
        announce: told what is done, how much of it, and of how much.
        power: p of the speed of rings.
        is_first_whole: whether all points of the first one are corners.
    """
    rings = grow(field, first, effort.pace, limit, effort.points, effort.way, partial(announce, "rings"), power)
    made: list[Floats] = []
    builder: MeshBuilder | None = None
    for count in (round(way / effort.pace.move) for way in STAGES):
        more = list(islice(rings, count - len(made)))
        if made and not more:
            break
        made += more
        builder = MeshBuilder(field, exact, made, effort, is_first_whole=is_first_whole) if len(made) > 1 else None
        if builder is not None and builder.lattice.is_huge:
            builder = None
        if builder is None or not builder.refine(partial(announce, "bands of triangles")) or len(made) < count:
            break
    return None if builder is None else builder.built(), made[-1]


class MeshBuilder:
    """Rings of which bands are refined until W falls on them.

    Args:
        field: the velocities in floats.
        exact: the checker's cells, told the unit of the mesh.
        rings: from the first one on.
        effort: of the search; a triangle that is refined counts anew, and after the last one the mesh ends before the
            first band that is open.
        is_first_whole: whether all points of the first one are corners.
    """

    def __init__(
        self,
        field: FieldInCells,
        exact: Callable[[str], CellFields],
        rings: Sequence[Floats],
        effort: BasinEffort,
        *,
        is_first_whole: bool = False,
    ) -> None:
        size = max(max_norm(ring) for ring in rings)
        self.lattice = Lattice(field.surfaces, size)
        self.field, self.exact = field, exact(str(self.lattice.unit))
        self.dense, self.rings = rings, dict[int, LatticeRing]()
        self.left, self.every, self.is_first_whole, self.used = (
            effort.triangles,
            effort.every,
            is_first_whole,
            list[int](),
        )
        self.between = max(round(BETWEEN / effort.pace.move), 1)

    def ring(self, number: int) -> LatticeRing:
        """A ring on the lattice."""
        if number not in self.rings:
            is_whole = self.is_first_whole and not number
            self.rings[number] = self.lattice.ring(self.dense[number], 1 if is_whole else self.every)
        return self.rings[number]

    def refine(self, announce: Callable[[int, int], None]) -> bool:
        """Refine bands from the first ring on, a few at a time; whether floats see W fall up to the last ring."""
        used = [*range(0, len(self.dense) - 1, self.between), len(self.dense) - 1]
        falling: set[Band] = set()
        rounds: dict[Band, int] = {}
        while True:
            open_bands = [pair for pair in pairwise(used) if pair not in falling][:AHEAD]
            if not open_bands:
                break
            announce(len(falling), len(used) - 1)
            if self.left < 0:
                used = used[: next(k for k, pair in enumerate(pairwise(used)) if pair not in falling) + 1]
                break
            touched, between = set[int](), set[int]()
            for pair, failing in self._failing(open_bands).items():
                rounds[pair] = rounds.get(pair, 0) + 1
                if not failing:
                    falling.add(pair)
                    continue
                changed = self._refine(pair, failing) if rounds[pair] <= ROUNDS else set()
                touched |= changed
                if not changed:
                    between.add(pair[1])
            falling = {pair for pair in falling if touched.isdisjoint(pair)}
            used = self._with_more(used, between)
        self.used = used
        return used[-1] == len(self.dense) - 1

    def built(self) -> BuiltMesh | None:
        """The mesh of these bands; None without one.  Where cells meet the checker asks more than floats have seen."""
        used = self.used
        if self.exact.has_borders:
            bands = list(pairwise(used))
            count = next((k for k, pair in enumerate(bands) if not self._is_shown(*pair)), len(bands))
            used = used[: count + 1]
        return BuiltMesh(self._record(used), len(used) - 1) if len(used) > 1 else None

    def _with_more(self, used: list[int], between: set[int]) -> list[int]:
        """A ring more before each of some, or no rings from one on before which there is none."""
        numbers = used[:1]
        for number in used[1:]:
            before = numbers[-1]
            if number in between:
                if number - before < 2:
                    break
                numbers.append((before + number) // 2)
            numbers.append(number)
        return numbers

    def _corners(self, pair: tuple[int, int], triangle: tuple[int, int, int]) -> Triangle:
        """A triangle of a band counterclockwise, as points of rings; its side of one ring comes first or last."""
        which, place, apex = triangle
        base, other = pair[which], pair[1 - which]
        chosen, opposite = self.ring(base).chosen, self.ring(other).chosen
        first, last = (base, chosen[place % len(chosen)]), (base, chosen[(place + 1) % len(chosen)])
        top = (other, opposite[apex % len(opposite)])
        return (first, last, top) if which else (first, top, last)

    def _failing(self, pairs: Sequence[Band]) -> dict[Band, list[Failing]]:
        """The triangles of each band on which W is not seen to fall, and whether they are turned over."""
        bands = [(pair, triangle) for pair in pairs for triangle in band(self.ring(pair[0]), self.ring(pair[1]))]
        self.left -= len(bands)
        named = [self._corners(pair, triangle) for pair, triangle in bands]
        rings = {number: self.ring(number).points for pair in pairs for number in pair}
        starts = dict(zip(rings, accumulate(map(len, rings.values()), initial=0), strict=False))
        places = [[starts[ring] + point for ring, point in triangle] for triangle in named]
        corners = np.concatenate(list(rings.values()))[places]
        heights = np.array(
            [[float(ring == pair[1]) for ring, _ in triangle] for (pair, _), triangle in zip(bands, named, strict=True)]
        )
        sizes, slopes = gradients(corners, heights)
        at = corners * float(self.lattice.unit)
        good = (sizes > 0) & falls(self.field, at, slopes, SMALL, self.lattice.on_lines(corners))
        failing: dict[Band, list[Failing]] = {pair: [] for pair in pairs}
        for number in np.nonzero(~good)[0].tolist():
            pair, triangle = bands[number]
            failing[pair].append((triangle, bool(sizes[number] <= 0)))
        return failing

    def _refine(self, pair: Band, failing: Sequence[Failing]) -> set[int]:
        """Halve sides of triangles that fail; which rings have more points."""
        more: dict[int, set[int]] = {number: set() for number in pair}
        for (which, place, apex), is_turned in failing:
            base, other = pair[which], pair[1 - which]
            points = [(base, self.ring(base).halve(place))]
            if points[0][1] is None or is_turned:
                points += [(other, self.ring(other).halve(k)) for k in (apex, apex - 1)]
            for number, point in points:
                if point is not None:
                    more[number].add(point)
        changed = set()
        for number, points_of in more.items():
            ring = self.ring(number)
            if not points_of <= set(ring.chosen):
                ring.chosen = sorted(points_of.union(ring.chosen))
                changed.add(number)
        return changed

    def _is_shown(self, inner: int, outer: int) -> bool:
        """Whether the checker's conditions hold on a band."""
        try:
            show_falls(Mesh(self._record([inner, outer])), self.exact)
        except RejectedError:
            return False
        return True

    def _record(self, used: Sequence[int]) -> Record:
        """The mesh of some rings, on which W is 0, 1, 2 and so on."""
        numbers: dict[Corner, int] = {}
        corners, triangles = list[str](), list[str]()
        for value, number in enumerate(used):
            ring = self.ring(number)
            for point in ring.chosen:
                numbers[number, point] = len(corners)
                x, y = ring.points[point]
                corners.append(f"{int(x)} {int(y)} {value}")
        for pair in pairwise(used):
            for triangle in band(self.ring(pair[0]), self.ring(pair[1])):
                triangles.append(" ".join(str(numbers[corner]) for corner in self._corners(pair, triangle)))
        return {"unit": str(self.lattice.unit), "corners": corners, "triangles": triangles}
