"""The cells of an array under whichever contact rule its scene names."""

from __future__ import annotations

from nonsmooth.analysis.cells.contact_rule import CellRule, cell_rules, rule_of
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.analysis.cells.polygon import Polygon
from nonsmooth.symbolic.mechanics.scene import Scene


def build_partition(scene: Scene, *, prune: bool = True, domain: Polygon | None = None) -> Partition:
    """Cells of the scene's contact rule in the checked square, or another domain, in the scene's own coordinates.

    A check asks the partition of its workspace (:mod:`nonsmooth.proofs.clauses.workspace`), about the checked point.

    Args:
        scene: the array.
        prune: leave out wheels that cannot matter; without, the cells are the same.
        domain: a convex polygon, in place of the checked square.

    Raises:
        RefusalError: for a rule without cells, and where the motion is not determined.
    """
    rule = rule_of(scene)
    if not isinstance(rule, CellRule):
        names = " or ".join(f'"{other.name}"' for other in cell_rules())
        raise RefusalError(f'contact.rule: required {names} for cells, received "{rule.name}", which has none')
    return rule.build_partition(scene, prune=prune, domain=domain)
