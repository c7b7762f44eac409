"""Whether a translation verdict and observed paths agree."""

from __future__ import annotations

from nonsmooth.proofs.clauses.translation.fan_stability import Move
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.findings.verdicts import Translation
from tests.oracles.box_paths import Observed
from tests.oracles.nearest_paths import End


def contradiction(result: TranslationResult, ends: set[End]) -> str:
    """What the paths say against the verdict; empty where they agree."""
    leaves = End.LEAVES in ends
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE and ends - {End.ARRIVES, End.UNCLEAR}:
        return f"asymptotically stable, but paths end {ends}"
    if result.verdict is Translation.STABLE and leaves:
        return "stable, but a path leaves"
    if result.verdict is Translation.UNSTABLE and not leaves:
        return "unstable, but no path leaves"
    return ""


def box_contradiction(result: TranslationResult, seen: Observed) -> str:
    """What paths of rule ``box`` say against the verdict; empty where they agree, or say nothing."""
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE and (seen.left or seen.rested):
        return f"asymptotically stable, but {seen}"
    if result.verdict is Translation.STABLE and seen.left:
        return f"stable, but {seen}"
    followed = result.fan is not None and any(e.move is not Move.SLIDE for e in result.fan.evidence)
    if result.verdict is Translation.UNSTABLE and followed and not seen.left:
        return f"unstable, but {seen}"
    return ""
