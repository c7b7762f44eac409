"""Smooth fields on polygonal cells: an array with feedback, or constant twists for a second opinion.

A feedback law gives every wheel a speed as a smooth function of the pose within each cell; rule ``nearest`` then moves
the body by ``xi = sum_w g_w u_w`` with the cell's control vector fields g_w (Murphey & Burdick, eq. 6).  The faces of
such a field are those of its cell complex: cells, edges between two cells, corners.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.smooth_field import (
    SURFACE_SLACK,
    Face,
    Member,
    Surface,
    Vector,
    Velocity,
    affine_surface,
)
from nonsmooth.analysis.fields.switched_field import ConstantField, Flow
from nonsmooth.analysis.partitions.cell_complex import CellComplex
from nonsmooth.analysis.partitions.partition import Cell, Partition
from nonsmooth.symbolic.contact_states import ContactState

Speeds: TypeAlias = Callable[[Vector], Mapping[int, float]]  # pose to surface speed by wheel index
Law: TypeAlias = Callable[[ContactState], Speeds]  # what is constant in a cell is prepared once


@dataclass(frozen=True, eq=False)
class CellwiseField:
    """One smooth field of ``(x, y, theta)`` on each cell of a polygonal domain.

    Attributes:
        cells: the cell complex, in floats.
        members: the field of each cell.
        kinematics: ``exact`` or ``leading``.
        tied: members that are one of several possible fields of their cell.
    """

    cells: CellComplex
    members: tuple[Member, ...]
    kinematics: str
    tied: frozenset[str] = frozenset()
    states: tuple[str, ...] = ("x", "y", "theta")
    heading: int | None = 2

    @property
    def size(self) -> float:
        """Size of the domain (length)."""
        return self.cells.size

    def faces_at(self, x: Vector) -> list[Face]:
        """Corners, edges and cells whose closure holds the position."""
        slack = SURFACE_SLACK * self.size
        at_corner = np.hypot(*(self._points - x[:2]).T) <= slack
        found = [self._corners[k] for k in np.flatnonzero(at_corner)]
        found += [edge for edge in self._edges if self._holds(edge, x, slack)]
        return found + [cell for cell in self._cells if self._holds(cell, x, slack)]

    def has_contact(self, x: Vector) -> bool:
        """Polygons have no curved sides."""
        return False

    def on_border(self, x: Vector) -> bool:
        """Whether the position lies on an edge with a cell on one side only."""
        slack = SURFACE_SLACK * self.size
        for line, first, last in self._borders:
            off, along, back = line.value(x), first.value(x), last.value(x)
            if abs(off) <= slack and along >= -slack and back >= -slack:
                return True
        return False

    def _holds(self, face: Face, x: Vector, slack: float) -> bool:
        """Whether a closed face holds a position."""
        inside = all(side * surface.value(x) >= -slack for surface, side in face.bounds)
        return inside and all(abs(surface.value(x)) <= slack for surface in face.keep)

    @cached_property
    def _points(self) -> Vector:
        return np.array(self.cells.points)

    @cached_property
    def _cells(self) -> tuple[Face, ...]:
        faces = []
        for polygon, member in zip(self.cells.polygons, self.members, strict=True):
            sides = [affine_surface("", (*side.normal, 0.0), side.offset) for side in polygon.sides]
            faces.append(Face(member.name, (), tuple((surface, -1) for surface in sides), (member,)))
        return tuple(faces)

    @cached_property
    def _edges(self) -> tuple[Face, ...]:
        faces = []
        for number, edge in enumerate(self.cells.edges):
            if edge.left is None or edge.right is None:
                continue
            line, first, last = self._frame(number)
            beside = (self.members[edge.left], self.members[edge.right])
            name = " | ".join(member.name for member in beside)
            faces.append(Face(name, (line,), ((first, 1), (last, 1)), beside))
        return tuple(faces)

    @cached_property
    def _borders(self) -> tuple[tuple[Surface, Surface, Surface], ...]:
        return tuple(self._frame(k) for k, edge in enumerate(self.cells.edges) if len(edge.cells) < 2)

    @cached_property
    def _corners(self) -> tuple[Face, ...]:
        faces = []
        for corner in self.cells.corners:
            x, y = corner.point
            keep = (affine_surface("x", (1, 0, 0), x), affine_surface("y", (0, 1, 0), y))
            around = tuple(self.members[cell] for cell in corner.cells)
            faces.append(Face(f"corner ({x:.6g}, {y:.6g})", keep, (), around))
        return tuple(faces)

    def _frame(self, number: int) -> tuple[Surface, Surface, Surface]:
        """The line of an edge (positive on its left) and its two ends (positive inside)."""
        a, b = self.cells.direction(number)
        (x1, y1), (x2, y2) = (
            self.cells.points[k] for k in (self.cells.edges[number].start, self.cells.edges[number].end)
        )
        return (
            affine_surface("line", (-b, a, 0), a * y1 - b * x1),
            affine_surface("start", (a, b, 0), a * x1 + b * y1),
            affine_surface("end", (-a, -b, 0), -a * x2 - b * y2),
        )


def flow_velocity(flow: Flow) -> Velocity:
    """A constant twist as a field of the pose."""
    vx, vy, omega, turn = (float(value) for value in (flow.vx, flow.vy, flow.omega, flow.turn))
    return lambda t, x: np.array([vx - turn * x[1], vy + turn * x[0], omega])


def smooth_form(field: ConstantField) -> CellwiseField:
    """A field of constant twists for the general integrator: a second opinion on the closed forms."""
    rounded = field if not field.exact else field.floats()
    members = tuple(Member(name, flow_velocity(own[0])) for name, own in zip(rounded.names, rounded.flows, strict=True))
    tied = frozenset(name for name, own in zip(rounded.names, rounded.flows, strict=True) if len(set(own)) > 1)
    return CellwiseField(rounded.cells, members, field.kinematics.value, tied)


def feedback_field(partition: Partition, law: Law, kinematics: Kinematics) -> CellwiseField:
    """An array under rule ``nearest`` whose wheel speeds follow a feedback law; in a tied cell the first state rules.

    Leading-order kinematics are those of the checked point: the twist's velocity is taken there.

    Raises:
        ValueError: for a contact state of more than three rows (rule ``box``), which has no control fields.
    """
    cells = partition.complex.floats()
    x, y = (float(value) for value in partition.scene.check.equilibrium)
    members = tuple(_controlled(cell, law, kinematics, (x, y)) for cell in partition.cells)
    tied = frozenset(m.name for m, cell in zip(members, partition.cells, strict=True) if len(cell.states) > 1)
    return CellwiseField(cells, members, kinematics.value, tied)


def _controlled(cell: Cell, law: Law, kinematics: Kinematics, centre: tuple[float, float]) -> Member:
    state = cell.states[0]
    columns = {wheel: np.array([float(x) for x in field]) for wheel, field in state.control_fields.items()}
    speeds = law(state)
    turning = kinematics is Kinematics.EXACT

    def velocity(t: float, x: Vector) -> Vector:
        given = speeds(x)
        twist: Vector = sum((given[wheel] * column for wheel, column in columns.items()), np.zeros(3))
        x_of, y_of = x[:2] if turning else centre
        twist[:2] += twist[2] * np.array([-y_of, x_of])
        return twist

    return Member(f"cell {cell.index}", velocity)
