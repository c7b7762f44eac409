"""Theorem 4, clause by clause, for one array: what is computed, and what is left out.

Which clauses there are: :data:`nonsmooth.proofs.clause_registry.CLAUSES`.  What they conclude together:
:mod:`nonsmooth.proofs.theorem4_result`.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TypeVar

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import CellRule, rule_of
from nonsmooth.analysis.cells.equilibria import RestPlace, find_equilibria
from nonsmooth.analysis.cells.partition import Partition, RefusalError, affordable
from nonsmooth.proofs import clause_registry
from nonsmooth.proofs.clauses.authority import roll_authority
from nonsmooth.proofs.clauses.clause import JudgedEquilibrium
from nonsmooth.proofs.clauses.rotation.clause import decide_rotation
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.clauses.workspace import Announce, Workspace, unheard
from nonsmooth.proofs.findings.verdicts import Rotation, Translation
from nonsmooth.proofs.theorem4_result import CellCheck, Check, SmoothCheck
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.contact_states import possible_triples, triples_with_friction
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Scene
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.rounded import ROUNDING_DECIDES
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

# ---- the verdicts at every isolated equilibrium of the square, each about its own point ----------
#
# The clauses are local: they look at the cells whose closure holds the point.  So each point is checked in a square of
# its own, small enough to stay inside the checked one.  Segments and areas of equilibria are reported
# without verdicts.


MOST = 16  # points that are judged: each costs a partition of its own
SHARE = 8  # the square about a point is this many times smaller than the checked one


def judge_equilibria(scene: Scene, found: tuple[RestPlace, ...]) -> tuple[JudgedEquilibrium, ...]:
    """Verdicts for the equilibria of a scene whose coordinates are those of the points.

    Points whose coordinates are unevaluated quotients, and those beyond :data:`MOST`, are left unjudged.
    """
    judged, budget = [], MOST
    for equilibrium in found:
        point = equilibrium.points[0]
        if len(equilibrium.points) > 1 or not budget or any(isinstance(x, Lazy) for x in point):
            judged.append(JudgedEquilibrium(equilibrium))
            continue
        budget -= 1
        judged.append(_judged(scene, equilibrium))
    return tuple(judged)


def _judged(scene: Scene, equilibrium: RestPlace) -> JudgedEquilibrium:
    own = replace(scene, check=CheckedSquare(equilibrium.points[0], scene.check.radius / SHARE))
    rule = rule_of(own)
    if isinstance(rule, CellRule):  # wheels that have no say there only take time
        own = replace(own, wheels=rule.wheels_that_matter(own))
    own = own.recentred()
    before = own.field.rounded_signs
    try:
        partition = build_partition(own)
    except RefusalError:  # the small square leaves the support polygon
        return JudgedEquilibrium(equilibrium)
    translation = decide_translation(partition)
    rotation = decide_rotation(partition, translation)
    if own.field.rounded_signs > before:
        return JudgedEquilibrium(equilibrium, Translation.UNDECIDED, Rotation.UNDECIDED)
    return JudgedEquilibrium(equilibrium, translation.verdict, rotation.verdict)


# ---- one array -----------------------------------------------------------------------------------


Kind = TypeVar("Kind", CellCheck, SmoothCheck)

CENSUS_LIMIT = 20_000  # row triples that are counted unasked: 25 wheels; a count decides no clause
FULL_CENSUS_LIMIT = 500_000  # row triples that are counted without pruning: 72 wheels, some ten seconds
CHECK_UNITS = 15_000_000  # of exact arithmetic in a whole check: a minute or so
SEARCH_UNITS = 4_000_000  # in the search for other equilibria, which no clause needs
WIDER = Fraction(65, 64)  # of the checked square: what is cut off there, so that its border lies inside


def check_theorem4(
    scene: Scene,
    *,
    prune: bool = True,
    beside: bool = True,
    announce: Announce = unheard,
    built: Partition | None = None,
) -> Check:
    """Check Theorem 4 for an array under the contact rule of its scene.

    Args:
        scene: the array; the point ``scene.check.equilibrium`` is checked in the square around it.
        prune: leave out what no verdict needs; without, everything is computed, with the same verdicts.
        beside: also search for other equilibria, count contact states and sample rates, on which no verdict rests.
        announce: hears the name of each step before it begins.
        built: all cells of the square, where they are known already.

    With a body the array is that of the wheels that carry it at the checked pose.

    Raises:
        RefusalError: where the motion is not determined (loads that do not exist, frictionless wheels), and where the
            exact arithmetic would take too long.
        SceneError: where a body has a wheel exactly under its edge; a :class:`TipsError` where it tips.
    """
    scene = standing(scene)
    with affordable(scene, CHECK_UNITS, "all clauses"):
        return _check(Workspace(scene, prune=prune, sample=beside, announce=announce, built=built), beside=beside)


def check_cells(scene: Scene) -> CellCheck:
    """Check under a rule with cells; see :func:`check_theorem4`.

    Raises:
        TypeError: for a rule without cells.
    """
    return _of_kind(CellCheck, check_theorem4(scene))


def check_smooth(scene: Scene) -> SmoothCheck:
    """Check under a rule without cells; see :func:`check_theorem4`.

    Raises:
        TypeError: for a rule with cells.
    """
    return _of_kind(SmoothCheck, check_theorem4(scene))


def _of_kind(kind: type[Kind], result: Check) -> Kind:
    if not isinstance(result, kind):
        raise TypeError(f"required a rule that gives a {kind.__name__}, received {result.scene.contact.rule}")
    return result


def _check(work: Workspace, *, beside: bool) -> Check:
    with work.timed("partition"):
        partition = work.partition
    with work.timed("contact states"):
        census_limit = _census_limit(work) if beside else 0
    with work.timed("other equilibria"):
        others = _equilibria(work) if beside else None
    results = clause_registry.decide_clauses(work)
    verdict, reason = clause_registry.conclude(results)
    common = (verdict, reason, work.given, results, census_limit, roll_authority(work.given))
    by_rounding = frozenset(work.by_rounding)
    if partition is None:
        return SmoothCheck(*common, tuple(work.skipped), work.seconds, by_rounding)
    return CellCheck(*common, tuple(work.skipped), work.seconds, by_rounding, partition, others)


def _equilibria(work: Workspace) -> tuple[JudgedEquilibrium, ...] | None:
    """All equilibria of the square, where its cells are known and the search is cheap."""
    if work.partition is None:
        return None
    if not work.partition.complete:
        work.skip("search for other equilibria", 1, "cells away from the point were not built")
        return None
    try:
        with work_limit(work.scene.field, SEARCH_UNITS):
            before = work.scene.field.rounded_signs
            found = find_equilibria(work.partition, _wider(work.partition))
            if work.scene.field.rounded_signs > before:
                work.skip("search for other equilibria", 1, ROUNDING_DECIDES)
                return None
            return judge_equilibria(work.scene, found)
    except WorkLimitError:
        why = f"it takes more than {SEARCH_UNITS // 1_000_000} million exact operations, and no clause needs it"
        work.skip("search for other equilibria", 1, why)
        return None


def _wider(partition: Partition) -> Partition | None:
    """The partition of a slightly larger square; None where the body tips beyond the checked one: there F ends."""
    check = partition.scene.check
    try:
        return build_partition(replace(partition.scene, check=replace(check, radius=check.radius * WIDER)))
    except RefusalError:
        return None


def _census_limit(work: Workspace) -> int:
    """How many row triples are counted, where that is asked for; what is not counted is said."""
    possible = triples_with_friction(work.scene)
    frictionless = possible_triples(len(work.scene.wheels)) - possible
    if frictionless:
        work.skip("contact states", frictionless, "they hold a row without friction, which constrains nothing")
    limit = CENSUS_LIMIT if work.prune else FULL_CENSUS_LIMIT
    if possible > limit:
        derived = 0 if work.partition is None else len(work.partition.states)
        why = f"no cell in the square; singular and distinct triples are counted up to {limit} triples"
        work.skip("contact states", possible - derived, why)
    return limit
