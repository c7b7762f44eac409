"""The registry of searches for theorems that show verdicts on plain systems, in the order of their trial.

A search looks for hypotheses of a theorem of :mod:`nonsmooth.proofs.checker.theorems` and for the evidence of its
claims.  A new one is a function with the signature of :data:`Show` and a line of :data:`THEOREM_SEARCHES`; its theorem
is a function of the checker and a line of ``THEOREMS`` there.  The V that decided a check is tried before all of these.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.cells import MAX_STATES, System, pattern
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE
from nonsmooth.proofs.choices import show_choice_of
from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.proofs.kernel.cells import BeyondReachError, StatedCells, sharpened, started, stated_cells
from nonsmooth.proofs.kernel.escapes import show_escape_of
from nonsmooth.proofs.kernel.fans import show_by_fan, show_by_weights
from nonsmooth.proofs.kernel.first_terms import show_departure_of, show_linearization_of
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search, instability_hypotheses, stability_hypotheses
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.many_states.lyapunov_search import LARGE, find_growing_product, find_growth
from nonsmooth.proofs.many_states.relay_degree import show_relay_of
from nonsmooth.proofs.many_states.weak_functions import find_kept_function, find_weak_growth
from nonsmooth.proofs.systems.findings import DecidedSystem
from nonsmooth.proofs.systems.scalar_stability import clear_distance, within
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
    growth = None
    if len(system.states) != len(PLANE):
        growth = find_growth(system) or find_growing_product(system) or find_growth(system, LARGE)
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


# ---- certificates of systems in one state --------------------------------------------------------
#
# A function V of the displacement, on the intervals between switchings.
#
# The point attracts with ``V = (x/a)^2`` left and ``(x/b)^2`` right of it, below the level 1 on ``(-a, b)``; it is
# stable with ``V = x^2``; a solution leaves it where V falls and is negative, or along one field that leads away.  The
# signs of the fields beside the point say which of these to write, and the checker shows it.  All is about the
# displacement from the point, or about that of the signed root where the state has one.


Theorem: TypeAlias = tuple[str, dict[str, Any]]  # its name, and its hypotheses


def scalar_theorem(result: DecidedSystem, system: System) -> Theorem:
    """The theorem that shows a verdict in one state, with its hypotheses.

    Args:
        result: of a check, not undecided.
        system: of the certificate.

    Raises:
        NoCertificateError: for a solution that leaves where right-hand sides only enclose the field.
        BeyondReachError: for too many surfaces or cells, and for numbers that are too large or too small.
    """
    (name,), scene = system.coordinates, result.scene
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
        return _attraction(result, system)
    radius = within(clear_distance(scene))
    stated = _cells(scene, system, radius)
    if result.verdict is Translation.STABLE:
        return "lyapunov", stability_hypotheses(stated.record, f"{name}**2", STABLE)
    if result.equilibrium is Equilibrium.FAILS:  # all velocities at the point have one sign
        upward = result.deciding.proofs.right.values[0].sign() > 0
        return "departure", {"cells": stated.record, "direction": ["1" if upward else "-1"]}
    return _leaving(result, name, stated, radius)


def _cells(scene: SwitchedSystem, system: System, radius: Fraction) -> StatedCells:
    """The cells of an interval about the point, which the point parts."""
    stated = stated_cells(scene, scene.field(radius), scene.coordinates(), irrational=True)
    return sharpened(stated, system, Search())


def _attraction(result: DecidedSystem, system: System) -> Theorem:
    """``V < 1`` exactly on the interval of starts that reach the point."""
    (name,) = system.coordinates
    sides = result.deciding.proofs
    right, left = (within(side.reach) for side in (sides.right, sides.left) if side.reach is not None)
    function = f"relu({name})**2/({right**2}) + relu(-{name})**2/({left**2})"
    if left == right:
        function = f"{name}**2/({right**2})"
    cells = _cells(result.scene, system, max(left, right)).record
    return "lyapunov", {**stability_hypotheses(cells, function, ASYMPTOTICALLY_STABLE), "level": "1", "below": True}


def _leaving(result: DecidedSystem, name: str, stated: StatedCells, radius: Fraction) -> Theorem:
    """Every solution that starts on one side leaves, or one solution does.

    Where all fields of each side have one sign, V is the distance on a side where they lead back, and minus it where
    they lead away: that holds for all that several right-hand sides may enclose.  Else one of them is followed.
    """
    cells, sides = stated.record, result.deciding.proofs
    left, right = sides.left.outward, sides.right.outward
    turn, outward = (1, right) if max(right) > 0 else (-1, left)
    if abs(sum(left)) == len(left) and abs(sum(right)) == len(right):
        function = f"-{name}" if sum(left) < sum(right) else name if sum(left) > sum(right) else f"-Abs({name})"
        return "instability", instability_hypotheses(cells, function, [turn])
    if result.scene.only_encloses:
        raise NoCertificateError("one solution of fields that are only enclosed says nothing of the stated one")
    signs = pattern(surface((turn * radius / 2,)).sign() for surface in stated.surfaces)
    field = [signs, outward.index(max(outward)), "1", [str(turn)]]
    start = {"within": str(radius), "surfaces": cells["surfaces"], "signs": signs, "direction": [str(turn)]}
    rising = name if turn > 0 else f"-{name}"
    return "escape", {**start, "along": [], "mixture": [field], "barriers": [], "function": rising}
