"""Instability under arbitrary switching, by a switching law: one field of the inclusion on each cell.

A *choice* is the number of a right-hand side; or a choice above and another one below a surface; or a mixture of two
choices.  It makes one right-hand side g of all of them, whose field on each cell is a mixture, with numbers, of the
fields there.

*Theorem.*  If the point is unstable for ``x' = g(x)``, it is unstable for the system.  *Proof.*  Where x lies in the
closure of a cell, F(x) holds the fields of all right-hand sides there, and their mixtures.  So the hull of the values
of g beside x is part of F(x), and every solution in the sense of Filippov of ``x' = g(x)`` is one of ``x' in F(x)``.
One that leaves is enough.  (That no velocity of g is zero at the point says nothing of F.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from .cells import System, require_formulas
from .escape import show_escape
from .formulas import parsed
from .positivity import Proofs
from .theorems import UNSTABLE, Statement, show_departure, show_instability
from .work import rational, require, take, whole

BY_ONE: dict[str, Callable[[System, Any, Proofs], list[Statement]]] = {
    "instability": show_instability,
    "departure": show_departure,
    "escape": show_escape,
}
MAX_NESTED = 4  # choices in choices


def show_choice(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The point is unstable, because it is for a choice among the right-hand sides.

    Hypotheses: ``choice``, ``theorem``, and ``hypotheses``: those of that theorem about the chosen right-hand side.
    """
    choice, theorem, theorem_hypotheses = take(hypotheses, "choice theorem hypotheses")
    require(not any(map(any, system.waves)), "fields that are exact: no sines and cosines")
    require_formulas(system)
    require(type(theorem) is str and theorem in BY_ONE, f"a theorem of {', '.join(BY_ONE)}")
    BY_ONE[theorem](chosen_system(system, choice), theorem_hypotheses, proofs)  # each shows that the point is unstable
    return [{"stability": UNSTABLE}]


def chosen_system(system: System, choice: Any) -> System:
    """The system with the one right-hand side of a choice."""
    return replace(system, rhs=(chosen(choice, system.rhs, MAX_NESTED),))


def chosen(choice: Any, sides: Sequence[tuple[str, ...]], depth: int) -> tuple[str, ...]:
    """The formulas of a choice: ``(1 + s)/2 f + (1 - s)/2 h``, s the sign of a surface, or a number from -1 to 1."""
    require(depth > 0, f"at most {MAX_NESTED} nested choices")
    if type(choice) is int:
        return sides[whole(choice, len(sides) - 1)]
    surface, first, second = take(choice, "surface first second")
    if type(surface) is list:
        weight = rational(surface[0])
        require(len(surface) == 1 and abs(weight) <= 1, "a number from -1 to 1")
        sign = f"({weight})"
    else:
        parsed(surface)  # a formula by itself: what follows it in the brackets remains outside of it
        sign = f"sign({surface})"
    pairs = zip(chosen(first, sides, depth - 1), chosen(second, sides, depth - 1), strict=True)
    return tuple(a if a == b else f"(1 + {sign})/2*({a}) + (1 - {sign})/2*({b})" for a, b in pairs)
