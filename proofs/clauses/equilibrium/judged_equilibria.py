"""The verdicts at every isolated equilibrium of the square, each about its own point.

The clauses are local: they look at the cells whose closure holds the point.  So each point is checked in a square of
its own, small enough to stay inside the checked one.  Segments and areas of equilibria are reported
without verdicts.
"""

from __future__ import annotations

from dataclasses import replace

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import CellRule, rule_of
from nonsmooth.analysis.cells.equilibria import RestPlace
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.clauses.clause import JudgedEquilibrium
from nonsmooth.proofs.clauses.rotation.clause import decide_rotation
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.findings.verdicts import Rotation, Translation
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Scene
from nonsmooth.symbolic.numbers.lazy import Lazy

MOST = 16  # points that are judged: each costs a partition of its own
SHARE = 8  # the square about a point is this many times smaller than the checked one


def judge_equilibria(scene: Scene, found: tuple[RestPlace, ...]) -> tuple[JudgedEquilibrium, ...]:
    """Verdicts for the equilibria of a scene whose coordinates are those of the points.

    Points whose coordinates are unevaluated quotients, and those beyond :data:`MOST`, are left unjudged.
    """
    judged, budget = [], MOST
    for equilibrium in found:
        point = equilibrium.points[0]
        if len(equilibrium.points) > 1 or not budget or any(isinstance(x, Lazy) for x in point):
            judged.append(JudgedEquilibrium(equilibrium))
            continue
        budget -= 1
        judged.append(_judged(scene, equilibrium))
    return tuple(judged)


def _judged(scene: Scene, equilibrium: RestPlace) -> JudgedEquilibrium:
    own = replace(scene, check=CheckedSquare(equilibrium.points[0], scene.check.radius / SHARE))
    rule = rule_of(own)
    if isinstance(rule, CellRule):  # wheels that have no say there only take time
        own = replace(own, wheels=rule.wheels_that_matter(own))
    own = own.recentred()
    before = own.field.rounded_signs
    try:
        partition = build_partition(own)
    except RefusalError:  # the small square leaves the support polygon
        return JudgedEquilibrium(equilibrium)
    translation = decide_translation(partition)
    rotation = decide_rotation(partition, translation)
    if own.field.rounded_signs > before:
        return JudgedEquilibrium(equilibrium, Translation.UNDECIDED, Rotation.UNDECIDED)
    return JudgedEquilibrium(equilibrium, translation.verdict, rotation.verdict)
