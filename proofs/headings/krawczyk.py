"""One zero of a smooth map in a box, proved by Krawczyk's operator in ball arithmetic.

With an approximate zero m, an approximate inverse Y of the Jacobian there and the Jacobian J(X) over a box X about m,
``K = m - Y E(m) + (I - Y J(X)) (X - m)``.  If K lies in the interior of X, E has exactly one zero in X, it lies in K,
and every matrix in J(X) is regular (Krawczyk 1969; Neumaier 1990, theorem 5.1.8).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from flint import arb, arb_mat

from nonsmooth.proofs.headings.ball_motion import UndecidedMotionError

Map: TypeAlias = Callable[[arb_mat], tuple[arb_mat, arb_mat]]  # a point (n, 1) to the value (n, 1) and Jacobian (n, n)

NEWTON_STEPS = 12  # from a float to the full precision
RADIUS_BITS = 60  # the box has the radius 2^-60


def zero_near(equations: Map, start: list[float]) -> arb_mat:
    """A box (n, 1) that holds exactly one zero near a start.

    Raises:
        UnprovedError: where none is proved.
    """
    point = arb_mat([[arb(value)] for value in start])
    try:
        for _ in range(NEWTON_STEPS):
            value, slope = equations(point)
            point = (point - slope.mid().inv().mid() * value).mid()
        around = arb(0, arb(2) ** -RADIUS_BITS)
        box = arb_mat([[entry + around] for entry in point.entries()])
        return contracted(equations, box)
    except ZeroDivisionError:
        raise UndecidedMotionError("a Jacobian that may be singular") from None


def contracted(equations: Map, box: arb_mat) -> arb_mat:
    """Krawczyk's operator on a box, where it maps it into its interior.

    Raises:
        UnprovedError: where it does not.
    """
    size = box.nrows()
    middle = box.mid()
    value, slope = equations(middle)
    inverse = slope.mid().inv().mid()
    spread = equations(box)[1]
    identity = arb_mat(size, size, [arb(int(k // size == k % size)) for k in range(size * size)])
    image = middle - inverse * value + (identity - inverse * spread) * (box - middle)
    inside = all(outer.contains_interior(inner) for outer, inner in zip(box.entries(), image.entries(), strict=True))
    if not inside:
        raise UndecidedMotionError("a box that Krawczyk's operator does not map into itself")
    return image
