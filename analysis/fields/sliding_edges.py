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
from nonsmooth.analysis.fields.constant_field import flow_of
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import XY, between, cross, minus

Velocities: TypeAlias = Sequence[Point]  # of a neighbour of an edge, at both ends


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
            along = minus(ends[1], ends[0])
            flows = [flow_of(cell.twists[0], Kinematics.EXACT) for cell in beside]
            left, right = ([flow.velocity(point) for point in ends] for flow in flows)
            for kind, first, last in _stretches(along, left, right):
                names = beside[0].index, beside[1].index
                found.append(SwitchingStretch(kind, names, between(start, end, first), between(start, end, last)))
    return tuple(found)


def _stretches(along: Point, left: Velocities, right: Velocities) -> Iterator[tuple[EdgeKind, float, float]]:
    """Kinds with the shares of the edge at which they begin and end."""
    speeds = [(cross(along, l), cross(along, r)) for l, r in zip(left, right, strict=True)]  # noqa: E741
    apart = [sign(r - l) for l, r in speeds]  # noqa: E741
    for sense in (1, -1):
        if max(sense * s for s in apart) <= 0:
            continue
        away = _where_positive([-sense * l for l, _ in speeds]), _where_positive([sense * r for _, r in speeds])  # noqa: E741
        first, last = max(a for a, _ in away), min(b for _, b in away)
        if first < last:
            yield EdgeKind.REPELLING if sense < 0 else _attracting(left, right), first, last


def _attracting(left: Velocities, right: Velocities) -> EdgeKind:
    """A slide rests all along where its radial speed vanishes at both ends: there the two velocities are parallel.

    That speed is ``A`` of :mod:`nonsmooth.analysis.cells.fan`, by Lagrange's identity ``|along|^2 (l x r)``.
    """
    slides = any(sign(cross(l, r)) for l, r in zip(left, right, strict=True))  # noqa: E741
    return EdgeKind.SLIDING if slides else EdgeKind.RESTING


def _where_positive(ends: Sequence[Any]) -> XY:
    """The shares of the edge between which a function, affine with these values at the ends, is not negative."""
    signs = [sign(value) for value in ends]
    if min(signs) >= 0:
        return 0.0, 1.0
    if max(signs) <= 0:
        return (0.0, 0.0) if not signs[0] else (1.0, 1.0) if not signs[1] else (1.0, 0.0)
    root = float(ends[0]) / (float(ends[0]) - float(ends[1]))
    return (0.0, root) if signs[0] > 0 else (root, 1.0)
