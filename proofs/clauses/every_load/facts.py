"""What is said of loads that are unknown: which are meant, and the load for which a clause fails."""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.cells.load_sets import Loads
from nonsmooth.proofs.findings.verdicts import Fact, Quantity
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.unknown_loads import UnknownLoads


def load_facts(scene: Scene) -> Iterator[Fact]:
    """Which loads the verdicts speak of; nothing where they are known."""
    unknown = scene.contact.loads
    if isinstance(unknown, UnknownLoads):
        words = f"loads: {unknown.words}"
        if not rule_of(scene).needs_loads:
            words = f"rule {scene.contact.rule} asks for no loads: what it says holds for all of them"
        yield Fact("loads", unknown.words, words)


def witness_load(loads: Loads | None) -> Fact:
    """The load for which a clause fails, wheel by wheel, as shares of the weight."""
    return Fact("load", Quantity(loads))
