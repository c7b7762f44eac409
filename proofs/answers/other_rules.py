"""What the other contact rules answer about position and heading, in a few words each.

A check is about one contact rule.  Which of them fits a machine is often not known, so the first clauses are decided
under the others too, where that is little work.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs import clause_registry
from nonsmooth.proofs.answers.answer import Answer, Results
from nonsmooth.proofs.answers.heading import heading_answer
from nonsmooth.proofs.answers.position import position_answer
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.under_way import part_of
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

FEW_UNITS = 150_000  # of exact arithmetic: a fifth of a second or so
FEW_WHEELS = 1_000  # beyond them loads and support polygons alone, which are not counted in units, take longer
TAKES_LONG = "not asked: it takes a while"
NEEDED = ("equilibrium", "translation", "rotation")  # the clauses that position and heading are answered from


@dataclass(frozen=True)
class OtherRule:
    """What one contact rule says, or why it says nothing.

    Attributes:
        name: of the rule.
        answers: position and heading; empty where there are none.
        why_not: why there are none.
        equilibrium: whether the point is an equilibrium; None where there is no answer.
    """

    name: str
    answers: tuple[Answer, ...]
    why_not: str = ""
    equilibrium: str | None = None


def other_rules(scene: Scene) -> tuple[OtherRule, ...]:
    """Position and heading under every contact rule but the scene's own."""
    names, found = [name for name in CONTACT_RULES if name != scene.contact.rule], []
    for k, name in enumerate(names):
        with part_of(k, len(names), "other rules"):
            found.append(_under(scene, name))
    return tuple(found)


def _under(scene: Scene, name: str) -> OtherRule:
    if len(scene.wheels) > FEW_WHEELS:
        return OtherRule(name, (), TAKES_LONG)
    other = scene.under(name)
    try:
        with work_limit(scene.field, FEW_UNITS):
            results = _decided(Workspace(other, sample=False))
    except RefusalError as error:
        return OtherRule(name, (), str(error))
    except WorkLimitError:
        return OtherRule(name, (), TAKES_LONG)
    answers = (position_answer(other, results), heading_answer(other, results))
    return OtherRule(name, answers, equilibrium=str(results["equilibrium"].verdict))


def _decided(work: Workspace) -> Results:
    for clause in clause_registry.CLAUSES:
        if clause.name in NEEDED:
            work.earlier[clause.name] = clause.decide(work)
    return work.earlier
