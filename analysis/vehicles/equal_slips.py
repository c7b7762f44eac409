"""The exact motion under friction ellipses where all weighted slips are alike.

Minus the gradient of ``D = sum N_i sqrt(q_i)``, with ``q_i = mu_R^2 r_i^2 + mu_S^2 s_i^2``, balances forces and moments
at a minimizer.  Where all loaded wheels slip with one size ``sqrt(q_i) = q > 0``, the balance is that of the weighted
least squares fit ``sum N_i q_i`` times 1/q: three linear equations in the twist.  So the fit is solved exactly, and it
is the minimizer of D exactly if its weighted slips are alike; nothing is assumed of symmetry.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from nonsmooth.analysis.cells.loads import elastic_loads_at
from nonsmooth.analysis.contact_rule import SmoothRule
from nonsmooth.symbolic.constraints import Triple, Twist, cofactors, inner
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import cross
from nonsmooth.symbolic.scene import Scene, Wheel

Pair: TypeAlias = tuple[Number, Number]
Row: TypeAlias = tuple[Triple, Number]  # normal a_k and target b_k of a unit row


def equal_slip_twist(scene: Scene, rule: SmoothRule) -> Twist | None:
    """The exact twist at the checked point; None where weighted slips differ, or a friction set is a cut ellipse.

    Where no loaded wheel slips at all nothing is dissipated, which is the least for every friction set.

    Raises:
        LoadError: where the point lies outside the support polygon or on its border, or the wheels are collinear.
    """
    if scene.contact.loads is not None:
        return None
    loads = elastic_loads_at(scene, scene.check.equilibrium)
    sets = [rule.friction_set(wheel.friction) for wheel in scene.wheels]
    weights = [(one.along * one.along, one.across * one.across) for one in sets]
    rows = [_unit_rows(wheel) for wheel in scene.wheels]
    twist = _fitted(loads, weights, rows)
    if twist is None:
        return None
    squares = _weighted_slips_squared(loads, weights, rows, twist)
    slides = any(squares)
    if slides and (any(one.is_cut for one in sets) or any(square != squares[0] for square in squares)):
        return None
    return Twist(*twist)


def slips_somewhere(scene: Scene, twist: Twist) -> bool:
    """Whether any wheel slips at a twist, exactly."""
    return any(_slip(row, twist) for wheel in scene.wheels for row in _unit_rows(wheel))


def _weighted_slips_squared(
    loads: Sequence[Number], weights: Sequence[Pair], rows: Sequence[tuple[Row, Row]], twist: Triple
) -> list[Number]:
    """``q_i`` of the loaded wheels."""
    squares = []
    for load, pair, both in zip(loads, weights, rows, strict=True):
        if load:
            along, across = (weight * _slip(row, twist) ** 2 for weight, row in zip(pair, both, strict=True))
            squares.append(along + across)
    return squares


def _unit_rows(wheel: Wheel) -> tuple[Row, Row]:
    """The roll and the side row with unit normals."""
    a, p = wheel.unit_grip, wheel.position
    side = -a[1], a[0]
    along, across = wheel.slip_speeds
    return ((*a, cross(p, a)), along), ((*side, cross(p, side)), across)


def _slip(row: Row, twist: Triple) -> Number:
    return inner(row[0], twist) - row[1]


def _fitted(loads: Sequence[Number], weights: Sequence[Pair], rows: Sequence[tuple[Row, Row]]) -> Triple | None:
    """The twist that minimizes ``sum N_i (mu_R^2 r_i^2 + mu_S^2 s_i^2)``; None where it is not unique."""
    zero = loads[0] * 0
    matrix, right = [[zero] * 3 for _ in range(3)], [zero] * 3
    for load, pair, both in zip(loads, weights, rows, strict=True):
        for weight, (normal, target) in zip(pair, both, strict=True):
            for i in range(3):
                scaled = load * weight * normal[i]
                right[i] = right[i] + scaled * target
                matrix[i] = [entry + scaled * other for entry, other in zip(matrix[i], normal, strict=True)]
    first, second, third = ((row[0], row[1], row[2]) for row in matrix)
    columns = cofactors(first, second, third)  # of the inverse, times the determinant
    determinant = inner(first, columns[0])
    if not determinant:
        return None
    x, y, z = (sum((columns[k][i] * right[k] for k in range(3)), zero) / determinant for i in range(3))
    return x, y, z
