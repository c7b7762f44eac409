"""A V of a system in three states and more, with the conditions that were looked at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.kernel.search import NotShownError, Search, stability_hypotheses
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.proofs.many_states.decay import ProvedDecay
from nonsmooth.proofs.many_states.examination import Examination, FailurePoint, examine
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.domain import Domain
from nonsmooth.proofs.systems.findings import ExaminedFunction, Reach, is_shown
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.switched_system import SwitchedSystem

PROVES = {Decrease.STRICT: Translation.ASYMPTOTICALLY_STABLE, Decrease.WEAK: Translation.STABLE}


@dataclass(frozen=True)
class ExaminedLyapunov(ExaminedFunction):
    """A V with its conditions.

    Attributes:
        formula: V, in the displacement under the states' names.
        radius: half the side of the cube on which they are looked at.
        examination: the conditions with their evidence.
    """

    formula: PiecewiseExpression
    radius: Number
    examination: Examination

    @property
    def domain(self) -> Domain:
        """Where they hold: at every distance where all of them are about forms."""
        return Domain(None if self.examination.is_homogeneous else self.radius)

    @property
    def decrease(self) -> Decrease:
        """What follows from them."""
        return self.examination.verdict

    @property
    def reason(self) -> str:
        """The same as a sentence."""
        return self.examination.reason

    @property
    def witness(self) -> FailurePoint | None:
        """Where one of them fails."""
        return self.examination.failure

    def check(self, system: SwitchedSystem) -> bool:
        """Whether the checker accepts what is said of V; a V that fails is looked at again."""
        verdict = PROVES.get(self.examination.verdict)
        if verdict is not None:
            return is_shown(system, self.known_entry(Reach()), verdict)
        undecided = self.examination.verdict is Decrease.UNDECIDED
        return undecided or examine(system, self.formula, self.radius) == self.examination

    def attraction(self, system: SwitchedSystem) -> dict[str, Any] | None:
        """LaSalle's principle with its evidence, for a V that does not rise; None where that is not found.

        Where V and the fields are forms on cones every solution is attracted.
        """
        if self.examination.verdict is not Decrease.WEAK:
            return None
        subject, search = read_subject(about(system)), Search()
        stated = self.known_entry(Reach())["hypotheses"]
        second = find_second(subject, stated["cells"], stated["function"], search)
        if second is None:
            return None
        hypotheses = {**stated, "second": second, "verdict": str(Translation.ASYMPTOTICALLY_STABLE)}
        for everywhere in (True, False):
            try:
                return search.entry(subject, "lyapunov", {**hypotheses, "everywhere": everywhere})[0]
            except NotShownError:
                continue
        return None

    def known_entry(self, reach: Reach) -> dict[str, Any]:
        """The theorem with its evidence, as a certificate holds it: what V shows, where from, and how fast."""
        region, rate = reach.region, cast("ProvedDecay | None", reach.rate)
        stated, falls = self.examination.stated, self.examination.verdict is Decrease.STRICT
        verdict = str(PROVES[self.examination.verdict])
        hypotheses = stability_hypotheses(stated.record, self.formula.text, verdict) | {
            "everywhere": falls and self.examination.is_homogeneous,
            "level": None if region is None else str(region.level),
            "rate": None if rate is None else rate.record,
        }
        proofs = {**stated.proofs, **self.examination.proofs}
        for more in (region, rate):
            proofs |= {} if more is None else more.proofs
        return {"theorem": "lyapunov", "hypotheses": hypotheses, "proofs": proofs}
