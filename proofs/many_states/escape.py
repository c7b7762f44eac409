"""A solution that starts at the point and leaves it: the velocity of a cell at the point leads into the cell.

Let s = 0 be the surfaces through the point, and f the field of a cell in which they have the signs e.  If
``e grad s . f > 0`` at the point for each of them, the solution ``t f + ...`` of the field of this cell stays in it for
a while.  Where the right-hand sides only enclose the field this says nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import fmpq

from nonsmooth.proofs.many_states.faces import unit
from nonsmooth.proofs.many_states.sign_cells import SignCell, SignCells, adjoining, rational_terms
from nonsmooth.symbolic.switched_system import SwitchedSystem

Velocity = tuple[fmpq, ...]


def escaping_velocity(system: SwitchedSystem, cells: SignCells) -> Velocity | None:
    """The velocity at the point of a cell that it leads into; None where no cell has one."""
    if system.waves:
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
