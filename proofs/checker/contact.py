"""The cells of an array: convex polygons that cover the checked square, with the twists that the rule gives in each.

A certificate lists the corners of the cells as points ``(X, Y, W)``, W > 0, for ``(X/W, Y/W)``, and in each cell the
wheels that act and the twists.  Which twists there must be is derived here, from the wheels alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from .plane import around, turns_once
from .tower import Vector, charge, cross, dot, has_rank_three, is_zero, normal_to, signs
from .wheels import NEAREST, Array, Row, edge_slopes, friction_limits
from .work import items, require, take, whole


@dataclass(frozen=True)
class Motion:
    """One twist of a cell.

    Attributes:
        cell: number of the cell, from 0.
        rows: the rows that give it.
        twist: ``(vx, vy, omega, 1)``.
        rates: signs of ``V*/2 = c . v`` for ``V = |c|^2`` at the cell's corners other than the checked point.
    """

    cell: int
    rows: tuple[Row, ...]
    twist: Vector
    rates: tuple[int, ...]


@dataclass(frozen=True)
class Cell:
    """A convex polygon with its motions.

    Attributes:
        polygon: numbers of its corners, counterclockwise.
        corners: the corners.
        acting: the wheels that act, as JSON.
        motions: all twists that the rule gives in it.
        rays: numbers of the corners after and before the checked point, the rays of the cell's cone there;
            ``(-1, -1)`` where the point lies inside, None where it does not lie in the cell.
    """

    polygon: tuple[int, ...]
    corners: tuple[Vector, ...]
    acting: Any
    motions: tuple[Motion, ...]
    rays: tuple[int, int] | None


class Cells:
    """The cells of a certificate.

    The claims: the polygons are convex and cover the square once, and the listed twists are those of the rule, and no
    others, at every point of their cell.

    Attributes:
        points: the corners of all cells.
        listed: the cells.
        motions: of all of them.
        here: the motions of the cells whose closures hold the checked point.
        highest: the largest sign of V* near the point, for ``V = |c|^2``.
    """

    def __init__(self, array: Array, points: Any, cells: Any) -> None:
        self.array, self.zero, self.one = array, array.field.rational(0), array.field.rational(1)
        self.parse, self.vector, self.rational = array.field.parse, array.field.vector, array.field.rational
        self.points = [self.vector(point, 3) for point in items(points)]
        require(min(signs(point[2] for point in self.points), default=0) > 0, "points with positive weights")
        self._rule = _Nearest(array) if array.rule == NEAREST else _Box(array)
        self.listed = [self._read(number, data) for number, data in enumerate(items(cells))]
        self._require_cover()
        self.here = [motion for cell in self.listed if cell.rays is not None for motion in cell.motions]
        self.highest = max(max(motion.rates) for motion in self.here)

    def _read(self, number: int, data: Any) -> Cell:
        polygon_data, acting, twists_data = take(data, "polygon wheels twists")
        name = f"cell {number}"
        polygon = [whole(k, len(self.points) - 1) for k in items(polygon_data)]
        corners = [self.points[k] for k in polygon]
        self.require_convex(name, corners)
        twists = [(*self.vector(twist, 3), self.one) for twist in items(twists_data)]
        rows = self._rule.rows(name, acting, twists, corners)
        origin = [k for k, corner in enumerate(corners) if is_zero(corner[:2])]
        away = [corner[:2] for k, corner in enumerate(corners) if k not in origin]
        motions = tuple(
            Motion(number, motion_rows, twist, tuple(dot(twist, place).sign() for place in away))
            for motion_rows, twist in zip(rows, twists, strict=True)
        )
        rays = self._rays(name, polygon, corners, origin)
        return Cell(tuple(polygon), tuple(corners), acting, motions, rays)

    def require_convex(self, name: str, corners: Sequence[Vector]) -> None:
        """Each side turns left of the last one, or goes straight on; and all of them turn around once."""
        sides = [(q[0] * p[2] - p[0] * q[2], q[1] * p[2] - p[1] * q[2]) for p, q in around(corners)]
        turns = around(sides)
        bends = [(cross(a, b).sign(), dot(a, b).sign()) for a, b in turns]
        require(min(bends) > (0, 0) and turns_once(turns), f"{name}: a convex polygon, counterclockwise")

    def _rays(
        self, name: str, polygon: Sequence[int], corners: Sequence[Vector], origin: list[int]
    ) -> tuple[int, int] | None:
        """The checked point lies in the cell iff it lies left of, or on, every side; on a side it is a corner."""
        views = [cross(a, b).sign() for a, b in around(corners)]
        if min(views) < 0:
            return None
        require(bool(origin) == (min(views) == 0), f"{name}: the checked point as a corner")
        if not origin:
            return (-1, -1)
        place, count = origin[0], len(polygon)
        return polygon[(place + 1) % count], polygon[place - 1]

    def _require_cover(self) -> None:
        """The cells cover the square ``|x|, |y| <= radius`` once, and each point is a corner of one.

        Neighbours list the same side in opposite senses, so these cancel.  What is left runs along the border of the
        square, counterclockwise and around once: so every point of the square is surrounded once by polygons that do
        not overlap.
        """
        sides = [side for cell in self.listed for side in around(cell.polygon)]
        unique = set(sides)
        used = {k for side in sides for k in side}
        once = len(sides) == len(unique) and used == set(range(len(self.points)))
        border = [(self.points[a], self.points[b]) for a, b in unique - {(b, a) for a, b in unique}]
        along = once and all(self._lies_on_one_edge(side) for side in border)
        sound = along and all(cross(a, b).sign() > 0 for a, b in border) and turns_once(border)
        require(sound, "cells that cover the square once, with each point as a corner")

    def _lies_on_one_edge(self, side: tuple[Vector, Vector]) -> bool:
        edges = [(axis, edge) for axis in (0, 1) for edge in (self.array.radius, -self.array.radius)]
        return any(is_zero(point[axis] - edge * point[2] for point in side) for axis, edge in edges)


# ---- the rules -----------------------------------------------------------------------------------


class _Nearest:
    """Rule nearest: rows are taken from the wheels by distance, as long as they are independent, until three.

    Of one wheel the row of larger friction comes first, and either where both have the same.  A row without friction
    limits nothing and is never taken.  A cell names the wheels that are taken, the nearest first.
    """

    def __init__(self, array: Array) -> None:
        self.array = array
        self.orders = {k: self._orders(k) for k in array.wheels}
        # of two rows, to both; and what cells ask again and again
        self.normal = cache(lambda a, b: normal_to(array.rows[a], array.rows[b]))
        self.is_independent = cache(self._is_independent)
        # |c - p|^2 - |c|^2 as a form in (c, 1)
        self.distances: dict[int, Vector] = {}
        for k, wheel in array.wheels.items():
            p, q, _ = wheel.place
            self.distances[k] = (p * -2, q * -2, p * p + q * q)

    def _orders(self, k: int) -> list[list[Row]]:
        """The rows of a wheel that have friction, in each order in which they may be taken."""
        along, across = self.array.wheels[k].friction
        able = [row for row, mu in ((("R", k), along), (("S", k), across)) if mu.sign()]
        gap = (across - along).sign()
        if len(able) < 2 or gap < 0:
            return [able]
        return [able[::-1]] if gap > 0 else [able, able[::-1]]

    def rows(
        self, name: str, acting: Any, twists: Sequence[Vector], corners: Sequence[Vector]
    ) -> list[tuple[Row, ...]]:
        """The rows of each motion, one after the other; the claims: each twist obeys its rows, and wheels are nearest.

        Distances differ by functions that are affine in c, so their order at the corners is that in the cell.
        """
        chain = [whole(k, len(self.array.wheels)) for k in items(acting, most=3)]
        branches: list[tuple[Row, ...]] = [()]
        able = set(self.distances)
        steps = []
        for k in chain:
            able = {n for n in able if self._adds_to(branches[0], n)}
            require(k in able, f"{name}: wheels that the rule takes")
            able.discard(k)
            steps.append((k, set(able)))
            branches = [self._extended(branch, order) for branch in branches for order in self.orders[k]]
        require(len(branches[0]) == 3, f"{name}: wheels that leave no motion free")
        if sum(len(orders[0]) for orders in self.orders.values()) > 3:  # else all of them are taken, in any order
            self._require_nearest(name, steps, corners)
        rows = list(
            dict.fromkeys(tuple(sorted(branch, key=lambda row: (chain.index(row[1]), row))) for branch in branches)
        )
        obeyed = len(rows) == len(twists)
        for motion_rows, twist in zip(rows, twists, strict=False):
            obeyed = obeyed and is_zero(dot(self.array.rows[row], twist) for row in motion_rows)
        require(obeyed, f"{name}: a twist for each choice of rows, which it obeys")
        return rows

    def _adds_to(self, taken: tuple[Row, ...], k: int) -> bool:
        """Whether a wheel has a row that may be taken after others."""
        return len(self._extended(taken, self.orders[k][0])) > len(taken)

    def _extended(self, taken: tuple[Row, ...], order: Sequence[Row]) -> tuple[Row, ...]:
        """Rows with those of one wheel, as long as they are independent, until three."""
        charge(8)  # the answers are remembered
        for row in order:
            if len(taken) < 3 and self.is_independent(taken, row):
                taken = (*taken, row)
        return taken

    def _is_independent(self, taken: tuple[Row, ...], row: Row) -> bool:
        """Whether a row is independent of independent ones; no row is zero, since directions are unit vectors."""
        if len(taken) < 2:
            return not taken or not is_zero(self.normal(*taken, row))
        return bool(dot(self.normal(*taken), self.array.rows[row]).sign())

    def _require_nearest(self, name: str, steps: Sequence[tuple[int, set[int]]], corners: Sequence[Vector]) -> None:
        """Each wheel taken is at least as near as every other one that might be taken in its place.

        Those that might be taken next too are farther than the next one, and need not be compared.
        """
        following = [*steps[1:], (0, set[int]())]
        for (near, able), (_, still) in zip(steps, following, strict=True):
            for far in able - still:
                line = [b - a for a, b in zip(self.distances[near], self.distances[far], strict=True)]
                ahead = all(dot(line, corner).sign() >= 0 for corner in corners)
                apart = not is_zero(line[:2])
                require(apart and ahead, f"{name}: wheels by their distance, at every corner")


class _Box:
    """Rule box: the twists minimize ``D = sum N_i (mu_R |d_i . v(p_i) - u_i| + mu_S |n_i . v(p_i)|)``.

    D is convex and piecewise linear, so a twist at which no slope along an edge is negative is a minimizer; slopes are
    affine in c, so the corners decide.  Where a slope vanishes at all corners D is flat along the edge, which then
    leads to another twist of the list.  A cell names the wheels that carry load, where the loads are elastic.
    """

    def __init__(self, array: Array) -> None:
        self.array = array

    def rows(
        self, name: str, acting: Any, twists: Sequence[Vector], corners: Sequence[Vector]
    ) -> list[tuple[Row, ...]]:
        """The rows that each twist satisfies; the claim: the twists are the minimizers of D that its edges join."""
        require(twists, f"{name}: a twist")
        limits, rows, tight_rows = friction_limits(self.array, acting, corners), self.array.rows, []
        for twist in twists:
            slips = {row: dot(normal, twist).sign() for row, normal in rows.items()}
            tight = tuple(row for row, side in slips.items() if not side)
            require(has_rank_three([rows[row] for row in tight]), f"{name}: twists that satisfy rows of rank three")
            gaps = [tuple(a - b for a, b in zip(other, twist, strict=True))[:3] for other in twists]
            for way, slopes in edge_slopes(rows, slips, limits):
                sound = min(slopes) >= 0 and (max(slopes) > 0 or _leads_along(way, gaps))
                require(sound, f"{name}: all twists that minimize D")
            tight_rows.append(tight)
        return tight_rows


def _leads_along(way: Vector, gaps: Sequence[Vector]) -> bool:
    """Whether one of the gaps is a positive multiple of a direction."""
    return any(dot(way, gap).sign() > 0 and is_zero(normal_to(gap, way)) for gap in gaps)
