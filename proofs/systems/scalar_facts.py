"""What the verdict on a system in one state says: one list of facts for terminal and JSON."""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.proofs.facts import Fact, Quantity, row_fact, text_fact
from nonsmooth.proofs.systems.scalar_stability import ScalarResult
from nonsmooth.proofs.systems.stability_result import stability_facts
from nonsmooth.proofs.systems.system_facts import rewriting_words
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.number_text import brief_text


def scalar_facts(result: ScalarResult) -> Iterator[Fact]:
    """Stability in one state."""
    holds = text_fact("verdict", str(result.equilibrium), "equilibrium")
    yield Fact("equilibrium", (holds, Fact("at", Quantity(result.scene.check.equilibrium))))
    if result.scene.written or result.scene.others:
        yield row_fact("field", rewriting_words(result.scene))
    yield Fact("lyapunov")
    yield Fact("translation", tuple(stability_facts(result)))
    yield from _region(result)


def _region(result: ScalarResult) -> Iterator[Fact]:
    """The interval of starts that are certified to reach the point."""
    right, left = result.right.reach, result.left.reach
    if result.verdict is not Translation.ASYMPTOTICALLY_STABLE or right is None or left is None:
        yield Fact("region")
        return
    (state,), (at,) = result.scene.states, result.scene.check.equilibrium
    words = f"every start with {brief_text(at - left)} < {state} < {brief_text(at + right)} reaches the equilibrium"
    record = {"from": Quantity(at - left), "to": Quantity(at + right), "text": words}
    yield Fact("region", record, words, row="region")
