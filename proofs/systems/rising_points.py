"""Points of a square at which V does not fall, with V nearly as small as it is at any such point.

Floats look for one on rays from the equilibrium, then on finer and finer grids about the best; exact arithmetic
confirms it.  One such point bounds all levels ``V < c`` that can be certified, and spares the exact prover the search.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Region
from nonsmooth.analysis.cells.switched_cells import LyapunovCell
from nonsmooth.proofs.systems.lyapunov_rows import Floats, values_at
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial

ANGLES, DISTANCES = 360, 160  # of the first points
WIDEST, FINER, ZOOMS, ACROSS = 1 / 40, 0.5, 24, 21  # grids: the first against the square, each against the one before
DIGITS = 16  # binary ones of a level


def first_rise(cells: Sequence[LyapunovCell], radius: Number) -> tuple[Fraction, Point] | None:
    """A level and a point where V is no larger and does not fall; None where none is seen.

    Args:
        cells: cover the square, with one polynomial V.
        radius: half its side.
    """
    found = [rise for cell in cells for rate in cell.rates for rise in _rises(cell, rate, float(radius))]
    return min(found, key=lambda rise: rise[0], default=None)


def _rises(cell: LyapunovCell, rate: Polynomial, radius: float) -> Iterator[tuple[Fraction, Point]]:
    """The last of finer and finer grids whose best point is confirmed."""
    best: list[Floats] = []
    points, step = _on_rays(radius), radius * WIDEST
    for _ in range(ZOOMS):
        lowest = _lowest(cell, rate, points, radius)
        if lowest is None:
            break
        best.append(lowest)
        line = np.linspace(-step, step, ACROSS)
        points = lowest + np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
        step *= FINER
    for place in reversed(best):
        point = cell.potential.field(Fraction(float(place[0]))), cell.potential.field(Fraction(float(place[1])))
        if cell.region.contains(point) and sign(rate(point)) >= 0 and any(map(sign, point)):
            yield _level_above(cell.potential(point)), point
            return


def _on_rays(radius: float) -> Floats:
    angles = np.linspace(-np.pi, np.pi, ANGLES, endpoint=False)
    units = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    units *= radius / np.abs(units).max(axis=1, keepdims=True)
    shares = np.arange(1, DISTANCES + 1) / DISTANCES
    return np.asarray((shares[:, None, None] * units).reshape(-1, 2))


def _lowest(cell: LyapunovCell, rate: Polynomial, points: Floats, radius: float) -> Floats | None:
    """The point of least V among those of a cell at which V does not fall."""
    inside = where_inside(cell.region, points) & (np.abs(points).max(axis=1) <= radius)
    kept = points[inside & (values_at(rate, points) >= 0)]
    return kept[np.argmin(values_at(cell.potential, kept))] if len(kept) else None


def where_inside(region: Region, points: Floats) -> NDArray[np.bool_]:
    """Which points a closed region holds, in floats."""
    kept = np.ones(len(points), dtype=bool)
    for a, b, c in (map(float, side) for side in region.sides):
        kept &= a * points[:, 0] + b * points[:, 1] + c >= 0
    for guard in region.guards:
        kept &= values_at(guard, points) >= 0
    return kept


def short_below(value: Fraction) -> Fraction:
    """A short fraction that is no larger than a positive one, and nearly as large."""
    unit = Fraction(2) ** (math.frexp(float(value))[1] - DIGITS)
    return unit * (value // unit)


def _level_above(value: Number) -> Fraction:
    """A short fraction that is no smaller."""
    unit = Fraction(2) ** (math.frexp(float(value))[1] - DIGITS)
    level = unit * (int(float(value) / unit) + 1)
    while sign(value - level) > 0:
        level += unit
    return level
