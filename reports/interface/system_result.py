"""The stability of a plain system as a script or a notebook holds it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.system_facts import system_facts
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.facts import fact_rows
from nonsmooth.reports.result import Tabular
from nonsmooth.reports.short_text import short_lines
from nonsmooth.reports.system_views import system_record
from nonsmooth.symbolic.notebook import html_table

if TYPE_CHECKING:
    from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True, repr=False)
class SystemCheckResult(Tabular):
    """What a check of a plain system found.

    Attributes:
        evidence: everything that was proved; ``evidence.check()`` verifies it again.
    """

    evidence: StabilityResult

    @property
    def verdict(self) -> str:
        """Asymptotically stable, stable, unstable or undecided."""
        return str(self.evidence.verdict)

    @property
    def reason(self) -> str:
        """Why, in one sentence."""
        return self.evidence.reason

    @property
    def lyapunov(self) -> str | None:
        """The function that shows stability, as text; None where none does."""
        functions = (own.function for own in reversed(self.evidence.findings))
        return next((own.text for own in functions if own is not None and not own.grows), None)

    def to_dict(self) -> dict[str, Any]:
        """The JSON record of ``nonsmooth check --json``."""
        return system_record(self.evidence)

    def rows(self) -> list[dict[str, str]]:
        """One row for each thing that is said."""
        return [{"what": name, "found": text} for name, text in fact_rows(system_facts(self.evidence))]

    def __repr__(self) -> str:
        head = f"{self.evidence.scene.name}: {self.verdict}"
        return short_lines(head, [(row["what"], row["found"]) for row in self.rows()])

    def _repr_html_(self) -> str:
        rows = [(row["what"], row["found"]) for row in self.rows()]
        return html_table(f"{self.evidence.scene.name}: {self.verdict}", ("what", "found"), rows)


def check_system(system: SwitchedSystem) -> SystemCheckResult:
    """Check a plain system; its evidence is verified before it is handed out."""
    return SystemCheckResult(verified(decide_system(system)))
