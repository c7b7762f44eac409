"""Evidence of a verdict by what acts near the point: the ways that search no V by polynomials, one after the other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, UNSTABLE, Statement
from nonsmooth.proofs.kernel.escapes import show_escape_of
from nonsmooth.proofs.kernel.fans import show_by_fan
from nonsmooth.proofs.kernel.first_terms import show_departure_of, show_linearization_of
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.sign_cells import BeyondReachError, IrrationalError
from nonsmooth.proofs.kernel.weighted_turns import show_by_weights
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem

Entry: TypeAlias = tuple[dict[str, Any], list[Statement]]


def show_near_point(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence of a verdict: no equilibrium, linearization, a solution that leaves, a piecewise linear V, V and W.

    Args:
        system: in any number of states.
        verdict: asymptotically stable, stable or unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows, the verdict among it.

    Raises:
        NotShownError: where none of them shows it, with the reason of each.
        IrrationalError: for numbers with roots.
    """
    ways: list[Callable[[], Entry]] = []
    if verdict == UNSTABLE:
        ways.append(lambda: show_departure_of(system, search))
    if verdict in (UNSTABLE, ASYMPTOTICALLY_STABLE):
        ways.append(lambda: show_linearization_of(system, verdict, search))
    if verdict == UNSTABLE:
        ways.append(lambda: show_escape_of(system, search))
    if len(system.states) == len(PLANE):
        ways.append(lambda: show_by_fan(system, verdict, search))
        ways.append(lambda: show_by_weights(system, verdict, search))
    reasons = []
    for show in ways:
        try:
            return show()
        except IrrationalError:
            raise
        except (NotShownError, BeyondReachError) as error:
            reasons.append(str(error))
    raise NotShownError("; ".join(reasons) or "no theorem was found that shows it")
