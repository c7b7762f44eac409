"""A solution that starts at the point and leaves it: the velocity of a cell at the point leads into the cell.

Let s = 0 be the surfaces through the point, and f the field of a cell in which they have the signs e.  If
``e grad s . f > 0`` at the point for each of them, the solution ``t f + ...`` of the field of this cell stays in it for
a while.  A cone with a linear field that holds an eigenvector of a positive eigenvalue holds a ray along which
solutions leave: the columns of ``adj(s I - A)`` are eigenvectors at the roots of the characteristic polynomial, and the
signs of polynomials at such a root are exact.  Where the right-hand sides only enclose the field neither says anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from flint import fmpq, fmpq_mat

from nonsmooth.proofs.checker.polynomials import unit
from nonsmooth.proofs.inequalities.real_roots import RealRoot, positive_roots
from nonsmooth.proofs.kernel.sign_cells import RationalTerms, SignCell, SignCells, adjoining, rational_terms
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.switched_system import SwitchedSystem

Velocity = tuple[fmpq, ...]


def escaping_velocity(system: SwitchedSystem, cells: SignCells) -> Velocity | None:
    """The velocity at the point of a cell that it leads into; None where no cell has one."""
    if system.only_encloses:
        return None
    zero = (0,) * len(cells.states)
    for cell in adjoining(cells):
        for field in cell.velocities:
            velocity = tuple(part.get(zero, fmpq(0)) for part in field)
            if any(velocity) and _leads_into(cells, cell, velocity):
                return velocity
    return None


def _leads_into(cells: SignCells, cell: SignCell, velocity: Sequence[fmpq]) -> bool:
    """Whether a velocity at the point leads into a cell."""
    count = len(velocity)
    for surface, sign in zip(cells.surfaces, cell.signs, strict=True):
        terms = rational_terms(surface)
        if terms.get((0,) * count):
            continue
        slope = sum((terms.get(unit(count, k), fmpq(0)) * v for k, v in enumerate(velocity)), fmpq(0))
        if not slope * sign > 0:
            return False
    return True


def escaping_rate(system: SwitchedSystem, cells: SignCells) -> Fraction | None:
    """A lower bound of the rate at which solutions leave along a ray in an open cone; None where none is found."""
    if system.only_encloses:
        return None
    zero = (0,) * len(cells.states)
    near = [(j, s) for j, s in enumerate(cells.surfaces) if zero not in s.terms]
    if any(surface.degree != 1 for _, surface in near):
        return None
    for cell in adjoining(cells):
        forms = [
            [cell.signs[j] * rational_terms(surface).get(unit(len(zero), k), fmpq(0)) for k in range(len(zero))]
            for j, surface in near
        ]
        for field in cell.velocities:
            if all(sum(e) == 1 for part in field for e in part):
                for root in _rays(system, field, forms):
                    return root.low
    return None


def _rays(
    system: SwitchedSystem, field: Sequence[RationalTerms], forms: Sequence[Sequence[fmpq]]
) -> Iterator[RealRoot]:
    """Positive eigenvalues of a linear field with an eigenvector at which all forms are positive."""
    count = len(field)
    matrix = fmpq_mat([[part.get(unit(count, k), fmpq(0)) for k in range(count)] for part in field])
    characteristic, adjugates = _resolvent(matrix)
    for root in positive_roots([system.field(c) for c in characteristic]):
        for column in range(count):
            heights = [_height(system, adjugates, form, column) for form in forms]
            signs = {root.sign_of(height) for height in heights}
            if len(signs) == 1 and 0 not in signs:
                yield root
                break


def _height(system: SwitchedSystem, adjugates: Sequence[fmpq_mat], form: Sequence[fmpq], column: int) -> list[Number]:
    """A form at one column of the adjugate, as a polynomial in the eigenvalue, ascending."""
    values = (sum((f * m[i, column] for i, f in enumerate(form)), fmpq(0)) for m in reversed(adjugates))
    return [system.field(value) for value in values]


def _resolvent(matrix: fmpq_mat) -> tuple[list[fmpq], list[fmpq_mat]]:
    """The characteristic polynomial, ascending, and the coefficients of ``adj(s I - A)``, descending."""
    count = matrix.nrows()
    identity = fmpq_mat([[fmpq(i == j) for j in range(count)] for i in range(count)])
    coefficients, adjugates = matrix.charpoly().coeffs(), [identity]
    for value in coefficients[-2:0:-1]:
        adjugates.append(matrix * adjugates[-1] + identity * value)
    return coefficients, adjugates
