"""A translation verdict beside paths of the program's own simulator: they share the cells and nothing else.

Where ``V = |c|^2`` leaves the question open, the fan of cones decides stability from leading terms.  So a few paths are
followed from starts very close to the equilibrium.  Under a verdict of stability none may reach a fixed share of the
checked square: a fan whose distances diverge takes a start of 1e-12 there within few turns, one of the order
``eps^(1/2)`` per cone does not.  A path that does is a fault of the program, noticed before the verdict is shown.
"""

from __future__ import annotations

import math

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.number_text import place_text

STARTS = 4
CLOSE = 2.0**-40  # of the half side of the square: the distance of the starts
FAR = 1 / 16  # of the half side: nothing that starts so close may come there
CROSSINGS = 8.0  # of the square, at the least speed: as long as a path is followed

STABLE_VERDICTS = (Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE)


class ContradictionError(RuntimeError):
    """A verdict and a path of this program that contradict each other: a fault, on one line."""


def refuse_contradiction(partition: Partition, translation: TranslationResult) -> None:
    """Follow some paths from close to the equilibrium of a centred partition, where the fan alone says it is stable.

    Raises:
        ContradictionError: where one of them leaves.
    """
    decided_by_fan = translation.fan is not None and translation.region_radius is None
    if not decided_by_fan or translation.verdict not in STABLE_VERDICTS or not partition.complete:
        return
    _follow_some(partition, translation)


def _follow_some(partition: Partition, translation: TranslationResult) -> None:
    """Paths from close by; what follows them is loaded only here."""
    import numpy as np

    from nonsmooth.analysis.fields.constant_field import array_field
    from nonsmooth.analysis.fields.kinematics import Kinematics
    from nonsmooth.analysis.trajectories.result import TrajectoryError
    from nonsmooth.analysis.trajectories.trajectory import simulate

    radius = float(partition.scene.check.radius)
    speeds = [math.hypot(float(t.vx), float(t.vy)) for cell in partition.cells for t in cell.twists if any(t.velocity)]
    if not speeds:
        return
    until = CROSSINGS * radius / min(speeds)
    field = array_field(partition, Kinematics.EXACT)
    for k in range(STARTS):
        angle = 2 * math.pi * (k + 0.3) / STARTS
        start = (CLOSE * radius * math.cos(angle), CLOSE * radius * math.sin(angle), 0.0)
        try:
            path = simulate(field, start, until)
        except TrajectoryError:  # the simulator gives up: that says nothing about the verdict
            continue
        farthest = float(np.hypot(path.array[:, 0], path.array[:, 1]).max())
        if farthest > FAR * radius:
            raise ContradictionError(
                f"{partition.scene.name}: (x, y) is said to be {translation.verdict}, but the path from "
                f"{place_text(start[:2], 3)} beside the equilibrium goes {farthest:.3g} away: please report this"
            )
