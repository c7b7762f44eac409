"""Loads over a box of wheel positions and of places of the body, as long as every wheel carries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from nonsmooth.symbolic.mechanics.load_model import Arithmetic
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.springs import load_model


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
    off = step * arb(0, 1)
    moments = [(arb(1), x.ball() + off, y.ball() + off) for x, y in (wheel.position for wheel in scene.wheels)]
    forms = load_model(scene).forms(moments, range(len(moments)), BALLS)
    return None if forms is None else LoadBox(tuple(forms))


def _inverse(*rows: tuple[arb, arb, arb]) -> list[tuple[arb, arb, arb]] | None:
    """By elimination, which loses less than cofactors where balls are wide."""
    try:
        inverse = arb_mat([list(row) for row in rows]).inv()
    except ZeroDivisionError:
        return None
    return [(inverse[0, c], inverse[1, c], inverse[2, c]) for c in range(3)]


BALLS: Arithmetic[arb] = Arithmetic(lambda number: number.ball(), _inverse, lambda load: (load > 0) - (load < 0))
