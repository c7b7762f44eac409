"""Rule ``nearest``: the contact states of the paper (Murphey & Burdick, sec. 3.1) and their exact cells.

Wheels are ordered by distance to the centre of mass; within a wheel the row with the larger friction comes
first; rows are taken greedily while independent, until three.  Both rows of the nearest wheel i are always
independent, and of the second-nearest wheel j one row at least completes them (a rigid motion that leaves
``p_i`` at rest and both rows of j idle is zero, since ``p_j != p_i``).  So the contact state depends on the
ordered pair (i, j) alone and its cells are the ordered order-2 Voronoi cells, cut exactly by bisectors.

Floats only propose which wheels can be among the two nearest; the margin keeps every doubtful one.
``nearest_states`` at the end is the slow literal definition of the rule, with which the tests and the study
``precision`` compare the cells; no verdict uses it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.partitions.partition import PARTITION_UNITS, Cell, Partition, affordable
from nonsmooth.analysis.partitions.polygon import HalfPlane, Point, Polygon, square
from nonsmooth.symbolic.constraints import Row, roll_row, side_row
from nonsmooth.symbolic.contact_states import ContactState, solve_rows
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.rule import Rule
from nonsmooth.symbolic.scene import Scene, Wheel, dot

# Relative to the coordinates and distances at hand: in double precision they err by less than 1e-14, so a wheel
# beyond this margin is certainly not among the two nearest, and a wheel within it is kept for the exact test.
CANDIDATE_MARGIN = 1e-9
SMALLEST_NORMAL = np.finfo(np.float64).tiny  # below it floats lose their relative accuracy


def build_nearest_partition(scene: Scene, *, prune: bool = True) -> Partition:
    """Cells of rule ``nearest`` in the checked square.

    Args:
        scene: the array.
        prune: look only at wheels that can be among the two nearest; without, at every pair.
    """
    domain = square(scene.check.equilibrium, scene.check.radius)
    positions = np.array([[float(p) for p in wheel.position] for wheel in scene.wheels])
    everyone = np.arange(len(scene.wheels))
    active = _contenders(positions, everyone, domain, 2) if prune else everyone
    cells: list[Cell] = []
    with affordable(scene, PARTITION_UNITS, "cells of rule nearest"):
        for i, j, polygon in _ordered_pairs(scene.wheels, positions, active, domain, prune=prune):
            cells.append(Cell(len(cells) + 1, polygon, pair_states(scene.wheels[i], scene.wheels[j])))
    return Partition(scene, Rule.NEAREST, domain, tuple(cells), len(active))


def _ordered_pairs(
    wheels: Sequence[Wheel],
    positions: NDArray[np.float64],
    active: NDArray[np.int_],
    domain: Polygon,
    *,
    prune: bool,
) -> Iterator[tuple[int, int, Polygon]]:
    """(nearest, second-nearest, cell) for every pair that owns area in the domain."""
    places = positions if prune else None
    bisectors = _Bisectors(wheels)
    for i in active:
        rivals = active[np.argsort(_distances(positions[active], positions[i]), kind="stable")]
        first = _region(bisectors, i, rivals, domain, places, by_distance=True)
        if first is None:
            continue
        others = active[active != i]
        contenders = _contenders(positions, others, first, 1) if prune else others
        for j in contenders:
            cell = _region(bisectors, j, contenders, first, places)
            if cell is not None:
                yield int(i), int(j), cell


def _contenders(
    positions: NDArray[np.float64], among: NDArray[np.int_], region: Polygon, rank: int
) -> NDArray[np.int_]:
    """Wheels that can be among the ``rank`` nearest somewhere in the region, nearest to its centre first.

    With reach r of the region about its centre, a wheel farther from the centre than the rank-th nearest
    wheel plus 2 r cannot.  Where coordinates overflow the distance is nan, and the wheel is kept.
    """
    centre = np.array([float(x) for x in region.centre])
    vertices = np.array([[float(x), float(y)] for x, y in region.vertices])
    rank = min(rank, len(among))
    with np.errstate(over="ignore", invalid="ignore"):
        reach = np.max(np.hypot(*(vertices - centre).T))
        distances = np.hypot(*(positions[among] - centre).T)
        bound = np.partition(distances, rank - 1)[rank - 1] + 2 * reach
        slack = CANDIDATE_MARGIN * (bound + np.hypot(*centre)) + SMALLEST_NORMAL
        near = np.flatnonzero(~(distances > bound + slack))
    order = near[np.argsort(distances[near], kind="stable")]
    return np.asarray(among[order])


def _region(
    bisectors: _Bisectors,
    i: int,
    rivals: Iterable[int],
    within: Polygon,
    positions: NDArray[np.float64] | None = None,
    *,
    by_distance: bool = False,
) -> Polygon | None:
    """Points of ``within`` at least as near to wheel i as to every rival.

    Args:
        bisectors: of all wheels.
        i: the wheel.
        rivals: the others, also i itself.
        within: where the points are sought.
        positions: of all wheels in floats, which decide the clear signs; without, every sign is exact.
        by_distance: whether the rivals come in the order of their distance from wheel i.  Then it stops at the first
            rival whose bisector lies beyond the farthest vertex: twice as far from the wheel as that.
    """
    region = within
    corners = None if positions is None else _float_vertices(region)
    for k in rivals:
        if k == i:
            continue
        known = None
        if positions is not None and corners is not None:
            if by_distance and _distances(positions[k], positions[i]) > 2 * _reach(corners, positions[i]):
                break
            known = _clear_signs(corners, positions[i], positions[k])
            if min(known) > 0:
                continue
        closer = region.clipped(bisectors.between(i, k), known)
        if closer is None:
            return None
        if closer is not region and positions is not None:
            corners = _float_vertices(closer)
        region = closer
    return region


def _float_vertices(region: Polygon) -> NDArray[np.float64]:
    return np.array([[float(x), float(y)] for x, y in region.vertices])


def _clear_signs(corners: NDArray[np.float64], near: NDArray[np.float64], far: NDArray[np.float64]) -> list[int]:
    """Signs of ``|c - far| - |c - near|`` at corners where floats are sure, 0 where they are not."""
    to_near, to_far = _distances(corners, near), _distances(corners, far)
    with np.errstate(over="ignore", invalid="ignore"):
        size = np.abs(corners).max() + np.abs(near).max() + np.abs(far).max()
        farther = to_far - to_near
        clear = np.abs(farther) > CANDIDATE_MARGIN * (size + to_far + to_near) + SMALLEST_NORMAL
        signs: list[int] = np.where(clear, np.sign(farther), 0).astype(int).tolist()
    return signs


def _reach(corners: NDArray[np.float64], place: NDArray[np.float64]) -> float:
    """Distance from a wheel to the farthest vertex, never too small."""
    with np.errstate(over="ignore", invalid="ignore"):
        size = np.abs(corners).max() + np.abs(place).max()
        return float(_distances(corners, place).max() + CANDIDATE_MARGIN * size + SMALLEST_NORMAL)


def _distances(points: NDArray[np.float64], place: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(over="ignore", invalid="ignore"):
        difference = points - place
        return np.asarray(np.hypot(difference[..., 0], difference[..., 1]))


class _Bisectors:
    """The bisectors of pairs of wheels, each computed once."""

    def __init__(self, wheels: Sequence[Wheel]) -> None:
        self._wheels = wheels
        self._known: dict[tuple[int, int], HalfPlane] = {}

    def between(self, near: int, far: int) -> HalfPlane:
        """See :func:`bisector`; wheels by their places in the list."""
        if (near, far) not in self._known:
            self._known[near, far] = bisector(self._wheels[near], self._wheels[far])
        return self._known[near, far]


def bisector(near: Wheel, far: Wheel) -> HalfPlane:
    """``|c - p_near|^2 <= |c - p_far|^2``, linear in c."""
    (a, b), (c, d) = near.position, far.position
    normal = (2 * (c - a), 2 * (d - b))
    offset = dot(far.position, far.position) - dot(near.position, near.position)
    return HalfPlane(normal, offset, f"{near.index}|{far.index}")


def pair_states(nearest: Wheel, second: Wheel) -> tuple[ContactState, ...]:
    """Contact states for an ordered pair: one, or two where the second wheel's friction ties."""
    pair = (roll_row(nearest), side_row(nearest))
    states = [solve_rows((*pair, row)) for row in preferred_rows(second)]
    regular = tuple(state for state in states if state is not None)
    tie = second.friction.roll == second.friction.side
    return regular if tie else regular[:1]


def preferred_rows(wheel: Wheel) -> tuple[Row, Row]:
    """The wheel's rows, larger friction first (roll first on a tie)."""
    roll, side = roll_row(wheel), side_row(wheel)
    return (side, roll) if sign(wheel.friction.side - wheel.friction.roll) > 0 else (roll, side)


def nearest_states(scene: Scene, point: Point) -> tuple[ContactState, ...]:
    """Literal rule at one point, for a strict order of distances: the slow definition the cells are tested against."""
    ordered = sorted(scene.wheels, key=lambda w: (point[0] - w.position[0]) ** 2 + (point[1] - w.position[1]) ** 2)
    return pair_states(ordered[0], ordered[1])
