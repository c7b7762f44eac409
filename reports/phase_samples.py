"""Fields and potentials of plain systems in two states at many points, in floats, for pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.cell_values import inside, polynomial_values, rate_values

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell
    from nonsmooth.analysis.fields.stated_field import StatedField

Floats: TypeAlias = NDArray[np.float64]


def sampled_rates(
    cells: Sequence[FieldCell], fields: Sequence[StatedField], xs: Floats, ys: Floats
) -> tuple[Floats, Floats]:
    """The field at many points, that of one cell where several meet."""
    first, second = np.zeros_like(xs), np.zeros_like(xs)
    for cell, field in zip(cells, fields, strict=True):
        here = inside(cell, xs, ys)
        f, g = rate_values(field, xs, ys)
        first[here], second[here] = f[here], g[here]
    return first, second


def sampled_potential(cells: Iterable[LyapunovCell], xs: Floats, ys: Floats) -> Floats:
    """V at many points."""
    potential = np.zeros_like(xs)
    for cell in cells:
        here = inside(cell, xs, ys)
        potential[here] = polynomial_values(cell.potential, xs, ys)[here]
    return potential
