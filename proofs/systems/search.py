"""Every search for a V of a plain system, in order, and whether a V that was found speaks of the system.

Systems of cones with linear fields get a piecewise quadratic V on the whole plane.  For others a linear program
proposes sums of monomials and bent functions on a square; then the linear parts of the cones propose.  With time
reversed the same searches find a function that grows along every solution.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, Refutation, Supremum, inhabited
from nonsmooth.proofs.systems.domain import SHRINKING, Domain, domains, given_cells, plane_cells
from nonsmooth.proofs.systems.findings import DERIVATIVES, ExaminedFunction
from nonsmooth.proofs.systems.lyapunov_search import (
    ENLARGING_WORK,
    Budget,
    Turn,
    find_lyapunov,
    find_weak_lyapunov,
    largest_square,
    searched_cells,
    square_cells,
)
from nonsmooth.proofs.systems.piecewise_quadratic import (
    HALVINGS,
    PotentialPiece,
    build_potential,
    find_near,
    find_piecewise_quadratic,
    linear_cones,
    linear_parts,
    potential_pieces,
    restricted,
)
from nonsmooth.proofs.systems.ray_moves import are_cones, conic_germ
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.switched_system import SwitchedSystem

BISECTIONS = 4  # of the square of a V for the linear parts of cones, where that is not the checked one
SEARCH_SCALES = (Fraction(1), SHRINKING, SHRINKING**2, SHRINKING**3)  # of the checked square


@dataclass(frozen=True)
class PlaneFunction(ExaminedFunction):
    """A V of a system in two states.

    Attributes:
        result: Lyapunov's conditions with their evidence.
        on: where they are looked at.
        formula: V as one formula; None where it is known by its pieces only.
        states: their names.
        grows: whether time was reversed.
        is_given: whether it is the scene's.
    """

    result: LyapunovResult
    on: Domain
    formula: PiecewiseExpression | None
    states: tuple[str, ...]
    grows: bool = False
    is_given: bool = False

    @property
    def domain(self) -> Domain:
        """The same."""
        return self.on

    @property
    def decrease(self) -> Decrease:
        """What follows from the conditions."""
        return self.result.verdict

    @property
    def reason(self) -> str:
        """The same as a sentence."""
        return self.result.reason

    @property
    def witness(self) -> Refutation | None:
        """Where one of them fails."""
        return self.result.witness

    @property
    def pieces(self) -> tuple[PotentialPiece, ...]:
        """V cone by cone, of one that was searched so."""
        return potential_pieces(self.result.cells, self.states) if self.formula is None else ()

    @property
    def suprema(self) -> dict[str, Supremum]:
        """The largest values of the derivatives."""
        return {name: self.result.supremum(name) for name in DERIVATIVES}

    def check(self, system: SwitchedSystem) -> bool:
        """Verify the conditions, and that they are about the system, or the reversed one, on the domain."""
        return self._speaks_of(system) and self.result.check()

    def _speaks_of(self, system: SwitchedSystem) -> bool:
        """Whether the cells are those of the system, or of the reversed one, on the domain that is named."""
        cells, radius = self.result.cells, self.domain.radius
        if self.is_given:
            own = domains(system, system.check.lyapunov, plane_cells(system))
            return self.domain in own and cells == inhabited(given_cells(system, self.domain))
        turn = reversed_cells if self.grows else tuple
        if self.formula is not None:
            return radius is not None and cells == searched_cells(system, self.formula, radius, turn)
        known = [(cell.region, cell.velocities) for cell in cells]
        return any(
            known == [(cell.region, cell.velocities) for cell in own] for own in _cut_by_cones(system, radius, turn)
        )


def _cut_by_cones(system: SwitchedSystem, radius: Number | None, turn: Turn) -> Iterator[Sequence[LyapunovCell]]:
    """The cells, without V, that a V of pieces on cones may have: the cones, or those of a square cut along them."""
    cells = turn(plane_cells(system))
    near = cells if radius is None else conic_germ(cells)
    linear = near if radius is None or near is None else linear_parts(near)
    for halvings in HALVINGS if linear is not None else ():
        rays, cones = linear_cones(linear or (), halvings)
        pieces = build_potential(rays, cones, [Fraction(0)] * len(rays), [Fraction(0)] * len(cones))
        yield pieces if radius is None else inhabited(restricted(pieces, square_cells(system, radius, turn)))


def search_lyapunov(system: SwitchedSystem, cells: Sequence[FieldCell], *, grows: bool = False) -> PlaneFunction | None:
    """A V that is proved to fall along every solution (with time reversed: to grow); None where none is found.

    Args:
        system: in two states.
        cells: of the whole plane.
        grows: whether time is reversed.
    """
    turn = reversed_cells if grows else tuple
    if are_cones(cells) and not system.others:
        found = find_piecewise_quadratic(turn(cells))
        if found is not None:
            return PlaneFunction(found, Domain(None), None, system.states, grows)
    proposed = find_lyapunov(system, turn)
    if proposed is not None:
        return PlaneFunction(proposed.result, Domain(proposed.radius), proposed.formula, system.states, grows)
    near = None if are_cones(cells) or system.others else conic_germ(cells)
    refused = None
    for scale in SEARCH_SCALES if near is not None else ():
        radius = system.check.radius * scale
        by_pieces = find_near(turn(near or ()), square_cells(system, radius, turn))
        if by_pieces is not None:
            pieces, result = by_pieces
            found_here = PlaneFunction(result, Domain(radius), None, system.states, grows)
            return enlarged_pieces(system, pieces, found_here, refused)
        refused = radius
    return None


def enlarged_pieces(
    system: SwitchedSystem, pieces: Sequence[LyapunovCell], found: PlaneFunction, refused: Number | None
) -> PlaneFunction:
    """The same V, of pieces on cones, on a larger square below one on which there is none, by bisection."""
    turn = reversed_cells if found.grows else tuple
    if found.domain.radius is None or refused is None:
        return found
    larger = largest_square(
        lambda radius: restricted(pieces, square_cells(system, radius, turn)),
        (found.domain.radius, refused),
        BISECTIONS,
        Budget(BISECTIONS * ENLARGING_WORK),
    )
    return found if larger is None else replace(found, result=larger[1], on=Domain(larger[0]))


def search_weak_lyapunov(system: SwitchedSystem, *, may_attract: bool = True) -> PlaneFunction | None:
    """A V that does not increase, if possible one that shows asymptotic stability; None where none is found.

    Args:
        system: in two states.
        may_attract: whether the equilibrium may attract; otherwise the first V serves.
    """
    found = find_weak_lyapunov(system, may_attract=may_attract)
    return None if found is None else PlaneFunction(found.result, Domain(found.radius), found.formula, system.states)


def reversed_cells(cells: Sequence[FieldCell]) -> tuple[FieldCell, ...]:
    """The system with time reversed."""
    return tuple(replace(cell, velocities=tuple((-f, -g) for f, g in cell.velocities)) for cell in cells)
