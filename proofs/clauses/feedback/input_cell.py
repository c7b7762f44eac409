"""Clause 4 in one closed cell: the inputs ``u_i, u_j``, their effect on V, and where it vanishes.

The symbols are those of :mod:`nonsmooth.proofs.clauses.feedback.by_rows`.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.analysis.cells.partition import Cell
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.feedback.control_lyapunov import Demand
from nonsmooth.proofs.clauses.witness import Witness
from nonsmooth.symbolic.constraints import RowKind
from nonsmooth.symbolic.contact_states import ContactState
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import around, between, cross, dot, minus, turned
from nonsmooth.symbolic.scene import Wheel


@dataclass(frozen=True)
class InputCell:
    """One closed cell with the data of its law.

    Attributes:
        cell: the cell.
        state: its contact state.
        nearest: wheel i, both rows held.
        second: wheel j, one row held.
        lever: ``d_j . J(p_j - p_i)`` scaled by ``|D_j|``, or None where the third row is a side row.
        projections: ``c . D_i`` at the vertices (a positive multiple of ``c . d_i``).
    """

    cell: Cell
    state: ContactState
    nearest: Wheel
    second: Wheel
    lever: Number | None
    projections: tuple[Number, ...]

    @property
    def torque_sign(self) -> int:
        """Sign of the coefficient of ``u_j`` in omega: the paper's ``u_j = -k theta`` needs it positive."""
        return 0 if self.lever is None else self.lever.sign()

    @property
    def demand(self) -> Demand:
        """What a control Lyapunov function must satisfy in the cell."""
        vertices = tuple(vertex for vertex in self.cell.polygon.vertices if any(vertex))
        return Demand(vertices, self.nearest.direction)

    def coefficients(self, point: Point, theta: Number, weight: Fraction = Fraction(1)) -> tuple[Number, ...]:
        """Coefficient of each input in ``V'/2 = c . v + w theta omega``, from the control vector fields."""
        fields = self.state.control_fields.values()
        return tuple(point[0] * x + point[1] * y + theta * weight * turn for x, y, turn in fields)

    def check(self) -> bool:
        """Verify the wheels from the rows that the cell holds, the lever as a moment, projections as areas."""
        first, other, third = self.state.rows[:3]
        held = first.wheel == other.wheel == self.nearest and {first.kind, other.kind} == set(RowKind)
        gap = minus(self.second.position, self.nearest.position)
        moment = None if third.kind is not RowKind.ROLL else cross(gap, self.second.direction)
        sides = (cross(self.nearest.direction, turned(vertex)) for vertex in self.cell.polygon.vertices)
        named = held and third.wheel == self.second and self.state in self.cell.states
        return named and self.lever == moment and self.projections == tuple(sides)

    def idle_plane(self, weight: Fraction) -> Witness:
        """Where one input acts alone: a nonzero (c, theta) of the closed cell at which it cannot change V.

        With ``xi = g u_i`` and ``V'/2 = (c . g_v + w theta g_omega) u_i`` that is the cell's centre (a vertex, where
        the centre is the equilibrium) with ``theta = -c . g_v/(w g_omega)``, or the equilibrium with any theta where
        ``g_omega = 0``.
        """
        meaning = "only one input acts: V' = a u_i vanishes on a plane through this c and theta"
        ((x, y, turn),) = self.state.control_fields.values()
        if not turn:
            return Witness((turn, turn), turn.field.one, meaning)
        polygon = self.cell.polygon
        point = polygon.centre if any(polygon.centre) else polygon.vertices[0]
        return Witness(point, -dot(point, (x, y)) / (turn * weight), meaning)

    def stall(self) -> Point | None:
        """A nonzero point of the closed cell with ``c . d_i = 0``, where there is one."""
        for (p, here), (q, after) in around(list(zip(self.cell.polygon.vertices, self.projections, strict=True))):
            if not here and any(p):
                return p
            if here.sign() * after.sign() < 0:
                point = between(p, q, here / (here - after))
                if any(point):
                    return point
        return None

    def is_idle(self, witness: Witness, weight: Fraction) -> bool:
        """Whether no input of the closed cell changes V at the witness, which is not the equilibrium itself."""
        nonzero = any(witness.point) or bool(witness.value)
        held = self.cell.polygon.contains(witness.point)
        return nonzero and held and not any(self.coefficients(witness.point, witness.value, weight))


def build_input_cell(cell: Cell, state: ContactState) -> InputCell:
    """The data of the law in a cell with three rows, both of the first wheel among them."""
    nearest, second = state.rows[0].wheel, state.rows[2].wheel
    lever = None
    if state.rows[2].kind is RowKind.ROLL:
        gap = (second.position[0] - nearest.position[0], second.position[1] - nearest.position[1])
        lever = dot(second.direction, turned(gap))
    projections = tuple(dot(vertex, nearest.direction) for vertex in cell.polygon.vertices)
    return InputCell(cell, state, nearest, second, lever, projections)


def is_local(cell: Cell) -> bool:
    """Whether the closed cell holds the equilibrium."""
    zero = cell.twists[0].omega.field.zero
    return cell.polygon.contains((zero, zero))
