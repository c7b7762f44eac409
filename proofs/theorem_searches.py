"""The registry of searches for theorems that show verdicts on plain systems, in the order of their trial.

A search looks for hypotheses of a theorem of :mod:`nonsmooth.proofs.checker.theorems` and for the evidence of its
claims.  A new one is a function with the signature of :data:`Show` and a line of :data:`THEOREM_SEARCHES`; its theorem
is a function of the checker and a line of ``THEOREMS`` there.  The V that decided a check is tried before all of these.

Instability by a function that does not rise: with time reversed, it is a weak Lyapunov function of the system.  A relay
that gains energy, ``x' = y, y' = -sign(x) + a y``, has ``V = -(abs(x) + y^2/2)`` with ``V' = -a y^2``.  The function W
that shows that nothing stays where ``V' = 0`` is :mod:`nonsmooth.proofs.kernel.second_function`'s.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.cells import MAX_STATES, Inclusion
from nonsmooth.proofs.checker.lyapunov import Lyapunov
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE
from nonsmooth.proofs.kernel.cells import BeyondReachError, IrrationalError, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.escapes import show_escape_of
from nonsmooth.proofs.kernel.fans import show_by_fan, show_by_weights
from nonsmooth.proofs.kernel.first_terms import show_departure_of, show_linearization_of
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.proofs.many_states.lyapunov_search import find_growth
from nonsmooth.proofs.many_states.relay_degree import show_relay_of
from nonsmooth.proofs.systems.lyapunov_search import find_weak_lyapunov
from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem

DIRECTIONS = ((1, 1), (-1, 1), (2, 5), (7, -3), (-5, 11))  # one of them is inside a cell


def find_weak_growth(system: SwitchedSystem, search: Search | None = None) -> dict[str, Any] | None:
    """Hypotheses of the theorem ``instability`` by a V that does not rise and further functions.

    Args:
        system: in two states, with rational numbers.
        search: keeps the proofs that are found.

    Returns:
        The hypotheses; None where nothing was found.
    """
    proofs = Search() if search is None else search
    found = find_weak_lyapunov(reversed_system(system))
    if found is None or found.formula is None or found.domain.radius is None:
        return None
    function, subject = f"-({found.formula.text})", read_subject(about(system))
    cells = stated_cells(system, found.domain.radius, surfaces_of(system, found.formula)).record
    second = find_second(subject, cells, function, proofs)
    if second is None:
        return None
    stated = Lyapunov(Inclusion(subject, cells, [function], proofs), proofs)
    leading = (own for own in DIRECTIONS if stated.is_negative_along(list(map(Fraction, own))))
    direction = next(leading, None)
    if direction is None:
        return None
    return {"cells": cells, "function": function, "second": second, "direction": list(map(str, direction))}


def reversed_system(system: SwitchedSystem) -> SwitchedSystem:
    """The system with time reversed."""

    def negated(sides: Sequence[PiecewiseExpression]) -> tuple[PiecewiseExpression, ...]:
        return tuple(parse_piecewise(f"-({side.text})", system.states) for side in sides)

    return replace(system, rhs=negated(system.rhs), others=tuple(map(negated, system.others)))


Show: TypeAlias = Callable[[SwitchedSystem, str, Search | None], Entry]


@dataclass(frozen=True)
class TheoremSearch:
    """A way to a theorem.

    Attributes:
        name: of what shows the verdict.
        show: finds the entry of a certificate for a system, a verdict and a search with what was shown before; raises
            ``NotShownError`` where nothing is found, and ``BeyondReachError`` for systems that it does not look at.
        verdicts: those that it may show.
        most_states: of the systems that it is for.
    """

    name: str
    show: Show
    verdicts: tuple[str, ...]
    most_states: int = MAX_STATES


def show_growth_of(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence that the point is unstable by a function that falls, or does not rise, and is negative near it.

    Args:
        system: in two states or more.
        verdict: unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    subject, search = started(system, search)
    if len(system.states) == len(PLANE):
        hypotheses = find_weak_growth(system, search)
    else:
        growth = find_growth(system)
        hypotheses = None if growth is None else growth.entry["hypotheses"]
        search = search if growth is None else Search(known=growth.entry["proofs"])
    if hypotheses is None:
        raise NotShownError("no function was found that shows instability")
    return search.entry(subject, "instability", hypotheses)


THEOREM_SEARCHES = (
    TheoremSearch("no equilibrium", show_departure_of, (UNSTABLE,)),
    TheoremSearch("linearization", show_linearization_of, (UNSTABLE, ASYMPTOTICALLY_STABLE)),
    TheoremSearch("solution that leaves", show_escape_of, (UNSTABLE,)),
    TheoremSearch("piecewise linear V on a fan", show_by_fan, (UNSTABLE, STABLE, ASYMPTOTICALLY_STABLE), len(PLANE)),
    TheoremSearch("leading terms with weights", show_by_weights, (UNSTABLE, ASYMPTOTICALLY_STABLE), len(PLANE)),
    TheoremSearch("relative degree of a relay", show_relay_of, (UNSTABLE,)),
    TheoremSearch("function that shows instability", show_growth_of, (UNSTABLE,)),
)


def show_verdict(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence of a verdict by the first search that finds it.

    Args:
        system: in two states or more.
        verdict: asymptotically stable, stable or unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows, the verdict among it.

    Raises:
        NotShownError: where none finds it, with the reason of each.
        IrrationalError: for numbers with roots.
    """
    reasons = []
    for search_for in THEOREM_SEARCHES:
        if verdict not in search_for.verdicts or len(system.states) > search_for.most_states:
            continue
        try:
            return search_for.show(system, verdict, search)
        except IrrationalError:
            raise
        except (NotShownError, BeyondReachError) as error:
            reasons.append(str(error))
    raise NotShownError("; ".join(reasons) or "no theorem was found that shows it")
