"""A V that falls along every solution and is negative at some points at every distance: the point is unstable.

A solution from such a point has ``V < V(start) < 0`` from then on, so it stays away from the equilibrium, where V is
zero; between there and the border of the cube V falls at a rate that is bounded from below, so it leaves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.facts import Fact, row_fact
from nonsmooth.proofs.kernel.cells import StatedCells
from nonsmooth.proofs.kernel.claims import Functions
from nonsmooth.proofs.many_states.examination import answer, conditions_on, find_failure
from nonsmooth.proofs.many_states.lyapunov_search import proposals
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.domain import cube_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem

DIRECTIONS = 600  # drawn at random, beside those of the most negative curvature
FINE = 1 << 10  # denominator of a direction


@dataclass(frozen=True)
class GrowthEvidence:
    """A function that shows instability.

    Attributes:
        formula: V, in the displacement under the states' names.
        radius: half the side of the cube on which V falls.
        direction: V is negative at all points near the equilibrium in this direction.
        stated: the cells of the cube.
        proofs: the evidence that V falls, by the names of claims.
    """

    formula: PiecewiseExpression
    radius: Number
    direction: tuple[fmpq, ...]
    stated: StatedCells
    proofs: dict[str, Any]

    def facts(self, states: Sequence[str]) -> tuple[Fact, ...]:
        """V, and where it falls."""
        direction = ", ".join(map(str, self.direction))
        where = f"{cube_text(self.radius, states)}; V < 0 in the direction ({direction})"
        return row_fact("with", f"V = {one_line(self.formula.text)}"), row_fact("on", where)

    @property
    def entry(self) -> dict[str, Any]:
        """As a certificate holds it."""
        direction = [str(x) for x in self.direction]
        cells, function = self.stated.record, self.formula.text
        hypotheses = {"cells": cells, "function": function, "second": None, "direction": direction}
        return {"theorem": "instability", "hypotheses": hypotheses, "proofs": {**self.stated.proofs, **self.proofs}}


def find_growth(system: SwitchedSystem) -> GrowthEvidence | None:
    """A V that shows instability; None where none is found.

    Raises:
        BeyondReachError: for a system that is not decided here.
    """
    for radius, formula in proposals(system, positive=False):
        stated, conditions = conditions_on(system, formula, radius)
        falls = conditions.claims(positive=False)
        direction = negative_direction(conditions)
        if direction is None or find_failure(stated.cells, falls) is not None:
            continue
        proofs = _proofs(falls)
        if proofs is not None:
            return GrowthEvidence(formula, radius, direction, stated, proofs)
    return None


def _proofs(claims: Sequence[Claim]) -> dict[str, Any] | None:
    """Evidence of all claims; None where that of one is not found."""
    proofs = {}
    for claim in claims:
        found = answer(claim, Effort.STRICT).found
        if found is None:
            return None
        proofs[claim.name] = found.evidence
    return proofs


def negative_direction(conditions: Functions) -> tuple[fmpq, ...] | None:
    """A direction in which V is negative near the point; None where none is found."""
    drawn = np.random.default_rng(0).normal(size=(DIRECTIONS, conditions.count))
    for candidate in (*_curved(conditions), *drawn):
        direction = _rounded(candidate)
        if any(direction) and conditions.is_negative_along([Fraction(int(x.p), int(x.q)) for x in direction]):
            return direction
    return None


def _curved(conditions: Functions) -> Iterator[NDArray[np.float64]]:
    """Directions in which the quadratic part of a piece is least."""
    for cell in conditions.inclusion.cells:
        vectors = np.linalg.eigh(_hessian(conditions.potential(cell)))[1]
        yield vectors[:, 0]
        yield -vectors[:, 0]


def _hessian(potential: Polynomial) -> NDArray[np.float64]:
    matrix = np.zeros((potential.count, potential.count))
    for exponents, value in potential.terms.items():
        if sum(exponents) == 2:
            i, j = (k for k, e in enumerate(exponents) for _ in range(e))
            matrix[i, j] += float(value)
            matrix[j, i] += float(value)
    return matrix


def _rounded(values: NDArray[np.float64]) -> tuple[fmpq, ...]:
    size = float(np.abs(values).max())
    return tuple(fmpq(round(float(x) / size * FINE), FINE) for x in values)
