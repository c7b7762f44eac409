"""Switched fields whose cells are polygons of the plane of (x, y): their faces and modes, whatever moves inside.

The faces of such a field are those of its cell complex: cells, edges between two cells, corners.  Its modes are the
cells.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import ClassVar

import numpy as np

from nonsmooth.analysis.cells.cell_complex import CellComplex
from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, Face, Member, Surface, Velocity, affine_surface
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane import cross, dot
from nonsmooth.symbolic.numbers.plane_arrays import Floats, norms


class CellSides:
    """The sides of convex cells in floats, all in a row; their normals are of unit length."""

    def __init__(self, cells: Sequence[Sequence[HalfPlane]]) -> None:
        self._normals = np.array([side.normal for sides in cells for side in sides])
        self._offsets = np.array([side.offset for sides in cells for side in sides])
        self._starts = np.cumsum([0, *map(len, cells[:-1])])

    def depths(self, points: Floats) -> Floats:
        """How far points (..., 2) lie from the nearest side of every cell, negative outside; shape (..., cells)."""
        gaps = self._offsets - (self._normals @ points.T).T
        return np.minimum.reduceat(gaps, self._starts, axis=-1)


class PolygonField(ABC):
    """A field of ``(x, y, theta)`` on polygonal cells; a mode is the number of a cell.

    Attributes:
        cells: the cell complex, in floats or exact numbers.
        unit: the unit of length of x and y, in that of the scene.
    """

    states: ClassVar[tuple[str, ...]] = ("x", "y", "theta")
    heading: ClassVar[int | None] = 2
    cells: CellComplex
    unit: float = 1.0

    @abstractmethod
    def velocity(self, mode: int) -> Velocity:
        """The field of a cell, in floats."""

    @abstractmethod
    def mode_name(self, mode: int) -> str:
        """The name of a cell."""

    @property
    def size(self) -> float:
        """Size of the domain (length)."""
        return self.cells.size

    def faces_at(self, x: Floats) -> list[Face]:
        """Corners, edges and cells whose closure holds the position."""
        slack = SURFACE_SLACK * self.size
        at_corner = norms(self._points - x[:2]) <= slack
        found = [self._corners[k] for k in np.flatnonzero(at_corner)]
        found += [edge for edge in self._edges if self._holds(edge, x, slack)]
        return found + [cell for cell in self._cells if self._holds(cell, x, slack)]

    def has_contact(self, x: Floats) -> bool:
        """Polygons have no curved sides."""
        return False

    def on_border(self, x: Floats) -> bool:
        """Whether the position lies on an edge with a cell on one side only."""
        slack = SURFACE_SLACK * self.size
        for line, first, last in self._borders:
            off, along, back = line.value(x), first.value(x), last.value(x)
            if abs(off) <= slack and along >= -slack and back >= -slack:
                return True
        return False

    @cached_property
    def _floats(self) -> CellComplex:
        """The cells in floats."""
        return self.cells if self.cells.slack else self.cells.floats

    @cached_property
    def _members(self) -> tuple[Member, ...]:
        return tuple(Member(self.mode_name(k), self.velocity(k)) for k in range(len(self.cells.polygons)))

    def _holds(self, face: Face, x: Floats, slack: float) -> bool:
        """Whether a closed face holds a position."""
        inside = all(side * surface.value(x) >= -slack for surface, side in face.bounds)
        return inside and all(abs(surface.value(x)) <= slack for surface in face.keep)

    @cached_property
    def _points(self) -> Floats:
        return np.array(self._floats.points)

    @cached_property
    def _cells(self) -> tuple[Face, ...]:
        faces = []
        for polygon, member in zip(self._floats.polygons, self._members, strict=True):
            sides = [affine_surface("", (*side.normal, 0.0), side.offset) for side in polygon.sides]
            faces.append(Face(member.name, (), tuple((surface, -1) for surface in sides), (member,)))
        return tuple(faces)

    @cached_property
    def _edges(self) -> tuple[Face, ...]:
        faces = []
        for number, edge in enumerate(self._floats.edges):
            if edge.left is None or edge.right is None:
                continue
            line, first, last = self._frame(number)
            beside = (self._members[edge.left], self._members[edge.right])
            name = " | ".join(member.name for member in beside)
            faces.append(Face(name, (line,), ((first, 1), (last, 1)), beside))
        return tuple(faces)

    @cached_property
    def _borders(self) -> tuple[tuple[Surface, Surface, Surface], ...]:
        return tuple(self._frame(k) for k, edge in enumerate(self._floats.edges) if len(edge.cells) < 2)

    @cached_property
    def _corners(self) -> tuple[Face, ...]:
        faces = []
        for corner in self._floats.corners:
            x, y = corner.point
            keep = (affine_surface("x", (1, 0, 0), x), affine_surface("y", (0, 1, 0), y))
            around = tuple(self._members[cell] for cell in corner.cells)
            faces.append(Face(f"corner {place_text((x, y))}", keep, (), around))
        return tuple(faces)

    def _frame(self, number: int) -> tuple[Surface, Surface, Surface]:
        """The line of an edge (positive on its left) and its two ends (positive inside)."""
        r, edge = self._floats.direction(number), self._floats.edges[number]
        start, end = self._floats.points[edge.start], self._floats.points[edge.end]
        return (
            affine_surface("line", (-r[1], r[0], 0), cross(r, start)),
            affine_surface("start", (r[0], r[1], 0), dot(r, start)),
            affine_surface("end", (-r[0], -r[1], 0), -dot(r, end)),
        )

    # ---- modes ---------------------------------------------------------------------------

    def mode_at(self, x: Floats) -> int | None:
        """The cell that holds the position; None outside the domain."""
        margins = self.depths(x)
        best = int(np.argmax(margins))
        return best if margins[best] >= 0 else None

    def nearest_mode(self, x: Floats) -> int:
        """The cell that holds the position or, outside the domain, violates the least."""
        return int(np.argmax(self.depths(x)))

    def margin(self, mode: int, x: Floats) -> float:
        """Distance from the nearest side, negative outside."""
        sides = self._floats.polygons[mode].sides
        return min(side.offset - side.normal[0] * x[0] - side.normal[1] * x[1] for side in sides)

    def following(self, mode: int, x: Floats, width: float) -> int | None:
        """The cell that holds the position now."""
        return self.mode_at(x)

    def blend(self, x: Floats, width: float) -> Iterator[tuple[Velocity, float]]:
        """Weights that fall from one to zero between ``width`` inside and ``width`` outside a cell, normalized.

        On the border of the domain, where nothing lies beyond, the cells inside keep all the weight.
        """
        margins = self.depths(x)
        shares = np.clip((margins + width) / (2 * width), 0.0, 1.0)
        if not shares.any():
            shares = (margins == margins.max()).astype(float)
        shares = shares / shares.sum()
        for k in np.flatnonzero(shares):
            yield self._members[k].velocity, float(shares[k])

    def depths(self, x: Floats) -> Floats:
        """How far positions (..., n), x and y first, lie in every cell, negative outside; shape (..., cells)."""
        return self._sides.depths(x[..., :2])

    @cached_property
    def _sides(self) -> CellSides:
        return CellSides([polygon.sides for polygon in self._floats.polygons])
