"""The basin of an asymptotically stable point in two or three states: a mesh around a level set that attracts.

In the plane rings are proposed in floats (:mod:`nonsmooth.proofs.systems.basin_rings`), and triangles between them are
refined (:mod:`nonsmooth.proofs.systems.basin_mesh`); in three states polyhedra with tetrahedra between them
(:mod:`nonsmooth.proofs.systems.basin_shells`).  The whole is shown by theorem ``basin`` of the checker, by exact whole
numbers.  How much of the true basin that is, is sampled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.checker.basin import NAMES, Plane
from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.outside import closed, place_of
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.systems.basin_mesh import Announce, BasinEffort, BuiltMesh, grown_mesh, last_ring, mesh_corners
from nonsmooth.proofs.systems.basin_rings import (
    AttractedLevel,
    FieldInCells,
    FloatField,
    RingGrowth,
    area,
    followed_home,
    inside_ring,
    level_ring,
)
from nonsmooth.proofs.systems.basin_shells import EFFORTS as IN_SPACE
from nonsmooth.proofs.systems.basin_shells import Front, inside_polyhedron
from nonsmooth.proofs.systems.outer_ring import (
    AROUND,
    Beside,
    find_outer_ring,
    find_traps,
    is_shown,
    on_lattice,
    places_of_rest,
    ring_of,
)
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, are_finite, max_norm, row_norms

# ---- lines beside the stable manifold of a saddle, beyond which no start comes to the point ------
#
# On the border of a basin there are often saddles, and what separates the starts that come from those that do not is
# the stable manifold of one.  A line begins a little beyond the saddle, along its stable direction, and goes on at both
# ends backward in time, turned by an angle such that velocities lead over it, away from the point.  Far from the region
# it ends in half-lines along the axes over which they lead, too.  Floats propose; theorem ``outside`` shows it.


MOST_SADDLES, MOST_POINTS = 3, 1_500  # the nearest ones; points of one branch
CLEAR = 2.0**-16  # of the square of the Jacobian's size: a determinant that is as small counts as zero, as on a curve
NEAR = 1 / 64  # of its distance from the point: how far from a saddle a line is straight, at most
SHARPER = 1 / 4  # than the angle of rings: a line is one ring, and many are tried
BEND = 1 / 3  # of the angle, by which a line turns from one point to the next, at most
LONGEST = 1 / 16  # of the size of the region: a side
WINDOWS = 20.0  # half-widths of the window: no line goes there
SAMPLES = tuple(2.0**k for k in range(-6, 20))  # places on a half-line, in floats, over the size
AXES = ((1, 0), (0, 1), (-1, 0), (0, -1))


def find_borders(system: System, surfaces: Sequence[str], border: Floats, pace: RingGrowth) -> list[Beside]:
    """Saddles, in floats, each with the hypotheses of theorem ``outside``, which are shown, of a line beside it.

    Args:
        system: in the plane, without sines.
        surfaces: on which it switches, in the displacement.
        border: of the certified region: shape (corners, 2).
        pace: of rings.
    """
    field = FloatField.of(system, surfaces)
    if any(field.plane.waves):
        return []
    half, borders = max_norm(border), list[Beside]()
    rests = [(place, slope) for place, slope in places_of_rest(field, AROUND * half) if are_finite(slope)]
    saddles = [(place, slope) for place, slope in rests if np.linalg.det(slope) < -CLEAR * np.sum(slope**2)]
    with np.errstate(all="ignore"):  # far out, and where velocities vanish
        for saddle, slope in saddles[:MOST_SADDLES]:
            search = _Search(field, saddle, slope, half, SHARPER * pace.angle)
            line = next((line for line in search.lines(surfaces) if is_shown(system, line)), None)
            borders += [] if line is None else [(saddle, line)]
    return borders


def left_of(hypotheses: Record, x: Floats) -> Mask:
    """Which places are to the left of a line, in floats: shape (places, 2)."""
    unit = float(Fraction(hypotheses["unit"]))
    half = 1 + int(np.abs(x).max() / unit)
    first, last = map(place_of, hypotheses["ends"])
    whole = closed([place_of(corner) for corner in hypotheses["corners"]], first, last, half)
    return inside_ring(np.array(whole, dtype=float) * unit, x)


@dataclass(frozen=True)
class _Search:
    """A line beside the stable manifold of one saddle.

    Attributes:
        field: its velocities.
        saddle: where it is.
        slope: the Jacobian there.
        half: half-width of the certified region.
        angle: by which the line is turned.
    """

    field: FloatField
    saddle: Floats
    slope: Floats
    half: float
    angle: float

    def lines(self, surfaces: Sequence[str]) -> Iterator[Record]:
        """Hypotheses of lines on either side of the stable manifold, that away from the point first."""
        values, vectors = np.linalg.eig(self.slope)
        order = np.argsort(values.real)
        (falls, grows), (stable, unstable) = values.real[order], vectors.real.T[order]
        for beyond in (unstable, -unstable) if unstable @ self.saddle > 0 else (-unstable, unstable):
            # The line is passed with the point to its left: what is beyond is to its right.
            way = stable if stable[1] * beyond[0] - stable[0] * beyond[1] > 0 else -stable
            near = min(NEAR, self.angle / 4) * float(np.linalg.norm(self.saddle))
            start = self.saddle + near * self.angle * -falls / grows * beyond
            before = self._branch(start - near * way, 1)
            after = None if before is None else self._branch(start + near * way, -1)
            if before is not None and after is not None:
                chain = np.concatenate([before[0][::-1], after[0]])
                ends = [f"{x} {y}" for x, y in (before[1], after[1])]
                yield {**on_lattice(chain, surfaces), "ends": ends}

    def _branch(self, start: Floats, along: int) -> tuple[Floats, tuple[int, int]] | None:
        """Points of a line backward in time until a half-line begins, and its direction.

        Args:
            start: the first point.
            along: 1 where the line is passed as solutions pass, -1 where against them.
        """
        points, step = [start], self.half / 1024
        while len(points) < MOST_POINTS and max_norm(points[-1]) < WINDOWS * self.half:
            direction = self._direction(points[-1], along)
            end = self._half_line(points[-1], along)
            if end is not None:
                return np.array(points), end
            while True:
                middle = self._direction(points[-1] + step / 2 * direction, along)
                after = self._direction(points[-1] + step * middle, along)
                if np.dot(direction, after) > np.cos(BEND * self.angle):
                    break
                step /= 2
                if not step > 2.0**-20 * self.half:
                    return None
            points.append(points[-1] + step * middle)
            step = min(1.5 * step, LONGEST * self.half)
        return None

    def _direction(self, place: Floats, along: int) -> Floats:
        """Backward in time, turned so that velocities lead to the right of the line."""
        velocity = self.field.at(place[None])[0, 0]
        turn = self.angle * along
        (c, s), (x, y) = (np.cos(turn), np.sin(turn)), -velocity / np.linalg.norm(velocity)
        return np.array([c * x - s * y, s * x + c * y])

    def _half_line(self, place: Floats, along: int) -> tuple[int, int] | None:
        """A direction along an axis, away from the region, over which all velocities lead to the right, in floats."""
        for x, y in AXES:
            if place @ (x, y) < AROUND / 2 * self.half:
                continue
            normal = along * np.array([-y, x], dtype=float)  # the first branch is passed inward, the last one outward
            there = place + np.outer(SAMPLES, (x, y)) * self.half
            if (self.field.at(np.concatenate([place[None], there])) @ normal > 0).all():
                return x, y
        return None


# ---- the basin -----------------------------------------------------------------------------------


POWERS, NEARLY_ALL = (2, 0), 0.95  # tried in turn, until triangles fill so much of the last ring
FARTHEST = 1e4  # times the size of the first ring: no ring goes there
MARGIN = 1.25  # of the square around the mesh over which starts are sampled


EFFORTS = {
    "fast": BasinEffort(RingGrowth(0.04, 0.012, 0.04), 41, way=12.0, triangles=40_000, outward=300),
    "best": BasinEffort(RingGrowth(0.007, 0.0025, 0.02), 101, points=20_000, triangles=10_000_000),
}


@dataclass(frozen=True)
class CertifiedBasin:
    """Triangles or tetrahedra of which every start tends to the point.

    Attributes:
        hypotheses: of theorem ``basin``; the mesh is among them.
        sampled: of the starts of a grid around the mesh that come to the point in floats, how many are certified, and
            how many there are.
        outside: the hypotheses of theorem ``outside``: a polygon around the triangles, such that no start outside of it
            comes to the point; None where none is known, and in space.
        traps: other places of rest, in floats, each with such hypotheses: no start inside of a polygon about it does.
        saddles: in floats, each with such hypotheses: no start beyond a line beside it does.
        square: of the starts of that grid, how many are certified, how many are in no trap, not outside of the polygon
            and beyond no line, and how many there are.
        window: that grid: the least and the largest value of each state, in the displacement from the point.
    """

    hypotheses: Record
    sampled: tuple[int, int]
    outside: Record | None = None
    traps: tuple[Beside, ...] = ()
    saddles: tuple[Beside, ...] = ()
    square: tuple[int, int, int] = (0, 0, 0)
    window: tuple[tuple[float, float], ...] = ()

    @property
    def never(self) -> tuple[Record, ...]:
        """The hypotheses of all polygons and lines on one side of which no start comes to the point."""
        polygons = () if self.outside is None else (self.outside,)
        return (*(hypotheses for _, hypotheses in (*self.traps, *self.saddles)), *polygons)

    @property
    def mesh(self) -> Record:
        """As a certificate holds it."""
        return dict(self.hypotheses["mesh"])

    @cached_property
    def corners(self) -> Floats:
        """Places in the displacement from the point, each with its value of W: shape (corners, states + 1)."""
        return mesh_corners(self.mesh)

    @property
    def kind(self) -> str:
        """What simplices are called: triangles or tetrahedra."""
        return NAMES[self.corners.shape[1] - 1]

    @cached_property
    def simplices(self) -> NDArray[np.int64]:
        """The numbers of the corners of each: shape (simplices, states + 1)."""
        return np.array([simplex.split(" ") for simplex in self.mesh[self.kind]], dtype=np.int64)

    @property
    def border(self) -> Floats:
        """The corners on which W is the level, in the plane a ring: shape (corners, states)."""
        return last_ring(self.corners)

    def holds(self, x: Floats) -> Mask:
        """Which places the border goes around: shape (places, states)."""
        if x.shape[1] == 2:
            return inside_ring(self.border, x)
        highest = self.corners[:, -1] == self.corners[:, -1].max()
        outer = self.simplices[highest[self.simplices].sum(axis=1) == 3]  # with a side on the border
        return inside_polyhedron(self.corners[outer[highest[outer]].reshape(-1, 3)][:, :, :3], x)

    @property
    def filled(self) -> float | None:
        """The area of the region, in floats, over that of the polygon, which holds the true one; None without one."""
        return None if self.outside is None else area(self.border) / area(ring_of(self.outside))

    @property
    def share(self) -> float:
        """Of the sampled starts that come to the point, the part that is certified."""
        certified, coming = self.sampled
        return certified / coming if coming else 0.0


def find_basin(
    system: System,
    local: Record,
    surfaces: list[str],
    effort: BasinEffort,
    limit: float | None,
    announce: Announce,
) -> CertifiedBasin | None:
    """A mesh around a level set; None where none is found.

    Args:
        system: in the plane.
        local: hypotheses of theorem ``lyapunov`` with a level on a square, which are shown.
        surfaces: on which the system switches, in the displacement.
        effort: of the search.
        limit: half the side of a square that the mesh may not leave; None without one.
        announce: told what is done, how much of it, and of how much.
    """

    def cells(unit: str) -> Plane:
        return Plane(system, unit, surfaces, Proofs({}))

    field, home = FloatField(cells("1")), AttractedLevel(system, local)
    first = level_ring(field, home)
    if first is None:
        return None
    far = FARTHEST * max_norm(first)
    best: BuiltMesh | None = None
    for power in POWERS:
        built, last = grown_mesh(field, cells, first, effort, min(limit or far, far), announce, power=power)
        if built is not None and (best is None or built.area > best.area):
            best = built
        if best is not None and best.area > NEARLY_ALL * area(last):
            break
    if best is None:
        return None

    hypotheses = {"local": local, "surfaces": surfaces, "mesh": best.record, "below": best.below}
    border = last_ring(best.corners)
    outside, traps, saddles = None, list[Beside](), list[Beside]()
    if limit is None:
        saddles = find_borders(system, surfaces, border, effort.pace)
        outside = find_outer_ring(system, surfaces, border, effort.pace, effort.outward)
        traps = find_traps(system, surfaces, border, effort.pace, effort.outward)
    starts = _grid(border, effort.starts, limit)
    certified = inside_ring(border, starts)
    masks = [~inside_ring(ring_of(trap), starts) for _, trap in traps] + [left_of(line, starts) for _, line in saddles]
    masks += [] if outside is None else [inside_ring(ring_of(outside), starts)]
    open_ones = np.all([np.ones(len(starts), dtype=bool), *masks], axis=0)
    square = int(np.sum(certified)), int(np.sum(open_ones)), len(starts)
    sampled = square[0], square[0] + _come(field, home, border, starts[~certified & open_ones])
    return CertifiedBasin(hypotheses, sampled, outside, tuple(traps), tuple(saddles), square, _ends(starts))


def find_basin_in_space(
    system: System,
    local: Record,
    surfaces: list[str],
    budget: str,
    limit: float,
    announce: Announce,
) -> CertifiedBasin | None:
    """A mesh around a level set in three states; None where none is found.

    Args:
        system: in three states.
        local: hypotheses of theorem ``lyapunov`` with a level on a cube, which are shown.
        surfaces: on which the system switches, in the displacement.
        budget: how much may be done.
        limit: half the side of a cube that the mesh does not leave, unless it begins in a wider one.
        announce: told what is done, how much of it, and of how much.
    """
    field, home, effort = FloatField.of(system, surfaces), AttractedLevel(system, local), IN_SPACE[budget]
    front = Front(field, home, limit, effort)
    grown = front.grown(partial(announce, "polyhedra"))
    if len(grown) < 2:
        return None
    mesh = front.record(grown)
    hypotheses = {"local": local, "surfaces": surfaces, "mesh": mesh, "below": len(grown) - 1}
    basin = CertifiedBasin(hypotheses, (0, 0))
    starts = _grid(basin.border, effort.starts, None)
    certified = basin.holds(starts) | home(starts)
    count = int(np.sum(certified))
    came = _come(field, home, basin.border, starts[~certified])
    return replace(basin, sampled=(count, count + came), window=_ends(starts))


def _grid(border: Floats, count: int, limit: float | None) -> Floats:
    """Starts around the mesh.

    Those of them that are certified come, too; a step that is too long to see that does not change what is proved.
    """
    low, high = border.min(axis=0), border.max(axis=0)
    middle, half = (low + high) / 2, MARGIN * (high - low) / 2
    if limit is not None:
        half = np.minimum(half, limit)
    lines = [np.linspace(m - h, m + h, count) for m, h in zip(middle, half, strict=True)]
    return np.stack(np.meshgrid(*lines), axis=-1).reshape(-1, len(lines))


def _ends(starts: Floats) -> tuple[tuple[float, float], ...]:
    """The least and the largest value of each state."""
    return tuple(zip(starts.min(axis=0).tolist(), starts.max(axis=0).tolist(), strict=True))


def _come(field: FieldInCells, is_home: Callable[[Floats], Mask], border: Floats, starts: Floats) -> int:
    """How many of some starts come to the first ring in floats."""
    far = 20 * float(row_norms(border).max())
    return int(np.sum(followed_home(field, starts, is_home, far)))
