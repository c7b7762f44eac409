"""Rule ``nearest``: the contact states of the paper (Murphey & Burdick, sec. 3.1) and their exact cells.

Wheels are ordered by distance to the centre of mass; within a wheel the row with the larger friction comes
first; rows are taken greedily while independent, until three.  A row without friction (coefficient zero) limits
nothing and is never taken.  Where friction ties within a wheel, either row may come first.

So the cells are those of an ordered Voronoi diagram: points with the same nearest wheel, then with the same nearest
one among the wheels that still have an independent row, and so on.  Where every row has friction, two wheels do:
both rows of the nearest wheel i are independent, and of the second-nearest wheel j one row at least completes
them (a rigid motion that leaves ``p_i`` at rest and both rows of j idle is zero, since ``p_j != p_i``).

Floats only propose which wheels can be the next; the margin keeps every doubtful one, and bisectors cut exactly.
``nearest_states`` at the end is the slow literal definition of the rule, with which the tests and the study
``precision`` compare the cells; no verdict uses it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.partition import PARTITION_UNITS, Cell, Partition, affordable, require_rank
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, checked_square, clipped_by
from nonsmooth.symbolic.mechanics.contact_states import (
    ContactState,
    Row,
    RowKind,
    Triple,
    independent,
    roll_row,
    rows_with_friction,
    side_row,
    solve_rows,
)
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import dot, in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, float_points, norms, places_of


def build_nearest_partition(scene: Scene, *, prune: bool = True, domain: Polygon | None = None) -> Partition:
    """Cells of rule ``nearest`` in the checked square, or in another convex domain.

    Args:
        scene: the array.
        prune: look only at wheels that can be among the nearest ones; without, at every wheel.
        domain: in place of the square.

    Raises:
        RefusalError: where the rows with friction leave a motion free.
    """
    _require_friction(scene)
    domain = domain or checked_square(scene)
    search = _Search(scene, prune)
    cells: list[Cell] = []
    with affordable(scene, PARTITION_UNITS, "cells of rule nearest"):
        for chain, polygon in search.chains(domain):
            cells.append(Cell(len(cells) + 1, polygon, greedy_states(scene.wheels[i] for i in chain)))
    return Partition(scene, "nearest", domain, tuple(cells), len(search.considered))


def nearest_partition_like(scene: Scene, known: Partition) -> Partition | None:
    """The cells of an array by those of another one whose wheels stand alike; None where they do not.

    Speeds, headings and coefficients move no side of a cell where every wheel has friction in both directions.
    """
    places = _rational_places(scene)
    if places is None or known.rule != "nearest" or places != _rational_places(known.scene):
        return None
    wheels = {wheel.index: wheel for wheel in scene.wheels}
    cells = tuple(
        Cell(cell.index, cell.polygon.over(scene.field), greedy_states(wheels[k] for k in cell.wheels))
        for cell in known.cells
    )
    return replace(known, scene=scene, domain=known.domain.over(scene.field), cells=cells, like=known.like or known)


def _rational_places(scene: Scene) -> list[Any] | None:
    """Where the wheels stand, and the checked square, where all of that is rational and no row is without friction."""
    points = *scene.positions, scene.check.equilibrium
    numbers = *chain.from_iterable(points), scene.check.radius
    found = [number.as_rational() if type(number) is Number else None for number in numbers]
    is_plain = all(map(has_friction, scene.wheels)) and None not in found
    return [*found, *scene.numbers] if is_plain else None


def relevant_wheels(scene: Scene) -> tuple[Wheel, ...]:
    """The wheels that can have a say in the checked square."""
    search = _Search(scene, prune=True)
    for _ in search.chains(checked_square(scene)):
        pass
    return tuple(scene.wheels[i] for i in sorted(search.considered))


def _require_friction(scene: Scene) -> None:
    """Refuse rows with friction that leave a motion free; both rows of two wheels never do."""
    whole = (wheel for wheel in scene.wheels if has_friction(wheel))
    if len(list(islice(whole, 2))) < 2:
        require_rank(rows_with_friction(scene), "friction: required rows")


def has_friction(wheel: Wheel) -> bool:
    """Whether both rows of a wheel have friction."""
    return bool(wheel.friction.roll) and bool(wheel.friction.side)


class _Search:
    """The ordered chains of wheels whose rows are taken, and where.

    Attributes:
        considered: the wheels that can be in a chain somewhere, by their positions in the scene.
    """

    def __init__(self, scene: Scene, prune: bool) -> None:
        self.wheels, self.prune, self.positions = scene.wheels, prune, places_of(scene.wheels)
        self.bisectors = _Bisectors(scene.wheels)
        self.considered: set[int] = set()

    def chains(self, domain: Polygon) -> Iterator[tuple[tuple[int, ...], Polygon]]:
        """Every chain with its cell, of positive area."""
        everyone = np.arange(len(self.wheels))
        # three rows in all are taken everywhere, whatever the order
        if len(everyone) <= 3 and sum(map(_count_rows, self.wheels)) == 3:
            self.considered.update(everyone.tolist())
            yield tuple(sorted(everyone.tolist(), key=lambda i: -_count_rows(self.wheels[i]))), domain
            return
        near = _contenders(self.positions, everyone, domain, 2) if self.prune else everyone
        self.considered.update(near.tolist())
        if all(has_friction(self.wheels[i]) for i in near):
            yield from self._pairs(near, domain)
        else:
            yield from self._longer((), domain)

    def _pairs(self, near: Indices, domain: Polygon) -> Iterator[tuple[tuple[int, ...], Polygon]]:
        """(nearest, second-nearest) where all these wheels have friction in both directions."""
        for i in near:
            distances = distances_from(self.positions[near], self.positions[i])
            first = _certain_region(self.bisectors, i, near[np.argsort(distances, kind="stable")], domain)
            if first is None:
                continue
            others = near[near != i]
            contenders = _contenders(self.positions, others, first, 1) if self.prune else others
            for j in contenders:
                cell = _certain_region(self.bisectors, j, contenders, first)
                if cell is not None:
                    yield (int(i), int(j)), cell

    def _longer(self, chain: tuple[int, ...], region: Polygon) -> Iterator[tuple[tuple[int, ...], Polygon]]:
        """Chains that begin as given, one wheel after the other, until their rows leave no motion free."""
        basis = _basis(self.wheels[i] for i in chain)
        if len(basis) == 3:
            yield chain, region
            return
        following = self._next(basis, region)
        self.considered.update(following)
        for i in following:
            part = _region(self.bisectors, i, following, region)
            if part is not None:
                yield from self._longer((*chain, i), part)

    def _next(self, basis: Sequence[Triple], region: Polygon) -> list[int]:
        """Wheels that can be the nearest, somewhere in the region, of those with a row independent of the basis."""
        centre = in_floats(region.centre)
        distances = distances_from(self.positions, np.array(centre))
        reach = reach_of(float_vertices(region), centre)
        found: list[int] = []
        bound = np.inf
        for i in np.argsort(distances, kind="stable").tolist():
            if self.prune and distances[i] > bound:
                break
            if _adds_to(basis, self.wheels[i]):
                if not found:
                    bound = distances[i] + 2 * reach
                    bound += CANDIDATE_MARGIN * (bound + math.hypot(*centre)) + SMALLEST_NORMAL
                found.append(i)
        return found


def _count_rows(wheel: Wheel) -> int:
    """How many rows of a wheel have friction."""
    return bool(wheel.friction.roll) + bool(wheel.friction.side)


def _basis(wheels: Iterable[Wheel]) -> list[Triple]:
    """Independent normals among the rows with friction of some wheels."""
    normals = [row.normal for wheel in wheels for row in preferred_rows(wheel)]
    return [normals[k] for k in independent(normals)]


def _adds_to(basis: Sequence[Triple], wheel: Wheel) -> bool:
    """Whether a wheel has a row with friction that is independent of the normals of a basis."""
    return any(len(independent([*basis, row.normal])) > len(basis) for row in preferred_rows(wheel))


def _contenders(positions: Floats, among: Indices, region: Polygon, rank: int) -> Indices:
    """Wheels that can be among the ``rank`` nearest somewhere in the region, nearest to its centre first.

    With reach r of the region about its centre, a wheel farther from the centre than the rank-th nearest
    wheel plus 2 r cannot.  Where coordinates overflow the distance is nan, and the wheel is kept.
    """
    centre = np.array(region.centre, float)
    vertices = float_points(region.vertices)
    rank = min(rank, len(among))
    with np.errstate(over="ignore", invalid="ignore"):
        reach = np.max(norms(vertices - centre))
        distances = norms(positions[among] - centre)
        bound = np.partition(distances, rank - 1)[rank - 1] + 2 * reach
        slack = CANDIDATE_MARGIN * (bound + np.hypot(*centre)) + SMALLEST_NORMAL
        near = np.flatnonzero(~(distances > bound + slack))
    order = near[np.argsort(distances[near], kind="stable")]
    return among[order]


def _region(bisectors: _Bisectors, i: int, rivals: Iterable[int], within: Polygon) -> Polygon | None:
    """Points of ``within`` at least as near to wheel i as to every rival, among which it may be itself."""
    return clipped_by(within, (bisectors.between(i, int(k)) for k in rivals if k != i))


def _certain_region(bisectors: _Bisectors, i: int, rivals: Indices, within: Polygon) -> Polygon | None:
    """The same region; of rounded places what counts is whether its shape is certain, not the way to it.

    It is where every corner lies certainly on its side of every line but its own two; and where there is no region, if
    one bisector certainly excludes all corners.
    """
    field = bisectors.field
    before = field.rounded_signs
    region = _region(bisectors, i, rivals, within)
    if field.rounded_signs == before:
        return region
    lines = [bisectors.between(i, int(k)) for k in rivals if k != i]
    if region is None:
        uncertain = min(_uncertain_signs(line, within.vertices, above=0) for line in lines)
    else:
        corners = [(corner, (region.sides[k - 1], region.sides[k])) for k, corner in enumerate(region.vertices)]
        uncertain = sum(
            _uncertain_signs(line, [corner for corner, through in corners if line not in through])
            for line in (*within.sides, *lines)
        )
    field.rounded_signs = before + uncertain
    return region


def _uncertain_signs(line: HalfPlane, corners: Iterable[Point], above: int = 1) -> int:
    """How many corners lie on a side of a line that is not certain, or on its inner side where ``above`` is 0."""
    uncertain = 0
    for corner in corners:
        slack = line.slack(corner)
        before = slack.field.rounded_signs
        uncertain += sign(slack) > above or slack.field.rounded_signs > before
    return uncertain


class _Bisectors:
    """The bisectors of pairs of wheels, each computed once."""

    def __init__(self, wheels: Sequence[Wheel]) -> None:
        self._wheels = wheels
        self.field = wheels[0].position[0].field
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


def greedy_states(ordered: Iterable[Wheel]) -> tuple[ContactState, ...]:
    """The contact states of wheels in the order of their distance: several where friction ties within a wheel.

    As many wheels are looked at as it takes to leave no motion free; both rows of a wheel are listed roll row first.
    """
    branches: list[tuple[Row, ...]] = [()]
    for wheel in ordered:
        orders = [preferred_rows(wheel)]
        if wheel.friction.roll == wheel.friction.side:
            orders.append(orders[0][::-1])
        branches = _distinct(_extended(taken, order) for taken in branches for order in orders)
        if len(branches[0]) == 3:
            break
    states = [solve_rows((rows[0], rows[1], rows[2])) for rows in branches if len(rows) == 3]
    return tuple(state for state in states if state is not None)


def _extended(taken: tuple[Row, ...], rows: Sequence[Row]) -> tuple[Row, ...]:
    """The rows taken, with those of the next wheel that are independent of all before, at most three.

    Both rows of the first wheel are, at right angles to each other.
    """
    added: list[Row] = [] if taken else [*rows]
    for row in rows if taken else ():
        normals = [r.normal for r in (*taken, *added, row)]
        if len(normals) <= 3 and len(independent(normals)) == len(normals):
            added.append(row)
    return (*taken, *sorted(added, key=lambda row: row.kind is RowKind.SIDE))


def _distinct(branches: Iterable[tuple[Row, ...]]) -> list[tuple[Row, ...]]:
    """Without repetitions of the same rows."""
    listed = list(branches)
    if len(listed) == 1:  # by far the most
        return listed
    return list({frozenset(row.name for row in rows): rows for rows in reversed(listed)}.values())[::-1]


def preferred_rows(wheel: Wheel) -> tuple[Row, ...]:
    """The wheel's rows with friction, larger friction first (roll first on a tie)."""
    roll, side = roll_row(wheel), side_row(wheel)
    ordered = (side, roll) if sign(wheel.friction.side - wheel.friction.roll) > 0 else (roll, side)
    return tuple(row for row in ordered if row.friction)


# ---- distances in floats -------------------------------------------------------------------------
#
# What lies beyond a margin is certain; what lies within it is left to exact arithmetic.


Place: TypeAlias = Sequence[float]  # x, y

# Relative to the coordinates and distances at hand: in double precision they err by less than 2^-46, so a wheel
# beyond this margin is certainly not among the two nearest, and a wheel within it is kept for the exact test.
CANDIDATE_MARGIN = 2.0**-29
SMALLEST_NORMAL = float(np.finfo(np.float64).tiny)  # below it floats lose their relative accuracy


def float_vertices(region: Polygon) -> list[Place]:
    """The vertices of a region in floats."""
    return [in_floats(vertex) for vertex in region.vertices]


def reach_of(corners: Sequence[Place], place: Place) -> float:
    """Distance from a wheel to the farthest vertex, never too small."""
    size = _size(corners) + _size([place])
    return max(math.dist(corner, place) for corner in corners) + CANDIDATE_MARGIN * size + SMALLEST_NORMAL


def _size(places: Sequence[Place]) -> float:
    """The largest coordinate."""
    return max(abs(value) for place in places for value in place)


def distances_from(points: Floats, place: Floats) -> Floats:
    """``|p - q|`` for many points p, shape (n, 2), at once."""
    with np.errstate(over="ignore", invalid="ignore"):
        difference = points - place
        return norms(difference)
