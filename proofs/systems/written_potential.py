"""A V that was searched, as people and other programs can read it: one polynomial per cone, in the states' names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import LyapunovCell
from nonsmooth.proofs.inequalities.cell_forms import directions
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.plane import cross, same_direction


@dataclass(frozen=True)
class PotentialPiece:
    """V on one cone at the equilibrium.

    Attributes:
        potential: V, in the displacement from the equilibrium under the states' names.
        start: first ray of the cone, counterclockwise.
        end: its last ray; None with ``start`` where one polynomial is V everywhere.
    """

    potential: Polynomial
    start: Point | None
    end: Point | None

    def __str__(self) -> str:
        if self.start is None or self.end is None:
            return f"{self.potential}"
        first, last = (f"({brief_text(x)}, {brief_text(y)})" for x, y in (self.start, self.end))
        return f"{self.potential} from ray {first} to ray {last}"


def potential_pieces(cells: Sequence[LyapunovCell], states: tuple[str, ...]) -> tuple[PotentialPiece, ...]:
    """The pieces of a V whose cells are cones, or parts of cones, at the origin."""
    spans: dict[Polynomial, list[tuple[Point, Point]]] = {}
    for cell in cells:
        found = spans.setdefault(cell.potential, [])
        for a, b in directions(cell.region):
            found.append(((a[0], a[1]), (b[0], b[1])))
    if len(spans) == 1:
        return tuple(PotentialPiece(replace(p, variables=states), None, None) for p in spans)
    return tuple(
        PotentialPiece(replace(potential, variables=states), start, end)
        for potential, own in spans.items()
        for start, end in _joined(own)
    )


def _joined(spans: Sequence[tuple[Point, Point]]) -> list[tuple[Point, Point]]:
    """Cones with a common ray made one (of at most a half turn), each direction once."""
    joined: list[tuple[Point, Point]] = []
    for start, end in spans:
        if any(same_direction(start, s) and same_direction(end, e) for s, e in joined):
            continue
        before = next((k for k, (_, e) in enumerate(joined) if same_direction(e, start)), None)
        if before is not None and sign(cross(joined[before][0], end)) >= 0:
            joined[before] = (joined[before][0], end)
        else:
            joined.append((start, end))
    return joined
