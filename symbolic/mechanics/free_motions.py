"""Free motions: the twists that no row with friction resists, exactly.

A row with friction resists a twist xi unless ``a_k . xi = 0``.  So the free twists are the kernel of the rows with
friction, and along each of them D is constant: if xi minimizes D, so does xi plus any free twist.  Free rollers with
all their axes through one point, for example, leave the rotation about it free.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from nonsmooth.symbolic.mechanics.constraints import Row, Triple, basis_of, complement, rows_with_friction
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_text import brief_text


def free_twists(scene: Scene) -> tuple[Triple, ...]:
    """A basis of the twists that no row with friction of any wheel resists; empty where every motion is resisted."""
    return kernel(rows_with_friction(scene))


def kernel(rows: Iterable[Row]) -> tuple[Triple, ...]:
    """A basis of the twists that satisfy ``a_k . xi = 0`` for rows of which at least one is there."""
    return complement(basis_of(row.normal for row in rows))


def free_text(twists: Sequence[Triple]) -> str:
    """In words, that these motions are free; empty where there are none."""
    if not twists:
        return ""
    listed = ", ".join(f"({', '.join(brief_text(entry) for entry in twist)})" for twist in twists)
    return f"no row with friction resists the motion{'s' if len(twists) > 1 else ''} xi = {listed}"
