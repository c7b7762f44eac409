"""Results of checks that claim something else than was found, of plain systems and of arrays."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeVar

from nonsmooth.proofs.clauses.workspace import ClauseResult
from nonsmooth.proofs.system_decision import StabilityResult
from nonsmooth.proofs.theorem4 import Theorem4Result

AnyCheck = TypeVar("AnyCheck", bound=Theorem4Result)


def with_reach(result: StabilityResult, **changes: Any) -> StabilityResult:
    """The result with another region, rate or gain."""
    return replace(result, reach=replace(result.reach, **changes))


def with_deciding(result: StabilityResult, **changes: Any) -> StabilityResult:
    """The result with another reason, verdict or proof of the finding that decides."""
    deciding = result.deciding
    changed = replace(deciding, **changes)
    return replace(result, findings=tuple(changed if finding is deciding else finding for finding in result.findings))


def with_results(check: AnyCheck, **results: ClauseResult) -> AnyCheck:
    """The check with other results of some clauses, by name; the conclusion stays as it is."""
    return replace(check, results={**check.results, **results})
