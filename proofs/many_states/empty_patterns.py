"""Why some patterns of signs of switching surfaces do not occur in a cube, as certificates write it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from nonsmooth.proofs.many_states.sign_cells import Pattern, SignCells, least_mixture
from nonsmooth.proofs.systems.system_certificate import exact_text


def empty_patterns(cells: SignCells) -> Iterator[list[list[Any]]]:
    """Mixtures of affine surfaces with signs that no point has: nowhere positive in the cube.

    Patterns are walked as the checker walks them; of those that have no cell, the shortest beginning is looked at.

    Args:
        cells: those that were not proved to be empty.
    """
    occurring = {cell.signs[:size] for cell in cells.cells for size in range(len(cells.surfaces) + 1)}
    known: list[list[list[Any]]] = []
    for beginning in sorted(occurring, key=len):
        for sign in (-1, 1):
            longer = (*beginning, sign)
            if len(longer) <= len(cells.surfaces) and longer not in occurring and not _is_known(longer, known):
                known.append(_mixture(cells, longer))
    yield from known


def _is_known(signs: Pattern, known: list[list[list[Any]]]) -> bool:
    """Whether a mixture that was found speaks of the pattern."""
    return any(all(j < len(signs) and signs[j] == (1 if s == "+" else -1) for j, s, _ in own) for own in known)


def _mixture(cells: SignCells, signs: Pattern) -> list[list[Any]]:
    """Surfaces, signs and weights of one mixture."""
    affine = [j for j in range(len(signs)) if cells.surfaces[j].degree == 1]
    forms = [cells.surfaces[j] * signs[j] for j in affine]
    found = least_mixture(forms, forms[0].field(cells.radius))
    weights = {} if found is None else found.weights
    return [[j, "+" if signs[j] > 0 else "-", exact_text(weights[i])] for i, j in enumerate(affine) if weights.get(i)]
