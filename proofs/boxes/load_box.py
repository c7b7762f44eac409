"""Loads of equal springs over a box of wheel positions and of places of the body.

``N_i = (1, p_i) . G^-1 (1, c)``, ``G = sum_k (1, p_k)(1, p_k)^T``, as long as no load is negative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from nonsmooth.symbolic.scene import LoadTable, Scene


@dataclass(frozen=True)
class LoadBox:
    """Loads as affine functions of c, with enclosures of their coefficients.

    Attributes:
        forms: ``(c0, cx, cy)`` of every wheel, balls.
    """

    forms: tuple[tuple[arb, arb, arb], ...]

    def at(self, place: Sequence[arb]) -> list[arb]:
        """Loads at a place (x, y), balls."""
        x, y = place
        return [c0 + cx * x + cy * y for c0, cx, cy in self.forms]


def load_box(scene: Scene, step: arb) -> LoadBox | None:
    """Loads of a scene whose positions may be off by ``step``; None where the springs do not fix them."""
    loads = scene.contact.loads
    if isinstance(loads, LoadTable):
        return LoadBox(tuple((a.ball(), b.ball(), c.ball()) for a, b, c in loads.rows))
    moments = [[arb(1), *(entry.ball() + step * arb(0, 1) for entry in wheel.position)] for wheel in scene.wheels]
    gram = arb_mat([[sum((m[r] * m[c] for m in moments), arb(0)) for c in range(3)] for r in range(3)])
    try:
        inverse = gram.inv()
    except ZeroDivisionError:
        return None
    forms = []
    for m in moments:
        form = [sum((m[r] * inverse[r, c] for r in range(3)), arb(0)) for c in range(3)]
        forms.append((form[0], form[1], form[2]))
    return LoadBox(tuple(forms))
