"""The result of a check as a script or a notebook holds it: the answers first, the evidence behind them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.answers.answers import Answers, exit_status, full_answers
from nonsmooth.proofs.answers.contradictions import contradictions_of_rules, reconciled, rests_under
from nonsmooth.proofs.clauses.workspace import Announce, unheard
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import Check, Contradiction
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.records import check_record
from nonsmooth.reports.result import Tabular
from nonsmooth.reports.short_text import short_lines
from nonsmooth.symbolic.contact_set import ContactSet, contact_set, standing
from nonsmooth.symbolic.notebook import html_table
from nonsmooth.symbolic.number_text import short_text

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.proofs.answers.answer import Answer
    from nonsmooth.proofs.answers.best_point import RestPoint
    from nonsmooth.proofs.answers.destinations import Destinations
    from nonsmooth.proofs.answers.headings import HeadingsOfRest
    from nonsmooth.reports.interface.law_result import LawResult
    from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True, repr=False)
class CheckResult(Tabular):
    """What a check of an array found.

    What it says has been compared (:mod:`nonsmooth.proofs.answers.contradictions`): what contradicts something else is
    undecided.

    Attributes:
        decided: every clause as it was decided.
        ask_others: whether the answers say what the other contact rules say.
        around: whether headings of rest are looked for around the checked point too.
        rest_points: with ``at="auto"`` the places of rest among which the point was chosen, the best first.
        elsewhere: contradictions with what is said in other results.
    """

    decided: Check
    ask_others: bool = True
    around: bool = False
    rest_points: tuple[RestPoint, ...] | None = None
    elsewhere: tuple[Contradiction, ...] = ()

    @cached_property
    def _brief(self) -> tuple[Check, Answers]:
        """The answers to the questions alone, compared with a few samples."""
        return reconciled(self.decided, None, *self.elsewhere)

    @cached_property
    def _full(self) -> tuple[Check, Answers]:
        """Everything, compared with each other."""
        asked = {"ask_others": self.ask_others, "around": self.around}
        answered = full_answers(self.decided, **asked, rest_points=self.rest_points)
        return reconciled(self.decided, answered, *self.elsewhere)

    @property
    def _said(self) -> tuple[Check, Answers]:
        """Everything, once somebody has asked for what takes longer."""
        return self._full if "_full" in vars(self) else self._brief

    @property
    def evidence(self) -> Check:
        """Every clause with its evidence; ``evidence.check()`` verifies it again."""
        return self._said[0]

    @property
    def contradictions(self) -> tuple[Contradiction, ...]:
        """Statements about the array that contradict each other, and on which nobody may rely."""
        return self.evidence.contradictions

    @property
    def _answers(self) -> dict[str, Answer]:
        return {answer.name: answer for answer in self._said[1].answers}

    @property
    def position(self) -> Answer:
        """Where a body goes that starts near the point."""
        return self._answers["position"]

    @property
    def heading(self) -> Answer:
        """What its heading does."""
        return self._answers["heading"]

    @property
    def pose(self) -> Answer:
        """Whether feedback can hold both."""
        return self._answers["pose"]

    @property
    def tolerances(self) -> Answer | None:
        """What holds for every array within the tolerances; None for a scene that states none."""
        return self.answers.robust

    @property
    def theorem4(self) -> str:
        """The verdict of Theorem 4: holds, fails, hypotheses not met or undecided."""
        return str(self.evidence.verdict)

    @property
    def at(self) -> tuple[float, float]:
        """The point that was checked."""
        x, y = self.evidence.scene.check.equilibrium
        return float(x), float(y)

    @property
    def contact_set(self) -> ContactSet:
        """The wheels that carry the body at the checked pose, and how far it may move before that changes."""
        return contact_set(self.evidence.scene)

    @property
    def answers(self) -> Answers:
        """The answers with what takes a little longer: where bodies go, and what the other rules say."""
        return self._full[1]

    @property
    def destinations(self) -> Destinations | None:
        """Where bodies go that start all over the square; None where all come home."""
        return self.answers.destinations

    @property
    def equilibrium_headings(self) -> HeadingsOfRest | None:
        """At which headings a body with an outline rests, and which of them attract; None where none matters."""
        return self.answers.headings

    def law(self) -> LawResult:
        """The certified feedback law as a table of regions and speeds, or a program.

        Raises:
            NoLawError: where the feedback clause certifies none.
        """
        from nonsmooth.reports.interface.law_result import certified_law_of

        return certified_law_of(self.evidence)

    def exit_status(self, required: Sequence[str]) -> int:
        """What ``nonsmooth check --require`` returns: 0 if all of these are as hoped for, 1 if one is not, else 3.

        Args:
            required: of position, heading, pose, tolerances and theorem4.
        """
        check, answered = self._full
        return exit_status(check, required, answered)

    def to_dict(self) -> dict[str, Any]:
        """The JSON record of ``nonsmooth check --json``."""
        return check_record(*self._full)

    def rows(self) -> list[dict[str, str]]:
        """One row for each answer and clause: question, verdict, why."""
        answered = [
            {"question": answer.name, "verdict": str(answer.verdict), "why": answer.sentence}
            for answer in self._answers.values()
        ]
        clauses = [
            {"question": clause.name, "verdict": str(found.verdict), "why": found.reason}
            for clause, found in self.evidence.clauses
        ]
        theorem = {"question": "Theorem 4", "verdict": self.theorem4, "why": self.evidence.reason}
        contradicted = [
            {"question": "contradiction", "verdict": "undecided", "why": one.text} for one in self.contradictions
        ]
        return [*answered, *clauses, theorem, *contradicted]

    def __repr__(self) -> str:
        said = [(answer.name, repr(answer)) for answer in self._answers.values()]
        theorem = ("Theorem 4", f"{self.theorem4}: {self.evidence.reason}")
        contradicted = [("contradiction", one.text) for one in self.contradictions]
        return short_lines(self._head(), [*said, theorem, *contradicted])

    def _repr_html_(self) -> str:
        rows = [(row["question"], row["verdict"], row["why"]) for row in self.rows()]
        return html_table(self._head(), ("question", "verdict", "why"), rows)

    def _head(self) -> str:
        scene = self.evidence.scene
        x, y = (short_text(value) for value in scene.check.equilibrium)
        return f"{scene.name}: {len(scene.wheels)} wheels, rule {scene.contact.rule}, at ({x}, {y})"


def check_scene(  # one keyword for each choice
    scene: Scene,
    *,
    prune: bool = True,
    best: bool = False,
    ask_others: bool = True,
    around: bool = False,
    beside: bool = True,
    announce: Announce = unheard,
    built: Partition | None = None,
) -> CheckResult:
    """Check an array; its evidence is verified before it is handed out.

    Args:
        scene: the array.
        prune: leave out what no verdict needs.
        best: check at the best rest point of the square instead of the scene's point.
        ask_others: let the answers say what the other contact rules say.
        around: look for headings of rest around the checked point too.
        beside: also search for other equilibria, count contact states and sample rates, on which no verdict rests.
        announce: told the name of each step as it begins.
        built: all cells of the square, where they are known already.

    Raises:
        RefusalError: where the motion is not determined.
        TipsError: where the body does not stand at the checked pose.
        SceneError: where a wheel lies exactly under its edge.
    """
    rest_points = None
    if best:
        from nonsmooth.proofs.answers.best_point import best_point  # paths: only a search loads them

        announce("the best rest point of the square")
        chosen = best_point(standing(scene))
        scene, rest_points = chosen.scene, chosen.found
    found = check_theorem4(scene, prune=prune, beside=beside, announce=announce, built=built)
    announce("verification of the evidence")
    return CheckResult(verified(found), ask_others, around, rest_points)


def compared(results: Sequence[CheckResult]) -> list[CheckResult]:
    """Checks of one array under several contact rules with all their answers, compared with each other."""
    for result in results:
        _ = result.answers
    asked = {str(result.evidence.scene.contact.rule): rests_under(result.evidence) for result in results}
    found = tuple(contradictions_of_rules(results[0].evidence.scene, asked))
    words = {word for one in found for word in one.between.split()}
    pairs = zip(asked, results, strict=True)
    renewed = [replace(result, elsewhere=found) if rule in words else result for rule, result in pairs]
    for result in renewed:
        _ = result.answers
    return renewed
