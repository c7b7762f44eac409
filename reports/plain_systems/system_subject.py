"""What the report of a plain system is about: the system, its verdict, and what several sections need."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from nonsmooth.analysis.cells.switched_cells import FieldCell, square_regions, system_cells
from nonsmooth.proofs.clauses.workspace import Announce, unheard
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.phase_portrait import PhasePortrait
from nonsmooth.reports.subject import Invocation
from nonsmooth.reports.system_results import SystemCheckResult
from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True, eq=False)
class SystemSubject:
    """A system, how it was asked for, and lazily what the sections share.

    Attributes:
        system: in two states.
        invocation: how the report was asked for.
        parts: names of the sections that are written.
        announce: hears the names of the sections.
    """

    system: SwitchedSystem
    invocation: Invocation
    parts: tuple[str, ...]
    announce: Announce = unheard

    @cached_property
    def result(self) -> StabilityResult:
        """The verdict, its evidence verified once more."""
        return verified(decide_system(self.system))

    @cached_property
    def cells(self) -> tuple[FieldCell, ...]:
        """The cells of the checked square, measured from the checked point."""
        return system_cells(self.system, square_regions(self.system.check.radius))

    @cached_property
    def portrait(self) -> PhasePortrait:
        """Cells, borders and picture.

        Raises:
            SceneError: under arbitrary switching.
        """
        return PhasePortrait(self.system)

    @property
    def records(self) -> dict[str, Record | None]:
        """The exact records of what is reported, for JSON."""
        portrait: dict[str, Any] | None = self.portrait.facts() if self.system.has_one_field else None
        return {"check": SystemCheckResult(self.result).facts(), "phase_portrait": portrait}
