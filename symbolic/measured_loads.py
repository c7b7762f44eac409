"""Loads measured at one pose, carried to others with the moment balance.

Let springs of equal stiffness but unknown heights carry the body: ``N_i = k (m_i . y - h_i)``, ``m_i = (1, p_i)``, as
long as no wheel lifts off.  Then the loads at two centres of mass differ by the elastic ones, whatever the heights::

    N_i(c) = N_i(c_0) + m_i^T G^-1 (0, c - c_0),      G = sum_j m_j m_j^T.

``c_0`` is the centre of the measured loads, ``sum N_i p_i / sum N_i``: so sum and moments balance at every c.  Where a
load would become negative a wheel lifts off, and the table ends there
(:func:`nonsmooth.analysis.cells.loads.load_regions` refuses such a square).
"""

from __future__ import annotations

from collections.abc import Sequence

from nonsmooth.symbolic.constraints import Triple
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector
from nonsmooth.symbolic.scene import LoadTable
from nonsmooth.symbolic.springs import EXACT, EqualSprings


class NoSpringsError(ValueError):
    """Wheels on one line: elastic loads are undetermined."""


def spring_forms(positions: Sequence[Vector]) -> list[Triple]:
    """``G^-1 m_i`` for every wheel: its elastic load ``form . (1, c)`` while all wheels carry, total weight 1.

    Raises:
        NoSpringsError: for wheels on one line.
    """
    one = positions[0][0].field.one
    forms = EqualSprings().forms([(one, *position) for position in positions], range(len(positions)), EXACT)
    if forms is None:
        raise NoSpringsError("required three wheels that are not collinear")
    return forms


def centre_of(values: Sequence[Number], positions: Sequence[Vector]) -> Vector:
    """``sum N_i p_i / sum N_i`` of loads in any unit that are not all zero."""
    zero = values[0].field.zero
    weight = sum(values, zero)
    x, y = (sum((value * p[axis] for value, p in zip(values, positions, strict=True)), zero) for axis in (0, 1))
    return x / weight, y / weight


def carried_table(values: Sequence[Number], positions: Sequence[Vector]) -> LoadTable:
    """The affine loads of total weight 1 that have these values (in any unit, not all zero) at their own centre.

    Raises:
        NoSpringsError: for wheels on one line.
    """
    weight = sum(values, values[0].field.zero)
    x, y = centre_of(values, positions)
    forms = spring_forms(positions)
    return LoadTable(
        tuple((value / weight - b * x - c * y, b, c) for value, (_, b, c) in zip(values, forms, strict=True))
    )


def largest_correction(table: LoadTable, centre: Vector, at: Vector) -> Number:
    """By how much a load changes at most where measured loads are taken to balance at ``at`` instead of their centre.

    As a share of the weight.
    """
    dx, dy = at[0] - centre[0], at[1] - centre[1]
    return max(abs(b * dx + c * dy) for _, b, c in table.rows)
