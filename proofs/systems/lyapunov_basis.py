"""Functions whose sums are proposed as V: monomials, and monomials times ``|l|`` of lines and ``|q|`` of curves.

The lines and curves are switching surfaces through the equilibrium.  Each function is continuous and bends at most
along its surface, so a sum is continuous however its coefficients are rounded.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression, SignOf, parse_piecewise
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem


@dataclass(frozen=True)
class BasisFunction:
    """A monomial in the displacement, times the absolute value of a surface or alone.

    Attributes:
        monomial: with coefficient 1.
        line: a linear form, or the polynomial of a curve; None for the monomial alone.
    """

    monomial: Polynomial
    line: Polynomial | None

    @property
    def degree(self) -> int:
        """The total degree."""
        return self.monomial.degree + (0 if self.line is None else self.line.degree)

    def piece(self, sign_of: SignOf) -> Polynomial:
        """The polynomial that it is where the line has the given sign."""
        if self.line is None:
            return self.monomial
        return self.monomial * self.line * sign_of(self.line)

    def text(self, states: tuple[str, ...]) -> str:
        """The function as a formula of the states."""
        monomial = str(replace(self.monomial, variables=states))
        if self.line is None:
            return monomial
        bent = f"Abs({replace(self.line, variables=states)})"
        return bent if monomial == "1" else f"{monomial}*{bent}"


def bent_functions(field: NumberField, lines: Iterable[Polynomial], degree: int) -> tuple[BasisFunction, ...]:
    """Monomials times ``|l|`` for each line or curve, of a total degree if l is a line."""
    return tuple(BasisFunction(m, line) for line in lines for m in _monomials(field, degree - 1))


def smooth_functions(field: NumberField, degree: int) -> tuple[BasisFunction, ...]:
    """Monomials of a total degree."""
    return tuple(BasisFunction(m, None) for m in _monomials(field, degree))


def _monomials(field: NumberField, degree: int) -> Iterator[Polynomial]:
    for k in range(degree, -1, -1):
        yield Polynomial(field, PLANE, {(k, degree - k): field.one})


def lines_through(system: SwitchedSystem) -> tuple[Polynomial, ...]:
    """The switching surfaces of a planar system that are lines through the checked point."""
    return tuple(s for s in system.surfaces(system.displaced(PLANE)) if s.degree == 1 and s.is_homogeneous)


def curves_through(system: SwitchedSystem) -> tuple[Polynomial, ...]:
    """The switching surfaces of a planar system that are curves through the checked point with a tangent there."""
    curves = (s for s in system.surfaces(system.displaced(PLANE)) if s.degree > 1)
    return tuple(s for s in curves if (0, 0) not in s.terms and ((1, 0) in s.terms or (0, 1) in s.terms))


def build_formula(
    basis: Sequence[BasisFunction], coefficients: Sequence[Fraction], states: tuple[str, ...]
) -> PiecewiseExpression:
    """The sum as a formula of the states, functions of low degree first.

    Raises:
        ExpressionError: for a sum that is too long.
    """
    used = [(c, function) for c, function in zip(coefficients, basis, strict=True) if c]
    used.sort(key=lambda term: term[1].degree)
    text = " + ".join(_term(c, function.text(states)) for c, function in used) or "0"
    return parse_piecewise(text.replace("+ -", "- "), states)


def _term(coefficient: Fraction, function: str) -> str:
    """``9*x*y/11`` for a coefficient and a function."""
    top, bottom = coefficient.numerator, coefficient.denominator
    factor = {1: "", -1: "-"}.get(top, f"{top}*")
    return f"{factor}{function}" + (f"/{bottom}" if bottom != 1 else "")
