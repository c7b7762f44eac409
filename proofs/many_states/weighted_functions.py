"""A search for V among forms of one weight, for fields whose lowest terms are homogeneous with weights of the states.

With weights ``r_k`` of the states, where the lowest terms of each ``x_k'`` have the weight ``d + r_k`` with one d, a V
serves that is a form of some weight (Rosier 1992; Bacciotti and Rosier 2005): products of powers of the states, one of
which may stand in absolute value.  The chain ``x' = y, y' = z, z' = -sign(y)`` has the weights 3, 2, 1: with
``J = x + y z + z^3/3`` where y > 0 it keeps ``J^2 + (abs(y) + z^2/2)^3``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import chain, product
from math import gcd

import numpy as np
from flint import fmpq_mat

from nonsmooth.proofs.checker.polynomials import Exponents
from nonsmooth.proofs.kernel.bases import PiecewiseFunction, formula_text, monomial
from nonsmooth.proofs.kernel.cells import SignCells, adjoining, build_cells, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.quotients import coefficients_of
from nonsmooth.proofs.kernel.written import null_basis
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, examine
from nonsmooth.proofs.many_states.weak_functions import SHARES, FunctionFamily
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

MOST_STATES = 3
LARGEST = 3  # weight of a state


@dataclass(frozen=True)
class WeightedFamily(FunctionFamily):
    """Forms of one weight.

    Attributes:
        powers: of the states that have this weight.
    """

    powers: tuple[float, ...]

    @cached_property
    def kept(self) -> fmpq_mat:
        """Columns of coefficients whose sums solutions keep."""
        claims = map(self._conditions.claims_on_cells, range(len(self.basis)))
        rates = [[own.value.terms for claim in same for own in claim.inequalities] for same in claims]
        places = sorted({(k, e) for own in rates for k, terms in enumerate(own) for e in terms})
        return null_basis(fmpq_mat([[as_fmpq(own[k].get(e, Fraction(0))) for own in rates] for k, e in places]))

    def energies(self) -> Iterator[PiecewiseExpression]:
        """Positive sums that do not rise, in floats: those that are kept first."""
        program = replace(self.program, points=float(self.stated.cells.radius) * self.program.points)
        for columns in (self.kept, fmpq_mat(np.eye(len(self.basis), dtype=int).tolist())):
            if columns.ncols():
                for chosen in program.combined(columns).solutions(np.array(self.powers), positive=True):
                    text = formula_text(self.basis, coefficients_of(columns, chosen))
                    yield parse_piecewise(text, self.system.states)


def find_weighted_energy(system: SwitchedSystem) -> ExaminedLyapunov | None:
    """A positive form that does not rise; None where none is found.

    Args:
        system: in three states, with rational numbers.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    if len(system.states) > MOST_STATES:
        return None
    for share in SHARES:
        radius = system.check.radius * share
        for formula in chain.from_iterable(own.energies() for own in weighted_families(system, radius)):
            examined = examine(system, formula, radius, effort=Effort.FULL)
            if examined.decrease in (Decrease.STRICT, Decrease.WEAK):
                return examined
    return None


def weighted_families(system: SwitchedSystem, radius: Number) -> Iterator[WeightedFamily]:
    """The forms on a cube, for all weights with which the lowest terms are homogeneous there; raises as above."""
    states = system.states
    bends = parse_piecewise(" + ".join(f"Abs({name})" for name in states), states)
    stated, cells = stated_cells(system, radius, surfaces_of(system, bends)), build_cells(system, radius)
    for weights in product(range(1, LARGEST + 1), repeat=len(states)):
        if gcd(*weights) == 1 and _are_homogeneous(cells, weights):
            for degree in range(max(weights) + 1, 2 * max(weights) + 2):
                basis = tuple(_forms(states, weights, degree))
                yield WeightedFamily(system, stated, basis, tuple(degree / own for own in weights))


def _are_homogeneous(cells: SignCells, weights: Exponents) -> bool:
    """Whether surfaces through the point have one weight each, and the lowest terms of the velocities there one d."""
    lowest: dict[int, int] = {}
    for cell in adjoining(cells):
        for k, part in ((k, part) for field in cell.velocities for k, part in enumerate(field)):
            degrees = [_weight(e, weights) - weights[k] for e in part.terms]
            lowest[k] = min([*degrees, *([lowest[k]] if k in lowest else [])], default=LARGEST)
    through = (surface for surface in cells.surfaces if not surface.at_origin)
    return len(set(lowest.values())) == 1 and all(len({_weight(e, weights) for e in s.terms}) == 1 for s in through)


def _weight(exponents: Exponents, weights: Exponents) -> int:
    return sum(map(int.__mul__, exponents, weights))


def _forms(states: tuple[str, ...], weights: Exponents, degree: int) -> Iterator[PiecewiseFunction]:
    """Products of powers of a weight, alone and times the absolute value of a state."""
    for exponents in product(range(degree + 1), repeat=len(states)):
        rest, own = degree - _weight(exponents, weights), monomial(states, exponents)
        if not rest:
            yield own
        for weight, name in zip(weights, states, strict=True):
            if rest == weight:
                yield PiecewiseFunction(f"{own.text}*Abs({name})", own.degree + 1)
