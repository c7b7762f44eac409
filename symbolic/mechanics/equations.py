"""Governing equations of contact states: Omega_i, annihilator, control vector fields, in both coordinates.

Everything is read off the exact contact state (cofactors over the scene's field), so no elimination and no
simplification is needed here; SymPy, LaTeX and plain text only write it down.  Two coordinates are offered:

- spatial: the twist ``xi = (v_x, v_y, omega)``, constant on a cell (what the paper integrates as ``(x', y', theta')``);
- body: the exact pose rate ``x' = v_x - omega y, y' = v_y + omega x, theta' = omega`` at centre of mass ``(x, y)``.

With symbolic inputs the right sides are ``sum_w g_w u_w`` (Murphey & Burdick, Definition 2 and eq. 6).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from nonsmooth.symbolic.formulas.surfaces import LINE_BREAK, Formula, Monomial
from nonsmooth.symbolic.mechanics.contact_states import ContactState, RowKind, Triple, constraint_matrix
from nonsmooth.symbolic.mechanics.scene import Wheel

if TYPE_CHECKING:
    import sympy


class Coordinates(StrEnum):
    """In which coordinates the governing equations are written."""

    SPATIAL = "spatial"
    BODY = "body"


_LEFT = {
    Coordinates.SPATIAL: (("v_x", "v_{x}"), ("v_y", "v_{y}"), ("omega", r"\omega")),
    Coordinates.BODY: (("x'", r"\dot{x}"), ("y'", r"\dot{y}"), ("theta'", r"\dot{\theta}")),
}


@dataclass(frozen=True)
class GoverningEquations:
    """Three equations ``left = right`` of one contact state.

    Attributes:
        coordinates: spatial (left sides ``v_x, v_y, omega``) or body (``x', y', theta'``).
        right: right sides, in ``x, y`` (body) and ``u_1, ..., u_n`` (symbolic inputs).
    """

    coordinates: Coordinates
    right: tuple[Formula, Formula, Formula]

    def to_sympy(self) -> sympy.Matrix:
        """The right sides as a 3 x 1 SymPy matrix in real symbols."""
        import sympy

        return sympy.Matrix([formula.to_sympy() for formula in self.right])

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def plain(self, longest: int | None = None) -> str:
        """One equation per line.

        Args:
            longest: round coefficients of more characters; None keeps all exact.
        """
        pairs = zip(_LEFT[self.coordinates], self.right, strict=True)
        return "\n".join(f"{plain} = {formula.plain(longest)}" for (plain, _), formula in pairs)

    def latex(self, longest: int | None = None) -> str:
        """An ``aligned`` block; long right sides continue on further lines."""
        pairs = zip(_LEFT[self.coordinates], self.right, strict=True)
        lines = [rf"{left} &= {formula.latex(LINE_BREAK, longest)}" for (_, left), formula in pairs]
        return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"


def governing_equations(
    state: ContactState, coordinates: Coordinates = Coordinates.SPATIAL, *, symbolic_inputs: bool = False
) -> GoverningEquations:
    """The motion of one contact state.

    Args:
        state: the contact state.
        coordinates: spatial twist or body pose rate.
        symbolic_inputs: write ``sum_w g_w u_w`` instead of the motion at the scene's speeds.
    """
    fields: list[tuple[Triple, Monomial]] = [((state.twist.vx, state.twist.vy, state.twist.omega), ())]
    if symbolic_inputs:
        fields = [(g, (f"u_{wheel:d}",)) for wheel, g in sorted(state.control_fields.items())]
    vx, vy, omega = (tuple((g[k], inputs) for g, inputs in fields) for k in range(3))
    if coordinates is Coordinates.BODY:
        vx += tuple((-g[2], (*inputs, "y")) for g, inputs in fields)
        vy += tuple((g[2], (*inputs, "x")) for g, inputs in fields)
    return GoverningEquations(coordinates, (Formula(vx), Formula(vy), Formula(omega)))


def wheel_constraints(wheel: Wheel, *, symbolic_input: bool = False, body: bool = False) -> sympy.Matrix:
    """``Omega_i`` (2 x 4 SymPy matrix, roll row first), acting on ``(xi, 1)``; eq. (2).

    Args:
        wheel: wheel i.
        symbolic_input: write the speed as ``u_i``.
        body: take moments about the centre of mass, ``d_i . J(p_i - c)``: then Omega_i acts on ``(x', y', theta', 1)``
            and depends on x and y, never on theta.
    """
    import sympy

    matrix = sympy.Matrix([[entry.to_sympy() for entry in row] for row in constraint_matrix(wheel)])
    if symbolic_input:
        for k, gain in enumerate(wheel.gains):
            matrix[k, 3] = -input_symbol(wheel.index) * (gain / wheel.grip_length).to_sympy()
    if body:
        x, y = sympy.symbols("x y", real=True)
        for k in range(2):
            matrix[k, 2] += matrix[k, 0] * y - matrix[k, 1] * x
    return matrix


def stacked_constraints(state: ContactState, *, symbolic_input: bool = False, body: bool = False) -> sympy.Matrix:
    """The 3 x 4 SymPy matrix of the state's rows; its null vector with last entry 1 is the motion.

    Args:
        state: three rows that hold together.
        symbolic_input: write speeds as ``u_i``.
        body: take moments about the centre of mass, as in :func:`wheel_constraints`.
    """
    import sympy

    rows = []
    for row in state.rows:
        both = wheel_constraints(row.wheel, symbolic_input=symbolic_input, body=body)
        rows.append(both.row(0 if row.kind is RowKind.ROLL else 1))
    return sympy.Matrix.vstack(*rows)


def annihilator(state: ContactState) -> sympy.Matrix:
    """``(xi, 1)``, the null vector of the stacked constraints (4 x 1 SymPy matrix)."""
    import sympy

    return sympy.Matrix([*(entry.to_sympy() for entry in state.twist), 1])


def input_symbol(wheel: int) -> sympy.Symbol:
    """``u_w``, the surface speed of wheel w."""
    import sympy

    return sympy.Symbol(f"u_{wheel:d}", real=True)
