"""Results of checks of plain systems that claim something else than was found."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nonsmooth.proofs.system_decision import StabilityResult


def with_reach(result: StabilityResult, **changes: Any) -> StabilityResult:
    """The result with another region, rate or gain."""
    return replace(result, reach=replace(result.reach, **changes))


def with_deciding(result: StabilityResult, **changes: Any) -> StabilityResult:
    """The result with another reason, verdict or proof of the finding that decides."""
    deciding = result.deciding
    changed = replace(deciding, **changes)
    return replace(result, findings=tuple(changed if own is deciding else own for own in result.findings))
