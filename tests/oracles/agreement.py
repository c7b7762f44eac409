"""Whether a translation verdict and observed paths agree."""

from __future__ import annotations

from nonsmooth.proofs.clauses.translation import TranslationResult
from nonsmooth.proofs.verdicts import Translation
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
