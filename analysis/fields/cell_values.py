"""Polynomials on cells of the plane, evaluated in floats at many places, for pictures and samples."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell
from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS, Polynomial


def polynomial_values(polynomial: Polynomial, xs: Floats, ys: Floats) -> Floats:
    """A polynomial in two variables at many places, of any shape."""
    return _values(polynomial, [xs, ys])


def rate_values(field: StatedField, xs: Floats, ys: Floats) -> tuple[Floats, Floats]:
    """The rates of both states at many places, of any shape."""
    values = [xs, ys]
    for wave in field.waves:
        argument = polynomial_values(wave.argument, xs, ys)
        values.append(np.sin(argument) if wave.kind == "sin" else np.cos(argument))
    first, second = (_values(rate, values) for rate in field.rates)
    return first, second


@BEYOND_FLOATS
def _values(polynomial: Polynomial, variables: list[Floats]) -> Floats:
    """A polynomial in any number of variables at many places."""
    total = np.zeros_like(variables[0])
    for exponents, c in polynomial.terms.items():
        term = np.full_like(variables[0], float(c))
        for variable, exponent in zip(variables, exponents, strict=True):
            term = term * variable**exponent if exponent else term
        total += term
    return total


def inside(cell: FieldCell, xs: Floats, ys: Floats) -> Mask:
    """Which places lie in a closed cell."""
    kept = np.ones(xs.shape, dtype=bool)
    for a, b, c in cell.region.sides:
        kept &= float(a) * xs + float(b) * ys + float(c) >= 0
    for guard in cell.region.guards:
        kept &= polynomial_values(guard, xs, ys) >= 0
    return kept


def potential_values(cells: Iterable[LyapunovCell], places: Floats) -> Floats:
    """V at places in the displacement from the checked point; infinite outside all cells.

    Args:
        cells: of the domain of V.
        places: (m, 2).

    Returns:
        (m,) values.
    """
    xs, ys = places[:, 0], places[:, 1]
    values = np.full(len(places), np.inf)
    for cell in cells:
        here = inside(cell, xs, ys)
        values[here] = polynomial_values(cell.potential, xs[here], ys[here])
    return values
