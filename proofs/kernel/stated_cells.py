"""The cells of a plain system and of functions, as certificates state them: surfaces, and patterns that are empty."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from nonsmooth.proofs.checker.cells import pattern
from nonsmooth.proofs.kernel.sign_cells import Pattern, SignCells, build_cells, least_mixture
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True)
class StatedCells:
    """What a theorem is told of the cells.

    Attributes:
        within: half the side of the cube; None for the whole space.
        surfaces: of the system, and further ones, each once up to a factor.
        empty: patterns of signs that no point inside the cube has, as texts, with the evidence.
        cells: of the cube, or of a cube in the whole space.
    """

    within: str | None
    surfaces: tuple[Polynomial, ...]
    empty: dict[str, dict[str, Any]]
    cells: SignCells

    @property
    def record(self) -> dict[str, Any]:
        """As a certificate holds it."""
        return {"within": self.within, "surfaces": list(map(str, self.surfaces)), "empty": list(self.empty)}

    @property
    def proofs(self) -> dict[str, Any]:
        """The evidence that patterns are empty, by the names of the claims."""
        return {f"empty {signs}": evidence for signs, evidence in self.empty.items()}

    def signs(self, sides: Iterable[tuple[Polynomial, int]]) -> str:
        """A text of signs in which some polynomials, multiples of surfaces, have given signs."""
        found: list[int | None] = [None] * len(self.surfaces)
        for polynomial, sign in sides:
            own = scaled(polynomial)
            k = next(k for k, surface in enumerate(self.surfaces) if scaled(surface) == own)
            found[k] = sign * _leading(polynomial).sign() * _leading(self.surfaces[k]).sign()
        return pattern(found)


def stated_cells(system: SwitchedSystem, radius: Number | None, more: Iterable[Polynomial] = ()) -> StatedCells:
    """The cells of a system.

    Args:
        system: in any number of states.
        radius: half the side of the cube; None for the whole space, where all surfaces pass the point.
        more: further surfaces, of functions; what is a multiple of another one is left out.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    half = system.field(1) if radius is None else radius
    known = {scaled(surface) for surface in build_cells(system, half).surfaces}
    new = {scaled(surface): surface for surface in more}
    cells = build_cells(system, half, [surface for own, surface in new.items() if own not in known])
    within = None if radius is None else str(radius)
    return StatedCells(within, cells.surfaces, dict(_empty_patterns(cells)), cells)


def scaled(polynomial: Polynomial) -> Polynomial:
    """The multiple whose leading coefficient is one."""
    return polynomial * _leading(polynomial).inverse()


def _leading(polynomial: Polynomial) -> Number:
    return polynomial.terms[max(polynomial.terms)]


def _empty_patterns(cells: SignCells) -> Iterator[tuple[str, dict[str, Any]]]:
    """Patterns, walked as the checker walks them: of those that have no cell the shortest beginnings, and why."""
    occurring = {cell.signs[:size] for cell in cells.cells for size in range(len(cells.surfaces) + 1)}
    known: list[dict[int, int]] = []
    for beginning in sorted(occurring, key=len):
        for sign in (-1, 1):
            longer = (*beginning, sign)
            if len(longer) <= len(cells.surfaces) and longer not in occurring and not _is_known(longer, known):
                weights = _contradiction(cells, longer)
                known.append({j: longer[j] for j in weights})
                last = max(weights)
                mixture = {f"s{j}": str(weight / weights[last]) for j, weight in weights.items() if j != last}
                yield pattern(known[-1].get(j) for j in range(len(cells.surfaces))), {"mixture": [mixture]}


def _is_known(signs: Pattern, known: Sequence[dict[int, int]]) -> bool:
    """Whether signs that were found to contradict each other occur in the pattern."""
    return any(all(j < len(signs) and signs[j] == s for j, s in own.items()) for own in known)


def _contradiction(cells: SignCells, signs: Pattern) -> dict[int, Number]:
    """Weights with which some affine surfaces with their signs have no positive value in the cube."""
    affine = [j for j in range(len(signs)) if cells.surfaces[j].degree == 1]
    forms = [cells.surfaces[j] * signs[j] for j in affine]
    found = least_mixture(forms, forms[0].field(cells.radius))
    weights = {} if found is None else found.weights
    return {j: weights[i] for i, j in enumerate(affine) if weights.get(i)}
