"""The dissipation ``D(xi) = sum_g |A_g xi - b_g|`` in ball arithmetic, with the derivatives that Newton's method needs.

Each group g of weighted contact rows is one wheel.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from flint import arb, arb_mat

Group: TypeAlias = tuple[arb_mat, arb_mat]  # A (m, 3) and b (m, 1)


def slip_size(group: Group, twist: arb_mat) -> tuple[arb_mat, arb]:
    """``w = A xi - b`` and its length."""
    w = group[0] * twist - group[1]
    return w, sum((entry * entry for entry in w.entries()), arb(0)).sqrt()


def derivatives(groups: Sequence[Group], twist: arb_mat) -> tuple[arb_mat, arb_mat]:
    """Gradient ``sum A^T u`` and Hessian ``sum A^T (1 - u u^T) A/|w|`` with ``u = w/|w|``."""
    gradient, hessian = arb_mat(3, 1), arb_mat(3, 3)
    for group in groups:
        w, size = slip_size(group, twist)
        unit, matrix = w * (1 / size), group[0]
        one = arb_mat([[int(j == k) for k in range(w.nrows())] for j in range(w.nrows())])
        gradient += matrix.transpose() * unit
        hessian += matrix.transpose() * (one - unit * unit.transpose()) * matrix * (1 / size)
    return gradient, hessian
