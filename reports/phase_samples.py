"""Fields and potentials of plain systems in two states at many points, in floats, for pictures."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell
    from nonsmooth.symbolic.numbers.polynomial import Polynomial

Floats: TypeAlias = NDArray[np.float64]


def values_of(polynomial: Polynomial, xs: Floats, ys: Floats) -> Floats:
    """A polynomial in the displacement at many points."""
    total = np.zeros_like(xs)
    for (a, b), c in polynomial.terms.items():
        total += float(c) * xs**a * ys**b
    return total


def inside(cell: FieldCell | LyapunovCell, xs: Floats, ys: Floats) -> NDArray[np.bool_]:
    """The points of a cell."""
    kept = np.ones(xs.shape, dtype=bool)
    for a, b, c in cell.region.sides:
        kept &= float(a) * xs + float(b) * ys + float(c) >= 0
    for guard in cell.region.guards:
        kept &= values_of(guard, xs, ys) >= 0
    return kept


def sampled_rates(cells: Iterable[FieldCell], xs: Floats, ys: Floats) -> tuple[Floats, Floats]:
    """The field at many points, that of one cell where several meet."""
    first, second = np.zeros_like(xs), np.zeros_like(xs)
    for cell in cells:
        here = inside(cell, xs, ys)
        f, g = cell.velocities[0]
        first[here], second[here] = values_of(f, xs, ys)[here], values_of(g, xs, ys)[here]
    return first, second


def sampled_potential(cells: Iterable[LyapunovCell], xs: Floats, ys: Floats) -> Floats:
    """V at many points."""
    potential = np.zeros_like(xs)
    for cell in cells:
        here = inside(cell, xs, ys)
        potential[here] = values_of(cell.potential, xs, ys)[here]
    return potential
