"""Theorem 4's pair equations for symbolic geometry: both rows of wheel i and one row of wheel j, by cofactors.

Positions ``(x_i, y_i), (x_j, y_j)``, headings ``phi_i, phi_j`` and speeds ``u_i, u_j`` are symbols.  Numerators and the
common denominator ``Delta`` are polynomials in them and in the headings' cosines and sines, kept in normal form
modulo ``cos^2 + sin^2 = 1`` for each heading.  The normal form is unique, so two expressions are equal on every
array iff their cross difference has normal form zero: identities are decided, not simplified.  Result::

    omega = (u_j - u_i d_i.d_j)/Delta,   v = u_i d_i - omega J p_i,   Delta = d_j . J(p_j - p_i)

and for a side row the same with ``n_j`` for ``d_j`` and 0 for ``u_j``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nonsmooth.symbolic.constraints import RowKind, cofactors, inner

if TYPE_CHECKING:
    import sympy


@dataclass(frozen=True)
class PairEquations:
    """``(v_x, v_y, omega) = numerators / denominator`` for the rows R_i, S_i and R_j (or S_j).

    Attributes:
        third: kind of wheel j's row.
        numerators: polynomials in positions, speeds, cosines and sines.
        denominator: ``Delta``, the determinant of the rows; the equations hold where it is not zero.
    """

    third: RowKind
    numerators: tuple[sympy.Expr, sympy.Expr, sympy.Expr]
    denominator: sympy.Expr

    @property
    def twist(self) -> sympy.Matrix:
        """``(v_x, v_y, omega)`` as a 3 x 1 matrix."""
        import sympy

        return sympy.Matrix([numerator / self.denominator for numerator in self.numerators])

    def equals(self, twist: sympy.Matrix) -> bool:
        """Whether a twist in the same symbols is identical to this one, for every geometry."""
        return all(
            vanishes(self.denominator * entry - numerator)
            for numerator, entry in zip(self.numerators, twist, strict=True)
        )

    def paper_form(self) -> sympy.Matrix:
        """The twist in the symbols of Theorem 4: ``theta, x_1, y_1`` (wheel i), ``x_2, y_2`` (wheel j), ``u_i, u_j``.

        Its formulas are those of eq. (2)'s sign ``+Psi`` (so ``d_i = -(cos theta, sin theta)``), a rim of wheel j
        through the origin (``d_j = -p_2/|p_2|``), and ``u_j`` standing for the speed times ``|p_2|``.
        """
        import sympy

        x1, y1, x2, y2, theta = sympy.symbols("x_1 y_1 x_2 y_2 theta", real=True)
        reach = sympy.sqrt(x2**2 + y2**2)
        xi, yi, ci, si, _ = _wheel("i")
        xj, yj, cj, sj, uj = _wheel("j")
        values = {ci: -sympy.cos(theta), si: -sympy.sin(theta), cj: -x2 / reach, sj: -y2 / reach}
        values |= {xi: x1, yi: y1, xj: x2, yj: y2, uj: uj / reach}
        changed = [entry.subs(values, simultaneous=True) for entry in (*self.numerators, self.denominator)]
        *numerators, denominator = (sympy.cancel(entry * reach) for entry in changed)
        return sympy.Matrix([sympy.factor(numerator / denominator) for numerator in numerators])

    def paper_rate(self) -> sympy.Expr:
        """``V' = 2 (x x' + y y' + theta_b theta')`` of the paper's form, for ``V = x^2 + y^2 + theta_b^2``.

        ``theta_b`` is the body's orientation; theta stays the angle of wheel i.
        """
        import sympy

        x, y, body = sympy.symbols("x y theta_b", real=True)
        vx, vy, omega = self.paper_form()
        return 2 * (x * vx + y * vy + body * omega)


def pair_equations(third: RowKind = RowKind.ROLL) -> PairEquations:
    """The pair equations by Cramer's rule.

    Args:
        third: which row of wheel j completes both rows of wheel i.
    """
    (roll, ui), (side, zero) = _row("i", RowKind.ROLL), _row("i", RowKind.SIDE)
    last, uj = _row("j", third)
    columns = cofactors(roll, side, last)
    numerators = [normal_form(sum(b * c[k] for b, c in zip((ui, zero, uj), columns, strict=True))) for k in range(3)]
    return PairEquations(third, (numerators[0], numerators[1], numerators[2]), normal_form(inner(roll, columns[0])))


def closed_form(third: RowKind = RowKind.ROLL) -> sympy.Matrix:
    """``(v_x, v_y, omega)`` as stated at the top of this file: what :func:`pair_equations` must reach."""
    import sympy

    xi, yi, ci, si, ui = _wheel("i")
    xj, yj, *_ = _wheel("j")
    (a, b, _), uj = _row("j", third)
    lever = b * (xj - xi) - a * (yj - yi)
    omega = (uj - ui * (ci * a + si * b)) / lever
    return sympy.Matrix([ui * ci + omega * yi, ui * si - omega * xi, omega])


def vanishes(expression: Any) -> bool:
    """Whether an expression in the pair's symbols is zero for every geometry (denominators cleared)."""
    import sympy

    numerator, _ = sympy.fraction(sympy.together(expression))
    return normal_form(numerator) == 0


def normal_form(expression: Any) -> sympy.Expr:
    """Remainder modulo ``cos^2 + sin^2 - 1`` of both headings, with ``sin`` to the first power at most."""
    import sympy

    (_, _, ci, si, _), (_, _, cj, sj, _) = _wheel("i"), _wheel("j")
    circles = [si**2 + ci**2 - 1, sj**2 + cj**2 - 1]
    _, remainder = sympy.reduced(sympy.expand(expression), circles, si, sj, ci, cj, order="lex")
    return remainder


def _wheel(name: str) -> tuple[sympy.Symbol, ...]:
    """``(x, y, cos phi, sin phi, u)`` of a wheel as symbols."""
    import sympy

    return tuple(sympy.Symbol(f"{letter}_{name}", real=True) for letter in "xycsu")


def _row(name: str, kind: RowKind) -> tuple[tuple[Any, Any, Any], Any]:
    """Left side ``(d, d . J p)`` and right side of a wheel's row; the side row has ``n = J d`` and 0."""
    x, y, c, s, u = _wheel(name)
    a, b = (c, s) if kind is RowKind.ROLL else (-s, c)
    return (a, b, b * x - a * y), (u if kind is RowKind.ROLL else 0)
