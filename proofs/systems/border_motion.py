"""What solutions do on the straight borders between the cells of a plain system: cross, slide, leave, or touch.

Along a border the normal parts of both fields are polynomials in one parameter, so the signs are constant between
their real roots, which are isolated exactly.  Borders along curves are not looked at.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations, pairwise

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Segment, common_edges
from nonsmooth.analysis.cells.switched_cells import FieldCell
from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.proofs.inequalities.dense_polynomials import along_edge, trimmed, value
from nonsmooth.proofs.inequalities.real_roots import RealRoot, positive_roots, samples_between, separated
from nonsmooth.symbolic.constraints import cross_product
from nonsmooth.symbolic.plane import dot


class BorderKind(StrEnum):
    """What solutions do on a part of a border."""

    CROSSING = "crossing"
    SLIDING = "sliding"  # both fields push onto it
    REPELLING = "repelling"  # both fields push away; solutions may stay on it, and leave at any time
    TOUCHED = "touched"  # a field runs along it
    UNDECIDED = "undecided"  # the sign of a normal part of sines and cosines was not found


@dataclass(frozen=True)
class BorderPart:
    """A part of a border between two cells.

    Attributes:
        start: one end.
        end: the other end.
        kind: what solutions do between.
        is_exact: whether the ends are exact; otherwise they are close to a root that has no name in the field.
        normal: into the cell of the first field.
        fields: the field on each side, the first one where several act.
    """

    start: Point
    end: Point
    kind: BorderKind
    is_exact: bool
    normal: Point
    fields: tuple[StatedField, StatedField]


def border_parts(cells: Sequence[FieldCell]) -> Iterator[BorderPart]:
    """All parts of straight borders across which the field changes."""
    for first, second in combinations(cells, 2):
        if first.velocities == second.velocities or are_parted(first, second):
            continue
        for edge in common_edges(first.region, second.region):
            yield from _parts(first, second, edge)


def are_parted(first: FieldCell, second: FieldCell) -> bool:
    """Whether two cells lie on two sides of a curve."""
    return any(not g + h for g in first.region.guards for h in second.region.guards)


def _parts(first: FieldCell, second: FieldCell, edge: Segment) -> Iterator[BorderPart]:
    a, b, _ = cross_product(*edge)  # positive inside the first cell
    normal = [[trimmed(along_edge(f * a + g * b, edge)) for f, g in cell.velocities] for cell in (first, second)]
    curves = [curve for side in normal for curve in side if curve]
    roots = separated(root for curve in curves if len(curve) > 1 for root in positive_roots(curve))
    ends: list[tuple[Point, bool]] = [(_end(edge[0]), True), *(_root_point(r, edge) for r in roots)]
    ends.append((_end(edge[1]), True))
    for t, ((start, known), (end, named)) in zip(samples_between(roots), pairwise(ends), strict=True):
        signs = [{value(curve, t).sign() if curve else 0 for curve in side} for side in normal]
        fields = StatedField(first.velocities[0]), StatedField(second.velocities[0])
        yield BorderPart(start, end, border_kind(*signs), known and named, (a, b), fields)


def sliding_velocity(part: BorderPart, place: Point) -> Point:
    """The mixture of both fields that is tangent to the border, ``((n . g) f - (n . f) g)/(n . g - n . f)``.

    Args:
        part: a border onto which both fields push, or from which both push away.
        place: on it.

    Raises:
        ZeroDivisionError: where both fields have the same normal part.
    """
    f, g = (field.at(place) for field in part.fields)
    a, b = part.normal
    normal = (float(a), float(b)) if any(field.waves for field in part.fields) else part.normal
    across_f, across_g = (dot(normal, velocity) for velocity in (f, g))
    first, second = ((across_g * a - across_f * b) / (across_g - across_f) for a, b in zip(f, g, strict=True))
    return (first, second)


def border_kind(first: set[int], second: set[int]) -> BorderKind:
    """From the signs of the normal parts; positive points into the first cell."""
    if 0 in first | second:
        return BorderKind.TOUCHED
    if first == {-1} and second == {1}:
        return BorderKind.SLIDING
    if first == {1} and second == {-1}:
        return BorderKind.REPELLING
    return BorderKind.CROSSING


def _end(generator: tuple[object, ...]) -> Point:
    x, y, w = generator
    return (x / w, y / w)  # type: ignore[operator]


def _root_point(root: RealRoot, edge: Segment) -> tuple[Point, bool]:
    exact = root.exact()
    t = root.low if exact is None else exact
    x, y, w = (a + b * t for a, b in zip(*edge, strict=True))
    return (x / w, y / w), exact is not None
