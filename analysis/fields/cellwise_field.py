"""Smooth fields on polygonal cells: an array with feedback, or constant twists for a second opinion.

A feedback law gives every wheel a speed as a smooth function of the pose within each cell; rule ``nearest`` then moves
the body by ``xi = sum_w g_w u_w`` with the cell's control vector fields g_w (Murphey & Burdick, eq. 6).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.cells.cell_complex import CellComplex
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.polygon_field import PolygonField
from nonsmooth.analysis.fields.switched_field import Member, ScalarVelocity, Velocity
from nonsmooth.symbolic.mechanics.contact_states import ContactState
from nonsmooth.symbolic.numbers.plane_arrays import Floats

Pose: TypeAlias = Floats | tuple[float, ...]  # (x, y, theta): paths are followed in single floats
Speeds: TypeAlias = Callable[[Pose], Mapping[int, float]]  # pose to surface speed by wheel index
StateLaw: TypeAlias = Callable[[ContactState], Speeds]  # what is constant in a cell is prepared once


@dataclass(frozen=True, eq=False)
class CellwiseField(PolygonField):
    """One smooth field of ``(x, y, theta)`` on each cell of a polygonal domain.

    Attributes:
        cells: the cell complex, in floats.
        members: the field of each cell.
        kinematics: ``exact`` or ``leading``.
        tied_members: members that are one of several possible fields of their cell.
        unit: what x and y count, in the scene's unit of length.
    """

    cells: CellComplex
    members: tuple[Member, ...]
    kinematics: str
    tied_members: frozenset[str] = frozenset()
    unit: float = 1.0

    def velocity(self, mode: int) -> Velocity:
        """The field of a cell."""
        return self.members[mode].velocity

    def mode_name(self, mode: int) -> str:
        """The name of a cell."""
        return self.members[mode].name

    def in_unit(self, length: float) -> CellwiseField:
        """The same field with x and y as multiples of a length, so that an integrator weighs them against theta."""
        if length == 1:
            return self
        members = tuple(Member(member.name, _in_unit(member.velocity, length)) for member in self.members)
        return replace(self, cells=self.cells.in_unit(length), members=members, unit=length)


def _in_unit(velocity: Velocity, length: float) -> Velocity:
    if isinstance(velocity, ScalarVelocity):
        rates = velocity.rates

        def in_unit(x: float, y: float, theta: float) -> tuple[float, ...]:
            along_x, along_y, turning = rates(x * length, y * length, theta)
            return along_x / length, along_y / length, turning

        return ScalarVelocity(in_unit)
    units = np.array([length, length, 1.0])
    return lambda t, x: np.asarray(velocity(t, x * units) / units)


def smooth_form(field: ConstantField) -> CellwiseField:
    """A field of constant twists for the general integrator: a second opinion on the closed forms."""
    rounded = field if not field.exact else field.floats()
    members = tuple(Member(name, rounded.velocity(k)) for k, name in enumerate(rounded.names))
    return CellwiseField(rounded.cells, members, field.kinematics.value, rounded.tied_members)


def feedback_field(partition: Partition, law: StateLaw, kinematics: Kinematics) -> CellwiseField:
    """An array under rule ``nearest`` whose wheel speeds follow a feedback law; in a tied cell the first state rules.

    Leading-order kinematics are those of the checked point: the twist's velocity is taken there.

    Args:
        partition: the cells of the array.
        law: the speeds of the rims from cell and pose.
        kinematics: exact pose, or leading order as in the paper.

    Raises:
        ValueError: for a contact state of more than three rows (rule ``box``), which has no control fields.
    """
    cells = partition.complex.floats
    x, y = partition.scene.check.place
    members = tuple(_controlled(cell, law, kinematics, (x, y)) for cell in partition.cells)
    tied = frozenset(m.name for m, cell in zip(members, partition.cells, strict=True) if len(cell.states) > 1)
    return CellwiseField(cells, members, kinematics.value, tied)


def control_columns(state: ContactState) -> list[tuple[int, float, float, float]]:
    """The wheels that act, each with its control vector field in floats."""
    return [(wheel, float(a), float(b), float(c)) for wheel, (a, b, c) in state.control_fields.items()]


def _controlled(cell: Cell, law: StateLaw, kinematics: Kinematics, centre: tuple[float, float]) -> Member:
    state = cell.states[0]
    columns = control_columns(state)
    speeds = law(state)
    turning = kinematics is Kinematics.EXACT

    def rates(x: float, y: float, theta: float) -> tuple[float, ...]:
        given = speeds((x, y, theta))
        v_x = v_y = omega = 0.0
        for wheel, a, b, c in columns:
            speed = given[wheel]
            v_x, v_y, omega = v_x + speed * a, v_y + speed * b, omega + speed * c
        x_of, y_of = (x, y) if turning else centre
        return v_x - omega * y_of, v_y + omega * x_of, omega

    return Member(f"cell {cell.index}", ScalarVelocity(rates))
