"""A V of a system in two states with its conditions, and as people and other programs read it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import LyapunovCell
from nonsmooth.proofs.inequalities.forms import directions
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, Refutation, Supremum
from nonsmooth.proofs.systems.domain import Domain
from nonsmooth.proofs.systems.findings import DERIVATIVES, ExaminedFunction, PotentialPiece
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import cross, same_direction
from nonsmooth.symbolic.numbers.polynomial import Polynomial


@dataclass(frozen=True)
class PlaneFunction(ExaminedFunction):
    """A V of a system in two states.

    Attributes:
        result: Lyapunov's conditions with their evidence.
        on: where they are looked at.
        formula: V as one formula; None where it is known by its pieces only.
        states: their names.
        grows: whether time was reversed.
        is_given: whether it is the scene's.
    """

    result: LyapunovResult
    on: Domain
    formula: PiecewiseExpression | None
    states: tuple[str, ...]
    grows: bool = False
    is_given: bool = False

    @property
    def domain(self) -> Domain:
        """The same."""
        return self.on

    @property
    def decrease(self) -> Decrease:
        """What follows from the conditions."""
        return self.result.verdict

    @property
    def reason(self) -> str:
        """The same as a sentence."""
        return self.result.reason

    @property
    def witness(self) -> Refutation | None:
        """Where one of them fails."""
        return self.result.witness

    @property
    def is_kept(self) -> bool:
        """Whether V, one polynomial near the point, has V' = 0 there: on all cells whose closure holds it."""
        zero = self.result.cells[0].potential.field.zero
        near = [cell for cell in self.result.cells if cell.region.contains((zero, zero))]
        return len({cell.potential for cell in near}) == 1 and not any(rate for cell in near for rate in cell.rates)

    @property
    def pieces(self) -> tuple[PotentialPiece, ...]:
        """V cone by cone, of one that was searched so."""
        return potential_pieces(self.result.cells, self.states) if self.formula is None else ()

    @property
    def suprema(self) -> dict[str, Supremum]:
        """The largest values of the derivatives; none where other evidence shows the conditions."""
        return {name: self.result.supremum(name) for name in DERIVATIVES} if self.result.strata else {}


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
