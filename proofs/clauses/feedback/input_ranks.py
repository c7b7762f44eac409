"""How many independent inputs act in each cell, across each side, and at the equilibrium.

In one cell the control vector fields of its contact state span the motions that inputs can give: rank 2 with a roll
row in third place, rank 1 with a side row (the paper's "not locally controllable").  On a side, and at the
equilibrium, Filippov mixtures of the neighbours' fields are available too.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from nonsmooth.analysis.cells.equilibria import shared_sides
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.symbolic.constraints import Triple, independent


@dataclass(frozen=True)
class InputRanks:
    """Ranks of the control vector fields.

    Attributes:
        cells: rank by number of the cell.
        sides: rank by pair of neighbouring cells.
        equilibrium: rank of all fields that meet at the checked point.
    """

    cells: dict[int, int]
    sides: dict[tuple[int, int], int]
    equilibrium: int


def input_ranks(partition: Partition) -> InputRanks:
    """Ranks for a centred partition of rule ``nearest``."""
    zero = partition.scene.field.zero
    sides = {
        (side.first.index, side.second.index): _rank([side.first, side.second]) for side in shared_sides(partition)
    }
    return InputRanks(
        {cell.index: _rank([cell]) for cell in partition.cells}, sides, _rank(partition.cells_at((zero, zero)))
    )


def _rank(cells: Iterable[Cell]) -> int:
    fields: list[Triple] = [field for cell in cells for state in cell.states for field in state.control_fields.values()]
    return len(independent(fields))
