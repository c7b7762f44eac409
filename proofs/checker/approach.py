"""Solutions that approach a set of equilibria, as nothing moves where V is kept (LaSalle's principle).

*Theorem.*  Let V be positive off the point and not rise, and let every rate ``-V'`` have a bound (:mod:`.invariance`)
that is zero only on flat places.  Let N be the span of the velocities of all fields at their places, and let no
direction but zero along any place be in N.  Then the point is stable, and every solution from near it approaches the
set of equilibria: its distance from this tends to zero.  *Proof.*  A solution from near the point stays near it, so it
tends to a compact set L that is weakly invariant, with V constant.  Let a solution stay in L.  At almost all times its
velocity is a mixture of fields whose rates are zero there, or of those beside a face on which V bends and its common
bound is zero: it is in N, and the solution is at their places.  There are finitely many places, so at almost all times
the solution is on one of these at other times that tend to this one: its velocity leads along that place.  So it is
zero, and the solution stays where it is: every point of L is an equilibrium.

A mass with dry friction, ``x' = v, v' = -x - sign(v)``, has ``V = x^2 + v^2`` with ``V' = -2 abs(v)``.  Where ``v = 0``
velocities are ``(0, a)``, which do not lead along this line.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .cells import Cell, Face, Inclusion, System
from .invariance import Chain
from .polynomials import Coefficient, constant, solve, variable
from .positivity import Proofs
from .theorems import STABLE, Statement
from .work import BUDGET, rational, require, take

Direction = tuple[Coefficient, ...]


class Approach(Chain):
    """The claims about a V that is kept on flat places, with no further functions.

    Attributes:
        places: where V may be kept.
        velocities: vectors that span those of all fields there.
    """

    def __init__(self, inclusion: Inclusion, proofs: Proofs, zeros: Any) -> None:
        super().__init__(inclusion, proofs, zeros)
        self.places: list[Face] = []
        self.velocities: dict[Direction, None] = {}

    def leave(self, name: str, place: Face, cells: Sequence[Cell]) -> None:
        """Note a place at which V may be kept, with the velocities there."""
        require(all(coordinate.degree <= 1 for coordinate in place.coordinates), "flat places where V is kept")
        self.places.append(place)
        for cell in cells:
            for _, field in cell.fields:
                parts = [place.restricted(component).terms for component in field]
                powers = {exponents: None for terms in parts for exponents in terms}
                self.velocities |= {tuple(terms.get(e, 0) for terms in parts): None for e in powers}

    def show_approach(self) -> None:
        """V does not rise, and nothing moves along the places where it may be kept."""
        self.show_chain()
        for place in self.places:
            require(not self.moves_along(place), "velocities that lead along no place where V is kept")

    def moves_along(self, place: Face) -> bool:
        """Whether a direction along a place, but zero, is a sum of multiples of the velocities."""
        size, count = place.dimension, place.dimension + len(self.velocities)
        BUDGET.spend((1 + count) * self.count**2)
        sums = []
        for k, form in enumerate(place.coordinates):
            total = constant(count, 0)
            for i in range(size):
                total += variable(count, i, form.slope(i))
            for j, velocity in enumerate(self.velocities):
                total += variable(count, size + j, -velocity[k])
            sums.append(total)
        solved = solve(sums, count)
        return solved is None or any(form.degree > 0 for form in solved[:size])


def show_approach(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """See the head of this file.

    With ``level``, every start of the cube with ``V < level`` approaches the set of equilibria.  With ``proper``
    every start does: all is shown in the whole space, and ``V + 1 >= proper |x|^2``, so that level sets are bounded.
    """
    cells, function, zeros, level, proper = take(hypotheses, "cells function zeros level proper")
    require(system.coordinates == system.states, "a system that is not seen by roots of its states")
    approach = Approach(Inclusion(system, cells, [function], proofs), proofs, zeros)
    approach.show_zero()
    approach.show_positive()
    approach.show_approach()
    conclusions: list[Statement] = [{"stability": STABLE}, {"approaches": "near"}]
    if proper is not None:
        approach.show_proper(rational(proper))
        conclusions.append({"approaches": "everywhere"})
    if level is not None:
        require(approach.bounded and rational(level) > 0, "a positive level on a cube")
        approach.show_border(rational(level))
        about = {"function": function, "within": cells["within"], "below": level}
        conclusions.append({"approaches": about})
    return conclusions
