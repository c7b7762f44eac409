"""Fields and potentials of plain systems in two states at many points, in floats, for pictures."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.cell_values import inside, polynomial_values

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell

Floats: TypeAlias = NDArray[np.float64]


def sampled_rates(cells: Iterable[FieldCell], xs: Floats, ys: Floats) -> tuple[Floats, Floats]:
    """The field at many points, that of one cell where several meet."""
    first, second = np.zeros_like(xs), np.zeros_like(xs)
    for cell in cells:
        here = inside(cell, xs, ys)
        f, g = cell.velocities[0]
        first[here], second[here] = polynomial_values(f, xs, ys)[here], polynomial_values(g, xs, ys)[here]
    return first, second


def sampled_potential(cells: Iterable[LyapunovCell], xs: Floats, ys: Floats) -> Floats:
    """V at many points."""
    potential = np.zeros_like(xs)
    for cell in cells:
        here = inside(cell, xs, ys)
        potential[here] = polynomial_values(cell.potential, xs, ys)[here]
    return potential
