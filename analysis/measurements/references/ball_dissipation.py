"""The dissipation ``D(xi) = sum_g |A_g xi - b_g|`` in ball arithmetic, with the derivatives that Newton's method needs.

Each group g of weighted contact rows is one wheel (ellipse) or one row (box).  With a smoothing ``delta`` every norm
``|w|`` becomes ``sqrt(|w|^2 + delta^2)``, which makes the sum smooth and strictly convex.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from flint import arb, arb_mat

Group: TypeAlias = tuple[arb_mat, arb_mat]  # A (m, 3) and b (m, 1)


def slip_size(group: Group, twist: arb_mat, delta: arb) -> tuple[arb_mat, arb]:
    """``w = A xi - b`` and its smoothed length."""
    w = group[0] * twist - group[1]
    squared = sum((entry * entry for entry in w.entries()), delta * delta)
    # the ball of a slip that vanishes holds zero, so that of its square may reach below
    return w, squared.nonnegative_part().sqrt()


def value(groups: Sequence[Group], twist: arb_mat, delta: arb) -> arb:
    """``D_delta``."""
    return sum((slip_size(group, twist, delta)[1] for group in groups), arb(0))


def derivatives(groups: Sequence[Group], twist: arb_mat, delta: arb) -> tuple[arb_mat, arb_mat]:
    """Gradient ``sum A^T u`` and Hessian ``sum A^T (1 - u u^T) A/|w|`` with ``u = w/|w|``."""
    gradient, hessian = arb_mat(3, 1), arb_mat(3, 3)
    for group in groups:
        w, size = slip_size(group, twist, delta)
        unit, matrix = w * (1 / size), group[0]
        one = arb_mat([[int(j == k) for k in range(w.nrows())] for j in range(w.nrows())])
        gradient += matrix.transpose() * unit
        hessian += matrix.transpose() * (one - unit * unit.transpose()) * matrix * (1 / size)
    return gradient, hessian
