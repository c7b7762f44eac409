"""The registry of searches for theorems that show verdicts on plain systems, in the order of their trial.

A search looks for hypotheses of a theorem of :mod:`nonsmooth.proofs.checker.theorems` and for the evidence of its
claims.  A new one is a function with the signature of :data:`Show` and a line of :data:`THEOREM_SEARCHES`; its theorem
is a function of the checker and a line of ``THEOREMS`` there.  The V that decided a check is tried before all of these.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from nonsmooth.proofs.checker.cells import MAX_STATES
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE
from nonsmooth.proofs.choices import show_choice_of
from nonsmooth.proofs.kernel.cells import BeyondReachError, started
from nonsmooth.proofs.kernel.escapes import show_escape_of
from nonsmooth.proofs.kernel.fans import show_by_fan, show_by_weights
from nonsmooth.proofs.kernel.first_terms import show_departure_of, show_linearization_of
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search, stability_hypotheses
from nonsmooth.proofs.many_states.first_integrals import find_kept_function
from nonsmooth.proofs.many_states.lyapunov_search import find_growth
from nonsmooth.proofs.many_states.relay_degree import show_relay_of
from nonsmooth.proofs.many_states.weak_functions import find_weak_growth
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

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
    growth = find_growth(system) if len(system.states) != len(PLANE) else None
    if growth is not None:
        return Search(known=growth.entry["proofs"]).entry(subject, "instability", growth.entry["hypotheses"])
    found = find_weak_growth(system)
    if found is None:
        raise NotShownError("no function was found that shows instability")
    return found[0]


def show_energy_of(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence that the point is stable by a V that solutions keep, of systems such as linear ones with turning pairs.

    Args:
        system: in two states or more.
        verdict: stable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    subject, search = started(system, search)
    found = find_kept_function(system)
    if found is None:
        raise NotShownError("no polynomial was found that is positive and kept")
    return search.entry(subject, "lyapunov", stability_hypotheses(found.stated.record, found.formula.text, STABLE))


THEOREM_SEARCHES = (
    TheoremSearch("no equilibrium", show_departure_of, (UNSTABLE,)),
    TheoremSearch("linearization", show_linearization_of, (UNSTABLE, ASYMPTOTICALLY_STABLE)),
    TheoremSearch("solution that leaves", show_escape_of, (UNSTABLE,)),
    TheoremSearch("piecewise linear V on a fan", show_by_fan, (UNSTABLE, STABLE, ASYMPTOTICALLY_STABLE), len(PLANE)),
    TheoremSearch("leading terms with weights", show_by_weights, (UNSTABLE, ASYMPTOTICALLY_STABLE), len(PLANE)),
    TheoremSearch("relative degree of a relay", show_relay_of, (UNSTABLE,)),
    TheoremSearch("function that shows instability", show_growth_of, (UNSTABLE,)),
    TheoremSearch("polynomial that is kept", show_energy_of, (STABLE,)),
    TheoremSearch("choice among right-hand sides", show_choice_of, (UNSTABLE,)),
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
    """
    reasons = []
    for search_for in THEOREM_SEARCHES:
        if verdict not in search_for.verdicts or len(system.states) > search_for.most_states:
            continue
        try:
            return search_for.show(system, verdict, search)
        except (NotShownError, BeyondReachError) as error:
            reasons.append(str(error))
    raise NotShownError("; ".join(reasons) or "no theorem was found that shows it")
