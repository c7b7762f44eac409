"""Theorem 4, clause by clause, for one array: what a check holds, what is computed, and what is left out.

Which clauses there are: :data:`nonsmooth.proofs.clause_registry.CLAUSES`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self, TypeAlias, TypeVar, cast

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import CellRule, rule_of
from nonsmooth.analysis.cells.partition import Partition, RefusalError, affordable
from nonsmooth.analysis.cells.polygon import strips_about
from nonsmooth.proofs import clause_registry
from nonsmooth.proofs.clauses.authority import Authority, roll_authority
from nonsmooth.proofs.clauses.clause import Clause, JudgedEquilibrium
from nonsmooth.proofs.clauses.equilibrium.clause import EllipseEquilibrium, EquilibriumResult
from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
from nonsmooth.proofs.clauses.rotation.clause import RotationResult, decide_rotation, rotation_bound
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult, decide_translation
from nonsmooth.proofs.clauses.workspace import Announce, ClauseResult, Skipped, Workspace, unheard
from nonsmooth.proofs.findings import Contradiction, Fact, Rotation, Theorem4, Translation
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.contact_states import (
    ContactCensus,
    possible_triples,
    take_census,
    triples_with_friction,
)
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Scene
from nonsmooth.symbolic.messages.notebook import ShortRepr, html_table
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.rounded import ROUNDING_DECIDES
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.equilibria import RestPlace
    from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback

# ---- the verdict with the evidence of every clause -----------------------------------------------
#
# ``holds`` iff the equilibrium holds, translation is (asymptotically) stable, rotation is unstable and, where mu_S <
# mu_R, feedback stabilizes.  At an equilibrium a clause that is refuted makes it ``fails``; a missing certificate alone
# is not a refutation, so it makes it ``undecided``, and so does a point that is not shown to be an equilibrium.


@dataclass(frozen=True, repr=False)
class Theorem4Result(ShortRepr):
    """What every check reports, whatever the contact rule.

    Attributes:
        verdict: the theorem's verdict for the array.
        reason: the clause that decided it.
        scene: the array as it was given.
        results: the clauses' results by name, in the order of the registry.
        census_limit: how many row triples are counted at most.
        authority: rank of the roll rows at the checked point.
        skipped: what was left out and why.
        seconds: where the time went.
        by_rounding: names of the clauses that claim nothing because rounding would decide them.
        contradictions: statements about the array that contradict each other; the clauses concerned are undecided.
    """

    verdict: Theorem4
    reason: str
    scene: Scene
    results: Mapping[str, ClauseResult]
    census_limit: int
    authority: Authority
    skipped: tuple[Skipped, ...]
    seconds: dict[str, float]
    by_rounding: frozenset[str]
    contradictions: tuple[Contradiction, ...] = field(default=(), kw_only=True)

    @cached_property
    def census(self) -> ContactCensus:
        """Counts of row triples, which no clause needs; of too many only the possible ones."""
        possible = triples_with_friction(self.scene)
        return take_census(self.scene) if possible <= self.census_limit else ContactCensus(possible)

    @property
    def clauses(self) -> tuple[tuple[Clause[Any], ClauseResult], ...]:
        """Every clause with its result, in order."""
        return tuple((clause, self.results[clause.name]) for clause in clause_registry.CLAUSES)

    def contradicted(self, contradictions: Sequence[Contradiction]) -> Self:
        """The same with every clause undecided that a contradiction concerns, and what follows from that."""
        if not contradictions:
            return self
        results = dict(self.results)
        for clause, result in self.clauses:
            said = "; ".join(one.text for one in contradictions if clause.name in one.clauses)
            results[clause.name] = clause.undecided(result, said) if said else result
        _, reason = clause_registry.conclude(results)
        return replace(
            self, results=results, verdict=Theorem4.UNDECIDED, reason=reason, contradictions=tuple(contradictions)
        )

    def facts(self, clause: Clause[Any]) -> Iterator[Fact]:
        """What one clause says beside verdict and reason."""
        return clause.facts(self.results[clause.name], self)

    @property
    def rotation(self) -> RotationResult:
        """Clause 3."""
        return cast("RotationResult", self.results["rotation"])

    @property
    def partition(self) -> Partition | None:
        """The cells, about the checked point; None under a rule without cells."""
        return None

    @property
    def minimizing_states(self) -> int | None:
        """How many contact states own a cell of the square; None where not all cells were built, or there are none."""
        return None

    @property
    def equilibria(self) -> tuple[JudgedEquilibrium, ...] | None:
        """All equilibria of the square; None where they were not searched for."""
        return None

    @property
    def other_equilibria(self) -> tuple[JudgedEquilibrium, ...] | None:
        """Equilibria of the square beside the checked point; None where they were not searched for."""
        if self.equilibria is None:
            return None
        return tuple(e for e in self.equilibria if len(e.found.points) > 1 or any(e.found.points[0]))

    @property
    def theta_is_weakly_stable(self) -> bool | None:
        """Whether some solution keeps theta near its start; None where that is not decided.

        The verdicts themselves are strong: they speak of every solution.
        """
        return None

    def check(self) -> bool:
        """Whether all clauses are about this scene, and the stand-alone checker accepts a certificate of what they say.

        Where there is none (a rule without cells, loads that are not known, nothing decided), or it leaves out some of
        it, all clauses are decided once more: that refuses what was changed since, and repeats an error.
        """
        from nonsmooth.proofs.certificate import build_certificate, stated_words
        from nonsmooth.proofs.kernel.subject import NoCertificateError
        from nonsmooth.proofs.verified import UnverifiedError

        scenes = self.scene, self.scene.recentred()
        about = (getattr(result, "scene", self.scene) for result in self.results.values())
        if self.verdict is not clause_registry.conclude(self.results)[0] or any(scene not in scenes for scene in about):
            return False
        try:
            stated = stated_words(build_certificate(self))
        except NoCertificateError:
            stated = {}
        except UnverifiedError:
            return False
        said = {name: str(result.verdict) for name, result in self.results.items() if result.verdict != "undecided"}
        if said and all(stated.get(name) == word for name, word in said.items()):
            return True
        work = Workspace(self.scene, sample=False)
        _ = work.partition  # before the clauses, as at first: what rounding decides of it counts for all of them
        return clause_registry.decide_clauses(work) == self.results

    def _repr_html_(self) -> str:
        """The verdicts with their reasons, for a notebook."""
        rows = [(clause.name, str(result.verdict), result.reason) for clause, result in self.clauses]
        head = f"{self.scene.name}, rule {self.scene.contact.rule}"
        return html_table(head, ("clause", "verdict", "reason"), [*rows, ("Theorem 4", self.verdict, self.reason)])


@dataclass(frozen=True, repr=False)
class CellCheck(Theorem4Result):
    """Check under a rule with cells.

    Attributes:
        cells: the partition, about the checked point.
        others: all equilibria of the square, about the checked point, with their own verdicts; None where they
            were not searched for.
    """

    cells: Partition
    others: tuple[JudgedEquilibrium, ...] | None

    @property
    def partition(self) -> Partition:
        """The cells, about the checked point."""
        return self.cells

    @property
    def equilibrium(self) -> EquilibriumResult:
        """Clause 1."""
        return cast("EquilibriumResult", self.results["equilibrium"])

    @property
    def translation(self) -> TranslationResult:
        """Clause 2."""
        return cast("TranslationResult", self.results["translation"])

    @property
    def feedback(self) -> AnyFeedback:
        """Clause 4."""
        return cast("AnyFeedback", self.results["feedback"])

    @property
    def minimizing_states(self) -> int | None:
        """How many contact states own a cell of the square; None where not all cells were built."""
        return len(self.partition.states) if self.partition.complete else None

    @property
    def equilibria(self) -> tuple[JudgedEquilibrium, ...] | None:
        """All equilibria of the square; None where they were not searched for."""
        return self.others

    @property
    def theta_is_weakly_stable(self) -> bool:
        """Whether some solution keeps theta near its start.

        The body arrives after a bounded rotation and may rest without turning, since the drift holds zero.
        """
        drift = self.rotation.drift
        arrives = self.partition.complete and rotation_bound(self.partition, self.translation) is not None
        return drift is not None and arrives and drift.interval[0] <= 0 <= drift.interval[1]


@dataclass(frozen=True, repr=False)
class SmoothCheck(Theorem4Result):
    """Check under a rule whose field is continuous and has no cells."""

    @property
    def equilibrium(self) -> EllipseEquilibrium:
        """Clause 1."""
        return cast("EllipseEquilibrium", self.results["equilibrium"])

    @property
    def translation(self) -> EllipseTranslation:
        """Clause 2, by exact linearization."""
        return cast("EllipseTranslation", self.results["translation"])

    @property
    def feedback(self) -> DrivenFeedback:
        """Clause 4."""
        return cast("DrivenFeedback", self.results["feedback"])


Check: TypeAlias = CellCheck | SmoothCheck


# ---- the verdicts at every isolated equilibrium of the square, each about its own point ----------
#
# The clauses are local: they look at the cells whose closure holds the point.  So each point is checked in a square of
# its own, small enough to stay inside the checked one.  Segments and areas of equilibria are reported
# without verdicts.


MOST = 16  # points that are judged: each costs a partition of its own
SHARE = 8  # the square about a point is this many times smaller than the checked one


def judge_equilibria(scene: Scene, places: tuple[RestPlace, ...]) -> tuple[JudgedEquilibrium, ...]:
    """Verdicts for the equilibria of a scene whose coordinates are those of the points.

    Points whose coordinates are unevaluated quotients, and those beyond :data:`MOST`, are left unjudged.
    """
    judged, budget = [], MOST
    for equilibrium in places:
        point = equilibrium.points[0]
        if len(equilibrium.points) > 1 or not budget or any(isinstance(x, Lazy) for x in point):
            judged.append(JudgedEquilibrium(equilibrium))
            continue
        budget -= 1
        judged.append(_judged(scene, equilibrium))
    return tuple(judged)


def _judged(scene: Scene, equilibrium: RestPlace) -> JudgedEquilibrium:
    small = replace(scene, check=CheckedSquare(equilibrium.points[0], scene.check.radius / SHARE))
    rule = rule_of(small)
    if isinstance(rule, CellRule):  # wheels that have no say there only take time
        small = replace(small, wheels=rule.wheels_that_matter(small))
    small = small.recentred()
    before = small.field.rounded_signs
    try:
        partition = build_partition(small)
    except RefusalError:  # the small square leaves the support polygon
        return JudgedEquilibrium(equilibrium)
    translation = decide_translation(partition)
    rotation = decide_rotation(partition, translation)
    if small.field.rounded_signs > before:
        return JudgedEquilibrium(equilibrium, Translation.UNDECIDED, Rotation.UNDECIDED)
    return JudgedEquilibrium(equilibrium, translation.verdict, rotation.verdict)


# ---- one array -----------------------------------------------------------------------------------


Kind = TypeVar("Kind", CellCheck, SmoothCheck)

CENSUS_LIMIT = 20_000  # row triples that are counted unasked: 25 wheels; a count decides no clause
FULL_CENSUS_LIMIT = 500_000  # row triples that are counted without pruning: 72 wheels, some ten seconds
CHECK_UNITS = 15_000_000  # of exact arithmetic in a whole check: a minute or so
SEARCH_UNITS = 4_000_000  # in the search for other equilibria, which no clause needs
WIDTH = Fraction(1, 64)  # of the half-width of the checked square: so far strips reach to both sides of its border


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
        built: all cells of the square, where they are known already, or those of a scene that may have the same ones.

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
    from nonsmooth.analysis.cells.equilibria import find_equilibria

    try:
        with work_limit(work.scene.field, SEARCH_UNITS):
            before = work.scene.field.rounded_signs
            equilibria = find_equilibria(work.partition, _about_border(work.partition))
            if work.scene.field.rounded_signs > before:
                work.skip("search for other equilibria", 1, ROUNDING_DECIDES)
                return None
            return judge_equilibria(work.scene, equilibria)
    except WorkLimitError:
        why = f"it takes more than {SEARCH_UNITS // 1_000_000} million exact operations, and no clause needs it"
        work.skip("search for other equilibria", 1, why)
        return None


def _about_border(partition: Partition) -> list[Partition] | None:
    """Partitions of narrow strips about the sides of the square; None where the body tips beyond it: there F ends."""
    width = partition.scene.check.radius * WIDTH
    try:
        return [build_partition(partition.scene, domain=strip) for strip in strips_about(partition.domain, width)]
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
