"""Edges of a partition where the motion switches: which are slid along, which are left, where the body rests.

On an edge with constant twists on both sides the normal speeds of the two neighbours are affine in the position, so
the stretch where both point to the edge is an interval whose ends follow from the signs at the corners.  Signs are
exact; lengths are floats, for drawing.  Cells where several motions tie have no edge of one kind and are left out.

Source: Filippov 1988, sec. 4 (attracting and repelling surfaces, equivalent control).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import between, cross, dot

XY: TypeAlias = tuple[float, float]


class EdgeKind(StrEnum):
    """What happens on an edge that is not simply crossed."""

    SLIDING = "sliding"
    RESTING = "resting"
    REPELLING = "repelling"


@dataclass(frozen=True)
class SwitchingStretch:
    """A stretch of the edge between two cells (their indices) with one kind of motion."""

    kind: EdgeKind
    cells: tuple[int, int]
    start: XY
    end: XY


@dataclass(frozen=True)
class _Sides:
    """Normal speeds (towards the left) and tangential speeds of both neighbours at the two ends of an edge."""

    normals: tuple[tuple[Any, Any], tuple[Any, Any]]
    tangents: tuple[tuple[Any, Any], tuple[Any, Any]]

    @property
    def rests(self) -> bool:
        """Whether the equivalent control stands still all along: ``N_R rho_L = N_L rho_R`` at both ends."""
        (left, right), (along_left, along_right) = self.normals, self.tangents
        return all(not sign(right[k] * along_left[k] - left[k] * along_right[k]) for k in range(2))


def switching_stretches(partition: Partition) -> tuple[SwitchingStretch, ...]:
    """Where solutions (exact pose kinematics) slide or rest along edges, or may leave them to both sides."""
    cells = partition.complex
    found: list[SwitchingStretch] = []
    for edge in cells.edges:
        if edge.left is None or edge.right is None:
            continue
        beside = partition.cells[edge.left], partition.cells[edge.right]
        if all(len(set(cell.twists)) == 1 for cell in beside):
            ends = cells.points[edge.start], cells.points[edge.end]
            start, end = ((float(x), float(y)) for x, y in ends)
            sides = _sides(ends, beside[0].twists[0], beside[1].twists[0])
            for kind, first, last in _stretches(sides):
                names = beside[0].index, beside[1].index
                found.append(SwitchingStretch(kind, names, between(start, end, first), between(start, end, last)))
    return tuple(found)


def _sides(ends: tuple[Point, Point], left: Twist, right: Twist) -> _Sides:
    (x1, y1), (x2, y2) = ends
    r = x2 - x1, y2 - y1
    velocities = [[twist.pose_rate(end) for end in ends] for twist in (left, right)]
    normals, tangents = ([tuple(product(r, v) for v in side) for side in velocities] for product in (cross, dot))
    return _Sides((normals[0], normals[1]), (tangents[0], tangents[1]))  # type: ignore[arg-type]


def _stretches(sides: _Sides) -> Iterator[tuple[EdgeKind, float, float]]:
    """Kinds with the shares of the edge at which they begin and end."""
    left, right = sides.normals
    apart = [sign(r - l) for l, r in zip(left, right, strict=True)]  # noqa: E741
    for sense in (1, -1):
        if max(sense * s for s in apart) <= 0:
            continue
        away = _where_positive([-sense * n for n in left]), _where_positive([sense * n for n in right])
        first, last = max(a for a, _ in away), min(b for _, b in away)
        if first < last:
            yield _kind(sense, sides), first, last


def _kind(sense: int, sides: _Sides) -> EdgeKind:
    if sense < 0:
        return EdgeKind.REPELLING
    return EdgeKind.RESTING if sides.rests else EdgeKind.SLIDING


def _where_positive(ends: Sequence[Any]) -> tuple[float, float]:
    """The shares of the edge between which a function, affine with these values at the ends, is not negative."""
    signs = [sign(value) for value in ends]
    if min(signs) >= 0:
        return 0.0, 1.0
    if max(signs) <= 0:
        return (0.0, 0.0) if not signs[0] else (1.0, 1.0) if not signs[1] else (1.0, 0.0)
    root = float(ends[0]) / (float(ends[0]) - float(ends[1]))
    return (0.0, root) if signs[0] > 0 else (root, 1.0)
