"""What results on the stability of plain systems have in common, in any number of states."""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.proofs.facts import Fact, text_fact
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.notebook import ShortRepr, html_table
from nonsmooth.symbolic.switched_system import SwitchedSystem

UNDECIDED_BY = "nothing"  # the method of results that nothing decided


class StabilityResult(ShortRepr):
    """A base of dataclasses: what ``check`` says of every plain system.

    Attributes:
        scene: the system.
        verdict: strong stability of the checked point.
        reason: one sentence for people.
        method: what decided.
    """

    scene: SwitchedSystem
    verdict: Translation
    reason: str
    method: str

    def _repr_html_(self) -> str:
        rows = [(self.verdict, self.method, self.reason)]
        return html_table(f"{self.scene.name}: strong stability", ("verdict", "by", "reason"), rows)

    @property
    def exit_status(self) -> int:
        """0 stable, 1 unstable or no equilibrium, 3 undecided."""
        return {Translation.UNSTABLE: 1, Translation.UNDECIDED: 3}.get(self.verdict, 0)


def stability_facts(result: StabilityResult, *, everywhere: bool = False) -> Iterator[Fact]:
    """The verdict, what decided, whether it is about all starts, and why."""
    yield text_fact("verdict", str(result.verdict), "stability")
    yield Fact("method", str(result.method))
    yield Fact("everywhere", everywhere)
    method = "" if result.method == UNDECIDED_BY else f" ({result.method})"
    yield Fact("reason", result.reason, f"{result.reason}{method}", row="because")
