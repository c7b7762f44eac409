"""The verdict of Theorem 4 for one array, with the evidence of every clause.

``holds`` iff the equilibrium holds, translation is (asymptotically) stable, rotation is unstable and, where
mu_S < mu_R, feedback stabilizes.  At an equilibrium a clause that is refuted makes it ``fails``; a missing certificate
alone is not a refutation, so it makes it ``undecided``, and so does a point that is not shown to be an equilibrium.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self, TypeAlias, cast

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs import clause_registry
from nonsmooth.proofs.clauses.authority import Authority
from nonsmooth.proofs.clauses.clause import Clause, JudgedEquilibrium
from nonsmooth.proofs.clauses.equilibrium.clause import EllipseEquilibrium, EquilibriumResult
from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
from nonsmooth.proofs.clauses.rotation.clause import RotationResult, rotation_bound
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.clauses.workspace import ClauseResult, Skipped, Workspace
from nonsmooth.proofs.findings.verdicts import Fact, Theorem4
from nonsmooth.symbolic.mechanics.contact_states import ContactCensus, take_census, triples_with_friction
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.notebook import ShortRepr, html_table

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback


@dataclass(frozen=True)
class Contradiction:
    """Two statements of this program about one array that cannot both be true.

    Attributes:
        between: what is compared, in a few words.
        sides: the two statements, a sentence each.
        clauses: names of the clauses that nobody may rely on.
    """

    between: str
    sides: tuple[str, str]
    clauses: tuple[str, ...]

    @property
    def text(self) -> str:
        """Both sides in one sentence."""
        return f"{self.between} contradict each other: {self.sides[0]}; but {self.sides[1]}"


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

    def contradicted(self, found: Sequence[Contradiction]) -> Self:
        """The same with every clause undecided that a contradiction concerns, and what follows from that."""
        if not found:
            return self
        results = dict(self.results)
        for clause, result in self.clauses:
            said = "; ".join(one.text for one in found if clause.name in one.clauses)
            results[clause.name] = clause.undecided(result, said) if said else result
        _, reason = clause_registry.conclude(results)
        return replace(self, results=results, verdict=Theorem4.UNDECIDED, reason=reason, contradictions=tuple(found))

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

        own = self.scene, self.scene.recentred()
        about = (getattr(result, "scene", self.scene) for result in self.results.values())
        if self.verdict is not clause_registry.conclude(self.results)[0] or any(scene not in own for scene in about):
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
