"""Switched fields that are constant on polygons of the plane: what closed-form simulation needs.

A cell has one twist ``(v, omega)`` and a body whose centre of mass c lies in it moves by ``theta' = omega`` and

- leading-order kinematics (the paper's): ``c' = v``;
- exact pose kinematics: ``c' = v + omega J c``.

Both are ``c' = v + turn J c`` with ``turn`` zero or ``omega``, so one code serves both.  On a cell boundary the motion
is any element of the convex hull of the neighbours' motions (Filippov 1988, sec. 4); the values of the field on the
boundary itself are ignored.  Where a rule ties (mu_R = mu_S) a cell has several twists and its hull is used at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.cell_complex import AtCorner, CellComplex, InCell, OnEdge, Place, build_complex
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, clipped_by
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.polygon_field import PolygonField
from nonsmooth.analysis.fields.switched_field import Member, ScalarVelocity, Velocity
from nonsmooth.symbolic.mechanics.contact_states import ContactState, Twist
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane import in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats

Entry: TypeAlias = Any  # int, float, Fraction or a field element


@dataclass(frozen=True)
class Flow:
    """``c' = (vx, vy) + turn J c``, ``theta' = omega``."""

    vx: Entry
    vy: Entry
    omega: Entry
    turn: Entry

    def velocity(self, point: Point) -> Point:
        """``c'`` at a point."""
        if not self.turn:
            return self.vx, self.vy
        return self.vx - self.turn * point[1], self.vy + self.turn * point[0]

    def about(self, point: Point) -> Twist:
        """``(c' at the point, turn)``: the motion as it is seen from the point."""
        return Twist(*self.velocity(point), self.turn)

    def floats(self) -> Flow:
        """Rounded numbers."""
        return Flow(float(self.vx), float(self.vy), float(self.omega), float(self.turn))

    def of_pose(self) -> Velocity:
        """The motion as a field of the pose, in floats."""
        vx, vy, omega, turn = (float(value) for value in (self.vx, self.vy, self.omega, self.turn))
        return ScalarVelocity(lambda x, y, theta: (vx - turn * y, vy + turn * x, omega))


@dataclass(frozen=True, repr=False)
class ConstantField(ShortRepr, PolygonField):
    """One constant twist (several where the rule ties) on each cell of a polygonal domain.

    Attributes:
        cells: the cell complex; exact numbers or floats.
        flows: the flows of each cell; in a tied cell the drawn path takes the first.
        names: what each cell is called in events and pieces.
        kinematics: how the pose follows from the twist.
        centre: the point about which ``|c - c*|^2`` is watched.
    """

    cells: CellComplex
    flows: tuple[tuple[Flow, ...], ...]
    names: tuple[str, ...]
    kinematics: Kinematics
    centre: Point

    @property
    def exact(self) -> bool:
        """Whether its numbers are exact."""
        return not self.cells.slack

    @cached_property
    def speed_scale(self) -> float:
        """Bound on all velocities in the domain (length/time)."""
        size = self.cells.size
        speeds = [
            float(abs(f.vx)) + float(abs(f.vy)) + 2 * size * float(abs(f.turn)) for flows in self.flows for f in flows
        ]
        return max(speeds)

    @cached_property
    def turn_scale(self) -> float:
        """Largest rate at which a velocity turns (1/time)."""
        return max(float(abs(flow.turn)) for flows in self.flows for flow in flows)

    @cached_property
    def rate_scale(self) -> float:
        """Largest rotation rate (1/time)."""
        return max(float(abs(flow.omega)) for flows in self.flows for flow in flows)

    def tied(self, cell: int) -> bool:
        """Whether several motions tie in a cell."""
        return len(set(self.flows[cell])) > 1

    @property
    def tied_members(self) -> frozenset[str]:
        """Names of the cells in which several motions tie."""
        return frozenset(name for cell, name in enumerate(self.names) if self.tied(cell))

    def velocity(self, mode: int) -> Velocity:
        """The (first) motion of a cell as a field of the pose, in floats."""
        return self._velocities[mode]

    @cached_property
    def _velocities(self) -> tuple[Velocity, ...]:
        return tuple(flows[0].of_pose() for flows in self.flows)

    def mode_name(self, mode: int) -> str:
        """The name of a cell."""
        return self.names[mode]

    def floats(self) -> ConstantField:
        """The same field in floats."""
        flows = tuple(tuple(flow.floats() for flow in several) for several in self.flows)
        centre = in_floats(self.centre)
        return replace(self, cells=self.cells.floats, flows=flows, centre=centre)

    def number(self, value: Entry) -> Entry:
        """A start value in the field's numbers: exact fields read floats as the binary fractions that they are."""
        if not self.exact:
            return float(value)
        zero = self.centre[0] * 0
        return zero + (Fraction(value) if isinstance(value, float | int) else value)

    def place_name(self, place: Place) -> str:
        """For example ``cell 1``, ``cell 1 | cell 2``, ``corner (0, 0)``."""
        match place:
            case InCell(cell):
                return self.names[cell]
            case OnEdge(edge):
                return " | ".join(self.names[cell] for cell in self.cells.edges[edge].cells)
            case AtCorner(corner):
                x, y = self.cells.points[corner]
                return f"corner {place_text((x, y))}"


def flow_of(twist: Sequence[Entry], kinematics: Kinematics) -> Flow:
    """The flow of a constant twist ``(vx, vy, omega)``."""
    vx, vy, omega = twist
    return Flow(vx, vy, omega, omega if kinematics is Kinematics.EXACT else omega * 0)


def array_field(partition: Partition, kinematics: Kinematics, *, exact: bool = False) -> ConstantField:
    """The field of an array under rule ``nearest`` or ``box``, with the scene's own speeds.

    Args:
        partition: the cells of the array, each with its twists.
        kinematics: exact pose, or leading order as in the paper.
        exact: numbers of the scene's field in place of floats.

    Raises:
        ValueError: for exact numbers with exact pose kinematics, whose arcs are transcendental.
    """
    if exact and kinematics is Kinematics.EXACT:
        raise ValueError("required leading-order kinematics for exact numbers: arcs need sines and cosines")
    cells = (partition if exact else partition.like or partition).complex  # of the same floats
    flows = tuple(tuple(flow_of(twist, kinematics) for twist in cell.twists) for cell in partition.cells)
    names = tuple(f"cell {cell.index}" for cell in partition.cells)
    field = ConstantField(cells, flows, names, kinematics, partition.scene.check.equilibrium)
    return field if exact else field.floats()


def piecewise_constant(
    domain: Polygon,
    pieces: Sequence[tuple[Sequence[HalfPlane], Sequence[Entry]]],
    kinematics: Kinematics = Kinematics.LEADING,
    *,
    exact: bool = False,
) -> ConstantField:
    """A plain piecewise-constant system: convex cells by their half-planes, each with ``(x', y', theta')``.

    Floats are read as the binary fractions that they are, so cells meet exactly.  The part of the domain outside all
    cells is outside the field.

    Args:
        domain: a convex polygon.
        pieces: half-planes and the motion between them, for each cell.
        kinematics: how theta moves the velocity.
        exact: exact numbers in place of floats.

    Raises:
        ValueError: for a cell without area in the domain, or exact numbers with exact pose kinematics.
    """
    if exact and kinematics is Kinematics.EXACT:
        raise ValueError("required leading-order kinematics for exact numbers: arcs need sines and cosines")
    polygons, flows = [], []
    whole = Polygon(tuple(_exact_point(p) for p in domain.vertices), tuple(_exact_side(s) for s in domain.sides))
    for number, (half_planes, rates) in enumerate(pieces, 1):
        polygon = clipped_by(whole, map(_exact_side, half_planes))
        if polygon is None:
            raise ValueError(f"required cells with area in the domain, received none for piece {number}")
        polygons.append(polygon)
        flows.append((flow_of(Twist(*(_exact(rate) for rate in rates)), kinematics),))
    size = max(abs(float(x)) for vertex in whole.vertices for x in vertex)
    names = tuple(f"cell {k}" for k in range(1, len(pieces) + 1))
    zero = whole.vertices[0][0] * 0
    field = ConstantField(build_complex(polygons, size), tuple(flows), names, kinematics, (zero, zero))
    return field if exact else field.floats()


def _exact(value: Entry) -> Entry:
    return Fraction(float(value)) if isinstance(value, float | int | np.floating) else value


def _exact_point(point: Point) -> Point:
    return _exact(point[0]), _exact(point[1])


def _exact_side(side: HalfPlane) -> HalfPlane:
    return HalfPlane(_exact_point(side.normal), _exact(side.offset), side.label)


# ---- smooth fields on cells ----------------------------------------------------------------------
#
# Smooth fields on polygonal cells: an array with feedback, or constant twists for a second opinion.
#
# A feedback law gives every wheel a speed as a smooth function of the pose within each cell; rule ``nearest`` then
# moves the body by ``xi = sum_w g_w u_w`` with the cell's control vector fields g_w (Murphey & Burdick, eq. 6).


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
