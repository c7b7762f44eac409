"""Energies of systems of second order with a cross term: candidates for a V that falls.

Where ``x' = v`` and ``v' = -g(x) - ...`` the energy ``G(x) + v^2/2`` with ``G' = g`` falls by damping alone, and
``V = G(x) + v^2/2 + c v h(x)`` with a small c, and ``h = x`` or ``h = g``, falls where v is zero, too.  Where g jumps,
as that of a relay, terms of V' of lowest order must cancel exactly: no linear program with a margin proposes such a V.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from nonsmooth.analysis.cells.switched_cells import FieldCell
from nonsmooth.proofs.systems.lyapunov_rows import BasisFunction, build_formula
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

SHARES = (Fraction(1, 4), Fraction(1, 16))  # of the cross term, tried in turn
NEAR = Fraction(1, 1 << 20)  # of the half-width: where g is read off
MOST_DEGREE = 5  # of g

Powers: TypeAlias = Mapping[int, Fraction]  # coefficients of powers of x
LINEAR: Powers = {1: Fraction(1)}


def energies(system: SwitchedSystem, cells: Sequence[FieldCell], radius: Number) -> Iterator[PiecewiseExpression]:
    """Candidates for V, where a system is one of second order, with a rational g.

    Args:
        system: in two states.
        cells: of a square.
        radius: its half-width.
    """
    for place in (0, 1):
        line = _monomial(system.field, place, 1, 0)
        sides = _forces(cells, radius, place, _monomial(system.field, place, 0, 1))
        if sides is None:
            continue
        right, left = sides
        energy = [(Fraction(1, 2), BasisFunction(_monomial(system.field, place, 0, 2), None))]
        energy += _times_speed(_integral(right), _integral(left), place, 0, line)
        shapes = [(LINEAR, LINEAR)] if right.get(0) or left.get(0) else [(LINEAR, LINEAR), sides]
        for share in SHARES:
            for shape in shapes:
                crossed = [(share * c, own) for c, own in _times_speed(*shape, place, 1, line)]
                coefficients, basis = zip(*energy, *crossed, strict=True)
                yield build_formula(basis, coefficients, system.states)


def _forces(cells: Sequence[FieldCell], radius: Number, place: int, speed: Polynomial) -> tuple[Powers, Powers] | None:
    """The force g on the right and on the left, the mean of both signs of v; None where ``x' = v`` does not hold."""
    if any(field[place] != speed for cell in cells for field in cell.velocities):
        return None
    sides = []
    for turn in (1, -1):
        found: dict[int, Fraction] = {}
        for up in (1, -1):
            at = [radius * (turn * NEAR), radius * (up * NEAR * NEAR)]
            inside = next((cell for cell in cells if cell.region.contains((at[place], at[1 - place]))), None)
            if inside is None:
                return None
            for exponents, c in inside.velocities[0][1 - place].terms.items():
                known = c.as_rational()
                if exponents[1 - place]:
                    continue
                if known is None or exponents[place] > MOST_DEGREE:
                    return None
                found[exponents[place]] = found.get(exponents[place], Fraction(0)) - as_fraction(known) / 2
        sides.append(found)
    right, left = sides
    return right, left


def _integral(powers: Powers) -> Powers:
    return {k + 1: c / (k + 1) for k, c in powers.items()}


def _times_speed(
    right: Powers, left: Powers, place: int, power: int, line: Polynomial
) -> Iterator[tuple[Fraction, BasisFunction]]:
    """A function of x with powers on either side, times a power of v, by ``x^k`` and ``|x| x^(k - 1)``."""
    for k in sorted({*right, *left}):
        a, b = right.get(k, Fraction(0)), left.get(k, Fraction(0))
        yield (a + b) / 2, BasisFunction(_monomial(line.field, place, k, power), None)
        if a != b:
            yield (a - b) / 2, BasisFunction(_monomial(line.field, place, k - 1, power), line)


def _monomial(field: NumberField, place: int, k: int, power: int) -> Polynomial:
    """``x^k v^power`` in the displacement."""
    exponents = (k, power) if place == 0 else (power, k)
    return Polynomial(field, PLANE, {exponents: field.one})
