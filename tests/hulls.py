"""Convex hulls by linear programs of SciPy: nothing of the workbench takes part."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product

import numpy as np
from scipy.optimize import linprog

from nonsmooth.symbolic.mechanics.scene import Scene

FEASIBLE, INFEASIBLE = 0, 2  # statuses of HiGHS


def hull_holds_zero(vectors: Iterable[Sequence[object]]) -> bool:
    """Feasibility of ``sum w v = 0, sum w = 1, w >= 0``; the vectors are scaled to length about one."""
    columns = np.array([[float(x) for x in vector] for vector in vectors]).T  # type: ignore[arg-type]
    count = columns.shape[1]
    system = np.vstack([columns / (np.abs(columns).max() or 1.0), np.ones(count)])
    found = linprog(np.zeros(count), A_eq=system, b_eq=[*np.zeros(len(columns)), 1], method="highs")
    assert found.status in (FEASIBLE, INFEASIBLE), found.message
    return bool(found.status == FEASIBLE)


def stands(scene: Scene) -> bool:
    """Whether the wheels carry the body everywhere in the checked square: its corners lie in their hull."""
    (x, y), r = scene.check.equilibrium, scene.check.radius
    places = [wheel.position for wheel in scene.wheels]
    corners = [(x + a * r, y + b * r) for a, b in product((-1, 1), repeat=2)]
    return all(hull_holds_zero((p - a, q - b) for p, q in places) for a, b in corners)
